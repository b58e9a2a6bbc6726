"""second_opinion.py - the paper's string once more for the checks of the command line: scipy's eigenvalues at the very
weight of the case, an adaptive integration of order 8 to 1e-11, closed forms where there are any. Reads nothing of kelly.
"""
import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

RPM = np.pi / 30.0
E, G, RHO, GRAVITY = 210e9, 210e9 / 3.01, 7850.0, 9.81
ALPHA, BETA = 0.1, 8e-5
SECTIONS = ((1400.0, 0.120, 0.095, 80), (200.0, 0.150, 0.095, 40))     # length, outside, inside [m], elements
NOMINAL = {"rpm": 100.0, "wob": 100.0, "mu": 0.04, "alpha1": 2.0, "alpha2": 1.0, "f0": 50.0, "start": "rest"}


def chain(values, pattern):
    matrix = np.zeros((len(values) + 1,) * 2)
    for e, value in enumerate(values):
        matrix[e:e + 2, e:e + 2] += value * np.array(pattern)
    return matrix


def modes(fc, torsional=10, axial=2):
    """At weight fc [N]: w2, phi [node, mode], d of torsion; w2, phi of axial motion; J."""
    length = np.concatenate([np.full(n, total / n) for total, _, _, n in SECTIONS])
    area = np.concatenate([np.full(n, np.pi / 4 * (o**2 - i**2)) for _, o, i, n in SECTIONS])
    polar = np.concatenate([np.full(n, np.pi / 32 * (o**4 - i**4)) for _, o, i, n in SECTIONS])
    # tension at the middle of an element: what hangs below it, less the weight on bit; consistent loads give just this
    hanging = np.cumsum((RHO * GRAVITY * area * length)[::-1])[::-1] - RHO * GRAVITY * area * length / 2
    u = (hanging - fc) / (E * area)
    spring, mass = [[1, -1], [-1, 1]], [[1 / 3, 1 / 6], [1 / 6, 1 / 3]]
    k_t = chain(polar * (G + E * (u + 0.5 * u**2)) / length, spring)
    k_a = chain(E * area * (1 + 3 * u + 1.5 * u**2) / length, spring)
    m_t, m_a = chain(RHO * polar * length, mass), chain(RHO * area * length, mass)
    w2, phi = eigh(k_t[1:, 1:], m_t[1:, 1:], subset_by_index=[0, torsional - 1])
    w2_a, phi_a = eigh(k_a, m_a, subset_by_index=[0, axial - 1])
    phi, phi_a = phi * np.sign(phi[-1]), phi_a * np.sign(phi_a[-1])
    w2_a[0] = 0.0
    return {"w2": w2, "phi": np.vstack([np.zeros(torsional), phi]), "d": phi.T @ m_t[1:].sum(axis=1),
            "w2_a": w2_a, "phi_a": phi_a, "J": m_t.sum()}


class String:
    """One case: NOMINAL with overrides."""

    def __init__(self, **case):
        self.case = case = {**NOMINAL, **case}
        self.m = modes(case["wob"] * 1e3)
        self.w0, self.b = case["rpm"] * RPM, self.m["phi"][-1]

    def weight(self, t):
        return self.case["f0"] * 1e3 * (np.sin(self.w0 * t) + 0.01)

    def torque(self, t, w):
        f = min(self.weight(t) - self.case["wob"] * 1e3, 0.0)
        return self.case["mu"] * f * (np.tanh(w) + self.case["alpha1"] * w / (1.0 + self.case["alpha2"] * w * w))

    def slope(self, t, x):
        q, v = np.split(x, 2)
        m = self.m
        torque = self.torque(t, self.w0 + self.b @ v)
        return np.concatenate([v, self.b * torque - m["d"] * ALPHA * self.w0 - (ALPHA + BETA * m["w2"]) * v - m["w2"] * q])

    def torsion(self, times):
        """States [q, q'] at the times."""
        v0 = 0.0 if self.case["start"] == "rotating" else -self.m["d"] * self.w0
        x0 = np.concatenate([np.zeros(len(self.b)), v0 + np.zeros(len(self.b))])
        return solve_ivp(self.slope, (0.0, max(times)), x0, "DOP853", times, rtol=1e-11, atol=1e-12).y

    def bit_speed(self, states):
        return self.w0 + self.b @ np.split(states, 2)[1]

    def surface_torque(self, times, states):
        """(S)."""
        out = []
        for t, x in zip(times, states.T):
            v, a = np.split(self.slope(t, x), 2)
            out.append(ALPHA * self.m["J"] * self.w0 + self.m["d"] @ (a + ALPHA * v) - self.torque(t, self.w0 + self.b @ v))
        return np.array(out)

    def axial(self, t):
        """p_j and p_j' at times t, in closed form: linear, driven by a constant and a sine."""
        t, w0 = np.asarray(t, dtype=float), self.w0
        f = self.case["f0"] * 1e3 * self.m["phi_a"][-1]
        p = [f[0] * (t / w0 - np.sin(w0 * t) / w0**2 + 0.005 * t**2)]
        v = [f[0] * ((1.0 - np.cos(w0 * t)) / w0 + 0.01 * t)]
        for force, w2 in zip(f[1:], self.m["w2_a"][1:]):
            c = ALPHA + BETA * w2
            steady = lambda s: force * (np.imag(np.exp(1j * w0 * s) / (w2 - w0**2 + 1j * c * w0)) + 0.01 / w2)
            steady_v = lambda s: force * np.imag(1j * w0 * np.exp(1j * w0 * s) / (w2 - w0**2 + 1j * c * w0))
            root = -c / 2 + 1j * np.sqrt(w2 - c * c / 4)
            # free part Re(A e^(root t)), p = p' = 0 at the start
            real = -steady(0.0)
            free = real + 1j * (root.real * real + steady_v(0.0)) / root.imag
            p.append(steady(t) + np.real(free * np.exp(root * t)))
            v.append(steady_v(t) + np.real(free * root * np.exp(root * t)))
        return np.array(p), np.array(v)

    def axial_speed(self, t):
        return self.m["phi_a"][-1] @ self.axial(t)[1]

    def response(self, duration, step):
        """int |U|^2 dt by the trapezoid at `step`."""
        times = step * np.arange(round(duration / step) + 1)
        q, p = np.split(self.torsion(times), 2)[0], self.axial(times)[0]
        square = np.sum((self.m["phi"] @ q)**2, axis=0) + np.sum((self.m["phi_a"] @ p)**2, axis=0)
        return step * (square.sum() - 0.5 * (square[0] + square[-1]))


def crc32c(data):
    crc = 0xffffffff
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82f63b78 if crc & 1 else 0)
    return crc ^ 0xffffffff
