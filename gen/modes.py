"""Natural modes of a chain of elements (k, m), eq. (23), to the same bits on any machine.

LAPACK's last digits change with the processor, so the solution is our own: Holzer's march from node to node. With the
torque P at a node, one element gives
    delta = (P - 3 w2 m phi) / (k + w2 m),    phi' = phi + delta,    P' = P - w2 m (6 phi + 3 delta)
which never subtracts stiffnesses, so low modes of fine meshes keep all their digits. Marched as the ratio z = P / phi
it cannot overflow, and it is the LDL' factorisation of K - w2 M: the number of sign changes is the number of
eigenvalues below w2 (Sturm). Bisection on that count, a shape from the marches of both ends joined where they
disagree least (twisted factorisation: right also where a mode decays away from that place), and Rayleigh's quotient.

All operations are elementwise + - * / and sqrt over [fc, mode]; loops run over the elements in order.
"""
from dataclasses import dataclass

import numpy as np

import bars as bars_

TINY = 1e-100      # stands for a ratio of exactly 0: z then passes through a number that is as good as infinite


@dataclass(frozen=True)
class Modes:
    w2: np.ndarray       # [fc, mode] rad2/s2
    shape: np.ndarray    # [node, fc, mode], phi' M phi = 1, > 0 at the bit

    @property
    def b(self):
        return self.shape[-1]


def torsion(bars, fc, count):
    """First `count` torsional modes at weights fc [N] (None: without prestress), top node fixed."""
    return solve(bars_.torsion_k(bars, fc), bars.torsion_m, count, fixed_top=True)


def axial(bars, fc, count):
    """First `count` axial modes, free at both ends: mode 0 is rigid and exactly so."""
    k = bars_.axial_k(bars, fc)
    rigid = np.ones((len(bars.x), k.shape[1], 1)) / np.sqrt(bars.mass)
    if count == 1:
        return Modes(np.zeros((k.shape[1], 1)), rigid)
    elastic = solve(k, bars.axial_m, count - 1, fixed_top=False)
    return Modes(np.concatenate([np.zeros((k.shape[1], 1)), elastic.w2], axis=1),
                 np.concatenate([rigid, elastic.shape], axis=2))


def uniform_response(bars, fc, modes):
    """d_i = phi_i' M 1, the coupling to the top node included. Summing the free rows of (K + Kg) phi = w2 M phi leaves
    the reaction at the top: d = phi_1 (k_1 / w2 + m_1), with all digits even where the sum over the nodes cancels."""
    return modes.shape[1] * (bars_.torsion_k(bars, fc)[0][:, None] / modes.w2 + bars.torsion_m[0])


def solve(k, m, count, fixed_top):
    """The lowest `count` elastic modes. k [element, fc], m [element]."""
    k = k[:, :, None]
    w2 = _bisect(k, m, count, fixed_top)
    for _ in range(2):        # the second pass starts from Rayleigh's value, right to the last digits
        shape = _shape(k, m, w2, fixed_top)
        w2 = _rayleigh(k, m, shape)
    shape = shape / np.sqrt(norm2(m, shape))
    return Modes(w2, np.where(shape[-1] < 0.0, -shape, shape))


def norm2(m, shape):
    """phi' M phi, element by element."""
    sum_ = np.zeros(shape.shape[1:])
    for e, me in enumerate(m.tolist()):
        upper, lower = shape[e], shape[e + 1]
        sum_ = sum_ + 2.0 * me * (upper * upper + upper * lower + lower * lower)
    return sum_


def _rayleigh(k, m, shape):
    energy = np.zeros(shape.shape[1:])
    for e in range(len(m)):
        stretch = shape[e + 1] - shape[e]
        energy = energy + k[e] * (stretch * stretch)
    return energy / norm2(m, shape)


def _march(k, m, w2, fixed):
    """Ratios z = P / phi at each node (None at a fixed one) and growth phi'/phi over each element, first to last."""
    z, growth = [None if fixed else np.zeros_like(w2)], []
    for ke, me in zip(k, m.tolist()):
        wm = w2 * me
        if z[-1] is None:
            growth.append(None)
            z.append(ke - 2.0 * wm)
            continue
        delta = (z[-1] - 3.0 * wm) / (ke + wm)
        ratio = 1.0 + delta
        ratio = np.where(ratio == 0.0, TINY, ratio)
        growth.append(ratio)
        z.append((z[-1] - wm * (6.0 + 3.0 * delta)) / ratio)
    return z, growth


def _count(k, m, w2, fixed_top):
    """Number of eigenvalues below w2 (Sturm): sign changes of phi on the way down, and of P at the free end."""
    z, growth = _march(k, m, w2, fixed_top)
    count = np.zeros(w2.shape, dtype=np.int64)
    for ratio in growth:
        if ratio is not None:
            count = count + (ratio < 0.0)
    return count + (z[-1] < 0.0)


def _bisect(k, m, count, fixed_top):
    """Lowest `count` eigenvalues [fc, mode]; a free chain's zero is left out."""
    wanted = np.arange(count)[None, :] + (1 if fixed_top else 2)     # eigenvalue number, from 1
    low = np.zeros((k.shape[1], count))
    # no eigenvalue of the chain exceeds the largest of a single free element, 2 k / m
    high = low + (2.02 * np.max(k[:, :, 0] / m[:, None], axis=0))[:, None]
    while True:
        middle = 0.5 * (low + high)
        if np.all((middle <= low) | (middle >= high)):
            return middle
        below = _count(k, m, middle, fixed_top) >= wanted
        low, high = np.where(below, low, middle), np.where(below, middle, high)


def _shape(k, m, w2, fixed_top):
    """Shapes [node, fc, mode], 1 at the node where the marches from the two ends agree best."""
    down, growth = _march(k, m, w2, fixed_top)
    up, shrink = _march(k[::-1], m[::-1], w2, False)
    up, shrink = up[::-1], shrink[::-1]
    first = 1 if fixed_top else 0
    gap = np.abs(np.stack([a + b for a, b in zip(down[first:], up[first:])]))
    twist = first + np.argmin(gap, axis=0)
    shape = np.ones((len(k) + 1, *w2.shape))
    for e in reversed(range(len(k))):
        shape[e] = np.where(e < twist, 0.0 if growth[e] is None else shape[e + 1] / growth[e], shape[e])
    for e in range(len(k)):
        shape[e + 1] = np.where(e >= twist, shape[e] / shrink[e], shape[e + 1])
    return shape
