#!/usr/bin/env python3
"""check_bench - `kelly bench` with emulated boards: campaigns, lockstep, real time, and lines that fail.

usage: tests/check_bench.py [--float build/host/kelly] [--double build/host-double/kelly] [WORD...]      only scenarios whose name holds one of the words

Last line `N passed, N failed`.
"""
import os
import pty
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time

import wits
from bench_board import ROOT, image, link, loaded
from bench_line import Between, again
from bench_run import TEMPORARY, WAITING, Faulty, Run, bytes_of, same_campaign
from programs import PROGRAM
from scenarios import run as run_scenarios

HEADER, RECORD = 96, 48          # bytes of a journal in float
BOARDS = ("stm32f405", "mps2-an500", "rv32")
CASE = "--duration 4 --window 2:4 --mu 0.02"
CLOCK = "--icount shift=5,sleep=off"


def until(condition, seconds=60):
    """Wait for it, on a machine that may be busy."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)


def watching(name):
    """A change that changes nothing and counts messages of this name in line.frames."""
    def watch(message, line):
        line.frames += message[0] == name
        return again(message)
    return watch


# ---- campaigns

def three_kinds_at_once():
    samples = 480
    case = f"{CASE} --samples {samples} --seed 5"
    run = Run(case + "".join(f" --port qemu:{t}" for t in BOARDS))
    yield from same_campaign(run, case, samples)
    boards = run.report()["bench"]["boards"]
    for target, board in zip(BOARDS, boards):
        flash = loaded(image(target))
        yield board["results"] > 0 and board["board"] == target, f"{target} took part: {board}"
        yield int(board["image_crc"], 16) == link.crc32c(flash) and board["image_bytes"] == len(flash), f"{target}: CRC of the image"
        yield board["emulator"] in run.err and board["emulator"].startswith("qemu-system-"), f"{target}: the emulator's command line is told"
    again_from = subprocess.run([PROGRAM["float"], "whatif", "--from", run.csv, "--case-json", run.json, "--mu", "0.0195"], capture_output=True, text=True, check=False)
    yield again_from.returncode == 0, f"its files are good for whatif: {again_from.stderr}"
    print("  " + ", ".join(f"{b['board']} {b['results']}" for b in boards) + f" realisations in {run.report()['seconds']:.2f} s")


def another_case():
    """A soft drive, another start, a first index, refused and lifted realisations."""
    case = "--duration 2 --window 1:2 --mu 0.1 --wob 60 --cov 0.3 --start rotating --drive soft --samples 24 --first 4000000000 --seed 18446744073709551615"
    run = Run(case + " --port qemu:mps2-an500")
    yield from same_campaign(run, case, 24)
    yield run.report()["liftoff"] > 0 and "drive soft" in run.out, f"lift-off, drive: {run.said}"


def lines_that_fail(rate, samples, more):
    case = f"{CASE} --samples {samples}"
    lines = [Faulty(t, f"--rate {rate} --seed {k} {more}") for k, t in enumerate(BOARDS)]
    run = Run(case + "".join(f" --port {line.port}" for line in lines))
    reports = [line.end() for line in lines]
    yield from same_campaign(run, case, samples)
    faults = sum(n for r in reports for way in ("up", "down") for kind, n in r[way].items() if kind != "bytes")
    carried = sum(r[way]["bytes"] for r in reports for way in ("up", "down"))
    kills, stalls = (sum(r[k] for r in reports) for k in ("kills", "stalls"))
    boards = run.report()["bench"]["boards"]
    yield faults > 0, "something was done to the line"
    yield stalls == ("stall" in more) * 3 and (kills >= 3) == ("kill" in more), f"{kills} kills, {stalls} stalls"
    yield all(b["connections"] > 1 for b in boards) or "kill" not in more, "each board that was killed came back"
    print(f"  rate {rate}: {faults} faults in {carried} bytes, {stalls} stalls, {kills} kills: {sum(b['bad_frames'] for b in boards)} bad frames here, "
          f"{sum(b['bad_frames_there'] for b in boards)} there, {sum(b['runs_repeated'] + b['requests_repeated'] for b in boards)} repeats, "
          f"{sum(b['doubles'] for b in boards)} results twice, {run.report()['seconds']:.1f} s")


def emulator_killed():
    """In mid-range, from outside; it is started again. And the only board there is."""
    samples, case = 80, "--duration 30 --window 20:30 --mu 0.02 --samples 80"
    run = Run(case + " --port qemu:stm32f405", wait=False)
    until(lambda: os.path.exists(run.csv + ".journal") and os.path.getsize(run.csv + ".journal") > HEADER + RECORD)
    with open(f"/proc/{run.process.pid}/task/{run.process.pid}/children", encoding="ascii") as file:
        children = file.read().split()
    for child in children:
        os.kill(int(child), signal.SIGKILL)
    run.wait()
    yield len(children) == 1, f"one emulator: {children}"
    yield from same_campaign(run, case, samples)
    yield run.report()["bench"]["boards"][0]["connections"] == 2, f"it was connected twice: {run.said}"


def host_killed():
    """Twice in mid-campaign, once with records torn off; what goes on asks for the rest alone, and gives what one campaign gives."""
    samples, case = 120, f"{CASE} --samples 120"
    run = Run(f"{case} --port qemu:stm32f405 --port qemu:rv32", wait=False)
    for more in (0, 40):
        until(lambda: os.path.exists(run.csv + ".journal") and os.path.getsize(run.csv + ".journal") > HEADER + (20 + more) * RECORD)
        run.process.kill()
        run.wait()
        os.truncate(run.csv + ".journal", os.path.getsize(run.csv + ".journal") // RECORD * RECORD + 7)   # whole records and a torn one
        held = (os.path.getsize(run.csv + ".journal") - HEADER) // RECORD
        other = Run(f"{case} --seed 2 --resume --port qemu:rv32 --csv {run.csv}", files=False)
        yield other.status == 2 and "of another run" in other.err, f"another seed: {other.said}"
        run = Run(f"{case} --resume --port qemu:stm32f405 --port qemu:rv32", wait=False, base=run.base)
    run.wait()
    yield from same_campaign(run, case, samples)
    used = run.report()["bench"]["resumed"]
    yield used == held >= 60 and "torn" in run.err, f"{held} records held, {used} used: {run.said}"
    yield f"{held} from the journal, {samples - held} from boards\n" in run.out, f"the summary says so: {run.out}"
    yield not os.path.exists(run.csv + ".journal"), "the journal is gone"


def hanging_board():
    """One says nothing more, with a range in its hands: the other one takes it over at once."""
    def hang(message, line):
        line.frames += message[0] == "result"
        return again(message) if line.frames < 6 else b""
    case = f"{CASE} --samples 100"
    with Between("rv32", hang) as line:
        run = Run(f"{case} --port {line.port} --port qemu:mps2-an500")
    yield from same_campaign(run, case, 100)
    boards = run.report()["bench"]["boards"]
    yield boards[0]["results"] == 5 and boards[1]["results"] == 95, f"five are its own: {run.said}"


def all_boards_gone():
    with Between("rv32", watching("result")) as line:
        run = Run(f"{CASE} --samples 100000 --port {line.port} --give-up 2", wait=False)
        until(lambda: line.frames > 9)
        line.pull()
        run.wait()
    yield run.status == 1 and "no board for 2 s" in run.err.splitlines()[-1], f"no board is left: {run.said}"
    left = [name for name in os.listdir(TEMPORARY.name) if name.startswith(os.path.basename(run.base))]
    yield left == [os.path.basename(run.csv) + ".journal"], f"what was delivered, and nothing half-written: {left}"


def other_lines(kind):
    """The same over TCP and over a terminal, where a host that ends leaves a board that answers the next one."""
    case = f"{CASE} --samples 30"
    with Between("mps2-an500", watching("result"), kind) as line:
        first = Run(f"{CASE} --samples 100000 --port {line.port}", wait=False)
        until(lambda: line.frames > 9)
        first.process.kill()
        first.wait()
        yield from same_campaign(Run(f"{case} --port {line.port} --image {image('mps2-an500')}"), case, 30)


# ---- lockstep

def next_float(value):
    """The same float but for its last bit."""
    return struct.unpack("<f", struct.pack("<I", struct.unpack("<I", struct.pack("<f", value))[0] ^ 1))[0]


def in_step(target, more):
    run = Run(f"--mode lockstep --duration 60 --port qemu:{target} {more}")
    report = run.report() if run.status == 0 else {}
    yield run.status == 0 and report["differing_bits"] == 0 and report["steps"] == 60000, f"60 s, no bit differs: {run.said}"
    yield report["values"] == 6 * report["frames"], "every field of every frame was compared"
    rows = run.rows()
    speeds = [float(row["top_speed_rpm"]) for row in rows]
    yield len(rows) == report["frames"] + 1 and max(speeds) - min(speeds) > 5, f"{len(rows)} lines, the top turns at {min(speeds):.1f} .. {max(speeds):.1f} rpm"
    early = [float(row["top_speed_rpm"]) for row in rows if 0.1 < float(row["time_s"]) < 3]
    yield (max(early) - min(early) > 0.5) == ("soft" in more), f"while the set speed stays, only a soft drive gives way: {min(early):.2f} .. {max(early):.2f} rpm"
    trip = report["round_trip_ms"]
    print(f"  {target} {more}: {report['frames']} frames, round trip {trip['median']:.2f} ms median, {trip['p95']:.2f} 95 %, {trip['max']:.1f} worst, "
          f"{report['frames_per_s']:.0f} frames/s")


def a_board_that_lies():
    def lie(message, line):
        name, seq, fields = message
        line.frames += name == "lock_answer"
        if line.frames == 100 and name == "lock_answer":
            fields["surface_torque"] = next_float(fields["surface_torque"])
        return again((name, seq, fields))
    with Between("rv32", lie) as line:
        run = Run(f"--mode lockstep --duration 5 --port {line.port}")
    yield run.one_line(1, "frame 100, 1 s", "surface torque differs by 1 bits"), f"the first bit is told: {run.said}"
    yield not os.path.exists(run.csv), "no file"


def step_on_a_bad_line():
    line = Faulty("rv32", "--rate 3e-3 --seed 3")
    run = Run(f"--mode lockstep --duration 5 --port {line.port}")
    line.end()
    yield run.status == 0 and run.report()["differing_bits"] == 0, f"no bit differs: {run.said}"
    yield run.report()["board"]["requests_repeated"] > 10, "requests were repeated"


def cable_pulled(mode):
    with Between("rv32", watching({"lockstep": "lock_answer", "realtime": "rt_sample"}[mode])) as line:
        run = Run(f"--mode {mode} --duration 60 --port {line.port}", wait=False)
        until(lambda: line.frames > 4)
        line.pull(False)
        run.wait()
        yield run.one_line(1, "closed at the other end", "session is lost"), f"the cable is pulled: {run.said}"
        yield not os.path.exists(run.csv), "no file"
        case = f"{CASE} --samples 4"
        yield from same_campaign(Run(f"{case} --port {line.port}"), case, 4)


# ---- real time

def keeps_time(target):
    runs = [Run(f"--mode realtime --duration 60 {CLOCK} --port qemu:{target}") for _ in range(2)]
    first, second = ({k: v for k, v in run.report().items() if k != "board"} if run.status == 0 else run.said for run in runs)
    yield first["steps"] == 60000 and first["late"] == 0 and 0 < first["load"] < 0.5, f"60 s at 1 kHz: {first}"
    measured = ("worst_late_us", "load", "load_worst")     # depend a little on where in a tick the start arrived
    yield {k: v for k, v in first.items() if k not in measured} == {k: v for k, v in second.items() if k not in measured}, f"the same again: {second}"
    yield runs[0].rows() == runs[1].rows(), "and every sample"
    yield max(first["worst_late_us"], second["worst_late_us"]) < 100 and abs(first["load"] - second["load"]) < 0.01, f"lateness, load: {first}, {second}"
    yield first["samples"] == first["samples_received"] == 600 == len(runs[0].rows()), "ten samples a second"
    print(f"  {target}: 60000 steps, {first['late']} late, worst lateness {first['worst_late_us']} us, load {100 * first['load']:.1f} %")


def counts_overloads():
    for steps in (1, 7):
        report = Run(f"--mode realtime --duration 10 {CLOCK} --port qemu:stm32f405 --overload {steps}:1500").report()
        yield report["late"] == steps and report["steps"] == 10000, f"{steps} injected, {report['late']} late"


def sleeps_through_no_tick(target):
    """A step that ends just before its next tick: whichever of the instructions before the sleep the tick meets, it is not slept over."""
    def worst(micros):
        report = Run(f"--mode realtime --duration 2 {CLOCK} --port qemu:{target} --overload 1:{micros}").report()
        return report["late"], report["worst_late_us"]
    before, after = 800, 990                 # too early, and so late that the next step has to wait
    start, end = worst(before), worst(after)
    yield start[0] == end[0] == 0 and start[1] < 10 < end[1] < 200, f"between them is the sleep: {start}, {end}"
    while after - before > 1:
        middle = (before + after) // 2
        before, after = (before, middle) if worst(middle)[1] >= 10 else (middle, after)
    for micros in range(after - 20, after + 5):
        late, micros_late = worst(micros)
        yield late == 0 and micros_late < 30, f"a step of {micros} us: {late} late, {micros_late} us"


def host_dies():
    """On the deterministic clock no commands are sent: what the board does then."""
    words = f"--mode realtime --duration 12 {CLOCK} --port qemu:rv32 --stream-hz 1 --command-timeout 3"
    speeds = {}
    for policy in ("hold", "ramp --ramp 4", "stop"):
        run = Run(f"{words} --policy {policy}")
        speeds[policy] = [round(float(row["top_speed_rpm"])) for row in run.rows()]
        yield run.status == 0 and run.report()["timeouts"] == 1, f"{policy}: {run.said}"
    yield speeds["hold"] == [100] * 12, f"hold: {speeds['hold']}"
    yield speeds["ramp --ramp 4"] == [100, 100, 100, 75, 50, 25] + [0] * 6, f"ramp: {speeds['ramp --ramp 4']}"
    yield speeds["stop"] == [100, 100], f"stop: {speeds['stop']}"


def takes_commands():
    profile, display = (os.path.join(TEMPORARY.name, name) for name in ("profile.csv", "display"))
    with open(profile, "w", encoding="ascii") as file:
        file.write("time_s,rpm,wob_kN\n0,100,100\n1,100,100\n3,140,80\n")
    run = Run(f"--mode realtime --duration 6 --port qemu:rv32 --profile {profile} --wits {display} --stream-hz 20 --command-timeout 5")
    report, rows = run.report(), run.rows()
    yield report["steps"] == 6000 and report["commands"] > 20 and report["timeouts"] == 0, f"commands: {run.said}"
    yield abs(float(rows[-1]["top_speed_rpm"]) - 140) < 1e-3, f"the last speed: {rows[-1]}"
    between = [float(r["top_speed_rpm"]) for r in rows if 1.8 < float(r["time_s"]) < 2.2]
    yield all(101 < speed < 139 for speed in between), f"half way: {between}"
    frames = wits.frames(bytes_of(display))
    yield len(frames) == report["wits_frames"] >= 4, f"{len(frames)} WITS frames"
    for more in (f"--profile {profile}", f"--wits {display}"):
        run = Run(f"--mode realtime --duration 3 --port qemu:rv32 --icount shift=5,sleep=off {more}", files=False)
        yield run.one_line(2, f"{more.split()[0]}: not with --icount"), f"{more} on the emulator's own time: {run.said}"
    run = Run("--mode realtime --duration 3 --port qemu:rv32 --wits /dev/full", files=False)
    yield run.one_line(1, "--wits /dev/full: ", "frames could not be written: No space left"), f"a display that takes nothing: {run.said}"
    yield frames[-1]["0120"] == 140 and abs(frames[-1]["0116"] - 8) < 1.5, f"WITS: {frames[-1]}"


def shows_wits():
    with Between("rv32") as line:
        Run(f"{CASE} --samples 12 --port {line.port}")
        run = Run(f"--mode wits --port {line.port}", files=False)
    frame = wits.one(run.out.encode())
    yield run.status == 0 and frame["0927"] == 12 and 0 <= frame["0926"] <= 1, f"the board's last campaign: {frame}"


# ---- what is not right

def garbage():
    """1 MB of noise, the largest frame, one that is longer, frames of no known type: before hello's answer and in the middle."""
    noise = random.Random(6)

    def disturb(message, line):
        line.frames += 1
        if line.frames == 1:
            return noise.randbytes(1 << 20) + again(message)
        if line.frames % 7 == 0:
            return link.raw_frame(200, 5, bytes(range(256)) + bytes(135)) + b"\0" + noise.randbytes(3000).replace(b"\0", b"\1") + b"\0" + again(message)
        return again(message)
    case = f"{CASE} --samples 30"
    with Between("mps2-an500", disturb) as line:
        run = Run(f"{case} --port {line.port}")
    yield from same_campaign(run, case, 30)
    yield run.report()["bench"]["boards"][0]["bad_frames"] > 1000, f"what was skipped: {run.said}"


def changed_hello(**changes):
    def change(message, _):
        name, seq, fields = message
        return again((name, seq, {**fields, **changes} if name == "hello_reply" else fields))
    return change


def does_not_fit():
    other = link.SCHEMA ^ 0x5a5a
    for what, changes, words in (("schema", {"schema": other}, (f"{other:08x}", f"{link.SCHEMA:08x}")), ("string", {"model": "other-12345678"}, ("other-12345678",)),
                                 ("precision", {"real_bytes": 8}, ("computes in double", "REAL=double"))):
        with Between("rv32", changed_hello(**changes)) as line:
            run = Run(f"{CASE} --port {line.port}")
            yield run.one_line(1, line.port, *words), f"another {what}: {run.said}"
            yield not os.path.exists(run.csv), "no file"
    with Between("rv32") as line:
        run = Run(f"{CASE} --port {line.port} --image {image('mps2-an500')}")
        here, there = (f"{link.crc32c(loaded(image(t))):08x}" for t in ("mps2-an500", "rv32"))
        yield run.one_line(1, here, there), f"another image: {run.said}"
        run = Run(f"--port qemu:rv32 --image {image('mps2-an500')}", files=False)
        yield run.one_line(2, "for another processor than qemu:rv32 has; give the .elf that make TARGET=rv32 wrote"), f"an image of another processor: {run.said}"
        run = Run(f"{CASE} --port {line.port}", real="double")
        yield run.one_line(1, "computes in float", "REAL=double"), f"another precision: {run.said}"


def boards_that_do_not_agree():
    """The same index twice, once with another bit; and a draw that is not this program's."""
    def change(message, line):
        name, seq, fields = message
        line.frames += name == "result"
        if line.frames == 5 and name == "result":
            return again(message) + again((name, seq, {**fields, "ss": next_float(fields["ss"])}))
        return again(message)

    def other_draw(message, _):
        name, seq, fields = message
        return again((name, seq, {**fields, "draw_crc": fields["draw_crc"] ^ 1} if name == "result" else fields))
    with Between("rv32", change) as line:
        run = Run(f"{CASE} --port {line.port}")
        yield run.one_line(1, "realisation 4: other bits"), f"another bit: {run.said}"
    with Between("rv32", other_draw) as line:
        run = Run(f"{CASE} --port {line.port}")
        yield run.one_line(1, "realisation 0: its draw"), f"another draw: {run.said}"


USAGE = ["", "--port nowhere", "--port qemu:nope", "--port qemu:../rv32", "--port qemu:targets", "--port tcp:x", "--port tcp::1", "--port tcp:x:0", "--port unix:",
         "--port qemu:", "--port /dev/null", "--port /tmp", "--port ./Makefile", "--port /dev/ttyS9,baud=77", "--port qemu:rv32 --image Makefile", "--port qemu:rv32 --image nothing", "--port qemu:rv32 --mode nope",
         "--port qemu:rv32 --mode lockstep --samples 3", "--port qemu:rv32 --port qemu:rv32 --mode lockstep", "--port qemu:rv32 --out x", "--port qemu:rv32 --overload 5",
         "--port qemu:rv32 --mode realtime --overload 5", "--port qemu:rv32 --mode realtime --overload x:5", "--port qemu:rv32 --mode realtime --drive soft",
         "--port qemu:rv32 --mode realtime --policy no", "--port qemu:rv32 --mode realtime --stream-hz 1e-12", "--port qemu:rv32 --mode realtime --step 0.0005", "--port qemu:rv32 --mode lockstep --frame-ticks 0",
         "--port qemu:rv32 --mode lockstep --profile nothing", "--port qemu:rv32 --mode lockstep --profile Makefile", "--port qemu:rv32 --threads 2",
         *(f"--port qemu:rv32 --icount {text}" for text in ("11", "shift=11", "shift=-1", "shift=1e1", "shift=08", "shift=", "nope", "sleep=off", "shift=5,sleep=maybe",
                                                             "shift=5,", "shift=5,align=on,sleep=off", "shift=5" + 9 * ",sleep=on")),
         "--port qemu:rv32 --mode realtime --icount shift=5 --wits x",
         "--port qemu:rv32 --give-up 0", "--port qemu:rv32 --first 4294967295 --samples 1", "--port qemu:rv32 --mode lockstep --mu 1"]


def elf(wide, segments, body=bytes(range(32)), **other):
    """An ELF of a header, program headers and a body; segments: (offset in the body, address, size). other: what its header says instead."""
    head, each = (64, 56) if wide else (52, 32)
    says = {"table": head, "each": each, "count": len(segments), "kind": 1 + wide, **other}
    start, word = head + each * len(segments), "Q" if wide else "I"
    text = struct.pack("<4s12B", b"\x7fELF", says["kind"], 1, 1, *[0] * 9) + struct.pack("<HHI3" + word + "I6H", 2, 243, 1, 0, says["table"], 0, 0, head, says["each"],
                                                                                      says["count"], 0, 0, 0)
    for offset, address, size in segments:
        text += struct.pack("<IIQQQQQQ", 1, 5, start + offset, address, address, size, size, 1) if wide else struct.pack("<8I", 1, start + offset, address, address, size, size, 5, 1)
    return text + body


def crafted():
    """(what, bytes) of images that are none: sums that wrap, sizes and counts beyond the file."""
    for wide in (False, True):
        last, bits = (1 << (64 if wide else 32)) - 16, 64 if wide else 32
        two = [(0, 0x1000, 16), (16, 0x1010, 16)]
        yield from ((f"{bits} bits, cut after {n} bytes", elf(wide, two)[:n]) for n in range(len(elf(wide, two))))
        yield f"{bits} bits, the end of a segment wraps", elf(wide, [(0, 0, 16), (0, last, 32)])
        yield f"{bits} bits, the only segment wraps", elf(wide, [(0, last, 32)])
        yield f"{bits} bits, far apart", elf(wide, [(0, 0, 16), (0, last - 16, 16)])
        yield f"{bits} bits, the offset wraps", elf(wide, [(0, 0, 16), (last - 64 - 2 * 56 if wide else last - 52 - 2 * 32, 16, 32)])
        yield f"{bits} bits, more bytes than the file has", elf(wide, [(0, 0, 1 << 20)])
        yield f"{bits} bits, more headers than the file has", elf(wide, two, count=65535)
        yield f"{bits} bits, no headers", elf(wide, two, count=0)
        yield f"{bits} bits, headers of no size", elf(wide, two, each=0)
        yield f"{bits} bits, headers too short", elf(wide, two, each=31)
        yield f"{bits} bits, headers at the end of memory", elf(wide, two, table=last)
        yield f"{bits} bits, headers that wrap into the file", elf(wide, [(0, 0, 16)] * 2, table=(1 << bits) - 8, each=72 if wide else 64)
        yield f"{bits} bits, of a kind that there is not", elf(wide, two, kind=3)


def images_that_are_none():
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "crafted.elf")
        for what, text in crafted():
            with open(path, "wb") as file:
                file.write(text)
            run = Run(f"--port unix:/nonexistent/line --give-up 0.1 --image {path}", files=False)
            yield run.one_line(2, f"--image {path}", "make TARGET=NAME"), f"{what}: {run.status}, {run.said}"
        for wide in (False, True):
            with open(path, "wb") as file:
                file.write(elf(wide, [(16, 0x1010, 16), (0, 0x1000, 16)]))
            run = Run(f"--port unix:/nonexistent/line --give-up 0.1 --image {path}", files=False)
            yield run.one_line(1, "no board for"), f"one that is right: {run.status}, {run.said}"


def misuse():
    for words in USAGE:
        run = Run(words, files=False)
        yield run.one_line(2), f"'{words}': {run.status}, {run.said}"
    for text in ("shift=", "shift=5,", "shift=5,sleep=maybe", "nope"):
        run = Run(f"--port qemu:rv32 --icount {text}", files=False)
        yield run.one_line(2, f"--icount {text}: unknown; give "), f"--icount {text}: {run.said}"
    run = Run("--port /dev/ttyNOTHERE", files=False)
    yield run.one_line(2, "--port /dev/ttyNOTHERE: No such file", "plug the board in") and WAITING not in run.err, f"a path that is not there: {run.said}"
    for words in ("unix:/nonexistent/line", "tcp:127.0.0.1:1"):
        run = Run(f"--port {words} --give-up 0.5", files=False)
        yield run.one_line(1, "no board for", words), f"'{words}': {run.said}"
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([PROGRAM["float"], "bench", "--port", "qemu:rv32"], cwd=folder, capture_output=True, text=True, check=False)
        yield done.returncode == 2 and "linker/rv32.mk" in done.stderr, f"outside the tree: {done.stderr}"
        os.symlink(os.path.join(ROOT, "linker"), os.path.join(folder, "linker"))
        done = subprocess.run([PROGRAM["float"], "bench", "--port", "qemu:rv32"], cwd=folder, capture_output=True, text=True, check=False)
        yield done.returncode == 2 and "make TARGET=rv32" in done.stderr, f"no image: {done.stderr}"


def silent_line():
    """A line on which nobody speaks: after two seconds what is waited for, once, and at last the reason."""
    ours, theirs = pty.openpty()
    for give_up, told in ((5, 1), (1, 0)):
        run = Run(f"--port {os.ttyname(theirs)} --give-up {give_up} --samples 3", files=False)
        waiting = [line for line in run.err.splitlines() if WAITING in line]
        yield run.one_line(1, "no board for", os.ttyname(theirs), "no answer to hello"), f"a silent line: {run.said}"
        yield len(waiting) == told and all(line.startswith("kelly: no board for") and f"at most {give_up} s (--give-up): {os.ttyname(theirs)}: opened 1 times" in line for line in waiting), f"it is told: {run.said}"
    os.close(ours)
    os.close(theirs)


def scenarios():
    for rate, samples, more in ((1e-4, 800, ""), (1e-3, 400, "--stall-at 1"), (1e-2, 400, "--stall-at 1.5 --kill-after 3000")):
        yield f"lines that fail {rate}", lines_that_fail, (rate, samples, more)
    yield "three kinds at once", three_kinds_at_once, ()
    for target in BOARDS:
        yield f"in step {target}", in_step, (target, {"rv32": "--drive soft --sample 3", "mps2-an500": "--frame-ticks 25 --start rotating"}.get(target, ""))
        yield f"keeps time {target}", keeps_time, (target,)
        yield f"sleeps through no tick {target}", sleeps_through_no_tick, (target,)
    yield "emulator killed", emulator_killed, ()
    yield "host killed", host_killed, ()
    yield "hanging board", hanging_board, ()
    yield "all boards gone", all_boards_gone, ()
    yield "another case", another_case, ()
    for kind in ("tcp", "pty"):
        yield f"other lines {kind}", other_lines, (kind,)
    yield "step on a bad line", step_on_a_bad_line, ()
    for mode in ("lockstep", "realtime"):
        yield f"cable pulled {mode}", cable_pulled, (mode,)
    for scenario in (a_board_that_lies, counts_overloads, host_dies, takes_commands, shows_wits, garbage, does_not_fit, boards_that_do_not_agree, images_that_are_none, silent_line, misuse):
        yield scenario.__name__.replace("_", " "), scenario, ()


if __name__ == "__main__":
    sys.exit(run_scenarios(__doc__, scenarios(), BOARDS))
