"""bench_run - `kelly bench` as a process, what it must give, and the faulty line before a board as another one."""
import csv
import json
import os
import random
import re
import shlex
import signal
import subprocess
import sys
import tempfile

from bench_board import ROOT, image
from programs import PROGRAM

WAITING = " s, waiting for one at most "   # told also of a good board, on a machine that is busy
TEMPORARY = tempfile.TemporaryDirectory()


class Run:
    """One `kelly bench`: exit status, stdout, stderr, its JSON and CSV where it wrote them."""
    number = 0

    def __init__(self, words, real="float", files=True, wait=True, base=None):
        Run.number += 1
        self.base = base or os.path.join(TEMPORARY.name, f"{Run.number}-{random.randrange(1 << 30)}")
        self.csv, self.json = self.base + ".csv", self.base + ".json"
        line = [PROGRAM[real], "bench", *shlex.split(words)]
        if files:
            mode = re.search(r"--mode (\w+)", words)
            line += ["--json", self.json, "--out" if mode else "--csv", self.csv]
        self.process = subprocess.Popen(line, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if wait:
            self.wait()

    def wait(self, timeout=180):
        try:
            self.out, self.err = self.process.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.out, self.err = self.process.communicate()
            self.err += " (no end)"
        self.status = self.process.returncode
        self.said = (self.out + self.err).strip()[-300:]
        return self

    def report(self):
        with open(self.json, encoding="ascii") as file:
            return json.load(file)

    def rows(self):
        with open(self.csv, encoding="ascii", newline="") as file:
            return list(csv.DictReader(file))

    def one_line(self, status, *words):
        """Whether it ended with this status and one line that holds these words."""
        lines = [text for text in self.err.splitlines() if not text.startswith("emulator: ") and WAITING not in text]
        return self.status == status and len(lines) == 1 and lines[0].startswith("kelly: ") and all(w in lines[0] for w in words)


def bytes_of(path):
    with open(path, "rb") as file:
        return file.read()


def montecarlo(case):
    """Bytes of the CSV, and the digest, of the same realisations on this machine."""
    path = os.path.join(TEMPORARY.name, f"mc-{random.randrange(1 << 30)}.csv")
    done = subprocess.run([PROGRAM["float"], "montecarlo", *shlex.split(case), "--csv", path], capture_output=True, text=True, check=True)
    return bytes_of(path), re.search("digest ([0-9a-f]{8})", done.stdout)[1]


def same_campaign(run, case, samples):
    """Claims of every campaign: the files of montecarlo, each index once."""
    yield run.status == 0, f"ends well: {run.said}"
    if run.status == 0:
        rows, digest = montecarlo(case)
        report = run.report()
        yield report["digest"] == digest, f"digest {report['digest']}, on the host {digest}"
        yield bytes_of(run.csv) == rows, "CSV of montecarlo, byte for byte"
        yield report["bench"]["resumed"] + sum(b["results"] for b in report["bench"]["boards"]) == samples == report["samples"], "every index counts exactly once"


class Faulty:
    """tests/faulty_line.py before a board, as a program."""

    def __init__(self, target, options):
        self.path = os.path.join(TEMPORARY.name, f"line-{random.randrange(1 << 30)}")
        self.port = f"unix:{self.path} --image {image(target)}"
        self.process = subprocess.Popen([sys.executable, os.path.join(ROOT, "tests", "faulty_line.py"), "--listen", "unix:" + self.path, "--target", target,
                                         "--image", image(target), *shlex.split(options)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.process.stderr.readline()     # ready

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        return json.loads(self.process.communicate(timeout=20)[0])
