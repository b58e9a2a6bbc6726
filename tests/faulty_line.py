#!/usr/bin/env python3
"""faulty_line.py - a serial line that fails, between a host program and a board: seeded, counted, in both directions.

usage: tests/faulty_line.py --listen unix:PATH|tcp:PORT (--target NAME --image F.elf [--icount TEXT] | --connect unix:PATH|tcp:HOST:PORT)
                            [--rate R] [--kinds flip,lose,double,swap,cut] [--seed N] [--stall-every BYTES] [--stall-at S,S,..]
                            [--stall-seconds 3] [--kill-at S,S,..] [--kill-after BYTES,..] [--direction both|up|down] [--seconds S]

--rate R       each byte meets each of the kinds with probability R / (number of kinds)
   flip        one bit of it is turned            lose    it does not arrive            double  it arrives twice
   swap        it changes places with the next    cut     it and the rest up to the next 00 do not arrive
--stall-...    both directions stop for 3 s, then what has waited goes on; nothing is lost by that
--kill-...     the emulator is killed and started again, by time or by bytes from the board; a host sees silence, then a banner
--direction    up: board to host only, down: host to board only
The host may connect again and again. A line of JSON with what was done is printed at the end: on SIGTERM, SIGINT or after --seconds.
"""
import argparse
import json
import os
import random
import selectors
import signal
import socket
import subprocess
import sys
import time

from run_target import command, target_settings

KINDS = ("flip", "lose", "double", "swap", "cut")
CHUNK = 4096
MOST_DEATHS = 20            # of an emulator that ends by itself: more, and its image is at fault


class Faults:
    """One direction: bytes in, bytes out. The same seed and the same bytes give the same faults, however they are cut up."""

    def __init__(self, rate, kinds, seed):
        self.rate, self.kinds = rate, tuple(kinds)
        self.random = random.Random(seed)
        self.counts = dict.fromkeys(self.kinds, 0)
        self.bytes = 0
        self._held = None       # a byte that waits to change places
        self._cutting = False
        self._left = self._gap()

    def _gap(self):
        """Bytes until the next fault."""
        return int(self.random.expovariate(self.rate)) if self.rate > 0 and self.kinds else 1 << 62

    def __call__(self, data):
        out = bytearray()
        self.bytes += len(data)
        for byte in data:
            self._one(byte, out)
        return bytes(out)

    def _one(self, byte, out):
        if self._cutting and byte:
            return
        self._cutting = False
        if self._held is not None:
            out.append(byte)
            byte, self._held = self._held, None
            out.append(byte)
            return
        self._left -= 1
        if self._left >= 0:
            out.append(byte)
            return
        self._left = self._gap()
        self._fault(self.random.choice(self.kinds), byte, out)

    def _fault(self, kind, byte, out):
        self.counts[kind] += 1
        if kind == "flip":
            out.append(byte ^ 1 << self.random.randrange(8))
        elif kind == "double":
            out += bytes([byte, byte])
        elif kind == "swap":
            self._held = byte
        elif kind == "cut":
            self._cutting = True


def address(text):
    """-> (socket family, address)"""
    kind, _, rest = text.partition(":")
    if kind == "unix" and rest:
        return socket.AF_UNIX, rest
    if kind == "tcp" and rest:
        host, _, port = rest.rpartition(":")
        return socket.AF_INET, (host or "127.0.0.1", int(port))
    raise ValueError(f"{text}: expected unix:PATH or tcp:[HOST:]PORT")


class Board:
    """The far end: an emulator that can be killed and started again, or a socket."""

    def __init__(self, words=None, connect=None):
        self.words, self.connect, self.process, self.starts = words, connect, None, 0
        self.start()

    def start(self):
        if self.connect:
            family, where = address(self.connect)
            self.socket = socket.socket(family)
            self.socket.connect(where)
        else:
            self.socket, far = socket.socketpair()
            self.process = subprocess.Popen(self.words, stdin=far, stdout=far, stderr=subprocess.DEVNULL)
            far.close()
        self.socket.setblocking(False)
        self.starts += 1

    def stop(self):
        if self.process:
            self.process.kill()
            self.process.wait()
        self.socket.close()


class Line:
    """Carries bytes until it is told to stop. `stalls`, `kills`: seconds after the start; `kill_after`: bytes from the board."""

    def __init__(self, listen, board, down, up, stall_every=0, stalls=(), stall_seconds=3.0, kills=(), kill_after=()):
        family, where = address(listen)
        if family == socket.AF_UNIX and os.path.exists(where):
            os.unlink(where)
        self.path = where if family == socket.AF_UNIX else None
        self.listener = socket.socket(family)
        self.listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.listener.bind(where)
        self.listener.listen(4)
        self.board, self.down, self.up, self.host = board, down, up, None
        self.to_board, self.to_host = bytearray(), bytearray()
        self.stall_every, self.stalls, self.stall_seconds = stall_every, sorted(stalls), stall_seconds
        self.kills, self.kill_after = sorted(kills), sorted(kill_after)
        self.counts = {"connections": 0, "stalls": 0, "kills": 0, "deaths": 0}
        self.next_stall, self.stalled_until = stall_every, 0.0
        self.begin = time.monotonic()
        self.running = True

    def stop(self, *_):
        self.running = False

    def run(self, seconds=None):
        end = self.begin + seconds if seconds else float("inf")
        try:
            while self.running and time.monotonic() < end:
                self._planned()
                self._turn()
        finally:
            self.close()

    def close(self):
        self.board.stop()
        self.listener.close()
        if self.host:
            self.host.close()
        if self.path and os.path.exists(self.path):
            os.unlink(self.path)

    # ---- stalls and kills

    def _planned(self):
        now = time.monotonic()
        passed = self.down.bytes + self.up.bytes
        while self.stalls and now - self.begin >= self.stalls[0]:
            self.stalls.pop(0)
            self._stall(now)
        if self.stall_every and passed >= self.next_stall:
            self.next_stall = passed + self.stall_every
            self._stall(now)
        if self.kills and now - self.begin >= self.kills[0]:
            self.kills.pop(0)
            self._restart("kills")
        if self.kill_after and self.up.bytes >= self.kill_after[0]:
            self.kill_after.pop(0)
            self._restart("kills")

    def _stall(self, now):
        self.counts["stalls"] += 1
        self.stalled_until = now + self.stall_seconds

    def _restart(self, why):
        self.counts[why] += 1
        self.board.stop()
        self.to_board.clear()
        self.board.start()

    # ---- bytes

    def _turn(self):
        wait = selectors.DefaultSelector()
        wait.register(self.listener, selectors.EVENT_READ)
        if time.monotonic() >= self.stalled_until:
            self._watch(wait, self.board.socket, self.to_host, self.to_board)
            if self.host:
                self._watch(wait, self.host, self.to_board, self.to_host)
        for key, events in wait.select(0.02):
            if key.fileobj is self.listener:
                self._accept()
            elif key.fileobj is self.board.socket:
                self._board(events)
            elif key.fileobj is self.host:
                self._host(events)
        wait.close()

    @staticmethod
    def _watch(wait, end, incoming, outgoing):
        """Reads where there is room for it, writes where there is something to write."""
        events = (selectors.EVENT_READ if len(incoming) < 16 * CHUNK else 0) | (selectors.EVENT_WRITE if outgoing else 0)
        if events:
            wait.register(end, events)

    def _accept(self):
        if self.host:
            self.host.close()
        self.host, _ = self.listener.accept()
        self.host.setblocking(False)
        self.to_host.clear()
        self.counts["connections"] += 1

    def _board(self, events):
        alive = self._move(self.board.socket, events, self.to_board, self.to_host, self.up)
        if not alive and self.board.process and self.counts["deaths"] < MOST_DEATHS:
            self._restart("deaths")
        elif not alive:
            self.stop()
        if not self.host:
            self.to_host.clear()     # nobody listens: gone, as on a wire

    def _host(self, events):
        if not self._move(self.host, events, self.to_host, self.to_board, self.down):
            self.host.close()
            self.host = None

    @staticmethod
    def _move(end, events, outgoing, incoming, faults):
        """-> whether the end is still there"""
        try:
            if events & selectors.EVENT_WRITE and outgoing:
                del outgoing[:end.send(outgoing)]
            if events & selectors.EVENT_READ:
                data = end.recv(CHUNK)
                incoming += faults(data)
                return bool(data)
        except BlockingIOError:
            pass
        except OSError:
            return False
        return True

    def report(self):
        return {**self.counts, "down": {"bytes": self.down.bytes, **self.down.counts}, "up": {"bytes": self.up.bytes, **self.up.counts}}


def _numbers(text):
    return [float(word) for word in text.split(",")] if text else []


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    for name in ("listen", "target", "image", "icount", "connect"):
        parser.add_argument("--" + name)
    parser.add_argument("--rate", type=float, default=0.0)
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--stall-every", type=int, default=0)
    parser.add_argument("--stall-seconds", type=float, default=3.0)
    for name in ("stall-at", "kill-at", "kill-after"):
        parser.add_argument("--" + name, type=_numbers, default=[])
    parser.add_argument("--direction", choices=("both", "up", "down"), default="both")
    parser.add_argument("--seconds", type=float)
    args = parser.parse_args()
    kinds = args.kinds.split(",") if args.kinds else []
    if not args.listen or bool(args.target and args.image) == bool(args.connect) or set(kinds) - set(KINDS):
        parser.error("give --listen, and --target with --image or --connect; kinds are " + ",".join(KINDS))
    words = None if args.connect else command(target_settings(args.target), args.image, args.icount)
    down, up = (Faults(args.rate if args.direction in ("both", way) else 0.0, kinds, f"{args.seed} {way}") for way in ("down", "up"))
    line = Line(args.listen, Board(words, args.connect), down, up, args.stall_every, args.stall_at, args.stall_seconds,
                args.kill_at, args.kill_after)
    signal.signal(signal.SIGTERM, line.stop)
    signal.signal(signal.SIGINT, line.stop)
    print("ready", file=sys.stderr, flush=True)
    line.run(args.seconds)
    print(json.dumps(line.report()), flush=True)


if __name__ == "__main__":
    main()
