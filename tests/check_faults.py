#!/usr/bin/env python3
"""check_faults.py - faults inside the lanes of each vector unit that this processor has: tests/host_faults.c, a program for each.

usage: tests/check_faults.py float|double FLIPS      their figures, last line `N passed, N failed`
"""
import os
import re
import subprocess
import sys

from check_digests import ROOT, engines


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in ("float", "double"):
        sys.exit(__doc__)
    out = os.path.join(ROOT, "build", "host-double" if sys.argv[1] == "double" else "host")
    passed = failed = 0
    for unit in engines(os.path.join(out, "kelly"))[1:]:              # the first is scalar
        done = subprocess.run([os.path.join(out, "faults-" + unit), sys.argv[2]], capture_output=True, text=True, check=False)
        lines = done.stdout.splitlines() or [""]
        print("\n".join(lines[:-1]), flush=True)
        said = re.fullmatch(r"([1-9]\d*) passed, (\d+) failed", lines[-1])
        passed, failed = passed + int(said[1] if said else 0), failed + int(said[2] if said else 0)
        if not said or done.returncode != (said[2] != "0"):
            print(f"FAIL faults-{unit}: ended with status {done.returncode}: {lines[-1]}{done.stderr[-300:]}")
            failed += 1
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
