"""The tangent stiffness of the simulated arm: minus the derivative of its generalised forces, in closed form.

For a chain of hinges with axes a_j through anchors o_j, a dead force f at p on a body distal to j has the
generalised force a_j . ((p - o_j) x f); its derivative by q_i, i proximal or equal to j, is a_i . c_j with
c_j = D_j a_j - tr(D_j) a_j, D_j the sum of (p - o_j) (x) f over the bodies distal to j. Gravity is such a
load. Parallel muscles add only what their stretching does, for their lengths are linear in the joint angles; straight
spans add what their turning does too.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf.routing import MUSCLES
from contarm_sim.simulation.loads import AppliedLoad, beyond
from contarm_sim.simulation.plant import Plant


class TangentStiffness:
    """Evaluates K = -dQ/dq [N m/rad], shape (dofs, dofs), at the plant's current positions and forces."""

    def __init__(self, plant: Plant, load: AppliedLoad) -> None:
        self._plant, self._load = plant, load
        self._model, self._data = plant.model, plant.data
        model = self._model
        self._base, self._payload = model.body("base").id, model.body("payload").id
        self._station_of_dof = model.dof_bodyid - self._base
        self._straight = plant.arm.muscle.path == "spans" and model.ntendon > 0
        if self._straight:
            names = [model.body(self._base + s).name for s in range(plant.arm.links + 1)]
            self._sites = np.array([[model.site(f"{name}_{muscle}").id for muscle in MUSCLES] for name in names])
        self.symmetric = not (load.any_moment or load.any_follower)

    def __call__(self) -> Array:
        """Return K; positions and actuator forces must be up to date.

        It is symmetric but for dead couples and follower moments, which no energy belongs to.
        """
        tensions, slopes = self._plant.muscle_tensions, self._plant.muscle_slopes
        K = self._dead_loads(tensions)
        if self._straight and tensions.any():
            K += self._spans(tensions)
        if slopes.any():
            J = self._plant.muscle_jacobian
            K += (J.T * slopes) @ J
        if self._plant.twisted is not None:
            K += self._plant.twisted.coupling(tensions)
        K[np.diag_indices_from(K)] += self._model.jnt_stiffness
        return 0.5 * (K + K.T) if self.symmetric else K

    def _dead_loads(self, tensions: Array) -> Array:
        """Return what forces and couples that keep their direction add, muscle tensions as they are among them."""
        data, model = self._data, self._model
        axes, anchors = data.xaxis, data.xanchor
        force, dyad, moment = self._load.distal()
        links = slice(self._base, self._base + len(force))
        weight = model.body_mass[links, None] * model.opt.gravity
        force += weight
        dyad += data.xipos[links, :, None] * weight[:, None, :]
        hung = model.body_mass[self._payload] * model.opt.gravity
        force[-1] += hung
        dyad[-1] += data.xipos[self._payload, :, None] * hung
        if self._straight and tensions.any():
            pull, ends = self._pulls(tensions)
            force += pull.sum(axis=1)
            dyad += np.einsum("smi,smj->sij", ends, pull)
        force = beyond(force)[self._station_of_dof]
        dyad = beyond(dyad)[self._station_of_dof]
        D = dyad - anchors[:, :, None] * force[:, None, :]
        c = np.einsum("jab,jb->ja", D, axes) - np.trace(D, axis1=1, axis2=2)[:, None] * axes
        dead = np.triu(axes @ c.T)
        dead = dead + np.triu(dead, 1).T
        if self._load.any_moment:  # dQ_i/dq_j = a_j . (a_i x M_i), j proximal to i
            couple = beyond(moment)[self._station_of_dof]
            dead += np.tril(np.cross(axes, couple) @ axes.T, -1)
        if self._load.any_follower:  # dQ_i/dq_j = a_i . (a_j x M), j distal to i
            dead += np.triu(axes @ np.cross(axes, self._load.follower()).T, 1)
        return -dead

    def _pulls(self, tensions: Array) -> tuple[Array, Array]:
        """Return the muscles' forces on their sites [N] and the sites' positions [m], shape (stations, 3, 3)."""
        ends = self._data.site_xpos[self._sites]
        spans = np.diff(ends, axis=0)
        along = tensions[None, :, None] * spans / np.linalg.norm(spans, axis=-1, keepdims=True)
        force = np.zeros_like(ends)
        force[:-1] += along
        force[1:] -= along
        return force, ends

    def _spans(self, tension: Array) -> Array:
        """Return what the turning of straight muscle spans adds.

        A span of length l along u turns by (a_j x u) under a dof j proximal to it, which costs tension times
        l (a_i . a_j - (a_i . u)(a_j . u)) for a pair: a sum over spans of a_i . G a_j, so again one cumulative sum.
        The joint that a span crosses moves only its far end, by v = a x (end - anchor), and is treated apart.
        """
        data = self._data
        axes, anchors, station = data.xaxis, data.xanchor, self._station_of_dof
        ends = data.site_xpos[self._sites]  # (stations, muscles, 3)
        spans = np.diff(ends, axis=0)
        reach = np.linalg.norm(spans, axis=-1)
        u = spans / reach[..., None]
        weight = tension * reach
        G = weight.sum(axis=1)[:, None, None] * np.eye(3) - np.einsum("sm,smi,smj->sij", weight, u, u)
        distal = np.zeros((len(ends), 3, 3))
        distal[:-1] = beyond(G)  # of the spans distal to a station

        own_u, own_reach = u[station - 1], reach[station - 1]  # (dofs, muscles, 3), (dofs, muscles)
        v = np.cross(axes[:, None], ends[station] - anchors[:, None])
        v -= (v * own_u).sum(axis=-1, keepdims=True) * own_u
        through = np.einsum("jab,jb->ja", distal[station], axes)
        across = np.einsum("m,jma->ja", tension, np.cross(own_u, v))
        proximal = (axes @ (through + across).T) * (station[:, None] < station)
        flat = (v * (tension / own_reach)[..., None]).reshape(len(axes), -1) @ v.reshape(len(axes), -1).T
        return proximal + proximal.T + (axes @ through.T + flat) * (station[:, None] == station)
