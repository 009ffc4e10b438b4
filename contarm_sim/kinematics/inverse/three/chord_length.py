"""How long a section's chord is, as a function of the cosine between the chord and the section's base.

A section bent by 2 h has the chord rho = length sinc(h), for a chain of N ball joints times x cot x with x = h/N; it
starts at the angle h from the section's base. As a function of c = cos h it is nearly a line (an arc's within 0.8 %)
and smooth beyond c = 0, where the bend passes pi; the polynomial here follows it to 1e-7 of a length.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from contarm_sim.kinematics.arrays import Array, sinc
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.result import Index

LEAST = -0.3
"""Least cosine that the polynomial follows; below it stays what it is there, for scans that pass through."""

_DEGREE, _LOW_DEGREE = 8, 4


@dataclass(frozen=True)
class ChordLength:
    """Chord lengths [m] of one section of each of n arms, from c, the cosine of half its bend: start + slope c + rest.

    Attributes:
        start, slope: of the nearest line, c = 0 to 1 [m], shape (n, 1).
        rest: coefficients of the polynomial that the line leaves [m], the highest power first, shape (9, n, 1).
        low: the same of fewer powers, to some percent, shape (5, n, 1).
    """

    start: Array
    slope: Array
    rest: Array
    low: Array

    def take(self, rows: Index) -> ChordLength:
        """Return those of some arms."""
        return ChordLength(self.start[rows], self.slope[rows], self.rest[:, rows], self.low[:, rows])

    def __call__(self, c: Array) -> Array:
        """Return chord lengths [m]."""
        return self.start + self.slope * c + horner(self.rest, np.maximum(c, LEAST))


def horner(coefficients: Array, x: Array) -> Array:
    """Return the polynomial at x, the highest power first."""
    value = coefficients[0] * x
    for each in coefficients[1:-1]:
        value += each
        value *= x
    value += coefficients[-1]
    return value


def horner_slope(coefficients: Array, x: Array) -> Array:
    """Return the derivative of the polynomial of degree 4 at x."""
    a, b, c, d = coefficients[:4]
    return ((4 * a * x + 3 * b) * x + 2 * c) * x + d


def chord_lengths(backbone: Backbone, sections: list[list[int]]) -> list[ChordLength]:
    """Return chord lengths, one for each place in the arm, of n arms; `sections[k]` says whose each arm has at k."""
    fits = [_fitted(None if backbone.links is None else backbone.links[k]) for k in range(len(backbone))]
    scaled = [length * fit for length, fit in zip(backbone.lengths, fits, strict=True)]
    out = []
    for each in sections:
        table = np.stack([scaled[k] for k in each], axis=-1)[..., None]
        out.append(ChordLength(table[0], table[1], table[2 : _DEGREE + 3], table[_DEGREE + 3 :]))
    return out


def exact(c: Array, links: int | None) -> Array:
    """Return chord lengths over the section's length at cosines c, to rounding."""
    h = np.arccos(c)
    if links is None:
        return sinc(h)
    return np.asarray(sinc(h) * np.cos(h / links) / sinc(h / links))


@cache
def _fitted(links: int | None) -> Array:
    """Return start, slope, and the coefficients of the rest and of its fit of fewer powers, as one vector."""
    start, slope = _coefficients(Chebyshev.interpolate(lambda c: exact(c, links), 1, [0.0, 1.0]), 1)
    rest = Chebyshev.interpolate(lambda c: exact(c, links) - start - slope * c, _DEGREE, [LEAST, 1.0])
    low = Chebyshev.interpolate(rest, _LOW_DEGREE, [0.0, 1.0])
    return np.concatenate([[start, slope], _coefficients(rest, _DEGREE)[::-1], _coefficients(low, _LOW_DEGREE)[::-1]])


def _coefficients(fit: Chebyshev, degree: int) -> Array:
    coefficients = fit.convert(kind=Polynomial, domain=[-1, 1], window=[-1, 1]).coef
    return np.asarray(np.pad(coefficients, (0, degree + 1 - len(coefficients))))
