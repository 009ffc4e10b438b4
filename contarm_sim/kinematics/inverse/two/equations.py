"""Two sections and a tip position: the equations that leave one free parameter, the first section's bend angle beta1.

Lengths are in units of the backbone's; `pair` has r, a and b of a section. Its end tangents, t = r/(2 cos h) long,
meet in a corner. With P = |p| and rho = hypot(x, y) of the tip p = (x, y, z):

    2 t1 (z + b2) = P^2 - r2^2                              (1)
    rho sin(beta1) cos(psi) = b1 + b2 - z cos(beta1)        (2)

psi is the azimuth of the elbow from that of the target; both signs solve. (1) says that the first section's corner is
as far from the tip as the second section asks for, (2) that the tip lies b2 ahead of the elbow. In (1), r2^2 + 2 t1 b2
falls with beta2, so beta2 is the one root of a monotone function; its slope by y = (beta2/2)^2 vanishes nowhere. A
beta1 is feasible where that root is within the limits and (2) has a cosine within +-1; at +-1 the pose is planar.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array, polynomial
from contarm_sim.kinematics.inverse.result import Index
from contarm_sim.kinematics.inverse.two.pair import Pair

_FEW = 100  # so many places are faster by a product of matrices than by Horner's scheme
_FITTED, _STEPS = 2, 12  # Newton steps on the fits; most of those that follow, mostly one
_SETTLED = 1e-8  # a step's error is its square, or its product with the fit's error


class Targets(NamedTuple):
    """Tip positions in units of the backbone's length, as the equations want them; arrays broadcast.

    Attributes:
        square: squared distance from the base.
        z: heights.
        rho: distances from the axis.
        ux, uy: unit vector of the azimuth; (1, 0) on the axis.
    """

    square: Array
    z: Array
    rho: Array
    ux: Array
    uy: Array

    def at(self, index: Index) -> Targets:
        """Return some of the targets."""
        return Targets(*(x[index] for x in self))

    def columns(self) -> Targets:
        """Return the targets as a column each, to be broadcast against rows of parameters."""
        return Targets(*(x[:, None] for x in self))


def as_targets(points: Array) -> Targets:
    """Return points (n, 3), in units of the backbone's length, as targets."""
    x, y, z = points.T
    rho = np.hypot(x, y)
    off = np.maximum(rho, 1e-300)
    return Targets(rho * rho + z * z, z, rho, np.where(rho > 0, x / off, 1.0), y / off)


def second_half(pair: Pair, corner: Array, value: Array) -> tuple[Array, Array]:
    """Return beta2/2 [rad] of (1), where r2^2 + 2 t1 b2 has a value, or the limit that is nearer to it; and b2.

    Newton steps in y: on the fit alone, then on the functions with the fit's slope.

    Args:
        pair: the sections.
        corner: 2 t1.
        value: what r2^2 + 2 t1 b2 must be.
    """
    most = 0.25 * pair.limits[1] ** 2
    c0, c1, c2 = (x + corner * y for x, y in pair.start)
    c0 -= value
    root = c1 * c1
    root -= 4 * c0 * c2
    root = np.sqrt(np.maximum(root, 0.0, out=root), out=root)
    root -= c1
    c0 *= 2
    y = np.divide(c0, root, out=root)
    np.minimum(np.maximum(y, 0.0, out=y), most, out=y)
    for _ in range(_FITTED):
        f, slope = _fitted(pair, corner, y)
        f -= value
        f /= slope
        y -= f
        np.minimum(np.maximum(y, 0.0, out=y), most, out=y)
    for _ in range(_STEPS):
        h = np.sqrt(y)
        square, b = pair.far(h)
        square += corner * b
        square -= value
        square /= slope
        new = y - square
        np.minimum(np.maximum(new, 0.0, out=new), most, out=new)
        y -= new  # what the step took off
        change = float(np.abs(y).max(initial=0.0))
        if change < _SETTLED:
            y *= _slope_of_b(pair, new)
            b -= y
            return np.sqrt(new), b
        y, slope = new, _fitted(pair, corner, new)[1]
    h = np.sqrt(y)
    return h, pair.far(h)[1]


def _fitted(pair: Pair, corner: Array, y: Array) -> tuple[Array, Array]:
    """Return the fit's value of r2^2 + 2 t1 b2 at y, and its slope."""
    if y.size <= _FEW:
        every = np.power(y[..., None], pair.powers) @ pair.columns
        return every[..., 0] + corner * every[..., 1], every[..., 2] + corner * every[..., 3]
    (s, b), *rest = pair.fit
    f = corner * b
    f += s
    slope: Array | None = None
    for s, b in rest:
        if slope is None:
            slope = f.copy()
        else:
            slope *= y
            slope += f
        f *= y
        f += s
        f += corner * b
    assert slope is not None
    return f, slope


def _slope_of_b(pair: Pair, y: Array) -> Array:
    """Return the fit's slope of b2 by y."""
    if y.size <= _FEW:
        return np.asarray(np.power(y[..., None], pair.powers) @ pair.columns[:, 3])
    return polynomial([k * b for k, (_, b) in zip(range(len(pair.fit) - 1, 0, -1), pair.fit[:-1], strict=True)], y)


class Elbow(NamedTuple):
    """What a parameter beta1 makes of a target: quantities of section 1, and what (1) and (2) say.

    Attributes:
        sine, cosine: of beta1.
        a1, b1: where section 1 ends, to the side and ahead.
        half2: beta2/2 [rad].
        lead: b1 + b2 - z cos beta1, by (2) rho sin(beta1) cos(psi).
        margin: 0 or more where beta1 is feasible.
    """

    sine: Array
    cosine: Array
    a1: Array
    b1: Array
    half2: Array
    lead: Array
    margin: Array


def elbow(pair: Pair, targets: Targets, beta1: Array) -> Elbow:
    """Return what parameters beta1 [rad] make of targets; arrays broadcast."""
    h = 0.5 * beta1
    sine_half, cosine_half, r = np.sin(h), np.cos(h), pair.first.chord(h)
    a1, b1 = r * sine_half, r * cosine_half
    sine, cosine = 2 * sine_half * cosine_half, 1 - 2 * sine_half * sine_half
    corner = r / cosine_half
    value = targets.square - corner * targets.z
    half2, lead = second_half(pair, corner, value)
    lead += b1
    lead -= targets.z * cosine
    (square_most, b_most), (square_least, b_least) = pair.ends
    margin = targets.rho * sine
    margin -= np.abs(lead)
    np.minimum(margin, square_most + corner * b_most - value, out=margin)
    np.minimum(margin, value - square_least - corner * b_least, out=margin)
    return Elbow(sine, cosine, a1, b1, half2, lead, margin)
