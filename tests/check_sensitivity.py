#!/usr/bin/env python3
"""check_sensitivity - kelly sensitivity against indices found another way, from plain ensembles.

usage: tests/check_sensitivity.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. (Ishigami's function: tests/test_sobol.c.)
"""
import io
import json
import shlex
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from programs import PROGRAM, chosen, command_line  # noqa: E402

count = {True: 0, False: 0}
CASE = "--mu 0.004 --duration 20 --window 10:20 --limit 0.98"
NAMES = ("fc", "mu", "a1", "a2", "rpm")
KEEP = ("probability", "ss", "rows", "rows_left_out", "rows_left_out_first", "realisations", "digest")


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


def kelly(args, real="float"):
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=300)


def sensitivity(args, real="float"):
    result = kelly(f"sensitivity {args} --json -", real)
    claim(result.returncode == 0 and not result.stderr, f"{args}: exit {result.returncode}, {result.stderr.strip()!r}")
    return json.loads(result.stdout)


def ensemble(args):
    """Rows of montecarlo's CSV: the five parameters, ss, stuck, whether it counts."""
    text = kelly(f"montecarlo {args} --csv -").stdout
    table = np.genfromtxt(io.StringIO(text.replace("step,", "1,").replace("ok,", "0,")), delimiter=",", skip_header=1)
    return {"y": table[:, 1:6], "ss": np.minimum(table[:, 9], 10), "probability": table[:, 10], "ok": table[:, 11] == 0}


def splitmix64(x):
    """Of the seed: the seed of B, from facts of the generator (Steele, Lea, Flood 2014)."""
    mask = 2 ** 64 - 1
    z = (x + 0x9e3779b97f4a7c15) & mask
    z = ((z ^ z >> 30) * 0xbf58476d1ce4e5b9) & mask
    z = ((z ^ z >> 27) * 0x94d049bb133111eb) & mask
    return z ^ z >> 31


def by_bins(y, f, bins=400):
    """V(E(f | y)) / V(f): variance of the means of f in bins of y, less what chance alone puts into them."""
    groups = np.array_split(f[np.argsort(y, kind="stable")], bins)
    between = np.mean([(g.mean() - f.mean()) ** 2 for g in groups]) - np.mean([g.var(ddof=1) / len(g) for g in groups])
    return between / f.var()


def holds(estimate, value, slack, what):
    claim(estimate["ci95"][0] - slack <= value <= estimate["ci95"][1] + slack, f"{what}: {estimate}, another way {value:.3f}")


def check_first_by_bins():
    found, plain = sensitivity(f"{CASE} --samples 1500 --seed 3"), ensemble(f"{CASE} --samples 20000 --seed 77")
    for measure in ("probability", "ss"):
        f = plain[measure]
        claim(abs(found[measure]["mean"] - f.mean()) < 4 * (f.var() / 3000) ** 0.5, f"mean of {measure}")
        claim(abs(found[measure]["variance"] / f.var() - 1) < 0.15, f"variance of {measure}")
        for i, name in enumerate(NAMES):
            index = found[measure]["indices"][name]
            holds(index["first"], by_bins(plain["y"][:, i], f), 0.02, f"{measure}, {name}, first")
            claim(index["total"]["ci95"][1] > index["first"]["ci95"][0], f"{measure}, {name}: total is not below first")
            claim(index["first"]["ci95"][1] - index["first"]["ci95"][0] < 0.25, f"{measure}, {name}: the interval says something")


def check_total_of_two():
    """With two random parameters the total index of one is 1 less the first index of the other."""
    for pair in (("mu", "a1"), ("a2", "rpm"), ("fc", "rpm")):
        cov = f"--cov {pair[0]}=0.2,{pair[1]}=0.2"
        found, plain = sensitivity(f"{CASE} {cov} --samples 1500 --seed 5"), ensemble(f"{CASE} {cov} --samples 20000 --seed 78")
        claim(set(found["ss"]["indices"]) == set(pair) and found["realisations"] == 4 * 1500, f"{cov}: the two that are random")
        for measure in ("probability", "ss"):
            for one, other in (pair, pair[::-1]):
                first = by_bins(plain["y"][:, NAMES.index(other)], plain[measure])
                holds(found[measure]["indices"][one]["total"], 1 - first, 0.02, f"{measure}, {pair}, total of {one}")


def check_rows_are_the_ensembles():
    seed, n = 18446744073709551557, 300
    found = sensitivity(f"{CASE} --samples {n} --seed {seed} --first 40")
    a, b = (ensemble(f"{CASE} --samples {n} --seed {s} --first 40") for s in (seed, splitmix64(seed)))
    for measure in ("probability", "ss"):
        both = np.concatenate([a[measure], b[measure]])
        claim(abs(found[measure]["mean"] - both.mean()) < 1e-7, f"mean of {measure} is that of A and B")
        claim(abs(found[measure]["variance"] - both.var()) < 1e-7, f"variance of {measure} is that of A and B")


def check_same_bits():
    seen = []
    for how in ("--threads 1", "--threads 2", "--threads 3 --engine scalar", "--threads 5 --engine sse2"):
        run = sensitivity(f"{CASE} --duration 4 --window 2:4 --samples 101 {how}")
        seen.append({k: run[k] for k in KEEP})
    claim(all(s == seen[0] for s in seen), "the same for any threads and engine")
    other = sensitivity(f"{CASE} --duration 4 --window 2:4 --samples 101 --seed 2")
    claim(other["digest"] != seen[0]["digest"] and other["ss"] != seen[0]["ss"], "not the same for another seed")


def check_left_out():
    args = "--mu 0.05 --cov 0.4 --step 0.002 --duration 2 --window 1:2 --limit 1.02"
    found = sensitivity(f"{args} --samples 300")
    claim(0 < found["rows_left_out"] < 300 and found["refused"] >= found["rows_left_out"], f"{found['rows_left_out']} rows left out")
    plain = ensemble(f"{args} --samples 300")
    named = {i for i, why in found["rows_left_out_first"]}
    claim({int(i) for i in np.flatnonzero(~plain["ok"])[:20]} <= named, "rows whose A is refused are named")
    claim("left out: " in kelly(f"sensitivity {args} --samples 100").stdout, "and in the summary")


def check_no_answer():
    for step, words in (("1e-6 --duration 0.001", "the step is too short for this precision"), ("0.02 --duration 1", "the step is too long for 35 of 35")):
        result, said = kelly(f"sensitivity --step {step} --samples 5 --json -"), kelly(f"sensitivity --step {step} --samples 5").stdout
        claim(result.returncode == 1 and result.stderr.count("\n") == 1 and words in result.stderr, f"--step {step}: exit {result.returncode}, {result.stderr!r}")
        found = json.loads(result.stdout)
        for measure in ("probability", "ss"):
            claim(found[measure]["mean"] is None and found[measure]["variance"] is None and set(found[measure]["indices"].values()) == {None},
                  f"--step {step}, {measure} of nothing: {found[measure]}")
        claim(said.count(": unknown: every row was left out\n") == 2 and "mean" not in said and "does not vary" not in said, f"--step {step}, in the summary: {said!r}")


def check_ends():
    run = sensitivity("--mu 0.04 --duration 20 --samples 64")
    claim(run["probability"]["variance"] == 0 and all(i is None for i in run["probability"]["indices"].values()), "P = 1: no index")
    run = sensitivity(f"{CASE} --duration 2 --window 1:2 --samples 63")
    claim(all(i is None for i in run["ss"]["indices"].values()), "63 rows: no index")
    run = sensitivity(f"{CASE} --duration 2 --window 1:2 --samples 64", "double")
    claim(run["real"] == "double" and run["ss"]["indices"]["mu"] is not None, "64 rows, in double")
    for args, word in (("--cov 0", "nothing is random"), ("--csv x", "does not belong"), ("--convergence", "does not belong"), ("--samples 0", "--samples 0"),
                       ("--nonsense 1", "unknown option"), ("--json /nowhere/x --samples 2 --duration 1", "cannot write")):
        result = kelly(f"sensitivity {args}")
        claim(result.returncode == (1 if "nowhere" in args else 2) and result.stderr.count("\n") == 1 and word in result.stderr and not result.stdout,
              f"{args}: {result.returncode} {result.stderr!r}")


CHECKS = (check_first_by_bins, check_total_of_two, check_rows_are_the_ensembles, check_same_bits, check_left_out, check_no_answer, check_ends)


def main():
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    names = chosen(parser).names
    for check in CHECKS:
        if not names or check.__name__[6:] in names:
            check()
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] > 0


if __name__ == "__main__":
    sys.exit(main())
