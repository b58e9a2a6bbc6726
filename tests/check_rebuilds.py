#!/usr/bin/env python3
"""check_rebuilds - what is built is what was asked for: an edited well file, another file of the same name, other flags.

Last line `N passed, N failed`.
"""
import os
import shutil
import subprocess
import sys
import tempfile

from check_sanitizers import PLAIN

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
NAME = "rebuild-check"
PROGRAM = os.path.join(ROOT, "build", "host-" + NAME, "kelly")


def make(*words):
    """With one small vector unit: most of the time would go into what a release unrolls for each of its own."""
    return subprocess.run(["make", "-s", *PLAIN, *words], cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)


def version():
    return subprocess.run([PROGRAM, "--version"], capture_output=True, text=True, check=True).stdout


def stamp():
    return os.stat(PROGRAM).st_mtime_ns


def claims(folder):
    """(holds, what) one after another; each builds on the ones before."""
    first, second = (os.path.join(folder, sub, NAME + ".toml") for sub in ("one", "two"))
    text = open(os.path.join(ROOT, "tests", "wells", "short.toml"), encoding="utf-8").read()
    for path in (first, second):
        os.makedirs(os.path.dirname(path))
    with open(first, "w", encoding="utf-8") as file:
        file.write(text)
    done = make("WELL=" + first)
    yield done.returncode == 0, "builds: " + done.stderr[-200:]
    before, built = version(), stamp()
    make("WELL=" + first)
    yield stamp() == built, "nothing changed, nothing is built"
    for other in ("device", "app-unit"):
        done = make("WELL=" + first, f"build/host-{NAME}/{other}")
        make("WELL=" + first)
        yield done.returncode == 0 and stamp() == built, f"{other} is another program of the same flags, nothing else is built: {done.stderr[-200:]}"
    edited = text.replace("mass_per_s = 0.1", "mass_per_s = 0.11")
    with open(first, "w", encoding="utf-8") as file:
        file.write(edited)
    make("WELL=" + first)
    yield edited != text and version() != before, "an edited well file is built"
    with open(second, "w", encoding="utf-8") as file:
        file.write(text)
    make("WELL=" + second)
    yield version() == before, "another file of the same name is built"
    with open(second, "w", encoding="utf-8") as file:
        file.write("nonsense")
    done = make("WELL=" + second)
    yield done.returncode != 0 and done.stderr.startswith("kelly gen: "), "a file gone bad is told: " + done.stderr[:200]
    with open(second, "w", encoding="utf-8") as file:
        file.write(text)
    make("WELL=" + second)
    built = stamp()
    make("WELL=" + second, "CFLAGS=-O1")
    yield stamp() != built, "other flags are built"
    done = make("WELL=a b.toml")
    yield done.returncode != 0 and "without spaces" in done.stderr, "a path with a space is refused"
    done = make("CFLAGS=-O2 -ffast-math", "WELL=" + second)
    yield done.returncode != 0 and "IEEE" in done.stderr, "fast-math is refused"
    reference = make("digest", "CFLAGS=-O1", "dir=build/" + NAME).stdout
    relaxed = make("digest", "CFLAGS=-O1 -fassociative-math -freciprocal-math -fno-signed-zeros -fno-trapping-math", "dir=build/" + NAME).stdout
    yield reference.startswith("digest ") and relaxed == reference, f"parts of it are overridden: {relaxed} {reference}"
    for word in ("SEED=-1", "FIRST=4294967296"):
        yield make("digest", word, "dir=build/" + NAME).returncode != 0, f"digest {word} fails"


def main():
    passed = failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for holds, what in claims(folder):
            passed, failed = passed + bool(holds), failed + (not holds)
            if not holds:
                print("FAIL " + what)
    shutil.rmtree(os.path.dirname(PROGRAM), ignore_errors=True)
    shutil.rmtree(os.path.join(ROOT, "build", NAME), ignore_errors=True)
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
