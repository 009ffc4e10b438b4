"""Array checks shared by the kinematics: vectors in, finite, of the stated size."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError

Array = NDArray[np.float64]


def as_vectors(value: Any, size: int, name: str) -> Array:
    """Return `value` as a float array of shape (..., size).

    Raises:
        InputError: the last axis has another size, or a number is NaN or infinite.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(name, repr(value), f"numbers, shape (..., {size})") from error
    if array.ndim == 0 or array.shape[-1] != size:
        raise InputError(name, f"of shape {array.shape}", f"shape (..., {size})")
    # A sum is finite only if every term is (or huge terms overflow): one pass, no temporary.
    if not np.isfinite(array.sum()) and not np.isfinite(array).all():
        raise InputError(name, array[~np.isfinite(array).all(axis=-1)][0].tolist(), "finite numbers")
    return array


def as_xi(value: Any) -> Array:
    """Return normalised arc lengths as an array.

    Raises:
        InputError: one lies outside [0, 1].
    """
    xi = np.asarray(value, dtype=float)
    if not np.all((xi >= 0) & (xi <= 1)):
        raise InputError("xi", value, "0 (base) to 1 (tip)")
    return xi


def sinc(x: Array) -> Array:
    """Return sin(x)/x, 1 at 0, to full relative precision."""
    return np.divide(np.sin(x), x, out=np.ones_like(x), where=x != 0)


def sinc_slope(x: Array) -> Array:
    """Return sinc'(x)/x = (cos x - sinc x)/x^2, -1/3 at 0.

    The closed form cancels like eps/x^2, so below 0.5 a series takes over (its first
    dropped term is 1e-18 there).
    """
    small = np.abs(x) < 0.5
    safe = np.where(small, 1.0, x)
    y = np.where(small, x, 0.0) ** 2
    series = -1 / 3 + y * (
        1 / 30 - y * (1 / 840 - y * (1 / 45360 - y * (1 / 3991680 - y * (1 / 518918400 - y / 93405312000))))
    )
    return np.where(small, series, (np.cos(safe) - np.sin(safe) / safe) / safe**2)
