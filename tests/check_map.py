#!/usr/bin/env python3
"""check_map - the driller's map, its journal, and advise.

usage: tests/check_map.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. NAME picks single checks.
"""
import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.stats import beta

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from map_journal import check_disk_full, check_foreign, check_killed, check_lock, check_torn  # noqa: E402
from map_tools import PROGRAM, SHORT, claim, count, done, kelly, map_json, montecarlo, read, refused  # noqa: E402
from programs import ROOT, chosen, command_line  # noqa: E402

STARTS = ("rest", "rotating")
SMALL = f"--rpm 60:120:30 --wob 40:140:50 --samples 50 {SHORT}"


# ---- cells

def same_cell(cell, mc, what):
    """A cell of the JSON of a map and a montecarlo run: the same realisations, the same numbers."""
    want = {"probability": mc["probability"], "lo95": mc["ci95"][0], "hi95": mc["ci95"][1], "samples": mc["samples"], "stuck": mc["stuck"],
            "refused_step": mc["refused_by"]["step"], "refused_range": mc["refused_by"]["range"],
            "refused_nonfinite": mc["refused_by"]["nonfinite"], "liftoff": mc["liftoff"], "digest": mc["digest"]}
    claim(cell == want, f"{what}: {cell} is not montecarlo's {want}")


def cells(data):
    """(start, row, column, cell) of every cell."""
    for start in STARTS:
        for j in range(len(data["wob_kN"])):
            for i in range(len(data["rpm"])):
                yield start, j, i, {name: rows[j][i] for name, rows in data[start].items()}


def cells_are_montecarlo(args, case, real="float"):
    data = map_json(f"{args} {case}", real)
    seen = set()
    for start, j, i, cell in cells(data):
        setting = f"--rpm {data['rpm'][i]!r} --wob {data['wob_kN'][j]!r} --f0 {data['f0_kN'][j]!r} --start {start}"
        same_cell(cell, montecarlo(f"{setting} --samples {cell['samples']} {case}", real), f"{real} {args} {case} {setting}")
        seen.add(cell["digest"])
    claim(len(seen) == 2 * len(data["rpm"]) * len(data["wob_kN"]), f"{args} {case}: two cells have one digest")
    return data


def check_cells():
    data = cells_are_montecarlo("--rpm 60:120:30 --wob 40:140:50 --samples 50", SHORT)
    claim(data["f0_kN"] == [20, 45, 70], f"f0 keeps its ratio to the weight: {data['f0_kN']}")
    claim(data["rest"]["probability"] != data["rotating"]["probability"], "both starts give one map")
    data = cells_are_montecarlo("--rpm 40.3:40.6:0.1 --wob 33.3 --samples 33", f"{SHORT} --seed 7 --first 1000 --f0 12.345 --cov fc=0.3,rpm=0.1")
    claim(data["rpm"] == [40.3, 40.4, 40.5, 40.6] and data["f0_kN"] == [12.345], f"settings as one types them: {data['rpm']}, {data['f0_kN']}")
    refusing = cells_are_montecarlo("--rpm 80:120:40 --wob 200:400:100 --samples 40", "--duration 1 --window 0:1 --mu 0.04")
    claim(0 < np.sum(refusing["rest"]["refused_step"]) + np.sum(refusing["rest"]["refused_range"]) < 240, "refused realisations are counted")
    shown = done("map --rpm 80:120:40 --wob 200:400:100 --samples 40 --duration 1 --window 0:1 --mu 0.04").splitlines()[-1]
    by = [int(np.sum([refusing[start][f"refused_{why}"] for start in ("rest", "rotating")])) for why in ("step", "range", "nonfinite")]
    claim(f"refused {sum(by)} in " in shown and shown.endswith(f"(step {by[0]}, range {by[1]}, nonfinite {by[2]})"), f"and shown by their reasons: {shown!r}, {by}")
    cells_are_montecarlo("--rpm 90 --wob 90 --samples 20000", "--duration 0.1 --window 0:0.1 --cov 0.2")
    cells_are_montecarlo("--rpm 60.1:60.5:0.1 --wob 40.1:40.4:0.1 --samples 17", SHORT, "double")   # 60.1 + 2 0.1 is not 60.3


def check_same_bytes():
    """Threads, engine and screen leave no trace in a file."""
    want = done(f"map {SMALL} --json -")
    for more in ("--threads 1", "--threads 3", "--threads 8", "--engine scalar", "--engine sse2 --threads 2", "--quiet"):
        claim(done(f"map {SMALL} --json - {more}") == want, f"map {more}: other bytes")
    claim(done(f"map {SMALL} --json - --seed 2") != want, "another seed gives the same map")


def interval(k, n, tail):
    return (beta.ppf(tail, k, n - k + 1) if k else 0.0), (beta.ppf(1 - tail, k + 1, n - k) if k < n else 1.0)


def finished(k, n, width):
    lo, hi = interval(k, n, 0.025)
    low, high = interval(k, n, 0.025 / 48)
    return hi - lo < width or low > 0.5 or high < 0.5


def looks(most):
    n = 32
    while n < most:
        yield n
        n = (n + n // 2 + 31) // 32 * 32
    yield most


def check_adaptive():
    args = f"--rpm 60:140:20 --wob 40:140:50 {SHORT}"
    data = map_json(f"{args} --adaptive 0.15")
    runs = {cell["samples"] for *_, cell in cells(data)}
    claim(data["adaptive_width"] == 0.15 and len(runs) > 2, f"adaptive: n differs from cell to cell: {runs}")
    for start, j, i, cell in cells(data):
        setting = f"--rpm {data['rpm'][i]!r} --wob {data['wob_kN'][j]!r} --f0 {data['f0_kN'][j]!r} --start {start} {SHORT}"
        same_cell(cell, montecarlo(f"{setting} --samples {cell['samples']}"), f"adaptive {setting}")
        rows = list(csv.DictReader(io.StringIO(done(f"montecarlo {setting} --samples {cell['samples']} --csv -"))))
        stuck = np.cumsum([int(row["stuck"]) for row in rows])
        first = next(n for n in looks(data["samples"]) if n == data["samples"] or finished(int(stuck[n - 1]), n, 0.15))
        claim(cell["samples"] == first, f"adaptive {setting}: stops at {cell['samples']}, not at the first look that decides, {first}")
        claim(cell["hi95"] - cell["lo95"] < 0.15 or finished(cell["stuck"], cell["samples"], 0), f"adaptive {setting}: neither narrow nor decided")
    capped = map_json(f"{args} --adaptive 0.02 --samples 100")
    claim(max(cell["samples"] for *_, cell in cells(capped)) == 100, "adaptive: --samples is the most of a cell")
    narrow = map_json(f"{args} --adaptive 0.3 --samples 4000")
    for start, j, i, cell in cells(narrow):
        claim(cell["samples"] < 200, f"adaptive: an interval narrower than 0.3 ends a cell at P = 0.5 too: {start} {j} {i}: {cell}")
    claim(any(not finished(cell["stuck"], cell["samples"], 0) for *_, cell in cells(narrow)), "the test has a cell that only its width ends")
    refused("map --adaptive 0", "0.002..1")
    refused("map --adaptive 2", "0.002..1")
    refused("map --adaptive x", "0.002..1")


# ---- onset and release

def check_edges():
    case = "--mu 0.004 --duration 30 --window 15:30"
    data = map_json(f"--rpm 40:130:15 --wob 25:205:45 --samples 1 {case}")
    kinds = set()
    for name, start in (("release", "rest"), ("onset", "rotating")):
        for j, wob in enumerate(data["wob_kN"]):
            def sticks(rpm):
                return montecarlo(f"--cov 0 --samples 1 {case} --rpm {rpm!r} --wob {wob!r} --f0 {data['f0_kN'][j]!r} --start {start}")["stuck"] == 1
            edge, kind, holes = data[f"{name}_rpm"][j], data[name][j], data[f"{name}_free_below"][j]
            kinds.add(kind)
            scan = [sticks(rpm) for rpm in data["scan_rpm"]]
            highest = max((k for k, s in enumerate(scan) if s), default=-1)
            claim(holes == sum(not s for s in scan[:max(highest, 0)]), f"{name} at {wob} kN: {holes} free speeds below, the scan says {scan}")
            if kind == "found":
                claim(data["scan_rpm"][highest] < edge <= data["scan_rpm"][highest + 1], f"{name} at {wob} kN: {edge} is not above the highest that sticks")
                claim(not sticks(edge) and sticks(round(edge - 0.1, 6)), f"{name} at {wob} kN: {edge} rpm is not free with sticking 0.1 below")
            else:
                claim(edge is None and kind == ("above" if highest == len(scan) - 1 else "below" if highest < 0 else "?"), f"{name} at {wob} kN: {kind}, {edge}, {scan}")
    claim(kinds == {"found", "above", "below"}, f"the test sees every kind of edge: {kinds}")
    step = map_json("--rpm 60:120:30 --wob 600 --samples 20 --mu 0.04 --cov 0.4 --duration 1 --window 0:1")
    claim(step["release"] == ["refused"] and step["onset_rpm"] == [None], f"an edge that cannot be computed: {step['release']}")
    fine = map_json("--rpm 40:140:0.5 --wob 60 --samples 1 --duration 1 --window 0:1")
    claim(len(fine["scan_rpm"]) == 41 and fine["scan_rpm"][0] == 40 and fine["scan_rpm"][-1] == 140, "a fine grid is scanned at 41 speeds")


# ---- grids and files

def check_grids():
    one = map_json(f"--rpm 100 --wob 100 --samples 20 {SHORT}")
    claim(one["rpm"] == [100] and one["wob_kN"] == [100] and np.shape(one["rest"]["stuck"]) == (1, 1), "one cell")
    claim(map_json(f"--rpm 100:100:5 --wob 100:104:5 --samples 20 {SHORT}") == one, "FROM:FROM:STEP is one cell")
    data = map_json("--rpm 40:143:5 --wob 25:225:10 --samples 1 --duration 0.1 --window 0:0.1")
    claim(data["rpm"] == list(range(40, 141, 5)) and data["wob_kN"] == list(range(25, 226, 10)), "TO belongs to the grid where it lies on it")
    for grid, want in (("0.1:1:0.1", [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1]), ("40:40.3:0.1", [40, 40.1, 40.2, 40.3])):
        got = map_json(f"--rpm {grid} --wob 100 --samples 1 --duration 0.01 --window 0:0.01")["rpm"]
        claim(got == want, f"--rpm {grid}: decimal numbers, TO included: {got}")
    default = map_json("--samples 1 --duration 0.01 --window 0:0.01")
    claim((default["rpm"], default["wob_kN"]) == (data["rpm"], data["wob_kN"]), "the default grid is 40:140:5 x 25:225:10")
    for grid, word in (("140:40:5", "40:140:5"), ("40:140:0", "step"), ("40:140:-5", "step"), ("40:140", "no step"), ("40:140:5:5", "parts"),
                       (":140:5", "finite"), ("40::5", "finite"), ("40:140:", "finite"), ("0:100:10", "range"), ("-5:100:10", "range"),
                       ("nan:100:10", "finite"), ("40:inf:10", "finite"), ("a", "finite"), ("40:140:1e-9", "step"), ("40:140:nan", "finite"),
                       ("1:9999:0.001", "at most 1000000"), ("4" * 200, "too long"), ("40,140,5", "finite")):
        refused(f"map --rpm {grid}", word)
        refused(f"map --wob {grid}", word)
    refused("map --rpm 40:140:0.1 --wob 25:224.8:0.2", "1001000 cells; at most 1000000")
    refused("map --rpm ''", "value")
    refused("map --rpm", "value")
    refused("map --wob=", "value")


def check_files(folder):
    stem = os.path.join(folder, "files")
    args = "--rpm 60:120:30 --wob 100:1600:500 --samples 30 --mu 0.08 --duration 4 --window 2:4"
    claim(done(f"map {args} --csv {stem}.csv --json {stem}.json --npy {stem}.npy --quiet") == "", "--quiet prints nothing")
    claim(sorted(os.listdir(folder)) == ["files.csv", "files.json", "files.npy"], f"nothing else is left: {os.listdir(folder)}")
    with open(f"{stem}.json", encoding="utf-8") as file:
        data = json.load(file)
    rows = list(csv.DictReader(io.StringIO(read(f"{stem}.csv").decode())))
    p = np.load(f"{stem}.npy")
    claim(p.shape == (2, 4, 3) and p.dtype == np.float64, f"NPY: {p.shape}, {p.dtype}")
    claim([(float(r["wob_kN"]), float(r["rpm"])) for r in rows] == [(w, r) for w in data["wob_kN"] for r in data["rpm"]], "CSV: a line a cell, in order")
    claim(np.isnan(p).any() and not np.isnan(p).all(), "the test has cells without and with a result")
    for start, j, i, cell in cells(data):
        row = rows[j * 3 + i]
        value = p[STARTS.index(start), j, i]
        claim((np.isnan(value) and cell["probability"] is None and row[f"{start}_p"] == "") or
              (value == cell["probability"] and abs(float(row[f"{start}_p"]) - value) < 1e-11), f"P of {start} {j} {i}: {value}, {cell}, {row}")
        for name in ("samples", "stuck", "refused_step", "refused_range", "refused_nonfinite", "liftoff"):
            claim(int(row[f"{start}_{name}"]) == cell[name], f"{name} of {start} {j} {i}")
        for name in ("lo95", "hi95"):
            claim(abs(float(row[f"{start}_{name}"]) - cell[name]) < 1e-11, f"{name} of {start} {j} {i}")
        for name in ("release", "onset"):
            edge = data[f"{name}_rpm"][j]
            claim(row[f"{name}_rpm"] == ("" if edge is None else f"{edge:.12g}"), f"{name} of row {j}")
    claim(done(f"map {args} --csv -") == read(f"{stem}.csv").decode(), "--csv - is the file")
    screen = done(f"map {args}")
    claim("already rotating" in screen and "release" in screen and " refused " in screen, "the screen shows both starts, the edges, what was refused")
    said = kelly(f"map {args} --json - --progress json")
    last = [json.loads(line) for line in said.stderr.splitlines()][-1]
    claim(said.stdout == read(f"{stem}.json").decode() and last["done"] == last["total"] == 48, f"--progress json: {last}")


def check_no_answer():
    """A map without one P says what would help, of a cell where something would."""
    for args, words in (("--wob 100 --step 1e-6 --duration 0.001", "the step is too short for this precision"), ("--wob 100 --step 0.02 --duration 1", "the step is too long for 5 of 5"),
                        ("--wob 1500:2000:500 --duration 1", "fitted for weights of 1..1000 kN"), ("--wob 0.5:100.5:100 --step 0.02 --duration 1", "the step is too long for 5 of 5")):
        refused(f"map --rpm 60 --cov 0 --samples 5 --quiet {args}", f"kelly: map: no answer: no realisation of any cell can be trusted: {words if 'step' in words else 'the table is ' + words}", status=1)


def check_mistakes(folder):
    for args, word in (("--start rest", "both starts"), ("--convergence", "--convergence"), ("--samples 0", "realisations"), ("--nonsense 1", "unknown"),
                       ("--resume=1", "no value"), ("--adaptive", "value"), ("--npy", "value"), ("--rpm 100 --wob 100 --window 5:3", "ends before"),
                       ("--first 4294967295", "indices"), ("--adaptive 0.01 --first 4294960000", "indices"), ("extra", "not an option"),
                       ("--resume", "no journal"), ("--resume --json -", "no journal"), ("--resume --csv /dev/null", "no journal")):
        refused(f"map {args}", word)
    for option in ("csv", "json", "npy"):
        refused(f"map {SMALL} --{option} {folder}/none/x.{option}", "cannot write here", status=1)
    full = kelly(f"map {SMALL} --csv /dev/full")
    claim(full.returncode == 1 and full.stderr.count("\n") == 1, f"a full device: exit {full.returncode}")
    for args, word in (("--below 0", "probability"), ("--below 2", "probability"), ("--below", "value"), ("--search-rpm 5", "range"),
                       ("--search-rpm 101:120", "leaves out"), ("--search-wob 10:20", "leaves out"), ("--search-wob a:b", "finite"), ("--csv x", "--csv"),
                       ("--rpm 60:120:30", "finite"), ("--convergence", "--convergence"), ("--nonsense 1", "unknown")):
        refused(f"advise {args}", word)
    claim(os.listdir(folder) == [], f"mistakes leave nothing behind: {os.listdir(folder)}")


# ---- advise

def advise(args):
    return json.loads(done(f"advise {args} --json -"))


def nearest(start_at, below, rpm, case, search=""):
    """Advice at this setting: every number is montecarlo's, it is under the limit, and a tenth less or the other way will not do."""
    a = advise(f"--rpm {rpm!r} --wob {100 if rpm == 100 else 60} --start {start_at} --below {below} {case} {search}")
    for name in ("now", "by_rpm", "by_wob"):
        s, what = a[name], f"advise {start_at} at {rpm} rpm, {name}"
        now = (a["now"]["rpm"], a["now"]["wob_kN"])

        def at(speed, weight):
            return montecarlo(f"--rpm {speed!r} --wob {weight!r} --f0 {round(weight / 2, 9)!r} --start {start_at} {case}")
        mc = at(s["rpm"], s["wob_kN"])
        claim(all(mc[key] == s[key] for key in ("probability", "ci95", "samples", "stuck", "refused", "digest")), f"{what}: {s}, {mc}")
        claim((s["probability"] < below) == (name != "now"), f"{what}: {s['probability']} against {below}")
        claim(abs(s["f0_kN"] - s["wob_kN"] / 2) < 1e-9, f"{what}: f0 keeps its ratio")
        if name == "now":
            continue
        k = 0 if name == "by_rpm" else 1
        change = (s["rpm"], s["wob_kN"])[k] - now[k]
        claim(change != 0 and (s["rpm"], s["wob_kN"])[1 - k] == now[1 - k], f"{what} changes one of the two: {s}")
        for other in (change - 0.1 if change > 0 else change + 0.1, -change):
            value = round(now[k] + other, 6)
            p = at(value, now[1]) if k == 0 else at(now[0], value)
            claim(p["probability"] >= below, f"{what}: {value} would do as well as {s}")
    return a


def check_advise():
    case = "--mu 0.004 --samples 64 --duration 30 --window 15:30"
    nearest("rotating", 0.05, 100, case)
    nearest("rest", 0.2, 100, case)
    ways = {np.sign(nearest("rest", 0.9, rpm, case, "--search-rpm 32:46")["by_rpm"]["rpm"] - rpm) for rpm in (38.8, 38.9)}
    claim(ways == {-1, 1}, f"between two ways out the nearer one is taken: {ways}")
    none = advise(f"--rpm 100 --wob 100 --start rest --below 0.05 --search-rpm 95:105 --search-wob 90:100 {case}")
    claim(none["by_rpm"] is None and none["by_wob"] is None and none["searched_rpm"] == [95, 105], f"none within the range: {none}")
    screen = done(f"advise --search-rpm 95:105 --search-wob 90:100 --start rest {case}")
    claim("none in 95..105 rpm" in screen and "none in 90..100 kN" in screen, f"none within the range, on the screen: {screen}")
    already = advise(f"--rpm 140 --wob 30 {case}")
    claim(already["below_already"] and already["by_rpm"] is None, f"nothing to change: {already}")
    claim("nothing to change" in done(f"advise --rpm 140 --wob 30 {case}"), "nothing to change, on the screen")
    fixed = advise(f"--rpm 100 --wob 100 --f0 10 --start rotating {case}")
    claim(fixed["by_wob"]["f0_kN"] == 10 and fixed["now"]["f0_kN"] == 10, "--f0 stays")
    for args, words in (("--step 0.1 --out-step 0.1", "the step is too long for 5 of 5"), ("--wob 1500 --cov 0 --search-wob 1400:1600", "fitted for weights of 1..1000 kN")):
        nothing = kelly(f"advise {args} --samples 5 --duration 2")
        claim(nothing.returncode == 1 and nothing.stderr.count("\n") == 1 and "kelly: advise: no answer: " in nothing.stderr and words in nothing.stderr,
              f"advise {args}, all refused: exit {nothing.returncode}, {nothing.stderr!r}")
        claim(nothing.stdout.count("no realisation there can be trusted") == 2 and "lowest P" not in nothing.stdout, f"advise {args}, all refused: {nothing.stdout!r}")
    part = kelly("advise --rpm 100 --wob 1500 --mu 0.001 --cov 0 --search-wob 900:1600 --samples 5 --duration 2 --below 1e-9 --limit 0")
    claim(part.returncode == 0 and not part.stderr and re.search("^speed .*no realisation there can be trusted$", part.stdout, re.M) and
          re.search("^weight .*the lowest P found is 1.0000$", part.stdout, re.M), f"settings with nothing beside settings with a P: {part.stdout!r} {part.stderr!r}")
    unsafe = advise("--rpm 100 --wob 600 --mu 0.04 --samples 40 --duration 1 --window 0:1 --limit 9.9 --below 0.5")
    claim(unsafe["now"]["refused"] > 20 and not unsafe["below_already"], f"refused realisations count as stuck: {unsafe['now']}")


# ---- the picture

def check_picture(folder):
    stem = os.path.join(folder, "map")
    done(f"map --rpm 40:140:20 --wob 25:225:40 --samples 32 --mu 0.004 --duration 10 --window 5:10 --json {stem}.json --quiet")
    drawn = subprocess.run([sys.executable, f"{ROOT}/host/draw_map.py", f"{stem}.json", stem], capture_output=True, text=True, check=False)
    claim(drawn.returncode == 0 and drawn.stderr == "", f"draw_map: {drawn.stderr.strip()[-300:]!r}")
    claim(read(stem + ".png")[:4] == b"\x89PNG" and len(read(stem + ".png")) > 50000, "a PNG")
    svg = read(stem + ".svg").decode()
    claim("<svg" in svg and str(folder) not in svg, "an SVG")
    done(f"map --rpm 100 --wob 100 --samples 4 {SHORT} --json {stem}.json --quiet")
    drawn = subprocess.run([sys.executable, f"{ROOT}/host/draw_map.py", f"{stem}.json", stem], capture_output=True, text=True, check=False)
    claim(drawn.returncode == 1 and "at least 2 x 2" in drawn.stderr and drawn.stderr.count("\n") == 1, f"one cell has no contours: {drawn.stderr!r}")


def million(folder):
    """The largest grid there is, beside everything else: two million cells of one realisation of one step."""
    return subprocess.Popen([PROGRAM["float"], *"map --rpm 40:139.9:0.1 --wob 25:224.8:0.2 --mu 0.004 --samples 1 --duration 0.001 --window 0:0.001".split(),
                             "--npy", f"{folder}/million.npy", "--quiet", "--threads", "1"], stderr=subprocess.PIPE)


def check_million(process, folder):
    _, said = process.communicate(timeout=280)
    claim(process.returncode == 0 and said == b"", f"a million cells: exit {process.returncode}, {said!r}")
    p = np.load(f"{folder}/million.npy")
    claim(p.shape == (2, 1000, 1000) and np.isin(p, (0.0, 1.0)).all(), f"a million cells: {p.shape}")


CHECKS = [check_cells, check_same_bytes, check_adaptive, check_edges, check_grids, check_files, check_no_answer, check_mistakes, check_torn, check_foreign, check_lock,
          check_killed, check_disk_full, check_advise, check_picture]


def main():
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    args = chosen(parser)
    picked = [c for c in CHECKS if not args.names or c.__name__ in args.names or c.__name__[6:] in args.names]
    big = tempfile.mkdtemp()
    process = None if args.names else million(big)
    try:
        for check in picked:
            folder = tempfile.mkdtemp()
            began = time.monotonic()
            before = count[False]
            try:
                check(*([folder] if check.__code__.co_argcount else []))
            except (OSError, ValueError, KeyError, StopIteration, subprocess.TimeoutExpired) as error:
                claim(False, f"{check.__name__}: {type(error).__name__}: {error}")
            print(f"{check.__name__[6:]:12s} {time.monotonic() - began:5.1f} s{'' if count[False] == before else '  FAILED'}", flush=True)
            shutil.rmtree(folder)
        if process:
            check_million(process, big)
    finally:
        shutil.rmtree(big)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
