#!/usr/bin/env python3
"""check_sanitizers - one suite, built to notice what C does not: equal digests, and not one complaint.

  clang, gcc   -fsanitize=address,undefined (clang: float-cast-overflow, float-divide-by-zero as well), the first complaint ends the
               run: unit tests, lanes, every subcommand that runs on a host alone; clang in float, gcc in double
  clang        -fsanitize=thread: several threads at work
  valgrind     memcheck: lanes and subcommands, uninitialised values included
  gcc          -m32 -msse2 -mfpmath=sse, float and double; -O1; clang -Os: the digest of the usual build

Last line `N passed, N failed`.
"""
import concurrent.futures
import os
import re
import shutil
import subprocess
import sys
import tempfile

from check_digests import CASE, ROOT, digest_of, engines, sh

SUITE = "address,undefined,float-cast-overflow,float-divide-by-zero"
FATAL = "-g -fno-omit-frame-pointer -fno-sanitize-recover=all"
# One vector unit of two vectors: with sanitizers a compiler is minutes on what a release has unrolled for each unit.
PLAIN = ["machine=plain", "vector_flags=-DKELLY_VECTORS=2 -DKELLY_WIDTH=2"]
SHORT = ["--samples", "256", "--duration", "4", "--window", "2:4", "--mu", "0.04"]
# (name, compiler, flags, precision, program that runs it, what runs)
BUILDS = (
    ("address-clang", "clang", f"-O1 -fsanitize={SUITE} {FATAL}", "float", [], "all"),
    ("address-gcc", "gcc", f"-O1 -fsanitize={SUITE} {FATAL}", "double", [], "all"),
    ("thread", "clang", f"-O1 -fsanitize=thread {FATAL}", "float", [], "threads"),
    ("valgrind", "gcc", "-O2 -g", "float", ["valgrind", "-q", "--error-exitcode=9", "--leak-check=no"], "lanes"),
    ("m32-float", "gcc -m32", "-O2 -msse2 -mfpmath=sse", "float", [], "digest"),
    ("m32-double", "gcc -m32", "-O2 -msse2 -mfpmath=sse", "double", [], "digest"),
    ("O1", "gcc", "-O1", "float", [], "digest"),
    ("Os", "clang", "-Os", "double", [], "digest"),
)


def run(words, folder):
    environment = dict(os.environ, ASAN_OPTIONS="detect_leaks=0:abort_on_error=0", UBSAN_OPTIONS="print_stacktrace=1")
    done = subprocess.run(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def command_lines(kelly, folder):
    """Every subcommand that needs no board, short; in an order in which files exist when they are read."""
    csv, grid = os.path.join(folder, "run.csv"), ["--rpm", "80:120:20", "--wob", "80:120:20"]
    few = ["--samples", "16", "--duration", "4", "--window", "2:4"]
    return [[kelly, "modes", "--json", os.path.join(folder, "modes.json")],
            [kelly, "simulate", "--duration", "2", "--window", "1:2", "--out", os.path.join(folder, "one.csv"), "--field", os.path.join(folder, "field.npy")],
            [kelly, "montecarlo", *SHORT, "--threads", "2", "--csv", csv, "--json", csv[:-4] + ".json", "--cov", "0.2"],
            [kelly, "montecarlo", *few, "--drive", "soft", "--convergence"],
            [kelly, "montecarlo", *few, "--envelope", os.path.join(folder, "envelope.csv"), "--out-step", "0.1"],
            [kelly, "whatif", "--from", csv, "--mu", "0.041"],
            [kelly, "sensitivity", *few],
            [kelly, "map", *grid, *few, "--json", os.path.join(folder, "map.json"), "--csv", os.path.join(folder, "map.csv")],
            [kelly, "advise", *few, "--below", "0.05"],
            [kelly, "manual"], [kelly, "--help"]]


def jobs_of(kind, out, folder):
    kelly = os.path.join(out, "kelly")
    lines = command_lines(kelly, folder)
    if kind == "all":
        return [[os.path.join(out, "unit")], [os.path.join(out, "lanes")], *lines]
    if kind == "threads":
        return [[kelly, "montecarlo", *SHORT, "--threads", t] for t in ("2", "5")] + [line for line in lines if line[1] in ("map", "sensitivity")]
    return [[os.path.join(out, "lanes")], *lines[:3], lines[5], lines[7]] if kind == "lanes" else []


def claims(build):
    """[(holds, what)] of one build."""
    name, compiler, flags, real, runner, kind = build
    out = f"build/sanitizers/{name}"
    goals = [f"{out}/kelly"] + ([f"{out}/unit", f"{out}/lanes"] if kind in ("all", "lanes") else [])
    built = sh(["make", "-s", f"CC={compiler}", f"CFLAGS={flags}", f"REAL={real}", f"dir={out}", *(PLAIN if "-fsanitize" in flags else []), *goals])
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
        for engine in engines(kelly) if not runner else ["scalar", "sse2", "avx2"]:
            status, text = run([*runner, kelly, "montecarlo", *CASE, "--engine", engine], folder)
            found.append((status == 0 and digest_of(text) == want, f"{name}, {engine}: {digest_of(text)}, the usual build {want}; status {status}"))
    return found


def planted():
    """Each sanitizer ends a program that deserves it: what is built here is not built past them."""
    faults = {"address": "volatile char *p = malloc(1); p[n] = 1; return p[n];", "undefined": "int x = 2147483647; return x + n;",
              "float-cast-overflow": "double x = 1e30 * n; return (int)x;", "float-divide-by-zero": "double x = n - 1; return 1.0 / x > 0;"}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in faults.items():
            path = os.path.join(folder, name)
            with open(path + ".c", "w", encoding="utf-8") as file:
                file.write(f"#include <stdlib.h>\nint main(int n, char **v) {{ (void)v; {text} }}\n")
            for compiler in ("clang", "gcc"):
                subprocess.run([compiler, "-O1", f"-fsanitize={SUITE}", *FATAL.split(), path + ".c", "-o", path], check=True)
                status, text_out = run([path], folder)
                yield status != 0 and "error" in text_out.lower(), f"planted {name}, {compiler}: not noticed"


def main():
    missing = [t for t in ("gcc", "clang", "valgrind") if not shutil.which(t)]
    if missing:
        print(f"missing: {' '.join(missing)}\n0 passed, {len(missing)} failed")
        return 1
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = [c for found in pool.map(claims, BUILDS) for c in found] + list(planted())
    for holds, what in results:
        if not holds:
            print(what)
    bad = sum(not holds for holds, _ in results)
    runs = sum(not re.search("planted", what) for _, what in results)
    print(f"figure: sanitizers, valgrind, -m32, -O1, -Os: {len(BUILDS)} builds, {runs} runs, {bad} complaints or other digests")
    print(f"{len(results) - bad} passed, {bad} failed")
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
