"""What keys of recordings and rigs are written as: quantities, units, directions and places along an arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_table import refuse_unknown
from contarm_sim.model.parameters import as_number, as_numbers
from contarm_sim.model.units import factor, quantity

PLACES = ("xi", "at", "station", "place", "section_end")
"""Keys that say where along the arm something is."""

_ENDS = {"base": 0.0, "tip": 1.0}
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_GRAVITY = 9.81


def table(value: Any, name: str, known: Sequence[str]) -> dict[str, Any]:
    """Return a table of TOML.

    Raises:
        InputError: it is none, or has an unknown key (with the nearest known one).
    """
    if not isinstance(value, dict):
        raise InputError(name, value, f"a table with {', '.join(known)}")
    refuse_unknown(value, known, f"{name}.")
    return value


def choice(value: Any, name: str, options: Sequence[str]) -> str:
    """Return a text that is one of a few.

    Raises:
        InputError: it is none of them.
    """
    if not isinstance(value, str) or value not in options:
        given = "missing" if value is None else repr(value) if isinstance(value, str) else value
        raise InputError(name, given, ", ".join(options))
    return value


def one_number(value: Any, unit: str, name: str) -> float:
    """Return a number in an SI unit: bare, or a text with its unit.

    Raises:
        InputError: neither.
    """
    if isinstance(value, str):
        return quantity(value, unit, name)
    found = as_number(value)
    if not math.isfinite(found):
        raise InputError(name, value, f"a number [{unit}], or a text with its unit")
    return found


def numbers(value: Any, unit: str, name: str, size: int | None = None) -> tuple[float, ...]:
    """Return numbers in an SI unit; one alone counts for all of `size`.

    Raises:
        InputError: not as many numbers.
    """
    if isinstance(value, (list, tuple)):
        found = tuple(one_number(one, unit, name) for one in value)
    else:
        found = (one_number(value, unit, name),) * (size or 1)
    if size is not None and len(found) != size:
        raise InputError(name, f"{len(found)} numbers", f"{size}, or one for all")
    return found


def whole(value: Any, name: str, least: int = 1) -> int:
    """Return a whole number.

    Raises:
        InputError: it is none, or is below `least`.
    """
    if isinstance(value, bool) or not isinstance(value, int) or value < least:
        raise InputError(name, value, f"a whole number, at least {least}")
    return value


def in_si(values: Array, unit: Any, allowed: Sequence[str], name: str) -> tuple[Array, str]:
    """Return values of a unit in SI units, and the SI unit.

    Args:
        values: of any shape.
        unit: what is written beside them, or None.
        allowed: SI units that it may be of the kind of; the first is meant where `unit` is None.
        name: of the key, for messages.

    Raises:
        InputError: an unknown unit, or one of another kind.
    """
    if unit is None:
        return values, allowed[0]
    found = factor(unit) if isinstance(unit, str) else None
    for one in allowed:
        own = factor(one)
        if found is not None and own is not None and found[1] == own[1]:
            scale = found[0] / own[0]  # divided where that is exact: 250 mm is 250/1000 m
            inverse = round(1 / scale) if scale < 1 else 0
            return values / inverse if inverse and math.isclose(1 / scale, inverse) else values * scale, one
    some = {"m": "m, mm, cm", "rad": "rad, deg", "N": "N, kN, mN", "Pa": "Pa, kPa, bar", "s": "s, ms, us",
            "kg": "kg, g", "-": "-"}  # fmt: skip
    raise InputError(name, repr(unit), f"a unit such as {', '.join(some.get(one, one) for one in allowed)}")


def direction(value: Any, name: str) -> Array:
    """Return a direction of length 1, shape (3,): "x", "-y" or three numbers.

    Raises:
        InputError: neither, or three zeros.
    """
    found = as_numbers(value)
    if isinstance(value, str) and value.strip().lstrip("+-").lower() in _AXES:
        axis = _AXES[value.strip().lstrip("+-").lower()]
        found = tuple(-x if value.strip().startswith("-") else x for x in axis)
    if found is None or len(found) != 3 or not any(found):
        raise InputError(name, value, 'an axis of the measuring frame such as "z" or "-y", or three numbers')
    return np.array(found) / math.hypot(*found) + 0.0


def gravity_of(value: Any, name: str) -> tuple[float, ...]:
    """Return gravity [m/s^2]: three numbers, or the direction of 9.81 m/s^2.

    Raises:
        InputError: neither.
    """
    if isinstance(value, str):
        return tuple((_GRAVITY * direction(value, name)).tolist())
    return numbers(value, "m/s^2", name, 3) if isinstance(value, (list, tuple)) else tuple(direction(value, name))


def quaternion_of(z: Any, x: Any, name: str) -> tuple[float, ...]:
    """Return the orientation, a quaternion w x y z, of a base whose z axis, and x axis, point in these directions.

    Args:
        x: None: as the shortest turn that takes z there leaves it; about x itself where it is half a turn.

    Raises:
        InputError: no directions, or two that are parallel.
    """
    from scipy.spatial.transform import Rotation

    along = direction(z, f"{name}.z")
    if x is None:
        cosine, axis = float(along[2]), np.array([-along[1], along[0], 0.0])
        sine = math.hypot(*axis)
        turn = axis / sine * math.atan2(sine, cosine) if sine else np.array([0.0 if cosine > 0 else math.pi, 0, 0])
        xyzw = Rotation.from_rotvec(turn).as_quat()
    else:
        across = direction(x, f"{name}.x")
        across = across - along * float(across @ along)
        if math.hypot(*across) < 1e-6:
            raise InputError(f"{name}.x", x, f"a direction that is not along z, {z}")
        across = across / math.hypot(*across)
        xyzw = Rotation.from_matrix(np.stack([across, np.cross(along, across), along], axis=1)).as_quat()
    wxyz = (np.roll(xyzw, 1) * (-1.0 if xyzw[3] < 0 else 1.0)).tolist()
    return tuple(x + 0.0 for x in wxyz)


def place_of(given: dict[str, Any], name: str, arm: Arm | None) -> float:
    """Return a place along the arm as normalised arc length xi; the tip where nothing is said.

    Raises:
        InputError: said twice, off the arm, or in a way that needs the arm where there is none.
    """
    said = [key for key in PLACES if key in given]
    if len(said) > 1:
        raise InputError(name, f"said by {' and '.join(said)}", f"one of {', '.join(PLACES)}")
    if not said:
        return 1.0
    key, value = said[0], given[said[0]]
    where = f"{name}.{key}"
    if key == "xi":
        return one_number(value, "-", where)
    if key == "at":
        return _ENDS[choice(value, where, list(_ENDS))]
    if arm is None:
        raise InputError(where, value, 'xi = 0.5 or at = "tip", or the arm as well: load_recording(path, arm)')
    ends = np.cumsum([0.0, *(section.length for section in arm.sections)])
    if key == "place":
        metres = one_number(value, "m", where)
        if not 0 <= metres <= ends[-1] * (1 + 1e-9):
            raise InputError(where, value, f"a length from 0 to that of the arm, {ends[-1]:g} m")
        return min(1.0, float(metres / ends[-1]))
    most = len(arm.sections) if key == "section_end" else sum(section.links for section in arm.sections)
    number = whole(value, where, 0 if key == "station" else 1)
    if number > most:
        raise InputError(where, number, f"a whole number up to {most}")
    if key == "section_end":
        return float(ends[number] / ends[-1])
    stations = np.cumsum([0, *(section.links for section in arm.sections)])
    return float(np.interp(number, stations, ends) / ends[-1])
