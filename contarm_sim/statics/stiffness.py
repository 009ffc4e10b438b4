"""The arm's generalised forces at rest and their tangent stiffness, in closed form on the engine's kinematics.

For a chain of hinges with axes a_j through anchors o_j, a dead force f at p on a body distal to j has the
generalised force a_j . ((p - o_j) x f); its derivative by q_i, i proximal or equal to j, is a_i . c_j with
c_j = D_j a_j - tr(D_j) a_j, D_j the sum of (p - o_j) (x) f over the bodies distal to j. Gravity is such a
load. Parallel muscles add only what their stretching does, for their lengths are linear in the joint angles; straight
spans add what their turning does too. One cumulative sum serves forces and stiffness.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics.arrays import Array
from contarm_sim.statics.loads import AppliedLoad, axial, beyond
from contarm_sim.statics.poses import Poses

SMALL = 1e-3
"""Change of a joint angle up to which the mean force tells the work well enough [rad]."""

Swing = tuple[Array, Any, Array]
"""Of dead loads: their part of Q [N m] and their potential [J]; the lengths of straight spans [m]."""


class TangentStiffness:
    """Evaluates forces Q [N m], shape (..., dofs), and K = -dQ/dq [N m/rad], (..., dofs, dofs), at a plant's positions.

    Call `forces` first, then `matrix` at the same pose and tensions; calling the object does both with the plant's own.
    Of `Poses` every array has a leading axis of cases, and each case has the bits that it has alone.

    Attributes:
        dead: part of Q of weight and dead forces, straight spans' included [N m], shape (..., dofs).
    """

    def __init__(self, plant: Plant | Poses, load: AppliedLoad) -> None:
        self._plant, self._load = plant, load
        self._data = plant.data
        model, data, index = plant.model, plant.data, plant.index
        self._axes, self._anchors, self._centres = data.xaxis, data.xanchor, data.xipos[..., index.bodies, :]
        self._mass, self._gravity = plant.mass[..., None], plant.gravity
        self._station_of_dof = index.station_of_dof
        self._sum_of_dof = self._mass.shape[-2] - 1 - self._station_of_dof  # sums run from the payload inwards
        self._sums = np.zeros((*self._centres.shape[:-1], 12))
        self._upper = _upper(model.nv)
        self._spanning = index.straight if model.ntendon else np.zeros(len(index.straight), dtype=bool)
        self.straight, self._parallel = bool(self._spanning.any()), bool(model.ntendon and not index.straight.all())
        if self.straight:
            self._sites = index.sites[:, self._spanning]
            self._there = (self._sites[:-1] >= 0) & (self._sites[1:] >= 0)  # spans that there are
        self._none = np.zeros((*self._centres.shape[:-2], 0))
        self.symmetric = not (load.any_moment or load.any_follower)

    def __call__(self) -> Array:
        """Return K; positions and actuator forces must be up to date.

        It is symmetric but for dead couples and follower moments, which no energy belongs to.
        """
        tensions = self._plant.muscle_tensions
        self._plant.tighten(tensions)
        self.forces(tensions)
        return self.matrix(tensions, self._plant.muscle_slopes)

    def forces(self, tensions: Array) -> Array:
        """Return Q at the plant's positions [N m], shape (..., dofs), of springs, weight, loads and tensions [N]."""
        sums, load, axes = self._sums, self._load, self._axes
        weight = self._mass * self._gravity
        sums[..., :3] = weight
        dyads = sums[..., 3:].reshape(*sums.shape[:-1], 3, 3)
        np.multiply(self._centres[..., None], weight[..., None, :], out=dyads)
        if load.any_force:
            load.add_forces(sums[..., :3], dyads)
        self._traces = sums[..., 3::4]
        self._turning = self.straight and bool(tensions.any())
        if self._turning:
            self._traces = self._traces.copy()
            pull, ends = self._pulls(tensions)
            sums[..., :-1, :3] += pull.sum(axis=-2)
            dyads[..., :-1, :, :] += ends.swapaxes(-1, -2) @ pull
        beyond_dof = sums[..., ::-1, :].cumsum(axis=-2).take(self._sum_of_dof, axis=-2)
        D = beyond_dof[..., 3:].reshape(*beyond_dof.shape[:-1], 3, 3)
        D -= self._anchors[..., None] * beyond_dof[..., None, :3]
        self._about = D
        self.dead = (axes * axial(D)).sum(axis=-1)
        Q = self.dead - self._plant.springs * self._data.qpos
        if load.any_moment:
            Q += (axes * load.couples()).sum(axis=-1)
        if load.any_follower:
            Q += (axes @ load.follower()[..., None])[..., 0]
        if load.any_actuation:
            Q += load.along_joints()
        if self._parallel:
            pulled = tensions * ~self._spanning if self.straight else tensions
            Q -= (pulled[..., None, :] @ self._plant.muscle_jacobian)[..., 0, :]
        return np.asarray(Q)

    def matrix(self, tensions: Array, slopes: Array) -> Array:
        """Return K at the pose of the last `forces`, for tensions [N] and their slopes [N/m], shape (..., M) each."""
        axes, D = self._axes, self._about
        c = (D @ axes[..., None])[..., 0]
        c -= (D[..., 0, 0] + D[..., 1, 1] + D[..., 2, 2])[..., None] * axes
        K = axes @ c.swapaxes(-1, -2)
        K = np.where(self._upper, K, K.swapaxes(-1, -2))
        if self._load.any_moment:  # dQ_i/dq_j = a_j . (a_i x M_i), j proximal to i
            K += np.tril(np.cross(axes, self._load.couples()) @ axes.swapaxes(-1, -2), -1)
        if self._load.any_follower:  # dQ_i/dq_j = a_i . (a_j x M), j distal to i
            K += np.triu(axes @ np.cross(axes, self._load.follower()[..., None, :]).swapaxes(-1, -2), 1)
        np.negative(K, out=K)
        if self._turning:
            spans = self._spans(tensions)
            K += 0.5 * (spans + spans.swapaxes(-1, -2))
        if slopes.any():
            J = self._plant.muscle_jacobian
            K += (J * slopes[..., None]).swapaxes(-1, -2) @ J
        diagonal(K)[...] += self._plant.springs
        if self._plant.twisted is not None:
            K += self._plant.twisted.stiffness(tensions)
        return K

    @property
    def potential(self) -> Array | float:
        """Potential of weight and dead forces at the last `forces` [J], shape (...)."""
        if self._traces.ndim == 2:
            return -float(self._traces.sum())
        return np.array([-float(traces.sum()) for traces in self._traces])  # adds up as it does for one

    def swing(self) -> Swing:
        """Return what `work` needs of the last `forces`."""
        return (
            self.dead,
            self.potential,
            self._plant.muscle_lengths[..., self._spanning] if self.straight else self._none,
        )

    def work(self, before: Swing, after: Swing, step: Array, tensions: Array) -> Any:
        """Return what dead loads, and straight spans, do along a step [J] beyond their mean force times the step.

        Args:
            before, after: `swing` at its ends.
            step: change of joint angles [rad], shape (..., dofs).
            tensions: mean tensions [N], shape (..., M).
        """
        small = np.abs(step).max(axis=-1) < SMALL
        if small.all():
            return 0.0  # and the difference of potentials would be all rounding
        drawn = dot(tensions[..., self._spanning], before[2] - after[2]) if self.straight else 0.0
        work = before[1] - after[1] + drawn - 0.5 * dot(before[0] + after[0], step)
        return np.where(small, 0.0, work) if small.ndim else work

    def _pulls(self, tensions: Array) -> tuple[Array, Array]:
        """Return the muscles' forces on their sites [N] and the sites' positions [m], (..., stations, muscles, 3)."""
        ends, u, _ = self._directions()
        along = tensions[..., None, self._spanning, None] * u
        force = np.zeros_like(ends)
        force[..., :-1, :, :] += along
        force[..., 1:, :, :] -= along
        return force, ends

    def _directions(self) -> tuple[Array, Array, Array]:
        """Return where straight muscles are at stations [m], and directions and lengths [m] of the spans between.

        A span that there is not, of a muscle that does not reach so far, has no direction and the length 1.
        """
        ends = self._data.site_xpos[..., self._sites, :]
        spans = np.diff(ends, axis=-3)
        if not self._there.all():
            spans[..., ~self._there, :] = 0.0
        reach = np.linalg.norm(spans, axis=-1)
        if not self._there.all():
            reach[..., ~self._there] = 1.0
        return ends, spans / reach[..., None], reach

    def _spans(self, tensions: Array) -> Array:
        """Return what the turning of straight muscle spans adds.

        A span of length l along u turns by (a_j x u) under a dof j proximal to it, which costs tension times
        l (a_i . a_j - (a_i . u)(a_j . u)) for a pair: a sum over spans of a_i . G a_j, so again one cumulative sum.
        The joint that a span crosses moves only its far end, by v = a x (end - anchor), and is treated apart.
        """
        data = self._data
        axes, anchors, station = data.xaxis, data.xanchor, self._station_of_dof
        ends, u, reach = self._directions()  # (.., stations, muscles, 3), (.., spans, muscles, 3), (.., spans, muscles)
        tension = tensions[..., None, self._spanning] * self._there
        weight = tension * reach
        G = weight.sum(axis=-1)[..., None, None] * np.eye(3) - np.einsum("...sm,...smi,...smj->...sij", weight, u, u)
        distal = np.zeros((*ends.shape[:-2], 3, 3))
        distal[..., :-1, :, :] = beyond(G, -3)  # of the spans distal to a station

        own_u, own_reach = (
            u[..., station - 1, :, :],
            reach[..., station - 1, :],
        )  # (.., dofs, muscles, 3), (.., muscles)
        v = np.cross(axes[..., None, :], ends[..., station, :, :] - anchors[..., None, :])
        v -= (v * own_u).sum(axis=-1, keepdims=True) * own_u
        through = np.einsum("...ab,...b->...a", distal[..., station, :, :], axes)
        own_tension = tension[..., station - 1, :]
        across = np.einsum("...m,...ma->...a", own_tension, np.cross(own_u, v))
        proximal = (axes @ (through + across).swapaxes(-1, -2)) * (station[:, None] < station)
        turned, v = (each.reshape(*axes.shape[:-1], -1) for each in (v * (own_tension / own_reach)[..., None], v))
        own = axes @ through.swapaxes(-1, -2) + turned @ v.swapaxes(-1, -2)
        return proximal + proximal.swapaxes(-1, -2) + own * (station[:, None] == station)


@lru_cache(maxsize=16)
def _upper(n: int) -> NDArray[np.bool_]:
    return np.triu(np.ones((n, n), dtype=bool))


def dot(a: Array, b: Array) -> Any:
    """Return the scalar products of vectors, shape (...)."""
    return (a[..., None, :] @ b[..., None])[..., 0, 0]


def solved(K: Array, right: Array) -> Array:
    """Return the solutions of K x = right, shapes (C, n, n), (C, n, k); NaN where a matrix is exactly singular."""
    try:
        return np.asarray(np.linalg.solve(K, right))
    except np.linalg.LinAlgError:
        if len(K) == 1:
            return np.full(right.shape, np.nan)
        return np.concatenate([solved(K[row : row + 1], right[row : row + 1]) for row in range(len(K))])


def definite(K: Array) -> NDArray[np.bool_]:
    """Return whether symmetric matrices, shape (C, n, n), are positive definite, shape (C,)."""
    try:
        np.linalg.cholesky(K)
    except np.linalg.LinAlgError:
        halves = np.array_split(K, 2)
        return np.zeros(1, dtype=bool) if len(K) == 1 else np.concatenate([definite(half) for half in halves])
    return np.ones(len(K), dtype=bool)


def diagonal(K: Array) -> Array:
    """Return the diagonals of matrices as a view, shape (..., n)."""
    return K.reshape(*K.shape[:-2], -1)[..., :: K.shape[-1] + 1]
