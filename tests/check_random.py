#!/usr/bin/env python3
"""check_random - the laws and the independence of the draws, as the realisations take them: five parameters, index after index.

Needs build/host/random-stream. Every p is of a fixed seed and must lie in 1e-6 .. 1 - 1e-6, above 1e-6 where it
counts both sides already. That the tests can see something is a claim as well: keys that are not mixed, a law that is a percent off.
The figures give the least and the greatest p of each family. Last line `N passed, N failed`.
"""
import os
import subprocess
import sys

import numpy as np
from scipy import special, stats

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TOOL = os.path.join(ROOT, "build", "host", "random-stream")
COVS = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5)             # shapes 2500 .. 4, the largest spread that a case may have
BEYOND = (1.0,)                                      # shape 1: the sampler's method still holds, no case may have it
INDICES, PARAMETERS = 500_000, 5
SEED = 20261127
LIMIT = 1e-6
BINS = 200                                           # wide beside the grid of floats that the draws lie on
count = {True: 0, False: 0}
families = {}
draws_made = 0


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)


def take(family, what, p, both=False):
    """One p of a family; `both`: it counts both sides already, else draws that are too even give one near 1."""
    families.setdefault(family, []).append(float(p))
    claim(LIMIT <= p <= (1.0 if both else 1.0 - LIMIT), f"{family}, {what}: p {p:.17g}")


def made(what, dtype, number, *more):
    """`number` values of the tool."""
    done = subprocess.run([TOOL, what, f"count={number}", *more], stdout=subprocess.PIPE, check=True)
    return np.frombuffer(done.stdout, dtype)


def gammas(number, cov, *more):
    global draws_made
    draws_made += number
    return made("gamma", np.float32, number, f"cov={cov}", *more).astype(float)


# ---- tests

def chi_square(counts, expected):
    return stats.chi2.sf(((counts - expected)**2 / expected).sum(), len(counts) - 1)


def law(draws, cov):
    """Chi-square over equally probable bins of the gamma law of mean 1."""
    shape = 1.0 / float(np.float32(cov))**2
    edges = stats.gamma.ppf(np.arange(1, BINS) / BINS, shape, scale=1.0 / shape)
    counts = np.bincount(np.searchsorted(edges, draws), minlength=BINS)
    return chi_square(counts, len(draws) / BINS)


def uniform(draws, cov):
    """The draws through the distribution function of their law."""
    shape = 1.0 / float(np.float32(cov))**2
    return special.gammainc(shape, draws * shape)


def kolmogorov(u):
    """Sorted u -> p of Kolmogorov and Smirnov, two sides, of many."""
    n = len(u)
    away = max((np.arange(1, n + 1) / n - u).max(), (u - np.arange(n) / n).max())
    return stats.kstwobign.sf(away * np.sqrt(n))


def darling_tail(z):
    """P(A2 > z) of Anderson and Darling: A2 is the sum of squares of normals over j (j + 1); its characteristic function inverted."""
    step, j = 0.01, np.arange(1, 400)
    t = (np.arange(30000) + 0.5) * step                   # midpoints of an even function: exact but for the end
    log = sum(-0.5 * np.log(1.0 - 2j * t / (k * (k + 1))) for k in j) + 1j * t / (j[-1] + 1)
    return max(0.5 + np.sum(np.imag(np.exp(log - 1j * t * z)) / t) * step / np.pi, 0.0)


def darling(u):
    """Sorted u -> p."""
    n, u = len(u), np.clip(u, 1e-300, 1.0 - 2.0**-53)
    return darling_tail(-n - np.mean((2 * np.arange(1, n + 1) - 1) * (np.log(u) + np.log1p(-u[::-1]))))


def normal(u):
    """Normal scores."""
    return special.ndtri(np.clip(u, 1e-12, 1 - 1e-12))


def correlation(pairs):
    """Squares of the correlations of normal scores, over all the pairs of arrays at once."""
    return stats.chi2.sf(sum(len(a) * np.mean(a * b)**2 for a, b in pairs), len(pairs))


def cells(*columns, bins):
    """Chi-square over the cells of a grid: do these uniforms know of one another?"""
    at = np.zeros(len(columns[0]), dtype=int)
    for column in columns:
        at = at * bins + np.minimum((column * bins).astype(int), bins - 1)
    number = bins**len(columns)
    return chi_square(np.bincount(at, minlength=number), len(at) / number)


def repeats(birthdays):
    """How many spacings of the sorted birthdays are there already."""
    spacings = np.sort(np.diff(np.sort(birthdays)))
    return int((spacings[1:] == spacings[:-1]).sum())


def both_sides(found, mean):
    return min(1.0, 2 * min(stats.poisson.cdf(found, mean), stats.poisson.sf(found - 1, mean)))


def few_birthdays(words):
    """Marsaglia: 2^12 birthdays in 2^32 days, spacings that repeat are Poisson with mean 4; over all the words there are."""
    lots = words[:len(words) // 4096 * 4096].astype(np.int64).reshape(-1, 4096)
    return both_sides(sum(map(repeats, lots)), 4.0 * len(lots))


def many_birthdays(low, high):
    """2^22 birthdays in 2^64 days: mean 1."""
    return both_sides(repeats(low.astype(np.uint64) << np.uint64(32) | high.astype(np.uint64)), 1.0)


# ---- families

def check_laws():
    for cov in (*COVS, *BEYOND):
        draws = gammas(INDICES * PARAMETERS, cov, "over=draw", "streams=0", f"seed={SEED}")
        take("chi-square of gamma draws", f"cov {cov}", law(draws, cov))
        u = uniform(draws, cov)
        if cov not in BEYOND:
            within_and_across(cov, u.reshape(-1, PARAMETERS))
        u.sort()
        take("Kolmogorov-Smirnov of gamma draws", f"cov {cov}", kolmogorov(u))
        take("Anderson-Darling of gamma draws", f"cov {cov}", darling(u))


def within_and_across(cov, u):
    """u[index, parameter]: the parameters of a realisation; the same parameter of neighbours near and far."""
    columns = [np.ascontiguousarray(c) for c in u.T]
    scores = [normal(c) for c in columns]
    each_pair = lambda of: [(a, b) for k, a in enumerate(of) for b in of[k + 1:]]
    take("correlation within a realisation", f"cov {cov}, ten pairs", correlation(each_pair(scores)))
    for k, (a, b) in enumerate(each_pair(columns)):
        take("pairs within a realisation, 32 x 32 cells", f"cov {cov}, pair {k}", cells(a, b, bins=32))
    take("all five of a realisation, 4^5 cells", f"cov {cov}", cells(*columns, bins=4))
    for lag in (1, 2, 16, 256):
        take("correlation across indices", f"cov {cov}, lag {lag}", correlation([(a[:-lag], a[lag:]) for a in scores]))
    for k, a in enumerate(columns):
        take("pairs across indices, 32 x 32 cells", f"cov {cov}, parameter {k}", cells(a[:-1:2], a[1::2], bins=32))


def check_stream():
    """Draw after draw from one stream."""
    for cov in COVS:
        u = uniform(gammas(INDICES, cov, "streams=1", f"seed={SEED}"), cov)
        score = normal(u)
        for lag in (1, 2, 3):
            take("correlation along one stream", f"cov {cov}, lag {lag}", correlation([(score[:-lag], score[lag:])]))
        take("pairs along one stream, 32 x 32 cells", f"cov {cov}", cells(u[:-1:2], u[1::2], bins=32))


def check_seeds():
    """The same index under one seed after another."""
    for cov in COVS:
        u = uniform(gammas(INDICES, cov, "over=seed", "streams=0", f"seed={SEED}"), cov)
        score = normal(u)
        for lag in (1, 256):
            take("correlation across seeds", f"cov {cov}, lag {lag}", correlation([(score[:-lag], score[lag:])]))
        take("pairs across seeds, 32 x 32 cells", f"cov {cov}", cells(u[:-1:2], u[1::2], bins=32))


def states(over, number, *more):
    return made("states", np.uint32, number, f"over={over}", "streams=0", f"seed={SEED}", *more).reshape(-1, 4)


def check_birthdays():
    for over in ("index", "seed", "draw"):
        of = states(over, 1 << 22)
        for k in range(4):
            take("birthday spacings of first states, 2^12 in 2^32", f"over {over}, word {k}", few_birthdays(of[:, k]), both=True)
        for a, b in ((0, 1), (2, 3), (0, 2), (1, 3)):
            take("birthday spacings of first states, 2^22 in 2^64", f"over {over}, words {a} {b}", many_birthdays(of[:, a], of[:, b]), both=True)


def check_power():
    """Each test refuses what is wrong."""
    plain = states("index", 1 << 17, "keys=plain")
    claim(few_birthdays(plain[:, 1]) < LIMIT, "birthday spacings do not see indices that are counted")
    draws = made("gamma", np.float32, 1 << 18, "over=seed", "streams=0", "each=1", "keys=plain", "seed=1", "cov=0.2").astype(float)
    u = uniform(draws, 0.2)
    for see in (lambda: law(draws, 0.2), lambda: kolmogorov(np.sort(u)), lambda: darling(np.sort(u)), lambda: cells(u[:-1:2], u[1::2], bins=32),
                lambda: correlation([(normal(u[:-1]), normal(u[1:]))])):
        claim(see() < LIMIT, "a test does not see seeds that are counted")
    draws = gammas(INDICES * PARAMETERS, 0.2, "over=draw", "streams=0", f"seed={SEED}")
    u = np.sort(uniform(draws, 0.202))
    claim(law(draws, 0.202) < LIMIT and kolmogorov(u) < LIMIT and darling(u) < LIMIT, "a spread that is a percent off goes unseen")
    even = (np.arange(INDICES) + 0.5) / INDICES
    row, column = np.divmod(np.arange(32 * 32 * 400), 32 * 400)
    claim(law(stats.gamma.ppf(even, 25.0, scale=0.04), 0.2) > 1 - LIMIT and kolmogorov(even) > 1 - LIMIT and darling(even) > 1 - LIMIT and
          cells((row + 0.5) / 32, (column + 0.5) / (32 * 400), bins=32) > 1 - LIMIT, "draws that are too even go unseen")
    claim(correlation([(normal(even), np.resize((-1.0, 1.0, 1.0, -1.0), INDICES))]) > 1 - LIMIT, "a correlation that is too near 0 goes unseen")
    for z, p in ((2.4923, 0.05), (3.8781, 0.01)):         # Marsaglia and Marsaglia 2004
        claim(abs(darling_tail(z) / p - 1) < 2e-3, f"tail of Anderson and Darling at {z}: {darling_tail(z)}")
    for z in (14.0, 18.0):                                # its largest weight, 1/2, times the product of 1 - 2 / (j (j + 1)), to the -1/2
        far = np.sqrt(3.0) * stats.chi2.sf(2 * z, 1)
        claim(abs(darling_tail(z) / far - 1) < 0.03, f"far tail of Anderson and Darling at {z}: {darling_tail(z)}, not {far}")


def main():
    for check in (check_power, check_laws, check_stream, check_seeds, check_birthdays):
        check()
    for family, ps in families.items():
        print(f"figure: random, {family}: {len(ps)} p, {min(ps):.3g} .. {max(ps):.7g}")
    least = [min(ps) for ps in families.values()]
    print(f"figure: random, gamma draws: {draws_made}; least of all {sum(map(len, families.values()))} p: {min(least):.3g}")
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] != 0


if __name__ == "__main__":
    sys.exit(main())
