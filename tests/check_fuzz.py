#!/usr/bin/env python3
"""check_fuzz - the readers of strange bytes under libFuzzer with the address and undefined-behaviour sanitisers.

usage: tests/check_fuzz.py replay|SECONDS [NAME...]

replay: every file of tests/fuzz/corpus/NAME/ once, regressions among them. SECONDS: that long of each fuzzer, from the corpus, two side
by side; what is found stays in build/fuzz/found/. Figures: executions and findings of each. Last line `N passed, N failed`.
"""
import collections
import concurrent.futures
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
CORPUS = os.path.join(ROOT, "tests", "fuzz", "corpus")
FOUND = os.path.join(ROOT, "build", "fuzz", "found")
# name: what it tries
FUZZERS = {"frame": "frames and messages", "console": "device program, console and requests", "wits": "WITS frames written", "journal": "journal",
           "stored": "CSV and JSON of a run", "options": "command line", "elf": "ELF of a board", "frame-double": "frames and messages, double"}
TEXT = "well files and WITS read (Python)"
COMMON = ["-detect_leaks=0", "-rss_limit_mb=1024", "-timeout=60", "-max_len=1024"]


def binary(name):
    return os.path.join(ROOT, "build", "fuzz-double" if name.endswith("-double") else "fuzz", name.removesuffix("-double"))


def corpus(name):
    folder = os.path.join(CORPUS, name.removesuffix("-double"))
    return sorted(os.path.join(folder, f) for f in os.listdir(folder))


def replay(name):
    """-> (good, executions, what was said)"""
    files = corpus(name)
    ran = subprocess.run([binary(name), *COMMON, *files], cwd=ROOT, capture_output=True, text=True, errors="replace", check=False)
    runs = len(re.findall(r"^Executed ", ran.stderr, re.M))
    return ran.returncode == 0 and runs == len(files) > 0, runs, ran.stderr[-1500:]


def fuzz(name, seconds):
    with tempfile.TemporaryDirectory() as folder:
        with subprocess.Popen([binary(name), *COMMON, f"-max_total_time={seconds}", "-print_final_stats=1", "-seed=1", f"-artifact_prefix={FOUND}/{name}-",
                               folder, *{os.path.dirname(f) for f in corpus(name)}], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True, errors="replace") as ran:
            said = "".join(collections.deque(ran.stderr, 200))       # the end: what is tried says a line each time, gigabytes in all
    runs = int((re.search(r"number_of_executed_units: *(\d+)", said) or [0, 0])[1])
    return ran.returncode == 0 and runs > len(corpus(name)), runs, said[-1500:]


def text(how):
    ran = subprocess.run([sys.executable, os.path.join(ROOT, "tests", "fuzz", "fuzz_text.py"), how], cwd=ROOT, capture_output=True, text=True, check=False)
    runs = int((re.search(r"^executions (\d+)", ran.stdout, re.M) or [0, 0])[1])
    return ran.returncode == 0 and runs > 0, runs, (ran.stdout + ran.stderr)[-1500:]


def main():
    if len(sys.argv) < 2 or not (sys.argv[1] == "replay" or sys.argv[1].isdigit()):
        sys.exit(__doc__)
    seconds = int(sys.argv[1]) if sys.argv[1] != "replay" else 0
    names = [n for n in (*FUZZERS, "text") if len(sys.argv) == 2 or n in sys.argv[2:]]
    os.makedirs(FOUND, exist_ok=True)
    for real in ("float", "double"):
        goal = [] if real == "float" else ["build/fuzz-double/frame"]
        built = subprocess.run(["make", "-s", "-j2", f"REAL={real}", *(goal or ["fuzzers"])], cwd=ROOT, capture_output=True, text=True, check=False)
        if built.returncode != 0:
            print((built.stdout + built.stderr)[-2000:])
            print("0 passed, 1 failed")
            return 1

    def one(name):
        if name == "text":
            return text(str(seconds) if seconds else "300%")
        return fuzz(name, seconds) if seconds else replay(name)

    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for name, (good, runs, said) in zip(names, pool.map(one, names)):
            passed, failed = passed + good, failed + (not good)
            what = FUZZERS.get(name, TEXT)
            print(f"figure: {'fuzzing for %d s' % seconds if seconds else 'fuzzing corpus'}, {what}: {runs} executions, {0 if good else 1} findings", flush=True)
            if not good:
                print(said)
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
