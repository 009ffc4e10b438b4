"""How far points are from the objects of an arm's world, as the engine measures it on the shapes that it simulates."""

from __future__ import annotations

import mujoco
import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import TIMESTEP, arm_spec
from contarm_sim.mjcf.backbone import links
from contarm_sim.model.arm import Arm

_PROBE = "probe"
_PROBE_RADIUS = 1e-9
"""Radius of the sphere that measures [m]."""

_FAR = 1e3
"""Farthest distance measured [m]."""

_APART = 1e-6
"""How far apart normals are compared, to find how the surface is curved [m]; a tenth of small distances."""


class Surroundings:
    """The objects around an arm, held where they stand.

    Attributes:
        objects: the arm's.
        radii: of what touches at the arm's stations [m], shape (K,).
    """

    def __init__(self, arm: Arm) -> None:
        spec = arm_spec(arm.without_memory, "none", TIMESTEP)
        spec.worldbody.add_geom(
            name=_PROBE, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_PROBE_RADIUS, 0, 0], contype=0, conaffinity=0
        )
        self._model = model = spec.compile()
        model.opt.ccd_tolerance, model.opt.ccd_iterations = 1e-12, 200
        self._data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, self._data, 0)
        mujoco.mj_kinematics(model, self._data)
        self.objects = arm.world.objects
        self.radii = np.array([link.contact_radius for link in links(arm)])
        self._geoms = [model.geom(each.name).id for each in self.objects]
        self._probe = self._data.geom_xpos[model.geom(_PROBE).id]
        self._id = model.geom(_PROBE).id
        self._centres = self._data.geom_xpos[self._geoms].copy()
        bounds = model.geom_rbound[self._geoms]
        self._bounds = np.where(bounds > 0, bounds, np.inf)

    def reach(self, number: int, points: Array) -> Array:
        """Return what an object is at least away from points [m], shape (P,): quick, for what is far off."""
        away = np.linalg.norm(points - self._centres[number], axis=-1) - self._bounds[number]
        return np.asarray(np.maximum(away, -np.inf))

    def distances(self, number: int, points: Array) -> tuple[Array, Array]:
        """Return distances [m] of points, shape (P, 3), from an object, negative inside, and normals out of it."""
        model, data, probe, geom, one = self._model, self._data, self._id, self._geoms[number], np.zeros(6)
        found, ends = np.zeros(len(points)), np.zeros((len(points), 6))
        for row, point in enumerate(points):
            self._probe[:] = point
            found[row] = mujoco.mj_geomDistance(model, data, probe, geom, _FAR, one)
            ends[row] = one
        away = ends[:, :3] - ends[:, 3:]
        away *= np.sign(found + _PROBE_RADIUS)[:, None]
        return found + _PROBE_RADIUS, away / np.maximum(np.linalg.norm(away, axis=1), 1e-300)[:, None]

    def curvature(self, number: int, point: Array, away: float) -> Array:
        """Return the second derivative of the distance from an object at a point `away` [1/m], shape (3, 3)."""
        apart = min(_APART, 0.1 * away)
        shifts = apart * np.concatenate([np.eye(3), -np.eye(3)])
        normals = self.distances(number, point + shifts)[1]
        slopes = (normals[:3] - normals[3:]) / (2 * apart)
        return np.asarray(0.5 * (slopes + slopes.T))
