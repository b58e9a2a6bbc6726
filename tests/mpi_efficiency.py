#!/usr/bin/env python3
"""mpi_efficiency - one rank against two, each computing on one thread: runs in turn, so that what else the machine does meets both.

usage: tests/mpi_efficiency.py [--samples N] [--pairs N] [--least E]

Two figures. By the clock: seconds on one rank over twice those on two, the best of the pairs; it needs two idle cores. By processor time: what one
rank takes over what two take together, both without the start of MPI (a run of one block); it holds under load too, but does not see waiting. Ends with 1 where the first is below --least.
"""
import argparse
import json
import os
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from check_mpi import PROGRAM, ROOT, command, environment  # noqa: E402


def run(ranks, samples):
    """(seconds of the run without mpirun's start, processor seconds of all of it)"""
    before = os.times()
    done = subprocess.run(command(ranks, f"montecarlo --mu 0.004 --samples {samples} --json -"), capture_output=True, text=True, check=True, env=environment())
    after = os.times()
    return json.loads(done.stdout)["seconds"], sum(after[2:4]) - sum(before[2:4])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--samples", type=int, default=24000)
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--least", type=float, default=0.9)
    args = parser.parse_args()
    PROGRAM["mpi"] = os.path.join(ROOT, "build/mpi/kelly")
    subprocess.run(["make", "-s", "mpi"], cwd=ROOT, check=True)
    pairs, start = [], {ranks: min(run(ranks, 80)[1] for _ in range(3)) for ranks in (1, 2)}
    for _ in range(args.pairs):
        one, two = run(1, args.samples), run(2, args.samples)
        pairs.append((one[0] / (2 * two[0]), (one[1] - start[1]) / (two[1] - start[2])))
        print(f"one rank {one[0]:.2f} s, {one[1]:.2f} s of processor time; two {two[0]:.2f} s, {two[1]:.2f} s: efficiency {pairs[-1][0]:.3f} by the clock, "
              f"{pairs[-1][1]:.3f} by processor time; load average {os.getloadavg()[0]:.1f}", flush=True)
    best = max(p[0] for p in pairs)
    print(f"efficiency on two ranks: {best:.3f} by the clock (best of {args.pairs}), {sorted(p[1] for p in pairs)[args.pairs // 2]:.3f} by processor time (median)")
    return best < args.least


if __name__ == "__main__":
    sys.exit(main())
