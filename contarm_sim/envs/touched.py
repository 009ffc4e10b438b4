"""What is seen of all that an arm can touch, where its world has objects: named quantities, as those of `state`.

    quantity             size   unit   scaled by
    object_positions     3 F    m      L0; of the free objects, in the base frame
    object_orientations  4 F    -      1; quaternions w x y z in the base frame
    object_velocities    3 F    m/s    1 m/s; in the base frame
    object_rates         3 F    rad/s  10 rad/s; in the base frame
    touching             P S    -      links of the section; how many of each section's links touch each partner
    touch_forces         3 P S  N      1 N; the sum of what each section feels of each partner, in the base frame

F is the number of free objects, S that of sections, P that of partners: the world's objects in their order, and the arm
itself where its links touch one another. Numbers of the first partner come first. Forces are those of the engine's last
step, 5 ms before the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.index import ArmIndex, Indices
from contarm_sim.envs.state import State
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm

SPEED, RATE, FORCE = 1.0, 10.0, 1.0
"""What velocities [m/s], rates [rad/s] and forces [N] are scaled by."""

ANGULAR = "rate"

_KIND = mujoco.mjtSensor
RATES = ((names.VELOCITY, _KIND.mjSENS_FRAMELINVEL), (ANGULAR, _KIND.mjSENS_FRAMEANGVEL))
"""Sensors of how each free object moves."""


def add_rate_sensors(spec: mujoco.MjSpec, arm: Arm) -> None:
    """Add sensors of how free objects move, in the base frame."""
    for name in arm.world.movable:
        for quantity, kind in RATES:
            spec.add_sensor(
                name=names.sensor(name, quantity), type=kind, objtype=mujoco.mjtObj.mjOBJ_XBODY, objname=name,
                reftype=mujoco.mjtObj.mjOBJ_SITE, refname=names.BASE,
            )  # fmt: skip


def rate_sensors(arm: Arm) -> list[str]:
    """Return the names of the sensors of how free objects move."""
    return [names.sensor(name, quantity) for name in arm.world.movable for quantity, _ in RATES]


def touched_sizes(arm: Arm) -> dict[str, int]:
    """Return how many numbers each quantity has; nothing of an arm that can touch nothing."""
    free, count = len(arm.world.movable), len(names.partners(arm)) * len(arm.sections)
    if not count:
        return {}
    moving = {
        "object_positions": 3 * free,
        "object_orientations": 4 * free,
        "object_velocities": 3 * free,
        "object_rates": 3 * free,
    }
    return {name: size for name, size in (moving | {"touching": count, "touch_forces": 3 * count}).items() if size}


def touched_scales(arm: Arm) -> dict[str, tuple[float, Any]]:
    """Return (offset, scale) of every quantity."""
    links = np.tile([float(section.links) for section in arm.sections], len(names.partners(arm)))
    return {
        "object_positions": (0.0, arm.length),
        "object_orientations": (0.0, 1.0),
        "object_velocities": (0.0, SPEED),
        "object_rates": (0.0, RATE),
        "touching": (0.0, links),
        "touch_forces": (0.0, FORCE),
    }


@dataclass(frozen=True)
class Columns:
    """Where in the engine's sensor data the touch of P partners, poses and rates of F free objects are.

    Attributes:
        touch: shape (P, K, 7), see `ArmIndex`.
        poses: shape (F, 7).
        rates: shape (F, 6).
    """

    touch: Indices
    poses: Indices
    rates: Indices

    @classmethod
    def of(cls, model: mujoco.MjModel, index: ArmIndex, arm: Arm) -> Columns:
        """Find them in a model with `add_rate_sensors`."""
        first = [int(model.sensor(name).adr[0]) for name in rate_sensors(arm)]
        rates = np.array(first, dtype=int)[:, None] + np.arange(3)
        return cls(index.touch, index.poses, rates.reshape(-1, 6))

    def read(self, sensors: Array, arm: Arm) -> State:
        """Return the quantities of sensor data, shape (B, sensors)."""
        return touched(sensors[:, self.touch], sensors[:, self.poses], sensors[:, self.rates], arm)


def touched(touch: Array, poses: Array, rates: Array, arm: Arm) -> State:
    """Return the quantities of arms, each of shape (B, size).

    Args:
        touch: how many contacts, their force on the partner [N] and where [m], shape (B, P, K, 7).
        poses: positions [m] and orientations of free objects, shape (B, F, 7).
        rates: velocities [m/s] and rates [rad/s], shape (B, F, 6).
    """
    count, starts = len(touch), names.section_stations(arm)
    links, forces = [], []
    for first, last in zip((-1, *starts[1:-1]), starts[1:], strict=True):
        own = touch[:, :, first + 1 : last + 1]
        number, force = np.zeros(own.shape[:2]), np.zeros((*own.shape[:2], 3))
        for station in range(own.shape[2]):  # term by term: the same bits alone or among others
            number, force = number + (own[:, :, station, 0] > 0), force - own[:, :, station, 1:4]
        links.append(number)
        forces.append(force)
    moving = {"object_positions": poses[..., :3], "object_orientations": poses[..., 3:]}
    moving |= {"object_velocities": rates[..., :3], "object_rates": rates[..., 3:]}
    felt = {"touching": np.stack(links, axis=2), "touch_forces": np.stack(forces, axis=2)}
    return {name: value.reshape(count, -1) for name, value in (moving | felt).items() if value.size}
