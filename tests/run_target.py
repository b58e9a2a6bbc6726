#!/usr/bin/env python3
"""run_target.py - run one image in the emulator of its target: UART on stdout, its exit status as ours.

usage: tests/run_target.py --target NAME [--timeout S] [--counting | --icount TEXT] [--line TEXT]...
                           [--stdin] [--qemu OPTION]... IMAGE.elf

The machine comes from linker/NAME.mk. Each line `?` that the image prints is a question (firmware/app/line.h): it is
answered with the next --line, and with an empty line when there are no more. --stdin gives our stdin to the UART instead
and answers nothing. --counting adds the -icount option under which board_measure_end is exact, --icount one of your own
(shift=5,sleep=off). Exit: the image's status (70 a fault), 124 time-out, 125 the emulator gave up.
"""
import argparse
import os
import re
import selectors
import signal
import subprocess
import sys
import time

TIMED_OUT, EMULATOR_FAILED = 124, 125
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def target_settings(name):
    """The variables of linker/NAME.mk."""
    path = os.path.join(ROOT, "linker", name + ".mk")
    with open(path, encoding="utf-8") as file:
        return dict(re.findall(r"^(\w+) *:= *(.*?) *$", file.read(), re.M))


def command(settings, elf, icount=None, extra=()):
    """The emulator's command line; the UART is its stdin and stdout."""
    words = settings["QEMU"].split() + ["-display", "none", "-monitor", "none", "-serial", "stdio"]
    if settings["FAMILY"] == "cortexm":
        words += ["-semihosting-config", "enable=on,target=native"]
    if icount:
        words += ["-icount", icount]
    return words + list(extra) + ["-kernel", elf]


class Answers:
    """Answers each `?` line of a stream of output; lines None: never."""

    def __init__(self, lines, write):
        self.silent, self.lines, self.write, self.seen = lines is None, list(lines or ()), write, b""

    def hear(self, data):
        """What is for others: all but the questions that are answered here."""
        if self.silent:
            return data
        rest = b""
        *whole, self.seen = (self.seen + data).split(b"\n")
        for line in whole:
            if line.strip() == b"?":
                self.write((self.lines.pop(0) if self.lines else "").encode() + b"\n")
            else:
                rest += line + b"\n"
        return rest


def send(pipe, data):
    try:
        pipe.write(data)
        pipe.flush()
    except BrokenPipeError:   # it ended without reading: its status says why
        pass


def counting(settings):
    """The -icount under which an instruction is a known number of counts."""
    return "shift=" + settings["ICOUNT_SHIFT"]


def run(words, lines=(), timeout=60.0, out=None, stdin=subprocess.PIPE):
    """Run to the end or the time-out. Returns (status, output); `out` gets it as it comes, but for questions that
    are answered. An own stdin goes to the UART; then lines must be None."""
    process = subprocess.Popen(words, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    answers = Answers(lines, lambda data: send(process.stdin, data))
    output, end = bytearray(), time.monotonic() + timeout
    waiter = selectors.DefaultSelector()
    waiter.register(process.stdout, selectors.EVENT_READ)
    try:
        while (left := end - time.monotonic()) > 0:
            if not waiter.select(left):
                continue
            data = os.read(process.stdout.fileno(), 65536)
            if not data:
                return status_of(process.wait(max(left, 1))), bytes(output)
            output += data
            rest = answers.hear(data)
            if out:
                out.write(rest)
                out.flush()
    except subprocess.TimeoutExpired:
        pass
    finally:
        process.kill()
        process.wait()
        waiter.close()
        if out:
            out.write(answers.seen)
            out.flush()
    return TIMED_OUT, bytes(output)


def status_of(code):
    return EMULATOR_FAILED if code < 0 else code


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--target", required=True)
    parser.add_argument("--timeout", type=float, default=60.0)
    parser.add_argument("--counting", action="store_true")
    parser.add_argument("--icount")
    parser.add_argument("--stdin", action="store_true")
    parser.add_argument("--line", action="append", default=[])
    parser.add_argument("--qemu", action="append", default=[])
    parser.add_argument("elf")
    args = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))   # ends the emulator on the way out
    settings = target_settings(args.target)
    words = command(settings, args.elf, counting(settings) if args.counting else args.icount, args.qemu)
    source = (None, sys.stdin) if args.stdin else (args.line, subprocess.PIPE)
    status, _ = run(words, source[0], args.timeout, sys.stdout.buffer, source[1])
    if status == TIMED_OUT:
        print(f"run_target: {args.elf}: time-out after {args.timeout:g} s", file=sys.stderr)
    elif status == EMULATOR_FAILED:
        print(f"run_target: {args.elf}: the emulator gave up (lockup)", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
