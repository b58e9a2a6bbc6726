#!/usr/bin/env python3
"""Claims about using kelly: help, installing, completion, progress and quiet, strings of one's own, the field along the string.

usage: tests/check_use.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...|long_run]

Run with an interpreter that has numpy. Prints one line for each claim that fails, then `N passed, N failed`.
"""
import glob
import json
import math
import os
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time
from fractions import Fraction

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "gen"))

import numpy as np          # noqa: E402

import bars                 # noqa: E402
from programs import PROGRAM, chosen, command_line  # noqa: E402
import reduce               # noqa: E402
import reference            # noqa: E402
import well as well_        # noqa: E402

WELLS = sorted(glob.glob(os.path.join(ROOT, "gen", "wells", "*.toml")))
QUICK = ["--samples", "8", "--duration", "4"]
LONG = ["montecarlo", "--samples", "64", "--threads", "1", "--engine", "scalar"]   # a second or more on any machine
count = {True: 0, False: 0}


def claim(holds, text):
    count[bool(holds)] += 1
    if not holds:
        print("FAILED: " + text)


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL, **options)


def kelly(*arguments, **options):
    return run(PROGRAM["float"], *arguments, **options)


def on_terminal(*arguments, **environment):
    """Everything that kelly writes to a terminal, stdout and stderr."""
    master, slave = pty.openpty()
    plain = {k: v for k, v in os.environ.items() if k != "NO_COLOR"}
    process = subprocess.Popen([PROGRAM["float"], *arguments], stdin=subprocess.DEVNULL, stdout=slave, stderr=slave,
                               env={**plain, "TERM": "xterm", **environment})
    os.close(slave)
    text, end = b"", time.monotonic() + 60
    while time.monotonic() < end:
        if select.select([master], [], [], 0.1)[0]:
            try:
                piece = os.read(master, 65536)
            except OSError:              # the other end has closed
                break
            text += piece
    os.close(master)
    claim(process.wait() == 0, f"{arguments} on a terminal ends with 0")
    return text.decode()


# ---- help

def commands():
    return re.findall(r"^  kelly (\S+)  ", kelly("--help").stdout, re.M)


def options_of(text):
    return re.findall(r"^  (--[a-z0-9-]+)", text, re.M)


def check_help():
    alone = kelly()
    claim(alone.returncode == 2 and not alone.stdout, "kelly alone: exit 2, nothing on stdout")
    first = re.search(r"Try first:\s+kelly (.*)", alone.stderr)
    claim(first and kelly(*first[1].split(), *QUICK).returncode == 0, "kelly alone says what to try first, and that works")
    claim({"montecarlo", "simulate", "modes", "manual"} <= set(commands()), f"commands: {commands()}")
    claim(kelly("help").stdout == kelly("--help").stdout, "kelly help = kelly --help")
    status = re.search(r"^Exit status: 0 (.*?), 1 (.*?),\s2 (.*?\))\.", kelly("help").stdout, re.M | re.S)
    page, readme = kelly("manual").stdout, open(os.path.join(ROOT, "README.md"), encoding="utf-8").read()
    claim(status and "".join(f".B {i}\n{words}\n" for i, words in enumerate(status.groups())).replace("\n.B", "\n.TP\n.B") in page, "exit statuses: the man page has help's words")
    claim(status and " ".join(status[0].split()) in " ".join(readme.split()), "exit statuses: the README has help's words")
    wrong = kelly("help", "nonsense")
    claim(wrong.returncode == 2 and wrong.stderr.count("\n") == 1 and "montecarlo" in wrong.stderr, "help of no command: exit 2")
    for command in commands():
        text = kelly(command, "--help")
        claim(text.returncode == 0 and not text.stderr, f"{command} --help ends with 0")
        claim(text.stdout == kelly("help", command).stdout, f"kelly help {command} is kelly {command} --help")
        claim(re.search(rf"^Example\n  kelly {command}", text.stdout, re.M), f"{command} --help has an example")
        claim(all(len(line) <= 132 and line == line.rstrip() for line in text.stdout.split("\n")), f"{command} --help: lines of 132 or less")
        told = options_of(text.stdout)
        claim(len(told) == len(set(told)), f"{command} --help names an option twice: {sorted(o for o in set(told) if told.count(o) > 1)}")
        claim("default" in text.stdout and ("--rpm" not in text.stdout or "[rpm]" in text.stdout), f"{command} --help: units and defaults")


def check_options_are_told():
    """The help of a command names an option exactly if its parser knows it."""
    sources = "".join(open(path, encoding="utf-8").read() for path in glob.glob(os.path.join(ROOT, "host", "*.c")))
    known = sorted({*re.findall(r'strcmp\(name, "(--[a-z0-9-]+)"\)', sources), *re.findall(r'{ "(--[a-z0-9-]+)",', sources)} - {"--help"})
    claim(len(known) > 25, f"options of the sources: {known}")
    for command in commands():
        told = set(options_of(kelly(command, "--help").stdout))
        for option in known:
            if option in told:           # an empty value is refused before anything runs
                answers = [kelly(command, option, "")]
            else:
                answers = [kelly(command, option, *value, cwd=tempfile.gettempdir()) for value in ((), ("/nowhere/x",))]
            refused = any(a.returncode == 2 and re.search("unknown option|does not belong", a.stderr) for a in answers)
            claim(answers[0].returncode == 2 or refused, f"{command} {option} without a value: exit 2")
            claim(refused != (option in told), f"{command} {'does not take' if refused else 'takes'} {option}, its help says otherwise")


def check_spelling():
    """A name that is nearly one is told which; one that is not, as ever."""
    for words, meant in (("montcarlo", "montecarlo"), ("help simualte", "simulate"), ("mop", "map"), ("whatif --form x", "--from"),
                         ("montecarlo --sampels 5", "--samples"), ("montecarlo --quite", "--quiet"), ("simulate --samples 4", "--sample"),
                         ("map --adaptiv 0.1", "--adaptive"), ("bench --prot x", "--port"), ("modes --jsn=x", "--json"), ("montecarlo --f1 3", "--f0"),
                         ("rare --mv", "--mu")):
        wrong = kelly(*words.split())
        claim(wrong.returncode == 2 and wrong.stderr.endswith(f"; did you mean {meant}?\n") and wrong.stderr.count("\n") == 1, f"{words}: {wrong.stderr!r}")
    for words in ("nonsense", "mo", "modes --rpm 100", "simulate --samplings 4", "modes --j x", "montecarlo --xx 1", "montecarlo --rpm"):
        wrong = kelly(*words.split())
        claim(wrong.returncode == 2 and "did you mean" not in wrong.stderr and wrong.stderr.count("\n") == 1, f"{words}: {wrong.stderr!r}")


def check_defaults():
    """Help prints the defaults that a run uses."""
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "run.json")
        kelly("montecarlo", "--samples", "1", "--quiet", "--json", path)
        case = json.load(open(path, encoding="utf-8"))["case"]
    text = kelly("montecarlo", "--help").stdout
    for key in ("rpm", "wob_kN", "f0_kN", "mu", "alpha1", "alpha2", "step_s", "duration_s", "limit", "torsional"):
        option = "--" + re.sub("_(kN|s)$", "", key)
        found = re.search(rf"^  {option} .*?\(default ([0-9.]+)\)", text, re.M)
        claim(found and abs(float(found[1]) - case[key]) < 1e-6 * case[key], f"default of {option} is {case[key]}")
    for command in ("map", "advise"):
        told = re.findall(r"^  --f0 .*(?:\n {29}.*)*", kelly(command, "--help").stdout, re.M)
        claim(len(told) == 1 and re.search(r"default:\s+its\s+ratio", told[0]), f"{command} --help, default of --f0: {told}")


def check_make_help():
    """make help has the goals that are described, also of a board, and the variables."""
    told = run("make", "-s", "help", cwd=ROOT).stdout
    goals = set(re.findall(r"^([a-z-]+) ", told, re.M))
    claim({"all", "run", "digest", "flash", "size", "test", "help"} <= goals, f"make help: goals {sorted(goals)}")
    missing = [name for name in ("REAL", "WELL", "TARGET", "SEED", "FIRST", "MAP", "V", "CC", "CFLAGS") if not re.search(rf"^(.*\W)?{name}\b", told[told.rfind("\n\n"):], re.M)]
    claim(not missing, f"make help: no variable {missing}")


# ---- installed

def check_install():
    with tempfile.TemporaryDirectory() as directory:
        done = run("make", "-s", "install", f"DESTDIR={directory}", "PREFIX=/opt/kelly", cwd=ROOT)
        claim(done.returncode == 0, f"make install: {done.stderr[-300:]}")
        there = {os.path.relpath(os.path.join(base, f), directory) for base, _, files in os.walk(directory) for f in files}
        wanted = {"opt/kelly/bin/kelly", "opt/kelly/share/man/man1/kelly.1", "opt/kelly/share/bash-completion/completions/kelly"}
        claim(there == wanted, f"what is installed: {there}")
        program = os.path.join(directory, "opt/kelly/bin/kelly")
        claim(run(program, "--version", cwd="/", env={}).stdout == kelly("--version").stdout, "the installed program runs anywhere")
        check_page(os.path.join(directory, "opt/kelly/share/man/man1/kelly.1"))
        check_completion_in(directory)


def check_page(path):
    """The man page renders without a warning, and says what --help says."""
    man, groff = shutil.which("man"), shutil.which("groff")
    command = [man, "--warnings", "-l", path] if man else [groff, "-man", "-ww", "-Tutf8", path] if groff else None
    if command:
        page = run(*command, env={**os.environ, "MANWIDTH": "100", "MANPAGER": "cat", "LC_ALL": "C"})
        claim(page.returncode == 0 and page.stderr == "", f"the man page renders without a warning: {page.stderr[:300]}")
        text = re.sub(r".\x08|\x1b\[[0-9;]*m", "", page.stdout)
    else:
        with open(path, encoding="utf-8") as file:
            text = file.read().replace("\\-", "-")
    for command in commands():
        claim(f"kelly {command}" in text, f"the man page has {command}")
        for option in options_of(kelly(command, "--help").stdout):
            claim(option in text, f"the man page has {option} of {command}")


def check_completion_in(directory):
    cases = {
        ("kelly", ""): ({"montecarlo", "simulate", "modes", "--help"}, True), ("kelly", "mon"): ({"montecarlo"}, False),
        ("kelly", "help", "sim"): ({"simulate"}, False), ("kelly", "simulate", "--fi"): ({"--field"}, False),
        ("kelly", "simulate", "--start", ""): ({"rest", "rotating"}, False), ("kelly", "simulate", "--start", "=", "ro"): ({"rotating"}, False),
        ("kelly", "montecarlo", "--rpm", ""): (set(), False), ("kelly", "modes", "--json", "opt"): ({"opt"}, False),
        ("kelly", "montecarlo", "--quiet", "--progress", "j"): ({"json"}, False), ("kelly", "nonsense", "--"): (set(), False),
        ("kelly", "modes", "--"): (set(options_of(kelly("modes", "--help").stdout)), False),
    }
    script = 'PATH="$1/opt/kelly/bin:$PATH"; cd "$1"; . "$1/opt/kelly/share/bash-completion/completions/kelly"; shift\n' \
             'complete -p kelly >&2; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _kelly; printf "%s\\n" "${COMPREPLY[@]}"'
    for words, (wanted, more) in cases.items():
        done = run("bash", "--norc", "-c", script, "bash", directory, *words)
        found = set(done.stdout.split())
        claim(done.returncode == 0 and done.stderr == "complete -F _kelly kelly\n", f"completion loads: {done.stderr!r}")
        claim(found >= wanted if more else found == wanted, f"completion of {words}: {found}, expected {wanted}")


# ---- on a terminal, in a pipe

def check_quiet():
    with tempfile.TemporaryDirectory() as directory:
        out = os.path.join(directory, "out")
        for command in (["montecarlo", *QUICK], ["montecarlo", *QUICK, "--json", out], ["simulate", "--duration", "1", "--out", out], ["modes"]):
            loud, quiet = kelly(*command), kelly(*command, "--quiet")
            claim(loud.stdout, f"{command} says something")
            claim(quiet.returncode == 0 and quiet.stdout == "" and quiet.stderr == "", f"{command} --quiet is silent")
    claim("left" in on_terminal(*LONG), "on a terminal there is progress")
    claim(on_terminal(*LONG, "--quiet") == "", "--quiet is silent on a terminal too")
    claim("left" not in on_terminal(*LONG, "--progress=none"), "--progress=none: no progress on a terminal")
    wrong = kelly("montecarlo", "--quiet", "--rpm", "x")
    claim(wrong.returncode == 2 and wrong.stderr.count("\n") == 1, "errors are told in spite of --quiet")


def check_progress():
    done = kelly(*LONG, "--progress=json")
    lines = [json.loads(line) for line in done.stderr.splitlines()]
    claim(len(lines) >= 2, f"--progress=json: {len(lines)} lines")
    sound = all(set(line) == {"done", "total", "per_s", "elapsed_s", "left_s"} for line in lines)
    claim(sound, "progress: the same keys in every line")
    lines = lines if sound else [dict.fromkeys(("done", "total", "elapsed_s", "left_s"), -1)]
    claim(all(line["total"] == 64 and 0 <= line["done"] <= 64 and line["left_s"] >= 0 for line in lines), "progress: within its bounds")
    claim(all(a["done"] <= b["done"] and a["elapsed_s"] <= b["elapsed_s"] for a, b in zip(lines, lines[1:])), "progress goes on")
    claim(lines and lines[-1]["done"] == 64, "progress ends with all of them")
    digest, silent = re.search(r"digest [0-9a-f]+", done.stdout), kelly("montecarlo", "--samples", "64")
    claim(silent.stderr == "" and digest and digest[0] in silent.stdout, "no progress in a pipe unless asked for; the result is the same")
    brief = kelly("montecarlo", "--samples", "240000", "--duration", "4", "--threads", "1", "--progress=json").stderr
    claim(brief.count("\n") >= 2, "progress is shown where no batch lasts as long as the time between two lines")


def check_colour():
    for command in (["montecarlo", *QUICK], ["montecarlo", "--help"]):
        claim("\x1b[" in on_terminal(*command), f"{command} on a terminal is coloured")
        claim("\x1b[" not in on_terminal(*command, NO_COLOR="1"), f"{command} with NO_COLOR is not")
        claim("\x1b[" in on_terminal(*command, NO_COLOR=""), f"{command} with an empty NO_COLOR is")
        claim("\x1b[" not in on_terminal(*command, TERM="dumb"), f"{command} on a dumb terminal is not")
        claim("\x1b" not in kelly(*command).stdout, f"{command} in a pipe is not")


# ---- both severities

def check_ssi():
    """P by SSI, from the CSV of the same run; both named; within 0.005 of each other."""
    with tempfile.TemporaryDirectory() as directory:
        table, report = os.path.join(directory, "t.csv"), os.path.join(directory, "r.json")
        done = kelly("montecarlo", "--mu", "0.004", "--samples", "2000", "--csv", table, "--json", report)
        rows = np.genfromtxt(table, delimiter=",", names=True, dtype=None, encoding="utf-8")
        result = json.load(open(report, encoding="utf-8"))
    ssi = (rows["bit_max_rpm"] - rows["bit_min_rpm"]) / (2 * rows["bit_mean_rpm"])
    stuck = int(np.sum(ssi > 0.8))
    claim(result["ssi"]["stuck"] == stuck and abs(result["ssi"]["probability"] - stuck / 2000) < 1e-12, f"SSI counts {stuck}: {result['ssi']}")
    claim(abs(result["ssi"]["probability"] - result["probability"]) <= 0.005, "P by SSI and by ss agree within 0.005")
    claim("min" in result["severity"] and "mean" in result["ssi"]["severity"], "JSON says which severity is which")
    claim(f"P = {stuck / 2000:.4f} ({stuck} of 2000)" in done.stdout and "SSI" in done.stdout and "ss =" in done.stdout, "the summary names both")
    with tempfile.TemporaryDirectory() as directory:
        table = os.path.join(directory, "t.csv")
        text = kelly("simulate", "--out", table).stdout
        rows = np.genfromtxt(table, delimiter=",", names=True)
    speed = rows["bit_speed_rpm"][rows["time_s"] >= 50]
    mean = float(re.search(r"mean (\S+) rpm, SSI = (\S+)", text)[1])
    claim(abs(mean - (speed[:-1] + speed[1:]).mean() / 2) < 0.02, "simulate: mean bit speed")
    claim(abs(float(re.search(r"SSI = (\S+)", text)[1]) - (speed.max() - speed.min()) / (2 * mean)) < 0.01, "simulate: SSI")


# ---- strings of one's own

UNITS = {"m": ("ft", Fraction("0.3048")), "mm": ("in", Fraction("25.4")), "kN": ("klbf", Fraction("0.45359237") * Fraction("9.80665")),
         "kg_m3": ("lbm_ft3", Fraction("0.45359237") / Fraction("0.3048")**3),
         "GPa": ("Mpsi", Fraction("0.45359237") * Fraction("9.80665") / Fraction("25.4")**2 * 1000)}


def converted(text, to_field):
    """A well file with every quantity in the other units."""
    for si, (field, ratio) in UNITS.items():
        old, new, factor = (si, field, 1 / ratio) if to_field else (field, si, ratio)
        text = re.sub(rf"^((?:\w+_)?(?:length|diameter|modulus|density|wob|amplitude))_{old}( *= *)([0-9.]+)",
                      lambda m: f"{m[1]}_{new}{m[2]}{float(Fraction(m[3]) * factor)!r}", text, flags=re.M)
    return text


def check_units():
    for name, to_field, key in (("paper", True, "inner_diameter_in"), ("slim-4000ft", False, "youngs_modulus_GPa")):
        text = open(os.path.join(ROOT, "gen", "wells", name + ".toml"), encoding="utf-8").read()
        other = converted(text, to_field)
        claim(key in other and other.count("\n") == text.count("\n"), f"{name} converted")
        one, two = (reduce.reduce(w, bars.build(w)) for w in map(well_.parse, (text, other)))
        for quantity in ("w2", "b", "d", "axial_w2", "axial_b"):
            a, b = (reduce.evaluate(r.fit[quantity], (np.array([2e3, 1e5, 9e5]) - r.fc_mid) * r.fc_scale) for r in (one, two))
            claim(np.max(np.abs(a - b)) <= 1e-12 * np.max(np.abs(a)), f"{name}: {quantity} is the same in the other units")
    for unit, (field, ratio) in UNITS.items():
        si = well_.SCALE[unit]
        multiplier, divisor = well_.SCALE[field]
        claim(Fraction(multiplier) / Fraction(divisor) == ratio * Fraction(si[0]) / Fraction(si[1]), f"1 {field} is exact")
    paper = open(os.path.join(ROOT, "gen", "wells", "paper.toml"), encoding="utf-8").read()
    bad = ((paper.replace("length_m = 1400.0", "length_m = 1400.0\nlength_ft = 4593.0"), "only one of length_m, length_ft"),
           (paper.replace("length_m = 1400.0", "length_ft = 0.1"), "0.328084 to 65616.8 ft"),
           (paper.replace("length_m = 1400.0", ""), "(or length_ft)"), (paper.replace("wob_kN = 100.0", "wob_klbf = 225.0"), "112.404 klbf"),
           (paper.replace("outer_diameter_mm = 120.0", "outer_diameter_in = 3.0"), "less than outer_diameter_in = 3.0"))
    for text, advice in bad:
        try:
            well_.parse(text)
            line = "accepted"
        except well_.WellError as error:
            line = well_.message(error, "f.toml", text)
        claim(advice in line, f"{line!r} should say {advice!r}")


def check_wells():
    """Every well of gen/wells: make WELL=..., its table, its first frequency, a run with nothing refused."""
    claim(len(WELLS) >= 4, f"wells: {WELLS}")
    for path in WELLS:
        name = os.path.basename(path)[:-5]
        with tempfile.TemporaryDirectory() as directory:
            own = os.path.join(directory, "host")
            shutil.copytree(os.path.join(ROOT, "build", "host"), own, ignore=shutil.ignore_patterns("tables", "kelly"), copy_function=shutil.copy2)
            done = run("make", "-s", f"WELL=gen/wells/{name}.toml", f"dir={own}", cwd=ROOT)
            claim(done.returncode == 0, f"make WELL={name}: {done.stderr[-300:]}")
            if done.returncode:
                continue
            result = run(os.path.join(own, "kelly"), "montecarlo", "--samples", "64", "--json", "-")
            shown = run(os.path.join(own, "kelly"), "modes", "--json", "-")
        if result.returncode or shown.returncode:
            claim(False, f"{name} runs: {result.stderr}{shown.stderr}")
            continue
        result, shown = json.loads(result.stdout), json.loads(shown.stdout)
        claim(result["refused"] == 0 and 0 < result["probability"] <= 1, f"{name}: P = {result['probability']}, refused {result['refused']}")
        claim(result["model"].startswith(name + "-"), f"{name}: the model is {result['model']}")
        well = well_.parse(open(path, encoding="utf-8").read())
        exact = math.sqrt(reference.modes(well, well.fc)["w2"][0]) / 2 / math.pi
        claim(abs(shown["torsion_prestressed_hz"][0] / exact - 1) < 1e-6, f"{name}: f_1 = {exact:.6f} Hz")
        table = os.path.join(ROOT, *(("firmware", "tables") if name == "paper" else ("build", "tables")), name + ".c")
        banner = open(table, encoding="utf-8").read(6000)
        claim("Certificate, proved" in banner and "probability that a realisation is refused" in banner, f"{name}: the table has its certificate")


def check_convergence():
    """The report of the generator: order two in the element length, nothing written."""
    text = open(os.path.join(ROOT, "tests", "wells", "short.toml"), encoding="utf-8").read()
    text = text.replace("duration_s = 40.0", "duration_s = 6.0").replace("window_s = [20.0, 40.0]", "window_s = [2.0, 6.0]")
    with tempfile.TemporaryDirectory() as directory:
        with open(os.path.join(directory, "short.toml"), "w", encoding="utf-8") as file:
            file.write(text.replace("elements = 6", "elements = 24"))
        done = run(sys.executable, os.path.join(ROOT, "gen"), "short.toml", "--convergence", "--out", "out", cwd=directory)
        claim(done.returncode == 0 and done.stderr == "", f"--convergence: {done.stderr[-300:]}")
        claim(os.listdir(directory) == ["short.toml"], "--convergence writes nothing")
    rows = {int(m[1]): float(m[2]) for m in re.finditer(r"^ +(\d+)   \d+\.\d{6}  +(\S+) .*differ", done.stdout, re.M)}
    claim(sorted(rows) == [12, 24, 48, 192], f"rows over the elements: {rows}")
    claim(len(rows) == 4 and 3.8 < rows[12] / rows[24] < 4.4, f"the error of f_1 falls with the square: {rows}")
    claim(re.search(r"^ +6 .* 0 differ   as in the well file$", done.stdout, re.M), "a row for the modes of the well file")


# ---- the field

def check_field():
    well = well_.parse(open(os.path.join(ROOT, "gen", "wells", "paper.toml"), encoding="utf-8").read())
    x = bars.build(well).x
    cases = ((["--mu", "0.004"], {"mu": 0.004}), (["--wob", "140", "--start", "rotating", "--axial", "5", "--torsional", "6"],
                                                  {"fc": 140e3, "rotating": 1, "axial": 5, "torsional": 6}))
    with tempfile.TemporaryDirectory() as directory:
        array, table = os.path.join(directory, "f.npy"), os.path.join(directory, "f.csv")
        for options, case in cases:
            want = reference.field(well, case, 0.001, 0.5, 20.0)
            for real, within in (("float", 3e-4), ("double", 1e-8)):
                arguments = ["simulate", *options, "--duration", "20", "--out-step", "0.5", "--quiet", "--out", os.devnull]
                for path in (array, table):
                    done = run(PROGRAM[real], *arguments, "--field", path)
                    claim(done.returncode == 0 and done.stdout == "", f"--field {path}: {done.stderr}")
                field = np.load(array, allow_pickle=False)
                claim(field.shape == (41, len(x)) and field.dtype.names == ("time_s", "x_m", "displacement_m", "twist_rad"), "NPY: [time, node]")
                claim(np.allclose(field["time_s"], 0.5 * np.arange(41)[:, None], atol=1e-9) and np.allclose(field["x_m"], x, rtol=1e-6), "time and x")
                for name, exact in zip(("displacement_m", "twist_rad"), want):
                    error = np.max(np.abs(field[name] - exact)) / np.max(np.abs(exact))
                    claim(error < within, f"{real} {options}: {name} is the reference's within {error:.1e}")
                claim(np.all(field["twist_rad"][:, 0] == 0), "the top does not twist against itself")
                lines = np.genfromtxt(table, delimiter=",", names=True)
                claim(all(np.allclose(lines[n], field[n].ravel(), rtol=1e-8, atol=1e-12) for n in field.dtype.names), "CSV and NPY hold the same")
        head = open(array, "rb").read(10)
        claim(head[:8] == b"\x93NUMPY\x01\x00" and (10 + head[8] + 256 * head[9]) % 64 == 0, "NPY 1.0, header of whole 64 bytes")
        for name in ("field.txt", "npy", ".npy", "-"):
            done = kelly("simulate", "--duration", "1", "--out", os.path.join(directory, "o.csv"), "--field", name, cwd=directory)
            claim(done.returncode == 2 and ".npy" in done.stderr and done.stderr.count("\n") == 1, f"--field {name}: exit 2")
        done = kelly("simulate", "--duration", "1", "--step", "0.05", "--out-step", "0.05", "--field", os.path.join(directory, "no.npy"))
        claim(done.returncode == 2 and not os.path.exists(os.path.join(directory, "no.npy")), "a refused run leaves no field")
        claim(sorted(os.listdir(directory)) == ["f.csv", "f.npy"], f"nothing half-written: {os.listdir(directory)}")
        check_examples(directory)


def check_examples(directory):
    """The examples of the help run as they stand, and what they write can be read."""
    for command in ("simulate", "modes", "montecarlo"):
        words = re.search(r"^Example\n  kelly (.*)", kelly(command, "--help").stdout, re.M)[1].split()
        claim(kelly(*words, cwd=directory).returncode == 0, f"example of {command}")
    rows = np.genfromtxt(os.path.join(directory, "runs.csv"), delimiter=",", names=True, dtype=None, encoding="utf-8")
    claim(len(rows) == json.load(open(os.path.join(directory, "run.json"), encoding="utf-8"))["samples"], "CSV and JSON of the example tell of the same run")


def check_long_run():
    """More than 2^31 steps from one line to the next, some minutes: by name only."""
    done = kelly(*"simulate --torsional 1 --axial 1 --duration 2147484 --out-step 2147483.7 --window 0:2147484".split())
    times = [line.split(",")[0] for line in done.stdout.splitlines()[1:]]
    claim(done.returncode == 0 and times == ["0", "2147483.7"], f"2147484000 steps: exit {done.returncode}, lines at {times[:5]}")


def main():
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    names = chosen(parser).names
    if names == ["long_run"]:
        check_long_run()
    for check in (check_help, check_options_are_told, check_spelling, check_defaults, check_make_help, check_install, check_quiet, check_progress, check_colour, check_ssi,
                  check_units, check_wells, check_convergence, check_field):
        name = check.__name__[6:]
        if not names or name in names:
            start = time.monotonic()
            check()
            print(f"{name:18s} {time.monotonic() - start:6.1f} s", flush=True)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
