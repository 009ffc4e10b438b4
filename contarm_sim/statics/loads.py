"""A `Load` on a plant: generalised forces at the current pose, and what the tangent stiffness needs of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.load import Load
from contarm_sim.statics.places import pitch_at, station_coordinate
from contarm_sim.statics.poses import Poses, Rows


class AppliedLoad:
    """Wrenches, follower and actuation moments on one plant, scaled by `fraction`; or, on `Poses`, a load each.

    A force acts on the link that its station lies on; one that falls on a joint is split half and half to both sides. A
    couple is shared by the two stations around it, by distance: a joint stands for the curvature of the whole pitch
    about it, of which that share carries the couple. Both keep the second order of convergence.

    Attributes:
        fraction: of the load that acts.
        any_force, any_moment, any_follower, any_actuation: whether there are dead forces, dead couples, and the rest.
    """

    def __init__(self, plant: Plant | Poses, load: Load | Sequence[Load]) -> None:
        self.fraction = 1.0
        self._plant = plant
        model, arm, index = plant.model, plant.arm, plant.index
        self._bodies, self._tip = np.arange(model.nbody)[index.stations], index.tip
        self._station_of_dof = index.station_of_dof
        one = isinstance(load, Load)
        loads = [load] if isinstance(load, Load) else load
        self._lead: tuple[int, ...] = () if one else (len(loads),)
        wrenches = [(case, wrench) for case, each in enumerate(loads) for wrench in each.wrenches]
        forces = [(case, each.xi, each.force) for case, each in wrenches if any(each.force)]
        couples = [(case, each.xi, each.moment) for case, each in wrenches if any(each.moment)]
        self._forces = _Points.of_forces(arm, *_columns(forces))
        self._couples = _Points.of_couples(arm, *_columns(couples))
        if one:
            self._forces, self._couples = self._forces.of_one(), self._couples.of_one()
        follower: Array = np.array([each.follower_moment for each in loads])
        about = np.array([[*each.actuation_moment, 0.0] for each in loads])
        actuation = (model.jnt_axis @ about[..., None])[..., 0]
        self._follower: Array = follower[0] if one else follower
        self._actuation: Array = actuation[0] if one else actuation
        self._look()

    def _look(self) -> None:
        self.any_force, self.any_moment = bool(len(self._forces.vector)), bool(len(self._couples.vector))
        self.any_follower, self.any_actuation = bool(self._follower.any()), bool(self._actuation.any())

    @property
    def symmetric(self) -> NDArray[np.bool_]:
        """Of many poses, whether the loads have energy, shape (C,)."""
        out: NDArray[np.bool_] = np.logical_not(self._follower.any(axis=-1))
        out[self._couples.at[0]] = False
        return out

    def keep(self, rows: Rows) -> None:
        """Go on with these of many cases alone."""
        number = np.full(self._lead, -1)
        kept = np.arange(self._lead[0])[rows]
        number[kept] = np.arange(len(kept))
        self._lead = (len(kept),)
        self._forces, self._couples = self._forces.keep(number), self._couples.keep(number)
        self._follower, self._actuation = self._follower[rows], self._actuation[rows]
        self._look()

    def add_forces(self, force: Array, dyad: Array) -> None:
        """Add dead forces f at p to those of stations, shape (..., S, 3), and dyads p (x) f, shape (..., S, 3, 3)."""
        data, at = self._plant.data, self._forces.at
        bodies = (*at[:-1], self._bodies[at[-1]])
        along = data.xmat[bodies].reshape(-1, 3, 3)[:, :, 2]
        points = data.xpos[bodies] + self._forces.z[:, None] * along
        scaled = self.fraction * self._forces.vector
        np.add.at(force, at, scaled)
        np.add.at(dyad, at, points[:, :, None] * scaled[:, None, :])

    def couples(self) -> Array:
        """Return the sum of dead couples beyond each dof [N m], shape (..., dofs, 3)."""
        moment = np.zeros((*self._lead, len(self._bodies), 3))
        np.add.at(moment, self._couples.at, self.fraction * self._couples.vector)
        return beyond(moment, -2).take(self._station_of_dof, axis=-2)

    def follower(self) -> Array:
        """Return the follower moment [N m] in the base frame, shape (..., 3)."""
        turned = self.fraction * self._plant.data.xmat[..., self._tip, :].reshape(*self._lead, 3, 3)
        return np.asarray((turned @ self._follower[..., None])[..., 0])

    def along_joints(self) -> Array:
        """Return the actuation moment on each joint [N m], shape (..., dofs)."""
        return self.fraction * self._actuation

    def generalised_forces(self) -> Array:
        """Return the loads' generalised forces [N m], shape (dofs,), of one plant; kinematics must be up to date."""
        count, station, data = len(self._bodies), self._station_of_dof, self._plant.data
        force, dyad = np.zeros((count, 3)), np.zeros((count, 3, 3))
        self.add_forces(force, dyad)
        about = beyond(dyad, 0)[station] - data.xanchor[:, :, None] * beyond(force, 0)[station, None, :]
        total = axial(about) + self.couples() + self.follower()
        return np.asarray((data.xaxis * total).sum(axis=1) + self.along_joints())


class _Points:
    """Vectors at stations, of many cases.

    Attributes:
        at: what selects the stations from an array of all: cases (of many) and stations, shape (P,) each.
        z: how far from the station along its link [m], shape (P,).
        vector: forces [N] or couples [N m], shape (P, 3).
    """

    def __init__(self, at: tuple[Any, ...], z: Array, vector: Array) -> None:
        self.at, self.z, self.vector = at, z, vector

    @classmethod
    def of_forces(cls, arm: Any, case: Any, xi: Array, force: Array) -> _Points:
        """Return forces on links; case by case, those of one station in the order of the load's wrenches."""
        if not len(xi):
            return cls((case, case), xi, force)
        last = arm.links
        place = station_coordinate(arm, xi)
        low, high = np.ceil(place - 0.5 - 1e-9).astype(int), np.floor(place + 0.5 + 1e-9).astype(int)
        share = np.where(low == high, 1.0, 0.5)[:, None]
        first, second = np.maximum(low, 0), np.minimum(high, last)
        twice = first != second
        which = np.concatenate([np.arange(len(xi)), np.flatnonzero(twice)])
        stations = np.concatenate([first, second[twice]])
        order = np.argsort(which, kind="stable")
        which, stations = which[order], stations[order]
        z = (place[which] - stations) * pitch_at(arm, place[which])
        return cls((case[which], stations), z, (share * force)[which])

    @classmethod
    def of_couples(cls, arm: Any, case: Any, xi: Array, moment: Array) -> _Points:
        """Return couples, each shared by the two stations around it."""
        if not len(xi):
            return cls((case, case), xi, moment)
        place = station_coordinate(arm, xi)
        before = np.minimum(place.astype(int), arm.links - 1)
        share = np.stack([before + 1 - place, place - before], axis=-1)
        stations = np.stack([before, before + 1], axis=-1).ravel()
        vector = (share[:, :, None] * moment[:, None, :]).reshape(-1, 3)
        return cls((np.repeat(case, 2), stations), np.zeros(len(stations)), vector)

    def of_one(self) -> _Points:
        return _Points(self.at[1:], self.z, self.vector)

    def keep(self, number: NDArray[np.integer]) -> _Points:
        """Return those of the cases that have a new number, under it."""
        case = number[self.at[0]]
        left = case >= 0
        return _Points((case[left], self.at[1][left]), self.z[left], self.vector[left])


def _columns(rows: list[tuple[int, float, Any]]) -> tuple[Any, Array, Array]:
    cases, xi, vectors = zip(*rows, strict=True) if rows else ((), (), ())
    return np.array(cases, dtype=int), np.array(xi, dtype=float), np.array(vectors, dtype=float).reshape(-1, 3)


def axial(dyad: Array) -> Array:
    """Return the sum of p x f, shape (..., 3), of sums of p (x) f, shape (..., 3, 3)."""
    flat = dyad.reshape(*dyad.shape[:-2], 9)
    return np.asarray(flat @ _AXIAL)


_AXIAL = np.zeros((9, 3))
for _axis, _plus, _minus in ((0, 5, 7), (1, 6, 2), (2, 1, 3)):
    _AXIAL[_plus, _axis], _AXIAL[_minus, _axis] = 1.0, -1.0


def beyond(values: Array, axis: int) -> Array:
    """Sum over each station, along an axis, and all that are distal to it."""
    return np.flip(np.cumsum(np.flip(values, axis), axis=axis), axis)
