#!/usr/bin/env python3
"""check_twice.py - --twice in every command that runs realisations, on the first and on every other process.

A copy of this tree is built in which every second call of the kernel gets one result wrong, under MPI on the processes besides the first.
With --twice it has to be told, as corrupt. Last line `N passed, N failed`.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
from check_digests import ROOT  # noqa: E402
from check_sanitizers import PLAIN  # noqa: E402

ERRS = """#include <stdlib.h>
int usleep(unsigned us);
static int errs(void)
{
    static unsigned calls;
    const char *const rank = getenv("OMPI_COMM_WORLD_RANK");
    if (rank && rank[0] == '0') {
        usleep(5000);                /* so that the others have something to do */
        return 0;
    }
    return ++calls % 2 == 1;
}
"""
CASE = "--mu 0.004 --duration 2 --window 1:2 --threads 1 --cov 0.2"
COMMANDS = {"montecarlo": "--samples 40", "map": "--samples 40 --rpm 100:120:20 --wob 80", "advise": "--samples 40 --below 0.01",
            "rare": "--samples-per-level 1000", "sensitivity": "--samples 40"}
count = {True: 0, False: 0}


def claim(holds, what):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return holds


def plant(folder):
    """The programs of a copy whose kernel errs: alone, for MPI."""
    for part in ("Makefile", "firmware", "gen", "host", "linker", "tests"):
        where = shutil.copytree if os.path.isdir(os.path.join(ROOT, part)) else shutil.copy
        where(os.path.join(ROOT, part), os.path.join(folder, part))
    path = os.path.join(folder, "firmware", "ensemble.c")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    for call in ("kelly_run(table, run, seed, first, count, results, (kelly_work *)work);", "kelly_run_draws(table, run, draws, count, results, (kelly_work *)work);"):
        claim(text.count(call) == 1, f"an engine calls the kernel by {call}")
        text = text.replace(call, call + " results[0].stuck ^= errs();")
    with open(path, "w", encoding="utf-8") as file:
        file.write(ERRS + text)
    for words in (["all"], ["mpi"]):
        subprocess.run(["make", "-s", f"-j{os.cpu_count()}", *PLAIN, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL)
    return [os.path.join(folder, "build", "host", "kelly")], ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", "3", os.path.join(folder, "build", "mpi", "kelly")]


def run(program, folder, words):
    done = subprocess.run([*program, *words.split()], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def check_told(programs, folder):
    for program in programs:
        for command, args in COMMANDS.items():
            name = f"{os.path.basename(program[0])} {command}"
            status, said, wrong = run(program, folder, f"{command} {args} {CASE} --twice --json - --engine scalar")
            claim(re.search(r'\[\d+, "corrupt"\]', said) if status == 0 else status == 1 and "a number in memory changed" in wrong,
                  f"{name} --twice: status {status}: {said[-200:]} {wrong[-300:]}")
            status, said, wrong = run(program, folder, f"{command} {args} {CASE} --json - --engine scalar")
            claim((status == 0 or command == "rare") and "corrupt" not in wrong + said.replace('"corrupt": 0', ""),
                  f"{name}: without it nobody would know: status {status}: {wrong[-300:]}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        programs = plant(folder)
        check_told(programs, folder)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
