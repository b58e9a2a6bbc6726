#!/usr/bin/env python3
"""check_sanitizers - one suite, built to notice what C does not: every test passes, equal digests and files, not one complaint.

usage: tests/check_sanitizers.py [BUILD...]

  clang, gcc   -fsanitize=address,undefined,float-cast-overflow,float-divide-by-zero, the first complaint ends the run; with the vector
               units of a release, each that this processor has; clang at -O0, where it is seconds on what it is minutes on at -O1
  clang        -fsanitize=thread
  valgrind     memcheck, uninitialised values included, with the vector units that it knows: up to AVX2
  gcc          -DKELLY_GUARD=0: the state not guarded (lanes.h), under the faults of host_faults.c; the unit tests know what is not seen then
  gcc, clang   -O0, -O1, -O2, -O3, -Os, float and double by turns; gcc -m32 -msse2 -mfpmath=sse in both; clang -m32

In each build: the unit tests at a board's sample sizes, those of the device program's parts and that program as a process, the lanes of its
vector units, every subcommand that runs on a host alone with each unit; faults inside where memory is watched. Tests are as many in all builds of a precision, the digest and every CSV and NPY are those of the usual build. Then one fault for
each tool is planted in a program of its own and has to be noticed. Last line `N passed, N failed`.
"""
import concurrent.futures
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile

from check_board_coverage import ESTIMATES
from check_digests import CASE, ROOT, digest_of, engines, sh
from run_target import run as run_board

SUITE = "address,undefined,float-cast-overflow,float-divide-by-zero"
FATAL = "-g -fno-omit-frame-pointer -fno-sanitize-recover=all"
RELEASE = []                     # vector units as make has them
# One unit of two lanes, two vectors: a compiler is minutes on what a release unrolls for each unit; "digests" has those.
PLAIN = ["machine=plain", "vector_flags=-DKELLY_VECTORS=2 -DKELLY_WIDTH=2"]
VALGRIND = ["valgrind", "-q", "--error-exitcode=9", "--leak-check=no"]
M32 = "-O2 -msse2 -mfpmath=sse"
SHORT = ["--samples", "256", "--duration", "2", "--window", "1:2", "--mu", "0.04"]
# (name, compiler, flags, precision, vector units, program that runs it); long ones first
BUILDS = (
    ("address-clang", "clang", f"-O0 -fsanitize={SUITE} {FATAL}", "float", RELEASE, []),
    ("address-gcc", "gcc", f"-O1 -fsanitize={SUITE} {FATAL}", "double", RELEASE, []),
    ("valgrind", "gcc", "-O1 -g", "float", RELEASE, VALGRIND),
    ("unguarded", "gcc", "-O2 -DKELLY_GUARD=0", "float", RELEASE, []),
    ("thread", "clang", f"-O1 -fsanitize=thread {FATAL}", "float", PLAIN, []),
    ("m32-gcc-float", "gcc -m32", M32, "float", PLAIN, []),
    ("m32-gcc-double", "gcc -m32", M32, "double", PLAIN, []),
    ("m32-clang-double", "clang -m32", "-O2 -msse2", "double", PLAIN, []),
    *((f"{compiler}{level}", compiler, level, ("float", "double")[(k + (compiler == "clang")) % 2], PLAIN, [])   # both precisions, by turns
      for k, level in enumerate(("-O0", "-O1", "-O2", "-O3", "-Os")) for compiler in ("gcc", "clang")),
)


def run(words, folder):
    environment = dict(os.environ, ASAN_OPTIONS="detect_leaks=0:abort_on_error=0", UBSAN_OPTIONS="print_stacktrace=1")
    done = subprocess.run(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def usual(real):
    return os.path.join(ROOT, "build", "host-double" if real == "double" else "host", "kelly")


def units(vectors, runner, real):
    """Names of the vector units of a build that can run here."""
    if vectors == PLAIN:
        return ["scalar", "vector"]
    return [e for e in engines(usual(real)) if e != "avx512" or runner != VALGRIND]


def command_lines(engine):
    """Every subcommand that needs no board, short, with files in the working directory; in an order in which they exist when they are read."""
    few = ["--samples", "16", "--duration", "2", "--window", "1:2", "--mu", "0.04"]
    grid = ["--rpm", "80:120:20", "--wob", "80:120:20"]
    by = ["--engine", engine]
    part = [["montecarlo", *few, *by, "--first", first, "--csv", first + ".csv", "--json", first + ".json", "--quiet"] for first in ("0", "16")]
    return [["modes", "--json", "modes.json"],
            ["simulate", "--duration", "2", "--window", "1:2", "--out", "one.csv", "--field", "field.npy"],
            ["montecarlo", *SHORT, *by, "--threads", "2", "--csv", "run.csv", "--json", "run.json", "--cov", "0.2"],
            ["montecarlo", *SHORT, *by, "--threads", "5", "--csv", "soft.csv", "--drive", "soft"],
            ["montecarlo", *few, *by, "--drive", "soft", "--convergence"],
            ["montecarlo", *few, *by, "--envelope", "envelope.csv", "--out-step", "0.1"],
            ["whatif", "--from", "run.csv", "--mu", "0.041"],
            *part, ["merge", "16.csv", "0.csv", "--csv", "all.csv", "--json", "all.json"],
            ["rare", *few[2:], *by, "--cov", "0.2", "--samples-per-level", "1000", "--threads", "2"],
            ["sensitivity", *few, *by],
            ["map", *grid, *few, *by, "--json", "map.json", "--csv", "map.csv", "--npy", "map.npy", "--threads", "2"],
            ["advise", *few, *by, "--below", "0.05"],
            ["plan", *few[2:6], "--samples", "10000", "--cores", "10", "--measure", "0.1", "--json", "plan.json"],
            ["manual"], ["--help"]]


def files_of(folder):
    """{name: CRC} of what holds no time."""
    found = {}
    for name in os.listdir(folder):
        if name.endswith((".csv", ".npy")):
            with open(os.path.join(folder, name), "rb") as file:
                found[name] = hashlib.sha256(file.read()).hexdigest()[:8]
    return found


def wanted(real):
    """-> digest, files and device program's lines of the usual build."""
    sh(["make", "-s", os.path.relpath(os.path.join(os.path.dirname(usual(real)), "device"), ROOT), f"REAL={real}"])
    with tempfile.TemporaryDirectory() as folder:
        for line in command_lines("scalar"):
            run([usual(real), *line], folder)
        return digest_of(sh([usual(real), "montecarlo", *CASE])), files_of(folder), estimates(os.path.dirname(usual(real)), [])


def estimates(out, runner):
    """What the device program says to each line, and its status, without a time."""
    said = {line: run_board([*runner, os.path.join(out, "device")], [line], timeout=300) for line in ESTIMATES}
    return {line: (status, re.sub(rb"per step .*|stack .*", b"", text)) for line, (status, text) in said.items()}


def of_tests(name, out, names, runner):
    """-> claims about the test programs, how many unit tests there are."""
    told, said, count = [], {}, {}
    for program in ("unit", "app-unit", "lanes", *faults_of(name, names)):
        status, said[program] = run([*runner, os.path.join(out, program), *(["100"] if "faults" in program else [])], out)
        count[program] = re.search(r"^([1-9]\d*) passed, (\d+) failed$", said[program], re.M)
        told.append((status == 0 and count[program], f"{name}: {program}: status {status}: {said[program].strip()[-600:]}"))
    tried = re.findall(r"^(\w+), \d+ realisations a vector", said["lanes"], re.M)
    return [*told, (tried == names, f"{name}: lanes tries {tried}, not {names}")], count["unit"] and int(count["unit"][1]) + int(count["unit"][2])


def faults_of(name, names):
    """Programs of host_faults.c that the build runs: of one lane, of the first vector unit."""
    return {"address-gcc": ["faults"], "unguarded": ["faults-" + names[1]]}.get(name, [])


def of_commands(name, kelly, engine, runner, want):
    digest, files, _ = want
    with tempfile.TemporaryDirectory() as folder:
        for line in command_lines(engine):
            status, text = run([*runner, kelly, *line], folder)
            yield status == 0, f"{name}, {engine}: {line[0]}: status {status}: {text.strip()[-600:]}"
        found = files_of(folder)
        status, text = run([*runner, kelly, "montecarlo", *CASE, "--engine", engine], folder)
    yield found == files, f"{name}, {engine}: other files than the usual build: {sorted(set(found.items()) ^ set(files.items()))}"
    yield status == 0 and digest_of(text) == digest, f"{name}, {engine}: {digest_of(text)}, the usual build {digest}; status {status}"


def claims(build, want):
    """-> [(holds, what)] of one build, how many unit tests it has."""
    name, compiler, flags, real, vectors, runner = build
    out, names = f"build/sanitizers/{name}", units(vectors, runner, real)
    built = sh(["make", "-s", f"CC={compiler}", f"CFLAGS={flags}", f"REAL={real}", f"dir={out}", "CHECK_LONG=0", *vectors,
                *(f"{out}/{program}" for program in ("kelly", "unit", "app-unit", "device", "lanes", *faults_of(name, names)))])
    if built.startswith("failed"):
        return [(False, f"{name}: {built}")], None
    out = os.path.join(ROOT, out)
    found, tests = of_tests(name, out, names, runner)
    said = estimates(out, runner)
    found += [(said[line] == want[real][2][line], f"{name}: device: {line}: {said[line]}") for line in ESTIMATES]
    for engine in names:
        found += of_commands(name, os.path.join(out, "kelly"), engine, runner, want[real])
    return found, tests


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
    builds = [b for b in BUILDS if not sys.argv[1:] or b[0] in sys.argv[1:]]
    want = {real: wanted(real) for real in ("float", "double")}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        done = list(pool.map(lambda build: claims(build, want), builds))
    results = [c for found, _ in done for c in found]
    runs = len(results)
    for real in ("float", "double"):
        tests = {build[0]: number for build, (_, number) in zip(builds, done) if build[3] == real}
        results.append((len(set(tests.values())) <= 1, f"unit tests in {real}: {tests}"))
    faults = list(planted())
    results += faults
    for holds, what in results:
        if not holds:
            print(what)
    bad = sum(not holds for holds, _ in results)
    suite = f"unit, app-unit, lanes, device program, {len(command_lines('scalar'))} commands a vector unit"
    print(f"figure: one suite ({suite}) under sanitizers, valgrind, -m32, -O0 to -O3, -Os, gcc and clang: {len(builds)} builds, {runs} claims, "
          f"{bad} complaints, other digests or other files")
    print(f"figure: faults planted for the sanitizers: {sum(bool(h) for h, _ in faults)} of {len(faults)} noticed")
    print(f"{len(results) - bad} passed, {bad} failed")
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
