#!/usr/bin/env python3
"""figures.py - Figures 1-8 of the paper from kelly's own runs, and a page that sets what the paper says beside what was found.

usage: host/figures.py [--kelly build/host/kelly] [--out build/figures] [--samples 400] [--quick]

Runs go to OUT/runs (CSV, NPY, JSON), pictures to OUT/figN.png and .svg, the page to OUT/index.html. --quick: few and short runs, for
a test of the machinery; its numbers mean nothing. Needs numpy and matplotlib (Debian: python3-numpy python3-matplotlib).
"""
import argparse
import concurrent.futures
import csv
import json
import os
import subprocess
import sys
import time

sys.dont_write_bytecode = True
try:
    import numpy as np
    import figures_draw as draw
    import figures_page as page
except ImportError as missing:
    sys.exit(f"figures: {missing}; apt-get install python3-numpy python3-matplotlib")

NAMES = ("fc", "mu", "a1", "a2", "rpm")   # Y1..Y5, as --cov calls them
LEVELS = (0.05, 0.20)
ROCKS = {"hard": 0.04, "soft": 0.004}
SPEED, AXIAL = "bit_speed_rpm", "bit_axial_speed_m_s"
STILL_RPM = 1.0                           # below this the mean bit speed is no measure of a dispersion
FINER = 8                                 # points a bin where a peak is located
SETTLED = 0.5                             # statistics "after the transient": the last half, the window of the severity


class Runs:
    """kelly's runs, each written to a file of its own and read back."""

    def __init__(self, kelly, out, quick):
        self.kelly, self.out, self.commands = kelly, os.path.join(out, "runs"), []
        self.common = ["--out-step", "0.02"] + (["--duration", "20"] if quick else [])
        os.makedirs(self.out, exist_ok=True)

    def path(self, name):
        return os.path.join(self.out, name)

    def call(self, *args):
        self.commands.append("kelly " + " ".join(os.path.relpath(a, self.out) if os.sep in a else a for a in args))
        done = subprocess.run([self.kelly, *args], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"figures: {' '.join(args)}: exit {done.returncode}: {done.stderr.strip()}")

    def simulate(self, name, *args):
        """One realisation in time: a structured array with the columns of the CSV."""
        file = self.path(name + ".csv")
        self.call("simulate", *self.common, *args, "--out", file)
        with open(file, encoding="ascii") as lines:
            names = lines.readline().strip().split(",")
            values = np.loadtxt(lines, delimiter=",", ndmin=2)
        return {n: values[:, i] for i, n in enumerate(names)}

    def ensemble(self, name, samples, *args):
        """-> envelope (fields as in the file) and the bit speed of every realisation [rpm], refused ones left out."""
        files = [self.path(f"{name}.{kind}") for kind in ("envelope.npy", "traces.npy", "json")]
        self.call("montecarlo", *self.common, *args, "--samples", str(samples), "--envelope", files[0], "--traces", files[1], "--json", files[2])
        traces = np.load(files[1])
        os.remove(files[1])               # 8 MB each; the envelope stays
        return np.load(files[0]), traces[~np.isnan(traces[:, 0])]

    def probability(self, name, *args):
        file = self.path(name + ".json")
        self.call("montecarlo", *self.common, *args, "--json", file)
        with open(file, encoding="ascii") as text:
            return json.load(text)

    def severity(self, name, *args):
        """ss of each realisation."""
        file = self.path(name + ".csv")
        self.call("montecarlo", *self.common, *args, "--csv", file)
        with open(file, encoding="ascii") as lines:
            return [float(line["ss"] or "nan") for line in csv.DictReader(lines)]

    def modes(self):
        file = self.path("modes.json")
        self.call("modes", "--json", file)
        with open(file, encoding="ascii") as text:
            return json.load(text)

    def convergence(self, samples):
        """int |U|^2 dt of each realisation: from runs of two, whose function is printed at n = 1 and n = 2."""
        def pair(first):
            file = self.path(f"convergence.{first}.json")
            self.call("montecarlo", *self.common, "--cov", "0.2", "--convergence", "--first", str(first), "--samples", "2", "--threads", "1",
                      "--json", file)
            with open(file, encoding="ascii") as text:
                at = dict(json.load(text)["convergence"])
            os.remove(file)
            return [at[1], 2 * at[2] - at[1]] if 2 in at else list(at.values())
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            return np.concatenate(list(pool.map(pair, range(0, samples, 2))))


# ---- what is measured on them

def spectrum(traces, dt, straight=False, finer=1):
    """Frequencies [Hz] and one-sided amplitude spectrum of each row, in its unit: mean (straight: line) taken out, Hann window;
    finer: points a bin, by zeros behind the record."""
    x = np.atleast_2d(np.asarray(traces, dtype=float))[:, :-1]
    n = x.shape[1]
    t = np.arange(n) - (n - 1) / 2
    x = x - x.mean(axis=1, keepdims=True)
    if straight:
        x = x - (x @ t / (t @ t))[:, None] * t
    window = np.hanning(n + 1)[:-1]
    return np.fft.rfftfreq(finer * n, dt), 2 * np.abs(np.fft.rfft(x * window, finer * n, axis=1)) / window.sum()


def peaks(f, amplitude, count, apart=0.1):
    """Frequencies of the `count` tallest local maxima at least `apart` Hz from a taller one, by a parabola through the logarithms; ascending."""
    log = np.log(amplitude + 1e-300)
    tops = [i for i in range(1, len(f) - 1) if amplitude[i - 1] < amplitude[i] >= amplitude[i + 1]]
    found = []
    for i in sorted(tops, key=lambda i: -amplitude[i]):
        if all(abs(f[i] - f[k]) >= apart for k in found):
            found.append(i)
    vertex = [f[i] + (f[1] - f[0]) * 0.5 * (log[i - 1] - log[i + 1]) / (log[i - 1] - 2 * log[i] + log[i + 1]) for i in found[:count]]
    return sorted(vertex)


def half(x, settled=SETTLED):
    return x[..., int(round(settled * (x.shape[-1] - 1))):]


def band_summary(envelope, traces, nominal):
    """Numbers of Figures 5 and 6."""
    high, low = envelope[f"{SPEED}_q975"], envelope[f"{SPEED}_q025"]
    t = envelope["time_s"]
    return {
        "upper": high.max(), "lower": low.min(), "nominal": nominal[SPEED].max(), "lowest": traces.min(), "highest": traces.max(),
        "outside": np.mean((traces > 350.0) | (traces < -5.0)), "upper_late": half(high).mean(), "width": half(high - low).mean(),
        "axial_width": half(envelope[f"{AXIAL}_q975"] - envelope[f"{AXIAL}_q025"]).mean(),
        "slope": np.polyfit(t, envelope[f"{AXIAL}_mean"], 1)[0], "nominal_slope": np.polyfit(t, nominal[AXIAL], 1)[0],
        "axial_end": half(envelope[f"{AXIAL}_mean"]).mean(), "axial_high": envelope[f"{AXIAL}_q975"].max(),
    }


def dispersion(envelope, amplitude):
    """Standard deviation over the mean: at each instant (NaN where the bit stands still), and at each frequency."""
    mean = envelope[f"{SPEED}_mean"]
    moving = mean > STILL_RPM
    return np.where(moving, envelope[f"{SPEED}_sd"] / np.where(moving, mean, 1), np.nan), amplitude.std(axis=0) / amplitude.mean(axis=0)


def bandwidth(f, amplitude, share=0.95):
    """Frequency below which `share` of the power lies [Hz]."""
    power = np.cumsum(np.mean(amplitude ** 2, axis=0))
    return f[np.searchsorted(power, share * power[-1])]


def streaming_errors(exact, streaming, other):
    """Root mean square over time of: streaming less exact; exact of another seed less exact, over sqrt 2 (the sampling error)."""
    def rms(a, b, field):
        return float(np.sqrt(np.mean((a[field] - b[field]) ** 2)))
    return {q: (rms(streaming, exact, f"{SPEED}_{q}"), float(np.max(np.abs(streaming[f"{SPEED}_{q}"] - exact[f"{SPEED}_{q}"]))),
                rms(other, exact, f"{SPEED}_{q}") / 2 ** 0.5) for q in ("mean", "sd", "q025", "q500", "q975")}


def axial_spectra(r):
    """Figure 1: spectra of the axial speed, and their two tallest peaks."""
    r["axial spectra"], r["peaks"], r["heights"], r["finer"] = {}, {}, {}, FINER
    for key in ("axial 10", "axial 1"):
        r["fine f"], amplitude = spectrum(r[key][AXIAL], r["t"][1], straight=True, finer=FINER)
        r["axial spectra"][key] = amplitude[0]
        r["peaks"][key] = peaks(r["fine f"], np.where(r["fine f"] > 0.5, amplitude[0], 0), 2)
        r["heights"][key] = np.interp(r["peaks"][key], r["fine f"], amplitude[0])


# ---- all of it

def collect(runs, samples, many):
    """Every run, every number. -> dict for the pictures and the page."""
    r = {"samples": samples, "many": many, "modes": runs.modes(), "still": STILL_RPM}
    r["nominal"] = runs.simulate("nominal")
    r["axial 10"] = runs.simulate("axial_10", "--torsional", "10", "--axial", "11")
    r["axial 1"] = runs.simulate("axial_1", "--torsional", "10", "--axial", "2")
    r["torsional 1"] = runs.simulate("torsional_1", "--torsional", "1", "--axial", "11")
    r["integrals"] = runs.convergence(5 * samples // 2)
    r["cases"] = {}
    for level in LEVELS:
        for name in NAMES + ("all",):
            if name == "all" and level != 0.20:
                continue
            cov = str(level) if name == "all" else f"{name}={level}"
            envelope, traces = runs.ensemble(f"{name}_{level:.2f}", samples, "--cov", cov)
            f, amplitude = spectrum(traces, envelope["time_s"][1])
            in_time, in_frequency = dispersion(envelope, amplitude)
            case = {"time": in_time, "frequency": in_frequency, "used": len(traces)}
            if (name, level) in (("rpm", 0.05), ("all", 0.20)):
                case.update(envelope=envelope, amplitude=amplitude, summary=band_summary(envelope, traces, r["nominal"]),
                            bandwidth=bandwidth(f, amplitude))
            r["cases"][name, level] = case
            r["f"] = f
    r["t"] = envelope["time_s"]
    axial_spectra(r)
    r["nominal amplitude"] = spectrum(r["nominal"][SPEED], r["t"][1])[1][0]
    r["P"], r["severity"] = {}, {}
    for rock, mu in ROCKS.items():
        case = ["--mu", str(mu), "--cov", "0.2"]
        r.setdefault("three", {})[rock] = [runs.simulate(f"{rock}_{j}", *case, "--sample", str(j)) for j in range(3)]
        for n in (samples, many):
            r["P"][rock, n] = runs.probability(f"P_{rock}_{n}", *case, "--samples", str(n))
        r["severity"][rock] = runs.severity(f"P_{rock}_3", *case, "--samples", "3")
    r["limit"] = r["P"]["hard", samples]["case"]["limit"]
    exact = r["cases"]["all", 0.20]["envelope"]
    r["streaming"] = runs.ensemble("streaming", samples, "--cov", "0.2", "--quantiles", "streaming")[0]
    r["errors"] = streaming_errors(exact, r["streaming"], runs.ensemble("seed_2", samples, "--cov", "0.2", "--seed", "2")[0])
    return r


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kelly", default="build/host/kelly")
    parser.add_argument("--out", default="build/figures")
    parser.add_argument("--samples", type=int, default=400, help="realisations of each ensemble, even (default 400, the paper's)")
    parser.add_argument("--quick", action="store_true", help="12 realisations of 20 s: a test of the machinery")
    a = parser.parse_args()
    if a.samples < 4 or a.samples % 2:
        sys.exit(f"figures: --samples {a.samples}: give an even number, 4 or more")
    start = time.monotonic()
    runs = Runs(os.path.abspath(a.kelly), os.path.abspath(a.out), a.quick)
    samples, many = (12, 100) if a.quick else (a.samples, 10 * a.samples)
    r = collect(runs, samples, many)
    ran = time.monotonic() - start
    pictures = draw.all_figures(r, a.out)
    page.write(r, os.path.join(a.out, "index.html"), pictures, runs.commands)
    print(f"figures: {len(pictures)} figures and index.html in {a.out}: {ran:.0f} s of runs, {time.monotonic() - start:.0f} s in all")


if __name__ == "__main__":
    main()
