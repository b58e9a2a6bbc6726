#!/usr/bin/env python3
"""check_rules - the static rules: MISRA C:2012, clang-tidy, gcc -fanalyzer, the limits of the Power of Ten.

Every finding is covered by a row of tests/deviations.txt or fails, and so does a row that covers nothing. Then one fault for each
tool is planted in a file of its own and has to be found. What is checked, as what:

  kernel    firmware/, link/, tables/ as a host compiles them: double, one lane
  device    firmware/, link/, app/ as a board does: float, freestanding, one lane (clang-tidy and gcc: app/)
  NAME      the board files of a target of linker/, with the macros of its compiler
  host      host/ but mpi.c
  mpi       host/mpi.c

cppcheck and its MISRA addon on all but host and mpi; clang-tidy (.clang-tidy) and gcc with the Makefile's warnings and -fanalyzer on all;
lines of a function on firmware/ and host/; loops, recursion (calls as gcc -O0 sees them) and function pointers on firmware/.

Last line `N passed, N failed`.
"""
import concurrent.futures
import fnmatch
import functools
import os
import re
import shutil
import subprocess
import sys

import c_source
from stack_depth import EDGE, INDIRECT

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
OUT = os.path.join("build", "rules")
TABLE = os.path.join("tests", "deviations.txt")
LINES_MOST = 60
BOARDS = ("microbit", "stm32f405", "mps2-an505", "rv32")   # all files of firmware/board and all branches of their directives
FIXED = ["-std=c11", "-ffp-contract=off", "-fno-math-errno"]
BOARD_NAMES = ['-DBOARD_NAME="rules"', "-DBOARD_COUNT_HZ=1000000u", "-DBOARD_ICOUNT_SHIFT=0", "-DBOARD_CPU_HZ=16000000u"]


def sh(words, **more):
    return subprocess.run(words, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, **more)


def files(*patterns):
    names = sh(["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", *patterns]).stdout.split()
    return [n for n in names if n.endswith(".c") and os.path.exists(os.path.join(ROOT, n))]


# ---- what is checked, as what ------------------------------------------------------------------------------------------


class Part:
    def __init__(self, name, sources, gcc, gcc_flags, clang_flags, platform="unix64"):
        self.name, self.sources, self.gcc, self.platform = name, sources, gcc, platform
        self.gcc_flags, self.clang_flags = FIXED + gcc_flags, FIXED + clang_flags


def board(target):
    text = open(os.path.join(ROOT, "linker", target + ".mk"), encoding="utf-8").read().replace("\\\n", " ")
    of = dict(re.findall(r"^(\w+) := (.*)$", text, re.M))
    arch = of["ARCH"].split()
    triple = ("riscv64" if "rv64" in of["ARCH"] else "riscv32") + "-none-elf" if of["FAMILY"] == "riscv" else "arm-none-eabi"
    flags = ["-ffreestanding", *BOARD_NAMES]
    return Part(target, files(":(glob)firmware/board/*.c", f"firmware/board/{of['FAMILY']}/*.c", f"firmware/board/{of['BOARD']}/*.c"),
                of["CROSS"] + "gcc", flags + arch,
                flags + ["--target=" + triple] + [a for a in arch if not a.startswith(("-misa-spec", "-fno-isolate", "-fsanitize"))],
                "unix64" if "rv64" in of["ARCH"] else "unix32")


def parts():
    kernel = files(":(glob)firmware/*.c", "firmware/link/*.c")
    tables = files("firmware/tables/*.c")
    double = ["-DKELLY_DOUBLE", "-Ifirmware/tables"]
    device = ["-ffreestanding", "-Ifirmware/tables", *BOARD_NAMES]
    host = ["-D_GNU_SOURCE", "-pthread", "-DKELLY_X86"]
    mpi = host + ["-DKELLY_MPI"] + sh(["mpicc", "--showme:compile"]).stdout.replace("-I", "-isystem").split()
    found = [Part("kernel", kernel + tables, "gcc", double, double), Part("device", kernel + files("firmware/app/*.c"), "gcc", device, device),
             Part("host", [n for n in files("host/*.c") if n != "host/mpi.c"], "gcc", host, host), Part("mpi", ["host/mpi.c"], "gcc", mpi, mpi)]
    return found + [board(n) for n in BOARDS]


# ---- tools: each gives a set of (rule, file, line) -----------------------------------------------------------------------


def local(path):
    path = os.path.normpath(os.path.relpath(os.path.join(ROOT, path), ROOT))
    return None if path.startswith("..") else path


def findings(tool, pattern, text):
    found = set()
    for match in re.finditer(pattern, text, re.M):
        path = local(match["file"])
        if path:
            found.add((tool + "/" + match["rule"], path, int(match["line"])))
    return found


@functools.lru_cache(None)
def macros(compiler, flags):
    """What the sources ask a compiler about."""
    text = subprocess.run([compiler, *flags, "-dM", "-E", "-xc", "/dev/null"], capture_output=True, text=True, check=True).stdout
    asked = re.compile(r"__(ARM_ARCH\w*|ARM_FP|riscv_\w+|STDC_HOSTED__)")
    return [f"-D{n}={v}" for n, v in re.findall(r"^#define (\w+)(?: (.*))?$", text, re.M) if asked.fullmatch(n)]


def cppcheck(part, sources=None):
    """One run for all files of a part: rules about names look across files."""
    work = os.path.join(ROOT, OUT, "cppcheck-" + part.name)   # its files would lie beside the sources otherwise
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    defines = [f for f in part.gcc_flags if f.startswith(("-D", "-I"))] + macros(part.gcc, tuple(part.gcc_flags))
    done = sh(["cppcheck", "--addon=misra", "--std=c11", "--enable=warning,style,performance,portability", "--max-configs=1", "-q",
               "--suppress=missingIncludeSystem", "--template={file}\t{line}\t{id}", "--platform=" + part.platform, "--cppcheck-build-dir=" + work, *defines,
               *(sources or part.sources)])
    text = re.sub(r"\tmisra-c2012-", "\tmisra/", done.stderr)
    found = findings("cppcheck", r"^(?P<file>[^\t\n]+)\t(?P<line>\d+)\t(?P<rule>\S+)$", text)
    found = {(r.removeprefix("cppcheck/") if "misra/" in r else r, f, n) for r, f, n in found}
    broken = done.returncode != 0 or "Bailing out" in done.stdout or "Traceback" in done.stdout + done.stderr   # of the addon: status 0
    return found | {("cppcheck/failed", part.sources[0], 0)} if broken else found


@functools.lru_cache(None)
def tidy_checks():
    text = open(os.path.join(ROOT, ".clang-tidy"), encoding="utf-8").read()
    return "".join(re.search(r"^Checks: *'([^']*)'", text, re.M)[1].split()).split(",")


def clang_tidy(part, source):
    """All checks that .clang-tidy names: those that it switches off again for editors are in the table, and are asked for here."""
    done = sh(["clang-tidy", "--quiet", "--checks=-*," + ",".join(c for c in tidy_checks() if not c.startswith("-")), "--header-filter=.*", source, "--",
               *part.clang_flags, "-Wall", "-Wextra", "-Wcomma"])
    found = findings("clang-tidy", r"^(?P<file>[^\s:]+):(?P<line>\d+):\d+: (?:warning|error): .* \[(?P<rule>[\w.,-]+)\]$", done.stdout)
    return found if done.returncode == 0 or found else {("clang-tidy/failed", source, 0)}


@functools.lru_cache(None)
def warnings():
    text = open(os.path.join(ROOT, "Makefile"), encoding="utf-8").read()
    return re.search(r"^warnings := (.*)$", text, re.M)[1].split()


def gcc(part, source):
    wanted = [w for w in warnings() if w != "-Wdouble-promotion" or "-DKELLY_DOUBLE" not in part.gcc_flags]
    done = sh([part.gcc, *part.gcc_flags, "-O2", *wanted, "-fanalyzer", "-fdiagnostics-path-format=none", "-c", source, "-o", os.devnull])
    found = findings("gcc", r"^(?P<file>[^\s:]+):(?P<line>\d+):\d+: (?:warning|error): .* \[-W(?P<rule>[\w.=+-]+)\]$", done.stderr)
    return found if done.returncode == 0 else found | {("gcc/failed", source, 0)}


# ---- the Power of Ten ----------------------------------------------------------------------------------------------------


def call_graph(part, source, out):
    """{caller: callees} as they are written: nothing is inlined."""
    where = os.path.join(out, part.name + "-" + source.replace("/", "-"))
    done = sh([part.gcc, *part.gcc_flags, "-O0", "-w", "-fcallgraph-info=su", "-c", source, "-o", where + ".o"])
    calls = {}
    if done.returncode == 0:
        with open(os.path.join(ROOT, where + ".ci"), encoding="utf-8") as file:
            for caller, callee in EDGE.findall(file.read()):
                calls.setdefault(caller, set()).add(callee)
    return calls


def place_of(name, sources):
    """A function of a call graph: (file, its first line)."""
    short = name.split(":")[-1]
    for source in sources:
        for f in c_source.of(ROOT, source).functions:
            if f.name == short and (":" not in name or source == name.rsplit(":", 1)[0]):
                return source, f.first
    return None


def recursion(calls, sources):
    """Functions that can come back to themselves."""
    def reached(start):
        seen, front = set(), set(calls.get(start, ()))
        while front:
            seen |= front
            front = {c for f in front for c in calls.get(f, ())} - seen
        return seen
    return {("power-of-ten/recursion", *(place_of(n, sources) or (sources[0], 0))) for n in calls if n in reached(n)}


def indirect(calls, sources):
    return {("power-of-ten/indirect-call", *(place_of(n, sources) or (sources[0], 0))) for n in calls if INDIRECT in calls[n]}


def of_source(path):
    """Length everywhere; loops and function pointers in firmware/."""
    source = c_source.of(ROOT, path)
    found = {("power-of-ten/length", path, f.first) for f in source.functions if f.lines > LINES_MOST}
    if not path.startswith("host/"):
        found |= {("power-of-ten/loop", path, loop.line) for loop in source.loops if not loop.bounded}
        found |= {("power-of-ten/function-pointer", path, line) for line in source.function_pointers}
    return found


# ---- the table -----------------------------------------------------------------------------------------------------------


def read_table(text):
    """[(rule, place, reason)]; rule and place may hold *, place is a file, file:function or * for all."""
    rows = [tuple(c.strip() for c in line.split(" | ")) for line in text.splitlines() if line.strip() and not line.startswith("#")]
    for row in rows:
        if len(row) != 3 or not all(row):
            sys.exit(f"{TABLE}: {' | '.join(row)}: not rule | place | reason")
    return rows


def covers(row, finding):
    rule, path, line = finding
    if rule.endswith("/failed") or "clang-diagnostic-error" in rule or not fnmatch.fnmatchcase(rule, row[0]):
        return False
    if ":" in row[1]:
        function = c_source.of(ROOT, path).function_at(line)
        return fnmatch.fnmatchcase(f"{path}:{function}", row[1])
    return fnmatch.fnmatchcase(path, row[1])


def compare(rows, found):
    """(findings without a row, rows without a finding)"""
    used = [any(covers(r, f) for f in found) for r in rows]
    return sorted(f for f in found if not any(covers(r, f) for r in rows)), [r for r, u in zip(rows, used) if not u]


def table_against_clang_tidy(rows):
    """What .clang-tidy switches off, so that an editor is quiet, are the rows for every file, no more and no less."""
    wide = {name for r in rows if r[1] == "*" and r[0].startswith("clang-tidy/") for name in r[0].removeprefix("clang-tidy/").split(",")}
    return sorted(wide ^ {c[1:] for c in tidy_checks() if c.startswith("-") and c != "-*"})


# ---- planted faults ------------------------------------------------------------------------------------------------------

COUNTS = "int count(unsigned n);\nint count(unsigned n)\n{\n    int s = 0;\n\n    for (%s) {\n        s++;\n    }\n    return s;\n}\n"
PLANTED = {
    "misra": ("misra/17.7", "int twice(int x);\nvoid lost(void);\nint twice(int x) { return 2 * x; }\nvoid lost(void) { twice(1); }\n"),
    "cppcheck": ("cppcheck/arrayIndexOutOfBounds", "int at(void);\nint at(void)\n{\n    int a[2] = { 1, 2 };\n\n    return a[2];\n}\n"),
    "clang-tidy": ("clang-tidy/bugprone-integer-division", "double half(int n);\ndouble half(int n) { return n / 2; }\n"),
    "clang-tidy-err33": ("clang-tidy/cert-err33-c", "#include <stdio.h>\nvoid out(FILE *f);\nvoid out(FILE *f) { fclose(f); }\n"),
    "gcc": ("gcc/analyzer-possible-null-dereference",
            "#include <stdlib.h>\nint *one(void);\nint *one(void)\n{\n    int *const p = malloc(sizeof(int));\n\n    *p = 1;\n    return p;\n}\n"),
    "gcc-sign": ("gcc/sign-compare", "int less(int a, unsigned b);\nint less(int a, unsigned b) { return a < b; }\n"),
    "length": ("power-of-ten/length", "int long_one(int x);\nint long_one(int x)\n{\n" + "    x++;\n" * 57 + "    return x;\n}\n"),
    "loop": ("power-of-ten/loop", "int until(const volatile int *p);\nint until(const volatile int *p)\n{\n    while (*p == 0) {\n    }\n    return 1;\n}\n"),
    "loop-counter": ("power-of-ten/loop", "int up(int n);\nint up(int n)\n{\n    for (int k = 0; k < n; k++) {\n        k -= 1;\n    }\n    return n;\n}\n"),
    "loop-zero": ("power-of-ten/loop", COUNTS % "unsigned i = n; i >= 0; i--"),
    "loop-away": ("power-of-ten/loop", COUNTS % "int i = 0; i < n; i -= 1"),
    "loop-still": ("power-of-ten/loop", COUNTS % "int i = 0; i < n; i += 0"),
    "loop-narrow": ("power-of-ten/loop", COUNTS % "uint8_t i = 0; i < 256u; i++"),
    "loop-over": ("power-of-ten/loop", COUNTS % "int i = 0; i != n; i += 2"),
    "loop-last": ("power-of-ten/loop", COUNTS % "unsigned i = 0; i <= n; i++"),
    "loop-branch": ("power-of-ten/loop", COUNTS.replace("for (%s) {", "int k = 0;\n    while (k < 9) {\n        if (s > 3) {\n            k++;\n        }")),
    "loop-wraps": ("power-of-ten/loop", COUNTS % "unsigned i = 0; i < n; i += 16"),
    "loop-float": ("power-of-ten/loop", COUNTS % "float x = 0; x < 1e9f; x++"),
    "loop-maybe": ("power-of-ten/loop", COUNTS % "unsigned i = 0; i < n; s > 3 && i++"),
    "recursion": ("power-of-ten/recursion", "int even(int n);\nint odd(int n);\nint even(int n) { return n == 0 ? 1 : odd(n - 1); }\n"
                                            "int odd(int n) { return n == 0 ? 0 : even(n - 1); }\n"),
    "indirect-call": ("power-of-ten/indirect-call", "typedef int work(int);\nint run(work *f);\nint run(work *f) { return f(1); }\n"),
    "function-pointer": ("power-of-ten/function-pointer", "int run(int (*f)(int));\nint run(int (*f)(int)) { return f != 0; }\n"),
}


def plant(name):
    """Whether the planted fault is found, by the functions above."""
    rule, text = PLANTED[name]
    path = os.path.join(OUT, "planted", name + ".c")
    with open(os.path.join(ROOT, path), "w", encoding="utf-8") as file:
        file.write(text)
    part = Part("planted", [path], "gcc", [], [])
    if rule.startswith(("misra", "cppcheck")):
        found = cppcheck(part)
    elif rule.startswith("clang-tidy"):
        found = clang_tidy(part, path)
    elif rule.startswith("gcc"):
        found = gcc(part, path)
    elif name in ("recursion", "indirect-call"):
        calls = call_graph(part, path, OUT)
        found = recursion(calls, [path]) | indirect(calls, [path])
    else:
        found = of_source(path)
    return any(r.split(",")[0] == rule for r, _, _ in found)


def table_holds():
    """The table's own rules: no finding without a row, no row without a finding, errors of a tool never covered."""
    one, other = ("misra/15.5", "a.c", 1), ("misra/15.6", "a.c", 1)
    row = ("misra/15.5", "*", "why")
    return [compare([row], {one}) == ([], []), compare([row], {one, other}) == ([other], []), compare([row], {other})[1] == [row],
            compare([("*", "*", "why")], {("gcc/failed", "a.c", 0)})[0] != []]


# ---- all -----------------------------------------------------------------------------------------------------------------


def run_tools(all_parts):
    """{tool: findings}, the calls of firmware/."""
    jobs = [(cppcheck, p) for p in sorted(all_parts, key=lambda p: -len(p.sources)) if p.name not in ("host", "mpi")]
    jobs += [(tool, p, s) for p in all_parts for s in p.sources for tool in (clang_tidy, gcc) if p.name != "device" or "/app/" in s]
    jobs += [(call_graph, p, s, OUT) for p in all_parts if p.name not in ("host", "mpi", "kernel") for s in p.sources]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(lambda job: (job[0], job[0](*job[1:])), jobs))
    calls = {}
    for tool, result in results:
        for caller in result if tool is call_graph else ():
            calls.setdefault(caller, set()).update(result[caller])
    return {f for tool, result in results if tool is not call_graph for f in result}, calls


def say_figures(rows, found, sources, calls):
    headers = [n for n in sh(["git", "ls-files", "firmware/*.h", "host/*.h"]).stdout.split()]
    lines = sum(len(open(os.path.join(ROOT, n), encoding="utf-8").read().splitlines()) for n in sources + headers)
    print(f"figure: static rules: {len(sources) + len(headers)} files of C, {lines} lines, {len(compare(rows, found)[0])} findings that no deviation covers")
    for tool, words in (("misra", "MISRA C:2012 (cppcheck)"), ("cppcheck", "cppcheck"), ("clang-tidy", "clang-tidy"), ("gcc", "gcc -fanalyzer and warnings")):
        mine = [f for f in found if f[0].startswith(tool + "/")]
        print(f"figure: {words}: {len(mine)} findings, all under {sum(r[0].startswith(tool + '/') for r in rows)} reasoned deviations")
    for tree in ("firmware", "host"):
        longest = max((f.lines, f.name) for s in sources if s.startswith(tree + "/") for f in c_source.of(ROOT, s).functions)
        print(f"figure: longest function of {tree}/: {longest[0]} lines ({longest[1]})")
    loops = [loop for s in sources if s.startswith("firmware/") for loop in c_source.of(ROOT, s).loops]
    print(f"figure: loops of firmware/: {len(loops)}, {sum(loop.bounded for loop in loops)} with a bound in sight, the others with one in the table")
    count = {r: sum(f[0] == "power-of-ten/" + r for f in found) for r in ("recursion", "indirect-call", "function-pointer")}
    print(f"figure: recursion in firmware/: {count['recursion']} of {len(calls)} functions that call")
    pointers = [f[1] for f in found if f[0] == "power-of-ten/function-pointer"]
    where = ", ".join(f"{pointers.count(n)} in {n}" for n in sorted(set(pointers)))
    print(f"figure: function pointers of firmware/: {where}; {count['indirect-call']} functions call through one")


def main():
    missing = [t for t in ("cppcheck", "clang-tidy", "gcc", "mpicc", "arm-none-eabi-gcc", "riscv64-unknown-elf-gcc") if not shutil.which(t)]
    if missing:
        print(f"missing: {' '.join(missing)}\n0 passed, {len(missing)} failed")
        return 1
    os.makedirs(os.path.join(ROOT, OUT, "planted"), exist_ok=True)
    rows = read_table(open(os.path.join(ROOT, TABLE), encoding="utf-8").read())
    all_parts = parts()
    sources = sorted({s for p in all_parts for s in p.sources} | set(n for n in sh(["git", "ls-files", "firmware/*.c"]).stdout.split()))
    found, calls = run_tools(all_parts)
    headers = sh(["git", "ls-files", "firmware/*.h", "host/*.h"]).stdout.split()
    for path in sources + headers:
        found |= of_source(path)
    firmware = [s for s in sources + headers if s.startswith("firmware/")]
    found |= recursion(calls, firmware) | indirect(calls, firmware)

    uncovered, stale = compare(rows, found)
    for rule, path, line in uncovered:
        print(f"{path}:{line}: {rule}: {c_source.of(ROOT, path).line(line).strip()[:100]}")
    for row in stale:
        print(f"{TABLE}: covers nothing: {' | '.join(row)}")
    differs = table_against_clang_tidy(rows)
    if differs:
        print(f".clang-tidy and {TABLE} differ on {' '.join(differs)}")
    unseen = [name for name in PLANTED if not plant(name)]
    for name in unseen:
        print(f"planted {name}: {PLANTED[name][0]} was not found")
    holds = table_holds()
    failed = len(uncovered) + len(stale) + len(differs) + len(unseen) + holds.count(False)
    say_figures(rows, found, sources, calls)
    print(f"figure: faults planted for the rule checkers: {len(PLANTED) - len(unseen)} of {len(PLANTED)} found")
    print(f"{len(sources) + len(rows) - len(stale) + len(PLANTED) - len(unseen) + holds.count(True)} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
