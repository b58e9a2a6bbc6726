"""map_journal.py - checks of the journal: torn, foreign, locked, killed, no room. Run by check_map.py."""
import fcntl
import os
import random
import resource
import shlex
import signal
import struct
import subprocess
import time

from map_tools import PROGRAM, SHORT, claim, done, kelly, read, refused, write
from second_opinion import crc32c

HEADER, RECORD = 96, 40                     # bytes of a journal: its header, a cell's record
DRAWS = random.Random(20261122)


def whole_journal(folder, args, real="float"):
    """The journal of a run that had come to its end but could not write its last file: the wanted CSV, and the journal."""
    out = os.path.join(folder, "j.csv")
    os.makedirs(os.path.join(folder, "taken"), exist_ok=True)
    failed = kelly(f"map {args} --csv {out} --npy {folder}/taken --quiet", real)
    claim(failed.returncode == 1 and failed.stderr.count("\n") == 1, f"a file that cannot be written: exit {failed.returncode}, {failed.stderr!r}")
    return out, read(out), read(out + ".journal")


def records(journal):
    return [journal[at:at + RECORD] for at in range(HEADER, len(journal), RECORD)]


def resumed(args, out):
    """Resume into `out`, from nothing but its journal: exit, stderr, bytes."""
    if os.path.exists(out):
        os.remove(out)
    result = kelly(f"map {args} --csv {out} --quiet --resume")
    return result.returncode, result.stderr, read(out) if os.path.exists(out) else b""


def check_torn(folder):
    """A journal cut at any byte, or with a byte changed, leads to the same result."""
    args = "--rpm 60:90:30 --wob 40:90:50 --samples 20 --mu 0.004 --duration 1 --window 0:1"
    out, want, journal = whole_journal(folder, args)
    claim(len(journal) >= HEADER + 16 * RECORD and (len(journal) - HEADER) % RECORD == 0, f"the journal has a record a cell: {len(journal)} bytes")
    claim(journal[:8] == b"KELLYJNL" and crc32c(journal[:92]) == struct.unpack("<I", journal[92:96])[0], "header: magic and CRC-32C")
    claim(all(crc32c(journal[at:at + RECORD - 4]) == struct.unpack("<I", journal[at + RECORD - 4:at + RECORD])[0]
              for at in range(HEADER, len(journal), RECORD)), "records: CRC-32C")
    status, said, got = resumed(args, out)
    claim(status == 0 and got == want and said.endswith(f"goes on from {len(records(journal))} records\n") and said.count("\n") == 1, f"from a whole journal: {said!r}")
    claim(not os.path.exists(out + ".journal"), "the journal goes with the last file")
    for cut in sorted({*range(0, HEADER + 2), *range(HEADER, len(journal), 7), len(journal) - 1}):
        write(out + ".journal", journal[:cut])
        status, said, got = resumed(args, out)
        torn = 0 < cut < HEADER or (cut > HEADER and (cut - HEADER) % RECORD)
        claim(status == 0 and got == want, f"cut at {cut}: exit {status}, {said!r}, other bytes {got != want}")
        whole = f"goes on from {(cut - HEADER) // RECORD} record" if cut >= HEADER else "torn header" if cut > 0 else "starts from its beginning"
        claim(said.count("\n") == (2 if torn and cut >= HEADER else 1) and ("torn" in said) == bool(torn) and whole in said, f"cut at {cut}: says {said!r}")
    for at in (HEADER, HEADER + 5, HEADER + RECORD - 1, HEADER + 3 * RECORD + 20, len(journal) - 1):
        bad = bytearray(journal)
        bad[at] ^= 0x10
        write(out + ".journal", bytes(bad))
        status, said, got = resumed(args, out)
        claim(status == 0 and got == want and "torn" in said, f"byte {at} changed: exit {status}, {said!r}, other bytes {got != want}")
    # behind a torn tail the journal goes on soundly: a second interruption loses nothing either
    write(out + ".journal", journal[:HEADER + 5 * RECORD + 11])
    again = kelly(f"map {args} --csv {out} --npy {folder}/taken --quiet --resume")
    claim(again.returncode == 1 and sorted(records(read(out + ".journal"))) == sorted(records(journal)), "records behind a torn tail are sound, none is lost")
    # records are believed: one that claims another count, with a sound CRC, shows that they are not computed again
    forged = bytearray(journal)
    stuck = struct.unpack_from("<I", forged, HEADER + 8)[0]
    struct.pack_into("<I", forged, HEADER + 8, stuck - 1 if stuck > 0 else 1)
    struct.pack_into("<I", forged, HEADER + RECORD - 4, crc32c(bytes(forged[HEADER:HEADER + RECORD - 4])))
    write(out + ".journal", bytes(forged))
    claim(resumed(args, out)[2] not in (want, b""), "what the journal holds is not computed again")
    for at in (4, 8, 12, 16):                # samples, stuck, lift-off, those that are sound: one that cannot be is computed again
        bad = bytearray(journal)
        struct.pack_into("<I", bad, HEADER + at, 4000000000)
        struct.pack_into("<I", bad, HEADER + RECORD - 4, crc32c(bytes(bad[HEADER:HEADER + RECORD - 4])))
        write(out + ".journal", bytes(bad))
        status, said, got = resumed(args, out)
        claim(status == 0 and got == want and "torn" in said, f"4e9 at {at}: exit {status}, {said!r}, other bytes {got != want}")
    beyond = bytearray(journal[:HEADER + RECORD])
    struct.pack_into("<I", beyond, HEADER, 0xffffffff)
    struct.pack_into("<I", beyond, HEADER + RECORD - 4, crc32c(bytes(beyond[HEADER:HEADER + RECORD - 4])))
    write(out + ".journal", bytes(beyond))
    claim(resumed(args, out)[0] == 0 and read(out) == want, "an index beyond the run is no record")
    write(out + ".journal", journal)
    fresh = kelly(f"map {args} --csv {out} --quiet")
    claim(fresh.returncode == 0 and "of an earlier kelly map, now in" in fresh.stderr and read(out) == want and
          read(out + ".journal.old") == journal, f"without --resume a run starts afresh and says so: {fresh.stderr!r}")


def check_foreign(folder):
    args = "--rpm 60:90:30 --wob 40:90:50 --samples 20 --duration 1 --window 0:1"
    out, want, journal = whole_journal(folder, args)
    others = [("--seed 2", "seed 1, this is 2"), ("--mu 0.005", "another case"), ("--samples 21", "another case"), ("--rpm 60:90:15", "another case"),
              ("--rpm 61:91:30", "another case"), ("--wob 40:91:50.5", "another case"), ("--f0 20", "another case"), ("--cov 0.1", "another case"),
              ("--limit 0.7", "another case"), ("--first 1", "another case"), ("--adaptive 0.1 --samples 20", "another case"),
              ("--drive soft", "another case"), ("--torsional 9", "another case"), ("--step 0.0005", "another case"), ("--window 0:0.5", "another case")]
    for more, word in others:
        refused(f"map {args} {more} --csv {out} --resume", word)
        claim(read(out + ".journal") == journal, f"{more}: a journal that is refused stays as it is")
    refused(f"map {args} --csv {out} --resume", "in float, this is in double", "double")
    for at, new, word in ((36, b"rare\0", "kelly rare"), (52, b"pipe-01\0", "string pipe-01"), (8, b"\x09", "version")):
        foreign = bytearray(journal)
        foreign[at:at + len(new)] = new
        struct.pack_into("<I", foreign, 92, crc32c(bytes(foreign[:92])))
        write(out + ".journal", bytes(foreign))
        refused(f"map {args} --csv {out} --resume", word)
    for text in (b"my thesis\n", b"my thesis\n" * 100, b"KELLYJNL" + b"x" * 200):
        write(out + ".journal", text)
        for resume in ("--resume", "") if text[:5] != b"KELLY" else ("--resume",):
            refused(f"map {args} --csv {out} {resume}", "not a journal")
            claim(read(out + ".journal") == text, "a file that is no journal stays as it is")
    write(out + ".journal", journal)
    same = resumed(args + " --threads 3 --engine scalar", out)
    claim(same[0] == 0 and same[2] == want and "dropped" not in same[1], f"threads and engine do not make another run: {same[:2]}")


def start(args):
    return subprocess.Popen([PROGRAM["float"]] + shlex.split(args), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def check_lock(folder):
    out = os.path.join(folder, "lock.csv")
    args = "--rpm 60:90:15 --wob 40:90:25 --samples 400 --duration 20 --window 10:20"
    with subprocess.Popen([PROGRAM["float"]] + shlex.split(f"map {args} --csv {out} --quiet"), stderr=subprocess.PIPE) as first:
        while not os.path.exists(out + ".journal") or os.path.getsize(out + ".journal") < HEADER:
            time.sleep(0.002)
        second = kelly(f"map {args} --csv {out} --resume")
        claim(first.poll() is None, "the first of two is still at work")
        claim(second.returncode == 1 and "another process" in second.stderr and second.stderr.count("\n") == 1, f"the second of two: {second.stderr!r}")
        _, said = first.communicate(timeout=120)
    claim(first.returncode == 0 and said == b"" and os.path.exists(out), f"the first of two comes to its end: {said!r}")
    with open(out + ".journal", "wb") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        refused(f"map {args} --csv {out}", "another process", status=1)
    os.remove(out + ".journal")


def check_killed(folder):
    """kill -9 at random times, again and again, then to the end: the files of a run that was left alone."""
    args = f"--rpm 60:120:12 --wob 40:140:20 --samples 200 {SHORT} --adaptive 0.1"
    outputs = "--csv {0}.csv --json {0}.json --npy {0}.npy --quiet"
    alone, killed = os.path.join(folder, "alone"), os.path.join(folder, "killed")
    began = time.monotonic()
    done(f"map {args} {outputs.format(alone)}")
    whole = time.monotonic() - began
    hits = 0
    for trial in range(12):
        for _ in range(3):
            with start(f"map {args} {outputs.format(killed)} --resume") as process:
                time.sleep(DRAWS.uniform(0.003, 0.5 * whole))
                hits += process.poll() is None
                process.send_signal(signal.SIGKILL)
                process.communicate()
        last = kelly(f"map {args} {outputs.format(killed)} --resume")
        same = [read(f"{alone}.{kind}") == read(f"{killed}.{kind}") for kind in ("csv", "json", "npy")]
        claim(last.returncode == 0 and all(same), f"trial {trial} of kill -9: exit {last.returncode}, {last.stderr!r}, files equal {same}")
        for kind in ("csv", "json", "npy"):
            os.remove(f"{killed}.{kind}")
    left = sorted(f for f in os.listdir(folder) if f.endswith(".journal"))
    claim(hits >= 6 and left == [], f"{hits} of 36 kills hit a running process; journals left: {left}")


def check_disk_full(folder):
    """A file that may not grow: one line, exit 1, and --resume ends with the same bytes."""
    args = "--rpm 60:90:30 --wob 40:90:50 --samples 20 --mu 0.004 --duration 1 --window 0:1"
    out, want, journal = whole_journal(folder, args)
    os.remove(out + ".journal")

    def small(limit):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    for limit in (0, 50, HEADER, HEADER + 5, HEADER + RECORD * 3 + 17, len(journal) - 1):
        result = kelly(f"map {args} --csv {out} --quiet", preexec_fn=lambda limit=limit: small(limit), restore_signals=False)
        claim(result.returncode == 1 and result.stderr.count("\n") == 1, f"room for {limit} bytes: exit {result.returncode}, {result.stderr!r}")
        status, said, got = resumed(args, out)
        claim(status == 0 and got == want, f"after room for {limit} bytes: exit {status}, {said!r}, other bytes {got != want}")
