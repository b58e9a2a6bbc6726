#!/usr/bin/env python3
"""check_coverage - lines, branches and MC/DC of firmware/, lines of host/, under the tests of the host.

usage: tests/check_coverage.py [--kernel] [--missed]

A copy of the tree is built by clang with counters, and the tests run in it as they are: the unit tests and lanes in float and
double and the device program as a process (tests/board_here.c) under the scenarios of the bench count for firmware/, the checks below for
host/. firmware/board is registers and start-up, which only a board has: tests/check_board_coverage.py. What cannot be reached is listed with its reason in tests/uncovered.txt,
`FILE | line, true or false | text of the line, or of the condition | reason`: an entry excuses one place, and one that is covered after all, or
fits no line, is a failure.
--kernel leaves the checks of host/ out, --missed shows every place that is not covered. Last line `N passed, N failed`.
"""
import argparse
import collections
import concurrent.futures
import os
import re
import shutil
import subprocess
import sys

import check_bench_device
import coverage_data
from bench_board import Board
from check_board_coverage import ESTIMATES, SCENARIOS
from run_target import ROOT
from run_target import run as run_device

TREE = os.path.join(ROOT, "build", "coverage", "tree")
ONLY_HOST = os.path.join(ROOT, "build", "coverage", "only-host.txt")     # -fprofile-list
PARTS = ("Makefile", "README.md", "firmware", "gen", "host", "linker", "tests")
# What reaches host/ in the least time; the names leave out what repeats lines or writes past a limit of file size.
CHECKS = {
    "cli": "modes golden order replay report cuts refused convergence mistakes help",
    "use": "help options_are_told defaults install quiet progress colour units field",
    "figures": "envelope threads traces refused mistakes streaming",
    "map": "cells same_bytes adaptive edges grids files mistakes torn foreign lock advise picture",
    "whatif": "",
    "until": "",
    "sensitivity": "left_out ends",
    "rare": "bad_usage not_random refusals",
    "merge": "cut misfits",
    "nothing_lost": "order foreign",
    "plan": "",
    "mpi": "more map mistakes",
    "bench": "",
}
LEAST = {"firmware lines": 100.0, "firmware branches": 99.0, "host lines": 90.0}
count = {True: 0, False: 0}


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


def copied():
    """The tree as it is; what was built in an earlier copy stays."""
    os.makedirs(TREE, exist_ok=True)
    for part in PARTS:
        source, target = os.path.join(ROOT, part), os.path.join(TREE, part)
        if os.path.isdir(source):
            shutil.rmtree(target, ignore_errors=True)
            shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(source, target)


def run(name, words, timeout=900):
    """In the copy, with counters of its own; (profile directory, last line)."""
    folder = os.path.join(ROOT, "build", "coverage", name)
    shutil.rmtree(folder, ignore_errors=True)
    environment = {**os.environ, "CC": "clang" + coverage_data.LLVM, "CFLAGS": coverage_data.CFLAGS, "CHECK_LONG": "0",
                   "LLVM_PROFILE_FILE": os.path.join(folder, "%2m.profraw")}
    if name == "build-of-host" or name in CHECKS:                      # the kernel at its full speed
        environment["CFLAGS"] += f" -O2 -fprofile-list={ONLY_HOST}"
    done = subprocess.run(words, cwd=TREE, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, errors="replace", timeout=timeout, check=False)
    lines = done.stdout.strip().splitlines() or [""]
    if name in CHECKS:             # what they claim is the affair of their own gates: lateness, for one, with counters on a busy machine
        claim(re.search(r"\d+ passed, \d+ failed", lines[-1]), f"{name} comes to its end: {lines[-10:]}")
    else:
        claim(done.returncode == 0, f"{name}: status {done.returncode}, {lines[-10:]}")
    return folder


def exclusions():
    """{(file, kind, text of the line): how many such places}"""
    with open(os.path.join(ROOT, "tests", "uncovered.txt"), encoding="utf-8") as file:
        rows = [line.strip() for line in file if line.strip() and not line.startswith("#")]
    found = collections.Counter()
    for row in rows:
        (path, kind, rest), (text, reason) = row.split(" | ", 2), row.split(" | ", 2)[2].rsplit(" | ", 1)
        found[path, kind, text] += 1
        claim(reason and rest and kind in ("line", "true", "false"), f"uncovered.txt: {row}")
    return found


def what(kind, at, text):
    """(kind of an entry, its text) of a place."""
    if kind == "lines":
        return "line", text[at - 1].strip()
    if kind == "branches":
        line, column, last, end, side = at
        return side, text[line - 1][column - 1:end - 1 if last == line else None].strip()
    return "condition", text[at[0] - 1].strip()


def judge(files, folder, excused):
    """{kind: [covered, all, excused]} of the files below a folder, and what was missed."""
    sums, missed, used = collections.defaultdict(lambda: [0, 0, 0]), [], collections.Counter()
    for path in sorted(files):
        if not path.startswith(folder) or "/tables/" in path or path.startswith("firmware/board/"):
            continue
        with open(os.path.join(TREE, path), encoding="utf-8") as source:
            text = source.read().splitlines()
        file = files[path]
        for kind, places in (("lines", file.lines), ("branches", file.branches), ("MC/DC conditions", file.conditions)):
            for at, covered in sorted(places.items(), key=str):
                key = (path, *what(kind, at, text))
                sums[kind][1] += 1
                if covered:
                    sums[kind][0] += 1
                elif used[key] < excused[key]:
                    sums[kind][2] += 1
                    used[key] += 1
                else:
                    missed.append(f"{kind}: {at if kind == 'lines' else at[0]}: {' | '.join(key)}")
    return sums, missed, used


def percent(covered, whole, excused=0):
    return 100.0 * covered / (whole - excused) if whole > excused else 100.0


def host_programs():
    """Profiles and programs of the checks of host/."""
    with open(ONLY_HOST, "w", encoding="ascii") as file:
        file.write("[clang]\nsource:firmware/*=skip\ndefault:allow\n")
    run("build-of-host", ["sh", "-c", "make -s -j2 all && make -s -j2 all REAL=double && make -s -j2 mpi"])
    checks = [run(check, [sys.executable, f"tests/check_{check}.py", *CHECKS[check].split()]) for check in CHECKS]
    return checks, [os.path.join(TREE, "build", d, "kelly") for d in ("host", "host-double", "mpi")]


def unit_programs():
    """Profiles and programs of the tests of the kernel."""
    profiles, programs = [], []
    for suffix, real in (("", "float"), ("-double", "double")):
        run(f"build{suffix}", ["make", "-s", f"-j{os.cpu_count()}", "all", "unit", f"build/host{suffix}/device", f"REAL={real}"])
        for program in ("unit", "lanes", "app-unit"):                  # accuracy reaches nothing more
            programs.append(os.path.join(TREE, f"build/host{suffix}", program))
            profiles.append(run(program + suffix, [programs[-1]]))
    more, others = device_program()
    return [*profiles, *more], [*programs, *others]


class Here(Board):
    """The device program as a process, which writes its counters when its input ends."""

    def __init__(self, *_, **__):
        super().__init__("", words=[os.path.join(TREE, "build", "host", "device")])

    def __exit__(self, *_):
        self.process.stdin.close()
        os.set_blocking(self.process.stdout.fileno(), True)
        self.process.stdout.read()
        self.process.wait()
        self.process.stdout.close()


def scenario(of):
    """What it claims is the affair of check_bench_device.py; here it must come to its end."""
    function, more = of
    try:
        return sum(1 for _ in function(*more)) > 0, function.__name__
    except Exception as why:      # noqa: BLE001  whatever it was, it is told
        return False, f"{function.__name__}: {why!r}"


def of_another_table(program):
    """A copy of the program in which a letter of the table's name is another: its CRC is wrong."""
    with open(program, "rb") as file:
        code = file.read()
    name = re.search(rb"paper-[0-9a-f]{8}\0", code)[0]
    with open(program + "-damaged", "wb") as file:
        file.write(code.replace(name, b"q" + name[1:]))
    shutil.copymode(program, program + "-damaged")
    return program + "-damaged"


def device_program():
    """The device program under the scenarios of the bench, and its console under what was found by fuzzing; (profiles, programs)."""
    folder, program = os.path.join(ROOT, "build", "coverage", "device"), os.path.join(TREE, "build", "host", "device")
    shutil.rmtree(folder, ignore_errors=True)
    check_bench_device.Board, check_bench_device.image = Here, lambda target: program
    os.environ["LLVM_PROFILE_FILE"] = os.path.join(folder, "%p.profraw")
    for line, status in ESTIMATES.items():
        claim(run_device([program], [line])[0] == status, f"estimate, {line}")
    said = subprocess.run(["sh", "-c", '(sleep 0.2; echo) | "$0"; echo $?', of_another_table(program)], capture_output=True, text=True, check=True).stdout
    claim(re.search(r"damaged.*\n1$", said), f"a table that is damaged ends the program: {said}")
    with concurrent.futures.ThreadPoolExecutor(len(SCENARIOS)) as pool:          # they wait most of the time
        for ends, name in pool.map(scenario, SCENARIOS):
            claim(ends, name)
    del os.environ["LLVM_PROFILE_FILE"]
    console = os.path.join(TREE, "build", "fuzz", "console")
    run("build-console", ["make", "-s", f"-j{os.cpu_count()}", "build/fuzz/console", f"FUZZ_CC=clang{coverage_data.LLVM} {coverage_data.CFLAGS}"])
    return [folder, run("console", [console, os.path.join(ROOT, "tests", "fuzz", "corpus", "console"), "-runs=0"])], [program, console]


def measure(name, profiles, programs):
    profile = os.path.join(ROOT, "build", "coverage", name + ".profdata")
    coverage_data.merge(profiles, profile)
    return coverage_data.measured(profile, programs, TREE)


def firmware(profiles, programs, show):
    excused = exclusions()
    sums, missed, used = judge(measure("firmware", profiles, programs), "firmware/", excused)
    for kind, (covered, whole, reasons) in sums.items():
        said = f"figure: coverage of firmware/, {kind}: {covered} of {whole} ({percent(covered, whole):.2f} %)"
        print(said + (f", {reasons} more cannot be reached, by tests/uncovered.txt" if reasons else ""))
    for key in excused - used:
        claim(False, f"uncovered.txt: covered, or no such line: {' | '.join(key)}")
    print(*[m for m in missed if show or m.startswith("lines")], sep="\n")
    for kind in ("lines", "branches"):
        covered, whole, reasons = sums[kind]
        claim(percent(covered, whole, reasons) >= LEAST[f"firmware {kind}"], f"{kind} of firmware/: {covered} and {reasons} with a reason, of {whole}")


def host(profiles, programs, show):
    sums, missed, _ = judge(measure("host", profiles, programs), "host/", collections.Counter())
    covered, whole, _ = sums["lines"]
    print(f"figure: coverage of host/, lines: {covered} of {whole} ({percent(covered, whole):.2f} %)")
    print(*[m for m in missed if show], sep="\n")
    claim(percent(covered, whole) >= LEAST["host lines"], f"lines of host/: {covered} of {whole}")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--kernel", action="store_true")
    parser.add_argument("--missed", action="store_true")
    args = parser.parse_args()
    copied()
    profiles, programs = unit_programs()
    firmware(profiles, programs, args.missed)
    if not args.kernel:
        host(*host_programs(), args.missed)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
