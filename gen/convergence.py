"""How many elements and how many modes are enough for a string: `python3 gen WELL.toml --convergence`.

The nominal case and 48 random realisations, the same in every row, with a quarter to twice the elements of the well file
(against eight times as many), and with 1 to 20 torsional modes. Textbook RK4 in double (reference.py).

The trajectory is compared over its first cycles only: later on the instants of sticking differ a little from row to row, and
two curves of one kind pass each other. What has to agree is what is counted: severity and stick-slip.
"""
import dataclasses
import math

import numpy as np

import bars as bars_
import modes as modes_
import reference

MODES = (1, 2, 3, 5, 7, 10, 14, 20)
DRAWS = 48
SEED = 1
FACTORS = (0.25, 0.5, 1.0, 2.0)
FINE = 8              # times the elements: what the others are compared with
CYCLES = 4            # periods of the first mode over which trajectories are compared
OUT_STEP = 0.05       # [s]


class Runs(reference.System):
    """Cases over and over, each time with other modes. `rows`: (w2, b, d) [case, mode] and how many of them are used."""

    def __init__(self, well, rows, cases):
        for name in ("fc", "mu", "a1", "a2", "w0", "f0"):
            setattr(self, name, np.array([case[name] for _ in rows for case in cases]))
        most = max(count for _, count in rows)
        columns = [[], [], []]
        for arrays, count in rows:      # a mode without b and d is at rest for ever
            for column, array, keep in zip(columns, arrays, (most, count, count)):
                column.append(np.where(np.arange(most) < keep, array[:, :most], 0.0))
        self.w2, self.b, self.d = (np.vstack(column) for column in columns)
        self.b_axial = np.zeros_like(self.b)                                # the axial motion does not act on the torsion
        self.alpha = well.alpha
        self.c = well.alpha + well.beta * self.w2
        self.drag = self.d * (self.alpha * self.w0)[:, None]
        self.v0 = np.zeros_like(self.d) if well.rotating else -self.d * self.w0[:, None]

    def rates(self, beta):
        """Fastest rate of each row [1/s]: what limits the step."""
        sum_ = (self.b * self.b).sum(axis=1)
        return self.mu * (self.fc + self.f0) * (1.0 + self.a1) * sum_ + beta * np.max(self.w2 * (self.b > 0.0), axis=1)


def _torsion(chain, cases, count):
    fc = np.array([case["fc"] for case in cases])
    found = modes_.torsion(chain, fc, count)
    return found.w2, found.b, modes_.uniform_response(chain, fc, found)


def _chain(well, factor):
    sections = tuple(dataclasses.replace(s, elements=max(1, round(s.elements * factor))) for s in well.sections)
    return bars_.build(dataclasses.replace(well, sections=sections))


def _cases(well):
    """The nominal case, then draws from the gamma laws of the well file."""
    rng = np.random.default_rng(SEED)
    cases = [{name: getattr(well, name) for name in ("fc", "mu", "a1", "a2", "w0", "f0")} for _ in range(1 + DRAWS)]
    for name, cov in zip(("fc", "mu", "a1", "a2", "w0"), well.cov):
        relative = rng.gamma(1.0 / cov**2, cov**2, DRAWS) if cov else np.ones(DRAWS)
        for case, factor in zip(cases[1:], relative.tolist()):
            case[name] *= factor
    return cases


def _rpm(value):
    return value * 30.0 / math.pi


def _speeds(well, runs, rows):
    """Bit speed [row, case, time] in rpm, with a step that every realisation can take."""
    step_s, duration = well.step_ns * 1e-9, well.ticks * well.step_ns * 1e-9
    step = OUT_STEP / math.ceil(OUT_STEP / min(step_s, 2.5 / np.max(runs.rates(well.beta))))
    speed = reference.march(runs, lambda t, q, v: runs.speed(v), step, OUT_STEP, duration)
    return _rpm(np.array(speed).T.reshape(len(rows), -1, len(speed)))


def _behaviour(well, speed, first_hz):
    """One text a row: against the last one, how the nominal bit speed begins and ends, and what is counted."""
    t = OUT_STEP * np.arange(speed.shape[2])
    inside = (t >= well.window_first * well.step_ns * 1e-9) & (t <= well.window_last * well.step_ns * 1e-9)
    low, high = speed[:, :, inside].min(axis=2), speed[:, :, inside].max(axis=2)
    ss = np.where(high + low > 0.0, (high - low) / np.where(high + low > 0.0, high + low, 1.0), 10.0)
    stuck = ss > well.limit
    early = t <= CYCLES / first_hz
    rms = np.sqrt(np.mean((speed[:, 0, early] - speed[-1, 0, early])**2, axis=1))
    return [f"{rms[i]:7.2f} rpm  {high[i, 0]:7.2f} rpm  {ss[i, 0]:6.4f}   {np.sum(stuck[i, 1:]):2d} of {DRAWS}, "
            f"{np.sum(stuck[i, 1:] != stuck[-1, 1:]):2d} differ" for i in range(len(speed))]


HEADING = "rms, start  highest      ss       stick-slip"


def elements(well, cases):
    """Lines of the table over the number of elements."""
    factors = [f for f in FACTORS if len(_chain(well, f).length) >= max(well.torsional, well.axial)] + [FINE]
    chains = [_chain(well, f) for f in factors]
    rows = [(_torsion(chain, cases, well.torsional), well.torsional) for chain in chains]
    axial = [np.sqrt(modes_.axial(c, np.array([well.fc]), max(2, well.axial)).w2[0, 1:]) for c in chains]
    hertz = [np.sqrt(arrays[0][0]) / 2.0 / math.pi for arrays, _ in rows]
    behaviour = _behaviour(well, _speeds(well, Runs(well, rows, cases), rows), hertz[-1][0])
    lines = [f"elements   f_1 [Hz]  error of f_1   of f_{well.torsional:<2d}  of axial   {HEADING}"]
    for i, factor in enumerate(factors):
        error = hertz[i] / hertz[-1] - 1.0
        note = "   as in the well file" if factor == 1.0 else "   taken as exact" if factor == FINE else ""
        lines.append(f"{len(chains[i].length):8d}   {hertz[i][0]:.6f}  {error[0]:12.1e}  {error[-1]:8.1e}  "
                     f"{np.max(np.abs(axial[i] / axial[-1] - 1.0)):8.1e}   {behaviour[i]}{note}")
    return lines


def torsional_modes(well, cases):
    """Lines of the table over the number of torsional modes."""
    chain, counts = _chain(well, 1.0), sorted({min(n, well.elements) for n in (*MODES, well.torsional)})
    arrays = _torsion(chain, cases, counts[-1])
    rows = [(arrays, n) for n in counts]
    runs = Runs(well, rows, cases)
    hertz = np.sqrt(arrays[0][0]) / 2.0 / math.pi
    behaviour = _behaviour(well, _speeds(well, runs, rows), hertz[0])
    step = 2.785 / runs.rates(well.beta).reshape(len(counts), -1)[:, 0]
    lines = [f"   modes   f_n [Hz]  sum b^2 [1/kg m2]  left of J [%]  largest step [ms]   {HEADING}"]
    for i, n in enumerate(counts):
        left = 100.0 * (1.0 - np.sum(arrays[2][0, :n]**2) / chain.inertia)
        note = "   as in the well file" if n == well.torsional else ""
        lines.append(f"{n:8d}   {hertz[n - 1]:8.4f}  {np.sum(arrays[1][0, :n]**2):17.6f}  {left:13.2f}  {1000.0 * step[i]:17.2f}   "
                     f"{behaviour[i]}{note}")
    return lines


def report(well):
    cases = _cases(well)
    print(f"{well.name}: nominal weight {well.fc / 1000.0:g} kN, mu {well.mu:g}, {_rpm(well.w0):.6g} rpm, "
          f"{well.ticks * well.step_ns * 1e-9:g} s, {'rotating' if well.rotating else 'from rest'}", flush=True)
    print("\n".join(["", f"Elements, with {well.torsional} torsional modes", *elements(well, cases)]), flush=True)
    print("\n".join(["", f"Torsional modes, with {well.elements} elements", *torsional_modes(well, cases)]), flush=True)
    print(f"""
Bit speed: rms difference from the last row over the first {CYCLES} periods of mode 1 (start); highest and severity over the window;
nominal case. Stick-slip: realisations of {DRAWS} with ss > {well.limit:g}, and how many of them are classified otherwise than in the last row.
Left of J: inertia of the string that the modes do not carry. Largest step: RK4's, for the nominal case.""")
