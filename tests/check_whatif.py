#!/usr/bin/env python3
"""check_whatif - other laws from a run on file, against fresh runs under those laws; what is refused; strict reading.

usage: tests/check_whatif.py [--float build/host/kelly] [--double build/host-double/kelly]

Each claim that fails is one line; the last line is `N passed, N failed`.
"""
import json
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from scipy.stats import gamma

sys.dont_write_bytecode = True
from programs import PROGRAM, chosen, command_line  # noqa: E402

count = {True: 0, False: 0}
CASE = "--mu 0.004 --duration 20 --window 10:20 --limit 0.98"
NAMES = {"fc": ("wob_kN", 0), "mu": ("mu", 1), "a1": ("alpha1", 2), "a2": ("alpha2", 3), "rpm": ("rpm", 4)}


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return bool(holds)


def kelly(args, real="float", **more):
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=300, **more)


def done(args, real="float", **more):
    result = kelly(args, real, **more)
    claim(result.returncode == 0 and not result.stderr, f"{args}: exit {result.returncode}, {result.stderr.strip()!r}")
    return json.loads(result.stdout) if result.returncode == 0 and "--json -" in args else None


def refused(args, word, status=2):
    result = kelly(args)
    claim(result.returncode == status and result.stderr.count("\n") == 1 and result.stderr.startswith("kelly: ") and word in result.stderr and
          not result.stdout, f"{args}: exit {result.returncode}, {result.stderr[:300]!r}, wanted {status} and {word!r}")


def stored(folder, name, args, real="float"):
    path = os.path.join(folder, name + ".csv")
    done(f"montecarlo {args} --csv {path} --json {path[:-4]}.json --quiet", real)
    return path


def whatif(path, args="", real="float"):
    return done(f"whatif --from {path} {args} --json -", real)


def by_numpy(path, found):
    """The estimate once more, with scipy's densities."""
    rows = [line.split(",") for line in open(path, encoding="ascii").read().splitlines()[1:]]
    y = np.array([[float(x) for x in r[1:6]] for r in rows])
    ok = np.array([r[11] == "ok" for r in rows])
    stuck = np.array([bool(r[9]) and np.float32(r[9]) > np.float32(found["limit"]) for r in rows])
    log_w = np.zeros(len(rows))
    for name, (key, column) in NAMES.items():
        if found["laws_run"]["cov"][name] > 0:
            for laws, sign in ((found["laws"], 1), (found["laws_run"], -1)):
                shape = laws["cov"][name] ** -2
                log_w += sign * gamma.logpdf(y[:, column], shape, scale=laws[key] / shape)
    w = np.exp(log_w)
    return w[stuck].sum() / w[ok].sum(), w.sum() ** 2 / (w ** 2).sum(), w.max() / w.sum(), w.mean()


def check_agrees_with_fresh_runs(folder):
    path = stored(folder, "run", f"{CASE} --samples 6000 --cov 0.2")
    same, plain = whatif(path), json.load(open(path[:-4] + ".json", encoding="ascii"))
    claim(abs(same["probability"] - plain["probability"]) < 1e-12 and same["ess"] == 6000, "the same laws: the same P")
    claim(max(abs(a - b) for a, b in zip(same["ci95"], plain["ci95"])) < 1e-9, f"the same laws: the same interval {same['ci95']} {plain['ci95']}")
    far = 0
    for args in ("--cov 0.15", "--mu 0.0042", "--mu 0.0038 --cov 0.18", "--rpm 107", "--wob 93 --alpha1 2.1", "--alpha2 1.1 --cov a2=0.1,mu=0.22",
                 "--cov fc=0.19,mu=0.12,a1=0.21,a2=0.2,rpm=0.17 --rpm 95"):
        found = whatif(path, args)
        # of montecarlo, what is not named is not random: the laws are spelled out
        cov = ",".join(f"{k}={v:.9g}" for k, v in found["laws"]["cov"].items())
        means = " ".join(f"--{o} {found['laws'][k]:.9g}" for o, k in (("rpm", "rpm"), ("wob", "wob_kN"), ("mu", "mu"), ("alpha1", "alpha1"), ("alpha2", "alpha2")))
        fresh = done(f"montecarlo {CASE} {means} --cov {cov} --samples 6000 --seed 4711 --json -")
        p, q = found["probability"], fresh["probability"]
        claim(abs(p - q) < 3.5 * (p * (1 - p) * (1 / found["ess"] + 1 / 6000)) ** 0.5, f"{args}: {p:.4f}, a fresh run {q:.4f}")
        claim(found["ci95"][0] < p < found["ci95"][1] and found["ci95"][1] - found["ci95"][0] < 0.15, f"{args}: {found['ci95']}")
        far += not found["ci95"][0] <= q <= found["ci95"][1]
        again = by_numpy(path, found)
        claim(np.allclose(again[:3], [p, found["ess"], found["largest_share"]], rtol=1e-5), f"{args}: {p}, {found['ess']}, by numpy {again}")
        claim(abs(again[3] - 1) < 0.1 and abs(found["ess"] / found["ess_predicted"] - 1) < 0.25, f"{args}: mean weight {again[3]}, {found}")
        print(f"{args:58s} P {p:.4f} [{found['ci95'][0]:.4f}, {found['ci95'][1]:.4f}]  ess {found['ess']:6.0f}   fresh {q:.4f}")
    claim(far <= 2, f"{far} of 7 fresh runs lie outside the intervals")
    other = whatif(path, "--limit 1.0")
    fresh = done(f"montecarlo {CASE} --limit 1.0 --samples 6000 --cov 0.2 --json -")
    claim(other["probability"] == fresh["probability"], "another limit: the same realisations, counted anew")
    return path


def check_intervals_hold(folder):
    """Other laws 40 times, from runs of their own: the interval holds what a long fresh run gives."""
    case = "--mu 0.004 --duration 4 --window 2:4 --limit 1.05"
    truth = done(f"montecarlo {case} --mu 0.0044 --cov 0.18 --samples 40000 --seed 5 --json -")["probability"]
    misses = 0
    for seed in range(40):
        path = stored(folder, "short", f"{case} --samples 1500 --seed {100 + seed} --cov 0.2")
        lo, hi = whatif(path, "--mu 0.0044 --cov 0.18")["ci95"]
        misses += not lo <= truth <= hi
    claim(misses <= 6, f"{misses} of 40 intervals miss {truth}")
    print(f"P = {truth:.4f}: {misses} of 40 intervals miss it")


def check_refused_count(folder):
    path = stored(folder, "steps", "--mu 0.05 --cov 0.4 --step 0.002 --duration 4 --window 2:4 --limit 1.02 --samples 2000")
    found = whatif(path, "--cov 0.38")
    p, ess, share, _ = by_numpy(path, found)
    claim(found["refused"] > 50 and abs(found["probability"] - p) < 1e-5, f"{found['refused']} refused, {found['probability']} {p}")
    claim(found["ci95"][0] < p < found["ci95"][1] and found["ci95"][1] - found["ci95"][0] > 0.1, f"they widen the interval: {found['ci95']}")


def check_double(folder):
    path = stored(folder, "double", "--mu 0.004 --duration 4 --window 2:4 --limit 1.05 --samples 400 --seed 18446744073709551615 --first 4294966000", "double")
    a, b = whatif(path, "--mu 0.0042"), whatif(path, "--mu 0.0042", "double")
    claim(a["real"] == "double" and abs(a["probability"] - b["probability"]) < 1e-6, "a run in double, read by both")


def check_too_far(path):
    for args in ("--mu 0.006", "--mu 0.02", "--cov 0.3", "--cov 0.5", "--cov 0.0001", "--rpm 200", "--cov mu=0.285"):
        refused(f"whatif --from {path} {args}", "too far from what was run")
    few = stored(os.path.dirname(path), "few", "--mu 0.004 --duration 1 --window 0:1 --samples 60")
    refused(f"whatif --from {few}", "few.csv: holds 60 realisations that count, and at least 100 are wanted; run montecarlo with more --samples")
    refused(f"whatif --from {path} --cov fc=0", "no realisation has one single value")
    for args, word in (("--cov 0.6", "out of range"), ("--mu 0", "out of range"), ("--wob x", "not a finite number"), ("--f0 3", "unknown option"),
                       ("--duration 3", "unknown option"), ("--cov fc=0.1,fc=0.1", "stands twice"), ("--json /nowhere/x", "cannot write")):
        refused(f"whatif --from {path} {args}", word, 1 if "nowhere" in args else 2)
    refused("whatif", "give --from")


def check_laws_must_be_known(folder, path):
    alone = os.path.join(folder, "alone.csv")
    shutil.copy(path, alone)
    refused(f"whatif --from {alone}", "its laws are unknown")
    found = done(f"whatif --from {alone} --case-json {path[:-4]}.json --json -")
    claim(found["samples"] == 6000, "the JSON can be named")
    for args, name in ((f"{alone} --case-json {folder}/nothing.json", "nothing.json"), (f"{folder}/nothing.csv --case-json {path[:-4]}.json", "nothing.csv"),
                       (f"{folder}/nothing.csv", "nothing.csv")):
        refused(f"whatif --from {args}", f"{folder}/{name}: there is no such file")
    refused(f"whatif --from {folder} --case-json {path[:-4]}.json", f"{folder}: a directory")
    refused(f"whatif --from {alone} --case-json {folder}", f"{folder}: a directory")
    fixed = stored(folder, "fixed", "--mu 0.004 --duration 2 --window 1:2 --samples 200 --cov mu=0.2")
    refused(f"whatif --from {fixed} --rpm 110", "was not random")
    refused(f"whatif --from {fixed} --cov 0.2", "was not random")
    claim(whatif(fixed, "--cov mu=0.18")["ess"] > 100, "what was random can be changed")
    before = [open(fixed[:-4] + end, "rb").read() for end in (".csv", ".json")]
    for out in (fixed, fixed[:-4] + ".json", os.path.join(folder, ".", "fixed.csv")):
        refused(f"whatif --from {fixed} --cov mu=0.18 --json {out}", "is read here")
    claim([open(fixed[:-4] + end, "rb").read() for end in (".csv", ".json")] == before, "the run stays as it is")
    for more in ("--until-width 0.2", "--until-decided 0.9", "--until-width 0.01 --samples 300"):
        refused(f"whatif --from {stored(folder, 'until', f'{CASE} {more}')}", "stopped itself")
    text = open(path[:-4] + ".json", encoding="ascii").read()
    other = os.path.join(folder, "older.json")
    with open(other, "w", encoding="ascii") as file:
        file.write(re.sub(r',\n  "crc32c": .*\n', "\n", text))
    claim("crc32c" not in open(other, encoding="ascii").read().replace("csv_crc32c", ""), "a report without its CRC")
    claim(done(f"whatif --from {alone} --case-json {other} --json -") == found, "a report without its CRC is read")
    changed = os.path.join(folder, "changed.json")
    with open(changed, "w", encoding="ascii") as file:
        file.write(text.replace('"mu": 0.00400000019', '"mu": 0.00400000020'))
    refused(f"whatif --from {alone} --case-json {changed}", "changed since it was written")
    rows = open(alone, encoding="ascii").read()
    near = next(line for line in rows.splitlines()[1:] if 0.5 < float(line.split(",")[9] or 0) < 0.9)
    with open(changed, "w", encoding="ascii") as file:
        file.write(rows.replace(near, ",".join(near.split(",")[:9] + ["0.95"] + near.split(",")[10:])))
    refused(f"whatif --from {changed} --case-json {path[:-4]}.json", "not the file that")
    other = os.path.join(folder, "other.json")
    text = re.sub(r',\n  "crc32c": .*\n', "\n", text)     # what else is wrong with it
    for old, new, word in (('"mu": 0.00400000019', '"mu": 0.0041', "line 2: parameter 2"), ('"seed": 1,', '"seed": 2,', "line 2: parameter 1"),
                           ('"rpm": 0.200000003', '"rpm": 0.21', "line 2: parameter 5"), ('"first": 0', '"first": 1', "line 2: index 0"),
                           ('"samples": 6000', '"samples": 5999', "line 6001: index 5999"), ('"samples": 6000', '"samples": 6001', "says 6001"),
                           ('"stuck": 2', '"stuck": 1', "says 6000, 1"), ('"stuck": ', '"stuck": 1', "of 6000"), ('"limit": 0.98', '"limit": 0.97', "do not agree with the limit"),
                           ('"seed": 1,', "", '"seed"'), ('"cov": {', '"cow": {', '"case.cov.fc"'), ("}", "", "no JSON from character"),
                           ('"first": 0', '"first": 0, "first": 0', "stands twice"), ('"mu": 0.00400000019', '"mu": nan', "no JSON from character")):
        claim(old in text, f"the JSON holds {old}")
        with open(other, "w", encoding="ascii") as file:
            at = text.rindex(old) if old == "}" else text.index(old)
            file.write(text[:at] + new + text[at + len(old):])
        refused(f"whatif --from {alone} --case-json {other}", word)


def check_strict_reading(folder):
    path = stored(folder, "strict", "--mu 0.05 --cov 0.4 --step 0.002 --duration 1 --window 0:1 --samples 150")
    good = open(path, "rb").read()
    lines = good.split(b"\n")
    bad_row = next(i for i, line in enumerate(lines) if b",step," in line)
    ok_row = next(i for i, line in enumerate(lines) if b",ok," in line)
    found = whatif(path)
    claim(found["samples"] == 150, "the file as it is")

    def broken(change, word, what):
        with open(path, "wb") as file:
            file.write(change)
        refused(f"whatif --from {path}", word)
        claim(True, what)

    def with_line(i, line):
        return b"\n".join(lines[:i] + [line] + lines[i + 1:])

    fields = lines[ok_row].split(b",")
    for k, text in ((0, b"-1"), (0, b"x"), (1, b"nan"), (2, b"0x1p3"), (2, b""), (3, b"-2"), (5, b" 100"), (9, b"inf"), (9, b""), (10, b"2"), (11, b"fine"), (12, b"0.5"),
                    (11, b"step"), (2, b"0.04")):
        broken(with_line(ok_row, b",".join(fields[:k] + [text] + fields[k + 1:])), f"line {ok_row + 1}: ", f"field {k} {text}")
    broken(with_line(bad_row, lines[bad_row].replace(b",step,", b",ok,")), f"line {bad_row + 1}: ", "ok without a result")
    broken(with_line(ok_row, lines[ok_row] + b",1"), f"line {ok_row + 1}: not 13 fields", "too many fields")
    broken(with_line(ok_row, lines[ok_row] + b"\0"), f"line {ok_row + 1}: not a whole line", "a zero")
    broken(with_line(ok_row, lines[ok_row] + b"\r"), f"line {ok_row + 1}: ", "a carriage return")
    broken(with_line(ok_row, b""), f"line {ok_row + 1}: not 13 fields", "an empty line")
    broken(b"\n".join(lines[:5] + lines[6:]), "line 6: index 5", "a missing line")
    broken(b"\n".join(lines[:5] + [lines[4]] + lines[5:]), "line 6: index 3", "a line twice")
    broken(b"\n".join(lines[:100]) + b"\n", "not the file that", "cut at a line")
    broken(good[:-1], "line 151: not a whole line", "cut before the end of the last line")
    broken(b"", "line 1: not the header", "nothing")
    broken(b"index,x\n", "line 1: not the header", "another header")
    broken(good.replace(b"alpha1", b"alpha3", 1), "line 1: not the header", "another header")
    dice = random.Random(7)
    for _ in range(60):                     # any byte to any other: never a crash, never a result from less than all of it
        at, to = dice.randrange(len(good)), dice.randrange(256)
        with open(path, "wb") as file:
            file.write(good[:at] + bytes([to]) + good[at + 1:])
        result = kelly(f"whatif --from {path} --json -")
        claim(result.returncode == 2 and result.stderr.count("\n") == 1 or
              good[at] == to and result.returncode == 0 and json.loads(result.stdout)["samples"] == 150, f"byte {at} to {to}: {result.returncode} {result.stderr[:200]!r}")
        with open(path, "wb") as file:
            file.write(good[:at])
        claim(kelly(f"whatif --from {path}").returncode == 2, f"cut at {at}")


def main():
    chosen(command_line(__doc__))
    with tempfile.TemporaryDirectory() as folder:
        path = check_agrees_with_fresh_runs(folder)
        check_intervals_hold(folder)
        check_refused_count(folder)
        check_double(folder)
        check_too_far(path)
        check_laws_must_be_known(folder, path)
        check_strict_reading(folder)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] > 0


if __name__ == "__main__":
    sys.exit(main())
