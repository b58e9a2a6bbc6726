"""coverage_data - what llvm-cov says of a set of programs: lines, branches and conditions, each place counted once.

A place counts as covered when any program covers any of its copies: a file is compiled for several vector units, in float and in
double, and an inline function into every file that uses it.
"""
import collections
import json
import os
import re
import subprocess

LLVM = "-19"                    # the first clang in Debian 12 that counts MC/DC
# Optimised, or the lanes take minutes. Profiles of processes that run at once are merged into one file for each program.
CFLAGS = "-O1 -fprofile-instr-generate -fcoverage-mapping -fcoverage-mcdc -Wno-unsupported-mcdc"


class File:
    """lines {number: covered}, branches {(line, column, last line, end, side): taken}, conditions {(line, column, k): shown to decide alone}."""

    def __init__(self):
        self.lines, self.branches, self.conditions = (collections.defaultdict(bool) for _ in range(3))


def tool(name, *words):
    done = subprocess.run(["llvm-" + name + LLVM, *words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"llvm-{name}{LLVM}: {done.stderr[-500:]}")
    return done.stdout


def merge(folders, out):
    """All profiles of these folders in one."""
    raw = [os.path.join(f, n) for f in folders for n in sorted(os.listdir(f)) if n.endswith(".profraw")]
    tool("profdata", "merge", "-sparse", "-o", out, *raw)


def measured(profile, programs, root):
    """-> {path below root: File} of every file below root."""
    objects = [programs[0], *(word for p in programs[1:] for word in ("-object", p))]
    files = collections.defaultdict(File)
    for record in tool("cov", "export", "-format=lcov", f"-instr-profile={profile}", *objects).split("end_of_record"):
        name = re.search(r"^SF:(.*)$", record, re.M)
        for line, count in re.findall(r"^DA:(\d+),(\d+)$", record, re.M):
            files[os.path.relpath(name[1], root)].lines[int(line)] |= count != "0"
    data = json.loads(tool("cov", "export", f"-instr-profile={profile}", *objects))["data"][0]["files"]
    for record in data:
        file = files[os.path.relpath(record["filename"], root)]
        for *place, true, false, _, _, _ in record["branches"]:
            file.branches[*place, "true"] |= true > 0
            file.branches[*place, "false"] |= false > 0
        for line, column, *_, shown in record.get("mcdc_records", []):
            for k, one in enumerate(shown):
                file.conditions[line, column, k] |= one
    return {name: file for name, file in files.items() if not name.startswith("..")}
