"""How far an arm is from the objects of its world: at many poses roughly, at one to the surface, by MuJoCo.

`rough` looks at places along the arcs alone, so that the arm may come nearer between them. `nearest` measures from the
chords between these places by MuJoCo's `mj_geomDistance` (GJK: Gilbert, Johnson, Keerthi, IEEE J. Robot. Autom. 4
(1988) 193), and subtracts how far an arc lies beside its chord: no place along the arm is nearer than it says.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from threading import Lock
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import as_bends
from contarm_sim.libmujoco import load
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object
from contarm_sim.planning.shapes import Hull, distance
from contarm_sim.planning.tube import CHORDS, Tube

_PROBE = 1e-4  # radius of the capsule that is moved along the chords [m]
_FAR = 1e3  # no object is farther [m]
_ALLOWANCE = 2e-6  # how far MuJoCo's distances of convex shapes may be too large [m]


@dataclass(frozen=True)
class Nearest:
    """Where an arm and the objects of its world are nearest.

    Attributes:
        clearance: from the arm's surface to the object's [m], below zero where they overlap.
        object: its name.
        xi: where along the arm, normalised arc length.
        place: of the backbone there [m], shape (3,).
        point: of the object's surface [m], shape (3,).
    """

    clearance: float
    object: str
    xi: float
    place: tuple[float, float, float]
    point: tuple[float, float, float]


class Clearance:
    """Distances of an arm's tube from the objects of its world; free objects are where they start.

    Meshes are as their files were when it was made. Threads may share it.

    Raises:
        InputError: an arm without objects, one in a host or that can touch itself, or a mesh that cannot be read.
    """

    def __init__(self, arm: Arm, chords: int = CHORDS) -> None:
        expect("arm", arm, Arm)
        if arm.world.host is not None:
            given = repr(arm.world.host.file)
            raise InputError("world", given, "none: planning keeps clear of objects ([[object]] in TOML) alone")
        if arm.world.self_contact:
            raise InputError("self_contact", True, "false: planning keeps clear of objects, not of the arm itself")
        if not arm.world.objects:
            raise InputError("objects", "none", "an arm whose world has objects ([[object]] in TOML), to keep clear of")
        self.arm, self.backbone, self.tube = arm, shape.backbone(arm), Tube.of(arm, chords)
        self.names = [each.name for each in arm.world.objects]
        self._model, self._data = _probed(arm)
        self._geoms = [self._model.geom(name).id for name in self.names]
        self._probe = self._model.geom(_probe_name(arm)).id
        self._probing = Lock()
        self._hulls = {each.name: Hull.of(_vertices(each)) for each in arm.world.objects if each.shape == "mesh"}

    def nearest(self, bends: Any) -> Nearest:
        """Return where the arm is nearest to an object at bends [rad], shape (S, 2).

        Its clearance is a lower bound, off by no more than arcs lie beside chords.

        Raises:
            InputError: bends of another shape, or of half a turn or more.
        """
        bends = as_bends(bends, self.backbone).reshape(1, -1, 2)
        tube, places = self.tube, self.tube.places(bends)[0]
        steps, beside = np.diff(places, axis=0), tube.sagitta(bends)[0] + tube.chord_radius + _ALLOWANCE
        sizes = np.sqrt((steps**2).sum(axis=-1))
        far = np.stack([self._lower(name, each, places) for name, each in self._each()])
        # Distances change along a chord by its length at most: this is the least that its ends' leave open.
        least = 0.5 * (far[:, :-1] + far[:, 1:] - sizes) - beside
        best, where = np.inf, (0, 0, np.zeros(6))
        fromto, frames = np.zeros(6), _frames(steps / sizes[:, None])
        for number, chord in zip(*np.unravel_index(np.argsort(least, axis=None), least.shape), strict=True):
            if least[number, chord] > best:
                break
            middle = places[chord] + 0.5 * steps[chord]
            found = self._distance(number, middle, frames[chord], 0.5 * sizes[chord], fromto) - beside[chord]
            if found < best:
                best, where = found, (chord, number, fromto.copy())
        chord, number, fromto = where
        share = float(np.clip((fromto[:3] - places[chord]) @ steps[chord] / sizes[chord] ** 2, 0.0, 1.0))
        arc_length = tube.along[chord] + share * (tube.along[chord + 1] - tube.along[chord])
        x, y, z = (places[chord] + share * steps[chord]).tolist()
        px, py, pz = fromto[3:].tolist()
        return Nearest(float(best), self.names[number], float(arc_length / tube.length), (x, y, z), (px, py, pz))

    def rough(self, bends: Array, wanted: float, places: Array | None = None) -> Array:
        """Return clearances at places along the arm [m], shape (K,), of bends [rad], shape (K, S, 2), not checked.

        A clearance from a mesh is exact up to what is wanted [m]; where more is said, it may be larger still.
        """
        places = self.tube.places(bends) if places is None else places
        out = np.full(len(places), np.inf)
        for name, each in self._each():
            far = self._from_mesh(name, places, wanted) if each.shape == "mesh" else distance(each, places)
            np.minimum(out, (far - self.tube.radius).min(axis=1), out=out)
        return out

    def of_points(self, points: Array) -> tuple[Array, Array]:
        """Return the distances of points, shape (T, 3), from the nearest object [m], and its number, shape (T,)."""
        far = np.stack([self._lower(name, each, points) for name, each in self._each()])
        for number, each in enumerate(self.arm.world.objects):
            if each.shape == "mesh":
                outside = np.flatnonzero(far[number] > 0)
                far[number, outside] = [self._of_point(number, point) for point in points[outside]]
        return far.min(axis=0), far.argmin(axis=0)

    def _each(self) -> Any:
        return zip(self.names, self.arm.world.objects, strict=True)

    def _lower(self, name: str, each: Object, places: Array) -> Array:
        """Return distances of places from an object [m]; from a mesh, lower bounds."""
        return self._hulls[name].distance(places) if each.shape == "mesh" else distance(each, places)

    def _of_point(self, number: int, point: Array) -> float:
        return self._distance(number, point, np.eye(3), 0.0, np.zeros(6))

    def _distance(self, number: int, middle: Array, frame: Array, half: float, fromto: Array) -> float:
        """Return the distance of an object [m] from a line about a middle, along the last column of a frame, (3, 3)."""
        import mujoco

        model, data, probe = self._model, self._data, self._probe
        with self._probing:  # threads share the one probe
            model.geom_size[probe, 1] = half
            data.geom_xpos[probe] = middle
            data.geom_xmat[probe] = frame.ravel()
            return float(mujoco.mj_geomDistance(model, data, probe, self._geoms[number], _FAR, fromto)) + _PROBE

    def _from_mesh(self, name: str, places: Array, wanted: float) -> Array:
        """Return distances from a mesh; exact for places that are nearer than what is wanted."""
        out = self._hulls[name].distance(places)
        number = self.names.index(name)
        for pose, place in np.argwhere((out > 0) & (out < wanted + self.tube.radius)):
            out[pose, place] = self._of_point(number, places[pose, place])
        return out


def clearance_of(arm: Arm) -> Clearance:
    """Return the clearance of an arm, kept for the next question about it while its meshes stay as they are.

    Raises:
        InputError: as the class.
    """
    files = [each.file for each in arm.world.objects if each.file is not None and os.path.isfile(each.file)]
    return _kept(arm, tuple((os.stat(file).st_mtime_ns, os.stat(file).st_size) for file in files))


@lru_cache(maxsize=8)
def _kept(arm: Arm, written: tuple[tuple[int, int], ...]) -> Clearance:
    return Clearance(arm)


def _vertices(each: Object) -> Array:
    """Return the vertices of a mesh in the base frame [m], shape (V, 3)."""
    from contarm_sim.mjcf.surfaces import placed_surface

    return placed_surface(each)


def _frames(z: Array) -> Array:
    """Return frames with the third axes given, shape (K, 3), of length 1: shape (K, 3, 3)."""
    upright = np.abs(z[:, 2:]) > 0.9
    x = np.cross(z, np.where(upright, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    x /= np.sqrt((x * x).sum(axis=-1, keepdims=True))
    return np.stack([x, np.cross(z, x), z], axis=-1)


def _probe_name(arm: Arm) -> str:
    """Return a name that no object has."""
    return max((each.name for each in arm.world.objects), key=len) + "_probe"


def _probed(arm: Arm) -> tuple[Any, Any]:
    """Return a model of the objects and one capsule, the probe, and its state."""
    load()
    import mujoco

    from contarm_sim.mjcf.objects import add_objects

    spec = mujoco.MjSpec()
    add_objects(spec, arm)
    spec.worldbody.add_geom(
        name=_probe_name(arm), type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[_PROBE, _PROBE, 0], contype=0, conaffinity=0
    )
    try:
        model = spec.compile()
    except ValueError as error:
        raise InputError("objects", str(error), "objects that MuJoCo can compile") from None
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data
