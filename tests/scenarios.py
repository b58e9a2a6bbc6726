"""scenarios - scenarios of a check side by side, as many as there are processors.

A scenario is (name, function, arguments); the function yields claims, (holds, what). One that breaks is a claim that fails.
"""
import concurrent.futures
import os
import subprocess
import time

from programs import ROOT, chosen, command_line


def _run(scenario):
    name, function, arguments = scenario
    begin, claims = time.monotonic(), []
    try:
        for claim in function(*arguments):
            claims.append(claim)
    except Exception as why:      # noqa: BLE001  whatever it was, the others go on
        claims.append((False, f"{type(why).__name__}: {why}"))
    return name, claims, time.monotonic() - begin


def run(doc, scenarios, boards):
    """Build the device programs of these boards, then run the scenarios whose name holds a word of the command line, or all.
    Prints each, and `N passed, N failed`; returns the exit status."""
    parser = command_line(doc)
    parser.add_argument("words", nargs="*")
    words, passed, failed = chosen(parser).words, 0, 0
    for target in boards:
        subprocess.run(["make", "-s", f"TARGET={target}", "device"], cwd=ROOT, check=True, stdin=subprocess.DEVNULL)
    picked = [s for s in scenarios if not words or any(w in s[0] for w in words)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for name, claims, seconds in pool.map(_run, picked):
            wrong = [text for good, text in claims if not good]
            passed, failed = passed + len(claims) - len(wrong), failed + len(wrong)
            print(f"{name}: {len(claims) - len(wrong)} passed, {len(wrong)} failed, {seconds:.1f} s", flush=True)
            for text in wrong:
                print("  FAIL " + text)
    print(f"{passed} passed, {failed} failed")
    return failed != 0
