"""`TipPlan` of many samples at once, to the bits of one; samples whose steps need damping are left to that."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contarm_sim.control.tip_plan import FAINT, FLOOR, ITERATIONS, KEPT, LARGEST, LONGEST, NEARER, STEP, eased, raised
from contarm_sim.engine.plant import Plant
from contarm_sim.engine.threads import shared_out
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.routing import length_jacobian, lengths_from_bend
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.model.arm import Arm
from contarm_sim.statics.cases import BUNCH
from contarm_sim.statics.holding_together import Holding
from contarm_sim.statics.poses import Poses, Starts
from contarm_sim.statics.stiffness import dot

Solved = tuple[Array, Array, Array, Array]
"""Of a sample: set-points [m], muscle lengths [m], the tip's derivatives by the bend [m/rad], joint angles [rad]."""


@dataclass(frozen=True)
class Asked:
    """Samples to solve, one a row: see `TipPlan.solve`.

    Attributes:
        qpos: joint angles to start from [rad].
        bend: bends asked for [rad], shape (C, 2 S).
        target: of the tip [m], shape (C, 3).
        forces: on the joints [N m], shape (C, dofs).
        least: tensions that muscles keep [N], shape (C, n).
        checked: refuse set-points that servos at rest cannot follow.
    """

    qpos: Array
    bend: Array
    target: Array
    forces: Array
    least: Array
    checked: bool

    def rows(self, which: slice | NDArray[np.intp]) -> Asked:
        """Return some of them."""
        return replace(
            self, qpos=self.qpos[which], bend=self.bend[which], target=self.target[which], forces=self.forces[which],
            least=self.least[which],
        )  # fmt: skip


@dataclass
class _At:
    """Samples at rest, one a row: where, and how the tip moves with the bend."""

    qpos: Array
    tensions: Array
    lengths: Array
    tip: Array
    slope: Array

    def take(self, rows: NDArray[np.intp], other: _At, of: NDArray[np.intp]) -> None:
        """Take rows from others."""
        for name, values in vars(self).items():
            values[rows] = getattr(other, name)[of]


def solve_many(arm: Arm, asked: Asked) -> dict[int, Solved]:
    """Return what was found of samples of an arm, by their rows.

    Others need `TipPlan`, for their steps or for the error that says why there is no solution.
    """
    starts = range(0, len(asked.bend), BUNCH)
    bunches = [asked.rows(slice(first, first + BUNCH)) for first in starts]
    solved = shared_out(lambda bunch: _Bunch(arm, bunch)(), bunches)
    return {first + row: one for first, found in zip(starts, solved, strict=True) for row, one in found.items()}


class _Bunch:
    """Samples of one arm, solved together."""

    def __init__(self, arm: Arm, asked: Asked) -> None:
        self._arm, self._plant, self._asked = arm, Plant(arm), asked
        self._keep = 0.0 if len(arm.sections) == 1 else (KEPT * arm.length) ** 2
        self._low = muscles.each(arm, lambda group: group.setpoint_range[0])
        self._high = muscles.each(arm, lambda group: group.setpoint_range[1])
        self._strongest = muscles.each(arm, lambda group: group.law.blocked_force)
        self._stiffness = muscles.each(arm, lambda group: group.servo_stiffness)

    def __call__(self) -> dict[int, Solved]:
        asked = self._asked
        count, size = asked.bend.shape
        at, arrived = self._rest(asked, asked.qpos, asked.least, asked.bend)
        lost = np.ones(count, dtype=bool)
        lost[arrived] = False
        bend, damping, curved = asked.bend.copy(), np.zeros(count), np.zeros((count, size, size))
        excess, unit = self._excess(at), np.eye(size)
        going = np.flatnonzero(~lost)
        for _ in range(ITERATIONS):
            slope, off = at.slope[going], asked.target[going] - at.tip[going]
            turned = slope.swapaxes(-1, -2)
            gram = turned @ slope + curved[going] + self._keep * unit
            pull = (turned @ off[..., None])[..., 0] + self._keep * (asked.bend[going] - bend[going])
            trace = np.trace(gram, axis1=-2, axis2=-1)
            damped = gram + ((damping[going] + FLOOR) * trace)[:, None, None] * unit
            change = np.linalg.solve(damped, pull[..., None])[..., 0]
            length = np.sqrt(dot(change, change))
            far = length > STEP
            going, change, off, slope = going[far], change[far], off[far], slope[far]
            if not len(going):
                break
            change *= np.minimum(1.0, LONGEST / length[far])[:, None]
            cost = self._cost(off, bend[going], asked.bend[going])
            nearer, left, there = self._nearer(asked, at, going, bend[going] + change, cost, excess[going])
            lost[going[left]] = True
            some, taken = there
            rows = going[nearer]
            at.take(rows, some, taken)
            excess[rows] = self._excess(some)[taken]
            bend[rows] += change[nearer]
            damping[rows] = eased(damping[rows])
            now = asked.target[rows] - at.tip[rows]
            turn = ((slope[nearer] - at.slope[rows]).swapaxes(-1, -2) @ now[..., None])[..., 0]
            curved[rows] = _curved(curved[rows], change[nearer], turn, at.slope[rows])
            back = going[~nearer & ~left]
            damping[back], curved[back] = raised(damping[back]), 0.0
            going = going[~left]
        return self._found(at, np.flatnonzero(~lost))

    def _found(self, at: _At, rows: NDArray[np.intp]) -> dict[int, Solved]:
        control = servo_control(at.lengths, at.tensions, self._arm)
        within = (at.tensions <= self._strongest) & (control >= self._low) & (control <= self._high)
        follows = np.all(within, axis=-1) | (not self._asked.checked)
        return {i: (control[i], at.lengths[i], at.slope[i], at.qpos[i]) for i in rows.tolist() if follows[i]}

    def _nearer(
        self, asked: Asked, at: _At, going: NDArray[np.intp], bend: Array, cost: Array, excess: Array
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], tuple[_At, NDArray[np.intp]]]:
        """Return which of those going come nearer at bends, which are lost, and where the nearer ones are."""
        near, left = np.zeros(len(going), dtype=bool), np.zeros(len(going), dtype=bool)
        tried = np.flatnonzero(np.hypot(bend[:, ::2], bend[:, 1::2]).max(axis=-1) <= LARGEST)
        places = going[tried]
        some, arrived = self._rest(asked.rows(places), at.qpos[places], at.tensions[places], bend[tried])
        left[tried] = True
        left[tried[arrived]] = False
        off = asked.target[places] - some.tip
        far = self._cost(off, bend[tried], asked.bend[places])
        better = (far <= cost[tried] + (NEARER * self._arm.length) ** 2) & (self._excess(some) <= excess[tried])
        better &= ~left[tried]
        near[tried] = better
        return near, left, (some, np.flatnonzero(better))

    def _rest(self, asked: Asked, qpos: Array, tensions: Array, bend: Array) -> tuple[_At, NDArray[np.intp]]:
        """Bring samples to rest at the lengths of bends; return where they are, and the rows of those that do."""
        arm, plant, count = self._arm, self._plant, len(bend)
        muscle_count, dofs = tensions.shape[1], qpos.shape[1]
        at = _At(
            qpos.copy(), tensions.copy(), np.zeros_like(tensions), np.zeros((count, 3)),
            np.zeros((count, 3, bend.shape[1])),
        )  # fmt: skip
        if not count:
            return at, np.zeros(0, dtype=int)
        problem = _TipHolding(
            Poses(plant, Starts(qpos, np.zeros((count, muscle_count)))), lengths_from_bend(bend, arm), tensions
        )
        problem.least, problem.extra = asked.least, np.broadcast_to(asked.forces, (count, dofs))
        bends, done = length_jacobian(bend, arm), list[NDArray[np.intp]]()

        def arrived(rows: NDArray[np.intp]) -> None:
            cases, poses = problem.places[rows], problem.poses
            at.qpos[cases], at.tensions[cases], at.lengths[cases] = (
                poses.qpos[rows], problem.tensions[rows], problem.lengths[rows]
            )  # fmt: skip
            at.tip[cases] = poses.data.xpos[rows, poses.index.tip]
            J = np.array([poses.tip_jacobian(row)[:3] for row in rows.tolist()])
            at.slope[cases] = J @ problem.by_lengths(rows) @ bends[cases]
            done.append(cases)

        problem(arrived)
        return at, np.concatenate([np.zeros(0, dtype=int), *done])

    def _cost(self, off: Array, bend: Array, asked: Array) -> Array:
        return dot(off, off) + self._keep * np.square(bend - asked).sum(axis=-1)

    def _excess(self, at: _At) -> Array:
        """Return how far poses are beyond what length servos can hold [N], as `Holder.excess`."""
        control = servo_control(at.lengths, at.tensions, self._arm)
        beyond = np.maximum(self._low - control, control - self._high) * self._stiffness
        over = np.maximum(beyond.max(axis=-1), (at.tensions - self._strongest).max(axis=-1))
        return np.maximum(0.0, over)


class _TipHolding(Holding):
    """`Holding`, and what joint angles gain by lengths where it ends."""

    def linearise(self) -> Array:
        """Derive the stiffness matrices at the present states."""
        self._matrix = super().linearise()
        return self._matrix

    def by_lengths(self, rows: NDArray[np.intp]) -> Array:
        """Return the derivative of joint angles by wanted lengths of some rows [rad/m], shape (R, dofs, n)."""
        by_length, error, weight = self._by_length[rows], self._error[rows], self._weight
        pushed = ((weight * error)[..., None, :] @ by_length)[..., 0, :]
        rest = np.concatenate([(self.forces[rows] + pushed)[..., None], self._by_tension[rows]], axis=-1)
        bent = np.linalg.solve(self._matrix[rows], rest)[..., 1:]
        return np.asarray(bent @ np.linalg.solve(by_length @ bent, self._meant))


def _curved(curved: Array, change: Array, turned: Array, slope: Array) -> Array:
    """Return what the tip's second derivative adds to slope^T slope, shape (C, 2, 2): see `tip_plan`."""
    if change.shape[-1] > 2:
        return np.zeros_like(curved)
    miss = turned - (curved @ change[..., None])[..., 0]
    along = dot(miss, change)
    told = np.abs(along) > FAINT * (np.sqrt(dot(miss, miss)) * np.sqrt(dot(change, change)))
    added = miss[:, :, None] * miss[:, None, :] / np.where(told, along, 1.0)[:, None, None]
    curved = np.where(told[:, None, None], curved + added, curved)
    total = slope.swapaxes(-1, -2) @ slope + curved
    crossed = 1.01 * total[:, 0, 1] * total[:, 1, 0]
    positive = (total[:, 0, 0] > 0) & (total[:, 0, 0] * total[:, 1, 1] > crossed)
    return np.where(positive[:, None, None], curved, 0.0)
