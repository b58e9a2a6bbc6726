#!/usr/bin/env python3
"""size_table - flash, RAM, stack and instructions a step of the device program on every board; build/size.md.

Each image is built and run in the emulator: the counts are exact, the stack's high-water mark is a painted one and must
lie below the worst case of the call graph. Exit 1 if one does not.
"""
import concurrent.futures
import os
import re
import subprocess
import sys

from check_budgets import Sizes
from run_target import ROOT, command, counting, run, target_settings


def targets():
    return sorted(f[:-3] for f in os.listdir(os.path.join(ROOT, "linker")) if f.endswith(".mk") and f != "targets.mk")


class Args:
    """What check_budgets.Sizes wants to know."""

    def __init__(self, target, real):
        self.target, self.real = target, real
        self.out = os.path.join(ROOT, "build", target + ("-double" if real == "double" else ""))
        kernel = [os.path.join(folder, f) for folder, _, files in os.walk(os.path.join(self.out, "firmware")) for f in files
                  if f.endswith(".o") and "/board" not in folder and "/app" not in folder]
        self.objects = sorted(kernel)


def measure(target, real):
    """One row: numbers of bytes, and instructions a step."""
    subprocess.run(["make", "-s", f"TARGET={target}", f"REAL={real}"], cwd=ROOT, check=True, stdin=subprocess.DEVNULL)
    args, settings = Args(target, real), target_settings(target)
    sizes, elf = Sizes(args, settings), os.path.join(args.out, "device.elf")
    _, counted = run(command(settings, elf, counting(settings)), ["count=1"], 300)
    _, ran = run(command(settings, elf), ["samples=1 seconds=2 from=1"], 300)
    per_step = re.search(rb"per step ([0-9.]+)", counted)
    used = re.search(rb"stack (\d+) of", ran)
    if not per_step or not used:
        raise SystemExit(f"size_table: {target} {real}: {(counted + ran).decode(errors='replace')[-300:]}")
    return {"flash": sizes.value("kernel.flash"), "image": sizes.value("flash.device"), "ram": sizes.value("ram.device") - stacks(elf, settings),
            "worst": sizes.value("stack.device"), "used": int(used[1]), "step": float(per_step[1])}


def stacks(elf, settings):
    """Bytes of the reserved stacks, which are part of .bss."""
    text = subprocess.run([settings["CROSS"] + "nm", elf], check=True, capture_output=True, text=True).stdout
    at = {name: int(value, 16) for value, _, name in (line.split() for line in text.splitlines() if len(line.split()) == 3)}
    return at["fault_stack_top"] - at["stack_base"]


def main():
    jobs = [(t, r) for t in targets() for r in ("float", "double")]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(lambda job: measure(*job), jobs))
    lines = ["| board | real | kernel and table, flash | whole image | static RAM | stack: seen in one run, worst case | instructions a step |", "|---|---|---|---|---|---|---|"]
    bad = 0
    for (target, real), row in zip(jobs, rows):
        bad += not 0 < row["used"] <= row["worst"]
        lines.append(f"| {target} | {real} | {row['flash']} | {row['image']} | {row['ram']} | {row['used']}, {row['worst']} | {row['step']:.0f} |")
    text = "\n".join(lines) + "\n"
    with open(os.path.join(ROOT, "build", "size.md"), "w", encoding="utf-8") as file:
        file.write(text)
    print(text, end="")
    return bad != 0


if __name__ == "__main__":
    sys.exit(main())
