#!/usr/bin/env python3
"""check_bench_device - the device program on the bench, in the emulator, asked by the Python codec alone.

usage: tests/check_bench_device.py [--float build/host/kelly] [--double build/host-double/kelly] [WORD...]

hello and the image's CRC against the ELF file, campaigns against `kelly montecarlo`, lockstep of two kinds of board, real time
on the emulator's deterministic clock, the console, WITS, and what must not disturb any of them. Last line `N passed, N failed`.
"""
import math
import random
import re
import struct
import sys
import time

import wits
from bench_answers import differs, digest, montecarlo
from bench_board import CASE, Board, Silent, as_float, image, link, loaded
from scenarios import run as run_scenarios

BOARDS = ("stm32f405", "mps2-an500", "rv32", "microbit")
CLOCK = "shift=5,sleep=off"        # 32 ns an instruction: 31 MHz
W0 = CASE["w0"]
START = {"source": 0, "seed": 0, "index": 0, "top_speed": W0, "duration": 0, "stream_ticks": 0, "command_ms": 0, "policy": 0,
         "ramp_ms": 0, "overload_steps": 0, "overload_us": 0}
SOFT = {"drive_inertia": 2900.0, "drive_impedance": 289.0, "drive_hz": as_float(0.2)}


# ---- scenarios: each yields (claim holds, claim) ----

def says_who_it_is(target):
    with Board(target) as board:
        reply, again = board.hello(nonce=0xFFFFFFFF), board.hello(nonce=5)
        flash = loaded(image(target))
        yield reply["image_crc"] == link.crc32c(flash) and reply["image_size"] == len(flash), f"image CRC {reply['image_crc']:08x} of {len(flash)} bytes is the ELF's"
        yield reply["nonce"] == 0xFFFFFFFF and again == {**reply, "nonce": 5}, "hello twice"
        expected = {"schema": link.SCHEMA, "real_bytes": 4, "board": target, "frame_max": 400, "tick_hz": 1000, "watchdog": 0 if target.startswith("rv") else 1}
        yield expected.items() <= reply.items(), f"hello_reply {reply}"
        seconds = [beats_in_a_second(board)]
        while not 3 <= seconds[-1] <= 12 and len(seconds) < 5:         # of a machine that kept the emulator, or this, from its own
            seconds.append(beats_in_a_second(board))
        yield 3 <= seconds[-1] <= 12, f"signs of life, second by second: {seconds}"


def beats_in_a_second(board):
    board.pump()
    board.heard.clear()
    end = time.monotonic() + 1.05
    while time.monotonic() < end:
        board.pump(seconds=0.05)
    return sum(m[0] == "status" and m[2]["state"] == 0 for m in board.heard)


def results_of(board, first, count, seed=1, **changes):
    board.send("run", **{"case_crc": board.case_crc, "seed": seed, "first": first, "count": count, **changes})
    return [board.wait(lambda m: m[0] == "result")[2] for _ in range(count)]


def runs_a_campaign(target, count=8, soft=False):
    rows, want = montecarlo(count, *(["--drive", "soft:Z=289,f=0.2,J=2900"] if soft else []))
    with Board(target) as board:
        board.hello()
        board.set_case(**(SOFT if soft else {}))
        begin = time.monotonic()
        results = results_of(board, 0, count)
        computed = time.monotonic() - begin
        wrong = {r["index"]: differs(r, row) for r, row in zip(results, rows) if differs(r, row)}
        yield not wrong, f"results of the CSV: {wrong}"
        got = digest(results, rows)
        yield got == want, f"digest {got}, the host's {want}"
        yield {r["job"] for r in results} == {link.job(board.case_crc, 1)}, "job"
        spans = []
        for _ in range(3):
            begin = time.monotonic()
            yield results_of(board, 0, count) == results, "the same range again"
            spans.append(time.monotonic() - begin)
        yield results_of(board, 1, 3) == results[1:4], "a part of it"
        if target == "microbit":
            yield min(spans) < computed / 2, f"from memory: {spans} s, computed in {computed:.2f} s"
        yield results_of(board, 2, 2, seed=2) != results[2:4], "another seed is another job"
        yield results_of(board, 2, 2) == results[2:4], "the job before it"
        status = board.ask("stop", "status")
        yield (status["state"], status["next"], status["end"]) == (0, 4, 4), f"idle afterwards: {status}"
        long = board.set_case(**(SOFT if soft else {}), ticks=4000000, window_last=4000000)["case_crc"]
        for first, seed in ((0, 1), (1, 1), (1, 2)):            # all are left half done
            board.send("run", case_crc=long, seed=seed, first=first, count=1)
            board.wait(lambda m: m[0] == "status" and m[2]["state"] == 1)
        board.ask("stop", "status")
        board.set_case(**(SOFT if soft else {}))
        yield results_of(board, 1, 2, seed=2) and results_of(board, 0, 3) == results[:3], "other jobs after those that were left half done"
        board.set_case(mu=as_float(3000.0), **(SOFT if soft else {}))
        refused = results_of(board, 0, 2)
        yield all(r["status"] == 1 and r["stuck"] == 0 and r["ss"] == 0 for r in refused), f"a step that is too long for such friction: {refused}"


def error_of(board, name, answer="status", **fields):
    return board.ask(name, answer, **fields).get("error")


def refuses(target):
    with Board(target) as board:
        run = {"case_crc": 1, "seed": 1, "first": 0, "count": 1}
        yield error_of(board, "stop") == 1, "a request before hello"
        reply = board.hello(schema=link.SCHEMA ^ 1)
        yield reply["schema"] == link.SCHEMA and reply["board"] == target, "hello of another schema is answered with this one's"
        yield error_of(board, "stop") == 1 and error_of(board, "run", **run) == 1, "nothing else is"
        board.hello()
        yield error_of(board, "run", "result", **run) == 6, "run without a case"
        yield board.set_case(fc=-1.0).get("error") == 5, "a case that the table refuses"
        yield board.set_case(mu=0.1).get("error") == 3, "a number that is no float"
        crc = board.set_case()["case_crc"]
        yield crc == link.crc32c(link.link_codec.pack(link.MESSAGES["case_set"][2], CASE)), "the case's name"
        yield board.set_case()["case_crc"] == crc, "the case again"
        run["case_crc"] = crc
        yield error_of(board, "run", "result", **{**run, "count": 0}) == 4, "no realisations"
        yield error_of(board, "run", "result", **{**run, "first": 0xFFFFFFFF, "count": 1}) == 4, "an index too large"
        yield error_of(board, "lock_step", "lock_answer", session=9, frame=1, ticks=1, top_speed=1.0, weight=1.0) == 7, "no session"
        session = board.ask("plant_start", "plant_reply", case_crc=crc, mode=3, **START)["session"]
        yield error_of(board, "lock_step", "lock_answer", session=session, frame=1, ticks=1, top_speed=1.0, weight=1.0) == 8, "lockstep in real time"
        yield board.set_case(mu=as_float(0.03)).get("error") == 8, "another case while a string runs"
        board.ask("stop", "status")
        command = {"session": session, "number": 1, "top_speed": 5.0, "ramp_ticks": 10, "weight": 80000.0}
        yield error_of(board, "rt_command", "rt_ack", **command) == 7, "a command after the end"
        for ns in (500000, 1500000):
            crc = board.set_case(step_ns=ns)["case_crc"]
            yield error_of(board, "plant_start", "plant_reply", case_crc=crc, mode=3, **START) == 4, f"real time with a step of {ns} ns"
            board.line("start")
            yield board.line("SYST:ERR?").startswith("-221"), f"and on the console: {ns} ns"
        reply = board.ask("plant_start", "plant_reply", case_crc=board.set_case(mu=as_float(3000.0))["case_crc"], mode=2, **START)
        yield reply["status"] == 1, f"a string whose step is too long: {reply}"
        board.set_case()
        for number, body, code, what in ((77, b"", 2, "no such type"), (2, b"", 2, "an answer as a request"), (77, bytes(range(256)) + bytes(135), 2, "the largest frame"),
                                         (9, b"\0", 3, "a body that is too long"), (6, b"\0" * 19, 3, "one that is too short"), (1, b"\0" * 9, 3, "a hello of another size")):
            board.pump(link.raw_frame(number, 4000 + number, body))
            got = board.wait(lambda m, n=number: m[1] == 4000 + n)
            yield got[0] == "error" and (got[2]["code"], got[2]["of_type"]) == (code, number), f"{what}: {got}"
        yield board.hello()["board"] == target, "hello after it all"


def survives(target, garbage):
    """Garbage, frames that are too long or broken, a hello in the middle of everything."""
    noise = random.Random(target)
    with Board(target) as board:
        board.hello()
        board.set_case()
        begin = time.monotonic()
        for _ in range(garbage // 65536):
            board.pump(noise.randbytes(65536))
        board.pump(b"\0")
        yield board.hello()["board"] == target, f"{garbage} bytes of garbage, then hello ({time.monotonic() - begin:.1f} s)"
        bad = board.ask("stop", "status")["bad"]
        board.pump(b"\0" + b"\1" * 5000 + b"\0")
        good = link.frame("stop", 99)
        board.pump(good[:7] + bytes([good[7] ^ 4]) + good[8:] + good[:5] + good)
        status = board.wait(lambda m: m[0] == "status" and m[1] == 99)[2]
        yield status["bad"] - bad == 3, f"an over-long, a flipped and a cut frame are counted: {status['bad'] - bad}"
        board.set_case(window_last=400000, ticks=400000)
        board.send("run", case_crc=board.case_crc, seed=1, first=0, count=100)
        yield board.wait(lambda m: m[0] == "status" and m[2]["state"] == 1)[2]["end"] == 100, "in a campaign"
        board.hello()
        board.heard.clear()
        yield board.wait(lambda m: m[0] == "status")[2]["state"] == 0 and not [m for m in board.heard if m[0] == "result"], "hello ends it"


def bears_any_frame(target, frames):
    """Frames with a right CRC and anything in them: each is answered, none ends the program."""
    chance, answers = random.Random(target), set()
    requests = [(number, fields) for number, _, fields in link.MESSAGES.values() if number > 1]

    def some(kind, low, high):
        if kind == "real":
            return struct.pack("<d", as_float(chance.uniform(0, 50)))
        if kind == "u8":
            return bytes([chance.randint(low, high)])
        size = {"u16": 2, "u32": 4, "u64": 8, "f32": 4, "text": 2}[kind]
        return chance.choice((bytes(size), chance.randbytes(size), b"\1" + bytes(size - 1)))

    with Board(target) as board:
        board.hello()
        board.set_case()
        for seq in range(1001, 1001 + frames):
            number, fields = chance.choice(requests)
            body = b"".join(some(*field[1:]) for field in fields)
            body = struct.pack("<I", board.case_crc) + body[4:] if chance.random() < 0.5 else body
            board.pump(link.raw_frame(number, seq, body[:chance.choice((400, 400, 400, chance.randrange(60)))]))
            if number not in (6, 12):      # those are answered by results, or when the steps are done
                got = board.wait(lambda m, seq=seq: m[1] == seq)
                answers.add((got[0], got[2].get("code")))
        yield len(answers) >= 8, f"answers of all kinds: {answers}"
        board.hello()
        yield board.set_case()["case_crc"] == board.case_crc and len(results_of(board, 0, 1)) == 1, "and a campaign"


def steps_together(targets):
    """Two boards, the same commands: equal answers, whatever is repeated."""
    with Board(targets[0]) as one, Board(targets[1]) as other:
        starts = []
        for board in (one, other):
            board.hello()
            board.set_case(rotating=1)
            ask = {"case_crc": board.case_crc, "mode": 2, **START, "source": 1, "seed": 3, "index": 11}
            starts.append(board.ask("plant_start", "plant_reply", seq=70, **ask))
        yield starts[0] == starts[1] == {"session": 70, "status": 0, "reason": 0}, f"{starts}"
        differ, moved = [], set()
        for frame in range(1, 101):
            ask = {"session": 70, "frame": frame, "ticks": 50, "top_speed": as_float(W0 * (1 + (frame % 40) / 80)), "weight": 90000.0 + 500 * (frame % 30)}
            answers = [board.ask("lock_step", "lock_answer", **ask) for board in (one, other)]
            if frame % 10 == 0:
                answers.append(one.ask("lock_step", "lock_answer", **ask))
                answers.append(one.ask("plant_start", "plant_reply", seq=70, case_crc=one.case_crc, mode=2, **START) and answers[0])
            differ += [frame] if any(a != answers[0] for a in answers) else []
            moved.add(answers[0].get("bit_speed"))
            last = answers[0]
        yield not differ, f"frames with different answers: {differ}"
        yield last.get("tick") == 5000 and last["sane"] == 1 and len(moved) == 100 and last["top_speed"] == ask["top_speed"], f"5 s: {last}"
        for wrong, code in (({"frame": 99}, 7), ({"frame": 102}, 7), ({"frame": 101, "ticks": 0}, 4), ({"frame": 101, "weight": -1.0}, 4), ({"frame": 101, "weight": 1e10}, 4), ({"session": 71}, 7)):
            yield error_of(one, "lock_step", "lock_answer", **{**ask, **wrong}) == code, f"{wrong} is error {code}"
        yield one.ask("lock_step", "lock_answer", **{**ask, "frame": 101, "ticks": 1})["tick"] == 5001, "and the next one goes on"
        long = {**ask, "frame": 102, "ticks": 20000}
        one.send("lock_step", 9001, **long)
        one.send("lock_step", 9002, **long)
        yield error_of(one, "lock_step", "lock_answer", **{**ask, "frame": 103}) == 7, "not before the answer"
        got = [m for m in (one.wait(lambda m: m[0] == "lock_answer"),) if m[1] == 9002]
        yield len(got) == 1 and got[0][2]["tick"] == 25001, "a request that comes again is answered once, to the last"
        one.hello()
        yield error_of(one, "lock_step", "lock_answer", **{**ask, "frame": 103}) == 7, "not after a hello"


# ---- real time ----

def real_time(target, **changes):
    """One session on the emulator's own clock -> (samples, report, fields of the start)."""
    with Board(target, icount=CLOCK) as board:
        board.hello()
        board.set_case()
        start = board.ask("plant_start", "plant_reply", case_crc=board.case_crc, mode=3, **{**START, **changes})
        samples = []
        while (got := board.wait(lambda m: m[0] in ("rt_sample", "rt_report")))[0] == "rt_sample":
            samples.append(got[2])
        asked = board.ask("rt_query", "rt_report", session=start["session"])
        return samples, got[2], asked == got[2]


def strings(samples):
    return [{k: v for k, v in s.items() if k not in ("worst_late_us", "load_permille")} for s in samples]


def keeps_time(target, seconds=60):
    samples, report, kept = real_time(target, duration=1000 * seconds, stream_ticks=1000)
    print(f"{target}: {seconds} s at 1 kHz and 32 ns an instruction: late {report['late']}, worst start {report['worst_late_us']} us, load "
          f"{report['load_permille'] / 10} %, longest step {report['load_worst_permille'] / 10} %", flush=True)
    yield report["late"] == 0 and report["tick"] == 1000 * seconds and report["samples"] == seconds == len(samples), f"{report}"
    yield 0 < report["load_permille"] < 200 and report["worst_late_us"] < 100 and report["unsane"] == report["timeouts"] == 0, f"load: {report}"
    yield kept, "the books can be asked for afterwards"
    yield [s["tick"] for s in samples] == list(range(1000, 1000 * seconds + 1, 1000)), "a sample each second"
    yield len({s["bit_speed"] for s in samples}) == seconds and all(s["top_speed"] == W0 for s in samples), "samples"
    again, second, _ = real_time(target, duration=10000, stream_ticks=1000)
    yield strings(again) == strings(samples[:10]) and second["late"] == 0, "twice the same"


def counts_overloads(target):
    for steps, us in ((7, 1500), (3, 1100), (5, 1700), (4, 900)):
        _, report, _ = real_time(target, duration=9500, overload_steps=steps, overload_us=us)
        want = steps if us > 1000 else 0
        yield report["late"] == want and report["tick"] == 9500, f"{steps} steps of {us} us: {report['late']} late"
        yield us < 1000 or us - 1000 <= report["worst_late_us"] <= us - 900, f"worst {report['worst_late_us']} us after {us} us"


def bites(target):
    """A step that does not end: the watchdog names it, where there is one."""
    with Board(target, icount=CLOCK) as board:
        watchdog = board.hello()["watchdog"]
        board.set_case()
        board.send("plant_start", case_crc=board.case_crc, mode=3, **{**START, "duration": 3000, "overload_steps": 1, "overload_us": 3000000})
        try:
            late = board.wait(lambda m: m[0] == "rt_report")[2]["late"]
            yield watchdog == 0 and late > 1000, f"no watchdog: {late} late"
        except Silent:
            said = bytes(board.text[-200:])
            yield watchdog == 1 and b"fault: watchdog: no checked step in time" in said and board.process.wait(5) == 70, f"{said!r}"


def watches_the_host(target):
    samples, report, _ = real_time(target, duration=6000, stream_ticks=250, command_ms=2000, policy=1, ramp_ms=2000)
    speeds = {s["tick"]: s["top_speed"] for s in samples}
    yield report["timeouts"] == 1 and report["state"] == 2 and report["unsane"] == 0, f"ramp: {report}"
    yield speeds[1750] == W0 and abs(speeds[3000] - W0 / 2) < 0.01 * W0 and speeds[4250] == 0 and speeds[6000] == 0, f"ramp: {speeds}"
    samples, report, _ = real_time(target, duration=6000, stream_ticks=1000, command_ms=2000, policy=0)
    yield report["state"] == 1 and report["timeouts"] == 1 and report["tick"] == 6000 and samples[-1]["top_speed"] == W0, f"hold: {report}"
    samples, report, _ = real_time(target, duration=6000, command_ms=2000, policy=2)
    yield report["state"] == 3 and report["timeouts"] == 1 and 1990 <= report["tick"] <= 2010, f"stop: {report}"


def takes_commands(target):
    """In the time of this machine: what is late is its affair."""
    with Board(target) as board:
        board.hello()
        board.set_case()
        ask = {"case_crc": board.case_crc, "mode": 3, **START, "stream_ticks": 50, "command_ms": 20000}
        session = board.ask("plant_start", "plant_reply", seq=500, **ask)["session"]
        command = {"session": session, "number": 1, "top_speed": as_float(5.0), "ramp_ticks": 200, "weight": 80000.0}
        yield board.ask("rt_command", "rt_ack", **command) == {"session": 500, "number": 1}, "acknowledged"
        yield board.wait(lambda m: m[0] == "rt_sample" and m[2]["top_speed"] == as_float(5.0))[2]["tick"] >= 200, "the top gets there"
        yield board.ask("rt_command", "rt_ack", **{**command, "top_speed": 9.0}) == {"session": 500, "number": 1}, "an old number changes nothing"
        yield board.ask("plant_start", "plant_reply", seq=500, **ask)["session"] == 500, "the start again starts nothing"
        board.heard.clear()
        sample = board.wait(lambda m: m[0] == "rt_sample")[2]
        yield sample["tick"] > 200 and sample["top_speed"] == as_float(5.0) and sample["state"] == 0, f"{sample}"
        yield error_of(board, "rt_command", "rt_ack", **{**command, "number": 2, "weight": 0.0}) == 4, "no weight"
        yield error_of(board, "rt_command", "rt_ack", **{**command, "number": 2, "ramp_ticks": 0}) == 4, "no time to get there"
        report = board.ask("rt_query", "rt_report", session=session)
        yield report["commands"] == 1 and report["tick"] > 200, f"{report}"
        board.wait(lambda m: m[0] == "rt_sample" and m[2]["tick"] > 2300)
        shown = wits.one(board.ask("wits_query", "wits")["text"].encode("ascii"))
        yield shown["0120"] == 48 and shown["0107"] == 2 and shown["0113"] is None and 0 < shown["0116"] < 30 and shown["0921"] < shown["0923"] < shown["0922"], f"WITS: {shown}"
        board.ask("stop", "status")
        results_of(board, 0, 4)
        shown = wits.one(board.ask("wits_query", "wits")["text"].encode("ascii"))
        yield shown["0927"] == 4 and shown["0926"] == 1.0, f"P of the campaign: {shown}"


def reading_until(board, fits, seconds=20):
    """The values of READ? when they fit; None if they never do."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        values = [float(v) for v in board.line("READ?").split(",")]
        if fits(values):
            return values
        time.sleep(0.1)
    return None


def talks_to_people(target):
    with Board(target) as board:
        yield re.fullmatch(r"kelly,%s,paper-[0-9a-f]{8},1\.0\.0" % target, board.line("*idn?")), "*IDN? is the first input"
        yield board.line("SYST:ERR?") == '0,"No error"', "no error"
        for line in ("BOGUS 1", "rpm", "rpm -5", "read?", "mu x", "stop 1"):
            board.line(line) if "?" not in line else board.pump(line.encode() + b"\n")
        errors = [board.line("system:error?").split(",")[0] for _ in range(5)]
        yield errors == ["-113", "-109", "-222", "-350", "0"], f"a queue of four: {errors}"
        for line in ("wob 9 kN", "wob 1234567890", "stop 1", "systemerror?x"):
            board.pump(line.encode() + b"\n")
        errors = [board.line("Syst:Error?").split(",")[0] for _ in range(5)]
        yield errors == ["-121", "-121", "-108", "-113", "0"], f"parameters: {errors}"
        for line in ("wits", "wits 2", "wob 0.5", "wob 9999"):
            board.line(line)
        errors = [board.line("SYST:ERR?").split(",")[0] for _ in range(4)]
        yield errors == ["-109", "-222", "-222", "-222"], f"out of range: {errors}"
        board.line("bogus")
        board.line("*CLS")
        yield board.line("SYST:ERR?") == '0,"No error"', "*CLS empties the queue"
        board.pump(b"WITS?\n")
        yield wits.one(board.wait_text(b"!!\r\n"))["0120"] is None, "WITS? without a string"
        for line in ("rpm 120", "WOB 90.5", "Mu .004"):
            board.line(line)
        yield [board.line(q) for q in ("RPM?", "WOB?", "MU?")] == ["120.00", "90.50", "0.004000"], "settings"
        board.line("start")
        board.line("mu 0.03")
        values = reading_until(board, lambda v: v[0] > 0.5)
        yield values and len(values) == 6 and abs(values[2] - 120) < 0.01 and 40 < values[5] < 140, f"reading {values}"
        yield board.line("SYST:ERR?").startswith("-221"), "mu while it runs"
        board.line("rpm 99999999")
        yield board.line("SYST:ERR?").startswith("-222"), "a speed that the step cannot be trusted with"
        board.line("RPM 60")
        yield reading_until(board, lambda v: v[2] == 60), "the top follows"
        yield re.fullmatch(r"\d+,\d+,\d+\.\d", board.line("STATus?")), "status"
        board.line("wits 1")
        said = board.wait_text(b"!!\r\n") + board.wait_text(b"!!\r\n")
        yield [f["0120"] for f in wits.frames(said)][1:] == [60], f"WITS of the console: {said!r}"
        board.pump(b"WITS 0\nSYST:ERR?\n")
        board.wait_text(b'0,"No error"\r\n')       # behind it no WITS comes any more
        board.line("STOP")
        board.line("  *RST")
        yield board.line("RPM?") == "%.2f" % (W0 * 30 / math.pi), "*RST: the table's case"
        board.line("wits on")
        board.line("wits off")
        yield board.line("SYST:ERR?") == '0,"No error"', "no error at the end"
        yield board.hello()["board"] == target, "a hello finds the bench behind the console"
        board.set_case()
        board.ask("plant_start", "plant_reply", case_crc=board.case_crc, mode=3, **START)
        board.line("RPM 10")
        yield board.line("SYST:ERR?").startswith("-221"), "the host's string is not the console's"


def scenarios():
    yield "overload", counts_overloads, ("stm32f405",)
    for target in ("stm32f405", "mps2-an500", "rv32"):
        yield "real time", keeps_time, (target,)
        yield "wedged", bites, (target,)
    yield "garbage", survives, ("rv32", 1 << 20)
    yield "garbage", survives, ("stm32f405", 1 << 16)
    for target in ("mps2-an500", "rv32"):
        yield "any frame", bears_any_frame, (target, 3000)
    for target in BOARDS:
        yield "hello", says_who_it_is, (target,)
        yield "campaign", runs_a_campaign, (target,)
    yield "campaign, soft drive", runs_a_campaign, ("mps2-an500", 4, True)
    for target in ("stm32f405", "rv32"):
        yield "refusals", refuses, (target,)
    yield "lockstep", steps_together, (("stm32f405", "rv32"),)
    yield "lockstep", steps_together, (("mps2-an500", "microbit"),)
    for target in ("stm32f405", "rv32"):
        yield "host watched", watches_the_host, (target,)
    for target in ("mps2-an500", "rv32"):
        yield "commands", takes_commands, (target,)
    for target in ("stm32f405", "rv32"):
        yield "console", talks_to_people, (target,)


if __name__ == "__main__":
    sys.exit(run_scenarios(__doc__, ((f"{name} {arguments[0]}", function, arguments) for name, function, arguments in scenarios()), BOARDS))
