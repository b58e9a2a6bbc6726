#!/usr/bin/env python3
"""check_digests - one value in float and one in double: every compiler, flag, lane count and board gives the same digest.

Runs `make digest` of 8 realisations (4 s, mu 0.04, every law at 0.2), for two seeds and first indices, and writes the
table to build/digests.md. The reference is the one-lane build of the host at -O2. Last line `N passed, N failed`.
"""
import concurrent.futures
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FLAGS = ("-O0", "-O2", "-O3 -march=native")
RUNS = ((1, 0), (20261122, 4000000000))   # (seed, first)
CASE = "--duration 4 --window 2:4 --mu 0.04 --cov 0.2 --samples 8".split()


def targets():
    return sorted(f[:-3] for f in os.listdir(os.path.join(ROOT, "linker")) if f.endswith(".mk") and f != "targets.mk")


def sh(words):
    done = subprocess.run(words, cwd=ROOT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else "failed: " + (done.stdout + done.stderr)[-300:]


def digest_of(text):
    found = re.search(r"^digest ([0-9a-f]{8})$|digest ([0-9a-f]{8})", text, re.M)
    return (found[1] or found[2]) if found else text.strip().replace("\n", " ")[-200:]


def engines(kelly):
    """The vector units of this program that this processor has: it refuses the others by name. One that ends otherwise ends the check."""
    found = []
    for name in ("scalar", "sse2", "avx2", "avx512", "vector"):
        done = subprocess.run([kelly, "montecarlo", "--samples", "1", "--duration", "1", "--engine", name], stdin=subprocess.DEVNULL, capture_output=True,
                              text=True, check=False)
        if done.returncode == 0:
            found.append(name)
        elif done.returncode != 2 or "not in this program or not on this processor" not in done.stderr:
            sys.exit(f"--engine {name}: status {done.returncode}: {done.stderr[-300:]}")
    return found


def on_host(compiler, flags, real):
    """[(what, digests)] of one build: each lane count."""
    out = f"build/digests/{compiler}{flags.replace(' ', '').replace('=', '')}-{real}"
    built = sh(["make", "-s", f"CC={compiler}", f"CFLAGS={flags}", f"REAL={real}", f"dir={out}", f"{out}/kelly"])
    if built.startswith("failed"):
        return [(f"{compiler} {flags}", [built] * len(RUNS))]
    kelly = os.path.join(ROOT, out, "kelly")
    return [(f"{compiler} {flags}, {engine}",
             [digest_of(sh([kelly, "montecarlo", *CASE, "--seed", str(s), "--first", str(f), "--engine", engine])) for s, f in RUNS])
            for engine in engines(kelly)]


def on_target(target, real):
    sh(["make", "-s", f"TARGET={target}", f"REAL={real}"])
    return [(target, [digest_of(sh(["make", "-s", "digest", f"TARGET={target}", f"REAL={real}", f"SEED={s}", f"FIRST={f}"])) for s, f in RUNS])]


def main():
    compilers = ("gcc", "clang")               # one that is not here fails
    jobs = [(on_target, t, r) for r in ("double", "float") for t in targets()]
    jobs += [(on_host, c, f, r) for r in ("float", "double") for c in compilers for f in FLAGS]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        results = list(pool.map(lambda job: (job[-1], job[0](*job[1:])), jobs))
    passed = failed = 0
    table = [f"| built by, runs on | float (seed {RUNS[0][0]}) | double | float (seed {RUNS[1][0]}, first {RUNS[1][1]}) | double |", "|---|---|---|---|---|"]
    rows = {}
    for real, lines in results:
        for what, digests in lines:
            rows.setdefault(what, {})[real] = digests
    want = rows.get("gcc -O2, scalar", {})
    for what, row in sorted(rows.items()):
        for real in ("float", "double"):
            for k, (seed, first) in enumerate(RUNS):
                good = re.fullmatch(r"[0-9a-f]{8}", row[real][k]) and row[real][k] == want.get(real, ["", ""])[k]
                passed, failed = passed + bool(good), failed + (not good)
                if not good:
                    print(f"{what}, {real}, seed {seed}, first {first}: {row[real][k]}, expected {want.get(real, ['?', '?'])[k]}")
        table.append(f"| {what} | {row['float'][0]} | {row['double'][0]} | {row['float'][1]} | {row['double'][1]} |")
    distinct = {want[r][k] for r in want for k in range(len(RUNS))}
    if len(distinct) != 4:   # a constant could not follow the seed
        failed += 1
        print(f"the four reference digests are not distinct: {sorted(distinct)}")
    with open(os.path.join(ROOT, "build", "digests.md"), "w", encoding="utf-8") as file:
        file.write("\n".join(table) + "\n")
    print(f"{passed + 1} passed, {failed} failed" if len(distinct) == 4 else f"{passed} passed, {failed} failed")
    return failed != 0


if __name__ == "__main__":
    sys.exit(main())
