"""bench_board - a device program in its emulator, talked to over its UART: frames by host/link_messages.py, and plain text.

    with Board("stm32f405") as board:
        reply = board.hello()
        board.ask("stop", "status")
"""
import os
import selectors
import struct
import subprocess
import sys
import time

from run_target import ROOT, command, target_settings

sys.path.insert(0, os.path.join(ROOT, "host"))
import link_messages as link      # noqa: E402

PATIENCE = 30.0                   # of a busy machine [s]


def image(target, real="float"):
    return os.path.join(ROOT, "build", target + ("-double" if real == "double" else ""), "device.elf")


def loaded(elf):
    """What is in flash: the segments of an ELF file with bytes in it, by physical address, gaps filled with 00."""
    with open(elf, "rb") as file:
        data = file.read()
    wide = data[4] == 2

    def number(at, size):
        return int.from_bytes(data[at:at + size], "little")

    word = 8 if wide else 4
    table, size, count = number(24 + word, word), number(54 if wide else 42, 2), number(56 if wide else 44, 2)
    parts = []
    for at in range(table, table + size * count, size):
        where, physical, length = (8, 24, 32) if wide else (4, 12, 16)
        if number(at, 4) == 1 and number(at + length, word) > 0:
            begin = number(at + where, word)
            parts.append((number(at + physical, word), data[begin:begin + number(at + length, word)]))
    first = min(start for start, _ in parts)
    flash = bytearray(max(start + len(part) for start, part in parts) - first)
    for start, part in parts:
        flash[start - first:start - first + len(part)] = part
    return bytes(flash)


class Silent(Exception):
    """The board did not say what was expected of it."""


class Board:
    def __init__(self, target, real="float", icount=None, elf=None, extra=(), words=None):
        self.words = words or command(target_settings(target), elf or image(target, real), icount, extra)
        self.process = subprocess.Popen(self.words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, bufsize=0)
        os.set_blocking(self.process.stdout.fileno(), False)
        os.set_blocking(self.process.stdin.fileno(), False)
        self.receiver, self.heard, self.text, self.seq, self.case_crc = link.Receiver(), [], bytearray(), 0, 0
        self.wait_text(b"?\n")    # before it, bytes may be lost

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()

    def pump(self, data=b"", seconds=0.0):
        """Send, and take what comes meanwhile: until all is sent, and at least one look, at most `seconds` long if nothing comes."""
        data, end = memoryview(bytes(data)), time.monotonic() + PATIENCE
        with selectors.DefaultSelector() as ready:
            ready.register(self.process.stdout, selectors.EVENT_READ)
            while True:
                if data:
                    try:
                        data = data[os.write(self.process.stdin.fileno(), data[:4096]):]
                        end = time.monotonic() + PATIENCE
                    except BlockingIOError:
                        pass
                came = bool(ready.select(0.01 if data else seconds)) and self.take()
                if not data:
                    return came
                if time.monotonic() > end:
                    raise Silent("the board takes no more bytes")

    def take(self):
        try:
            data = os.read(self.process.stdout.fileno(), 65536)
        except BlockingIOError:
            return False
        if not data:
            raise Silent(f"the emulator ended: {bytes(self.text[-200:])!r}")
        self.text += data
        del self.text[:-20000]
        self.heard += self.receiver.feed(data)
        return True

    def wait(self, fits, seconds=PATIENCE):
        """The first message heard that fits; it and what came before it are forgotten."""
        end = time.monotonic() + seconds
        while True:
            for k, message in enumerate(self.heard):
                if fits(message):
                    del self.heard[:k + 1]
                    return message
            left = end - time.monotonic()
            if left <= 0:
                raise Silent(f"nothing that fits; heard {self.heard[-3:]}")
            self.pump(seconds=left)

    def wait_text(self, text, seconds=PATIENCE):
        """Until text has come; what came up to its end, which is forgotten."""
        end = time.monotonic() + seconds
        while text not in self.text:
            left = end - time.monotonic()
            if left <= 0:
                raise Silent(f"no {text!r} in {bytes(self.text[-200:])!r}")
            self.pump(seconds=left)
        at = self.text.index(text) + len(text)
        said = bytes(self.text[:at])
        del self.text[:at]
        return said

    def send(self, name, seq=None, **fields):
        if seq is None:
            self.seq += 1
            seq = self.seq
        self.pump(link.frame(name, seq, **fields))
        return seq

    def ask(self, name, answer, seq=None, **fields):
        """-> the fields of the answer of that name, or of an error."""
        seq = self.send(name, seq, **fields)
        got = self.wait(lambda m: m[1] == seq and m[0] in (answer, "error"))
        if got[0] != answer:
            return {"error": got[2]["code"], **got[2]}
        return got[2]

    def hello(self, schema=link.SCHEMA, nonce=1):
        return self.ask("hello", "hello_reply", schema=schema, nonce=nonce)

    def set_case(self, **changes):
        got = self.ask("case_set", "case_reply", **{**CASE, **changes})
        self.case_crc = got.get("case_crc", 0)
        return got

    def line(self, text):
        """A line of the console; the answer where it asks for one."""
        self.text.clear()
        self.pump(text.encode() + b"\n")
        return self.wait_text(b"\r\n").decode(errors="replace").strip() if "?" in text else ""


def as_float(value):
    """The float nearest to it, which a float build computes in."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


# `kelly montecarlo --duration 4 --window 2:4 --mu 0.04 --cov 0.2`, in float.
CASE = {"fc": 100000.0, "mu": as_float(0.04), "a1": 2.0, "a2": 1.0, "w0": as_float(10.471975511965978), "f0": 50000.0,
        **{f"cov{k}": as_float(0.2) for k in range(5)}, "limit": as_float(0.8), "step_ns": 1000000, "ticks": 4000, "window_first": 2000,
        "window_last": 4000, "torsional": 10, "axial": 2, "rotating": 0, "drive_inertia": 0.0, "drive_impedance": 0.0, "drive_hz": 0.0}
