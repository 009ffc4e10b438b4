"""Natural frequencies of a clamped beam whose sections differ: no muscles, no gravity, a point mass at the tip.

Rayleigh's beam. Along each section the state (w, w', M, Q), M = EI w'' and Q = M' + j omega^2 w', follows

    (w')' = M/EI,   M' = Q - j omega^2 w',   Q' = (m/L) omega^2 w,      j = (m/L) r^2/4, r the section's radius,

which the exponential of a 4x4 matrix solves; it is continuous where sections meet. Clamped w = w' = 0 at the base,
and M = 0, Q + payload omega^2 w = 0 at the tip: two equations for M and Q at the base, whose determinant vanishes.
"""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

_RATIO = 1.05
"""Between neighbouring frequencies at which signs are looked at."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def frequencies(arm: Arm, count: int) -> Array:
    """Return the lowest natural frequencies in a plane [Hz], shape (count,)."""
    from scipy.optimize import brentq

    mass, softness = arm.mass + arm.payload, sum(s.length / s.bending_stiffness for s in arm.sections)
    omega = 0.1 / np.sqrt(mass * arm.length**2 * softness)  # below the lowest
    found: list[float] = []
    before = _open(arm, omega)
    while len(found) < count:
        after = _open(arm, _RATIO * omega)
        if before * after <= 0:
            found.append(brentq(lambda x: _open(arm, x), omega, _RATIO * omega, xtol=1e-13 * omega))
        omega, before = _RATIO * omega, after
    return np.array(found) / (2 * np.pi)


def energy_shares(arm: Arm, frequency: float) -> Array:
    """Return the sections' shares of the elastic energy of a mode, shape (S,), near whose frequency [Hz] one is."""
    from scipy.linalg import expm

    omega = 2 * np.pi * frequency
    at_tip = _to_tip(arm, omega)
    _, _, (*_, loads) = np.linalg.svd(at_tip[2:] + arm.payload * omega**2 * np.outer([0, 1], at_tip[0]))
    state, energy = np.concatenate([np.zeros(2), loads]), []
    for number, section in enumerate(arm.sections):
        A = _matrix(arm, number, omega)
        moments = np.array([(expm(A * section.length * x) @ state)[2] for x in 0.5 * (1 + _NODES)])
        energy.append(section.length * float(_WEIGHTS @ moments**2) / section.bending_stiffness)
        state = expm(A * section.length) @ state
    return np.array(energy) / sum(energy)


def _open(arm: Arm, omega: float) -> float:
    """Return the determinant that vanishes at natural angular frequencies [rad/s]."""
    w, _, moment, shear = _to_tip(arm, omega)
    one, other = moment, shear + arm.payload * omega**2 * w
    return float(one[0] * other[1] - one[1] * other[0])


def _to_tip(arm: Arm, omega: float) -> Array:
    """Return the tip's state by M and Q at the base, shape (4, 2)."""
    from scipy.linalg import expm

    state = np.eye(4)[:, 2:]
    for number, section in enumerate(arm.sections):
        state = expm(_matrix(arm, number, omega) * section.length) @ state
    return np.asarray(state)


def _matrix(arm: Arm, number: int, omega: float) -> Array:
    """Return what the derivative of the state is by the state along a section, shape (4, 4)."""
    section, square = arm.sections[number], omega**2
    density = section.mass / section.length
    rotary = density * (section.section_radius or arm.disk_radii[number]) ** 2 / 4
    A = np.zeros((4, 4))
    A[0, 1], A[1, 2], A[2, 1], A[2, 3], A[3, 0] = (
        1,
        1 / section.bending_stiffness,
        -rotary * square,
        1,
        density * square,
    )
    return A
