"""Where a free swing starts: the sample that it is followed from, and the arm's shape and speed there, from markers.

A hand lets go gradually, so a swing is followed from the sample at which the fastest marker has reached a share of its
peak speed. The shape there is the least bent, and most evenly bent, that goes through the markers: the joint angles q
that minimise

    sum over markers |p(q) - measured|^2 / s^2 + L/6 int k^2 ds + L^3/54 int k'^2 ds,

k the curvature, L the arm's length, s = 0.003 L: a joint bend of a radian in a sixth of the arm counts as much as s.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contarm_sim.engine.index import ArmIndex
from contarm_sim.engine.plants import Plants
from contarm_sim.identify.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.statics.places import Places

CLOSE = 0.003
"""Distance from a marker that counts as much as one of the shape's terms [lengths]."""

STEPS = 12
"""Most steps of Gauss and Newton."""

NEAR = 3
"""Samples before and after one that place and speed there are found from."""

HELD = 0.1
"""Share of the peak speed below which a hand still holds the arm."""


def speeds(time: Array, positions: Array) -> Array:
    """Return the speed of the fastest marker at each sample [m/s], shape (T,); 0 where none is seen there.

    Positions are medians of five, so that a sample that jumps is not a speed.

    Args:
        time: [s], shape (T,).
        positions: [m], shape (T, K, 3), NaN where a marker was not seen.
    """
    out = np.zeros(len(time))
    for marker in range(positions.shape[1]):
        seen = np.isfinite(positions[:, marker]).all(axis=-1)
        if np.count_nonzero(seen) > 2:
            padded = np.pad(positions[seen, marker], ((2, 2), (0, 0)), mode="reflect")
            middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5, axis=0), axis=-1)
            velocity = np.gradient(middle, time[seen], axis=0)
            out[seen] = np.maximum(out[seen], np.linalg.norm(velocity, axis=-1))
    return out


def start_of(time: Array, positions: Array, share: float) -> tuple[int, int]:
    """Return the samples of one block: the one that a swing is followed from, and the last at which it was held.

    Args:
        time, positions: as of `speeds`.
        share: of the peak speed.
    """
    speed = speeds(time, positions)
    peak = speed.max()
    if peak == 0:
        return 0, 0
    start = int(np.argmax(speed >= share * peak))
    slow = np.flatnonzero(speed[: start + 1] < HELD * peak)
    return start, int(slow[-1]) if len(slow) else start


def smoothed(time: Array, positions: Array, sample: int) -> tuple[Array, Array]:
    """Return the markers' positions [m] and velocities [m/s] at a sample, shape (K, 3) each, from parabolas about it.

    Through the samples nearest to it at which a marker is seen, those far off the others counting little; NaN where
    there are less than four.
    """
    out = np.full((2, *positions.shape[1:]), np.nan)
    about = np.arange(max(0, sample - 3 * NEAR), min(len(time), sample + 3 * NEAR + 1))
    for marker in range(positions.shape[1]):
        seen = about[np.isfinite(positions[about, marker]).all(axis=-1)]
        own = seen[np.argsort(np.abs(time[seen] - time[sample]), kind="stable")[: 2 * NEAR + 1]]
        if len(own) > 3:
            out[:, marker] = _parabola(time[own] - time[sample], positions[own, marker])[:2]
    return out[0], out[1]


def _parabola(time: Array, points: Array) -> Array:
    """Return the coefficients of parabolas through points, shape (3, 3), the constant first; outliers count little."""
    powers, weights = time[:, None] ** np.arange(3), np.ones(len(time))
    for _ in range(8):
        found = np.linalg.lstsq(weights[:, None] * powers, weights[:, None] * points, rcond=None)[0]
        off = np.linalg.norm(points - powers @ found, axis=1)
        weights = 1 / np.sqrt(1 + (off / (3 * np.median(off) + 1e-12)) ** 2)
    return np.asarray(found)


class ShapesFromMarkers:
    """Finds joint angles and rates of P arms at once from what was measured of their markers.

    Args:
        plants: P arms, whose poses this uses.
        rigs: of each.
    """

    def __init__(self, plants: Plants, rigs: Sequence[Rig]) -> None:
        self._plants, self._rigs = plants, rigs
        xi = [[marker.xi for marker in rig.markers] for rig in rigs]
        self._places = [Places(arm, own) for arm, own in zip(plants.arms, xi, strict=True)]
        self._offsets = np.array([[marker.offset for marker in rig.markers] for rig in rigs])
        self._turns = np.array([rig.rotation for rig in rigs])
        part = np.array([places.part for places in self._places])[..., None]
        stations = np.array([places.stations for places in self._places])[..., None]
        below = plants.index.station_of_dof <= stations  # (P, K, 2, D)
        self._carried = (1 - part) * below[:, :, 0] + part * below[:, :, 1]
        self._bent = np.stack([_bending_cost(arm, plants.index) for arm in plants.arms])
        self._anchors, self._axes = plants.batch.bind("xanchor"), plants.batch.bind("xaxis")
        self._close = CLOSE * np.array([arm.length for arm in plants.arms])

    def angles(self, positions: Array, start: Array | None = None) -> Array:
        """Return joint angles [rad], shape (P, D).

        Args:
            positions: of the markers in the frame of the measurements [m], shape (P, K, 3); NaN: not seen.
            start: to begin from; default straight.
        """
        q = np.zeros((len(self._rigs), self._bent.shape[-1])) if start is None else start.copy()
        for _ in range(STEPS):
            left, J = self._left(q, positions)
            change = self._solved(J, left, -np.einsum("pij,pj->pi", self._bent, q))
            largest = np.abs(change).max(axis=1, keepdims=True)
            q += change * np.minimum(1.0, 0.5 / np.maximum(largest, 1e-300))
            if largest.max() < 1e-9:
                break
        return q

    def rates(self, q: Array, velocities: Array) -> Array:
        """Return rates of joint angles [rad/s], shape (P, D), that the markers' velocities [m/s] tell of."""
        _, J = self._left(q, velocities)
        turned = velocities @ self._turns
        return self._solved(J, np.where(np.isfinite(turned), turned, 0.0), 0.0)

    def _solved(self, J: Array, left: Array, pull: Array | float) -> Array:
        weight = self._close[:, None, None] ** -2
        flat = J.reshape(len(J), -1, J.shape[-1])
        normal = weight * flat.transpose(0, 2, 1) @ flat + self._bent
        right = weight[..., 0] * np.einsum("pki,pk->pi", flat, left.reshape(len(J), -1)) + pull
        return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])

    def _left(self, q: Array, positions: Array) -> tuple[Array, Array]:
        """Return what is measured less what angles give, base frame, shape (P, K, 3), and the latter's derivative."""
        plants = self._plants
        plants.qpos[:] = q
        plants.forward()
        rotations = plants.rotations
        points, measured = np.empty(positions.shape), np.empty(positions.shape)
        for p, (rig, places) in enumerate(zip(self._rigs, self._places, strict=True)):
            frames = places.between(plants.centres[p, places.stations], rotations[p, places.stations])
            points[p] = frames[:, :3, 3] + np.einsum("kij,kj->ki", frames[:, :3, :3], self._offsets[p])
            measured[p] = (positions[p] - rig.position) @ self._turns[p]
        seen = np.asarray(np.isfinite(measured).all(axis=-1))[..., None]
        arms, axes = points[:, :, None] - self._anchors[:, None], self._axes[:, None]
        moved = np.stack([axes[..., i - 2] * arms[..., i - 1] - axes[..., i - 1] * arms[..., i - 2] for i in range(3)])
        J = np.where(seen[..., None], moved.transpose(1, 2, 0, 3) * self._carried[:, :, None], 0.0)
        return np.where(seen, measured - points, 0.0), J


def _bending_cost(arm: Arm, index: ArmIndex) -> Array:
    """Return what is quadratic in joint angles of the cost of a shape, shape (D, D)."""
    pitch = np.array([section.link_pitch for section in arm.sections])[index.section_of_joint]
    cost = np.diag(arm.length / 6 / pitch)
    for hinges in index.bending.values():
        h = pitch[hinges]
        change = np.diff(np.diag(1 / h), axis=0)  # of curvature from joint to joint
        between = 0.5 * (h[1:] + h[:-1])
        cost[np.ix_(hinges, hinges)] += arm.length**3 / 54 * change.T @ (change / between[:, None])
    return cost
