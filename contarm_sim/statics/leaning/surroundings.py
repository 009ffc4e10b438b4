"""How far points are from the objects of an arm's world, as the engine measures it on the shapes that it simulates."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import TIMESTEP, arm_spec, names
from contarm_sim.mjcf.backbone import links
from contarm_sim.mjcf.contact import LINKS
from contarm_sim.model.arm import Arm
from contarm_sim.model.host import Host

_PROBE, _TIP = "probe", f"{names.TIP}_collision"
_PROBE_RADIUS = 1e-9
"""Radius of the sphere that measures [m]."""

_FAR = 1e3
"""Farthest distance measured [m]."""

_APART = 1e-6
"""How far apart normals are compared, to find how the surface is curved [m]; a tenth of small distances."""


@dataclass(frozen=True)
class Obstacle:
    """What an arm may lean on: its name, its coefficient of friction, and its geom in the model."""

    name: str
    friction: float
    geom: int


class Surroundings:
    """What is around an arm, held where it stands: its objects, and the bodies of its host.

    Attributes:
        objects: of them, the arm's own first; a body of the host has one for each of its geoms.
        radii: of what touches at the arm's stations [m], shape (K,).

    Raises:
        InputError: the arm can touch itself, which is not known here.
    """

    def __init__(self, arm: Arm) -> None:
        if arm.world.self_contact:
            allowed = "false: equilibrium finds arms that lean on objects, not on themselves"
            raise InputError("self_contact", True, allowed)
        spec = arm_spec(arm.without_memory, "none", TIMESTEP)
        spec.worldbody.add_geom(
            name=_PROBE, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_PROBE_RADIUS, 0, 0], contype=0, conaffinity=0
        )
        self._model = model = spec.compile()
        model.opt.ccd_tolerance, model.opt.ccd_iterations = 1e-12, 200
        self._data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, self._data, 0)
        mujoco.mj_kinematics(model, self._data)
        self.radii = np.array([link.contact_radius for link in links(arm)])
        if arm.world.host is not None:
            self._into_base_frame()
        self._probe = self._data.geom_xpos[model.geom(_PROBE).id]
        self._id = model.geom(_PROBE).id
        self.objects = [Obstacle(each.name, each.friction, model.geom(each.name).id) for each in arm.world.objects]
        if arm.world.host is not None:
            self.objects += self._of_host(arm, arm.world.host)
        self._geoms = [each.geom for each in self.objects]
        self._centres = self._data.geom_xpos[self._geoms].copy()
        bounds = model.geom_rbound[self._geoms]
        self._bounds = np.where(bounds > 0, bounds, np.inf)

    def _into_base_frame(self) -> None:
        """Move all geoms from the world of a host, far from whose origin distances would lose digits."""
        base, data = self._data.body(names.BASE), self._data
        turn = base.xmat.reshape(3, 3).copy()
        data.geom_xpos[:] = (data.geom_xpos - base.xpos) @ turn
        data.geom_xmat[:] = (turn.T @ data.geom_xmat.reshape(-1, 3, 3)).reshape(-1, 9)

    def _of_host(self, arm: Arm, host: Host) -> list[Obstacle]:
        """Return what the links can touch of a host, but for what of the mount's body the base stands on."""
        model, own = self._model, {*names.stations(arm), names.PAYLOAD, *(each.name for each in arm.world.objects)}
        found = []
        for geom in range(model.ngeom):
            body = model.body(int(model.geom_bodyid[geom])).name
            if body in own or not model.geom_conaffinity[geom] & LINKS:
                continue
            if body == host.mount and self._away(geom, np.zeros(3))[0] < self.radii[0]:
                continue
            found.append(Obstacle(body, self._friction(geom), geom))
        return found

    def _friction(self, geom: int) -> float:
        """Return the coefficient between a geom and the arm: of the one of more priority, of equals the larger.

        So MuJoCo mixes them, and `condim`, the larger too: below 3 there is no friction.
        """
        model, two = self._model, [geom, self._model.geom(_TIP).id]
        first = [each for each in two if model.geom_priority[each] == model.geom_priority[two].max()]
        return float(model.geom_friction[first, 0].max()) if model.geom_condim[first].max() >= 3 else 0.0

    def _away(self, geom: int, point: Array) -> tuple[float, Array]:
        """Return the distance [m] of a geom from a point of the base frame, and its ends there, shape (6,)."""
        ends = np.zeros(6)
        self._probe[:] = point
        return mujoco.mj_geomDistance(self._model, self._data, self._id, geom, _FAR, ends), ends

    def reach(self, number: int, points: Array) -> Array:
        """Return what an object is at least away from points [m], shape (P,): quick, for what is far off."""
        away = np.linalg.norm(points - self._centres[number], axis=-1) - self._bounds[number]
        return np.asarray(np.maximum(away, -np.inf))

    def distances(self, number: int, points: Array) -> tuple[Array, Array]:
        """Return distances [m] of points, shape (P, 3), from an object, negative inside, and normals out of it."""
        found, ends = np.zeros(len(points)), np.zeros((len(points), 6))
        for row, point in enumerate(points):
            found[row], ends[row] = self._away(self._geoms[number], point)
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
