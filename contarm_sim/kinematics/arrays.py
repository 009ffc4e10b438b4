"""What the kinematics share: checks of arrays, and sin(x)/x with its slope.

Whole arrays are worked through in blocks of `BLOCK` rows, which stay in the processor's cache.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import factorial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError

Array = NDArray[np.float64]
Number = TypeVar("Number", float, Array)

BLOCK = 8192
FEW = 4  # so many numbers are faster in plain floats, to the same bits

_SERIES_END = 2.4675  # a little more than (pi/2)^2
SINC = [(-1) ** n / factorial(2 * n + 1) for n in range(10, -1, -1)]
_SLOPE = [(-1) ** n * 2 * n / factorial(2 * n + 1) for n in range(10, 0, -1)]


def as_vectors(value: Any, size: int, name: str) -> Array:
    """Return `value` as a float array of shape (..., size).

    Raises:
        InputError: the last axis has another size, or a number is NaN or infinite.
    """
    array = as_floats(value, size, name)
    # A sum is finite only if every term is (or huge terms overflow): one pass, no temporary.
    if not np.isfinite(array.sum()) and not np.isfinite(array).all():
        raise InputError(name, array[~np.isfinite(array).all(axis=-1)][0].tolist(), "finite numbers")
    return array


def as_floats(value: Any, size: int, name: str) -> Array:
    """Return `value` as a float array of shape (..., size), whatever its numbers are.

    Raises:
        InputError: not numbers, or the last axis has another size.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(name, repr(value), f"numbers, shape (..., {size})") from error
    if array.ndim == 0 or array.shape[-1] != size:
        raise InputError(name, f"of shape {array.shape}", f"shape (..., {size})")
    return array


def as_xi(value: Any) -> Array:
    """Return normalised arc lengths as an array.

    Raises:
        InputError: one lies outside [0, 1].
    """
    xi = np.asarray(value, dtype=float)
    if xi.ndim == 0 and 0 <= xi.item() <= 1:
        return xi
    if not np.all((xi >= 0) & (xi <= 1)):
        raise InputError("xi", float(xi[~((xi >= 0) & (xi <= 1))].flat[0]), "0 (base) to 1 (tip)")
    return xi


def blocks(count: int) -> Iterator[slice]:
    """Yield slices of at most `BLOCK` that cover `count` rows."""
    if count > FEW:
        np.empty(64 * BLOCK)  # freed at once, it has glibc keep that much at hand instead of returning every temporary
    for start in range(0, count, BLOCK):
        yield slice(start, start + BLOCK)


def sinc(x: Array) -> Array:
    """Return sin(x)/x, 1 at 0, to full relative precision."""
    return np.divide(np.sin(x), x, out=np.ones_like(x), where=x != 0)


def sinc_slope(x: Array) -> Array:
    """Return sinc'(x)/x = (cos x - sinc x)/x^2, -1/3 at 0, to full relative precision up to |x| = pi.

    From the half angle: with c and g of x/2, cos(x/2) = c + (x/2)^2 g, it is (g cos(x/2) - c^2)/4.
    """
    y = np.square(0.5 * np.asarray(x, dtype=float))
    c, g = sinc_and_slope(y)
    return np.asarray(0.25 * (g * (c + y * g) - c * c))


def sinc_and_slope(y: Number, out: tuple[Any, Any] = (None, None)) -> tuple[Number, Number]:
    """Return c = sin(x)/x and g = (cos x - c)/x^2 of y = x^2 >= 0, to rounding; then cos x = c + y g.

    Up to x = pi/2, half of the largest bend, by series whose dropped terms are below 3e-17: smooth through 0,
    cheaper than a sine, and the same bits for a float, an array of one, or one among many. Beyond, in closed form.
    """
    c, g = polynomial(SINC, y, out[0]), polynomial(_SLOPE, y, out[1])
    if isinstance(y, float):
        return (c, g) if y <= _SERIES_END else _closed(y)
    beyond = y > _SERIES_END
    if beyond.any():
        c[beyond], g[beyond] = _closed(y[beyond])
    return c, g


def polynomial(coefficients: list[float], y: Number, out: Any = None) -> Number:
    """Return the sum of coefficients[-1 - n] y^n; arrays in place after the first product, in `out` if given."""
    if not isinstance(y, float) and y.size <= FEW:
        few = np.array([polynomial(coefficients, one) for one in y.ravel().tolist()]).reshape(y.shape)
        return few if out is None else np.positive(few, out=out)
    value = coefficients[0] * y if out is None else np.multiply(coefficients[0], y, out=out)
    for coefficient in coefficients[1:-1]:
        value += coefficient
        value *= y
    value += coefficients[-1]
    return value


def _closed(y: Number) -> tuple[Number, Number]:
    x = np.sqrt(y)
    c = np.sin(x) / x
    return c, (np.cos(x) - c) / y


class ReadOnly:
    """A frozen dataclass that keeps its arrays to itself: copied when it is made, read-only, in copies of it too."""

    def _keep(self, name: str, array: Any) -> None:
        own = np.array(array, dtype=float)
        own.setflags(write=False)
        object.__setattr__(self, name, own)

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():  # copies and unpickled arrays are writable
            object.__setattr__(self, name, value)
        self.__post_init__()

    def __post_init__(self) -> None:
        """Check what was given, and `_keep` the arrays."""
