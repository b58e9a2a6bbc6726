#!/usr/bin/env python3
"""Claims about bad well files: one line on stderr that names file, key, value and what would be right; exit 2; no file.

Run with an interpreter that has numpy. Prints one line for each claim that fails, then `N passed, N failed`.
"""
import os
import random
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "gen"))
import well as well_        # noqa: E402

with open(os.path.join(ROOT, "gen", "wells", "paper.toml"), encoding="utf-8") as paper:
    PAPER = paper.read()
count = {True: 0, False: 0}
PATIENCE = 30         # [s]; a file takes less than one

LENGTH = ("length_m = 1400.0", "section[1].length_m")
INNER = ("inner_diameter_mm = 95.0          # not", "section[2].inner_diameter_mm")
ELEMENTS = ("elements = 80", "section[1].elements")
STEP, WINDOW = ("step_s = 0.001", "run.step_s"), ("window_s = [50.0, 100.0]", "run.window_s")

# (what is in the file, what it becomes, the key and the value that the line must name, words of the advice)
EDITS = [
    (LENGTH[0], "length_m = -1400.0", f"{LENGTH[1]} = -1400.0", "0.1 to 20000 m"),
    (LENGTH[0], "length_m = 0.0", f"{LENGTH[1]} = 0.0", "0.1 to 20000 m"),
    (LENGTH[0], "length_m = nan", f"{LENGTH[1]} = NaN", "a number"),
    (LENGTH[0], "length_m = inf", f"{LENGTH[1]} = Infinity", "a number"),
    (LENGTH[0], "length_m = 1e400", f"{LENGTH[1]} = 1E+400", "a number"),
    (LENGTH[0], "length_m = 1" + 400 * "0", f"{LENGTH[1]} = 1000", "a number"),
    (LENGTH[0], 'length_m = "1400"', f'{LENGTH[1]} = "1400"', "a number"),
    (LENGTH[0], "length_m = true", f"{LENGTH[1]} = true", "a number"),
    (LENGTH[0], "length_m = [1400.0]", f"{LENGTH[1]} = [1400.0]", "a number"),
    (LENGTH[0], "length_m = 2024-01-01", f'{LENGTH[1]} = "2024-01-01"', "a number"),
    (LENGTH[0], "", f"{LENGTH[1]} = (missing)", "0.1 to 20000 m"),
    (LENGTH[0], "length_km = 1.4", "section[1].length_km = 1.4", "did you mean length_m"),
    (INNER[0], "inner_diameter_mm = 150.0 #", f"{INNER[1]} = 150.0", "less than outer_diameter_mm = 150.0"),
    (INNER[0], "inner_diameter_mm = 160.0 #", f"{INNER[1]} = 160.0", "less than outer_diameter_mm = 150.0"),
    (INNER[0], "inner_diameter_mm = -1.0 #", f"{INNER[1]} = -1.0", "0 to 2000 mm"),
    ("outer_diameter_mm = 120.0", "outer_diameter_mm = 0.12", "section[1].outer_diameter_mm = 0.12", "1 to 2000 mm"),
    (ELEMENTS[0], "elements = 0", f"{ELEMENTS[1]} = 0", "a whole number from 1"),
    (ELEMENTS[0], "elements = -3", f"{ELEMENTS[1]} = -3", "a whole number from 1"),
    (ELEMENTS[0], "elements = 80.0", f"{ELEMENTS[1]} = 80.0", "a whole number"),
    (ELEMENTS[0], "elements = 970", "section[2].elements = 40", "at most 1000"),
    ('name = "drill pipe"', 'name = "drill */ pipe"', 'section[1].name = "drill */ pipe"', "letters"),
    ('name = "paper"', 'name = "../paper"', 'name = "../paper"', "letters"),
    ('name = "paper"', 'name = ""', 'name = ""', "letters"),
    ('name = "paper"', 'name = "x_shapes"', 'name = "x_shapes"', "_shapes"),
    ('name = "paper"', "", "name = (missing)", "letters"),
    ("youngs_modulus_GPa = 210.0", "youngs_modulus_GPa = 210e9", "material.youngs_modulus_GPa = 2.1", "1 to 1000 GPa"),
    ("density_kg_m3 = 7850.0", "density_kg_m3 = 7.85", "material.density_kg_m3 = 7.85", "100 to 30000 kg/m3"),
    ("mass_per_s = 0.1", "mass_per_s = -0.1", "damping.mass_per_s = -0.1", "0 to 100"),
    ("[environment]", "[surroundings]", "surroundings = {gravity_m_s2 = 9.81}", "unknown key"),
    ("gravity_m_s2 = 9.81", "", "environment.gravity_m_s2 = (missing)", "m/s2"),
    ("torsional = 10", "torsional = 21", "modes.torsional = 21", "1 to 20"),
    ("torsional = 10", "torsional = 0", "modes.torsional = 0", "1 to 20"),
    ("axial = 2 ", "axial = 0 ", "modes.axial = 0", "1 to 20"),
    ("rpm = 100.0", "rpm = 0", "case.rpm = 0", "0.1 to 1000"),
    ("wob_kN = 100.0", "wob_kN = 900.0", "case.wob_kN = 900.0", "2 to 500 kN"),
    ("mu = 0.04", "mu = 0", "case.mu = 0", "1e-06 to 10"),
    ("alpha2 = 1.0", "alpha2 = -1.0", "case.alpha2 = -1.0", "a number from"),
    ("wob = 0.2", "wob = 0.51", "uncertainty.wob = 0.51", "0 to 0.5"),
    ("rpm = 0.2", "rpm = -0.1", "uncertainty.rpm = -0.1", "0 to 0.5"),
    (STEP[0], "step_s = 0", f"{STEP[1]} = 0", "whole number of nanoseconds"),
    (STEP[0], "step_s = 0.0000000015", f"{STEP[1]} = 1.5E-9", "whole number of nanoseconds"),
    (STEP[0], "step_s = 0.002", f"{STEP[1]} = 0.002", "at most 0.00108"),
    ("duration_s = 100.0", "duration_s = 100.0005", "run.duration_s = 100.0005", "multiple of step_s = 0.001"),
    ("duration_s = 100.0", "duration_s = 4000000.001", "run.duration_s = 4000000.001", "at most 4000000000 steps"),
    ("duration_s = 100.0", "duration_s = 60.0", f"{WINDOW[1]} = [50.0, 100.0]", "0 to duration_s = 60.0"),
    (WINDOW[0], "window_s = [50.0, 40.0]", f"{WINDOW[1]} = [50.0, 40.0]", "first < last"),
    (WINDOW[0], "window_s = [50.0]", f"{WINDOW[1]} = [50.0]", "[first, last]"),
    (WINDOW[0], "window_s = [50.0, 99.9995]", f"{WINDOW[1]} = [50.0, 99.9995]", "multiple of step_s"),
    (WINDOW[0], 'window_s = ["a", 100.0]', f'{WINDOW[1]} = ["a", 100.0]', "two times"),
    ("severity_limit = 0.8", "severity_limit = -1", "run.severity_limit = -1", "0 to 10"),
    ('start = "rest"', 'start = "spinning"', 'run.start = "spinning"', '"rest" or "rotating"'),
    ('start = "rest"', 'start = "rest"\nstop = 1', "run.stop = 1", "unknown key"),
    ("[run]", "[[run]]", "run = [", "a table [run]"),
    ("[[section]]", "[[joint]]", "joint = [", "unknown key"),
    ("elements = 40", "elements = 40\nmud_weight = 1.2", "section[2].mud_weight = 1.2", "unknown key"),
    ("elements = 40", "elements = 40\nelements = 40", "", "expected a TOML file: Cannot overwrite"),
    ('name = "paper"', "name = paper", "", "expected a TOML file: Invalid value"),
    ("length_m = 1400.0", "length_m = 1e99999999999999999999", "", "numbers a computer can hold"),
    ("length_m = 1400.0", "length_m = " + 5000 * "9", "", "expected a TOML file"),
    ("window_s = [50.0, 100.0]", "window_s = " + 3000 * "[", "", "nested too deeply"),
]


def claim(holds, text):
    count[bool(holds)] += 1
    if not holds:
        print("FAILED: " + text)


def generate(arguments, directory):
    return subprocess.run([sys.executable, os.path.join(ROOT, "gen"), *arguments], capture_output=True, text=True,
                          cwd=directory, check=False, timeout=PATIENCE)


def refused(label, path, directory, key, advice):
    """One line, exit 2, nothing written."""
    out = os.path.join(directory, "out")
    ran = generate([path, "--out", out], directory)
    line = ran.stderr.rstrip("\n")
    claim(ran.returncode == 2, f"{label}: exit 2, was {ran.returncode}")
    claim(ran.stdout == "" and ran.stderr.count("\n") == 1, f"{label}: exactly one line: {ran.stderr!r}")
    claim(line.startswith(f"kelly gen: {path}") and key in line and advice in line,
          f"{label}: {line!r} should name {key!r} and say {advice!r}")
    claim(not os.path.exists(out) or not os.listdir(out), f"{label}: nothing is written")
    return line


def bad_wells(directory):
    path = os.path.join(directory, "my.toml")
    for old, new, key, advice in EDITS:
        assert old in PAPER, old
        with open(path, "w", encoding="utf-8") as file:
            file.write(PAPER.replace(old, new, 1))
        line = refused(new[:40] or "no " + old, path, directory, key, advice)
        number = re.match(r"kelly gen: \S+?my\.toml:(\d+): ", line)
        if key and "(missing)" not in key and "elements = 40" != key[-13:]:
            text = PAPER.replace(old, new, 1).split("\n")
            word = re.split(r"[.\]]", key.split(" = ")[0])[-1]
            claim(number and word in text[int(number[1]) - 1], f"{key}: the line number leads to the key: {line[:90]}")


def longest_run():
    """As long as the host program takes it, and no longer."""
    with open(os.path.join(ROOT, "host", "host.h"), encoding="utf-8") as file:
        most = float(re.search(r"#define STEPS_MOST (\S+)", file.read())[1])
    claim(most == well_.STEPS_MOST, f"gen takes {well_.STEPS_MOST} steps, the host {most:.0f}")
    well = well_.parse(PAPER.replace("duration_s = 100.0", "duration_s = 4000000.0"))
    claim(well.ticks == most, f"the longest run has {well.ticks} steps")


def long_lines(directory):
    """A bad key below lines of many blanks, words or brackets is told at once."""
    path = os.path.join(directory, "long.toml")
    for what, line in {"blanks": 20000 * " ", "blanks in a comment": "#" + 20000 * " ", "brackets": "#" + 20000 * "[ ", "words": "#" + 20000 * "a ",
                       "quotes": "#" + 20000 * "'\""}.items():
        text = PAPER.replace("[damping]", f"[damping]\n{line}").replace("stiffness_s = ", "'stiffnes_s' = ")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        try:
            said = refused(f"a long line of {what}", path, directory, "damping.stiffnes_s", "did you mean stiffness_s?")
        except subprocess.TimeoutExpired:
            claim(False, f"a long line of {what}: no answer within {PATIENCE} s")
            continue
        number = 1 + [row.startswith("'stiffnes_s'") for row in text.split("\n")].index(True)
        claim(f":{number}: " in said, f"a long line of {what}: the key is on line {number}: {said}")


def bad_files(directory):
    refused("no such file", os.path.join(directory, "none.toml"), directory, "", "No such file")
    refused("a directory", directory, directory, "", "directory")
    path = os.path.join(directory, "latin.toml")
    with open(path, "wb") as file:
        file.write(PAPER.replace("drill pipe", "Gest\xe4nge").encode("latin-1"))
    refused("not UTF-8", path, directory, "", "UTF-8")
    odd = {"": "letters", "\0\1\2": "TOML", "#" + PAPER.replace("\n", ""): "letters"}
    for text, advice in odd.items():
        path = os.path.join(directory, "odd.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        refused(f"odd file {text[:3]!r}", path, directory, "", advice)
    few = PAPER.replace("elements = 80", "elements = 3").replace("elements = 40", "elements = 4")
    path = os.path.join(directory, "few.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(few)
    refused("more modes than freedom", path, directory, "modes.torsional = 10", "7 torsional degrees of freedom")
    thin = re.sub(r"outer_diameter_mm = \S+", "outer_diameter_mm = 20.0", PAPER)
    with open(path, "w", encoding="utf-8") as file:
        file.write(re.sub(r"inner_diameter_mm = \S+", "inner_diameter_mm = 19.0", thin))
    refused("a string that 1000 kN buckles", path, directory, "", "")


def bad_command_lines(directory):
    good = os.path.join(ROOT, "gen", "wells", "paper.toml")
    for arguments in ([], [good, "more"], [good, "--frobnicate"], [good, "--as", "a/b"]):
        ran = generate(arguments, directory)
        claim(ran.returncode == 2 and ran.stderr.count("\n") == 1 and ran.stderr.startswith("kelly gen: "),
              f"gen {arguments}: one line, exit 2: {ran.stderr!r}")
    blocked = os.path.join(directory, "a_file")
    with open(blocked, "w", encoding="ascii"):
        pass
    ran = generate([good, "--out", blocked], directory)
    claim(ran.returncode == 1 and ran.stderr.count("\n") == 1 and blocked in ran.stderr,
          f"--out is a file: {ran.stderr!r}")
    out = os.path.join(directory, "half")
    os.makedirs(os.path.join(out, "paper_shapes.c"))            # the second file cannot take its name
    ran = generate([good, "--out", out], directory)
    claim(ran.returncode == 1 and os.listdir(out) == ["paper_shapes.c"], f"nothing half-written: {os.listdir(out)}")
    new = os.path.join(directory, "new", "dir")
    ran = generate([good, "--out", new, "--as", "mine"], directory)
    claim(ran.returncode == 0 and sorted(os.listdir(new)) == ["mine.c", "mine_shapes.c"],
          "--as names the files")


def marked(directory):
    """A byte order mark, as some editors write: the same table."""
    tables = []
    for text in (PAPER, "\ufeff" + PAPER):
        path = os.path.join(directory, "marked.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        ran = generate([path, "--out", directory], directory)
        with open(os.path.join(directory, "paper.c"), encoding="ascii") as file:
            tables.append((ran.returncode, file.read()))
    claim(tables[0] == tables[1] and tables[0][0] == 0, "a byte order mark changes nothing")


def lift_off(directory):
    """A weight that changes its sign at the means is built, and told in one line; one that only just does not is no news."""
    path = os.path.join(directory, "lift.toml")
    for old, new, told in (("wob_amplitude_kN = 50.0", "wob_amplitude_kN = 99.1", True), ("wob_amplitude_kN = 50.0", "wob_amplitude_klbf = 30", True),
                           ("wob_amplitude_kN = 50.0", "wob_amplitude_kN = 99.0", False)):
        assert old in PAPER
        with open(path, "w", encoding="utf-8") as file:
            file.write(PAPER.replace(old, new, 1).replace("step_s = 0.001", "step_s = 0.0005"))
        ran = generate([path, "--out", directory], directory)
        line = 1 + [row.startswith("wob_amplitude") for row in PAPER.split("\n")].index(True)
        claim(ran.returncode == 0 and os.path.exists(os.path.join(directory, "paper.c")), f"{new}: built all the same: {ran.stderr!r}")
        claim(ran.stderr.count("\n") == told and ran.stderr.startswith(f"kelly gen: {path}:{line}: case.{new}: warning: at the means the weight changes its sign"[:999 * told]),
              f"{new}: told: {ran.stderr!r}")


def mutations(number=4000):
    """Whatever happens to the text, parse() accepts it or raises WellError with a one-line message."""
    rng = random.Random(1)
    bits = ["=", "[", "]", "\"", "nan", "-", "1e999", "{", "}", "\n", ".", "0", "true", "'", "#", "\0", "inf", "é", ",",
            "[[section]]"]
    for _ in range(number):
        text = PAPER
        for _ in range(rng.randint(1, 3)):
            at = rng.randrange(len(text))
            text = text[:at] + rng.choice(bits + [text[rng.randrange(len(text)):][:30]]) + text[at + rng.randint(0, 6):]
        try:
            well_.parse(text)
        except well_.WellError as error:
            line = well_.message(error, "f.toml", text)
            if "\n" in line or not line.startswith("kelly gen: f.toml") or not line.isprintable():
                claim(False, f"one printable line: {line!r}")
        except Exception as error:      # the claim is that nothing else ever comes
            claim(False, f"{type(error).__name__}: {error} from {text!r}"[:300])
    claim(True, "mutations")


def main():
    with tempfile.TemporaryDirectory() as directory:
        bad_wells(directory)
    longest_run()
    with tempfile.TemporaryDirectory() as directory:
        long_lines(directory)
    with tempfile.TemporaryDirectory() as directory:
        bad_files(directory)
    with tempfile.TemporaryDirectory() as directory:
        bad_command_lines(directory)
    with tempfile.TemporaryDirectory() as directory:
        lift_off(directory)
        marked(directory)
    mutations()
    print(f"{count[True]} passed, {count[False]} failed")
    return 1 if count[False] else 0


if __name__ == "__main__":
    sys.exit(main())
