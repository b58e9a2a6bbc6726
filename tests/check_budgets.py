#!/usr/bin/env python3
"""check_budgets - sizes against tests/budgets.txt, and what the kernel must never call.

usage: tests/check_budgets.py --target NAME --real float|double --out DIR KERNEL.o...

Run by `make budgets TARGET=...`, which builds the images that it names. Prints a table; last line `N passed, N failed`.
"""
import argparse
import fnmatch
import os
import re
import subprocess
import sys

from run_target import ROOT, target_settings
from stack_depth import Unbounded, stack_depth

# Anything undefined that is not another kernel function must be one of these: the compiler's own helpers and the three
# functions of firmware/board/memory.c. So no heap, no libm, no stdio, no clock, no libc at all.
ALLOWED = re.compile(r"mem(cpy|move|set)$|__aeabi_\w+$|__(add|sub|mul|div|neg|eq|ne|lt|le|gt|ge|unord|cmp)[sd]f[23]$|"
                     r"__(fix|fixuns|float|floatun|extend|trunc)[sd][ifd]\w+$|__(u?div|u?mod|u?divmod|mul|ashl|ashr|lshr|"
                     r"clz|ctz|popcount|cmp|ucmp)[sd]i[234]$|__gnu_thumb1_case_\w+$|_GLOBAL_OFFSET_TABLE_$")
# Double precision in a float image: Arm's names, then the generic ones.
DOUBLE = re.compile(r"__aeabi_(d\w+|cd\w+|\w+2d)$|__\w*df\w*$")


def tool(cross, name, *args):
    return subprocess.run([cross + name, *args], check=True, capture_output=True, text=True).stdout


class Sizes:
    """What a budget line can name; each value is computed when it is asked for."""

    def __init__(self, args, settings):
        self.args, self.cross = args, settings["CROSS"]
        arm = settings["FAMILY"] == "cortexm"
        self.entry = "cortexm_start" if arm else "riscv_start"
        # On entry the core stores 8 words, 26 with an FPU, and may align by one more.
        stored = 108 if settings["FLOAT"] == "hard" else 36
        self.interrupts = [f"board_interrupt+{stored}", f"tick_interrupt+{stored}"] if arm else [None]   # of one priority: only one at a time

    def sections(self, files):
        """{text, data, bss} summed, from `size` in Berkeley form: constants count as text."""
        rows = [line.split() for line in tool(self.cross, "size", *files).splitlines()[1:]]
        return {key: sum(int(row[i]) for row in rows) for i, key in enumerate(("text", "data", "bss"))}

    def value(self, what):
        """Bytes, or None where the image is not built."""
        group, _, key = what.partition(".")
        if group == "kernel":
            return self.kernel(key)
        image, base = key, os.path.join(self.args.out, key)
        if not os.path.exists(base + ".elf"):
            return None
        if group == "stack":
            return max(stack_depth(base + ".map", self.entry, interrupt)[0] for interrupt in self.interrupts)
        sizes = self.sections([base + ".elf"])
        return {"flash": sizes["text"] + sizes["data"], "ram": sizes["data"] + sizes["bss"]}[group]

    def kernel(self, key):
        """Objects whose name ends in _shapes hold what a target may drop."""
        sizes = self.sections([o for o in self.args.objects if not o.endswith("_shapes.o")])
        return {"flash": sizes["text"] + sizes["data"], "ram": sizes["data"] + sizes["bss"], **sizes}[key]


def budgets(args):
    """(what, limit) of the lines of tests/budgets.txt for this target and precision; a later line overrides."""
    chosen = {}
    with open(os.path.join(ROOT, "tests", "budgets.txt"), encoding="utf-8") as file:
        for line in file:
            words = line.split("#")[0].split()
            if words and fnmatch.fnmatchcase(args.target, words[0]) and words[1] in ("*", args.real):
                chosen[words[2]] = int(words[3])
    return chosen.items()


def check_sizes(args, sizes):
    for what, limit in budgets(args):
        if what.startswith("steps."):   # runs the image: tests/check_images.py
            continue
        try:
            value = sizes.value(what)
        except Unbounded as why:
            yield False, f"{what}: {why}"
            continue
        if value is None:
            yield False, f"{what}: image not built (make TARGET={args.target} REAL={args.real} device hello)"
        else:
            yield value <= limit, f"{what} {value} of {limit} bytes"


def undefined(cross, objects):
    """{symbol: first object that wants it} of what the kernel does not define itself."""
    wanted, defined = {}, set()
    for path in objects:
        for line in tool(cross, "nm", path).splitlines():
            *_, kind, name = line.split()
            if kind in "Uw":
                wanted.setdefault(name, path)
            elif kind.isupper():
                defined.add(name)
    return {name: path for name, path in wanted.items() if name not in defined}


def check_symbols(args, cross):
    foreign = undefined(cross, args.objects)
    strange = [f"{n} ({p})" for n, p in foreign.items() if not ALLOWED.match(n)]
    yield not strange, "calls outside the kernel: " + (", ".join(strange) or "none but the compiler's helpers")
    if args.real == "float":
        doubles = [f"{n} ({p})" for n, p in foreign.items() if DOUBLE.match(n)]
        yield not doubles, "double precision in a float image: " + (", ".join(doubles) or "none")


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--target", required=True)
    parser.add_argument("--real", choices=("float", "double"), required=True)
    parser.add_argument("--out", required=True)
    parser.add_argument("objects", nargs="+")
    args = parser.parse_args()
    sizes = Sizes(args, target_settings(args.target))
    results = [*check_sizes(args, sizes), *check_symbols(args, sizes.cross)]
    for good, text in results:
        print(("ok    " if good else "FAIL  ") + text)
    failed = sum(not good for good, _ in results)
    print(f"{args.target} {args.real}: {len(results) - failed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
