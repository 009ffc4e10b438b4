"""The ideal rod that held muscle lengths bend, under gravity and in motion: where its tip must be.

An inextensible rod of curvature u(s) in its own axes, clamped at its base, EI (u1, u2) + GJ u3 = R^T M with M(s) the
moment of all loads beyond s. Muscles parallel to the backbone measure the integral of (u1, u2) over each section, its
bend, and nothing else; so there u = bend/L + sum_k c_k P_k with Legendre polynomials P_k, k >= 1, whose integral is
zero (Ritz). Gravity and, in motion, inertia are loads (d'Alembert); damping is a moment. It shares no code with the
engine, nor links.

Loads are sums over `SEGMENTS` pieces of each section, each bent uniformly: for the arc, that is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

SEGMENTS = 32
"""Pieces of a section: the sag of one is off by a thousandth of itself."""

MODES = 6
"""Legendre polynomials a component beyond the uniform bend."""

STATIONS = (np.arange(SEGMENTS) + 0.5) / SEGMENTS
"""Middles of the pieces, in lengths of their section, shape (SEGMENTS,)."""

_ITERATIONS = 20
_CONVERGED = 1e-6
"""Largest change of a coefficient [rad]."""
_SURELY = 0.1
"""Of that, what is surely less by the slope of the step before, too."""


def polynomials(xi: Array) -> Array:
    """Return Legendre polynomials 0 to `MODES` over a section, shape (X, 1 + MODES), at places xi in lengths."""
    return np.asarray(legendre.legvander(2 * np.asarray(xi) - 1, MODES), dtype=float)


def rod_tips(
    arm: Arm, bend: Array, density: Array, tip_force: Array, moments: Array | float = 0.0,
    tension: Array | float = 0.0, guess: Array | None = None,
) -> Array:  # fmt: skip
    """Return where the tips of rods with held muscle lengths are [m], shape (T, 3); NaN where no equilibrium is found.

    Args:
        arm: its S sections' lengths, muscle radii and stiffnesses are read.
        bend: that the muscle lengths fix [rad], shape (T, 2 S).
        density: force per length on the pieces, base frame [N/m], shape (T, S * SEGMENTS, 3).
        tip_force: [N], shape (T, 3).
        moments: what a damping moment m(s) gives the polynomials, its integrals with P_k [N m^2], shape
            (T, S, 1 + MODES, 3).
        tension: sums of the tensions of each group of muscles [N], shape (T, G); of one group also (T,).
        guess: coefficients to start from [rad], shape (T, S, 1 + MODES, 3); default none: the arcs.
    """
    count = len(arm.sections)
    free = np.ones((count, 1 + MODES, 3), dtype=bool)
    free[:, 0, :2] = False
    for number, section in enumerate(arm.sections):
        free[number, :, 2] = section.torsional_stiffness is not None
    stiffness = _stiffness(arm, np.asarray(tension, dtype=float), len(bend))
    uniform = np.zeros((len(bend), count, 3))
    uniform[..., 0], uniform[..., 1] = -bend[:, 1::2], bend[:, 0::2]
    x = np.zeros((len(bend), int(free.sum()))) if guess is None else guess[:, free]
    size_of_x, step = x.shape[1], 1e-5
    loads = density, tip_force, np.broadcast_to(moments, (len(bend), *free.shape))

    def balance(x: Array, which: NDArray[np.intp]) -> tuple[Array, Array]:
        coefficients = np.zeros((len(x), *free.shape))
        coefficients[:, free] = x
        left, tip = _balance(arm, uniform[which], coefficients, stiffness[which], *(load[which] for load in loads))
        return left[:, free], tip

    tip, going = np.full((len(bend), 3), np.nan), np.arange(len(bend))
    slope = np.zeros((0, size_of_x, size_of_x))
    for _ in range(_ITERATIONS):
        if len(slope):  # most are there, and the slope of the step before shows it
            left, tips = balance(x[going], going)
            rests = np.abs(np.linalg.solve(slope, left[..., None])).max(axis=(1, 2)) < _SURELY * _CONVERGED
            tip[going[rests]] = tips[rests]
            going = going[~rests]
            if not len(going):
                break
        nudged = np.concatenate([x[going, None], x[going, None] + step * np.eye(size_of_x)], axis=1)
        left, tips = balance(nudged.reshape(-1, size_of_x), np.repeat(going, 1 + size_of_x))
        left = left.reshape(len(going), 1 + size_of_x, size_of_x)
        slope = (left[:, 1:] - left[:, :1]).swapaxes(1, 2) / step
        change = -np.linalg.solve(slope, left[:, 0, :, None])[..., 0]
        size = np.abs(change).max(axis=1)
        done = size < _CONVERGED
        tip[going[done]] = tips.reshape(len(going), 1 + size_of_x, 3)[done, 0]
        x[going] += change * np.minimum(1.0, 1.0 / np.maximum(size, 1e-300))[:, None]
        going, slope = going[~done], slope[~done]
        if not len(going):
            break
    return tip


def _stiffness(arm: Arm, tension: Array, rods: int) -> Array:
    """Return EI, EI, GJ of each rod's sections [N m^2], shape (T, S, 3), under sums of tensions [N], see `rod_tips`.

    A twisted muscle is a helix, and longer: it adds r^2 sum T to the GJ of each section that it runs through.
    """
    found = np.empty((rods, len(arm.sections), 3))
    pulls = np.broadcast_to(tension if tension.ndim == 2 else tension[..., None], (rods, len(arm.groups)))
    for number, section in enumerate(arm.sections):
        found[:, number, :2], twisting = section.bending_stiffness, np.full(rods, section.torsional_stiffness or 0.0)
        for group, pull in zip(arm.groups, pulls.T, strict=True):
            if group.crosses(number):
                twisting = twisting + group.routing.radius**2 * pull
        found[:, number, 2] = twisting
    return found


def _balance(
    arm: Arm, uniform: Array, coefficients: Array, stiffness: Array, density: Array, force: Array, moments: Array
) -> tuple[Array, Array]:
    """Return the moments left over [N m^2], integrals with P_k, shape (T, S, 1 + MODES, 3), and the tips [m]."""
    P = polynomials(STATIONS)
    lengths = np.array([section.length for section in arm.sections])
    h = np.repeat(lengths / SEGMENTS, SEGMENTS)[:, None]
    bent = np.einsum("sk,tnkd->tnsd", P, coefficients) / lengths[:, None, None]
    curvature = bent + (uniform / lengths[:, None])[:, :, None]
    R, ends = _shape(curvature.reshape(len(bent), -1, 3), h)
    middle, tip, load = 0.5 * (ends[:, 1:] + ends[:, :-1]), ends[:, -1], h * density
    beyond = np.cumsum(load[:, ::-1], axis=1)[:, ::-1] - load + force[:, None]
    turning = np.cross(middle, load)
    moment = np.cumsum(turning[:, ::-1], axis=1)[:, ::-1] - turning + np.cross(tip, force)[:, None]
    moment += np.cross(R[..., 2], load) * h / 8 - np.cross(middle, beyond)  # its own outer half, and about itself
    seen = np.einsum("tsij,tsi->tsj", R, moment).reshape(bent.shape)
    apart = stiffness[:, :, None] * bent - seen
    left = (lengths / SEGMENTS)[:, None, None] * np.einsum("sk,tnsd->tnkd", P, apart) + moments
    return left, tip


def _shape(curvature: Array, h: Array) -> tuple[Array, Array]:
    """Return orientations of the pieces' middles, shape (T, K, 3, 3), and their ends [m], (T, K + 1, 3).

    Args:
        curvature: of the K pieces in their own axes [1/m], shape (T, K, 3).
        h: their lengths [m], shape (K, 1).
    """
    half = _rotation(0.5 * h * curvature)
    chord = h[:, 0] * np.sinc(0.5 * h[:, 0] * np.linalg.norm(curvature, axis=-1) / np.pi)
    R, now = np.empty_like(half), np.broadcast_to(np.eye(3), half[:, 0].shape)
    for piece in range(curvature.shape[1]):
        R[:, piece] = now @ half[:, piece]
        now = R[:, piece] @ half[:, piece]
    steps = chord[..., None] * R[..., 2]
    return R, np.concatenate([np.zeros_like(steps[:, :1]), np.cumsum(steps, axis=1)], axis=1)


def _rotation(turn: Array) -> Array:
    """Return the rotation by a vector [rad], shape (..., 3) -> (..., 3, 3)."""
    angle = np.linalg.norm(turn, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(turn, -1, 0)
    W = np.zeros((*turn.shape, 3))
    W[..., 2, 1], W[..., 0, 2], W[..., 1, 0] = x, y, z
    W -= W.swapaxes(-1, -2)
    return np.eye(3) + np.sinc(angle / np.pi) * W + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * W @ W
