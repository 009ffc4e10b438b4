"""Where the picture is taken from: at the angles of the scene's cameras, circling once, or following the tip."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.inverse.rotations import rotation_from_quaternion
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_numbers
from contarm_sim.view.rendering.near import with_objects
from contarm_sim.view.sections import section_places

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

FIXED = ("front", "side", "top")
MOVING = ("orbit", "tip")
CAMERAS = FIXED + MOVING

Angles = tuple[float, float]
"""Azimuth and elevation of a camera that stands still [deg]."""

_ELEVATION = 14.0
_AZIMUTH = 118.0
"""Of the moving cameras [deg]: the circle starts where `front` stands."""

_CLOSE = 1.1
"""Distance of the camera that follows the tip, in lengths of the arm."""

_MOMENTS, _AROUND = 60, 24
"""How many moments of a run, and how many places of the circle, cameras are placed by."""


_HOLDER = np.array([[x, y, z] for x in (-0.2, 0.2) for y in (-0.2, 0.2) for z in (-0.15, 0.0)])
"""Points about what holds the base in a host [lengths], base frame."""


def check_camera(name: str | Angles) -> str | Angles:
    """Return a camera's name, or its angles.

    Raises:
        InputError: there is no such camera.
    """
    angles = None if isinstance(name, str) else as_numbers(name)
    if name not in CAMERAS if isinstance(name, str) else (angles is None or len(angles) != 2):
        allowed = ", ".join(CAMERAS) + ("" if isinstance(name, str) else ", or azimuth and elevation [deg]")
        raise InputError("camera", repr(name), allowed)
    return name


def extent(*runs: Trajectory, path: bool = True, ghost: bool = True) -> Array:
    """Return points of the base frame about which all of some runs happens [m], shape (T, 3).

    Args:
        path, ghost: whether targets and analytic arcs are drawn; what is not takes no room.
    """
    found = []
    for run in runs:
        some = np.unique(np.linspace(0, len(run) - 1, _MOMENTS).round().astype(int))
        points = [_carried(run, some, run.stations[some]).reshape(-1, 3)]
        if run.arm.world.host is not None:
            about = np.tile(run.arm.length * _HOLDER, (len(some), 1, 1))
            points.append(_carried(run, some, about).reshape(-1, 3))
        if path:
            points.append(_carried(run, np.arange(len(run)), run.target[:, None])[:, 0])
        if ghost:
            arcs = np.array([[shape.position(bend, run.arm, xi) for xi in section_places(run.arm, 4)]
                             for bend in run.bend[some]])  # fmt: skip
            points.append(_carried(run, some, arcs.reshape(len(some), -1, 3)).reshape(-1, 3))
        found.append(with_objects(np.vstack(points), run.arm, None if run.objects is None else run.objects[some]))
    return np.vstack(found)


def _carried(run: Trajectory, samples: NDArray[np.intp], points: Array) -> Array:
    """Return points of the base frame of samples, shape (T, K, 3), in that of the start: a host may have moved it."""
    if run.base is None:
        return points
    turns = rotation_from_quaternion(run.base[:, 3:])
    world = run.base[samples, None, :3] + points @ turns[samples].transpose(0, 2, 1)
    return np.asarray((world - run.base[0, :3]) @ turns[0])


class Camera:
    """One camera, so placed that it shows points of the world, and the mount.

    `cut_away` says that the mount stands between it and a hanging arm.

    Args:
        name: front, side, top, orbit (one turn a film) or tip; or azimuth and elevation [deg].
        seen: points of the world [m], shape (T, 3); None: all that the arm can touch.
        frame: the picture, an `mjcf.framing.Frame`.
    """

    def __init__(self, name: str | Angles, arm: Arm, seen: Array | None, frame: Any) -> None:
        import mujoco

        from contarm_sim.mjcf.framing import axes, place
        from contarm_sim.mjcf.scene import CAMERAS as ANGLES
        from contarm_sim.mjcf.scene import base_position, base_rotation, workspace

        self.name, self._length = check_camera(name), arm.length
        self._eye = mujoco.MjvCamera()
        self._eye.type = mujoco.mjtCamera.mjCAMERA_FREE
        base, along = base_position(arm), base_rotation(arm)[:, 2]
        self.cut_away = name == "top" and along[2] < -0.1
        radius = 0.0 if seen is None else 1.3 * arm.disk_radius
        if seen is None:
            seen = workspace(arm)
        elif along[2] > 0.1 and arm.world.host is None:
            seen = np.vstack([seen, base, [base[0], base[1], 0.0]])
        else:
            seen = np.vstack([seen, base - 0.1 * arm.length * along])
        if not isinstance(name, str) or name in FIXED:
            azimuth, elevation = ANGLES[name] if isinstance(name, str) else name
            self._look_from(place(seen, radius, axes(azimuth, elevation), frame), azimuth, elevation, seen.mean(axis=0))
        elif name == "orbit":
            middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
            turns = [axes(start, _ELEVATION) for start in np.linspace(0, 360, _AROUND, endpoint=False)]
            flat = np.vstack([(seen - middle) @ turn.T for turn in turns])
            self._middle, (_, self._rise, self._eye.distance) = middle, place(flat, radius, np.eye(3), frame)
            self._eye.elevation = -_ELEVATION
        else:
            self._eye.elevation, self._eye.distance = -_ELEVATION, _CLOSE * arm.length

    def _look_from(self, eye: Array, azimuth: float, elevation: float, near: Array) -> None:
        """Stand at a point [m] and look at what is as far away as another point."""
        from contarm_sim.mjcf.framing import axes

        back = axes(azimuth, elevation)[2]
        self._eye.distance = float((eye - near) @ back)
        self._eye.lookat[:] = eye - self._eye.distance * back
        self._eye.azimuth, self._eye.elevation = azimuth + 180.0, -elevation

    def at(self, tip: Array, share: float) -> Any:
        """Return what the engine's renderer takes for a camera, when the tip is at a point of the world [m].

        Args:
            share: of the film that has passed, 0 to 1.
        """
        from contarm_sim.mjcf.framing import axes

        if self.name == "orbit":
            self._eye.azimuth = _AZIMUTH + 360.0 * share
            up = axes(self._eye.azimuth - 180.0, _ELEVATION)[1]
            self._eye.lookat[:] = self._middle + self._rise * up
        elif self.name == "tip":
            self._eye.lookat[:], self._eye.azimuth = tip, _AZIMUTH
        return self._eye

    @property
    def reach(self) -> float:
        """How far away what it shows can be, floor and shadow among it [m]."""
        return float(self._eye.distance) + 2.6 * self._length
