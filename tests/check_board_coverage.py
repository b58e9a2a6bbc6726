#!/usr/bin/env python3
"""check_board_coverage - lines of firmware/ that run on an emulated Cortex-M4F: the unit tests, and the device program on the bench.

usage: tests/check_board_coverage.py [--missed]

The images are those that are flashed, at -O2 with line numbers. QEMU writes down the instructions that it translates, which it
does when it comes to them; `objdump -dl` says which line each is of. A line counts as run when any of its instructions
was. Lines of all objects count, those too that no image needs. Last line `N passed, N failed`.
"""
import concurrent.futures
import os
import re
import subprocess
import sys
import tempfile

import check_bench_device as bench
from bench_board import Board
from check_on_targets import test_names
from run_target import ROOT, command, counting, run, target_settings

TARGET = "mps2-an386"
OUT = os.path.join(ROOT, "build", TARGET)
OBJDUMP = target_settings(TARGET)["CROSS"] + "objdump"
LEAST = {"kernel": 99.0, "app": 95.0, "board": 85.0}        # in percent; -O2 leaves lines whose instructions stand elsewhere
PARTS = {"kernel": lambda path: re.match(r"firmware/(link/)?\w+\.[ch]$", path), "app": lambda path: path.startswith("firmware/app/"),
         "board": lambda path: re.match(r"firmware/board/(cortexm/|mps/)?\w+\.[ch]$", path)}
ONE = (TARGET,)
SCENARIOS = ((bench.says_who_it_is, ONE), (bench.runs_a_campaign, ONE), (bench.runs_a_campaign, (TARGET, 4, True)), (bench.refuses, ONE),
             (bench.bears_any_frame, (TARGET, 300)), (bench.takes_commands, ONE), (bench.talks_to_people, ONE), (bench.watches_the_host, ONE),
             (bench.survives, (TARGET, 1 << 16)), (bench.steps_together, ((TARGET, TARGET),)), (bench.counts_overloads, ONE), (bench.bites, ONE))
ESTIMATES = {"samples=2 seconds=1": 0, "digest=1 samples=2 seconds=1": 0, "mu_e6=4000 samples=6 seconds=2 from=1": 0, "mu_e6=1000000000 samples=1 seconds=1": 0,
             "count=1": 0, "samples=none": 2, "seconds=4000001": 1, "first=4294967295 samples=2": 1,
             "mu_e6=4294967297": 2, "seed=1 seed=2": 2, "first=18446744073709551615": 2, "samples=18446744073709551614 first=4": 2,
             "samples=2 seconds=8 from=4000000": 1, "from=3 seconds=0": 1}     # line: status


def lines_of(path):
    """{address: (file below the root, line)} of the instructions in an image or object."""
    text = subprocess.run([OBJDUMP, "-dl", "--no-show-raw-insn", path], capture_output=True, text=True, check=True).stdout
    found, place = {}, None
    for row in text.splitlines():
        named = re.match(r"(/\S+):(\d+)", row)
        code = re.match(r" *([0-9a-f]+):\t", row)
        if named:
            place = os.path.relpath(os.path.normpath(named[1]), ROOT), int(named[2])
        elif code and place:
            found[len(found) if path.endswith(".o") else int(code[1], 16)] = place
    return found


def run_lines(elf, log):
    """{(file, line)} of the instructions in a log."""
    with open(log, encoding="utf-8", errors="replace") as file:
        seen = {int(m[1], 16) for m in re.finditer(r"^0x([0-9a-f]+):", file.read(), re.M)}
    table = lines_of(elf)
    return {table[address] for address in seen if address in table}


def unit(folder, name):
    elf, log = os.path.join(OUT, name + ".elf"), os.path.join(folder, name)
    status, _ = run(command(target_settings(TARGET), elf, None, ("-d", "in_asm", "-D", log)), timeout=300)
    return elf, log, status == 0, name


def board_alone(folder, elf):
    """hello and the faults: what they must say is the affair of check_targets.py."""
    log = os.path.join(folder, os.path.basename(elf))
    run(command(target_settings(TARGET), elf, counting(target_settings(TARGET)), ("-d", "in_asm", "-D", log)), ["hello", ""], timeout=60)
    return elf, log, os.path.exists(log), elf


def estimate(folder, line):
    elf, log = os.path.join(OUT, "device.elf"), os.path.join(folder, line.replace(" ", "_"))
    words = command(target_settings(TARGET), elf, counting(target_settings(TARGET)), ("-d", "in_asm", "-D", log))
    return elf, log, run(words, [line], timeout=200)[0] == ESTIMATES[line], "estimate, " + line


def scenario(number):
    """That it comes to its end; its claims are the affair of check_bench_device.py. The logs are those of its boards."""
    function, more = SCENARIOS[number]
    try:
        return sum(1 for _ in function(*more)) > 0, function.__name__
    except Exception as why:      # noqa: BLE001  whatever it was, it is told
        return False, f"{function.__name__}: {why}"


def report(done, show):
    """The lines that ran, of those that there are; (passed, failed)"""
    ran, there, right, wrong = set(), set(), 0, 0
    for elf, log, good, what in done:
        right, wrong = right + good, wrong + (not good)
        if not good:
            print(f"FAIL {what}")
        ran |= run_lines(elf, log)
    for folder, _, names in os.walk(os.path.join(OUT, "firmware")):
        for name in names:
            if name.endswith(".o"):
                there |= set(lines_of(os.path.join(folder, name)).values())
    for part, fits in PARTS.items():
        lines = sorted(place for place in there if fits(place[0]))
        missed = [place for place in lines if place not in ran]
        share = 100.0 * (len(lines) - len(missed)) / len(lines)
        print(f"figure: lines of firmware/ ({part}) run on {TARGET}: {len(lines) - len(missed)} of {len(lines)} ({share:.2f} %)")
        right, wrong = right + (share >= LEAST[part]), wrong + (share < LEAST[part])
        if show or share < LEAST[part]:
            print(*(f"  not run: {file}:{line}" for file, line in missed), sep="\n")
    return right, wrong


def main():
    show = "--missed" in sys.argv[1:]
    subprocess.run(["make", "-s", f"TARGET={TARGET}", "device", "one-tests", "hello", "faults"], cwd=ROOT, check=True, stdin=subprocess.DEVNULL)
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        logs = iter(range(1000))
        bench.Board = lambda target, real="float", icount=None: Board(target, real, icount, extra=("-d", "in_asm", "-D", f"{folder}/bench{next(logs)}"))
        done = list(pool.map(lambda name: unit(folder, name), test_names()))
        faults = os.path.join(OUT, "faults")
        alone = [os.path.join(OUT, "hello.elf"), *(os.path.join(faults, f) for f in sorted(os.listdir(faults)) if f.endswith(".elf"))]
        done += [*pool.map(lambda line: estimate(folder, line), ESTIMATES), *pool.map(lambda elf: board_alone(folder, elf), alone)]
        claims = list(pool.map(scenario, range(len(SCENARIOS))))
        done += [(os.path.join(OUT, "device.elf"), os.path.join(folder, n), True, "") for n in os.listdir(folder) if n.startswith("bench")]
        passed, failed = report(done, show)
    for good, what in claims:
        if not good:
            print("FAIL " + what)
    print(f"{passed + sum(good for good, _ in claims)} passed, {failed + sum(not good for good, _ in claims)} failed")
    return failed + sum(not good for good, _ in claims) != 0


if __name__ == "__main__":
    sys.exit(main())
