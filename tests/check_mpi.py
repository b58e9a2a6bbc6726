#!/usr/bin/env python3
"""check_mpi - ranks: the same files and digests as one process, one result file, a rank that is lost.

usage: tests/check_mpi.py [--float build/host/kelly] [--double build/host-double/kelly] [--mpi KELLY] [NAME...]

Without --mpi, builds and runs build/mpi/kelly (Open MPI). Each claim that fails is one line; the last line is `N passed, N failed`.
"""
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
from programs import PROGRAM, ROOT, chosen, command_line  # noqa: E402

count = {True: 0, False: 0}
CASE = "--mu 0.004 --duration 10"


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return bool(holds)


def environment():
    """mpirun asks root to say twice that it is meant; more ranks than cores are meant too."""
    return dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1")


def mpi_program(given):
    """The one that was given, or that of this tree."""
    PROGRAM["mpi"] = os.path.abspath(given or os.path.join(ROOT, "build/mpi/kelly"))
    if not given:
        subprocess.run(["make", "-s", "mpi"], cwd=ROOT, check=True)


def command(ranks, args):
    return (["mpirun", "-n", str(ranks), PROGRAM["mpi"]] if ranks else [PROGRAM["float"]]) + shlex.split(args)


def kelly(ranks, args, folder):
    """ranks 0: the program without MPI."""
    return subprocess.run(command(ranks, args), capture_output=True, text=True, check=False, timeout=300, cwd=folder, env=environment())


def read(folder, name):
    with open(os.path.join(folder, name), "rb") as file:
        return re.sub(rb'("seconds": )[0-9.]+|("crc32c": )"[0-9a-f]*"', rb"\1\2-", file.read())


def files_of(ranks, args, folder, names):
    for name in names:
        if os.path.exists(os.path.join(folder, name)):
            os.remove(os.path.join(folder, name))
    run = kelly(ranks, args, folder)
    claim(run.returncode == 0 and run.stdout == "", f"{ranks} ranks, {args}: exit {run.returncode}, {run.stderr!r} {run.stdout!r}")
    left = sorted(os.listdir(folder))
    claim(left == sorted(names), f"{ranks} ranks leave {left}")
    return [read(folder, name) for name in names]


def same_files(folder, args, names, ranks=(1, 2, 4)):
    want = files_of(0, args, folder, names)
    for n in ranks:
        got = files_of(n, args, folder, names)
        for name, a, b in zip(names, want, got):
            claim(a == b, f"{n} ranks, {args.split()[0]}: {name} is that of one process")
    for name in names:
        os.remove(os.path.join(folder, name))


def check_montecarlo(folder):
    """1 and 2 threads, 1, 2 and 4 ranks, two splits and merges: the same bytes and digest."""
    args = f"montecarlo {CASE} --samples 17000 --first 3 --csv run.csv --json run.json --quiet"
    same_files(folder, args, ["run.csv", "run.json"])
    digests = {}
    for what, ranks, more in (("1 thread", 0, "--threads 1"), ("2 threads", 0, "--threads 2"), ("1 rank", 1, ""), ("2 ranks", 2, ""), ("4 ranks", 4, ""),
                              ("2 ranks, 2 threads", 2, "--threads 2")):
        found = re.search(r"digest ([0-9a-f]{8})", kelly(ranks, f"montecarlo {CASE} --samples 3000 {more}", folder).stdout)
        digests[what] = found[1] if found else None
    for cut in ((1, 700, 2999), (1500,)):
        ends = [0, *cut, 3000]
        for k, (first, last) in enumerate(zip(ends, ends[1:])):
            kelly(2 * (k % 2), f"montecarlo {CASE} --samples {last - first} --first {first} --csv {k}.csv --json {k}.json --quiet", folder)
        parts = " ".join(f"{k}.csv" for k in reversed(range(len(ends) - 1)))
        run = kelly(0, f"merge {parts} --json all.json --quiet", folder)
        digests[f"cut at {cut}"] = json.loads(read(folder, "all.json").replace(b": -", b": 0"))["digest"] if run.returncode == 0 else run.stderr
    claim(len(set(digests.values())) == 1 and None not in digests.values(), f"one digest: {digests}")
    print(f"figure: one digest, {digests['1 thread']}, of 3000 realisations: {len(digests)} ways ({'; '.join(digests)})", flush=True)
    for name in os.listdir(folder):
        os.remove(os.path.join(folder, name))


def check_more(folder):
    """The convergence function and the envelope beside it."""
    args = f"montecarlo {CASE} --samples 60 --convergence --envelope env.csv --json run.json --quiet"
    same_files(folder, args, ["env.csv", "run.json"], (2,))


def check_map(folder):
    args = f"map {CASE} --rpm 60:140:40 --wob 60:160:50 --samples 150 --csv m.csv --json m.json --npy m.npy --quiet"
    same_files(folder, args, ["m.csv", "m.json", "m.npy"])
    same_files(folder, args + " --adaptive 0.1", ["m.csv", "m.json", "m.npy"], (3,))


def check_rare(folder):
    args = "rare --mu 0.004 --rpm 125 --start rotating --duration 10 --samples-per-level 1000 --json rare.json --quiet"
    same_files(folder, args, ["rare.json"], (1, 2, 4))


def check_others(folder):
    """The other commands that share their work; one that does not prints once."""
    same_files(folder, f"sensitivity {CASE} --samples 70 --json s.json --quiet", ["s.json"], (2,))
    same_files(folder, "advise --mu 0.004 --duration 4 --window 2:4 --samples 50 --search-rpm 90:120 --search-wob 80:110 --json a.json --quiet", ["a.json"], (3,))
    same_files(folder, f"montecarlo {CASE} --until-width 0.1 --json u.json --quiet", ["u.json"], (2,))
    run = kelly(2, "modes", folder)
    claim(run.returncode == 0 and run.stdout == kelly(0, "modes", folder).stdout, f"modes on two ranks: exit {run.returncode}, {run.stderr!r}")


def check_mistakes(folder):
    """One line of kelly's, exit 2, and no hang."""
    run = kelly(2, "montecarlo --samples 0", folder)
    claim(run.returncode == 2 and run.stderr.count("kelly:") == 1, f"a mistake: exit {run.returncode}, {run.stderr!r}")
    run = kelly(2, "montecarlo --samples 10 --csv nowhere/x.csv", folder)
    claim(run.returncode == 1 and run.stderr.count("cannot write") == 1, f"no such directory: exit {run.returncode}, {run.stderr!r}")
    said = [subprocess.run(["mpirun", "-n", str(ranks), PROGRAM["float"], "montecarlo", "--duration", "1", "--samples", "4"], capture_output=True, text=True, check=False, cwd=folder,
                           env=environment()).stderr.count("kelly: this program knows no MPI") for ranks in (1, 2)]
    claim(said == [0, 1], f"the program without MPI under mpirun says so once: {said}")


def ranks_of(parent):
    """Processes that mpirun started, by rank."""
    found = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat", encoding="ascii") as file:
                if int(file.read().rsplit(")", 1)[1].split()[1]) != parent:
                    continue
            with open(f"/proc/{pid}/environ", "rb") as file:
                rank = re.search(rb"OMPI_COMM_WORLD_RANK=(\d+)", file.read())
            if rank:
                found[int(rank[1])] = int(pid)
        except (OSError, ValueError):
            continue
    return found


def check_lost(folder):
    """A rank is killed in mid-run: the run ends with a message and goes on from its journal; any rank, the first too."""
    args = f"montecarlo {CASE} --samples 60000 --csv run.csv --json run.json --quiet"
    want = files_of(0, args, folder, ["run.csv", "run.json"])   # mpirun's message; what rank 0 says beside it is not always passed on
    os.remove(os.path.join(folder, "run.csv"))
    os.remove(os.path.join(folder, "run.json"))
    for victim in (2, 0, 1):
        journal = os.path.join(folder, "run.csv.journal")
        before = os.path.getsize(journal) if os.path.exists(journal) else 0
        with subprocess.Popen(command(3, args + " --resume"), cwd=folder, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True) as run:
            deadline = time.monotonic() + 60
            while (not os.path.exists(journal) or os.path.getsize(journal) < before + 400000) and time.monotonic() < deadline:
                time.sleep(0.01)
            pids = ranks_of(run.pid)
            claim(sorted(pids) == [0, 1, 2], f"ranks under way: {pids}")
            if victim in pids:
                os.kill(pids[victim], signal.SIGKILL)
            said = run.communicate(timeout=60)[1]
        claim(run.returncode != 0 and f"rank {victim}" in said and "signal 9" in said, f"rank {victim} lost: exit {run.returncode}, {said!r}")
        claim(not os.path.exists(os.path.join(folder, "run.csv")), "nothing half-written at the name of the result")
        gone = time.monotonic() + 10
        while any(os.path.exists(f"/proc/{pid}") for pid in pids.values()) and time.monotonic() < gone:
            time.sleep(0.01)
    print("figure: ranks killed in mid-run, each run ended with a message: 3")
    last = kelly(2, args + " --resume", folder)
    claim(last.returncode == 0 and [read(folder, n) for n in ("run.csv", "run.json")] == want, f"resumed on two ranks: {last.stderr!r}")
    claim(sorted(os.listdir(folder)) == ["run.csv", "run.json"], f"what is left: {sorted(os.listdir(folder))}")


def main():
    parser = command_line(__doc__)
    parser.add_argument("--mpi", metavar="KELLY")
    parser.add_argument("names", nargs="*")
    args = chosen(parser)
    mpi_program(args.mpi)
    for name in args.names or [n[6:] for n in globals() if n.startswith("check_")]:
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            globals()["check_" + name](folder)
        print(f"  {name}: {time.monotonic() - start:.1f} s", flush=True)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
