"""A `Load` on a plant: generalised forces at the current pose, and what the tangent stiffness needs of them."""

from __future__ import annotations

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.load import Load
from contarm_sim.statics.places import pitch_at, station_coordinate


class AppliedLoad:
    """Wrenches, follower and actuation moments on one plant, scaled by `fraction`.

    A force acts on the link that its station lies on; one that falls on a joint is split half and half to both sides. A
    couple is shared by the two stations around it, by distance: a joint stands for the curvature of the whole pitch
    about it, of which that share carries the couple. Both keep the second order of convergence.
    """

    def __init__(self, plant: Plant, load: Load) -> None:
        self.fraction = 1.0
        self._data = plant.data
        model, arm, index = plant.model, plant.arm, plant.index
        self._bodies, self._tip = np.arange(model.nbody)[index.stations], index.tip
        self._station_of_dof, last = index.station_of_dof, len(self._bodies) - 1
        points = []  # station, z on that link, force, moment
        for wrench in load.wrenches:
            place = float(station_coordinate(arm, np.array(wrench.xi)))
            low, high = int(np.ceil(place - 0.5 - 1e-9)), int(np.floor(place + 0.5 + 1e-9))
            for station in {max(low, 0), min(high, last)}:
                share = 1.0 if low == high else 0.5
                z = (place - station) * float(pitch_at(arm, np.array(place)))
                points.append((station, z, share * np.array(wrench.force), np.zeros(3)))
            before = min(int(place), last - 1)
            for station, share in ((before, before + 1 - place), (before + 1, place - before)):
                points.append((station, 0.0, np.zeros(3), share * np.array(wrench.moment)))
        self._stations = np.array([p[0] for p in points], dtype=int)
        self._z = np.array([p[1] for p in points])
        self._forces = np.array([p[2] for p in points]).reshape(-1, 3)
        self._moments = np.array([p[3] for p in points]).reshape(-1, 3)
        self._follower = np.array(load.follower_moment)
        about = np.array([load.actuation_moment[0], load.actuation_moment[1], 0.0])
        self._actuation = model.jnt_axis @ about
        self.any_actuation = bool(self._actuation.any())
        self.any_moment = bool(self._moments.any())
        self.any_follower = bool(self._follower.any())

    @property
    def any_force(self) -> bool:
        """Whether there are dead forces."""
        return len(self._stations) > 0

    def add_forces(self, force: Array, dyad: Array) -> None:
        """Add dead forces f at points p to those of their stations, (S, 3), and to their dyads p (x) f, (S, 3, 3)."""
        bodies = self._bodies[self._stations]
        along = self._data.xmat[bodies].reshape(-1, 3, 3)[:, :, 2]
        points = self._data.xpos[bodies] + self._z[:, None] * along
        scaled = self.fraction * self._forces
        np.add.at(force, self._stations, scaled)
        np.add.at(dyad, self._stations, points[:, :, None] * scaled[:, None, :])

    def couples(self) -> Array:
        """Return the sum of dead couples beyond each dof [N m], shape (dofs, 3)."""
        moment = np.zeros((len(self._bodies), 3))
        np.add.at(moment, self._stations, self.fraction * self._moments)
        return beyond(moment)[self._station_of_dof]

    def follower(self) -> Array:
        """Return the follower moment [N m] in the base frame, shape (3,)."""
        return self.fraction * self._data.xmat[self._tip].reshape(3, 3) @ self._follower

    def along_joints(self) -> Array:
        """Return the actuation moment on each joint [N m], shape (dofs,)."""
        return self.fraction * self._actuation

    def generalised_forces(self) -> Array:
        """Return the loads' generalised forces [N m], shape (dofs,); kinematics must be up to date."""
        count, station = len(self._bodies), self._station_of_dof
        force, dyad = np.zeros((count, 3)), np.zeros((count, 3, 3))
        self.add_forces(force, dyad)
        about = beyond(dyad)[station] - self._data.xanchor[:, :, None] * beyond(force)[station, None, :]
        total = axial(about) + self.couples() + self.follower()
        return np.asarray((self._data.xaxis * total).sum(axis=1) + self.along_joints())


def axial(dyad: Array) -> Array:
    """Return the sum of p x f, shape (..., 3), of sums of p (x) f, shape (..., 3, 3)."""
    flat = dyad.reshape(*dyad.shape[:-2], 9)
    return np.asarray(flat @ _AXIAL)


_AXIAL = np.zeros((9, 3))
for _axis, _plus, _minus in ((0, 5, 7), (1, 6, 2), (2, 1, 3)):
    _AXIAL[_plus, _axis], _AXIAL[_minus, _axis] = 1.0, -1.0


def beyond(values: Array) -> Array:
    """Sum over each station and all that are distal to it."""
    return np.cumsum(values[::-1], axis=0)[::-1]
