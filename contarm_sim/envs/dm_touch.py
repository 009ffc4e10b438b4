"""Sensors of what an arm touches in an arena, and of the free objects there, in PyMJCF; see `touched`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.envs.state import State
from contarm_sim.envs.touched import ANGULAR, touched
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.model.arm import Arm

_POSE = ((names.POSITION, "framepos"), (names.ORIENTATION, "framequat"))
_RATE = ((names.VELOCITY, "framelinvel"), (ANGULAR, "frameangvel"))


@dataclass(frozen=True)
class TouchSensors:
    """PyMJCF elements: of each partner and station, and of each free object's pose and motion in the base frame."""

    touch: list[Any]
    poses: list[Any]
    rates: list[Any]

    @classmethod
    def added(cls, root: Any, arm_model: Any, arm: Arm) -> TouchSensors:
        """Add sensors to an arena, which has the objects; those of the arm and itself are in its own model."""

        def contact(partner: str, station: str) -> Any:
            name = names.touch_sensor(station, partner, names.TOUCH)
            if partner == names.BASE:
                return arm_model.find("sensor", name)
            bodies = {"body1": arm_model.find("body", station), "body2": root.find("body", partner)}
            return root.sensor.add("contact", name=name, data="found force pos", reduce="netforce", num=1, **bodies)

        def frame(name: str, quantity: str, kind: str) -> Any:
            return root.sensor.add(
                kind, name=names.sensor(name, quantity), objtype="xbody", objname=root.find("body", name),
                reftype="site", refname=arm_model.find("site", names.BASE),
            )  # fmt: skip

        free = arm.world.movable
        return cls(
            [contact(partner, station) for partner in names.partners(arm) for station in names.stations(arm)],
            [frame(name, *what) for name in free for what in _POSE],
            [frame(name, *what) for name in free for what in _RATE],
        )

    def read(self, physics: Any, base: Array, arm: Arm) -> State:
        """Return the quantities of `touched`, with an axis of one arm.

        Args:
            base: the base's rotation in the arena, shape (3, 3).
        """
        partners, stations = len(names.partners(arm)), len(names.stations(arm))
        touch = self._of(physics, self.touch, 7).reshape(1, partners, stations, 7)
        touch[..., 1:4] = touch[..., 1:4] @ base
        poses = [self._of(physics, self.poses[part::2], width) for part, width in ((0, 3), (1, 4))]
        rates = self._of(physics, self.rates, 3).reshape(1, -1, 6)
        return touched(touch, np.concatenate(poses, axis=-1)[None], rates, arm)

    @staticmethod
    def _of(physics: Any, sensors: list[Any], width: int) -> Array:
        """Return what sensors of equal width read, shape (sensors, width)."""
        if not sensors:
            return np.empty((0, width))
        first = np.atleast_1d(physics.model.sensor_adr[physics.bind(sensors).element_id])
        return np.array(physics.data.sensordata[first[:, None] + np.arange(width)])
