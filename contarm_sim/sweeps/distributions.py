"""What one parameter of many cases may be: values, a range, or a probability distribution; as TOML has it.

    payload = [0, "50 g", "100 g"]
    bending_stiffness = { from = 0.05, to = 2.0, count = 9, scale = "log" }
    mass = { distribution = "normal", mean = "300 g", std = "5 %" }
    payload = { distribution = "uniform", low = 0, high = "100 g" }
    muscle.braid_friction = { distribution = "lognormal", mean = 0.1, std = 0.02, most = 0.3 }

Numbers are in SI units, texts carry their unit; a standard deviation in % is one of the mean.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.parameters import as_number
from contarm_sim.model.units import quantity

MOST_VALUES = 100_000
"""Most values of one parameter in a grid."""

LEAST_LEFT = 1e-9
"""Least share of a distribution that limits may leave."""

_RANGE = ("from", "to", "count", "scale")
_KEYS = {
    "normal": ("mean", "std", "least", "most"),
    "lognormal": ("mean", "std", "least", "most"),
    "uniform": ("low", "high"),
}


class Varied(ABC):
    """What a parameter may be."""

    @abstractmethod
    def at(self, share: Array) -> list[Any]:
        """Return the values below which these shares of all lie (quantiles), shares in (0, 1), shape (n,)."""

    def grid(self, name: str) -> list[Any]:
        """Return the values that a grid tries.

        Raises:
            InputError: a distribution has none.
        """
        raise InputError(name, "a distribution", "values, or from, to and count, in a grid")


@dataclass(frozen=True)
class Values(Varied):
    """Some values, each as likely as the others."""

    values: tuple[Any, ...]

    def at(self, share: Array) -> list[Any]:
        """Return the values by quantile."""
        last = len(self.values) - 1
        return [self.values[min(int(x * len(self.values)), last)] for x in share]

    def grid(self, name: str) -> list[Any]:
        """Return all values."""
        return list(self.values)


@dataclass(frozen=True)
class Range(Varied):
    """All numbers of an interval alike, or, where `log`, of its logarithm."""

    low: float
    high: float
    count: int | None
    log: bool

    def at(self, share: Array) -> list[Any]:
        """Return the values by quantile."""
        if self.log:
            return [float(x) for x in self.low * (self.high / self.low) ** share]
        return [float(x) for x in self.low + (self.high - self.low) * share]

    def grid(self, name: str) -> list[Any]:
        """Return evenly spaced values, both ends included.

        Raises:
            InputError: without a count.
        """
        if self.count is None:
            raise InputError(name, "a range without count", "count, in a grid: { from = 0.1, to = 1, count = 10 }")
        inside = self.at(np.arange(self.count) / (self.count - 1))[1:-1]
        return [self.low, *inside, self.high]


@dataclass(frozen=True)
class Normal(Varied):
    """A normal distribution, or, where `log`, a lognormal one: of a quantity with this mean and deviation.

    Attributes:
        mean, std: of the quantity itself, before limits cut it.
        least, most: limits outside of which there is nothing.
    """

    mean: float
    std: float
    log: bool
    least: float
    most: float

    def at(self, share: Array) -> list[Any]:
        """Return the values by quantile."""
        from scipy.special import ndtri

        middle, width = self._law()
        low, high, above = self._cut(middle, width)
        drawn = ndtri(low + (1 - share if above else share) * (high - low))
        drawn = middle + width * (-drawn if above else drawn)
        found = np.exp(drawn) if self.log else drawn
        return [float(x) for x in np.clip(found, self.least, self.most)]

    def left(self) -> float:
        """Return the share of the distribution that the limits leave."""
        low, high, _ = self._cut(*self._law())
        return float(high - low)

    def _law(self) -> tuple[float, float]:
        """Return mean and deviation of what is normal: the quantity, or its logarithm."""
        if not self.log:
            return self.mean, self.std
        width = math.sqrt(math.log1p((self.std / self.mean) ** 2))
        return math.log(self.mean) - 0.5 * width**2, width

    def _cut(self, middle: float, width: float) -> tuple[float, float, bool]:
        """Return the shares below both limits; where these are above the mean, above them, which keeps the digits."""
        from scipy.special import ndtr

        low, high = (self._standard(limit, middle, width) for limit in (self.least, self.most))
        return (ndtr(-high), ndtr(-low), True) if low > 0 else (ndtr(low), ndtr(high), False)

    def _standard(self, limit: float, middle: float, width: float) -> float:
        if self.log:
            limit = math.log(limit) if limit > 0 else -math.inf
        return (limit - middle) / width


def varied_from(table: Any, name: str, unit: str) -> Varied:
    """Return what a parameter may be, from what a TOML file or a Python dict says of it.

    Args:
        name: of the parameter, for messages.
        unit: of its values, "-" for none.

    Raises:
        InputError: an unknown key, an empty range, no values, or a distribution without its numbers.
    """
    if isinstance(table, (list, tuple)):
        return _values(table, name, unit)
    if not isinstance(table, dict):
        raise InputError(name, table, "a list of values, { from, to, count } or { distribution = ..., ... }")
    if "values" in table:
        _refuse_others(table, ("values",), name)
        return _values(table["values"], name, unit)
    if "distribution" in table:
        return _distribution(table, name, unit)
    if not {"from", "to"} & set(table) and set(table) & {key for keys in _KEYS.values() for key in keys}:
        raise InputError(f"{name}.distribution", "missing", ", ".join(_KEYS))
    _refuse_others(table, _RANGE, name)
    return _range(table, name, unit)


def _values(values: Any, name: str, unit: str) -> Values:
    if not isinstance(values, (list, tuple)) or not values:
        raise InputError(name, values, "one value or more")
    if len(values) > MOST_VALUES:
        raise InputError(name, f"{len(values)} values", f"at most {MOST_VALUES}")
    return Values(tuple(_in_si(value, name, unit) for value in values))


def _range(table: dict[str, Any], name: str, unit: str) -> Range:
    low, high = (_number(table, key, name, unit) for key in ("from", "to"))
    scale, count = table.get("scale", "linear"), table.get("count")
    if scale not in ("linear", "log"):
        raise InputError(f"{name}.scale", scale, "linear, log")
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= MOST_VALUES):
        raise InputError(f"{name}.count", count, f"a whole number from 2, both ends, to {MOST_VALUES}")
    if not low < high:
        raise InputError(name, f"an empty range, from {low:g} to {high:g}", "from below to")
    if scale == "log" and low <= 0:
        raise InputError(f"{name}.from", low, "more than 0 on a scale that is log")
    return Range(low, high, count, scale == "log")


def _distribution(table: dict[str, Any], name: str, unit: str) -> Varied:
    kind = table["distribution"]
    if not isinstance(kind, str) or kind not in _KEYS:
        raise InputError(f"{name}.distribution", kind, ", ".join(_KEYS))
    _refuse_others(table, ("distribution", *_KEYS[kind]), name)
    if kind == "uniform":
        low, high = (_number(table, key, name, unit) for key in ("low", "high"))
        if not low < high:
            raise InputError(name, f"an empty range, from {low:g} to {high:g}", "low below high")
        return Range(low, high, None, False)
    mean = _number(table, "mean", name, unit)
    std = _deviation(table, mean, name, unit)
    least, most = (_number({key: table.get(key, other)}, key, name, unit, math.inf) for key, other in
                   (("least", -math.inf), ("most", math.inf)))  # fmt: skip
    if kind == "lognormal" and mean <= 0:
        raise InputError(f"{name}.mean", mean, "more than 0 of a lognormal distribution")
    if not least < most or (kind == "lognormal" and most <= 0):
        raise InputError(name, f"an empty range, least {least:g}, most {most:g}", "least below most")
    law = Normal(mean, std, kind == "lognormal", least, most)
    if law.left() < LEAST_LEFT:
        raise InputError(name, f"cut off from {least:g} to {most:g}", "limits that leave some of the distribution")
    return law


def _deviation(table: dict[str, Any], mean: float, name: str, unit: str) -> float:
    given = table.get("std")
    if isinstance(given, str) and given.strip().endswith("%"):
        try:
            std = abs(mean) * float(given.strip()[:-1]) / 100
        except ValueError:
            std = math.nan
    else:
        std = _number(table, "std", name, unit)
    if not 0 < std < math.inf:
        such = '"5 %" of the mean' if mean else "a number: the mean is 0, of which % are nothing"
        raise InputError(f"{name}.std", given, f"a standard deviation above 0, such as {such}")
    return std


def _number(table: dict[str, Any], key: str, name: str, unit: str, most: float = 1e12) -> float:
    if key not in table:
        raise InputError(f"{name}.{key}", "missing", f"a number{'' if unit == '-' else f' [{unit}]'}")
    value = as_number(_in_si(table[key], f"{name}.{key}", unit))
    if not abs(value) <= most:
        raise InputError(f"{name}.{key}", table[key], "a finite number")
    return value


def _in_si(value: Any, name: str, unit: str) -> Any:
    if isinstance(value, (list, tuple)):
        return tuple(_in_si(x, name, unit) for x in value)
    return quantity(value, unit, name) if isinstance(value, str) and unit != "-" else value


def _refuse_others(table: dict[str, Any], known: tuple[str, ...], name: str) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{name}.{key}", "unknown", f"{did_you_mean(key, known)}All: {', '.join(known)}")
