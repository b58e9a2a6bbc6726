#!/usr/bin/env python3
"""check_struck_board - a bit of the state of a string flips on an emulated board, at any instruction of a step.

usage: tests/check_struck_board.py [STRIKES]      of each board and kind of top, default 40, of those asked over the line a fourth

Tops: stiff (a line of the console), soft (a campaign over the line), commanded (lockstep). The emulator's debugger stops the device program
somewhere within its steps, in the code that the board's compiler made, turns a bit of the lane or of a mode in memory, and lets it go on.
Either the realisation is refused as corrupt and the string said not to be sane, or no bit of what is told is another. Last line
`N passed, N failed`.
"""
import concurrent.futures
import os
import random
import re
import socket
import subprocess
import sys
import time

from bench_board import Board
from check_bench_device import SOFT, START, W0
from run_target import ROOT, command, run, target_settings

BOARDS = ("stm32f405", "rv32")
LINE = "samples=1 seconds=2 from=1 mu_e6=4000"
STEPS = 2400                     # instructions: some four steps
CORRUPT = 4                      # kelly_status
SLOW = 120                       # s: a board that is stepped through on a busy machine
LANE = ["wave", "dwave", "muf", "t1", "y1", "y2", "y3", "y4", "lowest", "highest", "guard"]
TOP = ["eta", "phi", "sine", "cosine", "speed", "lowest", "highest", "guard", *(f"{o}.at[{k}]" for o in "yp" for k in range(4))]
# struct: its words that are struck
STATE = {"kelly_block": [*(f"lane[0].{m}" for m in LANE), *(f"slow[0][{i}].{m}" for i in range(10) for m in "vx")],
         "kelly_driven": [*(f"lane[0].{m}" for m in TOP), *(f"mode[0][{i}].{m}" for i in range(10) for m in "vx"), "phase[0]", "phases"]}


class Debugger:
    """Of the emulator: the few packets that are wanted here. A program that runs is stopped by it."""

    def __init__(self, port):
        self.line, self.heard = self.connect(port), bytearray()
        self.line.settimeout(SLOW / 2)
        self.line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    @staticmethod
    def connect(port):
        for _ in range(100):
            try:
                return socket.create_connection(("127.0.0.1", port))
            except OSError:
                time.sleep(0.05)
        raise RuntimeError("no debugger")

    def send(self, text):
        self.line.sendall(f"${text}#{sum(text.encode()) & 255:02x}".encode())

    def ask(self, text):
        self.send(text)
        return self.answer()

    def answer(self):
        """The next packet, also of several that have come at once; not that which some emulators send of the stop as we came (T02, SIGINT)."""
        while not (packet := re.search(rb"\$([^#]*)#..", self.heard)):
            got = self.line.recv(4096)
            if not got:
                raise RuntimeError("the debugger is gone")
            self.heard += got
        said = packet[1].decode()
        del self.heard[:packet.end()]
        self.line.sendall(b"+")
        return self.answer() if said.startswith("T02") else said


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def symbols(settings, elf):
    said = subprocess.run([settings["CROSS"] + "nm", elf], capture_output=True, text=True, check=True).stdout
    return {w[2]: int(w[0], 16) for w in map(str.split, said.splitlines()) if len(w) == 3}


def places(settings, struct):
    """{word of the state: its offset within the struct}, from the board's compiler."""
    code = '#include "ensemble.h"\nconst unsigned places[] = { ' + ", ".join(f"offsetof({struct}, {w})" for w in STATE[struct]) + " };\n"
    words = [settings["CROSS"] + "gcc", *settings["ARCH"].replace("\\", "").split(), "-std=c11", "-ffreestanding", "-Ifirmware", "-S", "-x", "c", "-", "-o", "-"]
    said = subprocess.run(words, cwd=ROOT, input=code, capture_output=True, text=True, check=True).stdout
    found = [int(n) for n in re.findall(r"\.word\s+(\d+)", said)]
    return dict(zip(STATE[struct], found, strict=True))


class Strike:
    """So many instructions into the `call`th advance of this struct, a bit of the word at `offset` in it."""

    def __init__(self, settings, elf, struct, place):
        self.arm = settings["FAMILY"] == "cortexm"
        self.stop = f"0,{symbols(settings, elf)[struct + '_advance'] & ~1:x},{2 if self.arm else 4}"
        self.call, self.instructions, self.offset, self.bit = place

    def wait(self, debugger):
        """The breakpoint is set before this, and the program on its way."""
        for _ in range(self.call - 1):
            debugger.answer()
            debugger.send("c")
        debugger.answer()
        first = 0 if self.arm else 10                                 # r0, a0: the struct
        at = int.from_bytes(bytes.fromhex(debugger.ask("g")[8 * first:8 * first + 8]), "little") + self.offset
        debugger.ask("z" + self.stop)
        for _ in range(self.instructions):
            debugger.ask("s")
        word = int.from_bytes(bytes.fromhex(debugger.ask(f"m{at:x},4")), "little") ^ 1 << self.bit
        debugger.ask(f"M{at:x},4:{word.to_bytes(4, 'little').hex()}")
        debugger.send("c")


def estimate(target, elf, strike=None):
    """What the console says of one realisation, (whether it is refused as corrupt, all of it)."""
    settings, port = target_settings(target), free_port()
    words = command(settings, elf, extra=["-S", "-gdb", f"tcp:127.0.0.1:{port}"] if strike else ())
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        said = pool.submit(run, words, [LINE], 120)
        if strike:
            debugger = Debugger(port)
            debugger.ask("Z" + strike.stop)
            debugger.send("c")
            strike.wait(debugger)
        text = re.sub(r"stack .*", "", said.result()[1].decode(errors="replace"))
    return "refused: corrupt" in text, text


def over_the_line(target, elf, strike, case, ask):
    """The same of what `ask(board)` sends and hears, struck while the board is at it."""
    port = free_port()
    with Board(target, elf=elf, extra=["-gdb", f"tcp:127.0.0.1:{port}"]) as board:
        board.hello()
        board.set_case(**case)
        if not strike:
            return ask(board)
        debugger = Debugger(port)                                     # which stops the program
        debugger.ask("Z" + strike.stop)
        debugger.send("c")
        with concurrent.futures.ThreadPoolExecutor(1) as pool:
            done = pool.submit(strike.wait, debugger)
            try:
                return ask(board)
            finally:
                done.result()                                         # what went wrong in it is the cause of what went wrong here


def campaign(target, elf, strike=None):
    def ask(board):
        board.send("run", case_crc=board.case_crc, seed=1, first=1, count=1)
        result = board.wait(lambda m: m[0] == "result", SLOW)[2]
        return result["status"] == CORRUPT, result
    return over_the_line(target, elf, strike, SOFT, ask)


def lockstep(target, elf, strike=None):
    def ask(board):
        session = board.ask("plant_start", "plant_reply", case_crc=board.case_crc, mode=2, **START)["session"]
        answers = []
        for frame, speed in ((1, W0), (2, W0), (3, 9.0)):
            board.send("lock_step", session=session, frame=frame, ticks=60, top_speed=speed, weight=1e5)
            answers.append(board.wait(lambda m: m[0] == "lock_answer", SLOW)[2])
        return not answers[-1]["sane"], answers
    return over_the_line(target, elf, strike, {}, ask)


# kind of top: (struct, how it is run and asked, share of the strikes, which calls are struck)
TOPS = {"stiff": ("kelly_block", estimate, 1, (1, 2)), "soft": ("kelly_driven", campaign, 4, (1, 2, 25)), "commanded": ("kelly_driven", lockstep, 4, (1, 2, 25))}


def strikes_of(target, top, count):
    """(counts of outcomes, what went wrong)"""
    struct, how, share, calls = TOPS[top]
    settings, elf = target_settings(target), os.path.join(ROOT, "build", target, "device.elf")
    offsets, draw = places(settings, struct), random.Random(20261128)
    _, clean = how(target, elf)
    counts, wrong = {"same": 0, "detected": 0, "other": 0}, []
    for _ in range(count // share):
        place, bit, call, instructions = draw.choice(sorted(offsets)), draw.randrange(32), draw.choice(calls), draw.randrange(40, STEPS)
        detected, said = how(target, elf, Strike(settings, elf, struct, (call, instructions, offsets[place], bit)))
        outcome = "detected" if detected else "same" if said == clean else "other"
        counts[outcome] += 1
        if outcome == "other":
            wrong.append(f"{target}, {top}: {place} bit {bit}, call {call}, {instructions} instructions: {str(said)[-300:]}")
    return counts, wrong


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    for target in BOARDS:
        subprocess.run(["make", "-s", f"TARGET={target}", "device"], cwd=ROOT, check=True)
    failed = passed = 0
    each = [(target, top) for top in TOPS for target in BOARDS]
    with concurrent.futures.ThreadPoolExecutor(len(BOARDS)) as pool:
        for (target, top), (counts, wrong) in zip(each, pool.map(lambda of: strikes_of(*of, count), each)):
            strikes = sum(counts.values())
            print(*wrong, sep="\n", end="\n" if wrong else "")
            print(f"figure: faults in the state, bits, at any instruction, {target}, {top} top: {strikes}, of them same {counts['same']} "
                  f"detected {counts['detected']} other {counts['other']}")
            seen = counts["detected"] > strikes // 4          # most words live most of the time
            passed, failed = passed + strikes - len(wrong) + seen, failed + len(wrong) + (not seen)
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
