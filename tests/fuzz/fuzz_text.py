#!/usr/bin/env python3
"""fuzz_text.py - malformed text for the readers written in Python: the well file (gen/), and WITS frames (tests/wits.py).

usage: tests/fuzz/fuzz_text.py SECONDS|N%

SECONDS of mutations, or with `N%` exactly N of each reader (300% in make test), by a fixed seed; corpus and regressions first.
A well file is accepted, or refused with exit 2 and one line `kelly gen: file: ...`; a WITS stream is read or a WitsError. Never a traceback.
Every 200th accepted well file goes all the way to its table. The last line is `N passed, N failed`, before it the executions.
"""
import contextlib
import glob
import importlib.util
import io
import os
import random
import sys
import tempfile
import time
import traceback

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path[:0] = [os.path.join(ROOT, "gen"), os.path.join(ROOT, "tests")]

import well as well_     # noqa: E402
import wits              # noqa: E402

spec = importlib.util.spec_from_file_location("gen_main", os.path.join(ROOT, "gen", "__main__.py"))
gen = importlib.util.module_from_spec(spec)
spec.loader.exec_module(gen)

VALUES = ["nan", "inf", "-inf", "-1", "0", "-0.0", "1e400", "1e-400", "1e308", "9" * 400, "1_000", "0x10", "0b1", "+1", ".5", "5.", "true", "[]", "{}",
          "[1, 2, 3]", "[50.0]", '["a"]', '""', '"x"', "'y'", '"""z"""', '"\\u0000"', '"\\ud800"', '"a/b"', '"..\\n"', "1979-05-27", "07:32:00",
          "{a = 1}", "[[1]]", "50", "1e3", "100.0", "1000001", "0.3", "20", "21", "1.5", "[100.0, 50.0]", "[0.0, 0.0]", '"rotating"', '"rest"', "", "#",
          "[" * 3000 + "]" * 3000, "{a=" * 500 + "1" + "}" * 500, "0.1e", "1__0", "\u0661", "\U0001f600", "1e999999999", "1e-999999999", "0." + "0" * 500 + "1"]
KEYS = ["name", "length_m", "length_ft", "outer_diameter_in", "inner_diameter_mm", "elements", "rpm", "wob_klbf", "mu", "step_s", "window_s", "start",
        '"quoted"', "a.b", "section", "case", "run.step_s", "torsional", "x" * 300, "\u00e9", "severity_limit", ""]
HEADS = ["[[section]]", "[section]", "[case]", "[run]", "[nonsense]", "[[case]]", "[", "[]", "[case.rpm]", "[ 'run' ]", "[[section]"]
CHARACTERS = '"\'[]{}=#,.\\\n\r\t \0-+eE_0159ax\ufeff\u2028\x7f\x1b'

passed = failed = 0


def claim(holds, what, data):
    global passed, failed
    if holds:
        passed += 1
        return
    failed += 1
    with tempfile.NamedTemporaryFile(prefix="fuzz-text-", suffix=".bin", dir=os.path.join(ROOT, "build"), delete=False) as file:
        file.write(data)
    print(f"FAILED: {what}\n    the input is {os.path.relpath(file.name, ROOT)}", flush=True)


# ---- well files

def mutate_line(line, rng):
    key, equals, value = line.partition("=")
    how = rng.randrange(7)
    if how == 0:
        return f"{key}= {rng.choice(VALUES)}"
    if how == 1:
        return f"{rng.choice(KEYS)} {equals or '='}{value}"
    if how == 2:
        return ""
    if how == 3:
        return line + "\n" + line
    if how == 4 and line:
        at = rng.randrange(len(line))
        return line[:at] + rng.choice(CHARACTERS) + line[at + rng.randrange(2):]
    if how == 5:
        return line + "\n" + rng.choice(HEADS)
    return f"{key}{equals} {rng.uniform(-2, 4) * 10.0 ** rng.randint(-6, 6)!r}"


def mutate_well(text, rng):
    lines = text.split("\n")
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at = rng.randrange(len(lines))
        how = rng.randrange(10)
        if how < 7:
            lines[at] = mutate_line(lines[at], rng)
        elif how == 7:
            other = rng.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        elif how == 8:
            lines = lines[:at + 1] if rng.random() < 0.3 else lines
        else:
            lines = lines + lines[at:at + rng.randrange(8)]
    data = "\n".join(lines).encode("utf-8", "surrogatepass")
    if rng.random() < 0.03:
        at = rng.randrange(len(data) + 1)
        data = data[:at] + rng.randbytes(rng.randint(1, 4)) + data[at:]
    return data


def try_well(data, path, whole):
    """-> whether it was accepted."""
    with open(path, "wb") as file:
        file.write(data)
    err, out = io.StringIO(), io.StringIO()
    status = "traceback"
    try:
        with contextlib.redirect_stderr(err), contextlib.redirect_stdout(out):
            accepted = True
            try:
                well_.parse(data.decode("utf-8"))
            except (well_.WellError, UnicodeDecodeError):
                accepted = False
            status = gen.main([path, "--out", os.path.dirname(path)]) if whole or not accepted else 0
    except Exception:                                   # noqa: BLE001 - that is what is looked for
        err = io.StringIO(traceback.format_exc()[-600:])
    said = err.getvalue()
    one_line = said.count("\n") == 1 and said.startswith(f"kelly gen: {path}:") and all(c.isprintable() or c == "\n" for c in said)
    claim(status == 0 or (status == 2 and one_line), f"well file: {status}, {said!r}", data)
    return status == 0


def wells(rng, goes_on, folder):
    sources = [open(p, encoding="utf-8").read() for p in sorted(glob.glob(os.path.join(ROOT, "gen", "wells", "*.toml")) +
                                                              glob.glob(os.path.join(ROOT, "tests", "wells", "*.toml")))]
    path = os.path.join(folder, "w.toml")
    for kept in sorted(glob.glob(os.path.join(ROOT, "tests", "fuzz", "corpus", "well", "*"))):
        with open(kept, "rb") as file:
            try_well(file.read(), path, False)
    runs = accepted = 0
    while goes_on(runs):
        accepted += try_well(mutate_well(rng.choice(sources), rng), path, accepted % 200 == 199)
        runs += 1
    return runs, accepted


# ---- WITS

def frame(rng):
    lines = [item + ("-9999" if rng.random() < 0.2 else str(260131 if item in wits.DIGITS else round(rng.uniform(-9, 999), wits.ITEMS[item][2]) if wits.ITEMS[item][2]
             else rng.randrange(100))) for item in wits.ITEMS]
    return "&&\r\n" + "\r\n".join(lines) + "\r\n!!\r\n"


def mutate_wits(rng):
    text = "".join(frame(rng) for _ in range(rng.choice((1, 1, 2))))
    for _ in range(rng.choice((0, 1, 1, 2, 5))):
        at = rng.randrange(len(text))
        text = text[:at] + rng.choice(("", "&&", "!!", "\r", "\n", "\r\n", "9", "-", ".", "\0", "\xff", "0107", "9" * 400, "e5")) + text[at + rng.randrange(4):]
    return text.encode("latin-1")


def readings(rng, goes_on):
    runs = accepted = 0
    while goes_on(runs):
        data = mutate_wits(rng)
        try:
            found = wits.frames(data)
            claim(all(list(f) and all(v is None or isinstance(v, (int, float)) for v in f.values()) for f in found), "WITS: a strange value", data)
            accepted += 1
        except wits.WitsError as error:
            claim("\n" not in str(error), f"WITS: {error!r}", data)
        except Exception:                               # noqa: BLE001
            claim(False, "WITS: " + traceback.format_exc()[-600:], data)
        runs += 1
    return runs, accepted


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    os.makedirs(os.path.join(ROOT, "build"), exist_ok=True)
    exact = sys.argv[1].endswith("%")
    amount = float(sys.argv[1].rstrip("%"))

    def lasting(share):
        end = time.monotonic() + share * amount
        return (lambda runs: runs < amount) if exact else (lambda runs: time.monotonic() < end)

    rng = random.Random(20261127)
    with tempfile.TemporaryDirectory() as folder:
        well_runs, accepted = wells(rng, lasting(0.8), folder)
    wits_runs, _ = readings(rng, lasting(0.2))
    print(f"executions {well_runs + wits_runs}: {well_runs} well files of which {accepted} accepted, {wits_runs} WITS streams")
    print(f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
