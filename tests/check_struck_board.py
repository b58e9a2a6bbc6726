#!/usr/bin/env python3
"""check_struck_board - a bit of the state of a realisation flips on an emulated board, at any instruction of a step.

usage: tests/check_struck_board.py [STRIKES]      of each board, default 40

The emulator's debugger stops the device program somewhere within its steps, in the code that the board's compiler made, turns a bit of the
lane or of a mode in memory, and lets it go on. Either the realisation is refused as corrupt, or no bit of it is another. Last line
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

from run_target import ROOT, command, run, target_settings

BOARDS = ("stm32f405", "rv32")
LINE = "samples=1 seconds=2 from=1 mu_e6=4000"
STEPS = 2400                     # instructions: some four steps
MEMBERS = ["wave", "dwave", "muf", "t1", "y1", "y2", "y3", "y4", "lowest", "highest", "guard"]


class Debugger:
    """Of the emulator: the few packets that are wanted here."""

    def __init__(self, port):
        for _ in range(100):
            try:
                self.line = socket.create_connection(("127.0.0.1", port))
                self.line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                return
            except OSError:
                time.sleep(0.05)
        raise RuntimeError("no debugger")

    def send(self, text):
        self.line.sendall(f"${text}#{sum(text.encode()) & 255:02x}".encode())

    def ask(self, text):
        self.send(text)
        answer = b""
        while not re.search(rb"\$[^#]*#..$", answer):
            got = self.line.recv(4096)
            if not got:
                raise RuntimeError(f"the debugger is gone after {text}")
            answer += got
        self.line.sendall(b"+")
        return re.search(rb"\$([^#]*)#..$", answer)[1].decode()


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def symbols(settings, elf):
    said = subprocess.run([settings["CROSS"] + "nm", elf], capture_output=True, text=True, check=True).stdout
    return {w[2]: int(w[0], 16) for w in map(str.split, said.splitlines()) if len(w) == 3}


def places(settings):
    """Offsets of the state within a kelly_block, from the board's compiler."""
    wanted = [f"lane[0].{m}" for m in MEMBERS] + [f"slow[0][{i}].{m}" for i in range(10) for m in "vx"]
    code = '#include "ensemble.h"\nconst unsigned places[] = { ' + ", ".join(f"offsetof(kelly_block, {w})" for w in wanted) + " };\n"
    words = [settings["CROSS"] + "gcc", *settings["ARCH"].replace("\\", "").split(), "-std=c11", "-ffreestanding", "-Ifirmware", "-S", "-x", "c", "-", "-o", "-"]
    said = subprocess.run(words, cwd=ROOT, input=code, capture_output=True, text=True, check=True).stdout
    found = [int(n) for n in re.findall(r"\.word\s+(\d+)", said)]
    return dict(zip(wanted, found, strict=True))


def struck(settings, elf, call, instructions, offset, bit):
    """What the program says, struck so many instructions into its `call`th part."""
    port = free_port()
    words = command(settings, elf, extra=["-S", "-gdb", f"tcp:127.0.0.1:{port}"])
    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        said = pool.submit(run, words, [LINE], 120)
        debugger = Debugger(port)
        arm = settings["FAMILY"] == "cortexm"
        stop = f"0,{symbols(settings, elf)['kelly_block_advance'] & ~1:x},{2 if arm else 4}"
        debugger.ask("Z" + stop)
        for _ in range(call):
            debugger.ask("c")
        first = 0 if arm else 10                                     # r0, a0: the block
        at = int.from_bytes(bytes.fromhex(debugger.ask("g")[8 * first:8 * first + 8]), "little") + offset
        debugger.ask("z" + stop)
        for _ in range(instructions):
            debugger.ask("s")
        word = int.from_bytes(bytes.fromhex(debugger.ask(f"m{at:x},4")), "little") ^ 1 << bit
        debugger.ask(f"M{at:x},4:{word.to_bytes(4, 'little').hex()}")
        debugger.send("c")
        status, text = said.result()
    return status, text.decode(errors="replace")


def outcome(clean, said):
    if "refused: corrupt" in said:
        return "detected"
    return "same" if re.sub(r"stack .*", "", clean) == re.sub(r"stack .*", "", said) else "other"


def board(name, strikes):
    """(counts of outcomes, what went wrong)"""
    settings, elf = target_settings(name), os.path.join(ROOT, "build", name, "device.elf")
    subprocess.run(["make", "-s", f"TARGET={name}", "device"], cwd=ROOT, check=True)
    offsets, draw = places(settings), random.Random(20261128)
    clean = run(command(settings, elf), [LINE], 120)[1].decode(errors="replace")
    counts, wrong = {"same": 0, "detected": 0, "other": 0}, []
    for _ in range(strikes):
        place, bit, call, instructions = draw.choice(sorted(offsets)), draw.randrange(32), draw.choice((1, 2)), draw.randrange(40, STEPS)
        _, said = struck(settings, elf, call, instructions, offsets[place], bit)
        counts[outcome(clean, said)] += 1
        if outcome(clean, said) == "other":
            wrong.append(f"{name}: {place} bit {bit}, part {call}, {instructions} instructions: {said[-300:]}")
    return counts, wrong


def main():
    strikes = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    failed = passed = 0
    with concurrent.futures.ThreadPoolExecutor(len(BOARDS)) as pool:
        for name, (counts, wrong) in zip(BOARDS, pool.map(lambda name: board(name, strikes), BOARDS)):
            print(*wrong, sep="\n")
            print(f"figure: faults in the state, bits, at any instruction, {name}: {strikes}, of them same {counts['same']} detected {counts['detected']} other {counts['other']}")
            seen = counts["detected"] > strikes // 4          # most words live most of the time
            passed, failed = passed + strikes - len(wrong) + seen, failed + len(wrong) + (not seen)
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
