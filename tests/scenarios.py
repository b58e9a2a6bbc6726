"""scenarios - scenarios of a check side by side, as many as there are processors.

A scenario is (name, function, arguments); the function yields claims, (holds, what). One that breaks is a claim that fails.
"""
import concurrent.futures
import os
import subprocess
import sys
import time

from run_target import ROOT


def _run(scenario):
    name, function, arguments = scenario
    begin, claims = time.monotonic(), []
    try:
        for claim in function(*arguments):
            claims.append(claim)
    except Exception as why:      # noqa: BLE001  whatever it was, the others go on
        claims.append((False, f"{type(why).__name__}: {why}"))
    return name, claims, time.monotonic() - begin


def run(scenarios, boards):
    """Build the device programs of these boards, then run the scenarios whose name holds a word of the command line, or all.
    Prints each, and `N passed, N failed`; returns the exit status."""
    words, passed, failed = sys.argv[1:], 0, 0
    for target in boards:
        subprocess.run(["make", "-s", f"TARGET={target}", "device"], cwd=ROOT, check=True, stdin=subprocess.DEVNULL)
    chosen = [s for s in scenarios if not words or any(w in s[0] for w in words)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, claims, seconds in pool.map(_run, chosen):
            wrong = [text for good, text in claims if not good]
            passed, failed = passed + len(claims) - len(wrong), failed + len(wrong)
            print(f"{name}: {len(claims) - len(wrong)} passed, {len(wrong)} failed, {seconds:.1f} s", flush=True)
            for text in wrong:
                print("  FAIL " + text)
    print(f"{passed} passed, {failed} failed")
    return failed != 0
