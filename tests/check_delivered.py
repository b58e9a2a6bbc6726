#!/usr/bin/env python3
"""check_delivered - what a user gets: the archive of make dist, and what make install puts where, under the suite.

usage: tests/check_delivered.py [--suite]

The archive is made in this tree, in two unpacked copies of itself and in a repository that one of them is put into, under other
paths, umasks, time zones and locales: always the same bytes. What is built in two copies is the same bytes too. Every check of
the command line then runs from within a copy, against the program that was installed from it; --suite: all of `make test`
from within a copy instead. Needs git. Last line `N passed, N failed`.
"""
import concurrent.futures
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
# all of each, but for what builds other strings: that is in --suite
CHECKS = {"cli": (), "map": (), "whatif": (), "until": (), "sensitivity": (), "figures": (),
          "use": ("help", "options_are_told", "defaults", "install", "quiet", "progress", "colour", "ssi", "units", "field")}
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


def check_same_build(copies):
    """-> installed programs of the first copy."""
    for copy, machine in zip(copies, (HERE, THERE)):
        for words in (("all",), ("all", "REAL=double"), ("TARGET=stm32f405", "device")):
            status, _, wrong = run(copy, machine, "make", "-s", f"-j{os.cpu_count()}", *words)
            claim(status == 0, f"make {words} in {copy}: {wrong[-300:]}")
    programs = {}
    for real in ("float", "double"):
        prefix = os.path.join(os.path.dirname(os.path.dirname(copies[0])), "installed", real)
        for copy, machine, to in ((copies[1], THERE, prefix + "-there"), (copies[0], HERE, prefix)):
            status, _, wrong = run(copy, machine, "make", "-s", "install", f"PREFIX={to}", f"REAL={real}")
            claim(status == 0, f"make install {real}: {wrong[-300:]}")
        programs[real] = os.path.join(prefix, "bin", "kelly")
        built = os.path.join(copies[0], "build", "host" + "-double" * (real == "double"), "kelly")
        claim(digest(programs[real]) == digest(built), f"{real}: another program is installed")
    same = [name for name in BUILT if digest(os.path.join(copies[0], name)) == digest(os.path.join(copies[1], name))]
    claim(same == list(BUILT), f"built twice, the same: {same} of {BUILT}")
    print(f"figure: built twice byte for byte the same: {len(same)} of {len(BUILT)} ({', '.join(same)})")
    return programs


def counts(said):
    found = re.search(r"(\d+) passed, (\d+) failed\s*$", said)
    return (int(found[1]), int(found[2])) if found else (0, 1)


def check_suite_of(copy, programs):
    """The checks of the command line, from within the copy, against what was installed from it."""
    check = lambda name: run(copy, HERE, sys.executable, f"tests/check_{name}.py", "--float", programs["float"],
                             "--double", programs["double"], *CHECKS[name])
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(check, CHECKS))
    passed = 0
    for name, (status, said, wrong) in zip(CHECKS, results):
        good, bad = counts(said)
        passed += good
        claim(status == 0 and good > 0 and bad == 0, f"check_{name} against the installed program: {(said + wrong)[-1500:]}")
    print(f"figure: claims about the command line that the installed program meets: {passed}")


def check_whole_suite(copy):
    status, said, wrong = run(copy, HERE, "make", "-s", "test")
    good, bad = counts(said)
    claim(status == 0 and good > 0 and bad == 0, f"make test from within the archive: {(said + wrong)[-3000:]}")
    print(f"figure: make test from within the archive: {good} passed, {bad} failed")


def main():
    with tempfile.TemporaryDirectory() as scratch:
        first = dist(ROOT, HERE)
        check_contents(first)
        if "--suite" in sys.argv[1:]:
            check_whole_suite(unpack(first, os.path.join(scratch, "suite"), HERE))
        else:
            copies = [unpack(first, os.path.join(scratch, "one"), HERE), unpack(first, os.path.join(scratch, "another", "place"), THERE)]
            check_same_archive(first, copies)
            programs = check_same_build(copies)
            check_suite_of(copies[0], programs)
            claim(digest(dist(copies[0], HERE)) == digest(first), "after the build and the suite, the archive differs")
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
