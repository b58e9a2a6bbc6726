#!/usr/bin/env python3
"""check_targets - every board, alone: does it start, count, keep time, compute, and name each fault instead of hanging?

usage: tests/check_targets.py [TARGET...]

Builds tests/target_hello.c (float and double) and tests/faults/*.c with linker/targets.mk and runs them in QEMU. A fault
image says in its first comment what to expect, a regular expression, and which targets to skip and why. Needs the two
compilers and QEMU. Last line `N passed, N failed`.
"""
import concurrent.futures
import io
import os
import re
import subprocess
import sys

from run_target import ROOT, TIMED_OUT, command, counting, run, target_settings
from stack_depth import Unbounded, stack_depth

FAULT = 70
LINE = "seed=12345678901 first=7"
BIG = 12345678901
# What hello prints on any IEEE machine (hexadecimal); computed on x86-64 by the same expressions.
EVERYWHERE = {"seed_low": BIG & 0xFFFFFFFF, "seed_high": BIG >> 32, "first": 7, "data": 0x12345678, "bss": 0,
              "float_third": 0x3EAAAAAB, "float_subnormal": 0x000C1953, "float_sum": 0x4B800002,
              "float_product": 0x3DE38E3A, "ticks": 1, "cost": 1000, "cost_again": 0}
REAL = {"float": {"real_low": 0x3F5CE784, "real_high": 0}, "double": {"real_low": 0xD89AE430, "real_high": 0x3FEB9CF0}}
# Image of one target in the machine of another with the same memory map and no such FPU.
WRONG_FPU = [("mps2-an386", "float", "qemu-system-arm -M mps2-an385", "one, this core has none"),
             ("stm32f405", "float", "qemu-system-arm -M netduino2", "one, this core has none"),
             ("mps2-an500", "double", "qemu-system-arm -M mps2-an386", "double precision, this core has single"),
             ("rv32", "float", "qemu-system-riscv32 -M virt -bios none -cpu rv32,f=false,d=false", "does not have"),
             ("rv64", "float", "qemu-system-riscv64 -M virt -bios none -cpu rv64,f=false,d=false", "does not have")]


def out_of(target, real):
    return os.path.join("build", target + ("-double" if real == "double" else ""))


def build(target, real, *goals):
    words = ["make", "-s", "-f", "linker/targets.mk", "TARGET=" + target, "REAL=" + real, "OUT=" + out_of(target, real)]
    done = subprocess.run([*words, *goals], cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        yield False, f"build of {' '.join(goals)}, {real}:\n{done.stdout}{done.stderr}"


def values(output):
    return {k: int(v, 16) for k, v in re.findall(r"^(\w+) ([0-9a-f]{8})$", output.decode(errors="replace"), re.M)}


def check_hello(target, real):
    """Values, exact counts, and twice the same; the painted stack stays below the computed worst case. (How deep the
    stack went depends on where the tick struck, and that on when the host answered.)"""
    settings, base = target_settings(target), os.path.join(ROOT, out_of(target, real), "hello")
    words = command(settings, base + ".elf", counting(settings))
    shown = io.BytesIO()
    (status, output), (_, again) = run(words, [LINE], 60, shown), run(words, [LINE], 60)
    seen, second = values(output), values(again)
    same = {**seen, "stack_used": 0} == {**second, "stack_used": 0}
    yield status == 0 and same, f"hello {real}: status {status}, two runs the same: {same}"
    yield output.count(b"?") > 0 and shown.getvalue() == re.sub(rb"(?m)^\?\r?\n", b"", output), f"hello {real}: shown without its question: {shown.getvalue()!r}"
    for name, want in {**EVERYWHERE, **REAL[real]}.items():
        got = seen.get(name, -1)
        yield got == want, f"hello {real}: {name} is {got:#x}, wanted {want:#x}"
    yield from check_stack(base, settings, seen.get("stack_used", 0), real)


def check_stack(base, settings, used, real):
    arm = settings["FAMILY"] == "cortexm"
    try:
        worst, _ = stack_depth(base + ".map", "cortexm_start" if arm else "riscv_start",
                               "board_interrupt+108" if arm else None)
        yield 0 < used <= worst, f"hello {real}: {used} bytes of stack used, worst case {worst}"
    except Unbounded as why:
        yield False, f"hello {real}: {why}"


def check_silence(target):
    """Nobody answers the question: the image goes on by itself after its time-out, which an emulator that jumps over
    sleep passes at once."""
    settings = target_settings(target)
    icount = counting(settings) + ",sleep=off"
    words = command(settings, os.path.join(ROOT, out_of(target, "float"), "hello.elf"), icount)
    status, output = run(words, None, 60)
    seen = values(output)
    yield status == 0 and seen.get("seed_low") == 1, f"silence: status {status}, {output[-200:]!r}"


def expectation(path, target, settings):
    """The regular expression that an image's output must match, None where the target cannot show this fault."""
    with open(path, encoding="utf-8") as file:
        comment = file.read().split("*/")[0]
    skip = re.search(r"skip: (\w[\w-]*)", comment)
    if skip and skip[1] in (target, settings["FLOAT"], settings["FAMILY"]):
        return None
    return re.search(r"expect: ([^\n*]*[^\n* ])", comment)[1]


def check_fault(target, name):
    settings = target_settings(target)
    want = expectation(os.path.join(ROOT, "tests", "faults", name + ".c"), target, settings)
    if want is None:
        return
    elf = os.path.join(ROOT, out_of(target, "float"), "faults", name + ".elf")
    status, output = run(command(settings, elf), timeout=2 if want == "time-out" else 20)
    if want == "time-out":
        good = status == TIMED_OUT
    elif want.startswith("status "):
        good = status == int(want.split()[1])
    else:
        good = status == FAULT and re.search(b"fault: (" + want.encode() + b")", output) is not None
    yield good, f"fault {name}: status {status}, wanted {want}; {output.decode(errors='replace').strip()[-300:]}"


def check_wrong_fpu(target, real, machine, want):
    settings = {**target_settings(target), "QEMU": machine}
    status, output = run(command(settings, os.path.join(ROOT, out_of(target, real), "hello.elf")), timeout=20)
    text = output.decode(errors="replace").strip()
    yield status == FAULT and "wrong FPU" in text and want in text, f"wrong FPU: {machine}: status {status}, {text}"


def check_target(target):
    results = [*build(target, "float", "hello", "faults"), *build(target, "double", "hello")]
    if results:
        return target, results
    for real in ("float", "double"):
        results += check_hello(target, real)
    results += check_silence(target)
    for name in sorted(f[:-2] for f in os.listdir(os.path.join(ROOT, "tests", "faults")) if f.endswith(".c")):
        results += check_fault(target, name)
    for case in WRONG_FPU:
        if case[0] == target:
            results += check_wrong_fpu(*case)
    return target, results


def main():
    names = (f[:-3] for f in os.listdir(os.path.join(ROOT, "linker")) if f.endswith(".mk"))
    targets = sys.argv[1:] or sorted(set(names) - {"targets"})
    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for target, results in pool.map(check_target, targets):
            wrong = [text for good, text in results if not good]
            passed, failed = passed + len(results) - len(wrong), failed + len(wrong)
            print(f"{target}: {len(results) - len(wrong)} passed, {len(wrong)} failed", flush=True)
            for text in wrong:
                print("  FAIL " + text)
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
