"""Modes at some weights on bit -> short polynomials in s = (fc - fc_mid) fc_scale that hold at every weight.

Interpolation at Chebyshev nodes, written out in powers of s (degree <= 7 on [-1, 1]: no digits lost). The error is
taken at evenly spaced points, none of which is used by the interpolation.
"""
from dataclasses import dataclass

import numpy as np

import bars as bars_
import modes as modes_
from well import FC_MIN, MODES_MAX

FIT_LIMIT = 1e-9
POINTS = 34                    # where the fit is compared, both ends included; even: the middle is a Chebyshev node
# cos((2 k + 1) pi / (2 n)) >= 0 for n = degree + 1 nodes: literals, since cos() differs between machines
CHEBYSHEV = {
    3: (0.9238795325112867, 0.3826834323650898),
    4: (0.9510565162951535, 0.5877852522924731, 0.0),
    5: (0.9659258262890683, 0.7071067811865476, 0.25881904510252074),
    6: (0.9749279121818236, 0.7818314824680298, 0.4338837391175582, 0.0),
    7: (0.9807852804032304, 0.8314696123025452, 0.5555702330196022, 0.19509032201612825),
}
# Upper ends of the fit [N], the first that works. A string so light that 1000 kN buckles the linear bar gets less.
FC_MAX = (1e6, 5e5, 2e5, 1e5, 5e4, 2e4, 1e4)
QUANTITIES = ("w2", "b", "d", "axial_w2", "axial_b", "twist", "axial", "twist_gram", "axial_gram")


class ReduceError(Exception):
    """No fit with the promised error exists."""


@dataclass(frozen=True)
class Reduction:
    degree: int
    fc_min: float
    fc_max: float
    fc_mid: float
    fc_scale: float
    nodes: int
    fit: dict                  # quantity -> coefficients [degree + 1, ...]
    error: dict                # quantity -> largest relative error at the points
    points: np.ndarray         # weights at which the fit was compared [N]
    at_points: tuple           # (torsional Modes, axial Modes) there
    free_w2: np.ndarray        # without prestress
    axial_free_w2: np.ndarray


def reduce(well, bars):
    """The shortest fit below FIT_LIMIT over the widest range, never below twice the nominal weight."""
    count = (min(well.elements, MODES_MAX), min(well.elements + 1, max(11, well.axial)))
    reasons = []
    for fc_max in (f for f in FC_MAX if f >= 2.0 * well.fc):
        fc_mid, fc_scale = 0.5 * (FC_MIN + fc_max), 2.0 / (fc_max - FC_MIN)
        points = np.array([FC_MIN + (fc_max - FC_MIN) * i / (POINTS - 1) for i in range(POINTS)])
        if not _definite(bars, points):
            reasons.append(f"no positive stiffness up to {fc_max / 1000.0:g} kN")
            continue
        at_points = _modes(bars, points, count)
        want = quantities(bars, points, *at_points)
        for degree in CHEBYSHEV:
            fit = _fit(bars, degree, fc_mid, fc_scale, count)
            error = _errors(fit, want, (points - fc_mid) * fc_scale)
            if max(error.values()) < FIT_LIMIT:
                free = _modes(bars, None, count)
                return Reduction(degree, FC_MIN, fc_max, fc_mid, fc_scale, len(bars.x), fit, error, points, at_points,
                                 free[0].w2[0], free[1].w2[0])
        worst = max(error, key=error.get)
        reasons.append(f"error {error[worst]:.0e} in {worst} with degree 7 up to {fc_max / 1000.0:g} kN")
    raise ReduceError("no fit over the weight on bit below 1e-9: " + "; ".join(reasons))


def quantities(bars, fc, torsion, axial):
    """Everything that is fitted, first axis f_c."""
    return {
        "w2": torsion.w2, "b": torsion.b, "d": modes_.uniform_response(bars, fc, torsion),
        "axial_w2": axial.w2, "axial_b": axial.b,
        "twist": torsion.shape.transpose(1, 2, 0), "axial": axial.shape.transpose(1, 2, 0),
        "twist_gram": _gram(torsion.shape), "axial_gram": _gram(axial.shape),
    }


def evaluate(coefficients, s):
    """Horner's rule, as kelly_poly does it: coefficients [degree + 1, ...] at s [n] -> [n, ...]."""
    s = np.asarray(s).reshape((-1,) + (1,) * (coefficients.ndim - 1))
    value = coefficients[-1] + 0.0 * s
    for c in coefficients[-2::-1]:
        value = c + s * value
    return value


def _definite(bars, fc):
    return bool(np.all(bars_.axial_k(bars, fc) > 0.0) and np.all(bars_.torsion_k(bars, fc) > 0.0))


def _modes(bars, fc, count):
    return modes_.torsion(bars, fc, count[0]), modes_.axial(bars, fc, count[1])


def _gram(shape):
    """Lower triangle of the sums over the nodes of phi_i phi_j, row by row: [fc, pair]."""
    pairs = [(i, j) for i in range(shape.shape[2]) for j in range(i + 1)]
    row, column = (np.array(p) for p in zip(*pairs))
    sum_ = np.zeros((shape.shape[1], len(pairs)))
    for node in shape:
        sum_ = sum_ + node[:, row] * node[:, column]
    return sum_


def _fit(bars, degree, fc_mid, fc_scale, count):
    half = CHEBYSHEV[degree]
    x = [-c for c in half] + [c for c in reversed(half) if c != 0.0]
    fc = np.array([fc_mid + c / fc_scale for c in x])
    s = ((fc - fc_mid) * fc_scale).tolist()
    return {name: _interpolate(s, value) for name, value in quantities(bars, fc, *_modes(bars, fc, count)).items()}


def _interpolate(s, value):
    """Newton's divided differences, then multiplied out into powers of s."""
    divided = [v for v in value]
    n = len(s)
    for level in range(1, n):
        for i in range(n - 1, level - 1, -1):
            divided[i] = (divided[i] - divided[i - 1]) / (s[i] - s[i - level])
    power = [divided[n - 1]] + [np.zeros_like(divided[0])] * (n - 1)
    for i in range(n - 2, -1, -1):                       # power = divided[i] + (s - s[i]) power
        power = [divided[i] - s[i] * power[0]] + [power[j - 1] - s[i] * power[j] for j in range(1, n)]
    return _no_dust(np.stack(power))


def _no_dust(coefficients):
    """Powers below 1e-30 are rounding of a zero, and too small for a float literal."""
    return np.where(np.abs(coefficients) < 1e-30, 0.0, coefficients)


def _errors(fit, want, s):
    """Largest relative error of each quantity. Frequencies and b never vanish and are taken relative to themselves;
    d may pass through zero: relative to its largest over the range; shapes and Gram matrices: to the largest entry."""
    error = {}
    for name, exact in want.items():
        size = np.abs(exact)
        if name == "d":
            size = np.max(size, axis=0, keepdims=True)
        elif name in ("twist", "axial"):
            size = np.max(size, axis=(0, 2), keepdims=True)
        elif name.endswith("_gram"):
            size = np.max(size)
        difference = np.abs(evaluate(fit[name], s) - exact)
        error[name] = float(np.max(np.where(difference == 0.0, 0.0, difference / np.where(size == 0.0, 1e-300, size))))
    return error
