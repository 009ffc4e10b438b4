"""The controls of what loads the arm: how it is mounted, gravity, payload."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.inputs import slider, value

_MOUNTED = {"hanging": (0.0, 0.0, 1.0), "upright": (0.0, 0.0, -1.0), "sideways": (-1.0, 0.0, 0.0)}
"""Which way gravity points in the base frame, whose +Z is the straight arm."""


class Loads:
    """Mounting, gravity and payload."""

    def __init__(self, gui: Any, arm: Arm) -> None:
        strength = float(np.linalg.norm(arm.gravity))
        self._world, self._ways = arm.world, dict(_MOUNTED)
        chosen = "upright"
        if strength:
            own = np.array(arm.gravity) / strength
            chosen = next((name for name, way in _MOUNTED.items() if np.allclose(own, way)), "")
            if not chosen or arm.base_orientation is not None:
                chosen = f"tilted by {np.degrees(np.arccos(np.clip(-own[2], -1, 1))):.0f}°"
                self._ways = {chosen: tuple(own), **_MOUNTED}
        self._given = chosen
        with gui.add_folder("Load"):
            self._mount = gui.add_dropdown(
                "mounted", tuple(self._ways), initial_value=chosen, hint="How the straight arm points from its mount."
            )
            self._gravity = slider(gui, "gravity [m/s²]", (0.0, max(9.81, strength)), 0.01, strength)
            self._payload = slider(gui, "payload [g]", (0, max(200.0, 2e3 * arm.payload)), 5, 1e3 * arm.payload)
        self._hosted = arm.world.host is not None
        self._mount.disabled = self._gravity.disabled = self._hosted  # its host says both
        self.controls = (self._mount, self._gravity, self._payload)

    def connect(self, on: Callable[[Any, Callable[[], None]], None], action: Callable[[], None]) -> None:
        """Call an action when a person sets something."""
        for control in self.controls:
            on(control, action)

    def put_on(self, arm: Arm) -> Arm:
        """Return an arm under the load that the controls say."""
        if self._hosted:
            return replace(arm, payload=1e-3 * value(self._payload))
        # A hair of gravity keeps the picture's way down while it is turned off.
        x, y, z = (max(value(self._gravity), 1e-9) * part for part in self._ways[self._mount.value])
        base = self._world.base_orientation if self._mount.value == self._given else None
        return replace(arm, gravity=(x, y, z), base_orientation=base, payload=1e-3 * value(self._payload))


def turned(one: Arm, other: Arm) -> bool:
    """Return whether two arms are mounted in different ways."""
    return one.base_orientation != other.base_orientation or not np.allclose(_down(one), _down(other))


def _down(arm: Arm) -> Array:
    gravity = np.array(arm.gravity)
    return gravity / max(float(np.linalg.norm(gravity)), 1e-300)
