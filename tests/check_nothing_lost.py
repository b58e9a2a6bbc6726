#!/usr/bin/env python3
"""check_nothing_lost - a run that was killed, torn or starved goes on with --resume and ends as one that was left alone, byte for byte.

usage: tests/check_nothing_lost.py [--float build/host/kelly] [--double build/host-double/kelly] [--kills N] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. NAME picks single checks.
"""
import math
import os
import random
import re
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from programs import PROGRAM, ROOT, chosen, command_line  # noqa: E402
from second_opinion import crc32c  # noqa: E402

count = {True: 0, False: 0}
HEADER, RECORD = 96, 48                      # bytes of a journal in float
SEED = 20261122                              # of the times of the kills
CASE = "--mu 0.004 --duration 8 --window 4:8"
SMALL = f"montecarlo {CASE} --samples 20 --first 5"
PIECES = f"montecarlo {CASE} --samples 300 --engine sse2 --threads 2" if os.uname().machine == "x86_64" else f"montecarlo {CASE} --samples 300 --threads 2"
LOCK = threading.Lock()
FIGURES = {}
CALLS = ("write", "sync", "rename", "unlink", "truncate")


def claim(holds, what):
    with LOCK:
        count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return bool(holds)


def kelly(args, real="float", fault=None, counted=None):
    env = dict(os.environ)
    if fault:
        env.update(LD_PRELOAD=PROGRAM["shim"], KELLY_FAULT=fault)
    if counted:
        env.update(KELLY_FAULT_COUNT=counted)
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=120, env=env)


def read(path):
    with open(path, "rb") as file:
        return file.read()


def write(path, data):
    with open(path, "wb") as file:
        file.write(data)


def timeless(report):
    return re.sub(rb'"seconds": [0-9.]+|"crc32c": "[0-9a-f]*"', b"", report)


class Place:
    """A directory with the outputs of one run."""

    def __init__(self, folder, name):
        self.folder = os.path.join(folder, name)
        self.csv, self.json = os.path.join(self.folder, "run.csv"), os.path.join(self.folder, "run.json")
        self.journal = self.csv + ".journal"
        self.empty()

    def empty(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        os.mkdir(self.folder)

    def args(self, run):
        return f"{run} --csv {self.csv} --json {self.json} --quiet"

    def run(self, run, **more):
        return kelly(self.args(run), **more)

    def files(self):
        return sorted(os.listdir(self.folder))

    def results(self):
        """All that must be the same: every byte but those of the seconds, and of the CRC over them."""
        if self.files() != ["run.csv", "run.json"]:
            return self.files()
        return read(self.csv), timeless(read(self.json))

    def alone(self, run, real="float"):
        done = self.run(run, real=real)
        claim(done.returncode == 0 and done.stderr == "", f"alone: exit {done.returncode}, {done.stderr!r}")
        return self.results()


def resumed(place, run, want, what, whole=False, real="float"):
    """Go on, as the one that was left alone has ended; `whole`: with nothing to be dropped."""
    again = place.run(run + " --resume", real=real)
    good = again.returncode == 0 and place.results() == want and (not whole or "dropped" not in again.stderr)
    return claim(good, f"{what}: after --resume exit {again.returncode}, {again.stderr!r}, files {place.files()}"), again.stderr


# ---- kill -9

def check_kills(folder):
    """kill -9 at random times, and again while it resumes."""
    run = f"montecarlo {CASE} --samples 2000"
    place, draws, kills, seen = Place(folder, "kills"), random.Random(SEED), 0, {}
    start = time.monotonic()
    want = place.alone(run)
    span = 1.2 * (time.monotonic() - start)
    place.empty()
    while kills < PROGRAM["kills"]:
        process = subprocess.Popen([PROGRAM["float"]] + shlex.split(place.args(f"{run} --resume --threads {draws.choice((1, 2, 3))}")),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(draws.random() * span * draws.choice((0.3, 0.8)))
        process.kill()
        said = process.communicate()[1]
        ended = process.returncode == 0
        kills += not ended
        stage = "done" if ended else ",".join(f[4:] for f in place.files())
        seen[stage] = seen.get(stage, 0) + 1
        if not claim(process.returncode in (0, -9), f"kill {kills}: exit {process.returncode}, {said!r}"):
            return
        if ended or draws.random() < 0.3:
            if not resumed(place, run, want, f"kill {kills}")[0]:
                return
            place.empty()
    resumed(place, run, want, "the last kill")
    print(f"    {kills} kills, what lay there: " + "; ".join(f"{n} x {stage or 'nothing'}" for stage, n in sorted(seen.items())), flush=True)
    FIGURES["kill -9 at random times, survived"] = kills


# ---- a disk that fails

def check_faults(folder):
    """Killed before, within and after every write, sync, rename, unlink and truncate; a full disk and a broken one from every call on."""
    place, total = Place(folder, "faults"), 0
    want = place.alone(PIECES)
    counted = os.path.join(folder, "counted")
    place.empty()
    done = place.run(PIECES, fault="any:1000000:kill", counted=counted)
    calls = int(read(counted))
    claim(done.returncode == 0 and place.results() == want and calls > 15, f"the shim alone changes nothing: {calls} calls, {done.stderr!r}")
    for how in ("kill", "torn", "enospc", "eio"):
        for n in range(1, calls + 1):
            place.empty()
            hit = place.run(PIECES, fault=f"any:{n}:{how}")
            if how in ("kill", "torn"):
                claim(hit.returncode == -9, f"any:{n}:{how}: killed, exit {hit.returncode}")
            else:
                claim(hit.returncode == 1 and hit.stderr.startswith("kelly: ") and hit.stderr.count("\n") == 1,
                      f"any:{n}:{how}: exit {hit.returncode}, {hit.stderr!r}")
            claim(n < 5 or place.results() == want or os.path.exists(place.journal), f"any:{n}:{how}: work is lost, {place.files()}")
            resumed(place, PIECES, want, f"any:{n}:{how}")
            total += 1
    # one kind of call alone fails: each failure is an error, and none is passed over
    for kind in CALLS:
        for n in range(1, calls):
            place.empty()
            hit = place.run(PIECES, fault=f"{kind}:{n}:eio", counted=counted)
            if int(read(counted)) < n:
                claim(hit.returncode == 0 and n > 1, f"{kind}: {n - 1} calls")
                break
            claim(hit.returncode == 1, f"{kind}:{n}:eio: exit {hit.returncode}")
            resumed(place, PIECES, want, f"{kind}:{n}:eio")
            total += 1
    # and once more while it resumes: what the first fault left meets a second one
    for n in range(1, calls + 1):
        place.empty()
        place.run(PIECES, fault="write:3:torn")
        place.run(PIECES + " --resume", fault=f"any:{n}:torn")
        resumed(place, PIECES, want, f"torn twice, {n}")
        total += 1
    FIGURES["aborts, ENOSPC and EIO at a write, sync, rename, unlink or truncate, survived"] = total


def check_full(folder):
    """A disk that is really full."""
    place = Place(folder, "full")
    want = place.alone(PIECES)
    room = os.path.join(folder, "small")
    os.mkdir(room)
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "none", room], capture_output=True, check=False).returncode != 0:
        return   # not allowed here; the shim has tried the same
    try:
        args = f"{PIECES} --csv {room}/run.csv --json {room}/run.json --quiet"
        first = kelly(args)
        claim(first.returncode == 1 and "No space left" in first.stderr, f"full: exit {first.returncode}, {first.stderr!r}")
        subprocess.run(["mount", "-o", "remount,size=1m", room], capture_output=True, check=False)
        claim(kelly(args + " --resume").returncode == 0 and read(f"{room}/run.csv") == want[0], "with room again it goes on")
    finally:
        subprocess.run(["umount", room], capture_output=True, check=False)


# ---- a journal that is cut or changed

def whole_journal(place, run, real="float"):
    """The journal of a run killed just before it would have removed it."""
    place.empty()
    place.run(run, fault="unlink:1:kill", real=real)
    return read(place.journal)


def records(journal):
    return [journal[at:at + RECORD] for at in range(HEADER, len(journal), RECORD)]


def only(place, journal):
    place.empty()
    write(place.journal, journal)


def check_truncated(folder):
    """Cut at every byte; a bit changed in every record."""
    place = Place(folder, "cut")
    want = place.alone(SMALL)
    journal = whole_journal(place, SMALL)
    claim(len(journal) == HEADER + 20 * RECORD, f"a record a realisation: {len(journal)} bytes")
    claim(journal[:8] == b"KELLYJNL" and crc32c(journal[:92]) == struct.unpack("<I", journal[92:96])[0], "header: magic and CRC-32C")
    for at in range(HEADER, len(journal), RECORD):
        claim(crc32c(journal[at:at + RECORD - 4]) == struct.unpack("<I", journal[at + RECORD - 4:at + RECORD])[0], f"CRC-32C of the record at {at}")
    for cut in range(len(journal) + 1):
        only(place, journal[:cut])
        whole = cut == 0 or (cut >= HEADER and (cut - HEADER) % RECORD == 0)
        said = resumed(place, SMALL, want, f"cut to {cut} bytes", whole=whole)[1]
        claim(whole or "torn" in said, f"cut to {cut} bytes: {said!r}")
        number = (cut - HEADER) // RECORD
        starts = "starts from its beginning" in said if cut == 0 else f"goes on from {number} record{'s' * (number != 1)}\n" in said if cut >= HEADER else "torn header" in said
        claim(starts, f"cut to {cut} bytes, where it goes on: {said!r}")
    FIGURES["truncations of a journal, one at every byte, survived"] = len(journal) + 1
    # what is appended behind a torn tail is sound: a second interruption finds all of it
    for cut in (50, HEADER + 20, HEADER + 5 * RECORD + 11, len(journal) - 1):
        only(place, journal[:cut])
        place.run(SMALL + " --resume", fault="unlink:1:kill")
        again = read(place.journal) if os.path.exists(place.journal) else b""
        claim(sorted(records(again)) == sorted(records(journal)) and again[:HEADER] == journal[:HEADER], f"cut to {cut} bytes and interrupted again: {len(again)} bytes")
    for k in range(20):
        bad = bytearray(journal)
        bad[HEADER + k * RECORD + (7 * k) % RECORD] ^= 1 << k % 8
        only(place, bytes(bad))
        claim("torn" in resumed(place, SMALL, want, f"a bit of record {k} changed")[1], f"a bit of record {k} changed, and said")


def forged(journal):
    """With another result in record 4, and its right CRC: who uses it comes to other files."""
    record = bytearray(records(journal)[4])
    record[24] ^= 1                          # the lowest bit speed
    record[-4:] = struct.pack("<I", crc32c(bytes(record[:-4])))
    return journal[:HEADER + 4 * RECORD] + bytes(record) + journal[HEADER + 5 * RECORD:]


def check_order(folder):
    """Records that are out of their place, twice there or left out are dropped with all behind them, and run again."""
    place, draws = Place(folder, "order"), random.Random(1)
    want = place.alone(SMALL)
    journal = whole_journal(place, SMALL)
    for k in range(10):
        some = draws.sample(records(journal), draws.randrange(2, 21))
        some = some if some != records(journal)[:len(some)] else some[::-1]
        only(place, journal[:HEADER] + b"".join(some))
        claim("torn" in resumed(place, SMALL, want, f"order {k}")[1], f"order {k}: said")
    for bad in (records(journal)[:7] + records(journal)[8:], records(journal)[:7] + records(journal)[6:]):
        only(place, journal[:HEADER] + b"".join(bad))
        claim("torn" in resumed(place, SMALL, want, "a record left out, or twice there")[1], "a record left out, or twice there: said")
    for at, value in ((40, b"\xc8"), (40, b"\x05"), (41, b"\x02"), (42, b"\x02"), (36, struct.pack("<f", math.nan)), (24, struct.pack("<f", math.inf))):
        bad = bytearray(records(journal)[7])
        bad[at:at + len(value)] = value
        bad[-4:] = struct.pack("<I", crc32c(bytes(bad[:-4])))
        only(place, journal[:HEADER + 7 * RECORD] + bytes(bad) + journal[HEADER + 8 * RECORD:])
        claim("torn" in resumed(place, SMALL, want, f"what cannot be at {at}")[1], f"what cannot be at {at}: said")
    bad = bytearray(records(journal)[7])
    bad[24:43] = bytes(16) + b"\4\0\0"      # corrupt, as an engine gives it: it stays, and so does what is behind it
    bad[-4:] = struct.pack("<I", crc32c(bytes(bad[:-4])))
    only(place, journal[:HEADER + 7 * RECORD] + bytes(bad) + journal[HEADER + 8 * RECORD:])
    again = place.run(SMALL + " --resume")
    claim("goes on from 20 records" in again.stderr and "torn" not in again.stderr and b'"corrupt": 1' in read(place.csv.replace(".csv", ".json")), f"a corrupt one: {again.stderr!r}")
    only(place, forged(journal))
    place.run(SMALL + " --resume")
    claim(place.results() != want, "what the journal holds is not run again")


# ---- the other long commands

def check_commands(folder):
    """All commands that keep a journal: killed within the first and last calls, and every sixth between; each goes on. What ran once is no part of
    a run with --twice, and a record that cannot be, with its right CRC, is run again."""
    done = 0
    for name, run, outputs in (
            ("sensitivity", f"sensitivity {CASE} --samples 70 --threads 2 --engine scalar", ("json",)),
            ("until", f"montecarlo {CASE} --until-width 0.2 --threads 2", ("csv", "json")),
            ("convergence", "montecarlo --mu 0.004 --duration 1 --window 0:1 --samples 9 --convergence --threads 2", ("json",)),
            ("envelope", "montecarlo --mu 0.004 --duration 2 --window 0:1 --samples 23 --threads 2 --out-step 0.1", ("envelope.npy", "traces.npy")),
            ("advise", "advise --mu 0.004 --duration 1 --window 0:1 --samples 20 --search-rpm 80:120 --search-wob 80:120", ("json",)),
            ("rare", "rare --mu 0.004 --rpm 125 --start rotating --duration 10 --samples-per-level 1000 --threads 2", ("json",)),
            ("map", "map --mu 0.004 --duration 1 --window 0:1 --samples 20 --rpm 80:120:40 --wob 80:120:40", ("csv", "json", "npy"))):
        place = Place(folder, name)
        counted = os.path.join(folder, name + ".counted")
        args = f"{run} " + " ".join(f"--{kind.split('.')[0]} {place.folder}/run.{kind}" for kind in outputs) + " --quiet"
        want_files = sorted(f"run.{kind}" for kind in outputs)

        def results():
            return place.files() == want_files and [timeless(read(f"{place.folder}/{f}")) for f in want_files]

        claim(kelly(args, fault="any:1000000:kill", counted=counted).returncode == 0, f"{name}: ends")
        want, calls = results(), int(read(counted))
        claim(want and calls > 8, f"{name}: {calls} calls")
        for n in sorted({*range(1, 6), *range(6, calls, 6), *range(max(1, calls - 8), calls + 1)}):
            place.empty()
            hit = kelly(args, fault=f"any:{n}:torn")
            lay = place.files()
            again = kelly(args + " --resume")
            claim(hit.returncode == -9 and again.returncode == 0 and results() == want,
                  f"{name} torn at {n}: exit {hit.returncode}, left {lay}; then {again.returncode}, {again.stderr!r}, {place.files()}")
            done += 1
        place.empty()
        kelly(args, fault="unlink:1:kill")
        name_of = next(f"{place.folder}/{f}" for f in place.files() if f.endswith(".journal"))
        journal = read(name_of)
        place.empty()
        write(name_of, journal)
        other = kelly(args + " --twice --resume")
        claim(other.returncode == 2 and "with --twice and without" in other.stderr and read(name_of) == journal, f"{name}, --twice: {other.returncode}, {other.stderr!r}")
        size = struct.unpack("<I", journal[16:20])[0]
        for value in (b"\xff" * size, struct.pack("<d", -1), struct.pack("<d", math.inf)) if name == "convergence" else (b"\xff" * size, b"\x02" * size):
            bad = journal[HEADER:HEADER + 4] + value
            place.empty()
            write(name_of, journal[:HEADER] + bad + struct.pack("<I", crc32c(bad)) + journal[HEADER + size + 8:])
            again = kelly(args + " --resume")
            claim(again.returncode == 0 and "torn" in again.stderr and results() == want, f"{name}, a record of {value[:8]}: {again.returncode}, {again.stderr!r}")
    FIGURES["aborts of sensitivity, --until-width, --convergence, --envelope and --traces, advise, rare and map, survived"] = done


# ---- whose journal

def check_foreign(folder):
    """A journal of another run is refused and left as it is; two processes do not write one; without --resume a run starts afresh."""
    place = Place(folder, "foreign")
    want = place.alone(SMALL)
    journal = whole_journal(place, SMALL)
    others = ["--seed 2", "--samples 21", "--first 6", "--mu 0.005", "--rpm 101", "--wob 99", "--f0 49", "--alpha1 2.1", "--alpha2 1.1",
              "--cov 0.1", "--start rotating", "--drive soft", "--limit 0.7", "--torsional 9", "--window 3:8", "--duration 9", "--step 0.0005",
              "--twice"]
    for more in others:
        only(place, journal)
        other = place.run(f"{SMALL} {more} --resume")
        claim(other.returncode == 2 and "of another run" in other.stderr and place.files() == ["run.csv.journal"] and read(place.journal) == journal,
              f"{more}: exit {other.returncode}, {other.stderr!r}, {place.files()}")
    only(place, journal)
    claim("in float, this is in double" in place.run(SMALL + " --resume", real="double").stderr, "float is not double")
    only(place, journal)
    claim(place.run(SMALL.replace("montecarlo", "map") + " --samples 20 --resume").returncode == 2, "montecarlo is not map")
    for args in (f"{SMALL} --resume", f"{SMALL} --resume --csv - ", f"{SMALL} --resume --json -"):
        claim(kelly(args).returncode == 2, f"{args}: no file, no journal")
    only(place, journal)
    fresh = place.run(SMALL)
    old = place.journal + ".old"
    claim(fresh.returncode == 0 and "20 records of an earlier kelly montecarlo, now in" in fresh.stderr and old in fresh.stderr and fresh.stderr.count("\n") == 1,
          f"without --resume: {fresh.stderr!r}")
    claim(read(old) == journal and place.files() == ["run.csv", "run.csv.journal.old", "run.json"], f"the journal is kept: {place.files()}")
    os.remove(old)
    claim(place.results() == want, "without --resume it runs afresh")
    only(place, b"KELLYJNL" + bytes(range(1, 201)))
    write(old, journal)
    torn = place.run(f"{SMALL} --resume")
    claim(torn.returncode == 2 and read(old) == journal, f"an older one stays where nothing is begun: {torn.stderr!r}")
    torn = place.run(SMALL)
    claim(torn.returncode == 0 and "of an earlier kelly run, now" in torn.stderr and read(old) != journal, f"an older one is replaced: {torn.stderr!r}")
    only(place, journal[:HEADER])
    write(old, journal)
    claim(place.run(SMALL).stderr == "" and read(old) == journal, "a journal without records is not worth keeping")
    place.empty()
    write(old, forged(journal))
    again = place.run(f"{SMALL} --resume")
    claim(again.returncode == 0 and read(old) == forged(journal), f"an older one stays: {again.stderr!r}, {place.files()}")
    os.remove(old)
    claim(place.results() == want, "--resume does not use an older one")
    place.empty()
    kelly(f"sensitivity {CASE} --samples 4 --json {place.csv} --quiet", fault="unlink:1:kill")
    other = read(place.journal)
    only(place, other)
    fresh = place.run(SMALL)
    claim("records of an earlier kelly sensitivity" in fresh.stderr and read(old) == other, f"another command's: {fresh.stderr!r}")
    place.empty()
    with subprocess.Popen([PROGRAM["float"]] + shlex.split(place.args(f"montecarlo {CASE} --samples 400000")), stderr=subprocess.DEVNULL) as first:
        while not (os.path.exists(place.journal) and os.path.getsize(place.journal) > HEADER):
            time.sleep(0.01)
        for args in (place.args(f"montecarlo {CASE} --samples 400000 --resume"), f"{SMALL} --csv {place.csv}"):
            second = kelly(args)
            claim(second.returncode == 1 and "another process" in second.stderr, f"two at once: {second.returncode}, {second.stderr!r}")
        claim(first.poll() is None, "the first goes on")
        first.kill()
    claim(place.files() == ["run.csv.journal", "run.csv.part", "run.json.part"], f"what a kill leaves: {place.files()}")


def check_signals(folder):
    """What asks a run to end leaves the journal and no half-written file."""
    place = Place(folder, "signals")
    want = place.alone(PIECES)
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

    def heed():                              # a shell starts what runs in the background with some of them ignored, and kelly leaves it at that
        for each in numbers:
            signal.signal(each, signal.SIG_DFL)

    for number in numbers:
        place.empty()
        with subprocess.Popen([PROGRAM["float"]] + shlex.split(place.args(f"montecarlo {CASE} --samples 400000")), cwd=folder,
                              preexec_fn=heed, stderr=subprocess.PIPE) as process:
            while not (os.path.exists(place.journal) and os.path.getsize(place.journal) > HEADER):
                time.sleep(0.01)
            process.send_signal(number)
            told = process.communicate()[1].decode()
        claim(process.returncode == -number and place.files() == ["run.csv.journal"], f"{number!r}: exit {process.returncode}, left {place.files()}")
        claim(told == "kelly: interrupted; with --resume the run goes on from its journal\n", f"{number!r}: {told!r}")
    for what in ("no reader of its messages", "a full pipe for them"):     # neither holds it up
        place.empty()
        reader, writer = os.pipe()
        if what.startswith("no"):
            os.close(reader)
        else:
            os.set_blocking(writer, False)
            while True:
                try:
                    os.write(writer, bytes(4096))
                except BlockingIOError:
                    break
            os.set_blocking(writer, True)
        with subprocess.Popen([PROGRAM["float"]] + shlex.split(place.args(f"montecarlo {CASE} --samples 400000 --progress none")), cwd=folder, preexec_fn=heed, stderr=writer) as process:
            while not (os.path.exists(place.journal) and os.path.getsize(place.journal) > HEADER):
                time.sleep(0.01)
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
        os.close(writer)
        if not what.startswith("no"):
            os.close(reader)
        claim(process.returncode == -signal.SIGTERM and place.files() == ["run.csv.journal"], f"{what}: exit {process.returncode}, left {place.files()}")
    place.empty()
    resumed(place, PIECES, want, "afterwards", whole=True)
    journal = os.path.join(folder, "map.json.journal")
    with subprocess.Popen([PROGRAM["float"]] + shlex.split("map --mu 0.004 --rpm 40:140:5 --wob 25:225:10 --json map.json"), cwd=folder, preexec_fn=heed, stderr=subprocess.PIPE) as process:
        while not (os.path.exists(journal) and os.path.getsize(journal) > HEADER):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        told = process.communicate()[1].decode()
    claim(process.returncode == -signal.SIGINT and told.startswith("kelly: interrupted; with --resume"), f"a map: exit {process.returncode}, {told!r}")
    os.remove(journal)


def check_double(folder):
    """The same in double: kills at the calls, cuts through a record."""
    place = Place(folder, "double")
    want = place.alone(SMALL, real="double")
    journal = whole_journal(place, SMALL, real="double")
    claim(len(journal) == HEADER + 20 * 88, f"double: {len(journal)} bytes")
    for cut in range(HEADER + 88 * 3, HEADER + 88 * 4):
        only(place, journal[:cut])
        resumed(place, SMALL, want, f"double, cut to {cut}", real="double")


def timed(name, folder):
    start = time.monotonic()
    globals()["check_" + name](folder)
    print(f"  {name}: {time.monotonic() - start:.1f} s", flush=True)


def main():
    parser = command_line(__doc__)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("names", nargs="*")
    args = chosen(parser)
    PROGRAM["kills"] = args.kills
    with tempfile.TemporaryDirectory() as folder:
        PROGRAM["shim"] = os.path.join(folder, "shim.so")
        subprocess.run([os.environ.get("CC", "cc"), "-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-o", PROGRAM["shim"],
                        os.path.join(ROOT, "tests/failing_disk.c"), "-ldl"], check=True)
        names = args.names or [n[6:] for n in globals() if n.startswith("check_")]
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda name: timed(name, folder), names))
    for what, value in FIGURES.items():
        print(f"figure: {what}: {value}")
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
