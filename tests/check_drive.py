#!/usr/bin/env python3
"""check_drive - tops of variable speed against another implementation, at the command line, and bit for bit.

usage: tests/check_drive.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...]

Needs drive-numbers of build/host and build/host-double (make all unit, REAL=float and double). The other implementation is the equations of
motion as model.md has them, mode shapes from scipy's eigenvalues, integrated by DOP853 to 1e-10. Last line `N passed, N failed`.
"""
import concurrent.futures
import csv
import glob
import io
import json
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
from scipy.integrate import solve_ivp

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from check_digests import engines  # noqa: E402
from programs import PROGRAM, ROOT, chosen, command_line  # noqa: E402
from second_opinion import ALPHA, BETA, RPM, modes  # noqa: E402

sys.path.insert(0, os.path.join(ROOT, "gen"))
import reference  # noqa: E402
import well as well_  # noqa: E402

HOST = {"float": "build/host", "double": "build/host-double"}
SOFT = {"J": 2900.0, "Z": 289.0, "f": 0.2}
COLUMNS = ("bit speed", "top speed", "surface torque", "bit torque", "weight", "axial speed")
# (time [s], speed [rad/s], weight [N], ramp [s])
COMMANDS = ((1.0, 8.0, 120e3, 2.0), (5.0, 14.0, 80e3, 0.001), (8.0, 12.0, 110e3, 4.0), (9.5, 0.5, 110e3, 2.5))
count = {True: 0, False: 0}


def claim(holds, what):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


# ---- the other implementation

class Top:
    """Unknowns: angle and speed of the top, integral of the drive's error, q, q', p, p'."""

    def __init__(self, mu, w0, soft=None, speed=None, rotating=False, fc=100e3, f0=50e3):
        at = modes(fc)
        self.w2, self.b, self.d, self.inertia = at["w2"], at["phi"][-1], at["d"], at["J"]
        self.w2_a, self.b_a = at["w2_a"], at["phi_a"][-1]
        self.c_a = np.where(self.w2_a > 0, ALPHA + BETA * self.w2_a, 0.0)
        self.mu, self.w0, self.soft, self.fc, self.f0, self.slope = mu, w0, soft, fc, f0, 0.0
        speed = w0 if speed is None else speed
        n, m = len(self.w2), len(self.w2_a)
        self.state = np.concatenate([[0.0, speed, 0.0], np.zeros(n), np.zeros(n) if rotating else -self.d * speed, np.zeros(2 * m)])
        self.cut = np.cumsum([3, n, n, m])

    def rates(self, _, state):
        top, q, v, p, vp = np.split(state, self.cut)
        swing = self.f0 * (np.sin(top[0]) + 0.01)
        bit = self.bit_torque(top[1] + self.b @ v, min(swing - self.fc, 0.0))
        free = self.b * bit - self.d * ALPHA * top[1] - (ALPHA + BETA * self.w2) * v - self.w2 * q     # q'' + d theta''
        error, slope = self.w0 - top[1], self.slope
        if self.soft:
            push = 4.0 * self.soft["Z"] * error + (2.0 * np.pi * self.soft["f"])**2 * self.soft["J"] * top[2]
            rest = ALPHA * self.inertia * top[1] + self.d @ (free + ALPHA * v) - bit                   # (S) without theta''
            slope = (push - rest) / (self.soft["J"] + self.inertia - self.d @ self.d)
        return np.concatenate([[top[1], slope, error], v, free - self.d * slope, vp, self.b_a * swing - self.c_a * vp - self.w2_a * p])

    def bit_torque(self, w, f):
        return self.mu * f * (np.tanh(w) + 2.0 * w / (1.0 + w * w))

    def look(self, state):
        """One row of COLUMNS."""
        top, _, v, _, vp = np.split(state, self.cut)
        change = np.split(self.rates(0.0, state), self.cut)
        f = min(self.f0 * (np.sin(top[0]) + 0.01) - self.fc, 0.0)
        w = top[1] + self.b @ v
        bit = self.bit_torque(w, f)
        surface = self.inertia * (change[0][1] + ALPHA * top[1]) + self.d @ (change[2] + ALPHA * v) - bit
        return [w, top[1], surface, bit, f, self.b_a @ vp]

    def run(self, start, times):
        """States at these times, the last of which is where the next stretch begins."""
        done = solve_ivp(self.rates, (start, times[-1]), self.state, method="DOP853", rtol=1e-10, atol=1e-9, t_eval=times, max_step=0.005)
        self.state = done.y[:, -1].copy()
        return [self.look(y) for y in done.y.T]


def soft_reference(seconds, **case):
    top = Top(soft=SOFT, **case)
    return np.array([top.look(top.state)] + top.run(0.0, np.arange(1.0, seconds + 0.5)))


def commanded_reference(seconds, commands, **case):
    """A stretch between every two changes of slope or weight; whole seconds are kept."""
    top, now, rows = Top(**case), 0.0, {}
    ends = {round(t + ramp, 9): speed for t, speed, _, ramp in commands}
    begins = {t: (speed, weight, ramp) for t, speed, weight, ramp in commands}
    held = None
    for until in sorted({0.0, *ends, *begins, *np.arange(1.0, seconds + 0.5)}):
        if until > now:
            top.run(now, [until])
            now = until
        if until == held:
            top.state[1], top.slope = ends[until], 0.0
        if until in begins:
            speed, top.fc, ramp = begins[until]
            top.slope, held = (speed - top.state[1]) / ramp, round(until + ramp, 9)
        if until == round(until):
            rows[until] = top.look(top.state)
    return np.array([rows[t] for t in sorted(rows)])


# ---- kelly

def numbers(real, kind, step_us, seconds, commands=(), program=None, **case):
    """What drive-numbers prints at whole seconds, and its CRC-32C."""
    ticks = round(seconds * 1e6 / step_us)
    words = [program or os.path.join(ROOT, HOST[real], "drive-numbers"), kind, f"step={step_us}", f"ticks={ticks}", f"every={round(1e6 / step_us)}"]
    lines = "".join(f"{round(t * 1e6 / step_us)} {speed!r} {weight!r} {round(ramp * 1e6 / step_us)}\n" for t, speed, weight, ramp in commands)
    said = subprocess.run(words + [f"{k}={v!r}" for k, v in case.items()], input=lines, capture_output=True, text=True, check=True).stdout.split("\n")
    claim(said[-3] == "sane", f"{kind} {case}: {said[-3]}")
    return np.array([[float(x) for x in line.split()[1:]] for line in said[:-3]]), said[-2]


def kelly(real, words):
    return subprocess.run([PROGRAM[real]] + words.split(), capture_output=True, text=True, check=False)


def near(got, want, within, what):
    away = np.abs(got - want).max(axis=0)
    for name, a, w in zip(COLUMNS, away, within):
        claim(a <= w, f"{what}: {name} off by {a:.3g}, allowed {w:.3g}")
    return away


# ---- checks

def check_reference():
    """gen/reference.py, the reference of the random cases back to back, under a soft drive and, beside it, a stiff one."""
    with open(os.path.join(ROOT, "gen", "wells", "paper.toml"), encoding="utf-8") as file:
        well = well_.parse(file.read())
    cases = [{"w0": 10.0, "mu": 0.004, "rotating": 1, **SOFT}, {"w0": 10.0, "mu": 0.004}]
    data = reference.simulate_many(well, cases, 0.001, 1.0, 10.0)
    got = [np.array([data[name][k] for name in ("bit_speed", "surface_torque", "bit_torque", "f_bit", "bit_axial_speed")]).T for k in range(2)]
    want = np.delete(soft_reference(10, mu=0.004, w0=10.0, rotating=True), 1, axis=1)
    stiff = reference.simulate(well, cases[1], 0.001, 1.0, 10.0)
    for k, (name, within) in enumerate((("bit speed", 1e-4), ("surface torque", 0.05), ("bit torque", 0.05), ("weight", 0.05), ("axial speed", 1e-6))):
        away = np.abs(got[0][:, k] - want[:, k]).max()
        claim(away <= within, f"reference, soft: {name} off by {away:.3g}, allowed {within:.3g}")
    away = np.abs(got[1][:, 0] - stiff["bit_speed"]).max()
    claim(away <= 1e-9, f"reference, a stiff top among soft ones: bit speed off by {away:.3g}")


def check_soft():
    """At 1 ms, and at 0.5 ms with an error about 16 times smaller."""
    for mu, rotating in ((0.04, False), (0.004, False), (0.004, True)):
        want = soft_reference(20, mu=mu, w0=10.0, rotating=rotating)
        coarse = near(numbers("double", "soft", 1000, 20, mu=mu, w0=10.0, rotating=int(rotating))[0], want, (1e-3, 1e-4, 0.5, 0.5, 0.5, 1e-5),
                      f"soft, mu {mu}")
        fine = near(numbers("double", "soft", 500, 20, mu=mu, w0=10.0, rotating=int(rotating))[0], want, (1e-4, 1e-5, 0.05, 0.05, 0.05, 1e-6),
                    f"soft, mu {mu}, 0.5 ms")
        claim(12 < coarse[0] / fine[0] < 20, f"soft, mu {mu}: half the step, {coarse[0] / fine[0]:.1f} times smaller error")
        single = near(numbers("float", "soft", 1000, 20, mu=mu, w0=10.0, rotating=int(rotating))[0], want, (0.02, 2e-3, 10.0, 10.0, 40.0, 1e-3),
                      f"soft, mu {mu}, float")
        print(f"soft drive, mu {mu}, {'rotating' if rotating else 'rest'}: bit speed within {coarse[0]:.2g} rad/s at 1 ms, {fine[0]:.2g} at 0.5 ms, "
              f"{single[0]:.2g} in float")


def check_commanded():
    for w0, speed in ((10.0, 10.0), (12.0, 6.0)):
        want = commanded_reference(15, COMMANDS, mu=0.04, w0=w0, speed=speed)
        case = {"mu": 0.04, "w0": w0, "top": speed}
        coarse = near(numbers("double", "commanded", 1000, 15, COMMANDS, **case)[0], want, (1e-3, 1e-9, 1.0, 1.0, 1e-3, 1e-4), "commanded")
        fine = near(numbers("double", "commanded", 500, 15, COMMANDS, **case)[0], want, (1e-4, 1e-9, 0.1, 0.1, 1e-3, 1e-5), "commanded, 0.5 ms")
        claim(12 < coarse[0] / fine[0] < 20, f"commanded: half the step, {coarse[0] / fine[0]:.1f} times smaller error")
        single = near(numbers("float", "commanded", 1000, 15, COMMANDS, **case)[0], want, (0.02, 1e-5, 30.0, 30.0, 10.0, 1e-3), "commanded, float")
        print(f"commanded top from {speed} rad/s: bit speed within {coarse[0]:.2g} rad/s at 1 ms, {fine[0]:.2g} at 0.5 ms, {single[0]:.2g} in float")


def check_stiff_limit():
    stiff = numbers("double", "stiff", 1000, 20, mu=0.04, w0=10.0)[0]
    near(numbers("double", "commanded", 1000, 20, mu=0.04, w0=10.0, top=10.0)[0], stiff, (1e-8, 0.0, 1e-5, 1e-5, 1e-5, 1e-9), "commanded at w0")
    distances = [np.abs(numbers("double", "soft", 1000, 20, mu=0.04, w0=10.0, J=j, Z=1.0)[0] - stiff)[:, 0].max() for j in (1e5, 1e6, 1e7, 1e8)]
    claim(all(8 < a / b < 12 for a, b in zip(distances, distances[1:])), f"ten times the inertia, a tenth of the distance from stiff: {distances}")


def check_command_line():
    said = kelly("double", "simulate --drive soft:Z=289,f=0.2,J=2900 --mu 0.04 --rpm 95.49296585513721 --duration 20 --out-step 1").stdout
    rows = list(csv.DictReader(io.StringIO(said)))
    names = ("bit_speed_rpm", "top_speed_rpm", "surface_torque_kNm", "bit_torque_kNm", "wob_kN", "bit_axial_speed_m_s")
    unit = np.array([RPM, RPM, 1e3, -1e3, -1e3, 1.0])
    got = np.array([[float(row[name]) for name in names] for row in rows]) * unit
    near(got, numbers("double", "soft", 1000, 20, mu=0.04, w0=10.0)[0], (1e-9, 1e-9, 1e-6, 1e-6, 1e-6, 1e-12), "simulate is the plant")
    soft = json.loads(kelly("double", "montecarlo --samples 3 --drive soft --duration 10 --json -").stdout)
    drive = dict(part.split("=") for part in soft["case"]["drive"].removeprefix("soft:").split(","))
    claim(abs(float(drive["Z"]) - 289.2805) < 1e-3 and drive["f"] == "0.2" and drive["J"] == "2900", f"--drive soft is that of the pipe: {drive}")
    again = json.loads(kelly("double", f"montecarlo --samples 3 --drive {soft['case']['drive']} --duration 10 --json -").stdout)
    claim(again["digest"] == soft["digest"], "the drive of the JSON gives the same run")
    stiff = json.loads(kelly("double", "montecarlo --samples 3 --drive stiff --duration 10 --json -").stdout)
    plain = json.loads(kelly("double", "montecarlo --samples 3 --duration 10 --json -").stdout)
    claim(stiff["digest"] == plain["digest"] != soft["digest"] and plain["case"]["drive"] == "stiff", "stiff is what there was")
    said = kelly("double", "montecarlo --samples 3 --drive soft --duration 10").stdout
    claim("drive soft:Z=289.281,f=0.2,J=2900" in said and "drive" not in kelly("double", "montecarlo --samples 3 --duration 10").stdout,
          "the summary names a soft drive")


def check_rows():
    """Realisations of an ensemble: their severity from simulate, bit for bit; traces and field along with it."""
    case = "--drive soft --mu 0.004 --duration 20"
    for real in HOST:
        rows = list(csv.DictReader(io.StringIO(kelly(real, f"montecarlo {case} --samples 3 --first 5 --csv -").stdout)))
        for row in rows:
            said = list(csv.DictReader(io.StringIO(kelly(real, f"simulate {case} --sample {row['index']} --out-step 0.001").stdout)))
            speeds = [float(line["bit_speed_rpm"]) for line in said[10000:]]
            claim(min(speeds) == float(row["bit_min_rpm"]) and max(speeds) == float(row["bit_max_rpm"]), f"{real}: realisation {row['index']}")
            claim(abs(np.trapezoid(speeds) / 1e4 - float(row["bit_mean_rpm"])) < 0.01 if hasattr(np, "trapezoid") else
                  abs(np.trapz(speeds) / 1e4 - float(row["bit_mean_rpm"])) < 0.01, f"{real}: mean of realisation {row['index']}")


def check_map():
    grid = "map --rpm 80:120:40 --wob 50:100:50 --mu 0.004 --samples 30 --duration 20 --drive soft"
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "map.json")
        claim(kelly("float", f"{grid} --quiet --json {path}").returncode == 0, "map with a soft drive")
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    claim(data["case"]["drive"].startswith("soft:Z=289"), "the JSON of a map names the drive")
    for start in ("rest", "rotating"):
        one = json.loads(kelly("float", f"montecarlo --rpm 120 --wob 50 --f0 25 --mu 0.004 --samples 30 --duration 20 --drive soft --start {start} --json -").stdout)
        claim(data[start]["digest"][0][1] == one["digest"], f"a cell of the map is montecarlo's, {start}")


def check_result():
    """What the drive is for: fewer realisations stick, at no setting more, least where all of them stick."""
    def stuck(mu, rpm, wob, start, drive):
        words = f"montecarlo --mu {mu} --rpm {rpm} --wob {wob} --f0 {wob / 2:g} --start {start} --samples 400 --drive {drive} --json -"
        return json.loads(kelly("float", words).stdout)
    for start, rpm, wob in (("rest", 100, 100), ("rest", 80, 75), ("rest", 120, 125), ("rotating", 80, 100), ("rotating", 100, 150)):
        stiff, soft = (stuck(0.004, rpm, wob, start, drive) for drive in ("stiff", "soft"))
        claim(soft["ci95"][1] < stiff["ci95"][0], f"soft rock, {rpm} rpm, {wob} kN, {start}: {soft['probability']} is not below {stiff['probability']}")
        print(f"soft rock, {rpm} rpm, {wob} kN, {start}: P {stiff['probability']:.3f} stiff, {soft['probability']:.3f} soft")
    claim(stuck(0.04, 100, 100, "rest", "soft")["probability"] == 1.0, "hard rock: it sticks under either drive")


def check_engines():
    for real in HOST:
        digests = {}
        for engine in engines(PROGRAM[real]):
            done = kelly(real, f"montecarlo --drive soft:Z=300 --mu 0.004 --samples 70 --duration 5 --seed 9 --engine {engine} --json -")
            digests[engine] = json.loads(done.stdout)["digest"]
        claim(len(digests) > 0 and len(set(digests.values())) == 1, f"{real}: {digests}")
        print(f"soft drive, {real}: {digests}")


def compiled(job):
    compiler, flags, real, folder = job
    program = os.path.join(folder, re.sub(r"\W", "", f"{compiler}{flags}{real}"))
    sources = [f for pattern in ("firmware/*.c", "firmware/link/*.c") for f in sorted(glob.glob(os.path.join(ROOT, pattern)))]
    sources += [os.path.join(ROOT, "firmware", "tables", "paper.c"), os.path.join(ROOT, "tests", "host_drive.c")]
    words = [compiler, *flags.split(), "-std=c11", "-ffp-contract=off", "-fno-math-errno", "-DKELLY_DOUBLE" if real == "double" else "-DKELLY_FLOAT"]
    subprocess.run(words + sources + ["-o", program, "-lm"], check=True)
    return program


def check_compilers():
    """The CRC-32C of all that is seen at every tick of 2 s."""
    commands = ((0.1, 8.0, 120e3, 0.5), (1.0, 0.0, 90e3, 0.001))
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(2) as pool:
        jobs = [(c, flags, real, folder) for c in ("gcc", "clang") for flags in ("-O0", "-O3 -march=native") for real in HOST]
        for job, program in zip(jobs, pool.map(compiled, jobs)):
            for kind in ("soft", "commanded"):
                args = {"commands": commands, "top": 10.0} if kind == "commanded" else {}
                claim(numbers(job[2], kind, 1000, 2, program=program, **args)[1] == numbers(job[2], kind, 1000, 2, **args)[1], f"{kind}: {job[:3]}")


def main():
    checks = {name[6:]: check for name, check in globals().items() if name.startswith("check_")}
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    for name in chosen(parser).names or checks:
        checks[name]()
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
