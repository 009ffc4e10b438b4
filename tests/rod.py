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

import numpy as np
from collocation import Grid, cross, grid_of, hat
from threadpoolctl import threadpool_limits

ANGLES = np.radians([0.0, 120.0, 240.0])

HOLDING = 1e10
"""Stiffness that stands for a held length [N/m]: 50 N stretch it by 5e-9 m."""


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
    grid: Grid

    @threadpool_limits.wrap(limits=1, user_api="blas")
    def at(self, xi):
        """Return points (X, 3) and orientations (X, 3, 3) at normalised arc lengths xi."""
        R = self.grid.rotations(self.curvature)
        S = self.grid.integrals(np.atleast_1d(xi) * self.grid.edges[-1])
        return S @ R[:, :, 2], np.eye(3) + np.tensordot(S, R @ hat(self.curvature), 1)


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


def _drive(arm, tensions, pressures, lengths):
    """Return the law of the muscles: (lengths, share of the drive) -> tensions and slopes dT/dL."""
    if pressures is not None:
        return lambda L, share: tension(share * np.asarray(pressures), L, arm)
    if lengths is not None:
        held = np.asarray(lengths) - arm.length
        return lambda L, share: (HOLDING * (L - arm.length - share * held), np.full(3, HOLDING))
    given = np.zeros(3) if tensions is None else np.asarray(tensions, dtype=float)
    return lambda L, share: (share * given, np.zeros(3))


def _solve(
    arm, disks, *, tensions=None, pressures=None, lengths=None, force=(0, 0, 0), moment=(0, 0, 0), wrenches=(),
    follower_moment=(0, 0, 0), actuation_moment=(0, 0), guess=None, steps=4, panels=8, order=None,
):  # fmt: skip
    """Raise everything from none in `steps` (halved where Newton fails), or start from the curvature `guess`.

    Args:
        arm: length, mass, bending and torsional stiffness, muscle_radius, gravity, payload and muscle are read.
        tensions, pressures, lengths: one of them [N], [Pa], [m], or none. Lengths are held, pushing if need be: of
            sheathed muscles alone, which on an untwistable rod add up to 3 L whatever their common tension.
        force, moment: dead, at the tip; wrenches: more of them, as (xi, force, moment).
        follower_moment: at the tip, in its axes; actuation_moment: about the material x and y axes, uniform.
        panels, order: least number of panels, and nodes in each (6, or 4 on many).
    """
    if disks and lengths is not None:
        raise ValueError("the sum of the lengths of straight spans is no drive: it hardly moves")
    dead = ((1.0, np.add(force, arm.payload * np.array(arm.gravity)), moment), *wrenches)
    stations = [np.arange(disks + 1) / disks if disks else [], [xi for xi, *_ in wrenches]]
    breaks = tuple(np.unique(np.round(np.concatenate([np.linspace(0, 1, panels + 1), *stations]), 12)))
    grid = grid_of(breaks, arm.length, order or (6 if len(breaks) < 20 else 4))
    drive = _drive(arm, tensions, pressures, lengths)
    return raised(System(arm, grid, disks, drive, dead, follower_moment, actuation_moment), guess, steps)


def raised(system, guess=None, steps=4):
    """Return the equilibrium of a system, everything raised from none in `steps`, or from a `guess` at once."""
    u, done, step = np.zeros((len(system.grid.nodes), 3)), 0.0, 1 / steps
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


class System:
    """Residual and tangent of the rod's equation at the nodes."""

    def __init__(self, arm, grid, disks, drive, dead, follower_moment, actuation_moment):
        self.arm, self.grid, self.disks, self.drive = arm, grid, disks, drive
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
        R = grid.rotations(u)
        t = R[:, :, 2]
        turns = np.eye(3) + np.tensordot(self.S, R @ hat(u), 1)
        arms = np.einsum("xab,xb->xa", turns, self.offset)
        p = self.S @ t
        spin = np.einsum("xj,jac->xajc", self.S, R[:, :, :n]).reshape(-1, 3, G * n)  # rotation of a station by du
        move = np.tensordot(self.S, cross(spin[:G], t), 1)  # displacement of a station by du
        a, da = p + arms, move + cross(spin, arms)
        f, df, c, dc = scale * self.force, np.zeros_like(da), scale * self.couple, np.zeros_like(da)
        follower = scale * turns[G] @ self.follower
        c[G] += follower
        dc[G] += cross(spin[G : G + 1], follower[None])[0]
        m, dm = self.K * u, np.zeros((G, 3, G, n))
        dm[np.arange(G), :, np.arange(G)] = self.K[..., None] * np.eye(3)[:, :n]
        if self.disks:
            first = G + self.W
            lengths, T = self._spans(a[first:], da[first:], scale, f[first:], df[first:])
        else:
            lengths, T = self._sheathed(u, scale, m, dm)
        c, dc = c + np.cross(a, f), dc + cross(da, f) - cross(df, a)
        F, M = self.E @ f, self.E @ c
        M = M - np.cross(p[:G], F)
        dM = np.tensordot(self.E, dc, 1) - cross(move[:G], F) + cross(np.tensordot(self.E, df, 1), p[:G])
        residual = m - np.einsum("gab,ga->gb", R, M) - scale * self.actuation
        tangent = dm.reshape(G, 3, G * n) - R.swapaxes(1, 2) @ (dM - cross(spin[:G], M))
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
        probe = np.concatenate([hat(lever), np.tile(np.eye(3), (G, 1, 1))], axis=2)
        moments = (found["R"].swapaxes(1, 2) @ probe)[:, : self.n].reshape(-1, 6)
        bent = np.linalg.solve(found["tangent"], moments)
        compliance = np.concatenate([found["move"] @ bent, found["spin"] @ bent])
        tip, R = found["p"][G], found["turn"]
        return Rod(tip, R, found["lengths"], found["tensions"], compliance, float(margin), found["u"], self.grid)
