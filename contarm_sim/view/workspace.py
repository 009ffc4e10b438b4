"""Where the tip of several sections can be, how often, and how well it moves there: maps over a half plane.

No section twists and the muscles are left out, so all is the same around the z axis: a place is its distance from that
axis and its height.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics import sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone

Indices = NDArray[np.intp]

BATCH = 50_000
"""Poses that are found at a time: memory stays below 100 MB."""

_PATCHES = (7, 12)
"""Directions are told apart in so many rings by the cosine of the angle to z, of so many equal patches a half turn."""


@dataclass(frozen=True)
class Grid:
    """Square cells over distance from the axis and height.

    Attributes:
        size: of a cell [m].
        low: height of the lowest cell's lower edge [m].
        shape: cells in distance and in height.
    """

    size: float
    low: float
    shape: tuple[int, int]

    @classmethod
    def over(cls, backbone: Backbone, cells: int) -> Grid:
        """Return a grid over all that an arm reaches, so many cells in its length."""
        size = backbone.length / cells
        low = size * np.floor(lowest(backbone) / size - 1)
        return cls(size, float(low), (cells + 1, int(np.ceil((backbone.length - low) / size)) + 1))

    @property
    def distances(self) -> Array:
        """Distance of the middle of the cells from the axis [m]."""
        return np.asarray(self.size * (np.arange(self.shape[0]) + 0.5), dtype=float)

    @property
    def heights(self) -> Array:
        """Height of the middle of the cells [m]."""
        return np.asarray(self.low + self.size * (np.arange(self.shape[1]) + 0.5), dtype=float)

    @property
    def volumes(self) -> Array:
        """Volume that a cell sweeps around the axis [m^3], shape (distances, 1)."""
        return 2 * np.pi * self.distances[:, None] * self.size**2

    def cell(self, tips: Array) -> Indices:
        """Return the number of the cell of tips [m], shape (K, 3) -> (K,)."""
        column = np.hypot(tips[:, 0], tips[:, 1]) / self.size
        row = (tips[:, 2] - self.low) / self.size
        return np.ravel_multi_index((column.astype(int), row.astype(int)), self.shape)


@dataclass(frozen=True)
class Workspace:
    """Maps over a grid, shape (distances, heights).

    Attributes:
        grid: its cells.
        density: share of all poses whose tip is there [1/m^3].
        slowest: of the poses whose tip is there, the best one's smallest singular value of the tip's Jacobian [m/rad]:
            how far it moves for one radian of bends in the direction in which it moves least.
        directions: share of all directions of the tip that some pose there has.
    """

    grid: Grid
    density: Array
    slowest: Array
    directions: Array

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Whether any pose's tip is there."""
        return self.density > 0


def workspace(backbone: Backbone, cells: int = 48, poses: int = 400_000, seed: int = 0) -> Workspace:
    """Return the maps of an arm, by poses whose bends are drawn evenly from the disks up to the largest bends.

    Args:
        cells: in the length of the arm.
        poses: how many are drawn; each one counts for its mirror image too.
    """
    grid = Grid.over(backbone, cells)
    count, rings = int(np.prod(grid.shape)), _PATCHES[0] * _PATCHES[1]
    hits, slowest, seen = np.zeros(count), np.zeros(count), np.zeros((count, rings), dtype=bool)
    for bends in _drawn(backbone, poses, np.random.default_rng(seed)):
        frames = sections.transform(bends, backbone, check=False)
        cell = grid.cell(frames[:, :3, 3])
        hits += np.bincount(cell, minlength=count)
        J = sections.jacobian(bends, backbone, check=False)[:, :3]
        least = np.sqrt(np.maximum(np.linalg.eigvalsh(J @ J.swapaxes(-1, -2))[:, 0], 0.0))
        np.maximum.at(slowest, cell, least)
        seen[cell, _patch(frames)] = True
    return Workspace(
        grid,
        hits.reshape(grid.shape) / hits.sum() / grid.volumes,
        slowest.reshape(grid.shape),
        seen.mean(axis=1).reshape(grid.shape),
    )


def _drawn(backbone: Backbone, count: int, rng: np.random.Generator) -> Iterator[Array]:
    """Yield bends, shape (K, S, 2), drawn evenly from each section's disk, the first one's plane turned to 0."""
    limits = np.array(backbone.limits)
    for start in range(0, count, BATCH):
        size = (min(BATCH, count - start), len(backbone))
        angle, plane = limits * np.sqrt(rng.uniform(size=size)), rng.uniform(-np.pi, np.pi, size)
        plane[:, 0] = 0.0
        yield np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)


def _patch(frames: Array) -> Indices:
    """Return the patch of the tip's direction, about the axis as seen from the tip's meridian, mirrored to 0..pi."""
    rings, slices = _PATCHES
    tips, ways = frames[:, :3, 3], frames[:, :3, 2]
    around = np.arctan2(ways[:, 1], ways[:, 0]) - np.arctan2(tips[:, 1], tips[:, 0])
    turned = np.arccos(np.clip(np.cos(around), -1, 1)) / np.pi
    ring = np.clip((0.5 * (1 + ways[:, 2]) * rings).astype(int), 0, rings - 1)
    return ring * slices + np.clip((turned * slices).astype(int), 0, slices - 1)


def planar_tips(backbone: Backbone, count: int = 200_000, seed: int = 0) -> Array:
    """Return tips of arms bent in one plane, distance from the axis (either side) and height [m], shape (K, 2).

    The edges of what can be reached are among such poses. A grid for one or two sections, else drawn; of all sections
    but two at most, bends are at a limit or drawn.
    """
    limits = np.array(backbone.limits)
    if len(limits) <= 2:
        each = round(count ** (1 / len(limits)))
        axes = np.meshgrid(*(np.linspace(-limit, limit, each) for limit in limits), indexing="ij")
        angles = np.stack(axes, axis=-1).reshape(-1, len(limits))
    else:
        rng = np.random.default_rng(seed)
        angles = rng.uniform(-1, 1, (count, len(limits)))
        angles = np.where(rng.uniform(size=angles.shape) < 0.3, np.sign(angles), angles) * limits
    out = np.empty((len(angles), 2))
    for start in range(0, len(angles), BATCH):
        part = angles[start : start + BATCH]
        bends = np.stack([part, np.zeros_like(part)], axis=-1)
        out[start : start + BATCH] = sections.position(bends, backbone, check=False)[:, [0, 2]]
    return out


def hull(backbone: Backbone, directions: int = 72) -> Array:
    """Return the convex hull of all tips from the top down, distance from the axis and height [m], shape (K, 2)."""
    tips = planar_tips(backbone, 40_000)
    angle = np.linspace(0.0, np.pi, directions)
    farthest = (np.stack([np.sin(angle), np.cos(angle)], axis=1) @ tips.T).argmax(axis=1)
    points = np.abs(tips[farthest]) * [1, 0] + tips[farthest] * [0, 1]
    points[[0, -1], 0] = 0.0
    return points


def around(points: Array, planes: Array) -> Array:
    """Return a surface of revolution [m], shape (K, P, 3), of distances from the axis and heights [m], shape (K, 2)."""
    turned = points[:, :1, None] * np.stack([np.cos(planes), np.sin(planes)], axis=-1)
    return np.concatenate([turned, np.broadcast_to(points[:, None, 1:], (*turned.shape[:2], 1))], axis=-1)


def lowest(backbone: Backbone) -> float:
    """Return the height of the lowest tip [m]."""
    return float(planar_tips(backbone, 20_000)[:, 1].min())


def folds(backbone: Backbone, points: int = 361) -> list[Array]:
    """Return the curves that two sections' reachable tips end or fold at, distance from the axis and height [m].

    They are planar poses in which both bends move the tip along one line, planar poses with a bend at its limit, and
    poses with both bends at their limits in any two planes; each of shape (K, 2).
    """
    import contourpy

    first, second = (np.linspace(-limit, limit, points) for limit in backbone.limits)
    angles = np.stack(np.meshgrid(first, second, indexing="ij"), axis=-1)
    J = sections.jacobian(_planar(angles), backbone, check=False)[..., :3, :]
    determinant = J[..., 0, 0] * J[..., 2, 2] - J[..., 2, 0] * J[..., 0, 2]
    lines = contourpy.contour_generator(first, second, determinant.T).lines(0.0)
    edges = [np.stack([np.full(points, side * backbone.limits[0]), second], axis=1) for side in (-1, 1)]
    edges += [np.stack([first, np.full(points, side * backbone.limits[1])], axis=1) for side in (-1, 1)]
    planar = [sections.position(_planar(line), backbone, check=False)[:, [0, 2]] for line in [*lines, *edges]]
    turn = np.linspace(0.0, np.pi, points)
    both = np.zeros((points, 2, 2))
    both[:, 0, 0], both[:, 1] = first[-1], second[-1] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    tips = sections.position(both, backbone, check=False)
    corner = np.stack([np.hypot(tips[:, 0], tips[:, 1]), tips[:, 2]], axis=1)
    return [*planar, corner, corner * [-1, 1]]


def _planar(angles: Array) -> Array:
    """Return bends, shape (..., S, 2), of bend angles in the x-z plane, shape (..., S)."""
    return np.stack([angles, np.zeros_like(angles)], axis=-1)
