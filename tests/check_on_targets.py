#!/usr/bin/env python3
"""check_on_targets - every tests/test_*.c on every board, float and double, one image a test.

usage: tests/check_on_targets.py [--real float|double] [TARGET...]

Last line `N passed, N failed`; an image that does not build, ends with a fault or takes longer than LIMIT_S counts as one
failure. The slowest first, so that no core waits at the end.
"""
import argparse
import concurrent.futures
import os
import re
import sys
import time

from check_targets import build, out_of
from run_target import ROOT, command, run, target_settings

LIMIT_S = 300


def target_names():
    return sorted(f[:-3] for f in os.listdir(os.path.join(ROOT, "linker")) if f.endswith(".mk") and f != "targets.mk")


def test_names():
    names = os.listdir(os.path.join(ROOT, "tests"))
    return sorted(n[:-2] for n in names if n.startswith("test_") and n.endswith(".c"))


def run_test(target, real, test):
    """(passed, failed, seconds, text of failures)."""
    start = time.monotonic()
    elf = os.path.join(ROOT, out_of(target, real), test + ".elf")
    if not os.path.exists(elf):
        return 0, 1, 0.0, "not built"
    status, output = run(command(target_settings(target), elf), timeout=LIMIT_S)
    text = output.decode(errors="replace")
    counts = re.search(r"(\d+) passed, (\d+) failed\s*$", text)
    passed, failed = (int(counts[1]), int(counts[2])) if counts else (0, 0)
    if status != 0 and failed == 0:
        failed = 1
    return passed, failed, time.monotonic() - start, f"status {status}\n{text[-1000:]}" if failed else ""


def cost(job):
    """Soft arithmetic is the slow kind, soft double slower, and the M0 slowest."""
    target, real, _ = job
    settings = target_settings(target)
    soft = settings["DOUBLE" if real == "double" else "FLOAT"] == "soft"
    return soft * (1 + (real == "double")) + soft * (target == "microbit")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--real", choices=("float", "double"))
    parser.add_argument("targets", nargs="*")
    args = parser.parse_args()
    pairs = [(t, r) for t in args.targets or target_names() for r in ([args.real] if args.real else ("float", "double"))]
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for broken in pool.map(lambda pair: list(build(*pair, "-k", "one-tests")), pairs):
            for _, text in broken:
                print("FAIL", text)
        jobs = sorted(((*pair, test) for pair in pairs for test in test_names()), key=cost, reverse=True)
        sums = {pair: [0, 0, 0.0] for pair in pairs}
        for job, result in zip(jobs, pool.map(lambda job: run_test(*job), jobs)):
            sums[job[:2]] = [a + b for a, b in zip(sums[job[:2]], result[:3])]
            if result[1]:
                print("FAIL", *job, result[3], flush=True)
    for (target, real), (good, bad, seconds) in sums.items():
        print(f"{target:12} {real:6} {good} passed, {bad} failed, {seconds:.1f} s")
        passed, failed = passed + good, failed + bad
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
