#!/usr/bin/env python3
"""Claims about tests/faulty_line.py: the faults are those it says, and a line through it carries, damages, stalls and restarts.

Prints one line for each claim that fails, then `N passed, N failed`; exit 1 if any failed.
"""
import json
import os
import random
import socket
import subprocess
import sys
import tempfile
import threading
import time

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "host"))

import faulty_line                          # noqa: E402
import link_messages as link                # noqa: E402

count = {True: 0, False: 0}


def claim(holds, text):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print("FAILED: " + text, flush=True)
    return holds


def faults_are_as_said():
    data = random.Random(6).randbytes(400000)
    whole = faulty_line.Faults(1e-2, faulty_line.KINDS, 7)
    pieces = faulty_line.Faults(1e-2, faulty_line.KINDS, 7)
    rng, at, out = random.Random(8), 0, b""
    while at < len(data):
        n = rng.randrange(1, 5000)
        out += pieces(data[at:at + n])
        at += n
    claim(whole(data) == out and whole.counts == pieces.counts, "the same faults, however the bytes are cut up")
    claim(all(350 < n < 800 for n in whole.counts.values()), f"each kind at a fifth of 1e-2 per byte that is not cut: {whole.counts}")
    claim(faulty_line.Faults(0.0, faulty_line.KINDS, 1)(data) == data, "rate 0 changes nothing")
    plain = bytes(range(1, 101)) + b"\0" + bytes(range(1, 101))
    for kind, length in (("flip", 201), ("lose", 200), ("double", 202), ("swap", 201), ("cut", None)):
        one = faulty_line.Faults(1e-9, (kind,), 1)
        one._left = 50
        got = one(plain)
        claim(got != plain and got[:50] == plain[:50] and got[101:] == plain[101:] if kind in ("flip", "swap") else
              got == {"lose": plain[:50] + plain[51:], "double": plain[:51] + plain[50:], "cut": plain[:50] + plain[100:]}[kind], f"what {kind} does")
        claim(length is None or len(got) == length, f"bytes after {kind}")
    swapped = faulty_line.Faults(0.5, ("swap",), 1)(plain)
    claim(swapped != plain and len(swapped) in (200, 201) and abs(sum(plain) - sum(swapped)) <= 100, "swaps next to each other lose nothing")


class Parrot(threading.Thread):
    """A board that sends back every message, until its line is closed."""

    def __init__(self, path):
        super().__init__(daemon=True)
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(path)
        self.listener.listen(1)
        self.received = []
        self.start()

    def run(self):
        end, _ = self.listener.accept()
        receiver = link.Receiver()
        while data := end.recv(4096):
            for name, seq, fields in receiver.feed(data):
                self.received.append((name, seq, fields))
                end.sendall(link.frame(name, seq, **fields))
        self.listener.close()


def until(holds, seconds):
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.01)
    return holds()


def line_carries_and_damages(directory):
    board_path, host_path = os.path.join(directory, "board"), os.path.join(directory, "host")
    parrot = Parrot(board_path)
    words = [sys.executable, os.path.join(ROOT, "tests", "faulty_line.py"), "--listen", "unix:" + host_path, "--connect", "unix:" + board_path,
             "--rate", "0.002", "--stall-every", "60000", "--stall-seconds", "0.5"]
    proxy = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    claim(proxy.stderr.readline() == b"ready\n", "the line says when it is there")
    host = socket.socket(socket.AF_UNIX)
    host.connect(host_path)
    host.settimeout(20.0)
    receiver, back, slowest = link.Receiver(), [], 0.0
    for seq in range(1, 1201):
        host.sendall(link.frame("run", seq, case_crc=seq, seed=seq << 32, first=seq, count=1) + bytes(1))
        start = time.monotonic()
        if seq % 20 == 0:
            host.settimeout(0.05)
            try:
                while data := host.recv(65536):
                    back += receiver.feed(data)
            except TimeoutError:
                pass
            host.settimeout(20.0)
            slowest = max(slowest, time.monotonic() - start)
    end = time.monotonic() + 3.0
    host.settimeout(0.2)
    while time.monotonic() < end:
        try:
            back += receiver.feed(host.recv(65536))
        except TimeoutError:
            pass
    proxy.terminate()
    report = json.loads(proxy.communicate(timeout=10)[0])
    right = [m for m in back if m[0] == "run" and m[2] == {"case_crc": m[1], "seed": m[1] << 32, "first": m[1], "count": 1}]
    claim(right == back and 600 < len(back) < 1200, f"{len(back)} of 1200 come back, each as it was sent")
    claim(receiver.bad > 0 and report["up"]["flip"] > 0 and report["down"]["cut"] > 0, f"both ways are damaged: {report}")
    claim(report["stalls"] == (report["up"]["bytes"] + report["down"]["bytes"]) // 60000 or report["stalls"] >= 1, f"stalls: {report['stalls']}")
    claim(report["connections"] == 1 and proxy.returncode == 0, "one connection, and the report at the end")
    host.close()


def line_kills_and_restarts(directory):
    """The board of this is a program that says its name and then what it hears."""
    path = os.path.join(directory, "killed")
    words = [sys.executable, "-u", "-c", "import os; os.write(1, b'hello\\n')\nwhile d := os.read(0, 99): os.write(1, d)"]
    board = faulty_line.Board(words)
    line = faulty_line.Line("unix:" + path, board, faulty_line.Faults(0, (), 1), faulty_line.Faults(0, (), 1), kills=[1.0], kill_after=[2000])
    worker = threading.Thread(target=line.run, daemon=True)
    worker.start()
    host, heard = socket.socket(socket.AF_UNIX), bytearray()
    host.connect(path)
    host.settimeout(0.05)

    def listens():
        try:
            heard.extend(host.recv(4096))
        except TimeoutError:
            pass
        return heard.count(b"hello\n") >= want

    want = 1
    claim(until(lambda: line.counts["kills"] == 1 and listens(), 10.0), "killed after a second, and started again")
    host.sendall(b"x" * 2000)
    want = heard.count(b"hello\n") + 1
    claim(until(lambda: line.counts["kills"] == 2 and listens(), 10.0), "killed after 2000 bytes from the board, and started again")
    claim(b"x" * 100 in heard and board.starts == 3, "between them it answers")
    line.stop()
    worker.join(5.0)
    claim(not worker.is_alive() and board.process.poll() is not None and not os.path.exists(path), "nothing is left of it")
    host.close()


def main():
    with tempfile.TemporaryDirectory() as directory:
        faults_are_as_said()
        line_carries_and_damages(directory)
        line_kills_and_restarts(directory)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
