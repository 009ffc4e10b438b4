"""How a load drives the muscles: the controls that it means, and the pose to start from."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, routing
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.mjcf import Actuation
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Drive, Load

COMMON_MODE = 0.01
"""Common length change that is put down to rounding [lengths]."""

DRIVEN: dict[Drive, tuple[bool, Actuation]] = {
    "off": (False, "none"), "tensions": (False, "tensions"), "pressures": (True, "pressures"),
    "deltas": (True, "lengths"), "setpoints": (True, "lengths"), "bend": (True, "lengths"),
}  # fmt: skip
"""Whether muscles only pull, and what drives them in the engine, by how a load drives them."""


def driven_plant(arm: Arm, load: Load, make: Callable[..., Plant] = Plant) -> Plant:
    """Return a plant with muscles driven as a load says, posed for a first guess, its controls set."""
    kind = load.muscles.kind
    bend, control = commands(arm, kind, checked_values(arm, load))
    pull_only, actuation = DRIVEN[kind]
    plant = make(arm, pull_only=pull_only, actuation=actuation)
    plant.reset(bend)
    if kind != "off":
        plant.control[:] = control
        plant.pressure[:] = control if kind == "pressures" else plant.pressure
    return plant


def checked_values(arm: Arm, load: Load) -> Array:
    """Return the numbers that a load drives an arm's muscles with.

    Raises:
        InputError: not as many as it has muscles, or sections.
    """
    kind, values = load.muscles.kind, np.array(load.muscles.values)
    count, sections = muscles.count(arm), len(arm.sections)
    if kind == "bend" and len(values) != 2 * sections:
        allowed = f"{2 * sections} finite numbers, bend angle and plane angle of each section"
        raise InputError("muscles bend", values.tolist(), allowed)
    if kind not in ("off", "bend") and len(values) != count:
        raise InputError(f"muscles {kind}", values.tolist(), f"{count} finite numbers, one for each muscle")
    return values


def commands(arm: Arm, kind: Drive, values: Array) -> tuple[Array | None, Array]:
    """Return the bend to start from [rad], shape (..., 2 S), or None: straight; and controls, shape (..., M).

    Args:
        values: of a load, or of many that drive muscles alike, shape (..., V).

    Raises:
        InputError: bends that pulling muscles cannot hold, no bends, or pressures out of range.
    """
    if kind in ("off", "tensions"):
        return None, values
    if kind == "pressures":
        return None, _checked_pressures(arm, values)
    if kind == "setpoints":
        return _bend_about(arm, values), values
    if kind == "bend":
        bend = arc.from_polar(values[..., ::2], values[..., 1::2]).reshape(*values.shape[:-1], -1)
    elif values.ndim == 1:
        bend = _bend_of(arm, values)
    else:
        bend = np.array([_bend_of(arm, deltas) for deltas in values])
    lengths = routing.lengths_from_bend(bend, arm)
    return bend, servo_control(lengths, holding_tensions(bend, arm), arm)


def _bend_about(arm: Arm, setpoints: Array) -> Array:
    """Return the bend [rad], shape (..., 2 S), that servos told so [m], shape (..., M), about make: a first guess."""
    bend, _ = routing.bend_from_lengths(muscles.each(arm, lambda group: group.length) + setpoints, arm)
    angle = np.hypot(bend[..., ::2], bend[..., 1::2])
    return np.asarray(bend * np.repeat(np.minimum(1.0, 0.9 * np.pi / np.maximum(angle, 1e-9)), 2, axis=-1))


def _bend_of(arm: Arm, deltas: Array) -> Array:
    """Return the bend [rad] that length changes [m] ask for.

    Raises:
        InputError: no bend of an inextensible backbone has them.
    """
    allowed = "length changes of a bend below 180 deg, which sum to nearly nothing"
    if len(arm.sections) > 1:
        allowed = "length changes of bends below 180 deg, which sum to nearly nothing in each section"
    straight, own = muscles.each(arm, lambda group: group.length), muscles.slices(arm)
    if np.any(np.abs(deltas) >= straight):
        raise InputError("muscles deltas", deltas.tolist(), allowed)
    bend, residual = routing.bend_from_lengths(straight + deltas, arm)
    common = min(abs(residual), max(abs(deltas[part].mean()) for part in own))  # of links, or of arcs
    angle = np.hypot(bend[::2], bend[1::2]).max()
    if angle >= np.pi or common > COMMON_MODE * min(section.length for section in arm.sections):
        raise InputError("muscles deltas", deltas.tolist(), allowed)
    return bend


def _checked_pressures(arm: Arm, pressures: Array) -> Array:
    first = 0
    for group in arm.groups:
        law, end = group.pneumatics, first + group.routing.count
        low, high = law.pressure_limits
        own, rounding = pressures[..., first:end], 1e-9 * high
        if np.any((own > high + rounding) | ((own > 0) & (own < low - rounding))):
            of_section = f" for muscles of section {group.section + 1}" if len(arm.sections) > 1 else ""
            raise InputError("muscles pressures", own.tolist(), f"0, or {low:g} to {high:g} Pa{of_section}")
        first = end
    return pressures
