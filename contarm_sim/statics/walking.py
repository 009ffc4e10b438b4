"""Arms taken from rest to rest, all together: Newton with what rubs, one load after the other.

Steps are those of `together`: plain, halved where they leave more force than before. They begin where the last pose
would be if winches bent the arm by as much as they seem to. An arm that does not come to rest so begins at the last
pose itself, and then takes the step of its load in halves; the others do not notice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import ContarmError, NoEquilibriumError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Drive, Load, Wrench
from contarm_sim.statics.failures import impossible, possible, unsettled, unstable
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.rubbing import Rubbing
from contarm_sim.statics.several import SeveralPoses
from contarm_sim.statics.solver import TOTAL_STEP, tolerance
from contarm_sim.statics.stiffness import TangentStiffness, definite, solved

HALVES = 6
"""Most times that a step of the load is halved."""

ITERATIONS, HALVINGS = 30, 4
"""Most steps of Newton, and most tries for one: fewer than from far away, for half of the load is the better try."""

Rows = NDArray[np.intp]


class Walk:
    """C arms, alike, on their way through loads.

    Args:
        arms: of the cases, with what rubs.
        bare: the same without friction.
        kind: how their muscles are driven.

    Attributes:
        poses: of the arms; where they were at rest last.
        rubbing: what rubs, and its state.
    """

    def __init__(self, arms: Sequence[Arm], bare: Sequence[Arm], kind: Drive) -> None:
        self.poses = SeveralPoses(bare, kind)
        self._bare = list(bare)
        self._tolerance = np.array([tolerance(arm) for arm in bare])
        self._largest = TOTAL_STEP / self.poses.arm.links
        self._loads = [Load()] * len(arms)
        self._applied: list[Load] = []
        self._control = self.poses.control[:, : self.poses.index.zero.shape[0]] * 0.0
        self._put(self._loads)
        self._every = np.arange(len(arms))
        self.poses.derive(self._every)
        self.rubbing = Rubbing(self.poses, arms)

    def begin(self, qpos: Array, control: Array, loads: Sequence[Load]) -> None:
        """Put the arms at joint angles [rad], shape (C, dofs), under controls, shape (C, M), and loads."""
        self.poses.qpos[:] = qpos
        for row in self._every.tolist():
            self.poses.send(row, control[row])
        self._control, self._loads = np.array(control), list(loads)
        self._put(loads)
        self.poses.derive(self._every)
        self.rubbing.restart()

    def step(
        self, rows: Rows, control: Array, loads: Sequence[Load], lead: Array, bare: Sequence[Arm] | None = None
    ) -> dict[int, ContarmError]:
        """Take these arms to rest under the next controls, shape (C, M), and loads; return why some did not get there.

        Args:
            rows: of the arms.
            control: of all arms.
            loads: of all arms; how they drive muscles is in `control`.
            lead: by what joint angles may change [rad], shape (C, dofs): where the search begins.
            bare: the arms themselves, where they carry something else now.
        """
        if bare is not None:
            for row in rows.tolist():
                if bare[row] is not self._bare[row]:
                    self.poses.become(row, bare[row])
                    self._bare[row] = bare[row]
        start = self.poses.qpos.copy()
        self._put(loads)
        for row in rows.tolist():
            self.poses.send(row, control[row])
        self.poses.qpos[rows] += lead[rows]
        lost, failed = self._rest(rows), {}
        if len(lost) and lead[lost].any():
            self.poses.qpos[lost] = start[lost]
            lost = self._rest(lost)
        for row in lost.tolist():
            self.poses.qpos[row] = start[row]
            error = self._halved(row, self._control[row], control[row], self._loads[row], loads[row])
            if error is not None:
                failed[row] = error
                self.poses.qpos[row] = start[row]
        if len(lost):
            self._put(loads)
        self._control[rows], self._loads = control[rows], list(loads)
        return failed

    def _halved(
        self, row: int, before: Array, after: Array, load: Load, then: Load, depth: int = 1
    ) -> ContarmError | None:
        """Take one arm to its next rest in halves of the step."""
        start, one = self.poses.qpos[row].copy(), np.array([row])
        if depth > HALVES:
            return self._lost(row)
        middle, between = 0.5 * (before + after), _between(load, then)
        for first, second, a, b in ((before, middle, load, between), (middle, after, between, then)):
            self.poses.send(row, second)
            own = list(self._applied)
            own[row] = b
            self._put(own)
            if len(self._rest(one)):
                self.poses.qpos[row] = start
                error = self._halved(row, first, second, a, b, depth + 1)
                if error is not None:
                    return error
            start = self.poses.qpos[row].copy()
        return None

    def _stay(self, rows: Rows, K: Array) -> NDArray[np.bool_]:
        """Return whether arms at rest would stay; friction at muscles takes energy, so an arm stays that would without.

        Along tendons it makes stiffness matrices that are not symmetric, of which little else can be said.
        """
        stays = definite(0.5 * (K + K.swapaxes(-1, -2)))
        if not stays.all():
            bare = self.rubbing.matrix(self._stiffness, gripping=False)[rows[~stays]]
            stays[~stays] = definite(0.5 * (bare + bare.swapaxes(-1, -2)))
        return stays

    def _lost(self, row: int) -> ContarmError:
        """Return why an arm has no rest."""
        plant, residual, allowed = self.poses.plant_of(row), float(self._residual[row]), float(self._tolerance[row])
        if residual > allowed:
            return unsettled(plant, residual, allowed, ITERATIONS)
        try:
            impossible(plant.arm, self.poses.qpos[row], self.rubbing.lengths_now[row])
        except NoEquilibriumError as error:
            return error
        K = self.rubbing.matrix(self._stiffness, gripping=False)[row]
        return unstable(plant, float(np.linalg.eigvalsh(0.5 * (K + K.T))[0]))

    def _put(self, loads: Sequence[Load]) -> None:
        """Let loads act; how they drive muscles apart."""
        same = len(self._applied) == len(loads) and all(
            a is b or (a.wrenches == b.wrenches and a.follower_moment == b.follower_moment
                       and a.actuation_moment == b.actuation_moment)
            for a, b in zip(self._applied, loads, strict=True)
        )  # fmt: skip
        self._applied = list(loads)
        if not same or not hasattr(self, "_stiffness"):
            self._stiffness = TangentStiffness(self.poses, AppliedLoad(self.poses, loads))

    def _rest(self, rows: Rows) -> Rows:
        """Take Newton's steps with these arms; carry what rubs of those that come to rest; return the others."""
        poses, rubbing, count = self.poses, self.rubbing, len(self._every)
        start, step = poses.qpos.copy(), np.zeros_like(poses.qpos)
        before, tries, iterations = np.full(count, np.inf), np.zeros(count, int), np.zeros(count, int)
        going = np.zeros(count, dtype=bool)
        going[rows] = True
        lost = np.zeros(count, dtype=bool)
        while True:
            poses.derive(np.flatnonzero(going))
            forces = rubbing.forces(self._stiffness)
            largest = np.abs(forces).max(axis=-1)
            residual = self._residual = np.where(np.isfinite(largest), largest, np.inf)
            accepted = (residual < before) | (tries >= HALVINGS)
            resting = going & accepted & (residual <= self._tolerance)
            lost |= going & accepted & ~resting & ((iterations >= ITERATIONS) | ~np.isfinite(residual))
            K = rubbing.matrix(self._stiffness)
            if resting.any():
                at = np.flatnonzero(resting)
                stays = self._stay(at, K[at]) & possible(poses.index, poses.qpos[at], rubbing.lengths_now[at])
                lost[at[~stays]] = True
                rubbing.carry(at[stays])
            going &= ~resting & ~lost
            if not going.any():
                return np.flatnonzero(lost)
            at = np.flatnonzero(going)
            move = solved(K[at], forces[at][..., None])[..., 0]
            move *= np.minimum(1.0, self._largest / np.maximum(np.abs(move).max(axis=-1), 1e-300))[:, None]
            new = accepted[at]
            step[at] = np.where(new[:, None], move, 0.5 * step[at])
            start[at] = np.where(new[:, None], poses.qpos[at], start[at])
            before[at] = np.where(new, residual[at], before[at])
            tries[at] = np.where(new, 1, tries[at] + 1)
            iterations[at] += new
            poses.qpos[at] = start[at] + step[at]


def _between(a: Load, b: Load) -> Load:
    """Return the load half way; what drives the muscles apart."""
    if a is b:
        return b

    def mean(one: Sequence[float], other: Sequence[float]) -> Any:
        return tuple(0.5 * (x + y) for x, y in zip(one, other, strict=True))

    none = (0.0, 0.0, 0.0)
    halves = [
        Wrench(xi=each.xi, force=mean(each.force, none), moment=mean(each.moment, none))
        for each in (*a.wrenches, *b.wrenches)
    ]
    follower, actuation = (mean(getattr(a, name), getattr(b, name)) for name in ("follower_moment", "actuation_moment"))
    return replace(b, wrenches=tuple(halves), follower_moment=follower, actuation_moment=actuation)
