#!/usr/bin/env python3
"""gates.py - run the gates of `make test`, as many side by side as there are processors.

usage: tests/gates.py test [NAME...]

A gate is a command whose last line is `N passed, N failed`. One that ends otherwise, or with another status than its line
says, counts as one failure and shows the end of what it printed. The last line here is the sum.
"""
import os
import re
import subprocess
import sys
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PYTHON = sys.executable

# name: (group, timeout in s, command). Long ones first, so that the last to end is a short one.
GATES = {
    "tests-on-boards": ("test", 900, f"{PYTHON} tests/check_on_targets.py"),
    "command-line": ("test", 600, f"{PYTHON} tests/check_cli.py"),
    "digests": ("test", 900, f"{PYTHON} tests/check_digests.py"),
    "nothing-lost": ("test", 900, f"{PYTHON} tests/check_nothing_lost.py"),
    "merge": ("test", 300, f"{PYTHON} tests/check_merge.py"),
    "mpi": ("test", 600, f"{PYTHON} tests/check_mpi.py"),
    "plan": ("test", 300, f"{PYTHON} tests/check_plan.py"),
    "figures": ("test", 600, f"{PYTHON} tests/check_figures.py"),
    "map": ("test", 600, f"{PYTHON} tests/check_map.py"),
    "drive": ("test", 300, f"{PYTHON} tests/check_drive.py"),
    "use": ("test", 600, f"{PYTHON} tests/check_use.py"),
    "generator": ("test", 300, f"{PYTHON} tests/check_gen.py"),
    "sensitivity": ("test", 300, f"{PYTHON} tests/check_sensitivity.py"),
    "what-if": ("test", 300, f"{PYTHON} tests/check_whatif.py"),
    "stopping": ("test", 300, f"{PYTHON} tests/check_until.py"),
    "rare-events": ("test", 900, f"{PYTHON} tests/check_rare.py"),
    "well-files": ("test", 300, f"{PYTHON} tests/check_wells.py"),
    "unit-float": ("test", 300, "make -s unit && build/host/unit"),
    "unit-double": ("test", 300, "make -s unit REAL=double && build/host-double/unit"),
    "lanes-float": ("test", 300, "make -s unit && build/host/lanes"),
    "lanes-double": ("test", 300, "make -s unit REAL=double && build/host-double/lanes"),
    "accuracy-float": ("test", 300, "make -s unit && build/host/accuracy"),
    "link": ("test", 300, f"{PYTHON} tests/check_link.py"),
    "faulty-line": ("test", 120, f"{PYTHON} tests/check_faulty_line.py"),
    "vectors": ("test", 120, f"{PYTHON} tests/vectors/make_vectors.py --check"),
    "boards": ("test", 900, f"{PYTHON} tests/check_targets.py"),
    "images": ("test", 900, f"{PYTHON} tests/check_images.py"),
    "bench-device": ("test", 300, f"{PYTHON} tests/check_bench_device.py"),
    "bench": ("test", 400, f"{PYTHON} tests/check_bench.py"),
    "rebuilds": ("test", 300, f"{PYTHON} tests/check_rebuilds.py"),
    "accuracy-double": ("test", 300, "make -s unit REAL=double && build/host-double/accuracy"),
}
TARGETS = sorted(f[:-3] for f in os.listdir(os.path.join(ROOT, "linker")) if f.endswith(".mk") and f != "targets.mk")


def run_gate(name):
    """-> (passed, failed, seconds, tail of the output)"""
    _, timeout, command = GATES[name]
    start = time.monotonic()
    try:
        done = subprocess.run(command, shell=True, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              timeout=timeout, check=False)
        output, status = done.stdout.decode(errors="replace"), done.returncode
    except subprocess.TimeoutExpired as error:
        output, status = (error.stdout or b"").decode(errors="replace") + f"\nno end after {timeout} s", 124
    lines = output.strip().splitlines() or [""]
    found = re.fullmatch(r"(?:\w+: )?(\d+) passed, (\d+) failed", lines[-1].strip())
    seconds = time.monotonic() - start
    if not found or (int(found[2]) == 0) != (status == 0) or int(found[1]) + int(found[2]) == 0:
        return 0, 1, seconds, lines[-25:] + [f"(ended with status {status} and no sound last line)"]
    return int(found[1]), int(found[2]), seconds, lines[-25:-1] if int(found[2]) else []


class Board:
    """Takes gates from a list and prints each when it is done."""

    def __init__(self, names):
        self.names, self.lock = list(names), threading.Lock()
        self.passed = self.failed = 0

    def work(self):
        while True:
            with self.lock:
                if not self.names:
                    return
                name = self.names.pop(0)
            passed, failed, seconds, tail = run_gate(name)
            with self.lock:
                self.passed += passed
                self.failed += failed
                print(f"{name:24s} {passed:6d} passed, {failed:3d} failed  {seconds:6.1f} s", flush=True)
                for line in tail:
                    print("    " + line, flush=True)


def main():
    if len(sys.argv) < 2 or sys.argv[1] not in {g for g, _, _ in GATES.values()}:
        sys.exit(__doc__)
    group, only = sys.argv[1], sys.argv[2:]
    names = [n for n in GATES if GATES[n][0] == group and (not only or n in only)]
    if not names:
        sys.exit("gates: nothing of that name; there are: " + ", ".join(n for n in GATES if GATES[n][0] == group))
    for real in ("float", "double"):   # built once, before gates that run side by side would build it twice
        for goal in ("all", "unit"):
            subprocess.run(["make", "-s", f"-j{os.cpu_count()}", goal, f"REAL={real}"], cwd=ROOT, check=True)
        for target in [] if only else TARGETS:
            subprocess.run(["make", "-s", f"-j{os.cpu_count()}", f"TARGET={target}", f"REAL={real}"], cwd=ROOT, check=True)
    board = Board(names)
    workers = [threading.Thread(target=board.work) for _ in range(min(os.cpu_count() or 1, len(names)))]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    print(f"{board.passed} passed, {board.failed} failed")
    return board.failed != 0


if __name__ == "__main__":
    sys.exit(main())
