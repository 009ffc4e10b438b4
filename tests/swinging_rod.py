"""The ideal rod in motion, without a link or a joint: the truth that a released arm is measured against.

A clamped Kirchhoff rod as in `rod`, of curvature u(s, t), with the inertia of a round section that fills its mass
(Rayleigh's beam where it is small) and internal damping of Kelvin and Voigt:

    R' = R [u]x,  p' = R e3,  moment K (u + tau du/dt),  K = diag(EI, EI, GJ); GJ None: u3 = 0

Unknowns are the values of u at Gauss nodes. A section turns at w = int R du/dt ds and moves at v = int w x p' ds, both
linear in du/dt: the virtual work of weight, payload, loads, elastic moment and of the inertia of every section gives
M(u) d2u/dt2 = Q(u, du/dt), as exact as polynomials on the panels are. Implicit Runge-Kutta (Radau, of order 5) in time.
Shares nothing with the package but parameters.
"""

from dataclasses import dataclass

import numpy as np
from collocation import Grid, cross, hat
from rod import parallel_rod
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from threadpoolctl import threadpool_limits


@dataclass(frozen=True)
class Motion:
    """A swing: base frame, SI units.

    Attributes:
        time: (T,).
        points, R: positions (T, X, 3) and orientations (T, X, 3, 3) at the stations asked for.
        energy: kinetic, elastic and of weight (T,).
        state: u and du/dt at the nodes (T, 2, G, n).
    """

    time: np.ndarray
    points: np.ndarray
    R: np.ndarray
    energy: np.ndarray
    state: np.ndarray


class SwingingRod:
    """Equations of motion of one arm's rod on a grid.

    Args:
        arm: length, mass, stiffnesses, damping_time, section_radius, gravity and payload are read.
        grid: panels and nodes, as an equilibrium of `rod` has them.
        wrenches: as (xi, force, moment), that act scaled by `course(t)`, one number or one for each; default 0.
    """

    def __init__(self, arm, grid, wrenches=(), course=None):
        self.arm, self.grid, self.course = arm, grid, course or (lambda t: 0.0)
        self.n = 2 if arm.torsional_stiffness is None else 3
        G = len(grid.nodes)
        self.size = G * self.n
        self.K = np.tile([arm.bending_stiffness, arm.bending_stiffness, arm.torsional_stiffness or 0.0][: self.n], G)
        self.K *= np.repeat(grid.weights, self.n)
        xi = np.array([1.0, *(x for x, *_ in wrenches)])
        self.S = np.vstack([grid.S, grid.integrals(arm.length * xi)])
        self.force = np.array([f for _, f, _ in wrenches]).reshape(-1, 3)
        self.couple = np.array([c for *_, c in wrenches]).reshape(-1, 3)
        self.mass = np.concatenate([arm.mass / arm.length * grid.weights, [arm.payload]])
        across = 0.25 * (arm.section_radius or arm.disk_radius) ** 2
        self.inertia = self.mass[:G, None] * across * np.array([1.0, 1.0, 2.0])  # about x, y, z of the section
        self.gravity = np.array(arm.gravity)

    def _full(self, u):
        full = np.zeros((len(self.grid.nodes), 3))
        full[:, : self.n] = u.reshape(-1, self.n)
        return full

    def _move(self, u):
        """Return R, t at nodes, and the turn W and the motion V of stations by du/dt: (X, 3, G n)."""
        R = self.grid.rotations(self._full(u))
        t = R[:, :, 2]
        W = np.einsum("xj,jac->xajc", self.S, R[:, :, : self.n]).reshape(-1, 3, self.size)
        return R, t, W, np.tensordot(self.S, cross(W[: len(t)], t), 1)

    def matrix(self, u):
        """Return the mass matrix (G n, G n), and what it was made of."""
        G = len(self.grid.nodes)
        R, _, W, V = moved = self._move(u)
        A = V[: G + 1].reshape(-1, self.size) * np.sqrt(np.repeat(self.mass, 3))[:, None]
        B = (np.sqrt(self.inertia)[:, :, None] * (R.swapaxes(1, 2) @ W[:G])).reshape(-1, self.size)
        return A.T @ A + B.T @ B, moved

    def acceleration(self, t, u, rate):
        """Return d2u/dt2 (G n,)."""
        G, S = len(self.grid.nodes), self.S
        M, (R, tangent, W, V) = self.matrix(u)
        w = W @ rate
        spinning = np.cross(w[:G], np.einsum("gab,gb->ga", R, self._full(rate)))
        turning = S @ spinning  # of stations, for no d2u/dt2
        a = S @ (np.cross(turning[:G], tangent) + np.cross(w[:G], np.cross(w[:G], tangent)))
        force = self.mass[:, None] * (self.gravity - a[: G + 1])
        own, own_turning = np.einsum("gba,gb->ga", R, w[:G]), np.einsum("gba,gb->ga", R, turning[:G])
        gyro = self.inertia * own_turning + np.cross(own, self.inertia * own)
        Q = np.einsum("xan,xa->n", V[: G + 1], force)
        Q -= np.einsum("gan,ga->n", W[:G], np.einsum("gab,gb->ga", R, gyro))
        share = np.reshape(self.course(t), (-1, 1))
        if len(self.force) and share.any():
            Q += np.einsum("xan,xa->n", V[G + 1 :], share * self.force)
            Q += np.einsum("xan,xa->n", W[G + 1 :], share * self.couple)
        Q -= self.K * (u + self.arm.damping_time * rate)
        return np.linalg.solve(M, Q)

    def energy(self, u, rate):
        """Return the kinetic and elastic energy and that of weight [J]."""
        M, (_, tangent, *_) = self.matrix(u)
        height = (self.S @ tangent)[: len(self.grid.nodes) + 1]
        return 0.5 * rate @ M @ rate + 0.5 * u @ (self.K * u) - self.mass @ height @ self.gravity

    def frequencies(self, u, count):
        """Return the lowest natural frequencies [Hz] about an equilibrium without gravity and payload's weight."""
        squares = eigh(np.diag(self.K), self.matrix(u)[0], eigvals_only=True, subset_by_index=[0, count - 1])
        return np.sqrt(squares) / (2 * np.pi)

    @threadpool_limits.wrap(limits=1, user_api="blas")
    def swing(self, u, time, xi=(1.0,), rtol=1e-6, rate=None):
        """Return the motion from a curvature u (G, 3), at rest unless at `rate`, sampled at `time`."""
        start = np.concatenate([u[:, : self.n].ravel(), np.zeros(self.size) if rate is None else rate])

        def slope(t, y):
            return np.concatenate([y[self.size :], self.acceleration(t, y[: self.size], y[self.size :])])

        def stiff(t, y):  # what makes the equation stiff; enough for Newton
            rates = np.linalg.solve(self.matrix(y[: self.size])[0], np.diag(self.K))
            return np.block([[np.zeros_like(rates), np.eye(self.size)], [-rates, -self.arm.damping_time * rates]])

        found = solve_ivp(slope, (time[0], time[-1]), start, "Radau", t_eval=time, rtol=rtol, atol=rtol, jac=stiff)
        assert found.success, found.message
        S = self.grid.integrals(np.asarray(xi) * self.arm.length)
        points, turns, energy = [], [], []
        for y in found.y.T:
            full = self._full(y[: self.size])
            R = self.grid.rotations(full)
            points.append(S @ R[:, :, 2])
            turns.append(np.eye(3) + np.tensordot(S, R @ hat(full), 1))
            energy.append(self.energy(y[: self.size], y[self.size :]))
        state = found.y.T.reshape(len(time), 2, -1, self.n)
        return Motion(found.t, np.array(points), np.array(turns), np.array(energy), state)


def released(arm, wrenches, time, xi=(1.0,), panels=2, order=8, course=None, rtol=1e-6):
    """Return the motion of a rod held by wrenches (xi, force, moment) until time zero."""
    held = parallel_rod(arm, wrenches=wrenches, panels=panels, order=order)
    return SwingingRod(arm, held.grid, wrenches, course).swing(held.curvature, time, xi, rtol)


def straight(arm, panels=1, order=12):
    """Return the rod's equations on a grid of its own, for frequencies about the straight pose."""
    return SwingingRod(arm, Grid(np.linspace(0, arm.length, panels + 1), order))
