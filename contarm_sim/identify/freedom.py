"""Which parameters of an arm and of its rig a fit may change, and the vector that it changes.

bending_stiffness, section_2.mass, ...     of the arm, by the names of `model.named`; one value for all sections, or one
section_*.bending_stiffness                one for each section
frame.x, frame.turn_z                      of the rig: the base's position [m] and turn [rad]
marker_1.offset.z, marker.offset.z         of one marker or, one value for all, of each
marker_2.xi
actuation.gain_3, actuation.gain           of one channel, or one value for all
actuation.slack_4, actuation.slack         of one muscle, or one value for all
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.identify.wildcards import spread
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.named import named_parameters, with_parameters

_AXES = "xyz"


@dataclass(frozen=True, kw_only=True, repr=False)
class Free(Told):
    """A parameter that a fit may change.

    Attributes:
        name: see the module.
        low, high: bounds, SI units; None: as wide as the parameter allows.
        mean, sd: of a prior, known from elsewhere, SI units; None: no prior. Normal; of a positive parameter,
            whose logarithm is in the vector, that is, sd / mean wide. `sd` alone is about the value that the arm or rig
            has; `mean` alone is refused.

    Raises:
        InputError: bounds that leave nothing, or a spread that is not above 0.
    """

    name: str
    low: float | None = None
    high: float | None = None
    mean: float | None = None
    sd: float | None = None

    def __post_init__(self) -> None:
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise InputError(f"bounds of {self.name}", (self.low, self.high), "a lower and a higher number")
        if self.sd is not None and not self.sd > 0:
            raise InputError(f"prior of {self.name}", self.sd, "a spread above 0")
        if self.mean is not None and self.sd is None:
            raise InputError(f"prior of {self.name}", self.mean, "a mean and a spread")


@dataclass(frozen=True)
class Freedom:
    """The free parameters of an arm in a rig, one number each.

    Positive parameters, and gains that start above 0, go into the vector by their logarithm (a stiffness may be wrong
    by a factor), unless they start at 0. A lower bound of a gain at or below 0 leaves its sign open.

    Attributes:
        arm, rig: where they start from.
        free: the parameters, stars written out.
        units: of each.
        logarithmic: whether the vector has the logarithm.
    """

    arm: Arm
    rig: Rig
    free: tuple[Free, ...]
    units: tuple[str, ...]
    logarithmic: tuple[bool, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the parameters."""
        return tuple(one.name for one in self.free)

    def values(self, arm: Arm | None = None, rig: Rig | None = None) -> Array:
        """Return the parameters' values of an arm in a rig, SI units, shape (P,); default where they start from."""
        return values_of(self.arm if arm is None else arm, self.rig if rig is None else rig, self.names)

    def vector(self, values: Array) -> Array:
        """Return the vector of parameters' values, shape (..., P)."""
        return np.where(self.logarithmic, np.log(np.maximum(values, 1e-300)), values)

    def of_vector(self, vector: Array) -> Array:
        """Return the parameters' values of a vector, shape (..., P)."""
        inside = np.where(self.logarithmic, np.minimum(vector, 700.0), 0.0)
        return np.where(self.logarithmic, np.exp(inside), vector)

    def applied(self, values: Array) -> tuple[Arm, Rig]:
        """Return the arm and the rig that have these values, shape (P,).

        Raises:
            InputError: values that an arm or a rig cannot have.
        """
        known = named_parameters(self.arm)
        of_arm = {name: x for name, x in zip(self.names, values.tolist(), strict=True) if name in known}
        rig = self.rig
        for name, value in zip(self.names, values.tolist(), strict=True):
            if name not in known:
                rig = _in_rig(rig, name, value)
        return with_parameters(self.arm, of_arm) if of_arm else self.arm, rig

    def bounds(self) -> tuple[Array, Array]:
        """Return the lowest and the highest vector, shape (P,) each."""
        known = named_parameters(self.arm)
        low, high = np.full(len(self.free), -np.inf), np.full(len(self.free), np.inf)
        for place, one in enumerate(self.free):
            least, below = _allowed(one.name, known, self.arm)
            low[place] = least if one.low is None else max(one.low, least)
            high[place] = below if one.high is None else min(one.high, below)
        return self.vector(low), self.vector(high)


def freedom(arm: Arm, rig: Rig, free: Sequence[Free | str]) -> Freedom:
    """Return the free parameters of an arm in a rig.

    Raises:
        InputError: none, one twice, two of which one is part of the other, an unknown name (with the nearest known
            one), a parameter that is no number, one value for several that start from different ones, or bounds that
            the parameter cannot have or that leave its start out.
    """
    given = [one if isinstance(one, Free) else Free(name=one) for one in free]
    if not given:
        raise InputError("free", "nothing", "one parameter or more")
    known = free_names(arm, rig)
    every = [replace(one, name=name) for one in given for name in meant(one.name, arm, known)]
    _check_apart([one.name for one in every])
    of_arm, start = named_parameters(arm), values_of(arm, rig, [one.name for one in every])
    logarithmic = []
    for one, value in zip(every, start.tolist(), strict=True):
        _check_alike(one.name, value, known, arm, rig)
        least, _ = _allowed(one.name, of_arm, arm)
        gain = one.name.startswith("actuation.gain") and not (one.low is not None and one.low <= 0)
        logarithmic.append((least == 0 or gain) and value > 0)
        _check_bounds(one, value, _allowed(one.name, of_arm, arm))
    return Freedom(arm, rig, tuple(every), tuple(known[one.name] for one in every), tuple(logarithmic))


def values_of(arm: Arm, rig: Rig, names: Sequence[str]) -> Array:
    """Return what parameters are of an arm in a rig, SI units, shape (P,); one value for several: of the first."""
    known = named_parameters(arm)
    return np.array([_value(name, known, arm, rig) for name in names], dtype=float)


def meant(name: str, arm: Arm, known: Iterable[str]) -> list[str]:
    """Return the known names that a name, perhaps with a star, stands for.

    Raises:
        InputError: none; a parameter that is no number or that the arm leaves out, such as friction: there is nothing
            to start from. It says what would do.
    """
    given = named_parameters(arm)
    known = list(known)
    every = spread(name, known, given)
    for one in every:
        if one not in known:
            value, last = given[one].value(arm), one.split(".")[-1]
            if value is None:
                raise InputError(one, "omitted", f"a value in the arm's file to start from, such as {last} = 0.05")
            raise InputError(one, f"{value!r}", "a number: a fit changes numbers alone")
    return every


def _check_apart(names: Sequence[str]) -> None:
    """Refuse one parameter twice, and one that is part of another, as `section_1.mass` of `mass`."""
    for place, name in enumerate(names):
        for other in names[:place]:
            if name == other:
                raise InputError("free", name, "each parameter once")
            (one, mine), (two, theirs) = _parts(name), _parts(other)
            if one == two and all(a is None or b is None or a == b for a, b in zip(mine, theirs, strict=True)):
                raise InputError("free", f"{other} and {name}", "one of them: each says what the other is")


def _parts(name: str) -> tuple[str, tuple[str | None, str | None]]:
    """Return a name without numbers, and the numbers of its section and of what else it counts."""
    section = re.match(r"section_(\d+)\.", name)
    rest = name[section.end() :] if section else name
    number = re.search(r"_(\d+)(?=\.|$)", rest)
    bare = rest.replace(number[0], "", 1) if number else rest
    return bare, (section[1] if section else None, number[1] if number else None)


def _check_alike(name: str, value: float, known: Iterable[str], arm: Arm, rig: Rig) -> None:
    """Refuse one value for several that start from different ones: the arm could not keep what it has."""
    bare, own = _parts(name)
    others = [
        other
        for other in known
        for base, numbers in [_parts(other)]
        if base == bare and all(a in (None, b) for a, b in zip(own, numbers, strict=True))
    ]
    for other, has in zip(others, values_of(arm, rig, others).tolist(), strict=True):
        if not math.isclose(has, value, rel_tol=1e-9, abs_tol=1e-12):
            starred = re.sub(r"_\d+", "_*", other)
            raise InputError(name, f"{value:g} in one place, {has:g} in another", f"one start for all, or {starred}")


def _check_bounds(one: Free, value: float, allowed: tuple[float, float]) -> None:
    low, high = -math.inf if one.low is None else one.low, math.inf if one.high is None else one.high
    if (low < allowed[0] and one.low is not None) or (high > allowed[1] and one.high is not None):
        said = " to ".join(f"{each:g}" for each in allowed if math.isfinite(each))
        said = f"numbers within {said}" if math.isfinite(allowed[1]) else f"numbers above {said}, or at it"
        raise InputError(f"bounds of {one.name}", f"{low:g} to {high:g}", said)
    if not low <= value <= high:
        raise InputError(one.name, value, f"a start within its bounds, {low:g} to {high:g}")


def free_names(arm: Arm, rig: Rig) -> dict[str, str]:
    """Return the units of all parameters that a fit may change, by name."""
    found = {}
    for name, one in named_parameters(arm).items():
        value = one.value(arm)
        if isinstance(value, float):
            found[name] = one.unit
    found |= {f"frame.{axis}": "m" for axis in _AXES} | {f"frame.turn_{axis}": "rad" for axis in _AXES}
    for owner in ("marker", *(f"marker_{k + 1}" for k in range(len(rig.markers)))):
        found |= {f"{owner}.offset.{axis}": "m" for axis in _AXES} | {f"{owner}.xi": "-"}
    unit = {"windings": "m", "tensions": "N", "pressures": "Pa", "none": "-"}[rig.actuation.drive]
    gains, muscles = len(rig.actuation.gains), len(rig.actuation.slack)
    for name, own, count in (("gain", f"{unit}/command", gains), ("slack", unit, muscles)):
        if count:
            found |= {f"actuation.{name}{part}": own for part in ("", *(f"_{k + 1}" for k in range(count)))}
    return found


def _allowed(name: str, known: dict[str, Any], arm: Arm) -> tuple[float, float]:
    """Return what a parameter is above or at least, and what it is below; 0 where it is positive."""
    one = known.get(name)
    if one is None:
        return (0.0, 1.0) if name.endswith(".xi") else (-math.inf, math.inf)
    low, high = one.interval(arm)
    return low, high


def _value(name: str, known: dict[str, Any], arm: Arm, rig: Rig) -> float:
    if name in known:
        return float(known[name].value(arm))
    part, _, rest = name.partition(".")
    if part == "frame":
        vector = rig.turn if rest.startswith("turn_") else rig.position
        return vector[_AXES.index(rest[-1])]
    if part.startswith("marker"):
        marker = rig.markers[int(part[7:] or 1) - 1]
        return marker.xi if rest == "xi" else marker.offset[_AXES.index(rest[-1])]
    kind, number = _numbered(rest)
    return (rig.actuation.gains if kind == "gain" else rig.actuation.slack)[number or 0]


def _in_rig(rig: Rig, name: str, value: float) -> Rig:
    part, _, rest = name.partition(".")
    if part == "frame":
        field = "turn" if rest.startswith("turn_") else "position"
        return replace(rig, **{field: _put(getattr(rig, field), _AXES.index(rest[-1]), value)})
    if part.startswith("marker"):
        own = range(len(rig.markers)) if part == "marker" else (int(part[7:]) - 1,)
        markers = list(rig.markers)
        for place in own:
            old = markers[place]
            change = {"xi": value} if rest == "xi" else {"offset": _put(old.offset, _AXES.index(rest[-1]), value)}
            markers[place] = replace(old, **change)
        return replace(rig, markers=tuple(markers))
    kind, number = _numbered(rest)
    field = "gains" if kind == "gain" else "slack"
    old = getattr(rig.actuation, field)
    new: Any = (value,) * len(old) if number is None else _put(old, number, value)
    return replace(rig, actuation=replace(rig.actuation, **{field: new}))


def _numbered(rest: str) -> tuple[str, int | None]:
    found = re.fullmatch(r"([a-z]+)(?:_(\d+))?", rest)
    assert found is not None  # names are those of `free_names`
    return found[1], int(found[2]) - 1 if found[2] else None


def _put(values: tuple[float, ...], place: int, value: float) -> Any:
    return (*values[:place], value, *values[place + 1 :])
