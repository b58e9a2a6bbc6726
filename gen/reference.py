"""A second opinion on the whole chain, for test vectors: dense matrices, LAPACK's eigenvectors at the very weight of
the case (no fit), textbook RK4 in double, libm's tanh and sine. Written from equations (T) (W) (B) (F) (A) (S); shares
nothing with the rest of gen/ but the well file's reader.

    python3 gen/reference.py WELL.toml [--case fc=..,mu=..,...]... [--step S] [--out-step S] [--duration S] [--out FILE]

A case names what differs from the well file: fc, mu, a1, a2, w0, f0 in SI, rotating (0 or 1), torsional, axial;
and J [kg m2], Z [N m s/rad], f [Hz] of a soft drive at the top, where there is one: J > 0.
"""
import argparse
import os
import sys

import numpy as np

import well as well_

COLUMNS = ("time", "bit_speed", "bit_torque", "f_bit", "bit_axial_speed", "surface_torque")
CASE = ("fc", "mu", "a1", "a2", "w0", "f0", "rotating", "torsional", "axial")
STIFF = {"J": 0.0, "Z": 0.0, "f": 0.0}      # the drive of a case that names none


# ---- finite elements and modes at one weight

def assemble(values, pattern):
    """Sum of element matrices values[e] * pattern over neighbouring nodes."""
    matrix = np.zeros((len(values) + 1, len(values) + 1))
    for e, value in enumerate(values):
        matrix[e:e + 2, e:e + 2] += value * np.array(pattern)
    return matrix


def matrices(well, fc):
    """Axial and torsional (K + Kg, M) at weight fc [N]; fc None: without prestress."""
    length = np.concatenate([np.full(s.elements, s.length / s.elements) for s in well.sections])
    outer = np.concatenate([np.full(s.elements, s.outer) for s in well.sections])
    inner = np.concatenate([np.full(s.elements, s.inner) for s in well.sections])
    area, polar = np.pi / 4 * (outer**2 - inner**2), np.pi / 32 * (outer**4 - inner**4)
    spring, mass = [[1, -1], [-1, 1]], [[1 / 3, 1 / 6], [1 / 6, 1 / 3]]
    u = np.zeros(len(length))
    if fc is not None:
        force = np.zeros(len(length) + 1)
        np.add.at(force, np.arange(len(length)), well.density * well.gravity * area * length / 2)
        np.add.at(force, np.arange(1, len(length) + 1), well.density * well.gravity * area * length / 2)
        force[-1] -= fc
        stiffness = assemble(well.youngs * area / length, spring)
        u = np.diff(np.concatenate([[0.0], np.linalg.solve(stiffness[1:, 1:], force[1:])])) / length
    axial = well.youngs * area * (1 + 3 * u + 1.5 * u**2) / length
    torsion = polar * (well.shear + well.youngs * (u + 0.5 * u**2)) / length
    return ((assemble(axial, spring), assemble(well.density * area * length, mass)),
            (assemble(torsion, spring), assemble(well.density * polar * length, mass)))


def eigen(stiffness, mass, shift=0.0):
    """All (w2, phi) of K phi = w2 M phi, phi' M phi = 1, phi > 0 at the bit. By the Cholesky factor of K + shift M, in
    which the low modes are the large eigenvalues and keep their digits."""
    factor = np.linalg.cholesky(stiffness + shift * mass)
    half = np.linalg.solve(factor, mass)
    value, vector = np.linalg.eigh(np.linalg.solve(factor, half.T))
    value, vector = value[::-1], np.linalg.solve(factor.T, vector[:, ::-1])
    phi = vector / np.sqrt(np.sum(vector * (mass @ vector), axis=0))
    return 1.0 / value - shift, phi * np.where(phi[-1] < 0, -1.0, 1.0)


def modes(well, fc):
    """Every mode at weight fc: dict of w2, b, d, axial_w2, axial_b, shapes at the nodes, inertia, mass."""
    (ka, ma), (kt, mt) = matrices(well, fc)
    w2, phi = eigen(kt[1:, 1:], mt[1:, 1:])
    # a shift of about the square of the first elastic frequency makes the free chain definite
    wave2 = well.youngs / well.density / sum(s.length for s in well.sections)**2
    axial_w2, axial_phi = eigen(ka, ma, 10.0 * wave2)
    axial_w2[0] = 0.0
    return {"w2": w2, "b": phi[-1], "d": phi.T @ mt[1:] @ np.ones(len(mt)),
            "twist": np.vstack([np.zeros(len(w2)), phi]), "axial": axial_phi,
            "axial_w2": axial_w2, "axial_b": axial_phi[-1], "inertia": mt.sum(), "mass": ma.sum()}


# ---- equations of motion, several cases side by side

class System:
    """Torsional modes, then axial ones, as rows [case, mode] of one second-order system."""

    def __init__(self, well, cases):
        cases = [{**nominal(well), **case} for case in cases]
        for name in ("fc", "mu", "a1", "a2", "w0", "f0"):
            setattr(self, name, np.array([float(case[name]) for case in cases]))
        self.alpha = well.alpha
        torsional, axial = cases[0]["torsional"], cases[0]["axial"]
        rows = [modes(well, case["fc"]) for case in cases]
        zero_t, zero_a = np.zeros((len(cases), torsional)), np.zeros((len(cases), axial))
        pick = lambda name, count: np.array([row[name][:count] for row in rows])
        self.w2 = np.hstack([pick("w2", torsional), pick("axial_w2", axial)])
        self.b = np.hstack([pick("b", torsional), zero_a])
        self.d = np.hstack([pick("d", torsional), zero_a])
        self.b_axial = np.hstack([zero_t, pick("axial_b", axial)])
        self.c = well.alpha + well.beta * self.w2
        self.c[:, torsional] = 0.0                                  # the rigid mode is not damped
        self.drag = self.d * (self.alpha * self.w0)[:, None]
        self.inertia = rows[0]["inertia"]
        rotating = np.array([bool(case["rotating"]) for case in cases])
        self.v0 = np.where(rotating[:, None], 0.0, -self.d * self.w0[:, None])

    def weight(self, t):
        """(F): f_bit, f_a."""
        f_a = self.f0 * (np.sin(self.w0 * t) + 0.01)
        return f_a - self.fc, f_a

    def speed(self, v):
        """(W)."""
        return self.w0 + (self.b * v).sum(axis=1)

    def torque(self, w, f_bit):
        """(B)."""
        return self.mu * np.minimum(f_bit, 0.0) * (np.tanh(w) + self.a1 * w / (1.0 + self.a2 * w * w))

    def acceleration(self, q, v, weight):
        """(T), (A)."""
        f_bit, f_a = weight
        torque = self.torque(self.speed(v), f_bit)
        return self.b * torque[:, None] + self.b_axial * f_a[:, None] - self.drag - self.c * v - self.w2 * q

    def outputs(self, t, q, v):
        """One row of COLUMNS [column, case]."""
        weight = self.weight(t)
        w = self.speed(v)
        torque = self.torque(w, weight[0])
        a = self.acceleration(q, v, weight)
        surface = self.alpha * self.inertia * self.w0 + (self.d * (a + self.alpha * v)).sum(axis=1) - torque      # (S)
        return np.array([np.full_like(w, t), w, torque, weight[0], (self.b_axial * v).sum(axis=1), surface])


class Yielding(System):
    """The same under soft drives, stiff tops among them. The last column is the top: its angle and its speed, from w0 on. What the
    drive integrates is w0 - theta_top', so that its integral needs no column: it is w0 t - theta_top."""

    def __init__(self, well, cases):
        super().__init__(well, cases)
        cases = [{**STIFF, **case} for case in cases]
        self.rotor, impedance, hz = (np.array([float(case[name]) for case in cases]) for name in STIFF)
        self.k_speed, self.k_angle = 4.0 * impedance, (2.0 * np.pi * hz)**2 * self.rotor
        none = np.zeros((len(cases), 1))
        self.w2, self.c, self.d, self.b_axial = (np.hstack([x, none]) for x in (self.w2, self.c, self.d, self.b_axial))
        self.b, self.v0 = np.hstack([self.b, none + 1.0]), np.hstack([self.v0, self.w0[:, None]])
        self.moved = self.rotor + self.inertia - (self.d * self.d).sum(axis=1)

    def weight(self, t):
        """(F) needs the angle of the top: acceleration() takes it from the state, and from here the time."""
        return t

    def speed(self, v):
        """(W)."""
        return (self.b * v).sum(axis=1)

    def forces(self, q, v):
        """f_bit, f_a, torque on the bit."""
        f_a = self.f0 * (np.sin(q[:, -1]) + 0.01)
        return f_a - self.fc, f_a, self.torque(self.speed(v), f_a - self.fc)

    def acceleration(self, q, v, t):
        """(T) without theta_top'', (S) with it put in, the drive; then (T), (A)."""
        theta, rate = q[:, -1], v[:, -1]
        _, f_a, torque = self.forces(q, v)
        free = self.b * torque[:, None] + self.b_axial * f_a[:, None] - self.d * (self.alpha * rate)[:, None] - self.c * v - self.w2 * q
        push = self.k_speed * (self.w0 - rate) + self.k_angle * (self.w0 * t - theta)
        rest = self.alpha * self.inertia * rate + (self.d * (free + self.alpha * v)).sum(axis=1) - torque
        slope = np.where(self.rotor > 0.0, (push - rest) / self.moved, 0.0)
        a = free - self.d * slope[:, None]
        a[:, -1] = slope
        return a

    def outputs(self, t, q, v):
        """One row of COLUMNS [column, case]."""
        f_bit, _, torque = self.forces(q, v)
        a = self.acceleration(q, v, t)
        surface = self.inertia * (a[:, -1] + self.alpha * v[:, -1]) + (self.d * (a + self.alpha * v)).sum(axis=1) - torque     # (S)
        return np.array([np.full_like(torque, t), self.speed(v), torque, f_bit, (self.b_axial * v).sum(axis=1), surface])


def nominal(well):
    return {name: getattr(well, name) for name in CASE}


def system_of(well, cases):
    return (Yielding if any(case.get("J", 0.0) > 0.0 for case in cases) else System)(well, cases)


def simulate_many(well, cases, step, out_step, duration):
    """Cases (dicts of overrides, equal mode counts) -> {column: [case, time]}."""
    system = system_of(well, cases)
    data = np.array(march(system, system.outputs, step, out_step, duration))
    return {name: data[:, i, :].T for i, name in enumerate(COLUMNS)}


def march(system, look, step, out_step, duration):
    """Textbook RK4 from t = 0; the list of look(t, q, v) at every out_step."""
    q, v, h = np.zeros_like(system.v0), system.v0.copy(), step
    every, steps = round(out_step / step), round(duration / step)
    rows = [look(0.0, q, v)]
    after = system.weight(0.0)
    for n in range(steps):
        before, middle, after = after, system.weight((n + 0.5) * h), system.weight((n + 1) * h)
        a1 = system.acceleration(q, v, before)
        v2 = v + h / 2 * a1
        a2 = system.acceleration(q + h / 2 * v, v2, middle)
        v3 = v + h / 2 * a2
        a3 = system.acceleration(q + h / 2 * v2, v3, middle)
        v4 = v + h * a3
        a4 = system.acceleration(q + h * v3, v4, after)
        q = q + h / 6 * (v + 2 * (v2 + v3) + v4)
        v = v + h / 6 * (a1 + 2 * (a2 + a3) + a4)
        if (n + 1) % every == 0:
            rows.append(look((n + 1) * h, q, v))
    return rows


def field(well, case, step, out_step, duration):
    """Displacement from the prestressed string [m] and twist against the top [rad] at the nodes -> two [time, node]. A stiff top."""
    system, full = System(well, [case]), {**nominal(well), **case}
    at = modes(well, full["fc"])
    count = full["torsional"], full["axial"]
    q = np.array(march(system, lambda t, q, v: q[0], step, out_step, duration))
    return q[:, count[0]:] @ at["axial"][:, :count[1]].T, q[:, :count[0]] @ at["twist"][:, :count[0]].T


def simulate(well, case, step, out_step, duration=None):
    """One case -> {column: [time]}."""
    duration = well.ticks * well.step_ns * 1e-9 if duration is None else duration
    return {name: data[0] for name, data in simulate_many(well, [case], step, out_step, duration).items()}


# ---- test vectors

def _case(text):
    case = {}
    for part in text.split(","):
        key, _, value = part.partition("=")
        if key not in (*CASE, *STIFF):
            raise argparse.ArgumentTypeError(f"{key}: expected one of {', '.join((*CASE, *STIFF))}")
        case[key] = int(value) if key in ("rotating", "torsional", "axial") else float(value)
    return case


def main(argv):
    parser = argparse.ArgumentParser(description="Test vectors from the reference integrator.")
    parser.add_argument("well")
    parser.add_argument("--case", type=_case, action="append")
    parser.add_argument("--step", type=float, default=0.0005)
    parser.add_argument("--out-step", type=float, default=5.0)
    parser.add_argument("--duration", type=float, default=50.0)
    parser.add_argument("--out")
    options = parser.parse_args(argv)
    with open(options.well, encoding="utf-8") as file:
        well = well_.parse(file.read())
    lines = [f"# gen/reference.py {os.path.basename(options.well)}, RK4 in double at step {options.step!r} s",
             "# case " + " ".join((*CASE, *STIFF)) + "    (SI; w0 in rad/s)", "# row " + " ".join(COLUMNS) + "    (SI)"]
    for case in options.case or [{}]:
        data = simulate(well, case, options.step, options.out_step, options.duration)
        full = {**nominal(well), **STIFF, **case}
        lines.append("case " + " ".join(f"{float(value):.17g}" for value in full.values()))
        lines += ["row " + " ".join(f"{data[name][i]:.17g}" for name in COLUMNS) for i in range(len(data["time"]))]
    text = "\n".join(lines) + "\n"
    if options.out:
        with open(options.out, "w", encoding="ascii", newline="\n") as file:
            file.write(text)
    else:
        sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    sys.exit(main(sys.argv[1:]))
