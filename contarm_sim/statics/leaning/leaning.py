"""Downhill among rigid objects: what `descend` asks for, with contacts that press and do not pull.

Contact is rigid and without friction: gaps >= 0, forces >= 0, and no force across a gap. Each step is the least of the
energy to the second order under the gaps to the first; the curvature of the gaps, times the forces, is part of the
stiffness. Steps that raise the energy more than they close overlaps are taken back.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.statics.leaning.near import Chain, Near, nearest
from contarm_sim.statics.leaning.pressed import free, pressed_step, pressing, within
from contarm_sim.statics.leaning.surroundings import Surroundings
from contarm_sim.statics.leaning.tube import Tube
from contarm_sim.statics.solver import Solver

GAP = 1e-8
"""Largest overlap at rest, and gap that a force acts across [lengths]."""

ROUNDING = 1e-12
"""Overlap that has no price, and gap of a contact that is closed [lengths]: less comes and goes with rounding."""

TINY, CALM = 1e-5, 1e3
"""Change of joint angles [rad] and forces left [tolerances] below which closed contacts do no work but rounding."""

LEFT = 1e-6
"""Largest overlap between stations of an arm that lies flat on an object [lengths]."""

STRIDE, SEEN = 0.04, 0.1
"""Longest way of any part of the arm in one step, and how far it looks for objects [lengths]."""

CLOSED = 1e-3
"""Largest gap whose contact may press in the search [lengths]."""

DEAR = 2.0
"""Price of an overlap over the largest contact force."""


class Leaning:
    """A solver's arm among objects.

    Args:
        solver: of the arm alone, on its plant.
        surroundings: the objects.
        stations: arc lengths of the stations [m], shape (K,).

    Attributes:
        nears: where the arm is nearest to objects, at the pose last evaluated.
        press: the force there [N], shape (C,).
        slopes: how the gaps change with the joint angles [m/rad], shape (C, dofs).
    """

    def __init__(self, solver: Solver, surroundings: Surroundings, stations: Array) -> None:
        self.solver, self.tolerance, self.surroundings = solver, solver.tolerance, surroundings
        self.tube = Tube(stations, surroundings.radii)
        self.nears: list[Near] = []
        self._flat: set[tuple[int, int]] = set()
        self.press = self._gaps = np.zeros(0)
        self.slopes = np.zeros((0, len(solver.forces)))
        self._left, self._calm, self._matrix = solver.forces, False, np.zeros((0, 0))
        self._price, self._expected, self._overlap = 0.0, 0.0, 0.0

    @property
    def chain(self) -> Chain:
        """The arm at the pose last evaluated."""
        plant = self.solver.plant
        return Chain(
            plant.centres, plant.rotations, plant.data.xaxis, plant.data.xanchor, plant.index.station_of_dof
        )  # fmt: skip

    def look(self, far: float = SEEN) -> None:
        """Find where the arm is nearest to objects, up to a distance [lengths]."""
        chain = self.chain
        self.nears = nearest(self.tube, chain, self.surroundings, far * self.tube.length, self._flat)
        self._gaps = np.array([near.gap for near in self.nears])
        self.slopes = np.array([chain.slope(near) for near in self.nears]).reshape(-1, len(self.solver.forces))

    @property
    def deepest(self) -> float:
        """Largest overlap [m]."""
        return max(0.0, -float(self._gaps.min(initial=0.0)))

    @property
    def overlaps(self) -> bool:
        """Whether the arm overlaps an object by more than rounding."""
        return self.deepest > GAP * self.tube.length

    def forget(self) -> bool:
        """Forget what lay flat on objects; return whether the arm then overlaps one by more than `LEFT`."""
        self._flat.clear()
        self.look()
        return self.deepest > LEFT * self.tube.length

    # What `descend` asks for.

    def evaluate(self) -> float:
        """Derive forces and contacts; return what is left, overlaps and forces across gaps counted by `GAP`."""
        if not np.isfinite(self.solver.evaluate()):
            return float("inf")
        self.look()
        length, forces = self.tube.length, self.solver.forces
        for reach in (GAP, CLOSED):  # those that touch, if they bear it all
            closed = self._gaps < reach * length
            self.press = np.zeros(len(self.nears))
            self.press[closed] = pressing(self.slopes[closed], forces, self._gaps[closed], self.solver.scale)
            self._left = forces + self.press @ self.slopes
            left = float(np.abs(self._left).max())
            if left <= self.tolerance:
                break
        deepest = {near.number: 0.0 for near in self.nears}
        for near in self.nears:
            deepest[near.number] = max(deepest[near.number], -near.gap - ROUNDING * length)
        self._overlap = sum(deepest.values())  # of each object
        across = float(np.abs(self._gaps[self.press > 0]).max(initial=0.0))
        self._calm = left < CALM * self.tolerance and max(self.deepest, across) < ROUNDING * length
        off = max(self.deepest, across) / (GAP * length) * self.tolerance
        return max(left, off)

    def linearise(self) -> None:
        """Derive the stiffness, with what turning normals and sliding contacts add."""
        self._matrix = self.solver.tangent()
        chain = self.chain
        for near, force in zip(self.nears, self.press, strict=True):
            if force > 0:
                self._matrix -= force * chain.second(near, self.surroundings)

    def step(self, damping: float) -> Array | None:
        """Return the change of the joint angles [rad], or None, see `Descent`."""
        K, solver = self._matrix, self.solver
        if damping:
            K = K + damping * np.diag(solver.scale)
        gaps = np.maximum(self._gaps, -0.5 * STRIDE * self.tube.length)
        found = pressed_step(K, solver.forces, self.slopes, gaps, self.press > 0)
        if found is None:
            return None
        step, largest = found
        share = min(solver.share(step), self._share(step))
        if damping <= 1 or not self._price:  # beyond, the damping is what presses
            self._price = max(self._price, DEAR * largest)
        pull = self._left if self._calm and np.abs(step).max() < TINY else solver.forces
        fall = share * float(pull @ step) - 0.5 * share**2 * float(step @ self._matrix @ step)
        self._expected = max(fall + share * self._price * self._overlap, 1e-300)
        return share * step

    def _share(self, step: Array) -> float:
        """Return what share of a step no part of the arm goes farther in than `STRIDE`."""
        chain = self.chain
        spin, drift = chain.axes * step[:, None], np.cross(chain.anchors, chain.axes) * step[:, None]
        turned = chain.station_of_dof[None, :] <= np.arange(len(chain.x))[:, None]
        ways = np.linalg.norm(np.cross(turned @ spin, chain.x) + turned @ drift, axis=1)
        return float(min(1.0, STRIDE * self.tube.length / max(float(ways.max()), 1e-300)))

    def lift(self) -> float:
        """Return a damping that makes the stiffness positive."""
        return self.solver.lifting(self._matrix)

    def state(self) -> tuple[Any, ...]:
        """Return what `restore` needs."""
        return (
            self.solver.state(),
            self.nears,
            self.press,
            self._gaps,
            self.slopes,
            self._left,
            self._calm,
            self._overlap,
        )

    def restore(self, state: tuple[Any, ...]) -> None:
        """Go back to a state."""
        before, self.nears, self.press, self._gaps, self.slopes, self._left, self._calm, self._overlap = state
        self.solver.restore(before)
        self.solver.plant.pose()

    def move(self, step: Array) -> None:
        """Change the joint angles [rad]."""
        self.solver.move(step)

    def released(self, before: tuple[Any, ...], step: Array) -> tuple[float, float]:
        """Return the energy that a step released and what was expected [J], overlaps counted by their price."""
        *_, left, calm, overlap = before
        if calm and self._calm and np.abs(step).max() < TINY:
            work = 0.5 * float((left + self._left) @ step)
        else:
            work, _ = self.solver.released(before[0], step)
        return work + self._price * (overlap - self._overlap), self._expected

    # What there is to say at rest.

    @property
    def pressing(self) -> Array:
        """How the gaps that press change with the joint angles [m/rad], shape (P, dofs)."""
        return self.slopes[self.press > 0]

    @property
    def stiffness(self) -> Array:
        """Stiffness [N m/rad] with the contacts' own, shape (dofs, dofs), at the pose last linearised."""
        return self._matrix

    def softest(self) -> float:
        """Return the smallest eigenvalue of the stiffness among changes that keep contacts closed [N m/rad]."""
        K = within(self._matrix, self.pressing)
        if not len(K):
            return float("inf")
        if self.solver.stiffness.symmetric:
            return float(np.linalg.eigvalsh(0.5 * (K + K.T))[0])
        return float(np.linalg.eigvals(K).real.min())

    def softest_mode(self) -> Array:
        """Return the change of joint angles of the softest mode, shape (dofs,)."""
        Z = free(self.pressing)
        K = Z.T @ self._matrix @ Z
        return np.asarray(Z @ np.linalg.eigh(0.5 * (K + K.T))[1][:, 0])

    def compliance(self) -> Array:
        """Return what joint angles give way by generalised forces, contacts closed [rad/(N m)], (dofs, dofs)."""
        Z = free(self.pressing)
        return np.asarray(Z @ np.linalg.solve(Z.T @ self._matrix @ Z, Z.T))
