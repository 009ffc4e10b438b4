"""The ideal rod, solved without a link or a joint: the truth that the simulated arm is measured against.

A clamped Kirchhoff rod, inextensible and unshearable, of curvature u(s) in its own axes (x, y, twist):

    R' = R [u]x,  p' = R e3,  K u + m(u) = R^T M + a,  K = diag(EI, EI, GJ); GJ None: u3 = 0
    M(s) = sum of couples beyond s + sum of (point of attack - p(s)) x force beyond s

with m the moment of the muscles and a the uniform material moment. Muscles come in two routings:

- `parallel_rod`: sheathed along the backbone at r_i, frictionless (Rucker and Webster 2011). Each has the length
  L_i = int l_i ds, l_i = |e3 + u x r_i| = sqrt((1 - r kappa_i)^2 + (r u3)^2), and m = sum T_i dl_i/du;
- `spans_rod`: straight between disks at s = k L/N, through frictionless holes at r_i. Each disk feels the forces of the
  spans on both sides in its holes: point forces in M, and m = 0.

Tensions are given, or pressures: F = P (pi D0^2/4) (3 (1 - eps)^2/tan^2 a0 - 1/sin^2 a0) >= 0, eps = 1 - L/L_rest.

Gauss collocation: u is a polynomial on each panel, every integral a matrix, the equation holds at the nodes. Newton
with the exact tangent, loads and drives raised together from none. Shares nothing with the package but parameters.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from threadpoolctl import threadpool_limits

ANGLES = np.radians([0.0, 120.0, 240.0])


class NoEquilibriumError(Exception):
    """Raising the loads from none met a pose that is unstable, or none."""


@dataclass(frozen=True)
class Rod:
    """An equilibrium: base frame, SI units.

    Attributes:
        tip, R: position of the tip and its orientation, base from tip.
        lengths, tensions: of the muscles.
        compliance: displacement, rotation of the tip by a small dead force, couple there, drives constant, (6, 6).
        margin: least eigenvalue of the tangent [N m^2]; 0 at a fold or a bifurcation. Flutter is not looked for.
        curvature: u at the nodes, a guess for a neighbour.
    """

    tip: np.ndarray
    R: np.ndarray
    lengths: np.ndarray
    tensions: np.ndarray
    compliance: np.ndarray
    margin: float
    curvature: np.ndarray
    grid: "_Grid"

    def at(self, xi):
        """Return points (X, 3) and orientations (X, 3, 3) at normalised arc lengths xi."""
        R, _ = self.grid.rotations(self.curvature)
        S = self.grid.integrals(np.atleast_1d(xi) * self.grid.edges[-1])
        return S @ R[:, :, 2], np.eye(3) + np.tensordot(S, R @ _hat(self.curvature), 1)


@threadpool_limits.wrap(limits=1, user_api="blas")
def parallel_rod(arm, **drive_and_loads):
    """Return the equilibrium of the rod with sheathed muscles; see `_solve` for the arguments."""
    return _solve(arm, None, **drive_and_loads)


@threadpool_limits.wrap(limits=1, user_api="blas")
def spans_rod(arm, disks=None, **drive_and_loads):
    """Return the equilibrium of the rod with straight spans between N = `disks` (default: links) equal intervals."""
    return _solve(arm, disks or arm.links, **drive_and_loads)


def tension(pressure, length, arm):
    """Return force [N] and slope dF/dL [N/m] of a McKibben muscle, pulling only."""
    muscle, rest = arm.muscle, arm.length / (1 - arm.muscle.mount_contraction)
    cosine = 1 / (np.sqrt(3) * (1 - muscle.max_contraction))
    area, stretch = np.pi * (muscle.inner_diameter + 2 * muscle.wall) ** 2 / 4, length / rest
    force = pressure * area * (3 * stretch**2 * cosine**2 - 1) / (1 - cosine**2)
    slope = pressure * area * 6 * stretch * cosine**2 / (1 - cosine**2) / rest
    return np.maximum(force, 0.0), np.where(force > 0, slope, 0.0)


def _solve(
    arm, disks, *, tensions=None, pressures=None, force=(0, 0, 0), moment=(0, 0, 0), wrenches=(),
    follower_moment=(0, 0, 0), actuation_moment=(0, 0), guess=None, steps=4, panels=8, order=6,
):  # fmt: skip
    """Raise everything from none in `steps` (halved where Newton fails), or start from the curvature `guess`.

    Args:
        arm: length, mass, bending and torsional stiffness, muscle_radius, gravity, payload and muscle are read.
        tensions, pressures: one of them [N], [Pa], or neither.
        force, moment: dead, at the tip; wrenches: more of them, as (xi, force, moment).
        follower_moment: at the tip, in its axes; actuation_moment: about the material x and y axes, uniform.
        panels, order: least number of panels, and nodes in each.
    """
    dead = ((1.0, np.add(force, arm.payload * np.array(arm.gravity)), moment), *wrenches)
    stations = [np.arange(disks + 1) / disks if disks else [], [xi for xi, *_ in wrenches]]
    breaks = tuple(np.unique(np.round(np.concatenate([np.linspace(0, 1, panels + 1), *stations]), 12)))
    grid = _grid(breaks, arm.length, order if len(breaks) < 20 else 4)
    system = _System(arm, grid, disks, tensions, pressures, dead, follower_moment, actuation_moment)
    u, done, step = np.zeros((len(grid.nodes), 3)), 0.0, 1 / steps
    if guess is not None:
        u, step = guess, 1.0
    while done < 1:
        scale = min(done + step, 1.0)
        found = system.newton(u, scale)
        if found is None or (margin := np.linalg.eigvals(found["tangent"]).real.min()) <= 0:
            step /= 2
            if step < 1e-3:
                raise NoEquilibriumError(f"at {100 * done:.1f} % of the loads")
            continue
        u, done = found["u"], scale
    return system.result(found, margin)


def _hat(v):
    """Return [v]x of vectors (..., 3)."""
    x, y, z = np.moveaxis(v, -1, 0)
    o = np.zeros_like(x)
    return np.moveaxis(np.array([[o, -z, y], [z, o, -x], [-y, x, o]]), (0, 1), (-2, -1))


def _cross(a, v):
    """Return the columns of a (X, 3, n) crossed with v (X, 3)."""
    return -_hat(v) @ a


class _Grid:
    """Gauss nodes on panels, and the matrices that integrate the polynomials through values at the nodes."""

    def __init__(self, edges, order):
        self.edges, self.order = np.array(edges), order
        x, w = np.polynomial.legendre.leggauss(order)
        half, self.basis = np.diff(self.edges) / 2, np.linalg.inv(np.polynomial.legendre.legvander(x, order - 1))
        self.nodes = (self.edges[:-1, None] + half[:, None] * (1 + x)).ravel()
        self.weights = (half[:, None] * w).ravel()
        self.S = self.integrals(self.nodes)

    def integrals(self, s):
        """Return the matrix of the integrals from 0 to stations s (X,): (X, G)."""
        panel = np.clip(np.searchsorted(self.edges, s, side="right") - 1, 0, len(self.edges) - 2)
        half = np.diff(self.edges)[panel] / 2
        x = (s - self.edges[panel]) / half - 1
        upto = np.polynomial.legendre.legint(np.eye(self.order), lbnd=-1)
        own = half[:, None] * np.polynomial.legendre.legval(x, upto).T @ self.basis
        S = np.where(np.arange(len(self.nodes)) < self.order * panel[:, None], self.weights, 0.0)
        np.put_along_axis(S, self.order * panel[:, None] + np.arange(self.order), own, axis=1)
        return S

    def rotations(self, u):
        """Return R (G, 3, 3) at the nodes from R' = R [u]x, and at the end."""
        G, hat = len(self.nodes), _hat(u)
        matrix = np.eye(3 * G) - np.einsum("gj,jab->gbja", self.S, hat).reshape(3 * G, 3 * G)
        R = np.linalg.solve(matrix, np.tile(np.eye(3), (G, 1))).reshape(G, 3, 3).swapaxes(1, 2)
        return R, np.eye(3) + np.tensordot(self.weights, R @ hat, 1)


@lru_cache(maxsize=64)
def _grid(breaks, length, order):
    return _Grid(np.array(breaks) * length, order)


class _System:
    """Residual and tangent of the rod's equation at the nodes."""

    def __init__(self, arm, grid, disks, tensions, pressures, dead, follower_moment, actuation_moment):
        self.arm, self.grid, self.disks, self.tensions, self.pressures = arm, grid, disks, tensions, pressures
        self.n = 2 if arm.torsional_stiffness is None else 3
        self.K = np.array([arm.bending_stiffness, arm.bending_stiffness, arm.torsional_stiffness or 0.0])
        self.actuation = np.array([*actuation_moment, 0.0])
        self.follower = np.array(follower_moment, dtype=float)
        self.r = arm.muscle_radius * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES], axis=1)
        holes = np.repeat(np.arange(disks + 1) / disks, 3) if disks else np.zeros(0)
        G, self.W = len(grid.nodes), len(dead)
        points = np.concatenate([[xi for xi, *_ in dead], holes]) * grid.edges[-1]
        self.S = np.vstack([grid.S, grid.integrals(points)])
        beyond = points > grid.nodes[:, None]
        self.E = np.hstack([grid.weights - grid.S, beyond])  # what of a station's load is beyond a node
        self.offset = np.concatenate([np.zeros((G + self.W, 3)), np.tile(self.r, (len(holes) // 3, 1))])
        self.force, self.couple = np.zeros((2, len(self.S), 3))
        self.force[:G] = arm.mass / arm.length * np.array(arm.gravity)
        self.force[G : G + self.W] = [force for _, force, _ in dead]
        self.couple[G : G + self.W] = [moment for *_, moment in dead]

    def drive(self, lengths, scale):
        if self.pressures is not None:
            return tension(scale * np.asarray(self.pressures), lengths, self.arm)
        return scale * np.asarray((0, 0, 0) if self.tensions is None else self.tensions, dtype=float), np.zeros(3)

    def newton(self, u, scale):
        """Return the converged state at a share of the loads, None where there is none near."""
        for _ in range(15):
            state = self.state(u, scale)
            change = np.zeros_like(u)
            change[:, : self.n] = -np.linalg.solve(state["tangent"], state["residual"]).reshape(-1, self.n)
            size = np.abs(change).max() * self.arm.length
            if not size < 3:
                return None
            u = u + change
            if size < 1e-9:
                return self.state(u, scale)
        return None

    def state(self, u, scale):
        grid, n, G = self.grid, self.n, len(self.grid.nodes)
        R, _ = grid.rotations(u)
        t = R[:, :, 2]
        turns = np.eye(3) + np.tensordot(self.S, R @ _hat(u), 1)
        arms = np.einsum("xab,xb->xa", turns, self.offset)
        p = self.S @ t
        spin = np.einsum("xj,jac->xajc", self.S, R[:, :, :n]).reshape(-1, 3, G * n)  # rotation of a station by du
        move = np.tensordot(self.S, _cross(spin[:G], t), 1)  # displacement of a station by du
        a, da = p + arms, move + _cross(spin, arms)
        f, df, c, dc = scale * self.force, np.zeros_like(da), scale * self.couple, np.zeros_like(da)
        follower = scale * turns[G] @ self.follower
        c[G] += follower
        dc[G] += _cross(spin[G : G + 1], follower[None])[0]
        m, dm = self.K * u, np.zeros((G, 3, G, n))
        dm[np.arange(G), :, np.arange(G)] = np.diag(self.K)[:, :n]
        if self.disks:
            first = G + self.W
            lengths, T = self._spans(a[first:], da[first:], scale, f[first:], df[first:])
        else:
            lengths, T = self._sheathed(u, scale, m, dm)
        c, dc = c + np.cross(a, f), dc + _cross(da, f) - _cross(df, a)
        F, M = self.E @ f, self.E @ c
        M = M - np.cross(p[:G], F)
        dM = np.tensordot(self.E, dc, 1) - _cross(move[:G], F) + _cross(np.tensordot(self.E, df, 1), p[:G])
        residual = m - np.einsum("gab,ga->gb", R, M) - scale * self.actuation
        tangent = dm.reshape(G, 3, G * n) - R.swapaxes(1, 2) @ (dM - _cross(spin[:G], M))
        return {
            "u": u, "residual": residual[:, :n].ravel(), "tangent": tangent[:, :n].reshape(G * n, G * n), "R": R,
            "turn": turns[G], "p": p, "spin": spin[G], "move": move[G], "lengths": lengths, "tensions": T,
        }  # fmt: skip

    def _sheathed(self, u, scale, m, dm):
        """Add the moment of sheathed muscles to m, its change to dm; return lengths and tensions."""
        axis = np.stack([self.r[:, 1], -self.r[:, 0], 0 * ANGLES], axis=1)
        along, twist = 1 + u @ axis.T, self.arm.muscle_radius * u[:, 2:]
        element = np.hypot(along, twist)
        across = self.arm.muscle_radius * np.array([0.0, 0.0, 1.0])
        grad = (along[..., None] * axis + twist[..., None] * across) / element[..., None]  # dl_i/du, (G, 3, 3)
        lengths = self.grid.weights @ element
        T, slope = self.drive(lengths, scale)
        m += np.einsum("i,gia->ga", T, grad)
        second = np.einsum("ia,ib->iab", axis, axis) + np.outer(across, across)
        second = (second - np.einsum("gia,gib->giab", grad, grad)) / element[..., None, None]
        node = np.arange(len(u))
        dm[node, :, node] += np.einsum("i,giab->gab", T, second)[..., : self.n]
        dm += np.einsum("i,gia,j,jib->gajb", slope, grad, self.grid.weights, grad)[..., : self.n]
        return lengths, T

    def _spans(self, a, da, scale, f, df):
        """Write the forces on the holes into f, their change into df; return lengths and tensions."""
        a, da = a.reshape(-1, 3, 3), da.reshape(-1, 3, 3, da.shape[-1])
        d, dd = np.diff(a, axis=0), np.diff(da, axis=0)
        span = np.linalg.norm(d, axis=-1, keepdims=True)
        d = d / span
        stretch = np.einsum("kia,kian->kin", d, dd)
        T, slope = self.drive(span.sum(axis=(0, 2)), scale)
        pull = T[:, None] * d
        dpull = T[:, None, None] * (dd - d[..., None] * stretch[:, :, None]) / span[..., None]
        dpull += d[..., None] * (slope[:, None] * stretch.sum(axis=0))[:, None]
        for forces, pulls in ((f.reshape(a.shape), pull), (df.reshape(da.shape), dpull)):
            forces[:-1] += pulls
            forces[1:] -= pulls
        return span.sum(axis=(0, 2)), T

    def result(self, found, margin):
        G = len(self.grid.nodes)
        lever = found["p"][G] - found["p"][:G]
        probe = np.concatenate([_hat(lever), np.tile(np.eye(3), (G, 1, 1))], axis=2)
        moments = (found["R"].swapaxes(1, 2) @ probe)[:, : self.n].reshape(-1, 6)
        bent = np.linalg.solve(found["tangent"], moments)
        compliance = np.concatenate([found["move"] @ bent, found["spin"] @ bent])
        tip, R = found["p"][G], found["turn"]
        return Rod(tip, R, found["lengths"], found["tensions"], compliance, float(margin), found["u"], self.grid)
