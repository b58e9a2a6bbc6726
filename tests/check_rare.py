#!/usr/bin/env python3
"""Claims about `kelly rare`: reference probabilities from 1 to 2e-8, equal results at any number of threads and lanes, refusals.

usage: tests/check_rare.py [--kelly build/host/kelly] [--study [--seeds 20] [--from 1] [--workers 2] [--only NAME...]]

Without --study: a seed or two a case, about a minute. --study: every case with 20 seeds (20 minutes and more), its claims are
those on mean, spread and coverage, and build/rare.md gets the figures. Prints a line for each claim that fails, then
`N passed, N failed`.
"""
import argparse
import concurrent.futures
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
KELLY = os.path.join(ROOT, "build", "host", "kelly")
OTHER = os.path.join(ROOT, "build", "host-slim-4000ft", "kelly")
count = {True: 0, False: 0}

# name: (arguments, reference P or 0: from `plain` realisations of Monte Carlo, plain, reference string)
# The references stand on 1e6 plain realisations or long runs of another implementation; all laws at one coefficient of variation
# unless said, 100 s, window 50:100.
SOFT = ["--mu", "0.004"]
CASES = {
    "hard rock, P = 1": (["--mu", "0.04", "--cov", "0.2"], 0, 4000),
    "soft rock, P = 0.5": ([*SOFT, "--cov", "0.2"], 0, 4000),
    "210 rpm, cov 0.2": ([*SOFT, "--rpm", "210", "--cov", "0.2"], 9.88e-3, 20000),
    "170 rpm, cov 0.1": ([*SOFT, "--rpm", "170", "--cov", "0.1"], 7.3e-4, 0),
    "mu 0.002, 120 rpm": (["--mu", "0.002", "--rpm", "120", "--cov", "0.1"], 8.8e-5, 0),
    "200 rpm, cov 0.1": ([*SOFT, "--rpm", "200", "--cov", "0.1"], 1.03e-5, 0),
    "240 rpm, cov 0.1": ([*SOFT, "--rpm", "240", "--cov", "0.1"], 2.19e-8, 0),
    "unequal laws": ([*SOFT, "--rpm", "170", "--cov", "fc=0.05,mu=0.2,a1=0.1,rpm=0.15"], 0, 60000),
    "rotating": ([*SOFT, "--rpm", "150", "--cov", "0.2", "--start", "rotating"], 0, 60000),
    "hard rock, fast": (["--mu", "0.04", "--rpm", "560", "--cov", "0.1"], 0, 60000),
    "slim-4000ft": ([*SOFT, "--rpm", "210", "--cov", "0.1"], 0, 60000),
}


def claim(holds, text):
    count[bool(holds)] += 1
    if not holds:
        print("FAILED: " + text, flush=True)


def run(*arguments, kelly=None):
    return subprocess.run([kelly or KELLY, *map(str, arguments)], capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL)


def result(*arguments, kelly=None):
    """The JSON of a run, and its status."""
    with tempfile.TemporaryDirectory() as where:
        path = os.path.join(where, "out.json")
        done = run(*arguments, "--json", path, "--quiet", kelly=kelly)
        if not os.path.exists(path):
            return {"error": done.stderr}, done.returncode
        with open(path, encoding="utf-8") as file:
            return json.load(file), done.returncode


def program(name):
    return OTHER if name.startswith("slim") else KELLY


def rare(name, seed, threads=1):
    return result("rare", *CASES[name][0], "--seed", seed, "--threads", threads, kelly=program(name))[0]


def plain(name):
    """(P, lo, hi) of Monte Carlo with another seed."""
    out, _ = result("montecarlo", *CASES[name][0], "--samples", CASES[name][2], "--seed", 1000003, kelly=program(name))
    return out["probability"], *out["ci95"]


# ---- quick

def reference_cases():
    """One seed a case: within four of its own standard deviations, with fewer than 2e4 realisations."""
    for name in ("210 rpm, cov 0.2", "170 rpm, cov 0.1", "200 rpm, cov 0.1", "240 rpm, cov 0.1"):
        out, reference = rare(name, 1, threads=os.cpu_count()), CASES[name][1]
        claim(out.get("probability"), f"{name}: an answer ({out.get('reason') or out.get('error')})")
        if out.get("probability"):
            claim(abs(math.log(out["probability"] / reference)) < 4 * out["cov"], f"{name}: P {out['probability']:.3g} of {reference:.3g}")
            claim(out["ci95"][0] < out["probability"] < out["ci95"][1], f"{name}: interval {out['ci95']}")
            claim(out["realisations"] <= 20000, f"{name}: {out['realisations']} realisations")
            claim(0.3 < min(out["acceptance"]) and max(out["acceptance"]) < 0.6, f"{name}: acceptance {out['acceptance']}")
            claim(out["realisations"] == 2400 + 2160 * (out["levels"] - 1), f"{name}: {out['levels']} levels of {out['realisations']}")
            rpm = out["failures"]["rpm"]
            claim(rpm["mean"] < out["case"]["rpm"] and rpm["quantiles"]["0.025"] < rpm["mean"] < rpm["quantiles"]["0.975"],
                  f"{name}: failures lie at lower speeds: {rpm}")


SHORT = ["--duration", "20", "--window", "10:20"]


def plain_level():
    """Where the first level suffices it is montecarlo of the same seed, to the digest."""
    for arguments in (["--mu", "0.04"], SOFT):
        both = [*arguments, *SHORT, "--cov", "0.2", "--seed", 7]
        out, _ = result("rare", *both, "--samples-per-level", 400)
        mc, _ = result("montecarlo", *both, "--samples", 400)
        claim(out["method"] == "Monte Carlo" and out["levels"] == 1 and out["realisations"] == 400, f"{arguments}: {out}")
        for key in ("digest", "probability", "ci95", "refused"):
            claim(out[key] == mc[key], f"{arguments}: {key} {out[key]}, montecarlo {mc[key]}")


TURNING = [*SHORT, "--start", "rotating"]
DEEP = [*SOFT, "--rpm", "150", "--cov", "0.2", *TURNING, "--samples-per-level", "400"]


def same_bits():
    """Threads and vector units change nothing."""
    runs = [result("rare", *DEEP, *more)[0] for more in ([], ["--threads", 3], ["--engine", "scalar"], ["--engine", "sse2", "--threads", 2])]
    for out in runs[1:]:
        for key in runs[0]:
            claim(key in ("engine", "seconds") or out[key] == runs[0][key], f"{key}: {out[key]} instead of {runs[0][key]}")
    claim(runs[0]["levels"] > 2, f"deep enough to tell: {runs[0]['levels']}")
    other = result("rare", *DEEP, "--seed", 2)[0]
    claim(other["digest"] != runs[0]["digest"], "another seed, another run")


def unequal_laws():
    """A parameter that is not random stays at its mean; the others move."""
    out, status = result("rare", *SOFT, "--rpm", 130, *TURNING, "--cov", "mu=0.2,rpm=0.2", "--samples-per-level", 1200)
    claim(status == 0, f"unequal laws: {out.get('reason')}")
    if status == 0:
        places = out["failures"]
        claim(places["wob_kN"]["sd"] < 1e-4 and abs(places["wob_kN"]["mean"] - 100) < 1e-4, f"weight not random: {places['wob_kN']}")
        claim(places["alpha1"]["sd"] < 1e-6 and places["mu"]["sd"] > 1e-5 and places["rpm"]["sd"] > 0.1, f"mu and rpm random: {places}")


def refuses():
    """Each with its reason, exit 1 and a JSON without a probability."""
    for arguments, reason in (
            ([*SOFT, "--rpm", 170, "--cov", 0.1, "--samples-per-level", 400], "below 1e-9"),
            ([*SOFT, "--rpm", 120, "--cov", 0.1, "--samples-per-level", 400], "50 different"),
            ([*SOFT, "--rpm", 200, "--limit", 10], "no failure"),
            (["--mu", 0.04, "--rpm", 700, "--step", 0.002, "--cov", 0.2], "shorter step")):
        out, status = result("rare", "--samples-per-level", 200, *arguments, *TURNING)
        claim(status == 1 and out.get("probability", 0) is None and out["ci95"] is None, f"{arguments}: status {status}, {out}")
        claim(reason in str(out.get("reason")), f"{arguments}: reason {out.get('reason')}")
        done = run("rare", "--samples-per-level", 200, *arguments, *TURNING)
        claim(reason in done.stderr and done.stderr.count("\n") == 1 and "P(stick" not in done.stdout, f"{arguments}: {done}")
    claim(sum(out["refused_by_level"]) == out["refused"] > 0, f"refused: {out['refused']}, {out['refused_by_level']}")


def bad_usage():
    for arguments, word in ((["--cov", "0"], "nothing is random"), (["--samples-per-level", "2001"], "multiple of 40"),
                            (["--samples-per-level", "40"], "200"), (["--samples", "100"], "--samples"), (["--first", "3"], "--first"),
                            (["--csv", "x.csv"], "--csv"), (["--nonsense", "1"], "--nonsense")):
        done = run("rare", *arguments)
        claim(done.returncode == 2 and word in done.stderr and done.stderr.count("\n") == 1 and not done.stdout, f"{arguments}: {done}")


# ---- study

def study_case(name, seeds, first, pool):
    arguments, reference, samples = CASES[name]
    mc = plain(name) if samples else None
    reference = reference or mc[0]
    runs = list(pool.map(lambda s: rare(name, s), range(first, first + seeds)))
    good = [r for r in runs if r.get("probability") is not None]
    ps = [r["probability"] for r in good]
    claim(len(good) == seeds, f"{name}: {seeds - len(good)} refused: {[r.get('reason') or r.get('error') for r in runs if r not in good]}")
    if not good:
        return f"| {name} | {reference:.3g} | all refused |"
    mean = statistics.fmean(ps)
    spread = statistics.stdev(ps) / mean if len(ps) > 1 else 0
    covered = sum(r["ci95"][0] <= reference <= r["ci95"][1] for r in good)
    levels = [r["levels"] for r in good]
    realisations = statistics.fmean(r["realisations"] for r in good)
    acceptance = [a for r in good for a in r["acceptance"]]
    if mc:
        overlap = sum(r["ci95"][0] <= mc[2] and mc[1] <= r["ci95"][1] for r in good)
        claim(overlap >= 0.95 * len(good), f"{name}: {overlap} of {len(good)} intervals overlap that of {samples} plain realisations, {mc[1]:.4g} .. {mc[2]:.4g}")
    claim(abs(mean / reference - 1) < 0.1, f"{name}: mean {mean:.3g} of {reference:.3g}, ratio {mean / reference:.3f}")
    claim(covered >= 0.9 * len(good), f"{name}: {covered} of {len(good)} intervals hold {reference:.3g}")
    claim(spread <= 0.35, f"{name}: coefficient of variation {spread:.2f}")
    claim(max(r["realisations"] for r in good) <= 20000, f"{name}: more than 20000 realisations")
    print(f"{name}: " + " ".join(f"{p:.3g}" for p in sorted(ps)), flush=True)
    need = (1 - mean) / (mean * spread ** 2) if spread else 0
    return (f"| {name} | {reference:.3g}{f' ({samples} plain: {mc[1]:.3g}..{mc[2]:.3g})' if mc else ''} | {mean:.3g} | {mean / reference:.3f} | {spread:.2f} | "
            f"{statistics.fmean(r['cov'] for r in good):.2f} | {covered}/{len(good)} | {min(levels)}-{max(levels)} | {realisations:.0f} | "
            f"{f'{min(acceptance):.2f}-{max(acceptance):.2f}' if acceptance else '-'} | {sum(r['refused'] for r in runs)} | "
            f"{need:.3g} | {need / realisations:.3g} |")


HEAD = """# Subset simulation on the drill string: {seeds} seeds a case

100 s, window 50:100, limit 0.8, 2400 samples a level. Spread: standard deviation over mean of the {seeds} estimates; cov: what a run
says of itself, on average. Plain: realisations of plain Monte Carlo with the same spread; gain: over those of the run.

| case | reference | mean | ratio | spread | cov | covered | levels | realisations | acceptance | refused | plain | gain |
|---|---|---|---|---|---|---|---|---|---|---|---|---|
"""


def study(args):
    names = [n for n in CASES if not args.only or n in args.only]
    path = os.path.join(ROOT, "build", "rare.md")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    if any(program(n) == OTHER for n in names):
        subprocess.run(["make", "-s", "WELL=gen/wells/slim-4000ft.toml"], cwd=ROOT, check=True)
    lines = []
    with concurrent.futures.ThreadPoolExecutor(args.workers) as pool:
        for name in names:
            lines.append(study_case(name, args.seeds, args.first, pool))
            print(lines[-1], flush=True)
            with open(path, "w", encoding="utf-8") as file:
                file.write(HEAD.format(seeds=args.seeds) + "\n".join(lines) + "\n")


def main():
    global KELLY                                     # pylint: disable=global-statement
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1])
    parser.add_argument("--kelly", default=KELLY)
    parser.add_argument("--study", action="store_true")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--from", dest="first", type=int, default=1)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--only", nargs="*")
    args = parser.parse_args()
    KELLY = os.path.abspath(args.kelly)
    if args.study:
        study(args)
    else:
        for part in (bad_usage, plain_level, same_bits, unequal_laws, refuses, reference_cases):
            part()
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
