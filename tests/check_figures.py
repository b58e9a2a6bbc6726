#!/usr/bin/env python3
"""check_figures.py - envelopes in time against numpy, and the figures with their page.

usage: tests/check_figures.py [--float build/host/kelly] [--double build/host-double/kelly] [NAME...]

Each claim that fails is one line; the last line is `N passed, N failed`. NAME picks single checks.
"""
import csv
import io
import json
import os
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
from programs import PROGRAM, ROOT, chosen, command_line  # noqa: E402
sys.path.insert(0, os.path.join(ROOT, "host"))
import numpy as np  # noqa: E402
import figures  # noqa: E402

count = {True: 0, False: 0}
QUANTITIES = ("bit_speed_rpm", "bit_axial_speed_m_s", "surface_torque_kNm")
PLACES = {"q025": 0.025, "q500": 0.5, "q975": 0.975}


def claim(holds, what):
    count[bool(holds)] += 1
    if not holds:
        print(f"FAIL {what}", flush=True)
    return bool(holds)


def close(got, want, within, what):
    away = float(np.max(np.abs(np.asarray(got) - np.asarray(want)))) if np.size(got) else np.inf
    claim(away <= within, f"{what}: off by {away:.3g}, allowed {within:.3g}")


def run(real, *args):
    return subprocess.run([PROGRAM[real], *(str(a) for a in args)], capture_output=True, text=True, check=False, timeout=300)


def done(real, *args):
    result = run(real, *args)
    claim(result.returncode == 0 and result.stderr == "", f"{real} {args}: exit {result.returncode}, {result.stderr.strip()!r}")
    return result.stdout


def refused(status, words, *args):
    result = run("float", *args)
    claim(result.returncode == status and result.stderr.count("\n") == 1 and words in result.stderr and result.stdout == "",
          f"{args}: exit {result.returncode}, {result.stderr.strip()!r}; should be {status} and one line with {words!r}")


CASE = ("--duration", "3", "--cov", "0.2", "--seed", "7")


def simulated(real, indices, *case):
    """{quantity: [realisation, time]} from one `kelly simulate` for each index."""
    rows = [list(csv.DictReader(io.StringIO(done(real, "simulate", *case, "--sample", j)))) for j in indices]
    return {q: np.array([[float(line[q]) for line in lines] for lines in rows]) for q in QUANTITIES}, [float(line["time_s"]) for line in rows[0]]


def against_numpy(envelope, ensemble, within, what):
    for q, x in ensemble.items():
        size = np.max(np.abs(x))
        close(envelope[q + "_mean"], x.mean(axis=0), within * size, f"{what}: mean of {q}")
        close(envelope[q + "_sd"], x.std(axis=0), within * size, f"{what}: standard deviation of {q}")
        for name, p in PLACES.items():
            close(envelope[f"{q}_{name}"], np.quantile(x, p, axis=0), within * size, f"{what}: {p} quantile of {q}")


def check_envelope(here):
    for real, digits in (("float", 1e-8), ("double", 1e-14)):
        ensemble, times = simulated(real, range(5, 18), *CASE)
        path = os.path.join(here, f"{real}.npy")
        done(real, "montecarlo", *CASE, "--first", 5, "--samples", 13, "--envelope", path)
        envelope = np.load(path)
        claim(envelope.shape == (301,) and all(envelope.dtype[n] == np.dtype("<f8") for n in envelope.dtype.names), f"{real}: {envelope.dtype}")
        close(envelope["time_s"], times, 1e-12, f"{real}: times")
        against_numpy(envelope, ensemble, digits, real)


def check_threads(here):
    args = ("montecarlo", *CASE, "--samples", 37)
    kept = {}
    for threads in (1, 2, 5):
        files = [os.path.join(here, f"{name}{threads}.npy") for name in ("envelope", "traces")]
        done("float", *args, "--threads", threads, "--envelope", files[0], "--traces", files[1])
        kept[threads] = [open(f, "rb").read() for f in files]
    claim(kept[1] == kept[2] == kept[5], "the same bytes with 1, 2 and 5 threads")
    path = os.path.join(here, "envelope.csv")
    done("float", *args, "--envelope", path)
    with open(path, encoding="ascii") as lines:
        names = lines.readline().strip().split(",")
        table = np.loadtxt(lines, delimiter=",")
    envelope = np.load(os.path.join(here, "envelope1.npy"))
    claim(tuple(names) == envelope.dtype.names and all(np.array_equal(table[:, i], envelope[n]) for i, n in enumerate(names)), "CSV holds what NPY holds")


def check_traces(here):
    ensemble, _ = simulated("float", range(4), *CASE, "--out-step", "0.05")
    for q in QUANTITIES:
        path = os.path.join(here, q + ".npy")
        done("float", "montecarlo", *CASE, "--out-step", "0.05", "--samples", 4, "--traces", path, "--trace-of", q)
        traces = np.load(path)
        claim(traces.dtype == np.dtype("<f4") and traces.shape == (4, 61), f"traces of {q}: {traces.dtype}, {traces.shape}")
        close(traces, ensemble[q], 2e-7 * np.max(np.abs(ensemble[q])), f"traces of {q}")


def check_refused(here):
    """Realisations that are not integrated: rows of NaN, and no part of the statistics."""
    case = ("--duration", "1", "--cov", "0.2", "--mu", "0.13", "--samples", 30)
    files = {name: os.path.join(here, name) for name in ("e.npy", "t.npy", "r.csv")}
    done("float", "montecarlo", *case, "--envelope", files["e.npy"], "--traces", files["t.npy"], "--csv", files["r.csv"])
    with open(files["r.csv"], encoding="ascii") as lines:
        ok = np.array([line["status"] == "ok" for line in csv.DictReader(lines)])
    traces, envelope = np.load(files["t.npy"]).astype(float), np.load(files["e.npy"])
    claim(0 < ok.sum() < 30, f"some of them refused, some not: {ok.sum()} of 30 run")
    claim(np.all(np.isnan(traces[~ok])) and not np.any(np.isnan(traces[ok])), "rows of NaN exactly where refused")
    against_numpy({n: envelope[n] for n in envelope.dtype.names if n.startswith("bit_speed")}, {QUANTITIES[0]: traces[ok]}, 1e-7, "refused left out")
    gone = os.path.join(here, "gone.npy")
    result = run("float", "montecarlo", "--mu", "1", "--samples", 5, "--duration", "1", "--envelope", gone)
    claim(result.returncode == 1 and re.fullmatch(f"kelly: --envelope {gone}: not written: every realisation was refused.*\nkelly: no answer: .*\n", result.stderr),
          f"an envelope of nothing: exit {result.returncode}, {result.stderr!r}")
    claim(set(os.listdir(here)) == set(files), f"nothing is written where nothing counts: {os.listdir(here)}")


def check_mistakes(here):
    path = os.path.join(here, "x.npy")
    refused(2, "GB of memory", "montecarlo", "--samples", 4000000000, "--envelope", path)
    refused(2, "fewer --samples", "montecarlo", "--samples", 20000000, "--traces", path)
    told = re.search(r"need ([\d.e+]+) GB", run("float", "montecarlo", "--samples", 4000000000, "--traces", path).stderr)
    claim(told and abs(float(told[1]) / (4e9 * 3 * 10001 * 4 / 1e9) - 1) < 0.02, "the refusal says how much memory it would take")
    tight = subprocess.run(f"ulimit -v 2000000; exec '{PROGRAM['float']}' montecarlo --samples 40000 --threads 1 --envelope '{path}'", shell=True,
                           capture_output=True, text=True, check=False)
    claim(tight.returncode == 2 and "GB of memory" in tight.stderr and tight.stderr.count("\n") == 1, f"memory that cannot be had: {tight.stderr!r}")
    refused(2, ".npy or .csv", "montecarlo", "--envelope", os.path.join(here, "x.txt"))
    refused(2, ".npy or .csv", "montecarlo", "--envelope", "-")
    refused(2, "ends in .npy", "montecarlo", "--traces", os.path.join(here, "x.csv"))
    refused(2, "exact or streaming", "montecarlo", "--envelope", path, "--quantiles", "rough")
    refused(2, "surface_torque_kNm", "montecarlo", "--traces", path, "--trace-of", "torque")
    refused(1, "cannot write", "montecarlo", "--duration", "1", "--samples", 2, "--envelope", os.path.join(here, "no", "x.npy"))
    claim(not os.path.exists(path), "a refused run leaves no file")


def check_streaming(here):
    files = [os.path.join(here, f) for f in ("exact.npy", "streaming.npy", "other.npy")]
    for samples, duration in ((96, 2), (400, 20)):
        args = ("montecarlo", "--duration", duration, "--out-step", "0.1", "--cov", "0.2", "--samples", samples)
        done("float", *args, "--envelope", files[0])
        done("float", *args, "--envelope", files[1], "--quantiles", "streaming")
        done("float", *args, "--envelope", files[2], "--seed", 2)
        exact, streaming, other = (np.load(f) for f in files)
        for q in QUANTITIES:
            size = np.max(np.abs(exact[q + "_q975"]))
            for s in ("mean", "sd", *PLACES):
                rms, sampling = (np.sqrt(np.mean((x[f"{q}_{s}"] - exact[f"{q}_{s}"]) ** 2)) for x in (streaming, other))
                if samples <= 96 or s in ("mean", "sd"):
                    claim(rms <= 1e-5 * size, f"{samples} values, {q}_{s}: streaming is exact, off by {rms:.3g}")
                else:
                    claim(0 < rms < 0.2 * sampling / 2 ** 0.5, f"{samples} values, {q}_{s}: rms error {rms:.3g}, sampling error {sampling / 2 ** 0.5:.3g}")


def check_measures(here):
    """What figures.py computes, on signals whose answer is known."""
    del here
    t = np.arange(5001) * 0.02
    f, a = figures.spectrum(3.0 + 0.01 * t + 0.5 * np.sin(2 * np.pi * 1.4173 * t) + 0.8 * np.sin(2 * np.pi * 1.6667 * t), 0.02, straight=True, finer=8)
    close(figures.peaks(f, a[0], 2), (1.4173, 1.6667), 5e-4, "peaks of two sines")
    f, a = figures.spectrum(np.array([2 + 5 * np.sin(2 * np.pi * 2.0 * t)]), 0.02)
    close(a[0][np.argmin(abs(f - 2.0))], 5.0, 1e-3, "amplitude of a sine")
    close(figures.bandwidth(f, a), 2.0, 0.03, "all its power lies there")
    claim(np.array_equal(figures.half(np.arange(101.0)), np.arange(50.0, 101.0)), "the last half begins where the window does")
    envelope = {"bit_speed_rpm_sd": np.array([2.0, 1.0]), "bit_speed_rpm_mean": np.array([4.0, 0.5])}
    in_time, _ = figures.dispersion(envelope, np.ones((2, 3)))
    claim(in_time[0] == 0.5 and np.isnan(in_time[1]), "dispersion: sd over mean, none where the bit stands still")


def check_model(here):
    """The numbers of model.md, from runs as the figures make them."""
    runs = figures.Runs(PROGRAM["float"], here, quick=False)
    nominal = runs.simulate("nominal")
    f, a = figures.spectrum(nominal["bit_axial_speed_m_s"], 0.02, straight=True, finer=8)
    close(figures.peaks(f, np.where(f > 0.5, a[0], 0), 2), (1.4173, 1.6667), 2e-3, "peaks of the axial speed [Hz]")
    close(nominal["bit_speed_rpm"].max(), 286.5, 0.2, "nominal maximum [rpm]")
    for cov in ("rpm=0.2", "a1=0.2", "mu=0.05"):
        envelope, traces = runs.ensemble("one", 400, "--cov", cov)
        found = float(np.nanmean(figures.half(figures.dispersion(envelope, np.ones((1, 1)))[0])))
        claim(0.735 <= found <= 0.835, f"dispersion at {cov}: {found:.3f}, should be 0.74 to 0.83")
        claim(traces.shape == (400, 5001), f"traces: {traces.shape}")


def check_convergence(here):
    runs = figures.Runs(PROGRAM["float"], here, quick=True)
    value = runs.convergence(10)
    path = os.path.join(here, "c.json")
    done("float", "montecarlo", *runs.common, "--cov", "0.2", "--convergence", "--samples", 10, "--json", path)
    with open(path, encoding="ascii") as text:
        for n, want in json.load(text)["convergence"]:
            close(np.sum(value[:n]) / n, want, 1e-12 * want, f"conv({n}) from runs of two")


def numbers(text):
    return [float(x) for x in re.findall(r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?", re.sub("<[^>]*>|&[a-z0-9]+;", " ", text))]


def check_page(here):
    """A quick run makes all of it; the page compares what stands in its own rows, and says nothing that is not a number."""
    result = subprocess.run([sys.executable, os.path.join(ROOT, "host", "figures.py"), "--kelly", PROGRAM["float"], "--out", here, "--quick"],
                            capture_output=True, text=True, check=False, timeout=300)
    claim(result.returncode == 0, f"figures.py --quick: exit {result.returncode}: {result.stderr[-300:]}")
    for i in range(1, 10):
        for kind, magic in (("png", b"\x89PNG"), ("svg", b"<?xml")):
            path = os.path.join(here, f"fig{i}.{kind}")
            claim(os.path.exists(path) and open(path, "rb").read(5).startswith(magic) and os.path.getsize(path) > 10000, f"fig{i}.{kind} is a picture")
    if not os.path.exists(os.path.join(here, "index.html")):
        claim(False, "there is a page")
        return
    page = open(os.path.join(here, "index.html"), encoding="utf-8").read()
    claim("nan" not in re.sub("<[^>]*>", " ", page).lower().replace("nanm", "").split(), "no nan on the page")
    for i in range(1, 9):
        section = re.search(rf'<section id="fig{i}">(.*?)</section>', page, re.S)[1]
        rows = [re.findall(r"<td[^>]*>(.*?)</td>", row, re.S) for row in re.findall(r"<tr>(.*?)</tr>", section, re.S)[1:]]
        claim(rows and all(len(r) == 4 and numbers(r[2]) for r in rows), f"Figure {i}: a number of kelly's in every row")
        for says, paper, found, comparison in rows:
            percent = re.search(r"(agrees|differs): ([+-][\d.]+) %", comparison)
            if percent:
                want = 100 * (numbers(found)[0] / numbers(paper)[0] - 1)
                close(float(percent[2]), want, 0.15 + 0.5 * 100 / abs(numbers(paper)[0]) * 10 ** -len(found.split(".")[-1].split()[0]),
                      f"Figure {i}, {says}: {percent[2]} %")
    for says in (">1.41 Hz<", ">1.67 Hz<", ">300 rpm<", ">0 rpm<", ">0.85<", ">400 samplings<", ">100 %<", ">50 %<", "0 and 350 rpm"):
        claim(says in page, f"the paper's {says} stands on the page")
    claim("drilling rate" in page and "m/h" in page, "the axial speed is told from a drilling rate")


def main():
    parser = command_line(__doc__)
    parser.add_argument("names", nargs="*")
    names = chosen(parser).names
    for name, check in list(globals().items()):
        if name.startswith("check_") and (not names or name[6:] in names):
            with tempfile.TemporaryDirectory() as here:
                check(here)
    print(f"{count[True]} passed, {count[False]} failed")
    return count[False] > 0


if __name__ == "__main__":
    sys.exit(main())
