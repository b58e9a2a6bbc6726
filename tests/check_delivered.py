#!/usr/bin/env python3
"""check_delivered - what a user gets: the archive of make dist, and what make install puts where, under the suite.

usage: tests/check_delivered.py [--suite]

The archive is made in this tree, in two unpacked copies of itself and in a repository that one of them is put into, under other
paths, umasks, time zones and locales: always the same bytes. What is built in two copies is the same bytes too.

Every check that runs the host program then runs from within a copy, against the programs that were installed from it; the copy's own are
taken away first. Of "rare", "bench" and "bench_device", minutes each, a part; --suite: all of them, and `make test` from within
another copy. Of "use", never what builds strings and asks the generator: neither is installed. Left out for the same reasons are checks of
what they build themselves (back_to_back, coverage, digests, fuzz, random, rebuilds, sanitizers), of the generator (gen, wells), of boards
and their images (board_coverage, budgets, images, on_targets, targets), of the link's code (link, faulty_line) and of the source (rules, eva).
Needs git. Last line `N passed, N failed`.
"""
import concurrent.futures
import glob
import hashlib
import os
import re
import subprocess
import sys
import tarfile
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TOP = {"Makefile", "README.md", "firmware", "gen", "host", "linker", "tests"}   # and dot-files
# two machines: umask, environment
HERE = (0o022, {"TZ": "UTC", "LC_ALL": "C"})
THERE = (0o077, {"TZ": "Asia/Kathmandu", "LC_ALL": "C.UTF-8", "LANGUAGE": "de"})
BUILT = ("build/host/kelly", "build/host-double/kelly", "build/host/kelly.1", "build/stm32f405/device.bin")
BOARDS = ("stm32f405", "mps2-an500", "rv32", "microbit")   # that bench and bench_device ask
# name: what of it; long ones first. The last relinks the copy's own program, for make install.
CHECKS = {"map": (), "cli": (), "figures": (), "bench": ("three kinds", "in step", "host killed", "another case", "misuse"),
          "rare": ("bad_usage", "plain_level", "same_bits", "not_random"), "bench_device": ("campaign",), "nothing_lost": (), "drive": (),
          "plan": ("--mpi", "{mpi}"), "mpi": ("--mpi", "{mpi}"), "whatif": (), "sensitivity": (), "merge": (), "until": (),
          "use": ("help", "options_are_told", "spelling", "defaults", "install", "quiet", "progress", "colour", "ssi", "units", "field")}
PART = ("bench", "rare", "bench_device")
count = {True: 0, False: 0}


def claim(holds, what):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return holds


def run(where, machine, *words):
    """-> (status, stdout, stderr) of a command in the directory `where`."""
    mask, more = machine
    done = subprocess.run(words, cwd=where, env={**os.environ, **more}, umask=mask, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          check=False)
    return done.returncode, done.stdout, done.stderr


def digest(path):
    if not os.path.exists(path):
        return f"no {path}"
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def make(where, machine, *words):
    status, _, wrong = run(where, machine, "make", "-s", f"-j{os.cpu_count()}", *words)
    claim(status == 0, f"make {' '.join(words)} in {where}: {wrong[-300:]}")


def dist(where, machine):
    """Path of the archive that make dist makes there."""
    status, said, wrong = run(where, machine, "make", "-s", "dist")
    claim(status == 0 and re.fullmatch(r"build/kelly-[0-9.]+\.tar\.gz\n", said), f"make dist in {where}: {said}{wrong}")
    return os.path.join(where, said.strip())


def unpack(archive, where, machine):
    """-> the directory that it unpacks into."""
    os.makedirs(where)
    claim(run(where, machine, "tar", "--no-same-permissions", "-xzf", archive)[0] == 0 and len(os.listdir(where)) == 1, f"{archive} unpacks into one directory")
    return os.path.join(where, os.listdir(where)[0])


def check_contents(archive):
    with tarfile.open(archive) as tar:
        files = tar.getmembers()
    version = re.fullmatch(r"kelly-(.*)\.tar\.gz", os.path.basename(archive))[1]
    inside = [f.name.removeprefix(f"kelly-{version}/") for f in files]
    claim(all(f.name.startswith(f"kelly-{version}/") and f.isfile() for f in files), "files only, all below kelly-VERSION")
    top = {name.split("/")[0] for name in inside if not name.startswith(".")}
    claim(top == TOP, f"top level: {sorted(top)}")
    claim(not [n for n in inside if re.search(r"(^|/)(build|__pycache__)/|\.(o|elf|pyc)$", n)], "nothing that was built")
    claim({f.uid + f.gid for f in files} == {0} and len({f.mtime for f in files}) == 1, "one owner, one time")
    claim({f.mode for f in files} == {0o644, 0o755}, "modes of a fresh clone")
    if os.path.exists(os.path.join(ROOT, ".git")):
        tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split()
        claim(sorted(inside) == sorted(tracked), f"what git tracks and nothing else: {set(inside) ^ set(tracked)}")
    print(f"figure: files in the archive: {len(files)}")


def check_same_archive(first, copies):
    """Made again here and there; in a repository where a file lies about that is not part of it; after a build."""
    want, same = digest(first), 1
    same += claim(digest(dist(ROOT, THERE)) == want, "made twice in the same place, the archive differs")
    same += claim(digest(dist(copies[0], HERE)) == want, "made from an unpacked archive, it differs")
    for base, _, names in os.walk(copies[1]):
        for name in names:
            os.utime(os.path.join(base, name))
    run(copies[1], THERE, "git", "init", "-q", ".")
    run(copies[1], THERE, "git", "add", ".")
    with open(os.path.join(copies[1], "host", "notes.txt"), "w", encoding="ascii") as file:
        file.write("not part of it\n")
    same += claim(digest(dist(copies[1], THERE)) == want, "made in a repository, it differs")
    os.remove(os.path.join(copies[1], "host", "notes.txt"))
    print(f"figure: archives of make dist of the same bytes, over paths, umasks, time zones, with git and without: {same} of 4")


def build(copies):
    for copy, machine in zip(copies, (HERE, THERE)):
        for words in (("all",), ("all", "REAL=double"), ("TARGET=stm32f405", "device")):
            make(copy, machine, *words)


def installed(copies):
    """-> {name: program} of what make install of the first copy has put into prefixes of their own."""
    programs = {}
    for name, kind, settings in (("float", "host", ()), ("double", "host-double", ("REAL=double",)), ("mpi", "mpi", ("MPI=1",))):
        prefix = os.path.join(os.path.dirname(os.path.dirname(copies[0])), "installed", name)
        make(copies[0], HERE, "install", f"PREFIX={prefix}", *settings)
        if name != "mpi":
            make(copies[1], THERE, "install", f"PREFIX={prefix}-there", *settings)
        programs[name] = os.path.join(prefix, "bin", "kelly")
        claim(digest(programs[name]) == digest(os.path.join(copies[0], "build", kind, "kelly")), f"{name}: another program is installed")
    return programs


def check_same_build(copies):
    same = [name for name in BUILT if digest(os.path.join(copies[0], name)) == digest(os.path.join(copies[1], name))]
    claim(same == list(BUILT), f"built twice, the same: {same} of {BUILT}")
    print(f"figure: built twice byte for byte the same: {len(same)} of {len(BUILT)} ({', '.join(same)})")


def counts(said):
    found = re.search(r"(\d+) passed, (\d+) failed\s*$", said)
    return (int(found[1]), int(found[2])) if found else (0, 1)


def check_all_are_listed():
    """Every check that lets the command line choose its program is one of CHECKS."""
    found = set()
    for path in glob.glob(os.path.join(ROOT, "tests", "check_*.py")):
        with open(path, encoding="utf-8") as file:
            if re.search(r"^from (programs|scenarios) import", file.read(), re.M):
                found.add(os.path.basename(path)[6:-3])
    claim(found == set(CHECKS), f"checks of the host program and CHECKS differ: {found ^ set(CHECKS)}")


def take_away(copy, programs):
    """What is built but not installed is made, and the copy's own programs are gone: a check that runs them cannot pass."""
    for board in BOARDS:
        make(copy, HERE, f"TARGET={board}", "device")
    for kind, settings in (("host", ()), ("host-double", ("REAL=double",))):
        make(copy, HERE, f"build/{kind}/drive-numbers", *settings)
    for kind in ("host", "host-double", "mpi"):
        os.remove(os.path.join(copy, "build", kind, "kelly"))
    claim(all(os.path.exists(p) for p in programs.values()), f"installed: {programs}")


def check_suite_of(copy, programs, whole):
    """The checks of the host program, from within the copy, against what was installed from it."""
    def check(name):
        words = () if whole and name in PART else [word.format(**programs) for word in CHECKS[name]]
        return run(copy, HERE, sys.executable, f"tests/check_{name}.py", "--float", programs["float"], "--double", programs["double"], *words)
    take_away(copy, programs)
    *names, last = CHECKS
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(check, names)) + [check(last)]
    passed = 0
    for name, (status, said, wrong) in zip(CHECKS, results):
        good, bad = counts(said)
        passed += good
        claim(status == 0 and good > 0 and bad == 0, f"check_{name} against the installed program: {(said + wrong)[-1500:]}")
    print(f"figure: claims about the host program that the installed one meets, {len(CHECKS)} checks: {passed}")


def check_whole_suite(copy):
    status, said, wrong = run(copy, HERE, "make", "-s", "test")
    good, bad = counts(said)
    claim(status == 0 and good > 0 and bad == 0, f"make test from within the archive: {said[-3000:]}{wrong[-300:]}")
    print(f"figure: make test from within the archive: {good} passed, {bad} failed")


def main():
    whole = "--suite" in sys.argv[1:]
    with tempfile.TemporaryDirectory() as scratch:
        first = dist(ROOT, HERE)
        check_contents(first)
        check_all_are_listed()
        copies = [unpack(first, os.path.join(scratch, "one"), HERE), unpack(first, os.path.join(scratch, "another", "place"), THERE)]
        check_same_archive(first, copies)
        build(copies)
        programs = installed(copies)
        check_same_build(copies)
        check_suite_of(copies[0], programs, whole)
        claim(digest(dist(copies[0], HERE)) == digest(first), "after the build and the suite, the archive differs")
        if whole:
            check_whole_suite(unpack(first, os.path.join(scratch, "suite"), HERE))
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
