"""The string as linear bar elements, prestressed by gravity and the weight on bit.

Consistent mass, two degrees of freedom a node (axial, torsion); with theta'_S = 0 they do not couple. An element is
    stiffness  k [ 1 -1]      mass  m [2 1]
                 [-1  1]              [1 2]
so k and m say everything. Arrays run over the elements from the top down.

Every operation is a numpy elementwise + - * / in a fixed order: the bits do not depend on the machine.
"""
from dataclasses import dataclass

import numpy as np

PI = 3.141592653589793


@dataclass(frozen=True)
class Bars:
    length: np.ndarray          # [m]
    x: np.ndarray               # nodes: distance from the top [m]
    youngs: float               # [Pa]
    shear: float                # [Pa]
    area: np.ndarray            # [m2]
    polar: np.ndarray           # Ip, polar moment of the section [m4]
    axial_m: np.ndarray         # rho A l / 6 [kg]
    torsion_m: np.ndarray       # rho Ip l / 6 [kg m2]
    hanging: np.ndarray         # weight that the element carries when nothing pushes from below [N]
    mass: float                 # of the string [kg]
    inertia: float              # J = 1'M1 [kg m2]


def total(values):
    """Sum from the first to the last: np.sum groups by the vector width."""
    sum_ = 0.0
    for value in values.tolist():
        sum_ = sum_ + value
    return sum_


def build(well):
    """Well -> Bars."""
    columns = []
    for s in well.sections:
        outer2, inner2 = s.outer * s.outer, s.inner * s.inner
        columns += [(s.length / s.elements, PI / 4.0 * (outer2 - inner2),
                     PI / 32.0 * (outer2 * outer2 - inner2 * inner2))] * s.elements
    length, area, polar = (np.array(c) for c in zip(*columns))
    axial_m = well.density * area * length / 6.0
    torsion_m = well.density * polar * length / 6.0
    nodes = [0.0]
    for element in length.tolist():
        nodes.append(nodes[-1] + element)
    return Bars(length=length, x=np.array(nodes), youngs=well.youngs, shear=well.shear, area=area, polar=polar,
                axial_m=axial_m, torsion_m=torsion_m, hanging=_hanging(axial_m * 6.0 * well.gravity),
                mass=6.0 * total(axial_m), inertia=6.0 * total(torsion_m))


def _hanging(weight):
    """u_S = K^-1 f_g with the top clamped is statically determinate: each element carries what hangs below its
    lower node, and half of itself, because consistent loads put half of its weight on either node."""
    carried, below = np.zeros_like(weight), 0.0
    for e in reversed(range(len(weight))):
        carried[e] = below + 0.5 * weight[e]
        below = below + weight[e]
    return carried


def strain(bars, fc):
    """u'_S [element, fc] at weights on bit fc [N], eq. (21): tension positive."""
    return (bars.hanging[:, None] - fc[None, :]) / (bars.youngs * bars.area)[:, None]


def axial_k(bars, fc=None):
    """Element stiffness [element, fc], eqs. (15), (16) with theta'_S = 0; without prestress where fc is None."""
    k = (bars.youngs * bars.area / bars.length)[:, None]
    if fc is None:
        return k
    u = strain(bars, fc)
    return k * (1.0 + 3.0 * u + 1.5 * (u * u))


def torsion_k(bars, fc=None):
    """As axial_k for torsion. The geometric part has E, not G: eq. (16) as printed, which gives Table 1."""
    k = (bars.polar / bars.length)[:, None]
    if fc is None:
        return k * bars.shear
    u = strain(bars, fc)
    return k * (bars.shear + bars.youngs * (u + 0.5 * (u * u)))
