#!/usr/bin/env python3
"""check_back_to_back - the same random cases through gen/reference.py, this machine in float and double, and emulated boards.

usage: tests/check_back_to_back.py [STRING...]

Ten random strings of twenty random cases each, by a fixed seed: laws, drives, starts, weights, speeds, rocks, one realisation of a
random seed and index. Board and machine must agree bit for bit: digest and CSV, float on a Cortex-M4F, double on a Cortex-M7. The
reference has the equations of motion, eigenvectors of dense matrices and a sampler in double; it must agree within WITHIN over the
first seconds, before the systems that are chaotic have lost their memory, and in what is counted over the whole run.
The table of what was found is printed as figures. Last line `N passed, N failed`.
"""
import concurrent.futures
import csv
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path[:0] = [os.path.join(ROOT, "gen"), os.path.join(ROOT, "tests", "vectors")]
import reference  # noqa: E402
import well as well_  # noqa: E402
from make_vectors import gamma, words  # noqa: E402

STRINGS, CASES = 10, 20
SHORT, LONG = (1, 4), (10, 20)          # windows [s]; each ends its run
BOARDS = {"float": "mps2-an386", "double": "mps2-an500"}
SUFFIX = {"float": "", "double": "-double"}
PARAMETERS = ("fc", "mu", "a1", "a2", "rpm")
LIMIT = 0.8
# largest distance from the reference over SHORT: rpm, rpm, rpm, of ss
QUANTITIES = ("lowest bit speed [rpm]", "highest bit speed [rpm]", "mean bit speed [rpm]", "ss")
WITHIN = {"float": (0.005, 0.005, 0.005, 2e-5), "double": (1e-7, 1e-7, 1e-7, 1e-9)}
DRAW_WITHIN = 2e-6                       # of a draw, relative: the sampler computes in float
FLIPS = {"float": 1, "double": 0}        # cases of 200 on the other side of the limit over LONG


def well_text(name, rng):
    """A string that drills: pipe, heavier pipe below it or not, bottom hole assembly."""
    sections = [(rng.uniform(400, 3000), rng.uniform(95, 150), rng.uniform(8, 13), rng.randint(30, 60))]
    if rng.random() < 0.5:
        sections.append((rng.uniform(50, 300), rng.uniform(110, 150), rng.uniform(15, 25), rng.randint(8, 16)))
    sections.append((rng.uniform(80, 300), rng.uniform(140, 200), rng.uniform(25, 50), rng.randint(12, 30)))
    text = f'name = "{name}"\n'
    for number, (length, outer, wall, elements) in enumerate(sections):
        text += (f'[[section]]\nname = "part {number}"\nlength_m = {length:.1f}\nouter_diameter_mm = {outer:.1f}\n'
                 f"inner_diameter_mm = {outer - 2 * wall:.1f}\nelements = {elements}\n")
    return text + (f"[material]\nyoungs_modulus_GPa = {rng.uniform(195, 215):.2f}\nshear_modulus_GPa = {rng.uniform(70, 83):.2f}\n"
                   f"density_kg_m3 = 7850.0\n[damping]\nmass_per_s = {rng.uniform(0.03, 0.3):.3f}\nstiffness_s = {rng.uniform(2e-5, 1.2e-4):.2e}\n"
                   "[environment]\ngravity_m_s2 = 9.81\n"
                   f"[modes]\ntorsional = {rng.randint(4, 14)}\naxial = 2\n"
                   "[case]\nrpm = 100.0\nwob_kN = 80.0\nwob_amplitude_kN = 30.0\nmu = 0.01\nalpha1 = 2.0\nalpha2 = 1.0\n"
                   "[uncertainty]\nrpm = 0.2\nwob = 0.2\nmu = 0.2\nalpha1 = 0.2\nalpha2 = 0.2\n"
                   "[run]\nstep_s = 0.001\nduration_s = 100.0\nwindow_s = [50.0, 100.0]\nseverity_limit = 0.8\nstart = \"rest\"\n")


def random_case(rng):
    """What the command line says; every second drive is soft."""
    wob = rng.uniform(20, 220)
    case = {"rpm": rng.uniform(50, 180), "wob": wob, "f0": rng.uniform(0, 0.8) * wob,
            "mu": min(math.exp(rng.uniform(math.log(0.002), math.log(0.3))), 15 / wob),
            "alpha1": rng.uniform(0.5, 3), "alpha2": rng.uniform(0.5, 2)}
    case = {name: float(f"{value:.5g}") for name, value in case.items()}
    case["cov"] = {name: rng.choice((0, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5)) for name in PARAMETERS}
    case["start"] = rng.choice(("rest", "rotating"))
    soft = rng.random() < 0.5
    case["drive"] = {"Z": rng.randint(80, 1200), "f": rng.choice((0.05, 0.1, 0.2, 0.4)), "J": rng.randint(500, 5000)} if soft else {}
    case["seed"], case["first"] = rng.getrandbits(64), rng.getrandbits(32)
    return case


def options(case, window):
    line = [f"--{name}={case[name]}" for name in ("rpm", "wob", "f0", "mu", "alpha1", "alpha2", "start", "seed", "first")]
    line.append("--drive=" + ("soft:" + ",".join(f"{k}={v}" for k, v in case["drive"].items()) if case["drive"] else "stiff"))
    line.append("--cov=" + ",".join(f"{k}={v}" for k, v in case["cov"].items()))
    return [*line, "--samples=1", f"--duration={window[1]}", f"--window={window[0]}:{window[1]}", f"--limit={LIMIT}"]


# ---- the machines

def sh(words, but=""):
    """What a command says that ends with 0; or with 1, where `but` tells why."""
    done = subprocess.run(words, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode != 0 and not (but and done.returncode == 1 and but in done.stderr):
        raise RuntimeError(f"{' '.join(words)[-300:]}: exit {done.returncode}: {done.stderr[-300:]}")
    return done.stdout


def build(path, name):
    """Programs and images of a string: what differs from the paper's is the table, so the objects of that build are taken over."""
    places = []
    for real, suffix in SUFFIX.items():
        for place, target in ((f"build/host{suffix}", "all"), (f"build/{BOARDS[real]}{suffix}", "device")):
            goal = [target, f"REAL={real}", *([f"TARGET={BOARDS[real]}"] if target == "device" else [])]
            places.append(f"{place}-{name}")
            shutil.copytree(os.path.join(ROOT, place), os.path.join(ROOT, places[-1]), dirs_exist_ok=True)
            sh(["make", "-s", *goal, f"WELL={path}"])
    return places


def answer(real, name, command, case, window, scratch):
    """(digest, CSV) of one run."""
    path = os.path.join(scratch, f"{name}.csv")
    said = sh([f"build/host{SUFFIX[real]}-{name}/kelly", *command, *options(case, window), "--csv", path],
              but="no answer: none of 1 realisations can be trusted")
    with open(path, encoding="ascii") as file:
        return re.search(r"digest ([0-9a-f]{8})", said)[1], file.read()


def row_of(text):
    """Columns of the one realisation; a refused one leaves its results empty."""
    row = next(csv.DictReader(text.splitlines()))
    return {name: value if name == "status" else float(value or "nan") for name, value in row.items()}


# ---- the reference

def si(case, row):
    """The case of the reference: the draws of the run."""
    fixed = {"f0": case["f0"] * 1e3, "rotating": int(case["start"] == "rotating"), **case["drive"]}
    return {"fc": row["fc_kN"] * 1e3, "mu": row["mu"], "a1": row["alpha1"], "a2": row["alpha2"], "w0": row["rpm"] * math.pi / 30, **fixed}


def own_draw(case):
    """The draws by the sampler in double, in the units of the CSV."""
    means = (case["wob"], case["mu"], case["alpha1"], case["alpha2"], case["rpm"])
    covs = [float(np.float32(case["cov"][name])) for name in PARAMETERS]
    return [gamma(words(case["seed"], case["first"], k), mean, cov) if cov else mean for k, (mean, cov) in enumerate(zip(means, covs))]


def bit(well, cases):
    """Bit speed [rpm] and its integral [rpm s], [time, case] at every step: theta_top' + sum b q', theta_top + sum b q."""
    system = reference.system_of(well, cases)
    step = well.step_ns * 1e-9
    top = system.speed(np.zeros_like(system.v0))         # of a stiff one: the angle of a soft one is a column of q
    look = lambda t, q, v: (system.speed(v), top * t + (system.b * q).sum(axis=1))
    return np.array(reference.march(system, look, step, step, LONG[1])).swapaxes(0, 1) * 30 / math.pi


def measures(speed, angle, window, step):
    """lowest, highest, mean, ss of one case."""
    first, last = round(window[0] / step), round(window[1] / step)
    low, high = speed[first:last + 1].min(), speed[first:last + 1].max()
    return low, high, (angle[last] - angle[first]) / (window[1] - window[0]), (high - low) / (high + low) if high + low > 0 else 10.0


def of_row(row):
    return row["bit_min_rpm"], row["bit_max_rpm"], row["bit_mean_rpm"], row["ss"]


# ---- one string

def one_string(number):
    """-> list of cases, each a dict of what was found."""
    rng = random.Random(f"kelly {number}")
    name = f"random-{number}"
    with tempfile.TemporaryDirectory() as scratch:
        path = os.path.join(scratch, name + ".toml")
        with open(path, "w", encoding="ascii") as file:
            file.write(well_text(name, rng))
        with open(path, encoding="ascii") as file:
            well = well_.parse(file.read())
        places = build(path, name)
        try:
            found = [ask(name, random_case(rng), scratch) for _ in range(CASES)]
        finally:
            for place in places:
                shutil.rmtree(os.path.join(ROOT, place))
    refer(well, [one for one in found if one["short"]["double"]["status"] == "ok"])
    return found


def ask(name, case, scratch):
    one = {"case": case, "string": name, "same": {}, "short": {}, "long": {}, "bytes": {}}
    for real in SUFFIX:
        host = answer(real, name, ["montecarlo"], case, LONG, scratch)
        board = answer(real, name, ["bench", "--port", f"qemu:{BOARDS[real]}"], case, LONG, scratch)
        one["same"][real], one["bytes"][real] = host[0] == board[0], host[1] == board[1]
        one["long"][real] = row_of(host[1])
        one["short"][real] = row_of(answer(real, name, ["montecarlo"], case, SHORT, scratch)[1])
    draws = [one["long"]["float"][c] for c in ("fc_kN", "mu", "alpha1", "alpha2", "rpm")]
    one["draw"] = max(abs(a / b - 1) for a, b in zip(draws, own_draw(case)))
    return one


def refer(well, found):
    """Put what the reference finds beside it."""
    step = well.step_ns * 1e-9
    speed, angle = bit(well, [si(one["case"], one["short"]["double"]) for one in found])
    for k, one in enumerate(found):
        one["reference"] = {name: measures(speed[:, k], angle[:, k], window, step) for name, window in (("short", SHORT), ("long", LONG))}


# ---- claims

count = {True: 0, False: 0}


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


def label(one):
    return f"{one['string']}: kelly montecarlo {' '.join(options(one['case'], LONG))}"


def claims_of(one):
    for real in SUFFIX:
        claim(one["same"][real] and one["bytes"][real], f"{label(one)}: {real} on {BOARDS[real]} differs from this machine")
    claim(one["short"]["float"]["status"] == one["short"]["double"]["status"], f"{label(one)}: another status in float and double")
    claim(one["draw"] <= DRAW_WITHIN, f"{label(one)}: draws {one['draw']:.2g} off those of the sampler in double")
    if "reference" in one:
        for real in SUFFIX:
            away = distance(one, real)
            claim(all(a <= w for a, w in zip(away, WITHIN[real])), f"{label(one)}: {real} off the reference by {away} over {SHORT} s")


def distance(one, real):
    """From the reference over SHORT, by QUANTITIES. ss of a bit that hardly turns is a quotient of what is near 0: against that sum."""
    want, got = one["reference"]["short"], of_row(one["short"][real])
    away = [abs(a - b) for a, b in zip(got, want)]
    away[3] *= min(1.0, max(want[0] + want[1], 0.0) / 10.0)
    return away


def figures(found):
    ran = [one for one in found if "reference" in one]
    for real in SUFFIX:
        same = sum(one["same"][real] and one["bytes"][real] for one in found)
        print(f"figure: back to back, random cases whose bits are the same here and on {BOARDS[real]}, {real}: {same} of {len(found)}")
    print(f"figure: back to back, draws against the sampler in double, largest relative distance: {max(one['draw'] for one in found):.2g}")
    refused = len(found) - len(ran)
    lifted = sum(one["long"]["double"]["liftoff"] for one in found)
    claim(0 < refused <= len(found) // 4 and lifted > 0, f"{refused} of {len(found)} cases refused, {lifted:.0f} lift off: some should, few may")
    soft, turning = sum(bool(one["case"]["drive"]) for one in ran), sum(one["case"]["start"] == "rotating" for one in ran)
    claim(min(soft, turning, len(ran) - soft, len(ran) - turning) * 4 > len(ran), f"drives and starts: {soft} soft, {turning} rotating of {len(ran)}")
    print(f"figure: back to back, cases integrated: {len(ran)} of {len(found)}, {soft} under soft drives, {turning} rotating at the start, "
          f"{refused} refused alike, {lifted:.0f} lift off")
    for real in SUFFIX:
        away = np.array([distance(one, real) for one in ran])
        for k, what in enumerate(QUANTITIES):
            print(f"figure: back to back, {what} over {SHORT[0]}..{SHORT[1]} s, {real} against the reference, largest and median distance: "
                  f"{away[:, k].max():.2g} and {np.median(away[:, k]):.2g}, allowed {WITHIN[real][k]:g}")
    want = [one["reference"]["long"][3] > LIMIT for one in ran]
    for real in SUFFIX:
        got = [one["long"][real]["ss"] > LIMIT for one in ran]
        flips = sum(a != b for a, b in zip(got, want))
        claim(flips <= FLIPS[real], f"{real}: {flips} of {len(ran)} cases on the other side of ss = {LIMIT}")
        print(f"figure: back to back, stick-slip over {LONG[0]}..{LONG[1]} s, {real} and reference: {sum(got)} and {sum(want)} of {len(ran)}, "
              f"{flips} cases differ")
    claim(0.1 < np.mean(want) < 0.9, f"both kinds occur: {np.mean(want):.2f} stick")


def main():
    numbers = [int(word) for word in sys.argv[1:]] or list(range(STRINGS))
    for real in SUFFIX:                  # what build() takes over
        sh(["make", "-s", f"-j{os.cpu_count()}", "all", f"REAL={real}"])
        sh(["make", "-s", f"-j{os.cpu_count()}", "device", f"REAL={real}", f"TARGET={BOARDS[real]}"])
    with concurrent.futures.ProcessPoolExecutor(os.cpu_count()) as pool:
        found = [one for string in pool.map(one_string, numbers) for one in string]
    for one in found:
        claims_of(one)
    figures(found)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
