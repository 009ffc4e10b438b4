"""Newton for many poses at once: what `Solver.newton` does for one, to the bits, while nothing goes wrong.

Steps are those of one pose alone: plain, halved where they leave more force than before. A case that does not come to
rest so, or not where it would stay, is left to whoever solves it alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.load import Load
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.poses import Poses
from contarm_sim.statics.solver import HALVINGS, ITERATIONS, TOTAL_STEP
from contarm_sim.statics.stability import growth_at
from contarm_sim.statics.stiffness import TangentStiffness, definite, solved


class Together:
    """Moves poses to rest, each under its load and the controls of its muscles.

    Attributes:
        places: of the cases that are still on their way, among those given, shape (C,).
        residual: largest generalised force left at their present poses [N m], shape (C,).
        iterations: evaluations of the stiffness matrix, shape (C,).
        symmetric: whether their loads have energy, shape (C,).
        growth: of a small disturbance [1/s], shape (C,), once they have come to rest; NaN where loads have energy.
        tensions: of the muscles [N], shape (C, M).
    """

    def __init__(self, poses: Poses, loads: Sequence[Load], tolerance: Array | float) -> None:
        self.poses, self._loads = poses, AppliedLoad(poses, loads)
        self.symmetric, self._tolerance = self._loads.symmetric, np.broadcast_to(tolerance, len(poses))
        self._largest = TOTAL_STEP / poses.arm.links
        self.places = np.arange(len(poses))
        self.iterations, self.growth = np.zeros(len(poses), dtype=int), np.full(len(poses), np.nan)
        self._start, self._step = poses.qpos.copy(), np.zeros_like(poses.qpos)
        self._before, self._tries = np.full(len(poses), np.inf), np.zeros(len(poses), dtype=int)
        self._stiffness = TangentStiffness(poses, self._loads)

    def __call__(self, arrived: Callable[[NDArray[np.intp], Array], None]) -> None:
        """Take steps; call `arrived` with the rows of those on their way that come to rest and stay there, and K."""
        while len(self.places):
            self._evaluate()
            accepted = (self.residual < self._before) | (self._tries >= HALVINGS)
            resting = accepted & (self.residual <= self._tolerance)
            lost = accepted & ((self.iterations >= ITERATIONS) | ~np.isfinite(self.residual))
            going = ~resting & ~lost
            K = self._stiffness.matrix(self.tensions, self.poses.muscle_slopes)
            if resting.any():
                rows = np.flatnonzero(resting)
                at_rest = K if len(rows) == len(K) else K[rows]
                stays = self._stays(rows, at_rest)
                if stays.all():
                    arrived(rows, at_rest)
                elif stays.any():
                    arrived(rows[stays], at_rest[stays])
            if not going.all():
                K, accepted = K[going], accepted[going]
                self._keep(going)
            if len(self.places):
                self._move(K, accepted)

    def _evaluate(self) -> None:
        poses = self.poses
        poses.pose()
        self.tensions = poses.muscle_tensions
        poses.tighten(self.tensions)
        self.forces = self._stiffness.forces(self.tensions)
        largest = np.abs(self.forces).max(axis=-1)
        self.residual = np.where(np.isfinite(largest), largest, np.inf)

    def _keep(self, rows: NDArray[np.bool_]) -> None:
        self.poses.keep(rows)
        self._loads.keep(rows)
        for name in ("places", "iterations", "growth", "residual", "forces", "_start", "_step", "_before", "_tries",
                     "symmetric", "_tolerance"):  # fmt: skip
            setattr(self, name, getattr(self, name)[rows])
        self._stiffness = TangentStiffness(self.poses, self._loads)

    def _move(self, K: Array, accepted: NDArray[np.bool_]) -> None:
        """Take the next step where the last is accepted, and else the half of it from where that began."""
        step = solved(K, self.forces[..., None])[..., 0]
        longest = np.maximum(np.abs(step).max(axis=-1), 1e-300)
        step *= np.minimum(1.0, self._largest / longest)[:, None]
        new = accepted[:, None]
        self._step = np.where(new, step, 0.5 * self._step)
        self._start = np.where(new, self.poses.qpos, self._start)
        self._before = np.where(accepted, self.residual, self._before)
        self._tries = np.where(accepted, 1, self._tries + 1)
        self.iterations += accepted
        np.add(self._start, self._step, out=self.poses.qpos)

    def _stays(self, rows: NDArray[np.intp], K: Array) -> NDArray[np.bool_]:
        """Return whether poses at rest, with these stiffness matrices, would stay."""
        stays = definite(0.5 * (K + K.swapaxes(-1, -2)))
        for i in np.flatnonzero(stays & ~self.symmetric[rows]).tolist():
            self.growth[rows[i]] = growth_at(self.poses, int(rows[i]), K[i])
            stays[i] = not self.growth[rows[i]] > 0
        return stays
