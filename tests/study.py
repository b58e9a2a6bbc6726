#!/usr/bin/env python3
"""study.py - the report of `make study`: small probabilities, sensitivity, what-ifs, stopping, runs beyond one machine.

usage: tests/study.py REPORT.md [SECTION...]

Every section of the report is a sentence, the commands that ran, and what they printed, nothing else. The checks that a command
makes on the way count: where one fails the report is still written, and this ends with 1. Some ten minutes on two cores.
"""
import functools
import os
import platform
import re
import subprocess
import sys
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
KELLY = "build/host/kelly"
PYTHON = sys.executable

# name: (title, what it is, [(command, the lines of its output that are shown, or a file of Markdown that it writes)])
SECTIONS = {
    "rare": (
        "Small probabilities",
        "Subset simulation beside references of plain Monte Carlo; `plain` is the number of realisations that plain Monte Carlo takes for the same "
        "spread, `gain` that over the number taken here.",
        [(f"{PYTHON} tests/check_rare.py --study", os.path.join("build", "study-rare.md"))]),
    "sensitivity": (
        "Which parameter the answer hangs on",
        "Sobol indices of P and of the severity; the estimators on Ishigami's function, 200 000 rows of seed 1, and how many of the 3000 "
        "intervals of 500 repetitions (640 rows, seeds 10 to 509) hold its indices.",
        [(f"{KELLY} sensitivity --mu 0.004 --samples 1000 --seed 1", r".*"), (f"{KELLY} sensitivity --mu 0.004 --start rotating --samples 1000 --seed 1", r".*"),
         ("build/host/unit", r".*Ishigami.*")]),
    "whatif": (
        "What if the laws were others",
        "A run of seed 1 on file, reweighted to other laws, beside a fresh run of seed 4711 with these laws; then 40 runs (seeds 100 to 139) "
        "whose reweighted intervals should hold what 40 000 fresh realisations give (seed 5), and repetitions of the estimator alone.",
        [(f"{PYTHON} tests/check_whatif.py", r"(--|P = ).*"), ("build/host/unit", r" *mean .*intervals hold P")]),
    "stopping": (
        "Stopping when it is decided",
        "How often the interval, looked at after every realisation, ever misses P (1000 repetitions of 2000 realisations, seed 2026; 50 are allowed), "
        "and 100 runs of the model (seeds 0 to 99) that stopped by themselves.",
        [("build/host/unit", r" *P .*outside at any n.*"), (f"{PYTHON} tests/check_until.py", r"P = .*")]),
    "machines": (
        "Beyond one machine",
        "One digest whatever computes it; a rank killed; two ranks against one; 1e9 realisations on more cores than there are here, on paper and simulated.",
        [(f"{PYTHON} tests/check_mpi.py", r"figure: .*"), (f"{PYTHON} tests/mpi_efficiency.py", r".*"),
         ("mpirun -n 2 --allow-run-as-root --oversubscribe build/mpi/kelly plan --mu 0.004", r".*")]),
    "lost": (
        "Nothing lost",
        "Runs that were killed, or failed at a call, or whose journal was cut, and that --resume brought to the files of an uninterrupted run, "
        "byte for byte but for the seconds they took.",
        [(f"{PYTHON} tests/check_nothing_lost.py", r"figure: .*")]),
}


@functools.cache
def output(command):
    """-> (what it prints, its status, seconds); once, however many sections show a part of it."""
    start = time.monotonic()
    done = subprocess.run(command, shell=True, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    return done.stdout, done.returncode, time.monotonic() - start


def run(command, shown):
    """-> (text of the report, whether it ended well). Seconds are shown: a reader wants to know what an answer costs."""
    text, status, seconds = output(command)
    lines = [line for line in text.splitlines() if (status and line.startswith("FAIL")) or (not shown.endswith(".md") and re.fullmatch(shown, line))]
    said = "".join(f"    {line.removeprefix('figure: ')}\n" for line in lines)
    if shown.endswith(".md"):
        with open(os.path.join(ROOT, shown), encoding="utf-8") as file:
            said = file.read() + said
    name = command.replace(PYTHON + " ", "")
    return f"`{name}` ({seconds:.0f} s{f', FAILED with status {status}' if status else ''})\n\n{said}\n", status == 0


def machine():
    names = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo", encoding="utf-8", errors="replace") if line.startswith("model name")]
    commit = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores; commit {commit or 'unknown'}; {time.strftime('%Y-%m-%d')}"


def main():
    if len(sys.argv) < 2 or set(sys.argv[2:]) - set(SECTIONS):
        sys.exit(__doc__)
    well, start = True, time.monotonic()
    report = [f"# What kelly says of itself\n\n{machine()}\n\n"]
    for name in sys.argv[2:] or SECTIONS:
        title, about, commands = SECTIONS[name]
        report.append(f"## {title}\n\n{about}\n\n")
        for command, shown in commands:
            text, ended = run(command, shown)
            report.append(text)
            well = well and ended
            print(text, end="", flush=True)
    report.append(f"All of it: {(time.monotonic() - start) / 60:.1f} minutes.\n")
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.writelines(report)
    print(f"{sys.argv[1]} is written, {(time.monotonic() - start) / 60:.1f} minutes")
    return not well


if __name__ == "__main__":
    sys.exit(main())
