"""Two sections in units of the backbone's length: their ends in closed form, and polynomials that are close to them.

With half angle h = beta/2 a section of length l ends at a distance r = l sinc(h) along a chord that leans by h (a chain
of N joints: times x cot x, x = h/N), a = r sin h to the side and b = r cos h ahead. A straight connector e before
section 2 and a tool f after it: b2 += e + f cos beta2, a2 += f sin beta2, and r2 is the distance to the tool's tip.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.checks import check_sections

_TINY = 1e-8  # half bend angle below which sin(h)/h is 1 to the last digit
_DEGREE = 8  # of the polynomials


class Section(NamedTuple):
    """A section in units of the backbone's length: its length, and its links (0: an arc)."""

    length: float
    links: int

    def chord(self, h: Array) -> Array:
        """Return r, the distance from start to end at half bend angles h [rad]."""
        safe = np.maximum(h, _TINY)
        r = np.sin(safe)
        r *= self.length
        r /= safe
        if self.links:
            safe /= self.links
            r *= safe
            r /= np.tan(safe)
        return r


@dataclass(frozen=True)
class Pair:
    """Two sections in units of the backbone's length.

    Attributes:
        backbone: the arm that is 1 long.
        first, second: the sections.
        gap, tool: the connectors e and f.
        limits: largest bend angles [rad].
        ends: r2^2 and b2 of section 2 when it is straight, and at its limit.
        start: coefficients of r2^2 and b2 as quadratics in y = (beta2/2)^2, lowest first.
        fit: coefficients of close polynomials, highest first.
        powers: of y in these.
        columns: these and their slopes as columns; few places are faster by a product of matrices.
    """

    backbone: Backbone
    first: Section
    second: Section
    gap: float
    tool: float
    limits: tuple[float, float]
    ends: tuple[tuple[float, float], tuple[float, float]]
    start: tuple[tuple[float, float], ...]
    fit: tuple[tuple[float, float], ...]
    powers: Array = field(default_factory=lambda: np.arange(_DEGREE, -1, -1.0), compare=False, repr=False)
    columns: Array = field(default_factory=lambda: np.zeros((0, 4)), compare=False, repr=False)

    def far(self, h: Array) -> tuple[Array, Array]:
        """Return r2^2 and b2 at half bend angles h of section 2."""
        cosine, r = np.cos(h), self.second.chord(h)
        b, square = r * cosine, r * r
        if self.gap or self.tool:
            double = 2 * cosine * cosine - 1
            square = square + 2 * (self.gap + self.tool) * b
            square += self.gap**2 + self.tool**2 + 2 * self.gap * self.tool * double
            b = b + self.gap + self.tool * double
        return square, b


@lru_cache(maxsize=64)
def as_pair(backbone: Backbone) -> Pair:
    """Return the two sections of a backbone in units of its length.

    Raises:
        InputError: it has not two sections.
    """
    check_sections(backbone, 2)
    lengths, connectors = (tuple(x / backbone.length for x in xs) for xs in (backbone.lengths, backbone.connectors))
    unit = replace(backbone, lengths=lengths, connectors=connectors)
    first, second = (Section(*x) for x in zip(lengths, backbone.links or (0, 0), strict=True))
    gap, tool = connectors
    limits = backbone.limits[0], backbone.limits[1]
    bare = Pair(unit, first, second, gap, tool, limits, ((0.0, 0.0), (0.0, 0.0)), (), ())
    most = max(0.25 * limits[1] ** 2, 0.5)  # a fit to a shorter interval would be ill-conditioned
    square, b = (x.tolist() for x in bare.far(np.array([0.0, 0.5 * limits[1]])))
    close, start = _fit(bare, most, _DEGREE), _fit(bare, most, 2)
    values = np.array(close)
    slopes = np.zeros_like(values)
    slopes[1:] = values[:-1] * np.arange(_DEGREE, 0, -1.0)[:, None]
    columns = np.concatenate([values, slopes], axis=1)
    return replace(bare, ends=((square[0], b[0]), (square[1], b[1])), start=start[::-1], fit=close, columns=columns)


def _fit(pair: Pair, most: float, degree: int) -> tuple[tuple[float, float], ...]:
    """Return coefficients, highest first, of polynomials through r2^2 and b2 at Chebyshev's places of y."""
    y = 0.5 * most * (1 - np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1)))
    return tuple(zip(*(np.polyfit(y, x, degree).tolist() for x in pair.far(np.sqrt(y))), strict=True))
