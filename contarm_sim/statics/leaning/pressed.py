"""The step to rest of an arm among rigid objects: a quadratic energy under linear bounds, by active sets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array

CHANGES = 30
"""Most changes of the set of contacts that press, for one step."""


LEAST = 1e-8
"""Least square of a lever that an overlap is closed by [m^2]."""

SLACK, FEASIBLE = 1e-7, 1e-5
"""How much bounds give way, so that those that are nearly alike share forces; what they all may leave of a step."""

DEAR = 1e3
"""Stiffness of overlaps that cannot all be closed, over the arm's."""

ACROSS, NOTHING = 100.0, 1e-9
"""How much more a force across a gap counts than one that is not balanced; what share of the largest is none."""


def pressing(J: Array, pull: Array, gaps: Array, scale: Array) -> Array:
    """Return the forces [N] >= 0 of contacts that best balance generalised forces, rather at closed gaps, shape (C,).

    Args:
        J: how gaps change with the joint angles [m/rad], shape (C, dofs).
        pull: what is to be balanced [N m], shape (dofs,).
        gaps: [m], shape (C,).
        scale: stiffness of the joints [N m/rad], shape (dofs,): soft joints count more.
    """
    from scipy.optimize import nnls

    if not len(J):
        return np.zeros(0)
    weight = 1 / np.sqrt(scale)
    ridge = SLACK * np.linalg.norm(J * weight, axis=1).max()
    across = np.diag(ACROSS * np.abs(gaps) * float(weight.max()) + ridge)
    rows, target = np.concatenate([(J * weight).T, across]), np.concatenate([-pull * weight, 0 * gaps])
    forces, _ = nnls(rows, target, maxiter=100 * (len(J) + 10))
    return np.where(forces > NOTHING * forces.max(), forces, 0.0)


def pressed_step(K: Array, pull: Array, J: Array, gaps: Array, guess: NDArray[np.bool_]) -> tuple[Array, float] | None:
    """Return the least of energy - pull . s + s K s / 2 where gaps + J s >= 0, and the largest force [N].

    Args:
        K: stiffness [N m/rad], shape (dofs, dofs).
        gaps: [m], shape (C,).
        guess: which contacts press, shape (C,).

    Returns:
        None where there is none, or none was found.
    """
    half = _factor(K)
    active = guess.copy()
    if half is not None and len(J):
        pressed = _pressing_ones(half, pull, J, gaps)
        if pressed is None:
            return _compromise(K, pull, J, gaps)
        active = pressed
    for _ in range(CHANGES):
        solved = _held_step(K, pull, J[active], gaps[active])
        if solved is None:
            return None
        step, forces = solved
        left = np.where(active, np.inf, gaps + J @ step)
        if half is not None:
            return step, float(np.abs(forces).max(initial=0.0))  # the set is that of the symmetric part
        if len(forces) and forces.min() < 0:
            active[np.flatnonzero(active)[forces.argmin()]] = False
        elif len(left) and left.min() < -1e-12:
            active[left.argmin()] = True
        else:
            firm = _factor(within(K, J[active])) is not None
            return (step, float(forces.max(initial=0.0))) if firm else None
    return None


def _compromise(K: Array, pull: Array, J: Array, gaps: Array) -> tuple[Array, float]:
    """Return the step that closes overlaps as well as it can where it cannot close all."""
    deep = gaps < 0
    lever = float(np.square(J[deep]).sum(axis=1).max(initial=0.0))
    price = DEAR * float(np.abs(K.diagonal()).max()) / max(lever, LEAST)
    step = np.linalg.solve(K + price * J[deep].T @ J[deep], pull - price * gaps[deep] @ J[deep])
    return np.asarray(step), price * float(-gaps.min())


def within(K: Array, J: Array) -> Array:
    """Return a stiffness among the changes that keep contacts closed, shape (free, free)."""
    Z = free(J)
    return np.asarray(Z.T @ K @ Z)


def free(J: Array) -> Array:
    """Return a basis of the changes that keep contacts closed, shape (dofs, free)."""
    if not len(J):
        return np.eye(J.shape[1])
    _, sizes, V = np.linalg.svd(J)
    return np.asarray(V[int((sizes > 1e-9 * max(sizes[0], 1e-300)).sum()) :].T)


def _factor(K: Array) -> Array | None:
    try:
        return np.asarray(np.linalg.cholesky(0.5 * (K + K.T)))
    except np.linalg.LinAlgError:
        return None


def _pressing_ones(half: Array, pull: Array, J: Array, gaps: Array) -> NDArray[np.bool_] | None:
    """Return which contacts press where stiffness is positive: least distance under linear bounds by NNLS.

    Lawson and Hanson, Solving Least Squares Problems, chapter 23. None where the bounds contradict each other.
    """
    from scipy.optimize import nnls

    A = np.linalg.solve(half, J.T)
    short = -gaps - A.T @ np.linalg.solve(half, pull)
    size = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
    short = short / np.maximum(size, SLACK * size.max())
    if short.max() <= 0:
        return np.zeros(len(gaps), dtype=bool)
    size = np.maximum(size, SLACK * size.max())
    bounds = np.concatenate([A / size, SLACK * np.eye(len(size)), short[None] / short.max()])
    target = np.zeros(len(bounds))
    target[-1] = 1.0
    forces, left = nnls(bounds, target, maxiter=100 * (len(gaps) + 10))
    return np.asarray(forces > 0) if left > FEASIBLE else None


def _held_step(K: Array, pull: Array, J: Array, gaps: Array) -> tuple[Array, Array] | None:
    """Return the step that closes gaps, shape (dofs,), and forces [N], shape (C,)."""
    count, held = len(K), len(J)
    soft = 1e-13 * float(np.abs(J).max(initial=0.0)) ** 2 * held / max(float(np.abs(K.diagonal()).max()), 1e-300)
    whole = np.block([[K, -J.T], [J, soft * np.eye(held)]])
    try:
        solved = np.linalg.solve(whole, np.concatenate([pull, -gaps]))
    except np.linalg.LinAlgError:
        return None
    return (solved[:count], solved[count:]) if np.isfinite(solved).all() else None
