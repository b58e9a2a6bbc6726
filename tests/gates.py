#!/usr/bin/env python3
"""gates.py - run the gates of a group, as many side by side as there are processors; or some alone, with their figures printed.

usage: tests/gates.py test|prove|campaign     (make test, make prove, make campaign)
       tests/gates.py GATE...                 (make gate-NAME)

A gate is a command whose last line is `N passed, N failed`. One that ends otherwise, or with another status than its line
says, counts as one failure. What failed shows its FAIL lines and the end of what it printed. The last line here is the sum.

What a gate has counted or measured it prints as `figure: WHAT: VALUE`; the figures of a whole group go to build/gates-GROUP.md,
rows of the README's table. `test` is every gate of `make test`, `prove` what stands beside it, `campaign` what takes hours: its
rows are kept in tests/campaign.md, with the commit that they are of.
"""
import os
import re
import signal
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
    "twice": ("test", 600, f"{PYTHON} tests/check_twice.py"),
    "use": ("test", 600, f"{PYTHON} tests/check_use.py"),
    "generator": ("test", 300, f"{PYTHON} tests/check_gen.py"),
    "sensitivity": ("test", 300, f"{PYTHON} tests/check_sensitivity.py"),
    "what-if": ("test", 300, f"{PYTHON} tests/check_whatif.py"),
    "stopping": ("test", 300, f"{PYTHON} tests/check_until.py"),
    "rare-events": ("test", 900, f"{PYTHON} tests/check_rare.py"),
    "well-files": ("test", 300, f"{PYTHON} tests/check_wells.py"),
    "unit-float": ("test", 300, "make -s unit && build/host/unit"),
    "unit-double": ("test", 300, "make -s unit REAL=double && build/host-double/unit"),
    "app-float": ("test", 300, "make -s unit && build/host/app-unit"),
    "app-double": ("test", 300, "make -s unit REAL=double && build/host-double/app-unit"),
    "lanes-float": ("test", 300, "make -s unit && build/host/lanes"),
    "lanes-double": ("test", 300, "make -s unit REAL=double && build/host-double/lanes"),
    "faults-inside": ("test", 600, "make -s unit && build/host/faults 3400"),
    "faults-inside-lanes": ("test", 900, f"make -s unit && {PYTHON} tests/check_faults.py float 200"),
    "fuzz-replay": ("test", 600, f"{PYTHON} tests/check_fuzz.py replay"),
    "eva": ("prove", 2700, f"{PYTHON} tests/check_eva.py"),   # first, with the next: each one thread, and the others fill what is left
    "eva-levels": ("prove", 2400, f"{PYTHON} tests/check_eva.py --levels"),
    "fuzz": ("prove", 1200, f"{PYTHON} tests/check_fuzz.py 60"),
    "fuzz-long": ("campaign", 6000, f"{PYTHON} tests/check_fuzz.py 600"),
    "faults-inside-long": ("campaign", 900, "make -s unit && build/host/faults 20000"),
    "faults-inside-lanes-double": ("campaign", 1800, f"make -s unit REAL=double && {PYTHON} tests/check_faults.py double 4000"),
    "faults-inside-double": ("prove", 900, "make -s unit REAL=double && build/host-double/faults 6000"),
    "accuracy-float": ("test", 300, "make -s unit && build/host/accuracy"),
    "link": ("test", 300, f"{PYTHON} tests/check_link.py"),
    "faulty-line": ("test", 120, f"{PYTHON} tests/check_faulty_line.py"),
    "vectors": ("test", 120, f"{PYTHON} tests/vectors/make_vectors.py --check"),
    "boards": ("test", 900, f"{PYTHON} tests/check_targets.py"),
    "images": ("test", 900, f"{PYTHON} tests/check_images.py"),
    "struck-board": ("test", 900, f"{PYTHON} tests/check_struck_board.py"),
    "bench-device": ("test", 300, f"{PYTHON} tests/check_bench_device.py"),
    "bench": ("test", 400, f"{PYTHON} tests/check_bench.py"),
    "rebuilds": ("test", 300, f"{PYTHON} tests/check_rebuilds.py"),
    "accuracy-double": ("test", 300, "make -s unit REAL=double && build/host-double/accuracy"),
    "random": ("prove", 1800, f"make -s build/host/random-stream && {PYTHON} tests/check_random.py"),
    "back-to-back": ("prove", 1800, f"{PYTHON} tests/check_back_to_back.py"),
    "delivered": ("prove", 1800, f"{PYTHON} tests/check_delivered.py"),
    "delivered-suite": ("campaign", 7200, f"{PYTHON} tests/check_delivered.py --suite"),
    "random-batteries": ("campaign", 43200, f"make -s build/host/random-stream && {PYTHON} tests/check_batteries.py"),
    "static-rules": ("prove", 1800, f"{PYTHON} tests/check_rules.py"),
    "sanitizers": ("prove", 2400, f"{PYTHON} tests/check_sanitizers.py"),
    "coverage": ("prove", 1500, f"{PYTHON} tests/check_coverage.py"),
    "board-coverage": ("prove", 600, f"{PYTHON} tests/check_board_coverage.py"),
    "mutants": ("prove", 1500, f"nice -n 10 {PYTHON} tests/mutate.py --mutants 60 --quick"),
    "long-run": ("campaign", 1800, f"{PYTHON} tests/check_use.py long_run"),
    "all-mutants": ("campaign", 36000, f"nice -n 10 {PYTHON} tests/mutate.py --mutants 300"),
    "eva-double": ("campaign", 3000, f"{PYTHON} tests/check_eva.py --double"),
    "eva-rest": ("campaign", 6000, f"{PYTHON} tests/check_eva.py --rest"),
    "eva-rest-double": ("campaign", 9000, f"{PYTHON} tests/check_eva.py --rest --double"),
}
GROUPS = ("test", "prove", "campaign")
FIGURE = re.compile(r"figure: ([^|:]+): ([^|]+)")
TARGETS = sorted(f[:-3] for f in os.listdir(os.path.join(ROOT, "linker")) if f.endswith(".mk") and f != "targets.mk")


def run_gate(name):
    """-> (passed, failed, seconds, rows of figures, its failures and the end of the output)"""
    group, timeout, command = GATES[name]
    start = time.monotonic()
    with subprocess.Popen(command, shell=True, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, start_new_session=True) as gate:
        try:
            output, status = gate.communicate(timeout=timeout)[0], gate.returncode
        except subprocess.TimeoutExpired:
            os.killpg(gate.pid, signal.SIGKILL)   # a gate that hangs takes what it started with it
            output, status = gate.communicate()[0] + f"\nno end after {timeout} s".encode(), 124
    output = output.decode(errors="replace")
    lines = output.strip().splitlines() or [""]
    figures = [FIGURE.fullmatch(line) for line in lines]
    figures = [f"| {f[1]} | {f[2]} | `make {group}`, {name} |" for f in figures if f]
    found = re.fullmatch(r"(?:\w+: )?(\d+) passed, (\d+) failed", lines[-1].strip())
    seconds = time.monotonic() - start
    shown = [line for line in lines[:-25] if line.lstrip().startswith("FAIL")] + lines[-25:]
    if not found or (int(found[2]) == 0) != (status == 0) or int(found[1]) + int(found[2]) == 0:
        return 0, 1, seconds, [], shown + [f"(ended with status {status} and no sound last line)"]
    return int(found[1]), int(found[2]), seconds, [] if int(found[2]) else figures, shown[:-1] if int(found[2]) else []


class Board:
    """Takes gates from a list and prints each when it is done."""

    def __init__(self, names):
        self.names, self.lock = list(names), threading.Lock()
        self.passed = self.failed = 0
        self.figures = {}

    def work(self):
        while True:
            with self.lock:
                if not self.names:
                    return
                name = self.names.pop(0)
            passed, failed, seconds, self.figures[name], tail = run_gate(name)
            with self.lock:
                self.passed += passed
                self.failed += failed
                print(f"{name:26s} {passed:6d} passed, {failed:3d} failed  {seconds:6.1f} s", flush=True)
                for line in tail:
                    print("    " + line, flush=True)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    group, only = (sys.argv[1], []) if sys.argv[1:] in [[g] for g in GROUPS] else (None, sys.argv[1:])
    unknown = [n for n in only if n not in GATES]
    if unknown:
        sys.exit(f"gates: no gate {', '.join(unknown)}; there are: {', '.join(GATES)}")
    names = only or [n for n in GATES if GATES[n][0] == group]
    for real in ("float", "double"):   # built once, before gates that run side by side would build it twice
        for goal in ("all", "unit"):
            subprocess.run(["make", "-s", f"-j{os.cpu_count()}", goal, f"REAL={real}"], cwd=ROOT, check=True)
        for target in [] if only else TARGETS:
            subprocess.run(["make", "-s", f"-j{os.cpu_count()}", f"TARGET={target}", f"REAL={real}"], cwd=ROOT, check=True)
    if {"mpi", "plan"} <= set(names):
        subprocess.run(["make", "-s", f"-j{os.cpu_count()}", "mpi"], cwd=ROOT, check=True)
    board = Board(names)
    workers = [threading.Thread(target=board.work) for _ in range(min(os.cpu_count() or 1, len(names)))]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    rows = [row + "\n" for n in names for row in board.figures[n]]
    if only:
        sys.stdout.writelines(rows)
    else:
        with open(os.path.join(ROOT, "build", f"gates-{group}.md"), "w") as file:
            file.writelines(rows)
    print(f"{board.passed} passed, {board.failed} failed")
    return board.failed != 0


if __name__ == "__main__":
    sys.exit(main())
