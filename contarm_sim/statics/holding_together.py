"""Many poses at rest that meet given muscle lengths: what `Holder` does with one, to the bits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pneumatics import force, passive_slope, passive_tension
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import min_tensions
from contarm_sim.statics.downhill import Downhill
from contarm_sim.statics.holding import differences
from contarm_sim.statics.poses import Poses
from contarm_sim.statics.stiffness import dot, solved


class Holding(Downhill):
    """Poses of one arm that are to meet muscle lengths; `wanted` and the like as of `Holder`.

    Args:
        poses: where they start.
        wanted: muscle lengths [m], shape (C, n).
        tensions: of the actuators, to start from [N], shape (C, n).
        meant: what is wanted of the lengths, orthonormal columns, shape (C, n, 2 S); default the differences that bends
            of the arcs make.
        least_pressures: lowest pressures [Pa], shape (C, n), where these say what the lowest tensions are.
    """

    rows = (
        *Downhill.rows, "wanted", "least", "lengths", "_columns", "_least_pressures", "_error", "_by_length", "_free",
        "_by_tension", "extra",
    )  # fmt: skip

    def __init__(
        self, poses: Poses, wanted: Array, tensions: Array, meant: Array | None = None,
        least_pressures: Array | None = None,
    ) -> None:  # fmt: skip
        super().__init__(poses)
        arm = poses.arm
        muscles.require_drivable(arm)
        self._own = muscles.slices(arm)
        self._weight = max(group.servo_stiffness for group in arm.groups)
        self._per_metre = self._weight * max(group.routing.radius for group in arm.groups)
        self.wanted, self.tensions, self.extra = wanted, tensions.copy(), np.zeros((len(poses), 1))
        self.least = np.tile(min_tensions(arm), (len(poses), 1))
        self._alike = differences(arm) if meant is None else None
        self._columns = np.zeros((len(poses), 0)) if meant is None else meant
        self._pressed = least_pressures is not None
        self._least_pressures = np.zeros((len(poses), 0)) if least_pressures is None else least_pressures
        self.lengths = self._error = self._by_length = self._free = self._by_tension = np.zeros((len(poses), 0))

    @property
    def _meant(self) -> Array:
        return self._columns.swapaxes(-1, -2) if self._alike is None else self._alike

    def evaluate(self) -> Array:
        """Derive forces and lengths; return the largest force left of each, what errors of length pull included."""
        poses, arm = self.poses, self.poses.arm
        poses.pose(actuated=False)
        self.lengths = poses.muscle_lengths
        if self._pressed:
            self.least = self._least_pressures * force(1.0, self.lengths, arm)
        self._total = self.tensions + passive_tension(self.lengths, arm)
        poses.tighten(self._total)
        self.forces = self.stiffness.forces(self._total) + self.extra
        self._swing = self.stiffness.swing()
        self._error = (self._meant @ (self.wanted - self.lengths)[..., None])[..., 0]
        pulled = self._per_metre * np.abs(self._error).max(axis=-1)
        return np.asarray(np.maximum(np.abs(self.forces).max(axis=-1), pulled))

    def linearise(self) -> Array:
        """Derive the stiffness matrices, and what tensions and lengths have to do with joint angles."""
        poses, meant, weight = self.poses, self._meant, self._weight
        K = self.stiffness.matrix(self._total, passive_slope(self.lengths, poses.arm))
        J, columns = poses.muscle_jacobian, meant.swapaxes(-1, -2)
        self._by_length = np.array(np.broadcast_to(meant @ J, (len(poses), meant.shape[-2], J.shape[-1])), order="C")
        columns = np.broadcast_to(columns, (len(poses), *columns.shape[-2:]))
        self._free = columns.copy()
        for own in self._own:
            slackest = own.start + np.argmax((self.least - self.tensions)[:, own], axis=-1)
            self._free[:, own] -= columns[np.arange(len(poses)), slackest][:, None]
        self._by_tension = (J + poses.twist_by_tension).swapaxes(-1, -2) @ self._free
        return K + (weight * self._by_length).swapaxes(-1, -2) @ self._by_length

    def keep(self, rows: NDArray[np.bool_]) -> None:
        """Go on with these of the cases alone."""
        self._swing = tuple(each[rows] for each in self._swing)  # type: ignore[assignment]
        super().keep(rows)

    def step(self, K: Array) -> Array:
        """Return the plain changes of joint angles [rad] and tensions [N]."""
        pushed = ((self._weight * self._error)[..., None, :] @ self._by_length)[..., 0, :]
        found = solved(K, np.concatenate([(self.forces + pushed)[..., None], self._by_tension], axis=-1))
        bent, free = found[..., 1:], found[..., :1]
        turned = self._by_length @ bent
        pull = solved(turned, self._by_length @ free - self._error[..., None])
        step = (free - bent @ pull)[..., 0]
        share = self.share(step)
        return np.concatenate([share * step, share * (self._free @ pull)[..., 0]], axis=-1)

    def state(self) -> tuple[Any, ...]:
        """Return what `released` needs of the states before a step."""
        return self.forces, self.tensions, self._error, self._swing

    def move(self, step: Array) -> None:
        """Change joint angles [rad] and tensions [N]; the slackest muscle of each section has the least."""
        dofs = self.poses.qpos.shape[-1]
        self.poses.qpos += step[:, :dofs]
        tensions = self.tensions + step[:, dofs:]
        for own in self._own:
            tensions[:, own] += (self.least - tensions)[:, own].max(axis=-1, keepdims=True)
        self.tensions = tensions

    def released(self, before: tuple[Any, ...], step: Array) -> tuple[Array, Array]:
        """Return the energies that steps released and what was expected of them [J]."""
        forces, tensions, error, swing = before
        weight, turn = 0.5 * self._weight, np.ascontiguousarray(step[:, : forces.shape[-1]])
        sought = weight * dot(error, error)
        work = 0.5 * dot(forces + self.forces, turn) + sought - weight * dot(self._error, self._error)
        work = work + self.stiffness.work(swing, self._swing, turn, 0.5 * (tensions + self.tensions))
        return work, dot(0.5 * forces, turn) + sought

    def setpoints(self) -> tuple[Array, NDArray[np.bool_]]:
        """Return the controls of length servos that hold the poses [m], shape (C, n), and whether servos can."""
        arm = self.poses.arm
        control = servo_control(self.lengths, self.tensions, arm)
        limit = muscles.each(arm, lambda group: group.law.blocked_force)
        low = muscles.each(arm, lambda group: group.setpoint_range[0])
        high = muscles.each(arm, lambda group: group.setpoint_range[1])
        within = (self.tensions <= limit) & (control >= low) & (control <= high)
        return control, np.all(within, axis=-1)

    def pressures(self) -> tuple[Array, NDArray[np.bool_]]:
        """Return the pressures that hold the poses [Pa], shape (C, n), and whether there are such."""
        arm = self.poses.arm
        per_pascal = force(1.0, self.lengths, arm)
        pressures = np.divide(self.tensions, per_pascal, out=np.full(per_pascal.shape, np.inf), where=per_pascal > 0)
        limit = muscles.each(arm, lambda group: group.pneumatics.max_pressure)
        return pressures, np.all(pressures <= limit, axis=-1)
