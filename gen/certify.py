"""Proof of the table before a byte of it is written. Each claim is a line for the banner; one that fails refuses the
well. The figures come from elementwise arithmetic only, so they print alike everywhere; LAPACK is asked as a second
opinion, and only its yes or no counts.
"""
import math

import numpy as np

import bars as bars_
import modes as modes_
import reduce as reduce_

ORTHONORMAL_LIMIT = 1e-10
RESIDUAL_LIMIT = 1e-12
RESPONSE_LIMIT = 1e-10
LAPACK_LIMIT = 1e-9             # or LAPACK's own rounding, where the modes spread over more decades than that leaves
EPSILON_FLOAT = 1.2e-7          # of float: what rounding the coefficients costs


class CertifyError(Exception):
    """A claim that does not hold."""


def certify(well, bars, reduction, stable):
    """The lines of the certificate. Raises CertifyError."""
    lines = []
    torsion, axial = reduction.at_points
    k, ka = bars_.torsion_k(bars, reduction.points), bars_.axial_k(bars, reduction.points)
    worst = max(_orthonormality(bars.torsion_m, torsion.shape), _orthonormality(bars.axial_m, axial.shape))
    _claim(lines, worst < ORTHONORMAL_LIMIT, f"phi' M phi = 1 and 0 for all pairs of modes within {worst:.1e}")
    worst = max(_residual(k, bars.torsion_m, torsion, True), _residual(ka, bars.axial_m, axial, False))
    _claim(lines, worst < RESIDUAL_LIMIT, f"eigen residual |(K + Kg) phi - w2 M phi| / (|K + Kg| |phi|): {worst:.1e}")
    ends = [0, len(reduction.points) - 1]
    agree = max(_lapack(k[:, ends], bars.torsion_m, torsion, ends, True),
                _lapack(ka[:, ends], bars.axial_m, axial, ends, False))
    limit = max(_lapack_limit(torsion.w2), _lapack_limit(axial.w2[:, 1:]))
    _claim(lines, agree < limit,
           f"w_i and shapes agree with LAPACK's (flexibility form) within {limit:.0e} at both ends")
    worst = _response(bars, k, torsion)
    _claim(lines, worst < RESPONSE_LIMIT,
           f"d_i = phi_i' M 1 summed over the nodes and from the reaction at the top: {worst:.1e}")
    _claim(lines, bool(np.all(torsion.b > 0.0) and np.all(axial.b > 0.0)), "b_i > 0: signs consistent over f_c")
    lines += _fit_lines(reduction)
    if _is_paper(well, reduction):
        _paper(lines, bars, reduction)
    return lines + stability_lines(well, stable)


def _claim(lines, holds, text):
    if not holds:
        raise CertifyError("not so: " + text)
    lines.append(text)


# ---- modes

def _orthonormality(m, shape):
    """Largest |phi_i' M phi_j - (i == j)| over all pairs and weights."""
    gram = np.zeros((*shape.shape[1:], shape.shape[2]))
    for e, me in enumerate(m.tolist()):
        up, low = shape[e], shape[e + 1]
        gram = gram + me * ((2.0 * up + low)[:, :, None] * up[:, None, :]
                            + (up + 2.0 * low)[:, :, None] * low[:, None, :])
    return float(np.max(np.abs(gram - (np.arange(shape.shape[2])[:, None] == np.arange(shape.shape[2])))))


def _residual(k, m, modes, fixed_top):
    """Backward error of the eigenpairs: what a change of K by this fraction would explain."""
    shape = modes.shape
    row = np.zeros_like(shape)
    size = np.zeros_like(shape)
    for e, me in enumerate(m.tolist()):
        ke, up, low = k[e][:, None], shape[e], shape[e + 1]
        row[e] += ke * (up - low) - modes.w2 * me * (2.0 * up + low)
        row[e + 1] += ke * (low - up) - modes.w2 * me * (up + 2.0 * low)
        size[e] += ke * (np.abs(up) + np.abs(low))
        size[e + 1] += ke * (np.abs(up) + np.abs(low))
    first = 1 if fixed_top else 0
    return float(np.max(np.max(np.abs(row[first:]), axis=0) / np.max(size[first:], axis=0)))


def _lapack(k, m, modes, where, fixed_top):
    """Largest difference from LAPACK, relative, in w2 and in shapes. Solved for the stretches, sqrt(k_e) times the step
    of phi over element e, whose largest eigenvalues 1 / w2 are the wanted ones: an assembled K would lose digits."""
    n, worst = len(m), 0.0
    mass = np.zeros((n + 1, n + 1))
    for e, me in enumerate(m):
        mass[e:e + 2, e:e + 2] += me * np.array([[2.0, 1.0], [1.0, 2.0]])
    below = np.tri(n + 1, n, -1)
    if not fixed_top:           # the part without momentum
        below = below - np.ones((n + 1, 1)) * (mass.sum(axis=0) @ below / mass.sum())
    for column, point in enumerate(where):
        to_shape = below / np.sqrt(k[:, column])
        value, vector = np.linalg.eigh(to_shape.T @ mass @ to_shape)
        first = 0 if fixed_top else 1
        count = modes.w2.shape[1] - first
        if count == 0:
            continue
        w2 = 1.0 / value[::-1][:count]
        shape = (to_shape @ vector[:, ::-1][:, :count]) * np.sqrt(w2)
        shape = np.where(shape[-1] < 0.0, -shape, shape)
        own = modes.shape[:, point, first:]
        worst = max(worst, np.max(np.abs(w2 / modes.w2[point, first:] - 1.0)),
                    np.max(np.max(np.abs(shape - own), axis=0) / np.max(np.abs(own), axis=0)))
    return worst


def _lapack_limit(w2):
    """A rounding of 1 / w2_1 in the last place, seen by the highest mode."""
    spread = float(np.max(w2) / np.min(w2)) if w2.size else 1.0
    return max(LAPACK_LIMIT, 64.0 * 2.3e-16 * spread)


def _response(bars, k, modes):
    """Largest difference of the two ways to d, relative to the largest d of any mode."""
    shape, sum_ = modes.shape, np.zeros(modes.w2.shape)
    for e, m in enumerate(bars.torsion_m.tolist()):
        sum_ = sum_ + 3.0 * m * (shape[e] + shape[e + 1])
    reaction = shape[1] * (k[0][:, None] / modes.w2 + bars.torsion_m[0])
    return float(np.max(np.abs(sum_ - reaction)) / np.max(np.abs(sum_)))


# ---- fit

def _fit_lines(reduction):
    error, lines = reduction.error, []
    _claim(lines, max(error.values()) < reduce_.FIT_LIMIT,
           f"fit of degree {reduction.degree}, {reduction.fc_min / 1000.0:g} to {reduction.fc_max / 1000.0:g} kN, "
           f"{len(reduction.points)} points: relative error")
    for group in (("w2", "b", "d"), ("axial_w2", "axial_b"), ("twist", "axial"), ("twist_gram", "axial_gram")):
        lines.append("  " + ",  ".join(f"{name} {error[name]:.1e}" for name in group))
    single = {name: _float_error(reduction, name) for name in ("w2", "b", "d")}
    _claim(lines, max(single["w2"], single["b"]) < 8.0 * EPSILON_FLOAT,
           "the same evaluated in float:  " + ",  ".join(f"{name} {single[name]:.1e}" for name in single))
    if reduction.fc_max < reduce_.FC_MAX[0]:
        lines.append(f"  the range ends at {reduction.fc_max / 1000.0:g} kN: no fit below 1e-9 for this string up to "
                     f"{reduce_.FC_MAX[0] / 1000.0:g} kN")
    return lines


def _float_error(reduction, name):
    """Error of the table compiled for float, in the kernel's order of operations."""
    f = np.float32
    fc = reduction.points.astype(f)
    s = (fc - f(reduction.fc_mid)) * f(reduction.fc_scale)
    value = reduce_.evaluate(reduction.fit[name].astype(f), s)
    exact = reduce_.evaluate(reduction.fit[name], (reduction.points - reduction.fc_mid) * reduction.fc_scale)
    size = np.max(np.abs(exact), axis=0) if name == "d" else np.abs(exact)
    return float(np.max(np.abs(value - exact) / size))


def stability_lines(well, stable):
    h = well.step_ns * 1e-9
    return [
        f"RK4 at step {well.step_ns} ns: rate {stable.nominal:.1f} 1/s nominal, h rate = {h * stable.nominal:.3f} "
        "<= 2.785;",
        f"  exceeded with probability 1e-6: {stable.rate:.0f} 1/s, h rate = {h * stable.rate:.3f};"
        f"  h max w = {h * stable.fastest:.3f} <= 2.8",
        "  probability that a realisation is refused: "
        + (f"{stable.exceedance:.1e}" if stable.exceedance > 1e-12 else "below 1e-12"),
    ]


# ---- the string of the paper: Tables 1 and 2 as printed, golden numbers of the model

PAPER = ((1400.0, 0.12, 0.095, 80), (200.0, 0.15, 0.095, 40))
PAPER_FC = 100e3
TORSION_HZ = "0.3679 1.2275 2.2039 3.2179 4.2411 5.2575 6.2380 7.1004 7.8407 8.7130"
TORSION_PRESTRESSED_HZ = "0.3681 1.2281 2.2049 3.2194 4.2431 5.2599 6.2407 7.1028 7.8435 8.7168"
AXIAL_HZ = "1.4168 3.0166 4.7244 6.4701 8.2178 9.9314 11.5382 12.9613 14.3927 16.0154"
AXIAL_PRESTRESSED_HZ = "1.4173 3.0179 4.7266 6.4731 8.2216 9.9358 11.5428 12.9659 14.3985 16.0226"


def _is_paper(well, reduction):
    """By content: the name is the user's to choose."""
    sections = tuple((s.length, s.outer, s.inner, s.elements) for s in well.sections)
    return (sections == PAPER and reduction.fc_min <= PAPER_FC <= reduction.fc_max
            and (well.youngs, well.density, well.gravity) == (210e9, 7850.0, 9.81)
            and abs(well.shear * 3.01 / 210e9 - 1.0) < 1e-12)


def _hertz(w2):
    return [f"{math.sqrt(value) / (2.0 * bars_.PI):.4f}" for value in w2.tolist()]


def _paper(lines, bars, reduction):
    s = [(PAPER_FC - reduction.fc_mid) * reduction.fc_scale]
    at = {name: reduce_.evaluate(reduction.fit[name], s)[0] for name in ("w2", "b", "d", "axial_w2")}
    tables = ((reduction.free_w2[:10], TORSION_HZ), (at["w2"][:10], TORSION_PRESTRESSED_HZ),
              (reduction.axial_free_w2[1:11], AXIAL_HZ), (at["axial_w2"][1:11], AXIAL_PRESTRESSED_HZ))
    hits = sum(own == printed for w2, text in tables for own, printed in zip(_hertz(w2), text.split()))
    _claim(lines, hits == 40,
           f"the paper's string: {hits} of 40 frequencies of Tables 1 and 2 equal to the printed decimals")
    b2 = [b * b for b in at["b"].tolist()]
    first = math.sqrt(at["w2"][0]) / (2.0 * bars_.PI)
    golden = (("mass [kg]", bars.mass, 63010, 0.5), ("J [kg m2]", bars.inertia, 201.325, 5e-4),
              ("sum b^2, 1 mode", b2[0], 0.0085134, 5e-8), ("10 modes", sum(b2[:10]), 0.0428560, 5e-8),
              ("20 modes", sum(b2), 0.0769149, 5e-8), ("f_1 [Hz]", first, 0.36808567, 5e-9),
              ("b_1", at["b"][0], 0.0922678, 5e-8), ("|d_1|", abs(at["d"][0]), 12.89665, 5e-6),
              ("b_2", at["b"][1], 0.0605054, 5e-8), ("|d_2|", abs(at["d"][1]), 4.270786, 5e-7))
    for text, value, want, within in golden:
        if not abs(value - want) <= within:
            raise CertifyError(f"not so: {text} = {want:g} for the paper's string, it is {value:.9g}")
    figures = [f"{text} {value:.7g}" for text, value, _, _ in golden]
    lines.append("  golden numbers: " + ", ".join(figures[:2]) + ", " + ", ".join(figures[5:7]) + ",")
    lines.append("  " + ", ".join(figures[7:]) + ",")
    lines.append("  " + ", ".join(figures[2:5]))
