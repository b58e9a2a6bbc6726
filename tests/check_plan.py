#!/usr/bin/env python3
"""check_plan - kelly plan: the simulated run against what can be told on paper; figures measured between ranks.

usage: tests/check_plan.py [--float build/host/kelly] [--double build/host-double/kelly] [--mpi KELLY] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. No claim is about how fast this machine is.
"""
import json
import os
import resource
import shlex
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from check_mpi import claim, command, count, environment, mpi_program  # noqa: E402
from programs import chosen, command_line  # noqa: E402

CASE = "--mu 0.004 --duration 10"


def plan(args, ranks=0):
    run = subprocess.run(command(ranks, f"plan --measure 0.2 {args} --json -"), capture_output=True, text=True, check=False, timeout=300, env=environment())
    return json.loads(run.stdout) if claim(run.returncode == 0 and run.stderr == "", f"plan {args}: exit {run.returncode}, {run.stderr!r}") else None


def check_rows():
    """Every number of cores; no work is lost or done twice; where the limits are known."""
    p = plan(f"{CASE} --samples 1000000000 --cores 10000")
    claim([r["cores"] for r in p["rows"]] == [1, 10, 100, 1000, 10000], "rows")
    for r in p["rows"]:
        claim(0 < r["efficiency"] <= 1.001 and r["simulated_s"] > 0.97 * r["paper_s"], f"{r}")
        claim(r["array_s"] <= 1.02 * r["simulated_s"] and r["runs"] * 64 >= r["cores"], f"{r}")
        claim(1e6 < r["first_bytes"] <= r["all_bytes"] < 1e12, f"{r}")
    one, ten = p["rows"][:2]
    claim(abs(one["simulated_s"] / (1e9 / p["rate"] + 1e9 * p["leader_s"]) - 1) < 0.1, f"one core: {one}")
    claim(abs(ten["simulated_s"] / ten["paper_s"] - 1) < 0.15, f"ten cores, on paper and simulated: {ten}")
    claim([r["cores"] for r in plan(f"{CASE} --samples 1000 --cores 64")["rows"]] == [1, 10, 64], "the last row is the number that was asked for")


def check_limits():
    """A slow leader and a long start decide, as on paper."""
    row = plan(f"{CASE} --samples 10000000 --cores 1000 --message 100000")["rows"][-1]
    ends = 5 * 2 * 2 * 1000 * 0.1                        # in each of five batches every rank's two errands are given, and taken back
    claim(row["paper_s"] < row["simulated_s"] < row["paper_s"] + 1.2 * ends and row["simulated_s"] > 0.8 * ends, f"a slow leader decides: {row}")
    row = plan(f"{CASE} --samples 1000 --cores 64 --startup 500")["rows"][-1]
    claim(500 < row["simulated_s"] < 503, f"start-up: {row}")
    few, many = (plan(f"{CASE} --samples 1000000 --cores 1 --lines {lines}")["leader_s"] for lines in ("no", "yes"))
    claim(0 < few < many, f"lines cost the leader time: {few}, {many}")


def check_many():
    """A million cores, an errand a realisation: of a long batch the beginning is simulated, and what it tells holds for all. In minutes of a
    processor, where each errand would take an hour."""
    soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (120, hard))     # of each process from here on
    p = plan(f"{CASE} --engine scalar --samples 4294967295 --cores 1000000 --message 0.1 --way 1")
    resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))
    for r in (p or {"rows": []})["rows"][2:]:
        worked = r["efficiency"] * r["cores"] * r["simulated_s"]
        claim(abs(worked / (4294967295 / p["rate"]) - 1) < 0.02 + 1e-6 / r["efficiency"], f"all of the work is in it: {worked}, {r}, {p['rate']}")
        claim(0.98 < r["simulated_s"] / r["paper_s"] < 1.1, f"as on paper: {r}")


def check_measured():
    """Under mpirun start-up and messages are measured, and what is given is taken instead."""
    p = plan(f"{CASE} --samples 1000000 --cores 100", 2)
    mpi = p["mpi"]
    claim(mpi["measured"] and 0 < mpi["startup_s"] < 250 and 1e-7 < mpi["message_s"] < 1e-2 and 0 < mpi["way_s"] < 1 and mpi["process_bytes"] > 0, f"{mpi}")
    given = plan(f"{CASE} --samples 1000000 --cores 10 --startup 3 --message 7 --way 11", 2)["mpi"]
    claim([given[k] for k in ("startup_s", "message_s", "way_s")] == [3, 7e-6, 1.1e-5], f"{given}")
    claim(not plan(f"{CASE} --samples 1000 --cores 10")["mpi"]["measured"], "alone they are assumed")


def check_mistakes():
    for bad in ("--samples 0", "--cores 0", "--cores 2000000", "--message -1", "--way nan", "--lines maybe", "--measure 0", "--threads 2", "--csv x"):
        run = subprocess.run(command(0, f"plan {bad}"), capture_output=True, text=True, check=False)
        claim(run.returncode == 2 and run.stderr.count("\n") == 1, f"plan {shlex.quote(bad)} is refused: {run.stderr!r}")


def main():
    parser = command_line(__doc__)
    parser.add_argument("--mpi", metavar="KELLY")
    parser.add_argument("names", nargs="*")
    args = chosen(parser)
    mpi_program(args.mpi)
    for name in args.names or [n[6:] for n in globals() if n.startswith("check_")]:
        globals()["check_" + name]()
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
