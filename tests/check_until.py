#!/usr/bin/env python3
"""check_until - montecarlo that stops by itself: the same n on any threads, the files of --samples n, an interval that holds.

usage: tests/check_until.py [--float build/host/kelly] [--double build/host-double/kelly]

Each claim that fails is one line; the last line is `N passed, N failed`.
"""
import json
import math
import os
import shlex
import subprocess
import sys
import tempfile

from scipy.optimize import brentq
from scipy.special import gammaln

sys.dont_write_bytecode = True
from programs import PROGRAM, chosen, command_line  # noqa: E402

count = {True: 0, False: 0}
SHORT = "--duration 10 --window 5:10 --limit 1.05"


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


def kelly(args, real="float"):
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=300)


def montecarlo(args, real="float"):
    result = kelly(f"montecarlo {args} --json -", real)
    claim(result.returncode == 0 and not result.stderr, f"{args}: exit {result.returncode}, {result.stderr.strip()!r}")
    return json.loads(result.stdout)


def bounds(k, n):
    """Interval by the definition: where Beta(k + 1/2, n - k + 1/2) / (pi p^k q^(n-k)) < 20."""
    marginal = gammaln(k + 0.5) + gammaln(n - k + 0.5) - gammaln(n + 1) - math.log(math.pi) - math.log(20)

    def f(p):
        return marginal - (k * math.log(p) if k else 0) - ((n - k) * math.log1p(-p) if n > k else 0)
    at = min(max(k / n, 1e-12), 1 - 1e-12)
    return (brentq(f, 1e-300, at) if k else 0.0, brentq(f, at, 1 - 1e-15) if k < n else 1.0)


def by_hand(rows, stop):
    """The first n at which stop(lo, hi) holds, from the rows of a run that does not stop; refused ones count both ways."""
    stuck = refused = 0
    for n, row in enumerate(rows, 1):
        fields = row.split(",")
        stuck += int(fields[10])
        refused += fields[11] != "ok"
        if stop(bounds(stuck, n)[0], bounds(stuck + refused, n)[1]):
            return n
    return len(rows)


def check_stops_where_it_should(folder):
    for case, option, stop in ((f"--mu 0.004 {SHORT}", "--until-width 0.12", lambda lo, hi: hi - lo <= 0.12),
                               (f"--mu 0.004 {SHORT}", "--until-decided 0.36", lambda lo, hi: lo > 0.36 or hi < 0.36),
                               (f"--mu 0.05 --cov 0.4 --step 0.002 {SHORT}", "--until-width 0.3", lambda lo, hi: hi - lo <= 0.3)):
        plain, stopped = os.path.join(folder, "plain.csv"), os.path.join(folder, "stopped.csv")
        montecarlo(f"{case} --samples 3000 --csv {plain}")
        with open(plain, encoding="ascii") as file:
            lines = file.read().splitlines()
        n = by_hand(lines[1:], stop)
        claim(100 < n < 3000, f"{case} {option}: a test that tests something, n = {n}")
        seen = []
        for how in ("--threads 1", "--threads 2", "--threads 3 --engine scalar", "--threads 7 --engine sse2"):
            run = montecarlo(f"{case} {option} --samples 3000 --csv {stopped} {how}")
            with open(stopped, encoding="ascii") as file:
                claim(file.read().splitlines() == lines[:n + 1], f"{case} {option} {how}: the rows of the first {n} realisations")
            seen.append({k: v for k, v in run.items() if k not in ("engine", "seconds", "crc32c")})
        claim(all(s == seen[0] for s in seen), f"{case} {option}: the same JSON for any threads and engine")
        plain_n = montecarlo(f"{case} --samples {n}")
        claim(all(plain_n[k] == seen[0][k] for k in ("samples", "stuck", "refused", "digest", "probability", "ssi", "refused_first")),
              f"{case} {option}: what --samples {n} gives")
        lo, hi = bounds(seen[0]["stuck"], n)[0], bounds(seen[0]["stuck"] + seen[0]["refused"], n)[1]
        claim(abs(seen[0]["ci95"][0] - lo) < 2e-5 and abs(seen[0]["ci95"][1] - hi) < 2e-5, f"{seen[0]['ci95']}, by hand {lo} {hi}")
        claim(seen[0]["ci95"][0] <= plain_n["ci95"][0] and seen[0]["ci95"][1] >= plain_n["ci95"][1], "wider than at one n")
        claim(seen[0]["sequence"]["stopped"] == option.split()[0][8:], f"says why: {seen[0]['sequence']}")
        claim(seen[0]["sequence"]["samples_most"] == 3000, "says the most")


def check_ends():
    run = montecarlo(f"--mu 0.004 {SHORT} --until-width 0.01 --samples 50")
    claim(run["samples"] == 50 and run["sequence"]["stopped"] == "samples", f"--samples is the most: {run['sequence']}")
    run = montecarlo(f"--mu 0.04 {SHORT} --until-decided 0.5 --samples 1")
    claim(run["samples"] == 1 and run["sequence"]["stopped"] == "samples", "one realisation")
    run = montecarlo(f"--mu 0.004 {SHORT} --until-decided 0.9 --until-width 0.001 --first 4294966000")
    claim(run["sequence"]["stopped"] == "decided" and run["sequence"]["samples_most"] == 1296, "to the last of the indices; the first that holds")
    claim("sequence" not in montecarlo(f"{SHORT} --samples 5"), "no sequence where none was asked for")
    text = kelly(f"montecarlo --mu 0.004 {SHORT} --until-decided 0.9 --convergence").stdout
    claim("P is below the level" in text and "conv(1)" in text, f"the summary says why: {text!r}")
    for args, word in (("--until-width 0", "--until-width 0:"), ("--until-width x", "not a finite number"), ("--until-decided 1", "--until-decided 1:"),
                       ("--until-decided", "needs a value"), ("--until-width nan", "not a finite")):
        result = kelly(f"montecarlo {args}")
        claim(result.returncode == 2 and result.stderr.count("\n") == 1 and word in result.stderr, f"{args}: {result.stderr!r}")


def check_same_in_double():
    runs = [montecarlo(f"--mu 0.004 {SHORT} --until-width 0.1", real) for real in ("float", "double")]
    claim(runs[0]["samples"] == runs[1]["samples"] and runs[0]["sequence"] == runs[1]["sequence"],
          f"float and double stop at the same n: {runs[0]['samples']}, {runs[1]['samples']}")


def check_covers():
    """P at this setting from 40 000 realisations; 300 runs that stop where they are decided or narrow hold it in 95 % at least."""
    case = "--mu 0.004 --duration 4 --window 2:4"
    truth = montecarlo(f"{case} --samples 40000 --seed 999 --limit 1.05")["probability"]
    misses, total = 0, 0
    for seed in range(100):
        run = montecarlo(f"{case} --until-width 0.2 --until-decided {truth + 0.02:.4f} --seed {seed} --limit 1.05")
        misses += not run["ci95"][0] <= truth <= run["ci95"][1]
        total += run["samples"]
    claim(0.02 < truth < 0.98, f"P = {truth} is neither 0 nor 1")
    claim(misses <= 8, f"{misses} of 100 stopped runs miss P = {truth}")
    print(f"P = {truth:.4f}: {misses} of 100 stopped runs miss it, {total / 100:.0f} realisations each")


def main():
    chosen(command_line(__doc__))
    with tempfile.TemporaryDirectory() as folder:
        check_stops_where_it_should(folder)
    check_ends()
    check_same_in_double()
    check_covers()
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] > 0


if __name__ == "__main__":
    sys.exit(main())
