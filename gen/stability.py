"""May classical RK4 take the step of the well file? A bound on the fastest rate of a realisation, under its gamma laws.

    rate = mu (fc + f0) (1 + a1) sum b_i(fc)^2 + beta max w_i(fc)^2                [1/s]
is the slope of the bit torque at standstill seen by the modes used, plus their own damping. RK4 follows it while
h rate <= 2.785; a realisation above that is refused by the kernel. The generator accepts a step only if at most one
realisation in a million would be, and if h max w_i <= 2.8 (2.828 is RK4's limit for a pure oscillation).

The probability is a double sum over gamma laws on grids even in ln x, where the trapezoid rule converges fast. Only
elementwise + - * / and sums in a fixed order, with an exponential of our own: the figures go into the banner.
"""
import math
from dataclasses import dataclass

import numpy as np

import reduce as reduce_

RATE_LIMIT = 2.785
OSCILLATION_LIMIT = 2.8
PROBABILITY = 1e-6
GRID_FC, GRID_A1, GRID_TAIL = 601, 241, 4001


@dataclass(frozen=True)
class Stability:
    nominal: float        # rate of the nominal case [1/s]
    rate: float           # exceeded with probability 1e-6 [1/s]
    fastest: float        # largest w_i of the modes used, over the range of the fit [rad/s]
    exceedance: float     # probability that a realisation is refused at the step of the well file
    step_max: float       # largest safe step [s]


def stability(well, reduction):
    laws = _laws(well, reduction)
    rate = _quantile(laws)
    nominal = _at_mean(well, reduction)
    # rounded up to integers because the _Static_assert of the table compares integers
    rate = float(math.ceil(rate))
    torsion = math.sqrt(float(np.max(reduction.at_points[0].w2[:, :well.torsional])))
    axial = math.sqrt(float(np.max(reduction.at_points[1].w2[:, :well.axial])))
    fastest = math.ceil(max(torsion, axial) * 1000.0) / 1000.0
    step_max = min(RATE_LIMIT / rate, OSCILLATION_LIMIT / fastest)
    return Stability(nominal, rate, fastest, _exceeds(laws, RATE_LIMIT / (well.step_ns * 1e-9)), step_max)


def is_safe(well, result):
    """The same integers as in the _Static_assert."""
    return (well.step_ns * int(result.rate) <= 2785000000
            and well.step_ns * round(result.fastest * 1000.0) <= 2800000000000)


# ---- rate at a weight on bit

def _gain(well, reduction, fc):
    """(fc + f0) sum b_i^2 and beta max w_i^2 at weights fc; outside the fit (refused anyway) the end's values."""
    s = (np.clip(fc, reduction.fc_min, reduction.fc_max) - reduction.fc_mid) * reduction.fc_scale
    b = reduce_.evaluate(reduction.fit["b"], s)
    w2 = reduce_.evaluate(reduction.fit["w2"], s)
    sum_ = np.zeros(len(fc))
    for i in range(well.torsional):
        sum_ = sum_ + b[:, i] * b[:, i]
    return (fc + well.f0) * sum_, well.beta * w2[:, well.torsional - 1]


def _at_mean(well, reduction):
    gain, damping = _gain(well, reduction, np.array([well.fc]))
    return float(well.mu * (1.0 + well.a1) * gain[0] + damping[0])


# ---- gamma laws without libm

def excess(t):
    """e^t - 1 - t without cancellation: a series on t / 1024, then e^2t - 1 - 2t = 2 u + (u + t)^2."""
    t = t / 1024.0
    u = np.zeros_like(t)
    for n in range(8, 2, -1):
        u = t / n * (1.0 + u)
    u = 0.5 * t * t * (1.0 + u)
    for _ in range(10):
        e = u + t
        u, t = 2.0 * u + e * e, 2.0 * t
    return u


def gamma_grid(cov, n):
    """Values relative to the mean and weights, summing to 1, of the gamma law of shape 1 / cov^2; cov 0: no spread.
    In t = ln(x / mean) the density is exp(-shape (e^t - 1 - t)); the grid ends where that is below 1e-17."""
    if cov == 0.0:
        return np.array([1.0]), np.array([1.0])
    low, high = -(9.0 * cov + 45.0 * cov * cov), 9.0 * cov
    t = low + (high - low) / (n - 1) * np.arange(n)
    u = excess(t)
    v = u / (cov * cov)
    weight = 1.0 / (1.0 + _expm1(v))
    return 1.0 + (u + t), weight / math.fsum(weight.tolist())


def _expm1(v):
    """e^v - 1 for 0 <= v; capped at 700, where the weight has long vanished."""
    v = np.minimum(v, 700.0)
    return excess(v) + v


class Tail:
    """P(X > x) of a gamma law of mean 1, linear between fine grid points."""

    def __init__(self, cov):
        self.x, weight = gamma_grid(cov, GRID_TAIL)
        self.fixed = cov == 0.0
        self.above = np.cumsum(weight[::-1])[::-1] - 0.5 * weight

    def __call__(self, x):
        if self.fixed:
            return (x < 1.0) * 1.0
        i = np.clip(np.searchsorted(self.x, x), 1, len(self.x) - 1)
        x0, x1, p0, p1 = self.x[i - 1], self.x[i], self.above[i - 1], self.above[i]
        inside = p0 + (p1 - p0) * ((x - x0) / (x1 - x0))
        return np.where(x <= self.x[0], 1.0, np.where(x >= self.x[-1], 0.0, inside))


# ---- the law of the rate

@dataclass(frozen=True)
class Laws:
    gain: np.ndarray       # over the grid of fc
    damping: np.ndarray
    fc_weight: np.ndarray
    scale: np.ndarray      # over the grid of the second factor: what `tail` has to exceed is y / scale - shift
    shift: float
    scale_weight: np.ndarray
    tail: Tail
    top: float             # [1/s] certainly above the quantile


def _laws(well, reduction):
    """mu (1 + a1) gain(fc): fc on a grid; a1 on a grid and mu by its tail, or, where mu is fixed, a1 by its tail."""
    cov_fc, cov_mu, cov_a1 = well.cov[:3]
    fc, fc_weight = gamma_grid(cov_fc, GRID_FC if cov_mu or cov_a1 else GRID_TAIL)
    gain, damping = _gain(well, reduction, well.fc * fc)
    if cov_mu:
        a1, weight = gamma_grid(cov_a1, GRID_A1)
        scale, shift, tail = well.mu * (1.0 + well.a1 * a1), 0.0, Tail(cov_mu)
    else:
        scale, shift, weight = np.array([well.mu * well.a1]), 1.0 / well.a1, np.array([1.0])
        tail = Tail(cov_a1)
    top = well.mu * (1.0 + well.a1) * float(np.max(gain)) * 1000.0 + float(np.max(damping)) + 1.0
    return Laws(gain, damping, fc_weight, scale, shift, weight, tail, top)


def _exceeds(laws, rate):
    """P(rate of a realisation > rate)."""
    y = (rate - laws.damping) / laws.gain
    above = laws.tail(y[:, None] / laws.scale[None, :] - laws.shift)
    above = above * (laws.fc_weight[:, None] * laws.scale_weight[None, :])
    return math.fsum(above.ravel().tolist())


def _quantile(laws):
    """The rate that is exceeded with PROBABILITY, to 1e-6 of itself."""
    low, high = 0.0, laws.top
    for _ in range(200):
        middle = 0.5 * (low + high)
        if high - low < 1e-6 * high:
            break
        if _exceeds(laws, middle) > PROBABILITY:
            low = middle
        else:
            high = middle
    return high
