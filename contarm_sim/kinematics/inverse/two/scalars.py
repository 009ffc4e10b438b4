"""Many equations and minima of one unknown at once: brackets that shrink, by secants and parabolas where they can."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.result import Index

Function = Callable[[Array, Index], Array]
"""Values at unknowns x (n,) of the rows `index` (n,) of a problem."""

_GOLDEN = 0.3819660112501051
_END = 0.06  # share of a bracket that is stepped from its end: the minimum is often just there
_ROUNDING = 1e-15  # value that a better place would not lower
_LEAST = 1e-10  # smallest step


def crossings(function: Function, out: Array, inside: Array, f_out: Array, f_in: Array, width: float) -> Array:
    """Return where functions cross zero: the inner end of a bracket that is narrow, or where the value is rounding.

    Args:
        function: below 0 at `out`, 0 or more at `inside`; continuous.
        out, inside: ends of the brackets, in any order, shape (n,).
        f_out, f_in: values there.
        width: of a bracket that is narrow enough.
    """
    out, inside, f_out, f_in = (np.array(x, dtype=float) for x in (out, inside, f_out, f_in))
    left, side = np.flatnonzero(np.abs(out - inside) > width), np.zeros(len(out), dtype=int)
    for count in range(60):
        if not left.size:
            break
        a, b, fa, fb = out[left], inside[left], f_out[left], f_in[left]
        share = fb / (fb - fa) if count % 4 < 3 else np.full(len(left), 0.5)
        least = np.minimum(0.4 * width / np.abs(a - b), 0.25)  # a step past the root closes the bracket
        share = np.minimum(np.maximum(share + least, least), 1 - least)
        x = b + share * (a - b)
        f = function(x, left)
        good = f >= 0
        # Illinois: an end that stays twice counts half
        last, now = side[left], np.where(good, 1, -1)
        fa = np.where(good & (last == 1), 0.5 * fa, fa)
        fb = np.where(~good & (last == -1), 0.5 * fb, fb)
        out[left], f_out[left] = np.where(good, a, x), np.where(good, fa, f)
        inside[left], f_in[left] = np.where(good, x, b), np.where(good, f, fb)
        side[left] = now
        left = left[(np.abs(out[left] - inside[left]) > width) & ~(good & (f < _ROUNDING))]
    return inside


def minima(
    function: Function,
    low: Array,
    middle: Array,
    high: Array,
    values: tuple[Array, Array, Array],
    steps: int = 12,
    settled: float = 1e-6,
) -> tuple[Array, Array]:
    """Return where functions are least, and how small, shape (n,) each: Brent's method.

    Args:
        function: of one minimum between `low` and `high`.
        low, middle, high: brackets, shape (n,); the value at `middle` is least of the three; it may lie at an end.
        values: at the three.
        steps: most evaluations.
        settled: step after which no more are made.
    """
    a, x, c = (np.array(v, dtype=float) for v in (low, middle, high))
    fa, fx, fc = values
    if not x.size:
        return x, fx
    w, fw = np.where(fa <= fc, a, c), np.minimum(fa, fc)  # second best, third best
    v, fv = np.where(fa <= fc, c, a), np.maximum(fa, fc)
    last = before_last = c - a
    rows = np.arange(len(x))
    for _ in range(steps):
        # the vertex of the parabola through the best three
        r, q = (x - w) * (fx - fv), (x - v) * (fx - fw)
        p, q = (x - v) * q - (x - w) * r, 2 * (q - r)
        step = -p / np.where(q == 0, 1e-300, q)
        left, right = x - a, c - x
        inner = (np.abs(step) < 0.5 * np.abs(before_last)) & (step > -left) & (step < right) & (q != 0)
        share = np.where((left == 0) | (right == 0), _END, _GOLDEN)
        step = np.where(inner, step, np.where(right > left, share * right, -share * left))
        step = np.where(np.abs(step) < _LEAST, np.where(right > left, _LEAST, -_LEAST), step)
        before_last, last = last, step
        new = x + step
        f = function(new, rows)
        better, ahead = f <= fx, step > 0
        a = np.where(better == ahead, np.where(better, x, new), a)
        c = np.where(better != ahead, np.where(better, x, new), c)
        second = (f <= fw) | (w == x)
        third = ~better & ~second & ((f <= fv) | (v == x) | (v == w))
        v, fv = (
            np.where(better | second, w, np.where(third, new, v)),
            np.where(better | second, fw, np.where(third, f, fv)),
        )
        w, fw = np.where(better, x, np.where(second, new, w)), np.where(better, fx, np.where(second, f, fw))
        x, fx = np.where(better, new, x), np.where(better, f, fx)
        if np.abs(step).max() < settled:
            break
    return x, fx
