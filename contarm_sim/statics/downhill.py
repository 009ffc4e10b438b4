"""Downhill with many poses at once: what `descend` does with one, to the bits, while its steps are plain.

A case whose step does not release energy, or whose stiffness is not positive, leaves: whoever solves it alone damps its
steps.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.load import Load
from contarm_sim.statics.descent import LEFT, SHARE
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.poses import Poses
from contarm_sim.statics.servos import Servos
from contarm_sim.statics.solver import TOTAL_STEP, tolerance
from contarm_sim.statics.stiffness import TangentStiffness, definite, dot, solved

PLAIN = 100
"""Most plain steps."""


class Downhill(ABC):
    """Poses of arms without a load of their own, on their way to rest.

    Attributes:
        poses: those that are still on their way.
        tolerance: largest generalised force left at rest [N m].
        places: of these, among those given, shape (C,).
        residual: largest generalised force left at the present poses [N m], shape (C,).
        forces: generalised forces left [N m], shape (C, dofs).
        tensions: of the muscles [N], shape (C, M).
    """

    rows: ClassVar[tuple[str, ...]] = ("places", "residual", "forces", "tensions")
    """What has a row for each case."""

    def __init__(self, poses: Poses) -> None:
        self.poses, self.tolerance = poses, tolerance(poses.arm)
        self._largest = TOTAL_STEP / poses.arm.links
        self.places = np.arange(len(poses))
        self.residual = np.full(len(poses), np.inf)
        self.forces: Array = np.zeros_like(poses.qpos)
        self.tensions: Array = np.zeros((len(poses), len(poses.index.zero)))
        self._load()

    def _load(self) -> None:
        poses = self.poses
        self.stiffness = TangentStiffness(poses, AppliedLoad(poses, [Load()] * len(poses)))

    def __call__(self, arrived: Callable[[NDArray[np.intp]], None]) -> None:
        """Go down; call `arrived` with the rows of those on their way that come to rest in a minimum."""
        self.residual = self.evaluate()
        accepted = np.isfinite(self.residual)
        for _ in range(PLAIN):
            K = self.linearise()
            accepted &= definite(K)
            resting = self.residual <= self.tolerance
            if (accepted & resting).any():
                arrived(np.flatnonzero(accepted & resting))
            going = accepted & ~resting
            if not going.any():
                return
            if not going.all():
                self.keep(going)
                K = K[going]
            step, before = self.step(K), self.state()
            residual = self.residual
            self.move(step)
            self.residual = now = self.evaluate()
            gain, expected = self.released(before, step)
            accepted = np.isfinite(now) & ((gain > SHARE * expected) | (now <= LEFT * residual))

    def keep(self, rows: NDArray[np.bool_]) -> None:
        """Go on with these of the cases alone."""
        self.poses.keep(rows)
        for name in self.rows:
            setattr(self, name, getattr(self, name)[rows])
        self._load()

    def share(self, step: Array) -> Array:
        """Return what shares of changes of joint angles [rad] are not too much at once, shape (C, 1)."""
        longest = np.maximum(np.abs(step).max(axis=-1, keepdims=True), 1e-300)
        return np.asarray(np.minimum(1.0, self._largest / longest))

    @abstractmethod
    def evaluate(self) -> Array:
        """Derive the forces at the present states; return the largest left of each [N m]."""

    @abstractmethod
    def linearise(self) -> Array:
        """Derive the stiffness matrices at the present states."""

    @abstractmethod
    def step(self, K: Array) -> Array:
        """Return the plain steps, of these stiffness matrices."""

    @abstractmethod
    def state(self) -> tuple[Any, ...]:
        """Return what `released` needs of the states before a step."""

    @abstractmethod
    def move(self, step: Array) -> None:
        """Change the unknowns."""

    @abstractmethod
    def released(self, before: tuple[Any, ...], step: Array) -> tuple[Array, Array]:
        """Return the energies that steps released and what was expected of them [J]."""


class Settling(Downhill):
    """Poses under the controls of their muscles: what a call of `Solver` does with one."""

    rows = (*Downhill.rows, "_unlimited")

    def __init__(self, poses: Poses) -> None:
        super().__init__(poses)
        self._unlimited: Array = np.zeros_like(self.tensions)

    def _load(self) -> None:
        super()._load()
        self._servos = Servos(self.poses)

    def evaluate(self) -> Array:
        """Derive the forces at the present states; return the largest left of each [N m]."""
        poses = self.poses
        poses.pose()
        self.tensions = poses.muscle_tensions
        poses.tighten(self.tensions)
        self.forces = self.stiffness.forces(self.tensions)
        self._unlimited, self._swing = self._servos.unlimited(), self.stiffness.swing()
        return np.asarray(np.abs(self.forces).max(axis=-1))

    def linearise(self) -> Array:
        """Derive the stiffness matrices at the present states."""
        return self.stiffness.matrix(self.tensions, self.poses.muscle_slopes)

    def keep(self, rows: NDArray[np.bool_]) -> None:
        """Go on with these of the cases alone."""
        self._swing = tuple(each[rows] for each in self._swing)  # type: ignore[assignment]
        super().keep(rows)

    def step(self, K: Array) -> Array:
        """Return the plain steps, of these stiffness matrices."""
        step = solved(K, self.forces[..., None])[..., 0]
        return step * self.share(step)

    def state(self) -> tuple[Any, ...]:
        """Return what `released` needs of the states before a step."""
        return self.forces, self.tensions, self._unlimited, self._swing

    def move(self, step: Array) -> None:
        """Change the joint angles [rad]."""
        self.poses.qpos += step

    def released(self, before: tuple[Any, ...], step: Array) -> tuple[Array, Array]:
        """Return the energies that steps released and what was expected of them [J]."""
        forces, tensions, unlimited, swing = before
        work = 0.5 * dot(forces + self.forces, step) - self._servos.kinks(unlimited, self._unlimited)
        work = work + self.stiffness.work(swing, self._swing, step, 0.5 * (tensions + self.tensions))
        return work, dot(0.5 * forces, step)
