"""The equilibrium under a whole load: from a guess, downhill, or by raising the load from nothing.

Newton with the closed-form stiffness is fast. Where it fails, or ends where the arm would not stay, loads with energy
are followed downhill. Dead couples and followers have none: the load is raised from nothing, each pose the guess for
the next, the way a load is put on an arm, with pseudo-transient steps (K + mu diag(k)) dq = Q, which move as a strongly
damped arm would, where Newton is lost.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.statics.descent import descend
from contarm_sim.statics.failures import unsettled, unstable
from contarm_sim.statics.solver import Solution, Solver

Method = Literal["auto", "newton", "pseudo-transient"]
METHODS: tuple[Method, ...] = get_args(Method)

SMALLEST_INCREMENT = 1e-3
"""Continuation gives up below this fraction of the load."""

EVALUATIONS = 1500
"""Most stiffness matrices for one load on 100 links; with more, fewer: seconds in all."""

SIDE = 0.5
"""How far a buckling arm is bent to the side that it falls to [rad]."""


class Whole:
    """What continuation raises beside the load: gravity, pressures, constant tensions; set-points stay."""

    def __init__(self, plant: Plant) -> None:
        self._gravity, self._pressure = plant.model.opt.gravity.copy(), plant.pressure.copy()
        self._tensions = plant.control.copy() if plant.constant_tensions else None

    def apply(self, solver: Solver, fraction: float) -> None:
        """Put a fraction of the whole load on."""
        plant = solver.plant
        solver.load.fraction = fraction
        plant.model.opt.gravity[:] = fraction * self._gravity
        plant.pressure[:] = fraction * self._pressure
        if self._tensions is not None:
            plant.control[:] = fraction * self._tensions


def solve(solver: Solver, method: Method = "auto") -> Solution:
    """Find the equilibrium under the whole load.

    Args:
        method: `newton` or `pseudo-transient` alone from the current pose; `auto`: Newton, and what else it takes
            where that fails or ends in an unstable pose.

    Raises:
        EquilibriumError: says how far it got.
        InputError: an unknown method.
    """
    if method not in METHODS:
        raise InputError("method", repr(method), ", ".join(METHODS))
    start = solver.plant.data.qpos.copy()
    solver.iterations = 0
    residual = pseudo_transient(solver) if method == "pseudo-transient" else solver.newton()
    if residual <= solver.tolerance:
        found = solver.solution(residual)
        if found.stable or method != "auto":
            return found
    elif method != "auto":
        raise unsettled(solver.plant, residual, solver.tolerance, solver.iterations)
    solver.plant.data.qpos[:] = start
    return solver.solution(_down(solver) if solver.stiffness.symmetric else _raised(solver))


def _down(solver: Solver) -> float:
    """Go downhill; off a saddle, such as an upright arm that buckles, along its softest mode, on the side of +X."""
    data = solver.plant.data
    steps = solver.steps
    residual, stable = descend(solver, steps)
    for _ in range(5):
        if stable or residual > solver.tolerance:
            break
        data.qpos += _side(solver)
        residual, stable = descend(solver, steps)
    if residual > solver.tolerance:
        raise unsettled(solver.plant, residual, solver.tolerance, solver.iterations)
    if not stable:
        raise unstable(solver.plant, solver.softest())
    return residual


def _side(solver: Solver) -> Array:
    """Return a bend along the softest mode, of two that are alike the one towards +X [rad], shape (dofs,)."""
    values, modes = np.linalg.eigh(solver.tangent())
    towards = _towards_x(solver)
    alike = modes[:, values <= values[0] + 0.05 * abs(values[0])]
    share = towards @ alike
    mode = alike @ share if np.linalg.norm(share) > 1e-6 else modes[:, 0]
    return np.asarray(SIDE * mode / np.abs(mode).sum())


def _towards_x(solver: Solver) -> Array:
    """Return 1 for hinges about y, which bend the arm towards +X, and 0 for others, shape (dofs,)."""
    return np.asarray(solver.plant.model.jnt_axis[:, 1] > 0.5, dtype=float)


def _most(solver: Solver) -> int:
    return int(EVALUATIONS * min(1.0, 200 / solver.plant.model.nv) ** 2)


def pseudo_transient(solver: Solver, iterations: int = 400) -> float:
    """Take damped steps, the less damped the smaller the residual; return the residual reached."""
    data = solver.plant.data
    residual = first = solver.evaluate()
    damping = 1.0
    for _ in range(iterations):
        if residual <= solver.tolerance or solver.iterations > _most(solver):
            break
        K = solver.tangent()
        K[np.diag_indices_from(K)] += damping * solver.scale
        try:
            step = np.linalg.solve(K, solver.forces)
        except np.linalg.LinAlgError:  # exactly singular
            break
        shortened = solver.limited(step)
        if np.abs(shortened).max() < np.abs(step).max() or step @ solver.forces < 0:
            damping = max(4 * damping, 1e-3)
            step = shortened if step @ solver.forces > 0 else 0 * step
        data.qpos[:] += step
        before, residual = residual, solver.evaluate()
        first = max(first, residual)
        damping = min(damping * np.clip(residual / max(before, 1e-300), 0.2, 2.0), 1e6)
        if residual < 1e-4 * first:
            damping *= 0.1
    return residual


def _raised(solver: Solver) -> float:
    """Raise the load from nothing to the whole, each pose the guess for the next."""
    data = solver.plant.data
    whole = Whole(solver.plant)
    reached, increment, residual = 0.0, 0.25, np.inf
    pose = data.qpos.copy()
    while reached < 1.0:
        fraction = min(1.0, reached + increment)
        whole.apply(solver, fraction)
        data.qpos[:] = pose
        residual = solver.newton(12)
        if residual > solver.tolerance or not _firm(solver):
            _nudge(solver, pose)
            residual = pseudo_transient(solver)
        if residual <= solver.tolerance and _firm(solver):
            pose, reached, increment = data.qpos.copy(), fraction, 1.5 * increment
            continue
        increment *= 0.5
        if increment < SMALLEST_INCREMENT or solver.iterations > _most(solver):
            error = unsettled(solver.plant, residual, solver.tolerance, solver.iterations, fraction)
            whole.apply(solver, 1.0)
            raise error
    return residual


def _firm(solver: Solver) -> bool:
    """Whether no eigenvalue of the stiffness has a real part below zero: the symmetric part mostly tells."""
    return solver.positive() or solver.softest() > 0


def _nudge(solver: Solver, pose: Array) -> None:
    """Start a little bent towards +X beside a pose, so that a buckling arm has a side to fall to."""
    solver.plant.data.qpos[:] = pose + 0.05 / solver.plant.arm.links * _towards_x(solver)
