#!/usr/bin/env python3
"""check_cli.py - the kelly command as a user meets it: numbers, files, options, mistakes.

usage: tests/check_cli.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. NAME picks single checks.
"""
import csv
import io
import json
import os
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.stats import beta

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bad_usage  # noqa: E402
from check_digests import engines as engines_of  # noqa: E402
from programs import PROGRAM, chosen, command_line  # noqa: E402
from second_opinion import RPM, String, crc32c, modes  # noqa: E402

count = {True: 0, False: 0}
SIMULATE_HEADER = "time_s,bit_speed_rpm,bit_torque_kNm,wob_kN,bit_axial_speed_m_s,surface_torque_kNm,top_speed_rpm"
MONTECARLO_HEADER = "index,fc_kN,mu,alpha1,alpha2,rpm,bit_min_rpm,bit_max_rpm,bit_mean_rpm,ss,stuck,status,liftoff"


def claim(holds, what):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return holds


def close(got, want, within, what):
    away = float(np.max(np.abs(np.asarray(got) - np.asarray(want))))
    claim(away <= within, f"{what}: off by {away:.3g}, allowed {within:.3g}")


# ---- running it

def kelly(real, args, **more):
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=300, **more)


def done(real, args):
    """Output of a run that must succeed and say nothing on stderr."""
    result = kelly(real, args)
    claim(result.returncode == 0 and result.stderr == "", f"{real} {args}: exit {result.returncode}, {result.stderr.strip()!r}")
    return result.stdout


def table(text):
    return list(csv.DictReader(io.StringIO(text)))


def column(rows, name):
    return np.array([float(row[name]) for row in rows])


def simulate(real, args):
    return table(done(real, "simulate " + args))


def report(real, args):
    """The JSON of a montecarlo run."""
    return json.loads(done(real, f"montecarlo {args} --json -"))


def rows_of(real, args):
    return table(done(real, f"montecarlo {args} --csv -"))


def options(case):
    return " ".join(f"--{name} {value}" for name, value in case.items())


# ---- modes

TABLES = {
    "torsion_hz": (0.3679, 1.2275, 2.2039, 3.2179, 4.2411, 5.2575, 6.2380, 7.1004, 7.8407, 8.7130),
    "torsion_prestressed_hz": (0.3681, 1.2281, 2.2049, 3.2194, 4.2431, 5.2599, 6.2407, 7.1028, 7.8435, 8.7168),
    "axial_hz": (1.4168, 3.0166, 4.7244, 6.4701, 8.2178, 9.9314, 11.5382, 12.9613, 14.3927, 16.0154),
    "axial_prestressed_hz": (1.4173, 3.0179, 4.7266, 6.4731, 8.2216, 9.9358, 11.5428, 12.9659, 14.3985, 16.0226),
}


def check_modes():
    """Tables 1 and 2 of the paper, digit by digit."""
    for real in PROGRAM:
        text = done(real, "modes")
        found = json.loads(done(real, "modes --json -"))
        claim(set(found) == {"model", *TABLES}, f"{real} modes --json: keys {sorted(found)}")
        for name, printed in TABLES.items():
            want = [f"{hz:.4f}" for hz in printed]
            claim([f"{hz:.4f}" for hz in found[name]] == want, f"{real} modes: {name} is not the paper's")
            claim(any(line.split()[-10:] == want for line in text.splitlines()), f"{real} modes: {name} is not printed as the paper does")


# ---- simulate

def check_golden():
    """The nominal case of model.md; axial speed against its closed form."""
    times = (0, 5, 10, 20, 50)
    for real, within, axial_within in (("double", 0.01, 1e-6), ("float", 0.06, 5e-5)):
        text = done(real, "simulate --step 0.0005 --out-step 5 --duration 50")
        claim(text.splitlines()[0] == SIMULATE_HEADER, f"{real} simulate: header {text.splitlines()[0]}")
        rows = {float(row["time_s"]): row for row in table(text)}
        claim(sorted(rows) == [5.0 * k for k in range(11)], f"{real} simulate: times {sorted(rows)}")
        picked = [rows[t] for t in times]
        close(column(picked, "bit_speed_rpm") * RPM, (0.1442639, 22.808388, 17.560572, 0.727388, 5.049398), within * RPM, f"{real} golden bit speed")
        close(column(picked, "bit_axial_speed_m_s")[1:], (0.598377, 0.467162, 0.395796, 0.730316), 5e-6 + axial_within, f"{real} golden axial speed")
        close(column(picked, "bit_axial_speed_m_s"), String().axial_speed(times), axial_within, f"{real} axial speed")
        claim(all(row["top_speed_rpm"] in ("100", "100.000000") or abs(float(row["top_speed_rpm"]) - 100) < 1e-5 for row in picked), f"{real} top speed")
        at = column(picked, "time_s")
        close(column(picked, "wob_kN"), 100 - 50 * (np.sin(100 * RPM * at) + 0.01), 1e-9 if real == "double" else 1e-3, f"{real} weight on bit")


CASES = (
    ({"rpm": 120, "wob": 150, "mu": 0.02, "start": "rest"}, 30),
    ({"rpm": 80, "wob": 60, "mu": 0.004, "start": "rotating"}, 40),
    ({"rpm": 140, "wob": 200, "mu": 0.04, "alpha1": 1.5, "start": "rest"}, 30),
    ({"rpm": 60, "wob": 120, "mu": 0.01, "alpha1": 3, "alpha2": 0.5, "f0": 20, "start": "rest"}, 30),
    ({"rpm": 90, "wob": 40, "mu": 0.02, "start": "rotating"}, 20),
)


def check_other_cases():
    """Bit speed and surface torque of other cases against an adaptive integration, whose modes come from no table."""
    for case, horizon in CASES:
        string, times = String(**case), np.arange(0.0, horizon + 0.1, 2.5)
        states = string.torsion(times)
        for real, within in (("double", 0.01), ("float", 0.06)):
            rows = simulate(real, f"{options(case)} --step 0.0005 --out-step 2.5 --duration {horizon}")
            close(column(rows, "bit_speed_rpm"), string.bit_speed(states) / RPM, within, f"{real} {case}: bit speed in rpm")
            close(column(rows, "surface_torque_kNm"), string.surface_torque(times, states) / 1e3, 0.001 if real == "double" else 0.006,
                  f"{real} {case}: surface torque in kN m")
            close(column(rows, "bit_axial_speed_m_s"), string.axial_speed(times), 1e-6 if real == "double" else 3e-5, f"{real} {case}: axial speed")


def check_order():
    """Halving the step divides the error by 2^4."""
    speed = []
    for step in (0.002, 0.001, 0.0005):
        rows = simulate("double", f"--mu 0.004 --start rotating --duration 10 --out-step 0.5 --step {step}")
        speed.append(column(rows, "bit_speed_rpm")[1:])
    order = np.log2(np.linalg.norm(speed[0] - speed[1]) / np.linalg.norm(speed[1] - speed[2]))
    close(order, 4.0, 0.05, "order of the integrator")


def check_replay():
    """simulate --sample J is realisation J of montecarlo; the file gets what stdout gets, and a summary is said."""
    case = "--mu 0.01 --cov 0.2 --seed 7 --duration 6 --window 3:5"
    for real in PROGRAM:
        for row in rows_of(real, f"{case} --first 40 --samples 3"):
            again = simulate(real, f"{case} --sample {row['index']} --out-step 0.001")
            time_s, speed = column(again, "time_s"), column(again, "bit_speed_rpm")
            seen = speed[(time_s >= 3.0 - 1e-9) & (time_s <= 5.0 + 1e-9)]
            claim((seen.min(), seen.max()) == (float(row["bit_min_rpm"]), float(row["bit_max_rpm"])), f"{real} replay of {row['index']}: extremes differ")
            close((seen.max() - seen.min()) / (seen.max() + seen.min()), float(row["ss"]), 1e-6, f"{real} replay of {row['index']}: ss")
            close(np.mean(0.5 * (seen[1:] + seen[:-1])), float(row["bit_mean_rpm"]), 2e-3, f"{real} replay of {row['index']}: mean")
            claim(again[0]["top_speed_rpm"] == row["rpm"], f"{real} replay of {row['index']}: top speed")
    with tempfile.TemporaryDirectory() as where:
        said = done("float", f"simulate {case} --sample 40 --out {where}/a.csv")
        with open(f"{where}/a.csv", encoding="ascii") as file:
            claim(file.read() == done("float", f"simulate {case} --sample 40"), "simulate --out: another text than on stdout")
        claim(re.search(r"severity ss = [0-9.]+ .*stick-slip", said), f"simulate --out says {said!r}")
        claim(os.listdir(where) == ["a.csv"], f"simulate --out leaves {os.listdir(where)}")


# ---- montecarlo

def clopper_pearson(k, n, refused=0):
    hi = k + refused
    return [beta.ppf(0.025, k, n - k + 1) if k else 0.0, beta.ppf(0.975, hi + 1, n - hi) if hi < n else 1.0]


def check_probability():
    """The paper's 100 % and 50 %; a string that already rotates stays free more often."""
    for what, lo, hi in (("--mu 0.04", 0.999, 1.0), ("--mu 0.004", 0.46, 0.53), ("--mu 0.004 --start rotating", 0.16, 0.22)):
        found = {real: report(real, f"{what} --samples 4000") for real in PROGRAM}
        for real, r in found.items():
            claim(lo <= r["probability"] <= hi, f"{real} {what}: P = {r['probability']}")
            claim(r["probability"] == r["stuck"] / (r["samples"] - r["refused"]), f"{real} {what}: P is not stuck / counted")
            claim(r["ci95"][0] <= r["probability"] <= r["ci95"][1], f"{real} {what}: P outside {r['ci95']}")
            close(r["ci95"], clopper_pearson(r["stuck"], 4000, r["refused"]), 1e-9, f"{real} {what}: interval")
            claim(r["refused"] == 0, f"{real} {what}: {r['refused']} refused")
        claim(abs(found["float"]["stuck"] - found["double"]["stuck"]) <= 4, f"{what}: float and double differ by more than 0.001")


KEYS = {"probability", "ci95", "samples", "stuck", "refused", "liftoff", "seed", "first", "digest", "real", "model", "seconds"}


def check_report():
    """Keys of the JSON, columns of the CSV, and the summary all tell one story; the digest is that of the columns."""
    case = "--mu 0.004 --cov 0.3 --wob 80 --samples 60 --duration 3 --seed 5 --first 1000"
    for real in PROGRAM:
        r, text, rows = report(real, case), done(real, f"montecarlo {case}"), rows_of(real, case)
        claim(KEYS <= set(r), f"{real} --json lacks {KEYS - set(r)}")
        claim((r["samples"], r["seed"], r["first"], r["real"]) == (60, 5, 1000, real), f"{real} --json: {r}")
        claim(re.fullmatch(r"[0-9a-f]{8}", r["digest"]) and f"digest {r['digest']}" in text, f"{real} digest {r['digest']}")
        claim(f"P(stick-slip) = {r['probability']:.4f}" in text, f"{real} summary: {text!r}")
        claim(",".join(rows[0]) == MONTECARLO_HEADER, f"{real} --csv: header {','.join(rows[0])}")
        claim([int(row["index"]) for row in rows] == list(range(1000, 1060)), f"{real} --csv: indices")
        claim(sum(int(row["stuck"]) for row in rows) == r["stuck"], f"{real} --csv: stuck")
        claim(sum(int(row["liftoff"]) for row in rows) == r["liftoff"] > 0, f"{real} --csv: lift-off")
        claim(all((float(row["fc_kN"]) < 50.5) == (row["liftoff"] == "1") for row in rows), f"{real} --csv: lift-off of the wrong ones")
        claim(all((float(row["ss"]) > 0.8) == (row["stuck"] == "1") for row in rows if row["status"] == "ok"), f"{real} --csv: stuck is not ss > 0.8")
    claim(f"{crc32c(b''.join(map(record, rows_of('float', case)))):08x}" == report("float", case)["digest"], "float digest is not that of the columns")


def record(row):
    """What the digest covers of one realisation, in float: nine digits bring every float back."""
    units = (("fc_kN", 1e3), ("mu", 1), ("alpha1", 1), ("alpha2", 1), ("rpm", RPM), ("bit_min_rpm", RPM), ("bit_max_rpm", RPM),
             ("bit_mean_rpm", RPM), ("ss", 1))
    values = [float(row[name] or 0.0) * unit for name, unit in units]
    return struct.pack("<I9fB", int(row["index"]), *values, ("ok", "step", "range", "nonfinite", "corrupt").index(row["status"]))


def engines():
    found = kelly("float", "montecarlo --engine none").stderr
    widest = re.search(r"the widest here is (\w+)", found).group(1)
    return engines_of(PROGRAM["float"]), widest


def check_cuts():
    """Same digest and same rows for any threads, engine and cut of the range."""
    case = "--mu 0.004 --duration 4 --seed 11"
    usable, widest = engines()
    claim("scalar" in usable and widest in usable and len(usable) >= 2, f"engines {usable}, widest {widest}")
    for real in PROGRAM:
        whole = done(real, f"montecarlo {case} --samples 203 --first 50 --csv -").splitlines()
        digest = report(real, f"{case} --samples 203 --first 50")["digest"]
        for threads in (1, 2, 5, 64):
            claim(report(real, f"{case} --samples 203 --first 50 --threads {threads}")["digest"] == digest, f"{real} --threads {threads}: another digest")
        for engine in usable:
            r = report(real, f"{case} --samples 203 --first 50 --engine {engine}")
            claim((r["digest"], r["engine"]) == (digest, engine), f"{real} --engine {engine}: another digest or engine")
        parts = []
        for first, samples in ((50, 1), (51, 17), (68, 100), (168, 85)):
            parts += done(real, f"montecarlo {case} --samples {samples} --first {first} --csv -").splitlines()[1:]
        claim(parts == whole[1:], f"{real}: rows of the parts differ from the whole")
        claim(report(real, f"{case} --samples 203 --first 50 --seed 12")["digest"] != digest, f"{real}: another seed, same digest")
    a, b = (rows_of(real, f"{case} --samples 50") for real in PROGRAM)
    for name, unit in (("fc_kN", 1e3), ("mu", 1), ("alpha1", 1), ("alpha2", 1), ("rpm", RPM)):
        claim(np.array_equal(np.float32(unit * column(a, name)), np.float32(unit * column(b, name))), f"{name} differs between float and double")


def check_ends():
    """One sample, the last indices, nothing random."""
    case = "--duration 1 --mu 0.004"
    r = report("float", f"{case} --samples 1")
    close(r["ci95"], clopper_pearson(r["stuck"], 1), 1e-9, "interval of one sample")
    rows = rows_of("float", f"{case} --first 4294967290 --samples 6")
    claim([int(row["index"]) for row in rows] == list(range(4294967290, 4294967296)), "the last indices")
    for first in (4294967290, 4294967295):
        r = report("float", f"{case} --first {first} --until-width 0.05")
        claim((r["samples"], r["sequence"]["samples_most"]) == (4294967296 - first,) * 2, f"--until-width from {first}: {r['samples']} of {r['sequence']}")
    for args in (f"montecarlo {case}", f"sensitivity {case}", f"advise {case}", f"map --rpm 60 --wob 40 {case}", f"montecarlo {case} --until-width 0.05 --samples 7"):
        result = kelly("float", f"{args} --first 4294967290")
        refused(result, 2, f"{args} at the end of the indices")
        claim("--samples 400" not in result.stderr and "indices end" in result.stderr, f"{args} at the end of the indices: {result.stderr}")
    claim(report("float", f"{case} --samples 3 --seed 18446744073709551615")["seed"] == 18446744073709551615, "the largest seed")
    rows = rows_of("double", f"{case} --samples 5 --cov 0")
    claim(len({tuple(list(row.values())[1:]) for row in rows}) == 1 and float(rows[0]["fc_kN"]) == 100.0, "cov 0 is not one realisation")
    rows = rows_of("double", f"{case} --samples 5 --cov mu=0.1,rpm=0.3")
    claim(len(set(column(rows, "mu"))) == 5 and len(set(column(rows, "rpm"))) == 5, "named covs are not random")
    claim(set(column(rows, "fc_kN")) == {100.0} and set(column(rows, "alpha1")) == {2.0}, "covs that are not named are random")
    small, large = (column(rows_of("float", f"--duration 0.1 --samples 4000 --cov mu={c}"), "mu") for c in (0.05, 0.2))
    for values, cov in ((small, 0.05), (large, 0.2)):
        close(values.mean() / 0.04, 1.0, 4 * cov / 4000**0.5, f"mean of mu at cov {cov}")
        close(values.std() / 0.04 / cov, 1.0, 0.06, f"spread of mu at cov {cov}")


def check_refused():
    """Steps that are too long and weights outside the fit are counted and named; the interval widens; nothing is dropped."""
    for what, why in (("--step 0.002 --cov 0.4 --samples 300", "step"), ("--wob 900 --cov 0.5 --mu 0.001 --samples 40", "range")):
        case = f"{what} --duration 2"
        r, text, rows = report("float", case), done("float", f"montecarlo {case}"), rows_of("float", case)
        bad = [int(row["index"]) for row in rows if row["status"] == why]
        claim(0 < len(bad) < len(rows) and r["refused"] == r["refused_by"][why] + sum(v for k, v in r["refused_by"].items() if k != why), f"{what}: {r}")
        claim(len(bad) == r["refused_by"][why], f"{what}: {len(bad)} rows, {r['refused_by']}")
        claim([i for i, reason in r["refused_first"] if reason == why] == bad[:100], f"{what}: --json names others")
        claim(all(f"{i} ({why})" in text for i in bad[:12]), f"{what}: the summary does not name them")
        close(r["ci95"], clopper_pearson(r["stuck"], r["samples"], r["refused"]), 1e-9, f"{what}: interval")
        claim(all(row["bit_min_rpm"] == row["ss"] == "" and row["stuck"] == "0" for row in rows if row["status"] != "ok"), f"{what}: results of refused ones")
        claim(f"{crc32c(b''.join(map(record, rows))):08x}" == r["digest"], f"{what}: digest")
    result = kelly("float", "montecarlo --step 0.004 --mu 0.004 --samples 2 --duration 4")
    claim(result.returncode == 0, f"montecarlo minds an --out-step that nobody gave and it has no use for: {result.stderr.strip()}")
    r = report("float", "--wob 60 --mu 0.004 --samples 400 --duration 1")
    claim(0.15 <= r["liftoff"] / 400 <= 0.30, f"--wob 60: {r['liftoff']} of 400 lift off, not some 22 %")
    said = kelly("float", "simulate --step 0.005").stderr
    step = float(re.search(r"largest safe step is (\S+) s", said).group(1))
    claim(0.003 < step < 0.0037, f"largest safe step {step}")
    claim(kelly("float", f"simulate --step {step} --duration {step * 100} --out-step {step}").returncode == 0, f"its own largest step {step} is refused")
    for drive in ("soft:Z=1e9,f=100,J=1", "soft:Z=2e5,f=100,J=1"):
        said = kelly("float", f"simulate --duration 1 --window 0:1 --drive {drive}").stderr
        shown = re.fullmatch(r"kelly: --step 0.001: too long for this case; the largest safe step is (\S+) s(, and none below 1e-06 s can be given: [^\n]*)?\n", said)
        warned = re.search(r"nominal case allows (\S+) s", kelly("float", f"montecarlo --samples 2 --duration 1 --window 0:1 --drive {drive}").stdout)
        claim(shown and warned and shown[1] == warned[1] and float(shown[1]) > 0, f"{drive}: a safe step of use: {said!r}, {warned}")
        claim(shown and (float(shown[1]) < 1e-6) == bool(shown[2]), f"{drive}: whether it can be given: {said!r}")
    step = float(shown[1]) if shown else 1.0
    ran = kelly("float", f"simulate --drive {drive} --step {step} --out-step {step} --duration {1000 * step} --window 0:{1000 * step}")
    claim(ran.returncode == 0, f"{drive}: its own largest step {step} is refused: {ran.stderr}")


def check_no_answer():
    """A probability of nothing is exit 1 and a line that says what would help; the files are there all the same."""
    for case, words in (("--step 0.02", "(step 5, range 0, nonfinite 0, corrupt 0): the step is too long for 5 of 5; the nominal case allows 0.0036"),
                        ("--wob 1500 --cov 0", "(step 0, range 5, nonfinite 0, corrupt 0): the table is fitted for weights of 1..1000 kN; give such a --wob")):
        with tempfile.TemporaryDirectory() as where:
            result = kelly("float", f"montecarlo {case} --samples 5 --duration 2 --json {where}/r.json --csv {where}/r.csv --quiet")
            refused(result, 1, f"all refused, {case}")
            claim(f"none of 5 realisations can be trusted {words}" in result.stderr, f"all refused, {case}: {result.stderr!r}")
            with open(f"{where}/r.json", encoding="ascii") as file:
                r = json.load(file)
            claim(r["probability"] is None and r["ci95"] == [0, 1] and r["refused"] == 5, f"all refused: {r['probability']} {r['ci95']}")
            claim(sorted(os.listdir(where)) == ["r.csv", "r.json"], f"all refused: files {os.listdir(where)}")
            refused(kelly("float", f"merge {where}/r.csv --quiet"), 1, f"a merge of those, {case}")
    for command in ("simulate", "montecarlo --samples 5 --cov 0"):      # a step that is told can be given
        told = kelly("float", f"{command} --step 1e-6 --duration 0.0001 --window 0:0.0001 --out-step 1e-6")
        least = re.search("give at least ([0-9.e-]+) s", told.stderr)
        claim(told.returncode in (1, 2) and least, f"{command}, a step too short: {told.stderr!r}")
        claim(least and kelly("float", f"{command} --step {least[1]} --duration {5 * float(least[1]):.12g} --out-step {least[1]}").returncode == 0,
              f"{command}, a step too short: {least and least[1]} is not taken")
    for command in ("map --rpm 60 --wob 100", "sensitivity"):
        refused(kelly("float", f"{command} --step 0.02 --samples 5 --duration 2 --quiet"), 1, f"{command}, all refused")
    for more, files in (("", {"r.csv", "r.json"}), ("--traces {}/t.npy", {"r.csv", "r.json", "t.npy"}), ("--resume", {"r.csv", "r.json"})):
        with tempfile.TemporaryDirectory() as where:
            result = kelly("float", f"montecarlo --step 0.02 --samples 5 --duration 2 --envelope {where}/e.csv --csv {where}/r.csv --json {where}/r.json --quiet "
                           + more.format(where))
            lines = [line for line in result.stderr.splitlines() if ".journal: not there, or empty; " not in line]
            claim(result.returncode == 1 and len(lines) == 2 and f"--envelope {where}/e.csv: not written: " in lines[0] and "no answer" in lines[1],
                  f"an envelope of nothing {more}: exit {result.returncode}, {lines}")
            claim(set(os.listdir(where)) == files, f"an envelope of nothing {more}: files {os.listdir(where)}")


def check_convergence():
    """The convergence function against a computation of its own."""
    case = "--mu 0.01 --cov 0.2 --samples 3 --duration 4 --out-step 0.01 --step 0.0005 --seed 2"
    for real, within in (("double", 1e-6), ("float", 2e-4)):
        found = report(real, f"{case} --convergence")["convergence"]
        rows = rows_of(real, case)
        each = [String(wob=float(row["fc_kN"]), mu=float(row["mu"]), alpha1=float(row["alpha1"]), alpha2=float(row["alpha2"]),
                       rpm=float(row["rpm"])).response(4.0, 0.01) for row in rows]
        claim([n for n, _ in found] == [1, 2, 3], f"{real} convergence: n = {[n for n, _ in found]}")
        for n, value in found:
            close(value / np.mean(each[:n]), 1.0, within, f"{real} convergence at {n}")


# ---- mistakes

def refused(result, status, what):
    one_line = result.stderr.endswith("\n") and result.stderr.count("\n") == 1 and result.stderr.startswith("kelly: ")
    claim(result.returncode == status and one_line and not result.stdout,
          f"{what}: exit {result.returncode} (not {status}), stdout {result.stdout[:60]!r}, stderr {result.stderr[:200]!r}")


def check_mistakes():
    """Every mistake: one line, the right status, nothing on stdout, no file left."""
    with tempfile.TemporaryDirectory() as where:
        for args in bad_usage.USAGE:
            refused(kelly("float", args, cwd=where), 2, args)
            # another --csv or --out would take its place, and --resume is right where there is an output
            if not args.startswith(("modes", "nonsense")) and not any(o in args for o in ("--csv", "--field", "--resume")):
                refused(kelly("float", f"{args} {'--out' if args.startswith('sim') else '--csv'} {where}/left.csv", cwd=where), 2, args + " and a file")
        for args in bad_usage.FILES:
            refused(kelly("float", args.format(D=f"{where}/none", F=where), cwd=where), 1, args)
        claim(os.listdir(where) == [], f"left behind: {os.listdir(where)}")
    with open("/dev/full", "w", encoding="ascii") as full:
        for args in bad_usage.FULL:
            result = subprocess.run([PROGRAM["float"]] + shlex.split(args), stdout=full, stderr=subprocess.PIPE, text=True, check=False)
            result.stdout = ""
            refused(result, 1, args + " on a full disk")
    claim(os.path.exists("/dev/full") and not [name for name in os.listdir("/dev") if name.startswith("full.")], "something left in /dev")


def check_told():
    """What is wrong is said of the thing that is wrong, and what is right is within what is said."""
    for args, said in (("simulate --mu 0.004 --resume", "simulate: unknown option --resume"), ("modes --twice", "modes: unknown option --twice"),
                       ("montecarlo --mu 1001", "give a bit-rock factor in m, 1e-9..1000"), ("montecarlo --wob 1.1e6", "give weight on bit in kN, 0.001..1000000"),
                       ("montecarlo --f0 1.1e6", "in kN, 0..1000000"), ("whatif --from x --alpha1 1.1e6", "alpha_1 in s/rad, 1e-9..1000000"),
                       ("montecarlo --duration 1e12", "give seconds, 1e-6..1e9"), ("montecarlo --drive soft:Z=1e30", "0.001..1e9, e.g. Z=289"),
                       ("montecarlo --cov rpm=", "--cov rpm=: rpm has no number"), ("montecarlo --cov rpm=x", "--cov rpm: x: not a finite"),
                       ("montecarlo --cov mu=0.1,fc=0.6", "--cov fc: 0.6: out of range"), ("simulate --drive soft:Z=", "soft:Z=: Z= has no number"),
                       ("bench --port tcp:localhost:1 --icount shift=5", "--port tcp:localhost:1 is no emulator"), ("bench --port qemu:rv32 --mode wits --seed 9", "not in --mode wits"),
                       ("montecarlo --window 50:50", "--window 50:50: is empty"),
                       ("rare --resume", "give --json\n"), ("advise --resume", "give --json\n"), ("montecarlo --resume", "give --csv, --json, --envelope or"),
                       ("simulate --seed 9", "--seed: the nominal case is not random; give --sample J"), ("simulate --cov 0.3", "--cov: the nominal case"),
                       ("bench --port qemu:rv32 --mode lockstep --seed 9", "--seed: the nominal case"), ("montecarlo --quantiles exact", "give --envelope F.npy too"),
                       ("montecarlo --trace-of bit_speed_rpm", "give --traces F.npy too")):
        result = kelly("float", args)
        refused(result, 2, args)
        claim(said in result.stderr, f"{args}: {result.stderr!r}")
    for args, said in (("plan --mu 10 --measure 0.05 --cores 1", "the step is too long"), ("plan --wob 100000 --measure 0.05 --cores 1", "1..1000 kN; give such a --wob"),
                       ("montecarlo --samples 8 --duration 1 --csv /dev/full", "kelly: /dev/full: could not be written: No space left")):
        result = kelly("float", args)
        refused(result, 1, args)
        claim(said in result.stderr, f"{args}: {result.stderr!r}")
    for engine in engines()[0]:          # most of it can be trusted, though not the first that is measured
        claim(kelly("float", f"plan --engine {engine} --wob 950 --mu 0.001 --measure 0.05 --cores 1").returncode == 0, f"plan at 950 kN, {engine}")
    with tempfile.TemporaryDirectory() as where:
        claim(kelly("float", f"plan --wob 100000 --measure 0.05 --cores 1 --json {where}/p.json").returncode == 1 and os.listdir(where) == [], f"plan left {os.listdir(where)}")
    few = kelly("float", "sensitivity --mu 0.001 --wob 900 --duration 1 --samples 64")
    claim(few.returncode == 1 and "27 of 64 rows hold" in few.stderr and "a --wob, or a --cov fc=, whose draws lie there" in few.stderr, f"sensitivity of 37 rows: {few.stderr!r}")
    for args, warned in (("--wob 900 --mu 0.001 --samples 40 --duration 2", True), ("--mu 0.004 --samples 40 --duration 2", False)):
        found = re.search(r"warning: in (\d+) of 40 the weight lies outside 1..1000 kN", done("float", f"montecarlo {args}"))
        r = report("float", args)
        claim(bool(found) == warned and (not found or int(found[1]) == r["refused_by"]["range"] > 0), f"{args}: {found}, {r['refused_by']}")
    stopped = done("float", "simulate --rpm 60 --mu 0.04 --duration 1 --window 0:0.4 --out /dev/null")
    claim("rpm, not above 0: no SSI" in stopped and "SSI =" not in stopped, f"a bit that does not turn: {stopped!r}")


def check_whole():
    """A whole number that is too small or too large is out of range, however it is written; what is none is told so; 1e3 is one."""
    for option, value, where in (("--samples", "-5", "1..4294967295"), ("--samples", "1e30", "1..4294967295"), ("--samples", "1e400", "1..4294967295"),
                                 ("--samples", "-1e3", "1..4294967295"), ("--samples", "4294967296", "1..4294967295"), ("--samples", "9" * 30, "1..4294967295"),
                                 ("--seed", "-1", "0..18446744073709551615"), ("--seed", "1e20", "0..18446744073709551615"),
                                 ("--seed", "18446744073709551616", "0..18446744073709551615"), ("--seed", "1844674407370955161.6e1", "0..18446744073709551615"),
                                 ("--seed", "1e100000000000000000000", "0..18446744073709551615"), ("--threads", "-1", "1..1024"), ("--torsional", "1e2", "1..20")):
        said = kelly("float", f"montecarlo {option} {value}").stderr
        claim(said.startswith(f"kelly: {option} {value}: out of range; give ") and said.endswith(where + "\n"), f"{option} {value}: {said!r}")
    for value in ("1.5", "1e-3", "+5", "5.0", "1e", "1e+", "1e 3", "0x5", "0x1e", "0x1e3", "5 ", " 5", "-", "--5", "inf", "1e6x", "-1.5", "e5", ".5e1", "1.25e1",
                  "1.0000000000000000001e0", "1e-100000000000000000000"):
        result = subprocess.run([PROGRAM["float"], "montecarlo", "--samples", value], capture_output=True, text=True, check=False)
        claim(result.returncode == 2 and f"--samples {value}: not a whole number; give " in result.stderr, f"--samples '{value}': {result.stderr!r}")
    for value in ("20", "2e1", "0.2e2", "020", "2e+01", "200e-1", "2.e1"):
        claim(report("float", f"--samples {value} --duration 1")["samples"] == 20, f"--samples {value}")
    for value, seed in (("1e16", 10**16), ("1e19", 10**19), ("9007199254740993e0", 2**53 + 1), ("1844674407370955161.5e1", 2**64 - 1), ("0e999999999999", 0)):
        result = kelly("float", f"montecarlo --samples 1 --duration 0.1 --json - --seed {value}")
        claim(result.returncode == 0 and json.loads(result.stdout)["seed"] == seed, f"--seed {value}: {result.stderr!r} {re.findall('.*seed.*', result.stdout)}")


def check_times():
    """Times are told with all their digits, in a summary and in a refusal."""
    said = done("float", "montecarlo --samples 2 --duration 1000.001 --step 0.00100")
    claim(", window 500:1000.001 s, step 0.001 s" in said, f"the window of a long run: {said!r}")
    said = done("float", "simulate --duration 1.000125 --step 0.000125 --out /dev/null")
    claim(" over 0.5:1.000125 s" in said, f"the window of simulate: {said!r}")
    said = done("float", "montecarlo --samples 2 --duration 0.999999 --step 0.00333333")
    claim("step 0.00333333 s" in said, f"a step: {said!r}")
    for args, what in (("--duration 10.00005", "--duration 10.00005: not a whole number of steps of 0.001 s"),
                       ("--duration 1000.001 --window 500:1000.002", "--window 500:1000.002: ends after the duration of 1000.001 s; give a window within 0:1000.001")):
        claim(what in kelly("float", f"montecarlo {args}").stderr, f"{args}: {kelly('float', 'montecarlo ' + args).stderr!r}")


def check_links():
    """An output by a link goes where the link leads; two links to one file are one place, whether or not it is there."""
    case = "montecarlo --samples 2 --duration 1 --window 0:1 --quiet"
    with tempfile.TemporaryDirectory() as where:
        os.mkdir(f"{where}/sub")
        for name, target in (("one", "sub/there"), ("two", f"{where}/sub/there"), ("three", "one"), ("round", "round"), ("here", "sub")):
            os.symlink(target, f"{where}/{name}")
        for there in (False, True):
            for a, b in (("one", "two"), ("three", "two"), ("sub/there", "one"), ("here/there", "sub/there"), ("here/x", "sub/x"), ("one", "sub/there.part"),
                         ("one", "one.journal")):
                for args in (f"{case} --csv {a} --json {b}", f"{case} --csv {b} --json {a}"):
                    refused(kelly("float", args, cwd=where), 2, f"{args}, there: {there}")
            made = kelly("float", f"{case} --csv three", cwd=where)
            claim(made.returncode == 0 and os.path.islink(f"{where}/one") and os.path.islink(f"{where}/three") and os.listdir(f"{where}/sub") == ["there"],
                  f"a link stays a link, there: {there}: {made.stderr!r} {os.listdir(where + '/sub')}")
        claim(kelly("float", f"{case} --csv one --json other", cwd=where).returncode == 0 and os.path.exists(f"{where}/other"), "two places are two places")
        claim(sorted(os.listdir(where)) == ["here", "one", "other", "round", "sub", "three", "two"], f"left behind: {os.listdir(where)}")


def check_flags():
    """An option without a value means the same wherever it stands, and takes nothing of what follows; --twice changes no result of a sound machine."""
    short, long = "--mu 0.004 --duration 2 --window 1:2 --threads 2 --cov 0.2", "--mu 0.004 --start rotating --duration 10"
    for command, args, case in (("montecarlo", "--rpm 140 --samples 20", short), ("map", "--rpm 100:120:20 --wob 80 --f0 10 --samples 20", short),
                                ("advise", "--rpm 140 --samples 20 --below 0.5", short), ("sensitivity", "--rpm 140 --samples 20", short),
                                ("rare", "--rpm 125 --samples-per-level 1000", long)):
        def said(more):
            return re.sub(r'"(seconds|crc32c)": .*', "", done("float", f"{command} {more} --json -"))
        want = said(f"{args} {case}")
        flags = re.findall(r"^  (--[a-z-]+)  ", kelly("float", command + " --help").stdout, re.M)
        claim({"--twice", "--quiet", "--help"} <= set(flags), f"{command}: options without a value in its help: {flags}")
        for flag in set(flags) - {"--help", "--resume", "--convergence"}:
            for line in (f"{flag} {args} {case}", f"{args} {flag} {case}", f"{args} {case} {flag}"):
                claim(said(line) == want, f"{command} {line}: another result than without {flag}")


def check_help():
    result = kelly("float", "--help")
    claim(result.returncode == 0 and "montecarlo" in result.stdout and not result.stderr, "--help")
    result = kelly("float", "")
    claim(result.returncode == 2 and not result.stdout and "montecarlo" in result.stderr, "no command")
    claim(re.fullmatch(r"kelly \S+ \S+ float\n", done("float", "--version")), "--version")
    claim(abs(report("float", "--rpm=120 --samples 1 --duration 1")["case"]["rpm"] - 120) < 1e-4, "--option=value")
    r = report("float", "--samples 1 --duration 20")["case"]
    claim(r["window_s"] == [10, 20], f"the window is not the last half: {r['window_s']}")


def main():
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    names = chosen(parser).names
    for name, check in list(globals().items()):
        if name.startswith("check_") and (not names or name[6:] in names):
            start = time.monotonic()
            check()
            print(f"{name[6:]:14s} {time.monotonic() - start:6.1f} s", flush=True)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
