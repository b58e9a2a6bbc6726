#!/usr/bin/env python3
"""check_images - the device program on every board, float and double: budgets, instructions a step, stack, wrong tables.

Runs `make budgets`, counts and runs the image in the emulator (the painted stack must lie below the worst case of the call
graph), and links images whose table has another precision or another schema: each must say so and end with status 1.
Last line `N passed, N failed`.
"""
import argparse
import concurrent.futures
import os
import re
import subprocess
import sys

from check_budgets import budgets
from run_target import ROOT, command, run, target_settings
from size_table import measure, targets

# What is wrong, compiler flag, text of the table and what takes its place, what the board must say.
WRONG = [("number", "-O2", ".fc_min = R(0x1.f4p+9)", ".fc_min = R(0x1.f4p+8)", b"table is damaged"),
         ("precision", "-DKELLY_DOUBLE", "", "", b"differ in precision"), ("schema", "-O2", ".schema = KELLY_SCHEMA,", ".schema = KELLY_SCHEMA + 1u,", b"schema differs")]


def check_budget(target, real):
    done = subprocess.run(["make", "-s", "budgets", f"TARGET={target}", f"REAL={real}"], cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, check=False)
    found = re.search(r"(\d+) passed, (\d+) failed\s*$", done.stdout)
    if not found:
        yield False, (done.stdout + done.stderr)[-300:]
        return
    for line in done.stdout.splitlines():
        if line.startswith(("ok", "FAIL")):
            yield line.startswith("ok"), line


def check_run(target, real):
    row = measure(target, real)
    limits = dict(budgets(argparse.Namespace(target=target, real=real)))
    yield 0 < row["used"] <= row["worst"], f"stack {row['used']} of the call graph's {row['worst']}"
    if "steps.device" in limits:
        yield row["step"] <= limits["steps.device"], f"{row['step']:.1f} instructions a step, limit {limits['steps.device']}"


def check_wrong_table(target):
    """The float image with its table compiled again, wrongly."""
    out, settings = os.path.join("build", target), target_settings(target)
    elf, table = f"{out}/device.elf", f"{out}/firmware/tables/paper.o"
    link = subprocess.run(["make", "-n", "-W", table, f"TARGET={target}", elf], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    link = next(line for line in link.splitlines() if f"-o {elf}" in line)
    with open(os.path.join(ROOT, "firmware/tables/paper.c"), encoding="ascii") as file:
        text = file.read()
    for name, flag, old, new, expected in WRONG:
        source, wrong, image = (f"{out}/wrong-{name}{end}" for end in (".c", ".o", ".elf"))
        with open(os.path.join(ROOT, source), "w", encoding="ascii") as file:
            file.write(text.replace(old, new) if old else text)
        words = [settings["CROSS"] + "gcc", *settings["ARCH"].replace("\\", "").split(), "-std=c11", "-O2", "-ffreestanding", flag, "-Ifirmware/tables", "-c", source]
        subprocess.run([*words, "-o", wrong], cwd=ROOT, check=True)
        subprocess.run(link.replace(table, wrong).replace(f"-o {elf}", f"-o {image}").split(), cwd=ROOT, check=True)
        status, output = run(command(settings, os.path.join(ROOT, image)), [""], 60)
        yield status == 1 and expected in output, f"table of another {name}: status {status}, {output[-120:]!r}"


def check(target, real):
    yield from check_budget(target, real)
    yield from check_run(target, real)
    if real == "float":
        yield from check_wrong_table(target)


def main():
    jobs = [(t, r) for t in targets() for r in ("float", "double")]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(lambda job: (job, list(check(*job))), jobs))
    passed = failed = 0
    for (target, real), claims in results:
        for good, what in claims:
            passed, failed = passed + bool(good), failed + (not good)
            if not good:
                print(f"{target} {real}: {what}")
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
