#!/usr/bin/env python3
"""check_rare - kelly rare against plain Monte Carlo and reference probabilities from 1 to 2e-8, equal bits, refusals.

usage: tests/check_rare.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...] [--study [--seeds 20] [--from 1] [--step 0.002] [--workers 2] [--only NAME...]]

The gate takes steps of 4 ms: 8000 realisations of the case at 210 rpm are classified as at 1 ms, one and all. --study: every case of CASES with
seeds 1 .. 20, and of MORE with 1 .. 10, at 2 ms, into build/study-rare.md and .json; its claims are those on mean, spread and coverage.
Prints a line for each claim that fails, then `N passed, N failed`.
"""
import concurrent.futures
import json
import math
import os
import re
import statistics
import subprocess
import sys

sys.dont_write_bytecode = True
from map_tools import PROGRAM, claim, count, kelly, montecarlo, refused  # noqa: E402  pylint: disable=wrong-import-position
from programs import ROOT, chosen, command_line  # noqa: E402  pylint: disable=wrong-import-position

OTHER = "gen/wells/slim-4000ft.toml"
MC_SEED = 1000003                # of plain Monte Carlo, another one than any of rare's
COARSE = "--step 0.004"
MOST = 20000                     # realisations of a run

# name: (arguments, reference P, or 0: from `plain` realisations of Monte Carlo, plain). 100 s, window 50:100, from rest.
# The references: 1e6 plain realisations (9.88e-3, 7.3e-4), long runs of another implementation (the rest).
CASES = {
    "mu 0.004, 210 rpm, cov 0.2": ("--mu 0.004 --rpm 210 --cov 0.2", 9.88e-3, 20000),
    "mu 0.004, 170 rpm, cov 0.1": ("--mu 0.004 --rpm 170 --cov 0.1", 7.3e-4, 0),
    "mu 0.002, 120 rpm, cov 0.1": ("--mu 0.002 --rpm 120 --cov 0.1", 8.8e-5, 0),
    "mu 0.004, 200 rpm, cov 0.1": ("--mu 0.004 --rpm 200 --cov 0.1", 1.03e-5, 0),
    "mu 0.004, 240 rpm, cov 0.1": ("--mu 0.004 --rpm 240 --cov 0.1", 2.19e-8, 0),
}
MORE = {
    "unequal laws": ("--mu 0.004 --rpm 170 --cov fc=0.05,mu=0.2,a1=0.1,rpm=0.15", 0, 60000),
    "rotating start": ("--mu 0.004 --rpm 150 --cov 0.2 --start rotating", 0, 60000),
    "soft drive": ("--mu 0.004 --rpm 180 --cov 0.2 --drive soft", 0, 60000),
    "slim-4000ft": ("--mu 0.004 --rpm 300 --cov 0.2", 0, 60000),
    "about 1e-6": ("--mu 0.004 --rpm 215 --cov 0.1", 0, 0),
}


def program(name):
    return "other" if name == "slim-4000ft" else "float"


def rare(args, real="float"):
    """The JSON of a run and its status; without an answer the JSON is there all the same."""
    done = kelly(f"rare {args} --quiet --json -", real)
    return json.loads(done.stdout) if done.stdout else {"error": done.stderr}, done.returncode


def build_other():
    subprocess.run(["make", "-s", f"WELL={OTHER}"], cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
    PROGRAM["other"] = os.path.join(ROOT, "build", "host-" + os.path.basename(OTHER)[:-5], "kelly")


def plain(args, samples, real="float"):
    out = montecarlo(f"{args} --samples {samples} --seed {MC_SEED}", real)
    return out["probability"], *out["ci95"]


class Runs:
    """Some seeds of one case."""

    def __init__(self, name, args, seeds, pool=None):
        jobs = [f"{args} --seed {s}" + (" --threads 1" if pool else "") for s in seeds]
        self.name = name
        self.all = [out for out, _ in (pool.map if pool else map)(lambda job: rare(job, program(name)), jobs)]
        self.good = [r for r in self.all if r.get("probability") is not None]
        self.p = [r["probability"] for r in self.good]
        claim(len(self.good) == len(self.all), f"{name}: refused {[r.get('reason') or r.get('error') for r in self.all if r not in self.good]}")
        claim(max(r["realisations"] for r in self.all) <= MOST, f"{name}: more than {MOST} realisations")

    def mean(self):
        return statistics.fmean(self.p)

    def spread(self):
        return statistics.stdev(self.p) / self.mean()

    def hold(self, lo, hi):
        """Runs whose interval has something of lo..hi."""
        return sum(r["ci95"][0] <= hi and lo <= r["ci95"][1] for r in self.good)


# ---- the gate

def check_plain_level():
    """P = 1 and 0.5: the first level is enough, and is montecarlo of the same seed, to the digest."""
    for args in ("--mu 0.04", "--mu 0.004"):
        both = f"{args} --cov 0.2 --seed 7 {COARSE if args != '--mu 0.04' else '--step 0.001'}"
        out, status = rare(both)
        mc = montecarlo(f"{both} --samples 2400")
        claim(status == 0 and out["method"] == "Monte Carlo" and out["levels"] == 1 and out["realisations"] == 2400, f"{args}: {out}")
        for key in ("digest", "probability", "ci95", "refused", "refused_by", "refused_first", "case"):
            claim(out[key] == mc[key], f"{args}: {key} {out[key]}, montecarlo {mc[key]}")


def check_against_plain(name, args, seeds, samples):
    """Mean within four standard errors of Monte Carlo's, nine in ten intervals overlap with its own."""
    p, lo, hi = plain(args, samples, program(name))
    runs = Runs(name, args, seeds)
    error = math.hypot(runs.mean() * statistics.fmean(r["cov"] for r in runs.good) / len(seeds) ** 0.5, (p / samples) ** 0.5)
    claim(1e-3 < p < 2e-2, f"{name}: P {p} is rare, and Monte Carlo can see it")
    claim(abs(runs.mean() - p) < 4 * error, f"{name}: mean {runs.mean():.3g}, Monte Carlo {p:.3g}, standard error {error:.2g}")
    claim(runs.hold(lo, hi) >= 0.9 * len(seeds), f"{name}: {runs.hold(lo, hi)} of {len(seeds)} intervals overlap with {lo:.3g} .. {hi:.3g}")
    return runs


def check_reference_cases():
    """A seed a case: within four of its own standard deviations, with what a run must say of itself."""
    for name, (args, reference, _) in list(CASES.items())[1:]:
        out = Runs(name, f"{args} {COARSE}", [1]).all[0]
        if not claim(out.get("probability"), f"{name}: an answer"):
            continue
        claim(abs(math.log(out["probability"] / reference)) < 4 * out["cov"], f"{name}: P {out['probability']:.3g} of {reference:.3g}")
        claim(out["ci95"][0] < out["probability"] < out["ci95"][1], f"{name}: interval {out['ci95']}")
        claim(out["realisations"] == 2400 + 2160 * (out["levels"] - 1) + out["look"]["tried"], f"{name}: {out['levels']} levels of {out['realisations']}")
        claim(len(out["acceptance"]) == out["levels"] - 1 and min(out["acceptance"]) > 0.3, f"{name}: acceptance {out['acceptance']}")
        claim(min(out["acceptance_led"]) > 0.35, f"{name}: the hint leads well: {out['acceptance_led']}")
        rpm = out["failures"]["rpm"]
        claim(rpm["mean"] < out["case"]["rpm"] and rpm["quantiles"]["0.025"] < rpm["mean"] < rpm["quantiles"]["0.975"], f"{name}: {rpm}")
        claim(all(0 < r["share"] <= 1 and 0 < r["rpm"] < 1000 for r in out["failures"]["resonances"]), f"{name}: {out['failures']}")


def check_same_bits():
    """Threads and vector units change nothing."""
    deep = "--mu 0.004 --rpm 150 --cov 0.2 --duration 20 --window 10:20 --start rotating --samples-per-level 1000 --step 0.002"
    runs = [rare(f"{deep} {more}")[0] for more in ("", "--threads 3", "--engine scalar", "--engine sse2 --threads 2")]
    for out in runs[1:]:
        for key in runs[0]:
            claim(key in ("engine", "seconds") or out[key] == runs[0][key], f"{key}: {out[key]} instead of {runs[0][key]}")
    claim(runs[0]["levels"] > 2, f"deep enough to tell: {runs[0]['levels']}")
    claim(rare(f"{deep} --seed 2")[0]["digest"] != runs[0]["digest"], "another seed, another run")


def check_not_random():
    """A parameter that is not random is none that the failures tell of; the others move."""
    args = f"--mu 0.004 --rpm 200 --cov mu=0.2,rpm=0.2 --samples-per-level 1200 {COARSE}"
    out, status = rare(args)
    if claim(status == 0, f"two laws: {out.get('reason')}"):
        places = out["failures"]
        claim(set(places) == {"mu", "rpm", "resonances", "count", "distinct", "finds"}, f"weight, alpha1 and alpha2 are not random: {places}")
        claim(places["mu"]["sd"] > 1e-5 and places["rpm"]["sd"] > 0.1, f"mu and rpm random: {places}")
        said = re.findall(r"^(\w+) .* 95 % of them", kelly(f"rare {args}").stdout, re.M)
        claim(said == ["mu", "rpm"], f"the summary tells of the same: {said}")


def check_refusals():
    """Each with its reason, exit 1 and a JSON without a probability."""
    short = "--duration 20 --window 10:20 --start rotating --samples-per-level 1000"
    for args, reason in ((f"--mu 0.004 --rpm 240 --cov 0.05 {short}", "1e-9"),
                         (f"--mu 0.004 --rpm 200 --limit 10 {short}", "no failure"),
                         ("--mu 0.002 --rpm 165 --cov rpm=0.04 --limit 0.155 --step 0.002", "has anyway"),   # P is 1.7e-5, the search sees a third
                         (f"--wob 850 --mu 0.0002 --rpm 240 --cov 0.1 --limit 3 {short}", "a --wob, or a --cov fc=, whose draws lie there"),
                         (f"--wob 20000 --cov 0.1 {short}", "fitted for weights of 1..1000 kN; give such a --wob"),
                         (f"--mu 0.04 --rpm 700 --step 0.002 --cov 0.2 {short}", "may be failures: the step is too long for ")):
        out, status = rare(args)
        claim(status == 1 and out.get("probability", 0) is None and out["ci95"] is None, f"{args}: status {status}, {out}")
        claim(reason in str(out.get("reason")), f"{args}: reason {out.get('reason')}")
        done = kelly(f"rare {args}")
        claim(done.returncode == 1 and reason in done.stderr and done.stderr.count("\n") == 1 and "P(stick" not in done.stdout, f"{args}: {done}")
    claim(sum(out["refused_by_level"]) == out["refused"] == sum(out["refused_by"].values()) > 0, f"refused: {out['refused']}, {out['refused_by_level']}")
    claim(len(out["refused_first"]) == min(out["refused"], 100) and "refused: " in done.stdout, "the refused by their index")


def check_two_places():
    """Failures on both sides of the mean speed, at 96 and, at a resonance, at 132 rpm: P is 8.7e-5 by 150 000 plain realisations, and the search
    alone sees 6e-7. And a lucky sample of an early level, which stands for 64 times the 6.5e-6 of the second case. No seed may answer."""
    for args, seeds in (("--mu 0.004 --f0 95 --rpm 116 --cov rpm=0.035", range(1, 4)), ("--mu 0.004 --f0 95 --rpm 116 --cov rpm=0.03", range(1, 4)),
                        ("--mu 0.004 --f0 90 --rpm 114 --cov rpm=0.035", range(1, 2))):
        for seed in seeds:
            out, status = rare(f"{args} --seed {seed} --step 0.002")
            claim(status == 1 and out["probability"] is None and ("more than one place" in out["reason"] or "few finds" in out["reason"]),
                  f"{args}, seed {seed}: {out.get('probability')}, {out.get('reason')}")
            claim("few finds" in str(out["reason"]) or out["look"]["failed"] > 0, f"{args}, seed {seed}: {out['look']}")


def check_bad_usage():
    for args, word in (("--cov 0", "nothing is random"), ("--samples-per-level 2001", "multiple of 40"), ("--samples-per-level 960", "1000"),
                       ("--samples-per-level x", "not a whole number"), ("--samples 100", "--samples"), ("--first 3", "--first"), ("--csv x.csv", "--csv"),
                       ("--convergence", "--convergence"), ("--nonsense 1", "--nonsense"), ("--limit 11", "--limit 11"), ("--cov 0.6", "--cov 0.6")):
        refused(f"rare {args}", word)
    refused("rare --json /nowhere/x --duration 1", "cannot write", status=1)


def gate(names):
    for name in names or ("bad_usage", "plain_level", "same_bits", "not_random", "refusals", "two_places", "reference_cases"):
        globals()["check_" + name]()
    if names:
        return
    build_other()
    name, args = "P about 1e-2", CASES["mu 0.004, 210 rpm, cov 0.2"][0]
    check_against_plain(name, f"{args} {COARSE}", range(1, 21), 20000)
    for name, (args, _, samples) in MORE.items():
        if samples:
            check_against_plain(name, f"{args} {COARSE}", range(1, 5), 20000)


# ---- the study

HEAD = """Seeds {first} .. {last}, of the last five cases the first half of them; steps of {step} s, 100 s, window 50:100, limit 0.8, 2400 samples a
level. Spread: standard deviation over mean of the estimates; cov: what a run says of itself, on average. Plain: realisations of plain Monte Carlo for the same spread; gain: over those of a run.

| case | reference | mean | ratio | spread | cov | covered | levels | realisations | acceptance | refused | plain | gain |
|---|---|---|---|---|---|---|---|---|---|---|---|---|
"""


def study_case(name, args, seeds, pool):
    flags, reference, samples = CASES.get(name) or MORE[name]
    flags += f" --step {args.step}"
    mc = plain(flags, samples, program(name)) if samples else None
    reference = reference or (mc[0] if mc else None)
    runs = Runs(name, flags, seeds, pool)
    row = {"case": name, "flags": flags, "reference": reference, "monte_carlo": mc, "seeds": [seeds[0], seeds[-1]], "estimates": runs.p, "mean": runs.mean(),
           "spread": runs.spread(), "cov": statistics.fmean(r["cov"] for r in runs.good), "levels": [f(r["levels"] for r in runs.good) for f in (min, max)],
           "realisations": statistics.fmean(r["realisations"] for r in runs.good), "refused": sum(r["refused"] for r in runs.all),
           "acceptance": [f(a for r in runs.good for a in r["acceptance"]) for f in (min, max)]}
    row["plain"] = (1 - row["mean"]) / (row["mean"] * row["spread"] ** 2)
    row["gain"] = row["plain"] / row["realisations"]
    if reference:
        row["ratio"], row["covered"] = row["mean"] / reference, runs.hold(reference, reference)
        slack = 0.1 if name in CASES else 0.1 + 2 * (1 / (reference * samples)) ** 0.5
        claim(abs(row["ratio"] - 1) < slack, f"{name}: mean {row['mean']:.3g} of {reference:.3g}, ratio {row['ratio']:.3f}")
        claim(row["covered"] >= 0.9 * len(seeds), f"{name}: {row['covered']} of {len(seeds)} intervals hold {reference:.3g}")
    if mc:
        claim(runs.hold(mc[1], mc[2]) >= 0.95 * len(seeds), f"{name}: {runs.hold(mc[1], mc[2])} intervals overlap with {mc[1]:.3g} .. {mc[2]:.3g}")
    claim(row["spread"] <= 0.35, f"{name}: coefficient of variation {row['spread']:.2f}")
    return row


def as_line(row):
    ratio, covered = (f"{row['ratio']:.3f}", f"{row['covered']}/{len(row['estimates'])}") if row["reference"] else ("", "")
    return (f"| {row['case']} | {format(row['reference'], '.3g') if row['reference'] else ''} | {row['mean']:.3g} | {ratio} | {row['spread']:.2f} | "
            f"{row['cov']:.2f} | {covered} | {row['levels'][0]}-{row['levels'][1]} | {row['realisations']:.0f} | "
            f"{row['acceptance'][0]:.2f}-{row['acceptance'][1]:.2f} | {row['refused']} | {row['plain']:.3g} | {row['gain']:.3g} |\n")


def study(args):
    names = [n for n in (*CASES, *MORE) if not args.only or n in args.only]
    seeds, rows = range(args.first, args.first + args.seeds), []
    path = os.path.join(ROOT, "build", "study-rare")
    if "slim-4000ft" in names:
        build_other()
    with concurrent.futures.ThreadPoolExecutor(args.workers) as pool:
        for name in names:
            rows.append(study_case(name, args, seeds if name in CASES else seeds[:(len(seeds) + 1) // 2], pool))
            print(as_line(rows[-1]), end="", flush=True)
            with open(path + ".md", "w", encoding="utf-8") as file:
                file.write(HEAD.format(first=seeds[0], last=seeds[-1], step=args.step) + "".join(as_line(row) for row in rows))
            with open(path + ".json", "w", encoding="utf-8") as file:
                json.dump(rows, file, indent=1)


def main():
    parser = command_line(__doc__)
    parser.add_argument("--study", action="store_true")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--from", dest="first", type=int, default=1)
    parser.add_argument("--step", default="0.002", help="of the study [s]")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", nargs="*")
    parser.add_argument("names", nargs="*")
    args = chosen(parser)
    if args.study:
        study(args)
    else:
        gate(args.names)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
