#!/usr/bin/env python3
"""check_batteries - dieharder on the words that firmware/random.h makes. No p below 1e-6 or above 1 - 1e-6. Hours.

usage: tests/check_batteries.py [--only TEST,...] [STREAM...]     TEST: its number in dieharder -l

Needs build/host/random-stream and Debian's dieharder. Each stream is one run of the generator that all tests read from on. A p
that dieharder calls weak is taken again with more samples until it is not, or fails (-Y 1); what is printed is that of all samples,
Kolmogorov-Smirnov to machine precision (-k 2). Left out of `dieharder -a`: opso, oqso, dna and sums, which `dieharder -l` itself
calls suspect or not to be used, and 28 of the 33 lags of rgb_lagged_sum, which alone read 230 GB.
Each test is a figure: its p's, in the order of the battery. Last line `N passed, N failed`.
"""
import argparse
import csv
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
STREAMS = {
    "one stream": ("streams=1",),
    "256 indices interleaved": ("over=index", "streams=256"),
    "first 4 words of ever new draws": ("over=draw", "streams=0", "each=4"),
    "256 seeds interleaved": ("over=seed", "streams=256"),
}
# number of the test and the sizes that it is run with; None: it has but one
TESTS = ((0, None), (2, None), (3, None), (8, None), (9, None), (10, None), (11, None), (12, None), (13, None), (15, None), (16, None),
         (100, None), (101, None), (102, None), (205, None), (204, None), (209, None), (206, None), (207, None), (208, (0, 1)),
         (1, None), (4, None), (17, None), (200, range(1, 13)), (202, range(2, 6)), (201, range(2, 6)), (203, (0, 1, 3, 7, 15)))
COLUMNS = ("test_name", "ntuple", "tsamples", "psamples", "pvalues", "assessment")
LIMIT = 1e-6
count = {True: 0, False: 0}


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


def dieharder(source, test, size):
    """[(name, ntuple, tsamples, psamples, p, assessment)] of one run that reads from `source`."""
    words = ["dieharder", "-g", "200", "-d", str(test), "-k", "2", "-Y", "1", "-c", ",", *(w for c in COLUMNS for w in ("-D", c))]
    words += [] if size is None else ["-n", str(size)]
    said = subprocess.run(words, stdin=source, capture_output=True, text=True, check=False).stdout
    rows = [[field.strip() for field in row] for row in csv.reader(said.splitlines())]
    return [(r[0], *map(int, r[1:4]), float(r[4]), r[5]) for r in rows if len(r) == len(COLUMNS) and r[1].isdigit()]


def stream(*ask):
    return subprocess.Popen([os.path.join(ROOT, "build", "host", "random-stream"), "words", *ask], stdout=subprocess.PIPE)


def end(process):
    process.kill()
    process.wait()
    process.stdout.close()


def battery(name, only):
    """-> p's of the whole battery."""
    source, ps = stream(*STREAMS[name]), []
    try:
        for test, sizes in TESTS:
            if str(test) not in only:
                continue
            rows = [row for size in sizes or (None,) for row in dieharder(source.stdout, test, size)]
            claim(rows, f"{name}: dieharder -d {test} gives a p")
            for what, size, _, samples, p, word in rows:
                claim(LIMIT <= p <= 1 - LIMIT and word == "PASSED", f"{name}: {what} {size}: p {p:g} of {samples} samples, {word}")
            if rows:
                again = "".join(f"; {r[1]} after {r[3]} samples" for r in rows if r[3] > min(q[3] for q in rows))
                verdict = ", ".join(sorted({row[5] for row in rows}))
                print(f"figure: dieharder, {name}, {rows[0][0]}: p {' '.join(f'{row[4]:.6f}' for row in rows)}{again}; {verdict}", flush=True)
            ps += [row[4] for row in rows]
    finally:
        end(source)
    return ps


def check_power():
    """The first words of ever new streams whose states are counters. The battery must see it."""
    source = stream("over=draw", "streams=0", "each=4", "keys=plain")
    rows = dieharder(source.stdout, 100, None)
    end(source)
    claim(rows and rows[0][4] < LIMIT and rows[0][5] == "FAILED", f"dieharder refuses streams keyed by a counter: {rows}")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--only")
    parser.add_argument("streams", nargs="*")
    args = parser.parse_args()
    only = args.only.split(",") if args.only else [str(test) for test, _ in TESTS]
    strangers = sorted(set(only) - {str(test) for test, _ in TESTS}) + sorted(set(args.streams) - set(STREAMS))
    if strangers:
        parser.error(f"{', '.join(strangers)}: no test or stream of this battery")
    check_power()
    for name in args.streams or STREAMS:
        ps = battery(name, only)
        if ps:
            print(f"figure: dieharder, {name}: {len(ps)} p, least {min(ps):.6f}, most {max(ps):.6f}", flush=True)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
