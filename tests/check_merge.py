#!/usr/bin/env python3
"""check_merge - parts of an ensemble, however cut, make the files of one run; what does not fit is named and refused.

usage: tests/check_merge.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. NAME picks single checks.
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

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from programs import PROGRAM, ROOT, chosen, command_line  # noqa: E402
from second_opinion import crc32c  # noqa: E402

count = {True: 0, False: 0}
# short, with realisations of every kind: stuck and free, lifted off, refused for the step and for the range
CASE = "--mu 0.02 --wob 500 --f0 300 --cov 0.45 --duration 4 --window 2:4 --torsional 5"


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return bool(holds)


def kelly(args, folder, real="float"):
    return subprocess.run([PROGRAM[real]] + shlex.split(args), capture_output=True, text=True, check=False, timeout=120, cwd=folder)


def done(args, folder, real="float"):
    run = kelly(args, folder, real)
    claim(run.returncode == 0 and run.stderr == "", f"{args}: exit {run.returncode}, {run.stderr!r}")
    return run.stdout


def refused(args, folder, *words, real="float", status=2):
    before = sorted(os.listdir(folder))
    run = kelly(args, folder, real)
    claim(run.returncode == status and run.stderr.startswith("kelly: ") and run.stderr.count("\n") == 1 and run.stdout == ""
          and all(w in run.stderr for w in words), f"{args}: exit {run.returncode}, {run.stderr!r}, wanted {words}")
    claim(sorted(os.listdir(folder)) == before, f"{args}: leaves {set(os.listdir(folder)) - set(before)}")


def read(folder, name):
    with open(os.path.join(folder, name), "rb") as file:
        return re.sub(rb'("seconds": )[0-9.]+|("crc32c": )"[0-9a-f]*"', rb"\1\2-", file.read())


def bytes_of(folder, name):
    with open(os.path.join(folder, name), "rb") as file:
        return file.read()


def put(folder, name, data):
    with open(os.path.join(folder, name), "wb") as file:
        file.write(data)


def sealed(report):
    """With the CRC at its end that it should have."""
    text = report[:report.rindex(b'  "crc32c": ')]
    return text + b'  "crc32c": "%08x"\n}\n' % crc32c(text)


def part(folder, name, first, samples, more="", real="float", case=CASE):
    done(f"montecarlo {case} --first {first} --samples {samples} --csv {name}.csv --json {name}.json --quiet {more}", folder, real)


def check_cut(folder):
    """Cut anywhere, merged in any order, and merged again."""
    draws = random.Random(7)
    for real in PROGRAM:
        part(folder, "one", 11, 400, real=real)
        want = read(folder, "one.csv"), read(folder, "one.json")
        report = json.loads(want[1].replace(b": -", b": 0"))
        claim(0 < report["stuck"] < 400 and report["liftoff"] > 0 and report["refused_by"]["step"] > 0 and report["refused_by"]["range"] > 0,
              f"the case has all kinds: {report['stuck']}, {report['liftoff']}, {report['refused_by']}")
        for parts in (1, 2, 3, 7):
            ends = [0] + sorted(draws.sample(range(1, 400), parts - 1)) + [400]
            for k in range(parts):
                part(folder, f"p{k}", 11 + ends[k], ends[k + 1] - ends[k], f"--threads {1 + k % 3}", real)
            names = [f"p{k}.csv" for k in range(parts)]
            draws.shuffle(names)
            done(f"merge {' '.join(names)} --csv all.csv --json all.json --quiet", folder, real)
            claim((read(folder, "all.csv"), read(folder, "all.json")) == want, f"{real}: {parts} parts cut at {ends}")
            said = done(f"merge {' '.join(n.replace('csv', 'json') for n in names)}", folder, real)
            claim(f"digest {report['digest']}" in said and "seed 1, first 11" in said, f"reports alone: {said!r}")
        part(folder, "p0", 11, 100, real=real)
        part(folder, "p1", 111, 100, real=real)
        part(folder, "p2", 211, 200, real=real)
        done("merge p0.csv p1.csv --csv left.csv --json left.json --quiet", folder, real)
        done("merge left.csv p2.csv --csv=all.csv --json=all.json --quiet", folder, real)
        claim((read(folder, "all.csv"), read(folder, "all.json")) == want, f"{real}: merged twice")
        claim(done("merge p2.csv p0.csv p1.csv --csv -", folder, real).encode() == want[0], f"{real}: to stdout")


def edits(folder, report):
    """Any byte of a report to another; counts that could be, with a right CRC, which the lines contradict."""
    for at, old in enumerate(report):
        if old in b"0123456789abcdef":
            put(folder, "b.json", report[:at] + (b"1" if old == ord("0") else b"0") + report[at + 1:])
            if kelly("merge b.json", folder).returncode != 2:
                claim(False, f"byte {at} of a report changed, {report[at - 30:at + 1]}: accepted")
    for bad in (report.replace(b'"digest": "', b'"digest": "0')[:-1], re.sub(rb'  "crc32c": .*\n', b"", report).replace(b",\n}", b"\n}"), report + b"\n",
                report.replace(b'"seconds": ', b'"seconds":  ')):
        put(folder, "b.json", bad)
        refused("merge a.json b.json c.json", folder, "b.json", "crc32c")
    counts = json.loads(report)
    for old, new, word in ((rb'"stuck": \d+', b'"stuck": %d' % (counts["stuck"] - 1), "stuck"), (rb'"liftoff": \d+', b'"liftoff": %d' % (counts["liftoff"] + 1), "liftoff"),
                           (rb'"step": \d+, "range": \d+', b'"step": %d, "range": %d' % (counts["refused_by"]["step"] + 1, counts["refused_by"]["range"] - 1), "refused_by.")):
        bad = re.sub(old, new, report, count=1)
        put(folder, "b.json", bad)
        refused("merge a.csv b.csv c.csv --csv x.csv", folder, "b.json", "crc32c")
        put(folder, "b.json", sealed(bad))
        done("merge a.json b.json c.json --quiet", folder)
        refused("merge a.csv b.csv c.csv --csv x.csv", folder, "b.json", f'"{word}', "not what the lines of b.csv say")
    put(folder, "b.json", report)


def check_misfits(folder):
    """Gaps, overlaps, foreign runs, changed and missing files."""
    part(folder, "a", 0, 50)
    part(folder, "b", 50, 30)
    part(folder, "c", 80, 20)
    refused("merge a.csv c.csv --csv x.csv", folder, "gap", "a.csv", "c.csv", "50..79")
    refused("merge a.csv b.csv a.csv", folder, "overlap", "0..49")
    part(folder, "over", 40, 30)
    refused("merge over.csv a.csv --json x.json", folder, "overlap", "a.csv and over.csv", "40..49")
    part(folder, "in", 10, 5)
    refused("merge in.csv a.csv", folder, "overlap", "10..14")
    for more, words in (("--seed 2", ("seed 2", "1")), ("--mu 0.021", ("mu 0.0209", "0.0199")), ("--rpm 101", ("rpm 101", "99.99")), ("--wob 501", ("wob_kN 501",)),
                        ("--f0 301", ("f0_kN 301",)), ("--alpha1 3", ("alpha1 3", "2")), ("--alpha2 3", ("alpha2 3",)), ("--limit 0.7", ("limit 0.69", "0.8")),
                        ("--cov 0.4", ("cov.fc 0.4",)), ("--cov fc=0.45,mu=0.45,a1=0.45,a2=0.45", ("cov.rpm 0", "0.449")), ("--start rotating", ("rotating", "rest")),
                        ("--duration 5 --window 2:4", ("duration_s 5", "4")), ("--window 1:4", ("window_s 1", "2")), ("--step 0.0005", ("step_s 0.0005",)),
                        ("--torsional 6", ("torsional 6", "5")),
                        ("--drive soft", ("drive soft", "stiff"))):
        part(folder, "foreign", 50, 5, more)
        refused("merge a.csv foreign.csv", folder, "foreign.csv", "of another run", *words)
    shutil.copy(os.path.join(folder, "foreign.json"), os.path.join(folder, "stale.json"))      # of a run before, of another case
    shutil.copy(os.path.join(folder, "b.csv"), os.path.join(folder, "stale.csv"))
    for both in ("a.csv stale.csv", "stale.csv a.csv"):
        refused(f"merge {both}", folder, "stale.csv", "not the file that stale.json is of")
    for csv, report, parts in (("b", "a", "a.csv stale.csv"), ("b", "a", "stale.csv a.csv"), ("c", "a", "b.csv stale.csv"), ("a", "c", "stale.csv b.csv")):   # of another range
        shutil.copy(os.path.join(folder, f"{report}.json"), os.path.join(folder, "stale.json"))
        shutil.copy(os.path.join(folder, f"{csv}.csv"), os.path.join(folder, "stale.csv"))
        refused(f"merge {parts}", folder, "stale.csv", "not the file that stale.json is of")
    for ends in ("--mu 1e-9 --rpm 10000 --alpha1 1e-9", "--alpha2 1e-9 --rpm 0.001 --limit 10"):        # which a float rounds
        part(folder, "ends", 0, 5, ends)
        done("merge ends.csv --quiet", folder)
    part(folder, "foreign", 50, 5, real="double")
    refused("merge a.csv foreign.csv", folder, "double", "float")
    shutil.copy(os.path.join(folder, "foreign.json"), os.path.join(folder, "stale.json"))      # of another precision, alone
    refused("merge stale.csv", folder, "stale.csv", "not the file that stale.json is of")
    part(folder, "base", 0, 50, real="double")
    part(folder, "foreign", 50, 5, "--mu 0.0200000000001", real="double")
    refused("merge base.csv foreign.csv", folder, "foreign.csv", "of another run", real="double")
    text = read(folder, "b.csv")
    for bad in (text[:-1], text.replace(b",ok,", b",OK,", 1), text + text.splitlines(True)[-1], b"", text.replace(b"0", b"1", 1)):
        with open(os.path.join(folder, "b.csv"), "wb") as file:
            file.write(bad)
        refused("merge a.csv b.csv c.csv --csv x.csv --json x.json", folder, "b.csv", "not the file that b.json is of")
    with open(os.path.join(folder, "b.csv"), "wb") as file:
        file.write(text)
    report = bytes_of(folder, "b.json")
    claim(sealed(report) == report, "the report ends with the CRC-32C of all before it")
    edits(folder, report)
    part(folder, "until", 50, 300, "--until-width 0.5")
    refused("merge a.csv until.csv", folder, "stopped itself")
    for bad in (b"", b"{", b"[1]", report[:-3], report.replace(b'"samples": 30', b'"samples": 0'), report.replace(b'"digest"', b'"digset"'),
                report.replace(b'"samples": 30', b'"samples": 30.5'), report.replace(b'"first": 50', b'"first": -1'), b"{" * 100000, report + b"\0x"):
        put(folder, "b.json", sealed(bad) if b"crc32c" in bad and bad[-1:] == b"\n" else bad)
        refused("merge a.csv b.csv c.csv --csv x.csv", folder, "b.json")
    claim(b'"range"]' in report, "b has refused ones")
    for key, value in (("stuck", 31), ("refused", 31), ("refused", 0), ("liftoff", 31), ("step", 1000), ("nonfinite", 1), ("refused_first", [])):
        bad = re.sub(rb'"%s": ([0-9]+|\[\[.*\]\])' % key.encode(), b'"%s": %s' % (key.encode(), str(value).encode()), report, count=1)
        put(folder, "b.json", sealed(bad))   # the first of that name; of ssi's, which comes later, below
        refused("merge a.json b.json c.json", folder, "b.json", '"' + key.replace("step", "refused_by.step").replace("nonfinite", "refused"))
    for key, value in (("window_s", [1e300, 4]), ("window_s", [-1, 4]), ("window_s", [4, 2]), ("window_s", [2, 2]), ("window_s", [2, 5]), ("duration_s", 1e30),
                       ("duration_s", 1e9), ("duration_s", -1),
                       ("duration_s", 3.99951), ("window_s", [2.0003, 4]), ("step_s", 0.0010000001), ("torsional", 5.7), ("start", '"banana"')):
        bad = re.sub(rb'"%s": ([0-9.]+|"\w+"|\[.*?\])' % key.encode(), b'"%s": %s' % (key.encode(), str(value).encode()), report, count=1)
        put(folder, "b.json", sealed(bad))
        refused("merge b.json", folder, "b.json", f'"case.{key}"')
    for values in ((1234567.891, [1234567.89, 1234567.891]), (4e6, [3999999.998, 4e6])):     # a narrow window late in a long run is one
        bad = report
        for key, value in zip(("duration_s", "window_s"), values):
            bad = re.sub(rb'"%s": ([0-9.]+|\[.*?\])' % key.encode(), b'"%s": %s' % (key.encode(), str(value).encode()), bad, count=1)
        put(folder, "b.json", sealed(bad))
        done("merge b.json --quiet", folder)
    put(folder, "b.json", report)
    for key, value, word in (("seed", "1.5", '"seed"'), ("seed", "1e0", '"seed"'), ("real", '"banana"', '"real"'), ("samples", "30null", "no JSON"), ("samples", "+30", "no JSON"),
                             ("samples", "030", "no JSON"), ("samples", "30.", "no JSON"), ("samples", "nul", "no JSON"), ("seconds", "1e", "no JSON")):
        bad = re.sub(rb'"%s": ([0-9.]+|"\w+")' % key.encode(), b'"%s": %s' % (key.encode(), value.encode()), report, count=1)
        put(folder, "b.json", sealed(bad))
        refused("merge b.json", folder, "b.json", word)
    for old, new in ((rb'("ssi": .*"stuck": )[0-9]+', rb"\g<1>31"), (rb'(refused_first": \[\[)[0-9]+', rb"\g<1>7"), (b'"range"\\]', b'"ok"]')):
        put(folder, "b.json", sealed(re.sub(old, new, report, count=1)))
        refused("merge a.json b.json c.json", folder, "b.json")
    put(folder, "b.json", sealed(re.sub(rb'"csv_crc32c": "[0-9a-f]*",', b"", report)))
    refused("merge a.csv b.csv", folder, "without --csv")
    os.remove(os.path.join(folder, "b.json"))
    refused("merge a.csv b.csv", folder, "b.json is not beside it")
    for name in ("nothing.csv", "nothing.json"):
        refused(f"merge a.csv {name}", folder, f"{name}: there is no such file")
    shutil.copy(os.path.join(folder, "c.csv"), os.path.join(folder, "c.csv.journal"))
    refused("merge c.csv", folder, "not finished", "--resume")
    os.remove(os.path.join(folder, "c.csv.journal"))
    os.rename(os.path.join(folder, "c.csv"), os.path.join(folder, "gone.csv"))
    refused("merge c.csv", folder, "c.csv: there is no such file")
    os.mkdir(os.path.join(folder, "c.csv"))
    refused("merge c.csv", folder, "c.csv: a directory")
    for args in ("merge", "merge --json x.json", "merge a.txt", "merge .csv", "merge a.csv --csv", "merge a.json --csv x.csv", "merge a.csv --seed 1",
                 "merge a.csv --csv x --json x", "merge a.csv --threads 2"):
        refused(args, folder)
    for out in ("--csv a.csv --json a.json", "--csv x.csv --json a.json", "--csv ./a.csv", "--json a.csv", "--json a.json"):
        before = read(folder, "a.csv"), read(folder, "a.json")
        refused("merge a.csv " + out, folder, "is read here")
        claim((read(folder, "a.csv"), read(folder, "a.json")) == before, f"merge a.csv {out}: the part stays as it is")
    refused("merge a.json --json a.json", folder, "is read here")
    refused("merge a.csv --csv x --json x.part", folder, "give each its own")
    refused("merge a.csv --csv nowhere/x.csv", folder, "cannot write", status=1)


def check_array(folder):
    """The example: an array of jobs, one of them killed and started again, gives one run's files."""
    part(folder, "one", 0, 103)
    env = dict(os.environ, KELLY=PROGRAM["float"])
    script = os.path.join(ROOT, "host/examples/array.sh")
    for parts in (1, 4, 103):
        run = subprocess.run(["sh", script, f"run{parts}", "103", str(parts)] + shlex.split(CASE), cwd=folder, env=env, capture_output=True, text=True, check=False)
        claim(run.returncode == 0 and read(folder, f"run{parts}.csv") == read(folder, "one.csv") and read(folder, f"run{parts}.json") == read(folder, "one.json"),
              f"array of {parts}: {run.stderr!r}")
    for name in ("run4.2.csv", "run4.csv"):
        os.remove(os.path.join(folder, name))
    run = subprocess.run(["sh", script, "run4", "103", "4"] + shlex.split(CASE), cwd=folder, env=env, capture_output=True, text=True, check=False)
    claim(run.returncode == 0 and read(folder, "run4.csv") == read(folder, "one.csv"), f"a part again: {run.stderr!r}")
    claim(subprocess.run(["sh", script], capture_output=True, check=False).returncode == 2, "usage")
    before = {name: bytes_of(folder, name) for name in os.listdir(folder)}
    for args, word in (("run4 103 5 " + CASE, "run4.study"), ("run4 104 4 " + CASE, "run4.study"), ("run4 103 4 " + CASE.replace("0.02", "0.021"), "run4.study"),
                       ("run4 103 4 --seed 2 " + CASE, "103 samples in 4 parts --mu 0.02"), ("x 1e3 4", "SAMPLES '1e3'"), ("x 103 0", "PARTS '0'"), ("x 0 4", "SAMPLES"),
                       ("x 103 4.5", "PARTS"), ("x -1 4", "SAMPLES"), ("x '' 4", "SAMPLES"), ("x 103 four", "PARTS"), ("x 010 4", "SAMPLES"), ("x 99999999999999999999 1", "SAMPLES")):
        run = subprocess.run(["sh", script] + shlex.split(args), cwd=folder, env=env, capture_output=True, text=True, check=False)
        claim(run.returncode == 2 and run.stderr.startswith("array.sh: ") and run.stderr.count("\n") == 1 and word in run.stderr, f"array.sh {args}: exit {run.returncode}, {run.stderr!r}")
        claim({name: bytes_of(folder, name) for name in os.listdir(folder)} == before, f"array.sh {args}: leaves {set(os.listdir(folder)) - set(before)}")
    for name in ("old.3.csv", "old.2.csv.journal"):   # parts of nobody knows what
        with open(os.path.join(folder, name), "w", encoding="ascii") as left:
            left.write("x")
        run = subprocess.run(["sh", script, "old", "103", "4"] + shlex.split(CASE), cwd=folder, env=env, capture_output=True, text=True, check=False)
        claim(run.returncode == 2 and f"array.sh: {name}: " in run.stderr and not os.path.exists(os.path.join(folder, "old.study")), f"{name} left by an unknown study: {run.stderr!r}")
        os.remove(os.path.join(folder, name))
    for args, status, words in (("wrong 9 3 --mu nonsense", 2, "--mu nonsense: not a finite number"), ("nothing 9 3 --step 0.02 --duration 2", 1, "none of 9 realisations")):
        run = subprocess.run(["sh", script] + shlex.split(args), cwd=folder, env=env, capture_output=True, text=True, check=False)
        claim(run.returncode == status and words in run.stderr, f"array.sh {args}: exit {run.returncode}, {run.stderr!r}")
    claim(not os.path.exists(os.path.join(folder, "wrong.study")), "a study that was refused leaves nothing")
    claim(os.path.exists(os.path.join(folder, "nothing.json")), "parts without an answer are put together")
    spaced = os.path.join(folder, "two words *")
    os.mkdir(spaced)
    for again in (False, True):
        run = subprocess.run(["sh", script, f"{spaced}/run", "103", "4"] + shlex.split(CASE), env=env, capture_output=True, text=True, check=False)
        claim(run.returncode == 0 and read(spaced, "run.csv") == read(folder, "one.csv"), f"a directory with a space, again: {again}: {run.stderr!r}")


def main():
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    args = chosen(parser)
    for name in args.names or [n[6:] for n in globals() if n.startswith("check_")]:
        with tempfile.TemporaryDirectory() as folder:
            globals()["check_" + name](folder)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
