#!/usr/bin/env python3
"""Claims about gen/: the table's bytes, its numbers against other ways to them, the guards, the reference integrator.

Run with an interpreter that has numpy and scipy (Debian: /usr/bin/python3). The bad well files are in check_wells.py.
Prints one line for each claim that fails, then `N passed, N failed`; exit 1 if any failed.
"""
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "gen"))

import numpy as np                          # noqa: E402
from scipy import stats                     # noqa: E402
from scipy.integrate import solve_ivp       # noqa: E402

import bars                                 # noqa: E402
import modes                                # noqa: E402
import reduce                               # noqa: E402
import reference                            # noqa: E402
import stability                            # noqa: E402
import well as well_                        # noqa: E402

PAPER = os.path.join(ROOT, "gen", "wells", "paper.toml")
TABLES = os.path.join(ROOT, "firmware", "tables")
WELLS = [os.path.join(ROOT, "tests", "wells", name) for name in ("three.toml", "short.toml", "one-mode.toml")]
CFLAGS = ("-std=c11 -pedantic -Wall -Wextra -Wconversion -Wdouble-promotion -Wshadow -Wundef -Werror "
          "-fsyntax-only").split()
count = {True: 0, False: 0}


def claim(holds, text):
    holds = bool(holds)
    count[holds] += 1
    if not holds:
        print("FAILED: " + text)


def close(value, want, within, text):
    claim(abs(value - want) <= within, f"{text}: {value!r}, expected {want!r} within {within:g}")


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, check=False, **options)


def generate(path, out, **environment):
    return run(sys.executable, os.path.join(ROOT, "gen"), path, "--out", out, env={**os.environ, **environment})


def read(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


def load(path):
    return well_.parse(read(path))


# ---- the emitted C, read back

class Table:
    """Numbers of a generated NAME.c."""

    def __init__(self, text):
        self.arrays = {name: [float.fromhex(x) for x in re.findall(r"R\((\S+?)\)", body)]
                       for name, body in re.findall(r"static const real (\w+)\[\] = \{(.*?)\n\};", text, re.S)}
        self.scalars = {name: float.fromhex(x) for name, x in re.findall(r"\.(\w+) = R\((\S+?)\)", text)}
        self.scalars.update({name: int(x) for name, x in re.findall(r"\.(\w+) = (\d+)u?,", text)})
        self.torsional, self.axial = (int(re.search(rf"\.{n} = (\d+),", text)[1]) for n in ("torsional", "axial"))
        self.identity = re.search(r'\.id = "(.*?)"', text)[1]

    def at(self, name, fc):
        """Polynomials of an array at weight fc, by Horner's rule."""
        n = self.scalars["degree"] + 1
        s = (fc - self.scalars["fc_mid"]) * self.scalars["fc_scale"]
        values = []
        for start in range(0, len(self.arrays[name]), n):
            value = 0.0
            for c in reversed(self.arrays[name][start:start + n]):
                value = c + s * value
            values.append(value)
        return np.array(values)


# ---- claims

def bytes_repeat(directory):
    """The same bytes as committed, whatever the processor offers to numpy and to its BLAS."""
    wanted = {name: read(TABLES, name) for name in ("paper.c", "paper_shapes.c")}
    avx = "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL"
    machines = {"as it is": {},
                "no AVX": {"NPY_DISABLE_CPU_FEATURES": avx, "OPENBLAS_CORETYPE": "Prescott"},
                "another BLAS kernel": {"OPENBLAS_CORETYPE": "Haswell", "OPENBLAS_NUM_THREADS": "1"}}
    for label, environment in machines.items():
        out = os.path.join(directory, label.replace(" ", "_"))
        ran = generate(PAPER, out, **environment)
        claim(ran.returncode == 0, f"paper.toml is accepted, {label}: {ran.stderr.strip()}")
        for name, text in wanted.items():
            path = os.path.join(out, name)
            claim(os.path.exists(path) and read(path) == text, f"{name} regenerates to the committed bytes, {label}")
    text = "".join(wanted.values())
    claim(text.isascii() and ROOT not in text and not re.search(r"20\d\d-\d\d", text),
          "the generated files hold neither path nor date")
    claim(len(wanted["paper_shapes.c"]) < 2_000_000, "the shapes file stays below 2 MB")


def fit_is_the_eigensolution(path, text):
    """Against dense matrices and LAPACK at weights that the fit has never seen."""
    well, table = load(path), Table(text)
    fc_max = table.scalars["fc_max"]
    for fc in (f for f in (2e3, 37.3e3, 100e3, 400e3, 900e3) if f <= fc_max):
        direct = reference.modes(well, fc)
        for name in ("w2", "b", "axial_w2", "axial_b"):
            size = table.axial if name.startswith("axial") else table.torsional
            own, other = table.at(name, fc), direct[name][:size]
            first = 1 if name == "axial_w2" else 0
            error = np.max(np.abs(own[first:] / other[first:] - 1.0)) if size > first else 0.0
            half = 0.5 if name.endswith("w2") else 1.0           # w itself is what is promised
            claim(error * half < 1e-9, f"{well.name}: {name} at {fc:g} N equals the eigensolution: {error:.1e}")
        own, other = table.at("d", fc), direct["d"][:table.torsional]
        error = np.max(np.abs(own - other) / np.abs(other))
        claim(error < 1e-9, f"{well.name}: d at {fc:g} N equals the eigensolution: {error:.1e}")
    direct = reference.modes(well, None)
    for name in ("w2", "axial_w2"):
        own = np.array(table.arrays[name.replace("w2", "free_w2")])
        error = np.max(np.abs(own - direct[name][:len(own)]) / np.maximum(direct[name][:len(own)], 1e-9))
        claim(error < 1e-9, f"{well.name}: {name} without prestress equals the eigensolution: {error:.1e}")
    close(table.scalars["inertia"], direct["inertia"], 1e-12 * direct["inertia"], f"{well.name}: J = 1'M1")
    claim(table.arrays["axial_w2"][:table.scalars["degree"] + 1] == [0.0] * (table.scalars["degree"] + 1),
          f"{well.name}: the rigid mode has w = 0 exactly")


def shapes_fit(path, directory):
    """Node by node, and the Gram matrices, at one weight."""
    well = load(path)
    generate(path, directory)
    table = Table(read(directory, well.name + ".c"))
    shapes = Table.__new__(Table)
    text = read(directory, well.name + "_shapes.c")
    shapes.arrays, shapes.scalars = {}, table.scalars
    for name, body in re.findall(r"static const real (\w+)\[\] = \{(.*?)\n\};", text, re.S):
        shapes.arrays[name] = [float.fromhex(x) for x in re.findall(r"R\((\S+?)\)", body)]
    claim(f'"{table.identity}"' in text, f"{well.name}: shapes and table carry one id")
    fc, nodes = 212.5e3, well.elements + 1
    (ka, ma), (kt, mt) = reference.matrices(well, fc)
    twist = shapes.at("twist", fc).reshape(table.torsional, nodes).T
    axial = shapes.at("axial", fc).reshape(table.axial, nodes).T
    for label, phi, k, m, w2 in (("twist", twist, kt, mt, table.at("w2", fc)),
                                 ("axial", axial, ka, ma, table.at("axial_w2", fc))):
        gram = phi.T @ m @ phi
        claim(np.max(np.abs(gram - np.eye(len(gram)))) < 1e-8, f"{well.name}: {label} shapes are M-orthonormal")
        energy = np.diag(phi.T @ k @ phi)
        claim(np.max(np.abs(energy - w2)) < 1e-8 * np.max(w2 + 1e-9), f"{well.name}: {label} shapes have the energy w2")
        rows, columns = np.tril_indices(phi.shape[1])
        sums = phi.T @ phi
        error = np.max(np.abs(shapes.at(label + "_gram", fc) - sums[rows, columns])) / np.max(np.abs(sums))
        claim(error < 1e-8, f"{well.name}: {label}_gram is the sum over the nodes: {error:.1e}")
    claim(np.all(twist[0] == 0.0), f"{well.name}: the top node does not twist")
    length = sum(s.length for s in well.sections)
    close(shapes.arrays["x"][-1], length, 1e-9 * length, f"{well.name}: x of the bit [m]")


def tables_of_the_paper(table):
    """Tables 1 and 2, no prestress and prestressed, as printed."""
    hertz = lambda w2: [f"{math.sqrt(v) / 2.0 / math.pi:.4f}" for v in w2]
    printed = (("free_w2", 0, "0.3679 1.2275 2.2039 3.2179 4.2411 5.2575 6.2380 7.1004 7.8407 8.7130"),
               ("w2", 0, "0.3681 1.2281 2.2049 3.2194 4.2431 5.2599 6.2407 7.1028 7.8435 8.7168"),
               ("axial_free_w2", 1, "1.4168 3.0166 4.7244 6.4701 8.2178 9.9314 11.5382 12.9613 14.3927 16.0154"),
               ("axial_w2", 1, "1.4173 3.0179 4.7266 6.4731 8.2216 9.9358 11.5428 12.9659 14.3985 16.0226"))
    for name, first, text in printed:
        values = table.arrays[name] if "free" in name else table.at(name, 100e3)
        for own, want in zip(hertz(values[first:first + 10]), text.split()):
            claim(own == want, f"{name}: {own} Hz, printed {want}")


def golden_numbers(table):
    """model.md's, for the paper's string at 100 kN."""
    b, d, w2 = (table.at(name, 100e3) for name in ("b", "d", "w2"))
    chain = bars.build(load(PAPER))
    close(chain.mass, 63010, 0.5, "mass [kg]")
    close(table.scalars["inertia"], 201.325, 5e-4, "J [kg m2]")
    for n, want in ((1, 0.0085134), (10, 0.0428560), (20, 0.0769149)):
        close(float((b[:n]**2).sum()), want, 6e-8, f"sum of b^2 over {n}")
    close(math.sqrt(w2[0]) / 2 / math.pi, 0.36808567, 6e-9, "f_1 [Hz]")
    for value, want, within in ((b[0], 0.0922678, 6e-8), (abs(d[0]), 12.89665, 6e-6),
                                (b[1], 0.0605054, 6e-8), (abs(d[1]), 4.270786, 6e-7)):
        close(value, want, within, "b_1, d_1, b_2, d_2")
    close(table.scalars["inertia"] - float((d[:10]**2).sum()), 3.200, 5e-4, "J - sum d^2")
    nominal = {"fc": 1e5, "f0": 5e4, "mu": 0.04, "a1": 2.0, "a2": 1.0, "w0": 100.0 * 0.10471975511965977, "limit": 0.8,
               "window_first": 50000, "window_last": 100000, "rotating": 0}
    for name, want in nominal.items():
        claim(table.scalars[name] == want, f"nominal {name} = {want}")


def uniform_bar():
    """A uniform chain without prestress has exact discrete eigenvalues: k / m (2 - 2 cos t) / (4 + 2 cos t)."""
    n, k, m = 50, 3.0e6, 2.0
    chain = np.full((n, 1), k), np.full(n, m)
    for fixed, angles in ((True, [(2 * j - 1) * math.pi / (2 * n) for j in range(1, n + 1)]),
                          (False, [j * math.pi / n for j in range(1, n + 1)])):
        exact = np.array([k / m * (4 * math.sin(t / 2)**2) / (4 + 2 * math.cos(t)) for t in angles])
        found = modes.solve(*chain, n, fixed_top=fixed)
        error = np.max(np.abs(found.w2[0] / exact - 1.0))
        claim(error < 1e-13, f"uniform bar, all {n} modes, {'fixed' if fixed else 'free'} top: {error:.1e}")
        shape = found.shape[:, 0, :]
        x = np.arange(n + 1)[:, None]
        wave = np.sin(x * np.array(angles)) if fixed else np.cos(x * np.array(angles))
        wave = wave / wave[-1] * shape[-1]
        claim(np.max(np.abs(wave - shape)) < 1e-11, "uniform bar: shapes are sampled waves")


def stable_step():
    """The law of the fastest rate, against a sum with scipy's gamma law."""
    well = load(PAPER)
    reduction = reduce.reduce(well, bars.build(well))
    found = stability.stability(well, reduction)
    close(found.nominal, 771.65, 0.5, "nominal rate [1/s]")
    x = np.linspace(0.1, 4.0, 1001)
    weight = stats.gamma.pdf(x, 25, scale=1.0 / 25) * (x[1] - x[0])
    fc, a1 = 1e5 * x, 2.0 * x
    gain, damping = stability._gain(well, reduction, fc)
    for rate in (2000.0, found.rate, 2785.0):
        need = (rate - damping)[:, None] / gain[:, None] / (1 + a1)[None, :]
        other = float(weight @ stats.gamma.sf(need, 25, scale=0.04 / 25) @ weight)
        own = stability._exceeds(stability._laws(well, reduction), rate)
        claim(abs(own / other - 1) < 0.01, f"P(rate > {rate:g}) = {own:.3g}, by scipy {other:.3g}")
    claim(1.4e-7 < found.exceedance < 2.6e-7, f"at 1 ms 2e-7 of the realisations are refused: {found.exceedance:.2g}")
    for cov in (0.001, 0.05, 0.2, 0.5):
        x = 1 + cov * np.array([0.0, 1.0, 3.0, 5.0])
        error = np.max(np.abs(stability.Tail(cov)(x) / stats.gamma.sf(x / cov**2, 1 / cov**2) - 1))
        claim(error < 2e-3, f"gamma tail at cov {cov}: {error:.1e}")


def compiler():
    found = next((cc for cc in ("gcc", "cc", "clang") if shutil.which(cc)), None)
    claim(found, "a C compiler is there")
    return found


def guards_trip(directory, cc):
    """Editing the step in the generated C does not compile; nor does another schema."""
    tree = os.path.join(directory, "tree")
    os.makedirs(os.path.join(tree, "tables"))
    for name in ("string_model.h", "real.h"):
        shutil.copy(os.path.join(ROOT, "firmware", name), tree)
    text = read(TABLES, "paper.c")
    edits = ((text, None), (text.replace("STEP_NS      1000000u", "STEP_NS      1500000u"), "unsafe step"),
             (text.replace("STEP_NS      1000000u", "STEP_NS      500000u"), "do not belong together"),
             (text.replace("TICKS        100000u", "TICKS        100001u"), "do not belong together"),
             (text.replace("KELLY_SCHEMA != 2u", "KELLY_SCHEMA != 99u"), "schema"))
    for edited, reason in edits:
        with open(os.path.join(tree, "tables", "t.c"), "w", encoding="ascii") as file:
            file.write(edited)
        ran = run(cc, *CFLAGS, "t.c", cwd=os.path.join(tree, "tables"))
        holds = ran.returncode == 0 if reason is None else ran.returncode and reason in ran.stderr and edited != text
        claim(holds, f"the table compiles, or trips on {reason}: {ran.stderr.strip()[:200]}")


def compiles(directory, cc, path):
    name = load(path).name
    for file in (f"{name}.c", f"{name}_shapes.c"):
        text = read(directory, file).replace('"../string_model.h"', f'"{ROOT}/firmware/string_model.h"')
        for real in ([], ["-DKELLY_DOUBLE"]):
            ran = run(cc, *CFLAGS, *real, "-x", "c", "-", input=text)
            claim(ran.returncode == 0, f"{file} compiles without a warning, {real}: {ran.stderr.strip()[:200]}")


def tight(case, times):
    """Bit speed and axial bit speed by DOP853, relative tolerance 1e-11."""
    system = reference.System(load(PAPER), [case])
    n = system.b.shape[1]

    def slope(t, y):
        return np.concatenate([y[n:], system.acceleration(y[None, :n], y[None, n:], system.weight(t))[0]])

    start = np.concatenate([np.zeros(n), system.v0[0]])
    found = solve_ivp(slope, (0.0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-11, atol=1e-12)
    return system.speed(found.y[n:].T), (system.b_axial * found.y[n:].T).sum(axis=1)


def reference_is_right():
    """Golden speeds of model.md; RK4 against a tight solution; order 4; surface torque as the top spring feels it."""
    well = load(PAPER)
    data = reference.simulate(well, {}, 0.0005, 5.0, 50.0)
    for t, want in ((0, 0.1442639), (5, 22.808388), (10, 17.560572), (20, 0.727388), (50, 5.049398)):
        close(data["bit_speed"][t // 5], want, 3e-5, f"bit speed at {t} s [rad/s]")
    # at 10 s model.md prints 0.467162; the exact solution of (A) is 0.4671656
    for t, want in ((5, 0.598377), (10, 0.4671656), (20, 0.395796), (50, 0.730316)):
        close(data["bit_axial_speed"][t // 5], want, 6e-7, f"axial bit speed at {t} s [m/s]")
    times = [0.0, 5.0, 10.0, 20.0]
    speed, axial = tight({}, times)
    for t, own, want in zip(times, speed, (0.1442639, 22.808388, 17.560572, 0.727388)):
        close(own, want, 6e-7, f"tight bit speed at {t} s [rad/s]")
    close(axial[3], 0.395796, 6e-7, "tight axial bit speed at 20 s [m/s]")
    soft = {"mu": 0.004, "rotating": 1, "w0": 14.0, "fc": 130e3}
    exact = tight(soft, [0.0, 4.0])[0][1]
    errors = [abs(reference.simulate(well, soft, h, 4.0, 4.0)["bit_speed"][1] - exact) for h in (0.001, 0.0005)]
    close(math.log2(errors[0] / errors[1]), 4.0, 0.05, "observed order of the reference RK4")


def main():
    with tempfile.TemporaryDirectory() as directory:
        bytes_repeat(directory)
        cc = compiler()
        guards_trip(directory, cc)
        for path in (PAPER, *WELLS):
            out = os.path.join(directory, "wells")
            ran = generate(path, out)
            claim(ran.returncode == 0 and ran.stderr == "", f"{path} is accepted: {ran.stderr.strip()}")
            compiles(out, cc, path)
            fit_is_the_eigensolution(path, read(out, load(path).name + ".c"))
            shapes_fit(path, out)
    table = Table(read(TABLES, "paper.c"))
    tables_of_the_paper(table)
    golden_numbers(table)
    uniform_bar()
    stable_step()
    reference_is_right()
    print(f"{count[True]} passed, {count[False]} failed")
    return 1 if count[False] else 0


if __name__ == "__main__":
    sys.exit(main())
