#!/usr/bin/env python3
"""check_sanitizers - one suite, built to notice what C does not: equal digests, and not one complaint.

  clang, gcc   -fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero, the first complaint ends the run: unit tests
               and every subcommand that runs on a host alone; clang in float, gcc in double
  clang        -fsanitize=thread: several threads at work
  valgrind     memcheck: montecarlo with its files, uninitialised values included
  gcc          -m32 -msse2 -mfpmath=sse, float and double; -O1; -O3; clang -Os

Each build gives the digest of the usual one (`make digest`), with one lane and with a vector of two. Then one fault for each tool is
planted in a program of its own and has to be noticed. Last line `N passed, N failed`.
"""
import concurrent.futures
import os
import shutil
import subprocess
import sys
import tempfile

from check_digests import CASE, ROOT, digest_of, sh

SUITE = "address,undefined,float-cast-overflow,float-divide-by-zero"
FATAL = "-g -fno-omit-frame-pointer -fno-sanitize-recover=all"
# One vector unit of two lanes, two vectors: a compiler is minutes on what a release unrolls for each unit; "digests" has those.
PLAIN = ["machine=plain", "vector_flags=-DKELLY_VECTORS=2 -DKELLY_WIDTH=2"]
ENGINES = ("scalar", "vector")
VALGRIND = ["valgrind", "-q", "--error-exitcode=9", "--leak-check=no"]
SHORT = ["--samples", "256", "--duration", "2", "--window", "1:2", "--mu", "0.04"]
# (name, compiler, flags, precision, program that runs it, what runs); long ones first
BUILDS = (
    ("address-clang", "clang", f"-O1 -fsanitize={SUITE} {FATAL}", "float", [], "all"),
    ("address-gcc", "gcc", f"-O1 -fsanitize={SUITE} {FATAL}", "double", [], "all"),
    ("thread", "clang", f"-O1 -fsanitize=thread {FATAL}", "float", [], "threads"),
    ("valgrind", "gcc", "-O1 -g", "float", VALGRIND, "files"),
    ("m32-float", "gcc -m32", "-O2 -msse2 -mfpmath=sse", "float", [], "digest"),
    ("m32-double", "gcc -m32", "-O2 -msse2 -mfpmath=sse", "double", [], "digest"),
    ("O3", "gcc", "-O3", "double", [], "digest"),
    ("O1", "gcc", "-O1", "double", [], "digest"),
    ("Os", "clang", "-Os", "float", [], "digest"),
)


def run(words, folder):
    environment = dict(os.environ, ASAN_OPTIONS="detect_leaks=0:abort_on_error=0", UBSAN_OPTIONS="print_stacktrace=1")
    done = subprocess.run(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def command_lines(kelly, folder):
    """Every subcommand that needs no board, short; in an order in which files exist when they are read."""
    def at(name):
        return os.path.join(folder, name)
    few = ["--samples", "16", "--duration", "2", "--window", "1:2", "--mu", "0.04"]
    grid = ["--rpm", "80:120:20", "--wob", "80:120:20"]
    part = [["montecarlo", *few, "--first", first, "--csv", at(first + ".csv"), "--json", at(first + ".json"), "--quiet"] for first in ("0", "16")]
    lines = [["modes", "--json", at("modes.json")],
             ["simulate", "--duration", "2", "--window", "1:2", "--out", at("one.csv"), "--field", at("field.npy")],
             ["montecarlo", *SHORT, "--threads", "2", "--csv", at("run.csv"), "--json", at("run.json"), "--cov", "0.2"],
             ["montecarlo", *few, "--drive", "soft", "--convergence"],
             ["montecarlo", *few, "--envelope", at("envelope.csv"), "--out-step", "0.1"],
             ["whatif", "--from", at("run.csv"), "--mu", "0.041"],
             *part, ["merge", at("16.csv"), at("0.csv"), "--csv", at("all.csv"), "--json", at("all.json")],
             ["rare", *few[2:], "--cov", "0.2", "--samples-per-level", "1000"],
             ["sensitivity", *few],
             ["map", *grid, *few, "--json", at("map.json"), "--csv", at("map.csv")],
             ["advise", *few, "--below", "0.05"],
             ["plan", "--samples", "10000", "--cores", "10", "--measure", "0.1", "--json", at("plan.json")],
             ["manual"], ["--help"]]
    return [[kelly, *line] for line in lines]


def jobs_of(kind, out, folder):
    kelly = os.path.join(out, "kelly")
    lines = command_lines(kelly, folder)
    if kind == "all":
        return [[os.path.join(out, "unit")], *lines]
    if kind == "threads":
        return [[kelly, "montecarlo", *SHORT, "--threads", t] for t in ("2", "5")] + [[*line, "--threads", "2"] for line in lines if line[1] in ("map", "rare")]
    return lines[2:3] if kind == "files" else []


def claims(build):
    """[(holds, what)] of one build, its digest."""
    name, compiler, flags, real, runner, kind = build
    out = f"build/sanitizers/{name}"
    goals = [f"{out}/kelly"] + ([f"{out}/unit"] if kind == "all" else [])
    built = sh(["make", "-s", f"CC={compiler}", f"CFLAGS={flags}", f"REAL={real}", f"dir={out}", "CHECK_LONG=0", *PLAIN, *goals])
    if built.startswith("failed"):
        return [(False, f"{name}: {built}")]
    out = os.path.join(ROOT, out)
    kelly, usual = os.path.join(out, "kelly"), os.path.join(ROOT, "build", "host-double" if real == "double" else "host", "kelly")
    want = digest_of(sh([usual, "montecarlo", *CASE]))
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for words in jobs_of(kind, out, folder):
            status, text = run([*runner, *words], folder)
            short = " ".join(os.path.basename(w) for w in words[:2])
            found.append((status == 0, f"{name}: {short}: status {status}: {text.strip()[-600:]}"))
        for engine in ENGINES:
            status, text = run([*runner, kelly, "montecarlo", *CASE, "--engine", engine], folder)
            found.append((status == 0 and digest_of(text) == want, f"{name}, {engine}: {digest_of(text)}, the usual build {want}; status {status}"))
    return found


def planted():
    """Each tool ends a program that deserves it."""
    faults = {"address": "volatile char *p = malloc(2); free((void *)p); return p[n];", "undefined": "int x = 2147483647; return x + n;",
              "float-cast-overflow": "double x = 1e30 * n; return (int)x;", "float-divide-by-zero": "double x = n - 1; return 1.0 / x > 0;"}
    faults = [(name, compiler, f"-fsanitize={SUITE}", text, []) for name, text in faults.items() for compiler in ("clang", "gcc")]
    faults.append(("thread", "clang", "-fsanitize=thread", "pthread_t t; pthread_create(&t, 0, add, 0); shared += n; pthread_join(t, 0); return 0;", []))
    faults.append(("uninitialised", "gcc", "-pthread", "volatile int *p = malloc(sizeof(int) * 4); return p[n] == 7 ? 3 : 0;", VALGRIND))
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "fault")
        for name, compiler, flag, text, runner in faults:
            with open(path + ".c", "w", encoding="utf-8") as file:
                file.write("#include <pthread.h>\n#include <stdlib.h>\nstatic int shared;\nvoid *add(void *p);\nvoid *add(void *p) { shared++; return p; }\n"
                           f"int main(int n, char **v) {{ (void)v; {text} }}\n")
            subprocess.run([compiler, "-O1", flag, *FATAL.split(), "-pthread", path + ".c", "-o", path], check=True)
            status, said = run([*runner, path], folder)
            wanted = {"thread": "data race", "uninitialised": "uninitialised", "address": "AddressSanitizer"}.get(name, "runtime error")
            yield status != 0 and wanted in said, f"planted {name}, {compiler}: not noticed: status {status}: {said[-300:]}"


def main():
    missing = [t for t in ("gcc", "clang", "valgrind") if not shutil.which(t)]
    if missing:
        print(f"missing: {' '.join(missing)}\n0 passed, {len(missing)} failed")
        return 1
    for real in ("float", "double"):
        sh(["make", "-s", "all", f"REAL={real}"])
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = [c for found in pool.map(claims, BUILDS) for c in found] + list(planted())
    for holds, what in results:
        if not holds:
            print(what)
    bad = sum(not holds for holds, _ in results)
    runs = sum(not what.startswith("planted") for _, what in results)
    print(f"figure: sanitizers, valgrind, -m32, -O1, -O3, -Os: {len(BUILDS)} builds, {runs} runs, {bad} complaints or other digests")
    print(f"figure: faults planted for the sanitizers: {sum(h for h, w in results if w.startswith('planted'))} of {len(results) - runs} noticed")
    print(f"{len(results) - bad} passed, {bad} failed")
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
