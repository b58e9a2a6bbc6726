#!/usr/bin/env python3
"""m4_cycles - what one RK4 step costs on a Cortex-M4F, from a trace of the emulator and the datasheet's cycle counts.

usage: tests/m4_cycles.py [IMAGE.elf]      (default build/stm32f405/device.elf, `make TARGET=stm32f405`)

QEMU writes each program counter; the listing says which instruction that is; the Technical Reference Manual of the
Cortex-M4 says what it costs: 1 cycle for most, VDIV 14, a load or store of n words n + 1, a branch taken 3, one more
where an arithmetic result is used by the very next instruction. Flash is taken as free of wait states (the part has an
accelerator with a cache; the loop fits it). An estimate, not a measurement on silicon.
"""
import collections
import os
import re
import subprocess
import sys
import tempfile

from run_target import ROOT, command, run, target_settings

CLOCK, REALISATIONS, STEPS, MODES = 168e6, 400, 100_000, 10
LINE = re.compile(r"^\s*([0-9a-f]+):\s+(\S+)\s*([^@;]*)")


def listing(elf):
    """{address: (mnemonic, operands)} of the function that steps."""
    text = subprocess.run(["arm-none-eabi-objdump", "-d", "--no-show-raw-insn", elf], check=True, capture_output=True, text=True).stdout
    body = re.search(r"<kelly_block_advance>:\n(.*?)\n\n", text + "\n\n", re.S)[1]
    return {int(m[1], 16): (m[2].split(".")[0], m[3].strip()) for m in map(LINE.match, body.splitlines()) if m}


def words(operands):
    """Registers in a list such as {s16-s26}."""
    inside = re.search(r"\{(.*)\}", operands)[1]
    count = 0
    for part in inside.split(","):
        ends = [int(re.sub(r"\D", "", end) or 0) for end in part.split("-")]
        count += ends[-1] - ends[0] + 1
    return count


def cost(name, operands, taken):
    if name.startswith(("vldm", "vstm", "ldm", "stm", "push", "pop", "vpush", "vpop")):
        return 1 + words(operands)
    if name.startswith("vdiv"):
        return 14
    if name.startswith(("vldr", "vstr", "ldr", "str")):
        return 2
    if name.startswith(("vmla", "vmls", "vnmla", "vnmls")):
        return 3
    return 3 if taken else 1


def result(name, operands):
    """The register that an arithmetic instruction leaves for the next one, or None."""
    return operands.split(",")[0].strip() if re.match(r"v(add|sub|mul|div|neg|abs|mla|mls|nm)", name) else None


def trace(elf):
    """Program counters in order."""
    settings = target_settings("stm32f405")
    with tempfile.TemporaryDirectory() as folder:
        log = os.path.join(folder, "trace")
        status, output = run(command(settings, elf, extra=("-singlestep", "-d", "exec,nochain", "-D", log)), ["count=1"], 300)
        if status != 0:
            sys.exit(f"m4_cycles: the image ended with {status}: {output.decode(errors='replace')[-200:]}")
        with open(log, encoding="utf-8") as file:
            for line in file:
                field = line.split("/")
                if len(field) > 2:
                    yield int(field[1], 16)


def main():
    elf = sys.argv[1] if len(sys.argv) > 1 else os.path.join(ROOT, "build/stm32f405/device.elf")
    code = listing(elf)
    cycles = count = 0
    kinds, before, last = collections.Counter(), None, None
    for address in trace(elf):
        inside = code.get(address)
        if last:   # the one before, now that it is known where it went
            name, operands = code[last]
            jumped = address not in (last + 2, last + 4)
            cycles += cost(name, operands, jumped)
            left = result(name, operands)
            if inside and left and re.search(rf"\b{left}\b", ",".join(inside[1].split(",")[1:]) if result(*inside) else inside[1]):
                cycles += 1
            count += 1
            kinds[name] += 1
        last = address if inside else None
    steps = kinds["vldmia"] / MODES
    seconds = cycles / steps * REALISATIONS * STEPS / CLOCK
    print(f"{count / steps:.0f} instructions and {cycles / steps:.0f} cycles a step (datasheet); "
          f"{REALISATIONS} x 100 s on a {CLOCK / 1e6:.0f} MHz Cortex-M4F: {seconds:.0f} s, {REALISATIONS * 100 / seconds:.0f} times real time")


if __name__ == "__main__":
    main()
