"""The rates and conditions of `rod_sections`, on pieces of the rod between places of load, for scipy's `solve_bvp`.

Pieces are stacked, each mapped to [0, 1]. Lengths are counted in the rod's, moments in EI/L of the first section.
"""

import numpy as np
from scipy.integrate import solve_bvp

E3 = np.array([0.0, 0.0, 1.0])

TOLERANCE = 1e-6
"""Of the last solution, relative residual of the rates; tips are then right to some 1e-8 of length."""

STEP = 1e-7
"""Of differences, beside 1 or the state."""


class Pieces:
    """An arm and its loads. States: 13 of each piece (p, quaternion, N, then u or u1, u2, m3), and a length a muscle.

    Attributes:
        length, force, moment: what lengths [m], forces [N] and moments [N m] are counted in.
        edges, spans, count: where pieces begin and end, how long they are, how many.
        section: that each piece belongs to.
    """

    def __init__(self, arm, tensions, pressures, wrenches, actuation_moment, follower_moment):
        sections = arm.sections
        ends = np.cumsum([0.0, *(section.length for section in sections)])
        self.length, self.moment = ends[-1], sections[0].bending_stiffness / ends[-1]
        self.force, ends = self.moment / self.length, ends / ends[-1]
        gravity = np.array(arm.gravity) / self.force
        loads = [(1.0, arm.payload * gravity, np.zeros(3))]
        loads += [(xi, np.array(F) / self.force, np.array(M) / self.moment) for xi, F, M in wrenches]
        self.edges = np.unique(np.round([*ends, *(xi for xi, *_ in loads)], 12))
        self.spans, self.count = np.diff(self.edges), len(self.edges) - 1
        self.section = np.searchsorted(ends, 0.5 * (self.edges[1:] + self.edges[:-1])) - 1
        own = [sections[number] for number in self.section]
        scale = self.moment * self.length
        self.rigid = np.array([section.torsional_stiffness is None for section in own])
        self.K = (
            np.array([[s.bending_stiffness, s.bending_stiffness, s.torsional_stiffness or 0.0] for s in own]) / scale
        )
        self.weight = np.array([s.mass / s.length * self.length * gravity for s in own])
        self.loads = np.zeros((2, self.count, 3))  # at the end of each piece
        for xi, F, M in loads:
            at = np.argmin(np.abs(self.edges[1:] - xi))
            self.loads[:, at] += F, M
        self.actuation = np.array([*actuation_moment, 0.0]) / self.moment
        self.follower = np.array(follower_moment) / self.moment
        self._add_muscles(arm, ends)
        self.tensions = np.zeros(len(self.r)) if tensions is None else np.asarray(tensions) / self.force
        self.pressures = None if pressures is None else np.asarray(pressures, dtype=float)

    def _add_muscles(self, arm, ends):
        r, through, self.laws = [], [], []
        for number, line in enumerate(arm.routings):
            first = 0 if line.start == "base" else number
            rest = (ends[number + 1] - ends[first]) / (1 - arm.laws[number].mount_contraction)
            for index in range(line.count):
                angle = line.offset + 2 * np.pi * index / line.count
                r.append([line.radius * np.cos(angle), line.radius * np.sin(angle), 0.0])
                through.append((first <= self.section) & (self.section <= number))
                self.laws.append((arm.laws[number], rest))
        self.r = np.array(r).reshape(-1, 3) / self.length
        self.through = np.array(through, dtype=float).reshape(-1, self.count).T

    def split(self, y):
        """Return p, q, n, w of every piece, (pieces, nodes, 3 or 4)."""
        states = y[: 13 * self.count].reshape(self.count, 13, -1).swapaxes(1, 2)
        return np.split(states, [3, 7, 10], axis=-1)

    def straight(self, x):
        """Return the states of the straight rod without loads."""
        y = np.zeros((13 * self.count + len(self.r), len(x)))
        y[2 : 13 * self.count : 13] = self.edges[:-1, None] + self.spans[:, None] * x
        y[3 : 13 * self.count : 13] = 1.0
        y[13 * self.count :] = (self.spans @ self.through)[:, None] * x
        return y

    def bent(self, w, share):
        """Return curvature and moment, in the rod's axes."""
        rigid, third = self.rigid[:, None, None], np.array([False, False, True])
        u = np.where(rigid & third, 0.0, w)
        return u, self.K[:, None] * u + np.where(rigid & third, w, 0.0) - share * self.actuation

    def paths(self, u):
        """Return the muscles' rates of length, (pieces, nodes, muscles, 1), and tangents, in the rod's axes."""
        v = E3 + np.cross(u[:, :, None], self.r)
        rate = np.linalg.norm(v, axis=-1, keepdims=True)
        return rate, v / rate

    def pulls(self, y, share):
        """Return the tensions at a share of the drive, given or by the muscles' lengths."""
        if self.pressures is None:
            return share * self.tensions
        lengths = zip(self.laws, share * self.pressures, y[13 * self.count :, -1], strict=True)
        return np.array([mckibben(law, P, length / rest) for (law, rest), P, length in lengths]) / self.force

    def across(self, R, w, T, share=1.0):
        """Return the moment that rod and muscles carry together, base frame."""
        u, m = self.bent(w, share)
        pull = (self.through * T)[:, None, :, None] * self.paths(u)[1]
        return np.einsum("kxab,kxb->kxa", R, m + np.cross(self.r, pull).sum(axis=2))

    def rates(self, y, T, share):
        """Return the rates of all states by x, of shape (states, nodes)."""
        states, lengths = self._parts(y, T, share)
        return np.concatenate([states.swapaxes(1, 2).reshape(13 * self.count, -1), lengths.sum(axis=0).T])

    def slopes(self, y, T, share, by_tension):
        """Return what rates change by states (states, states, nodes) and by tensions, in differences.

        Pieces do not see each other's states: the same state of all is changed at once.
        """
        size, muscles, (states, lengths) = 13 * self.count, len(self.r), self._parts(y, T, share)
        by_state = np.zeros((size + muscles, size + muscles, y.shape[1]))
        by_pull = np.zeros((size + muscles, muscles, y.shape[1]))
        piece = np.arange(self.count)
        for number in range(3, 13):
            changed = y.copy()
            changed[number:size:13] += STEP * (1 + np.abs(y[number:size:13]))
            steps = (changed - y)[number:size:13]
            more, longer = self._parts(changed, T, share)
            block = ((more - states) / steps[..., None]).swapaxes(1, 2)
            for row in range(13):
                by_state[13 * piece + row, 13 * piece + number] = block[:, row]
            by_state[size:, number:size:13] = ((longer - lengths) / steps[..., None]).transpose(2, 0, 1)
        for number in range(muscles if by_tension else 0):
            pull = T.copy()
            pull[number] += STEP * (1 + abs(T[number]))
            more, _ = self._parts(y, pull, share)
            by_pull[:size, number] = ((more - states) / (pull - T)[number]).swapaxes(1, 2).reshape(size, -1)
        return by_state, by_pull

    def _parts(self, y, T, share):
        """Return rates of the pieces' states, (pieces, nodes, 13), and what each adds to those of lengths."""
        _, q, n, w = self.split(y)
        R, (u, m) = rotations(q), self.bent(w, share)
        rate, t = self.paths(u)
        pull, D = (self.through * T)[:, None, :, None], -hat(self.r)  # u' x r = D u'
        carried = np.einsum("kxba,kxb->kxa", R, n) - (pull * t).sum(axis=2)  # by the rod alone
        pull = pull / rate
        turned = rate * np.cross(u[:, :, None], t)  # of p'' of a path, what u does; u' does D u'
        known = pull * (turned - t * (t * turned).sum(-1, keepdims=True))
        by_change = pull[..., None] * (D - t[..., None] * np.einsum("kxia,iab->kxib", t, D)[..., None, :])
        H = np.einsum("iab,kxibc->kxac", -D, by_change)
        H[..., range(3), range(3)] += self.K[:, None]
        H[self.rigid, :, :, 2] = E3  # no change of twist, but of m3
        left = np.cross(u, m) + np.cross(E3, carried) + np.cross(self.r, known).sum(axis=2)
        change = -np.linalg.solve(H, left[..., None])[..., 0]
        dn = np.broadcast_to(-share * self.weight[:, None], n.shape)
        dq = 0.5 * np.concatenate(
            [-(q[..., 1:] * u).sum(-1, keepdims=True), q[..., :1] * u + np.cross(q[..., 1:], u)], axis=-1
        )
        states = np.concatenate([R[..., 2], dq, dn, change], axis=-1) * self.spans[:, None, None]
        return states, (self.spans[:, None] * self.through)[:, None] * rate[..., 0]

    def conditions(self, ya, yb, T, share):
        first, last = self.split(ya), self.split(yb)
        out = [first[0][0, 0], first[1][0, 0] - [1, 0, 0, 0]]
        out += [(last[i][:-1] - first[i][1:]).ravel() for i in (0, 1)]
        moment, beyond = (self.across(rotations(end[1]), end[3], T, share) for end in (last, first))
        couple = share * self.loads[1]
        couple[-1] += share * rotations(last[1])[-1, 0] @ self.follower
        out.append((last[2][:, 0] - share * self.loads[0] - np.vstack([first[2][1:, 0], np.zeros(3)])).ravel())
        out.append((moment[:, 0] - couple - np.vstack([beyond[1:, 0], np.zeros(3)])).ravel())
        out.append(ya[13 * self.count :])
        if self.pressures is not None:
            out.append(T - self.pulls(yb[:, None], share))
        return np.concatenate(out)

    def solve(self, x, y, T, share):
        """Return what `solve_bvp` finds at a share of the loads, from a guess of states and tensions."""
        options = {"tol": TOLERANCE, "max_nodes": 500} if share == 1 else {"tol": 1e-2, "max_nodes": 50}
        if self.pressures is None:
            return solve_bvp(
                lambda x, y: self.rates(y, T, share), lambda a, b: self.conditions(a, b, T, share), x, y,
                fun_jac=lambda x, y: self.slopes(y, T, share, False)[0], **options,
            )  # fmt: skip
        return solve_bvp(
            lambda x, y, T: self.rates(y, T, share), lambda a, b, T: self.conditions(a, b, T, share), x, y, p=T,
            fun_jac=lambda x, y, T: self.slopes(y, T, share, True), **options,
        )  # fmt: skip

    def bends(self, solution):
        """Return the integral of the magnitude of bending over each section [rad]."""
        x, weights = np.polynomial.legendre.leggauss(20)
        w = self.split(solution(0.5 * (1 + x)))[3]
        return np.bincount(self.section, 0.5 * self.spans * (np.hypot(w[..., 0], w[..., 1]) @ weights))


def mckibben(law, pressure, stretch):
    """Return the force [N] of a muscle stretched to a share of its rest length; pulling only."""
    cosine = 1 / (np.sqrt(3) * (1 - law.max_contraction))
    area = np.pi * (law.inner_diameter + 2 * law.wall) ** 2 / 4
    return pressure * area * np.maximum(3 * (stretch * cosine) ** 2 - 1, 0.0) / (1 - cosine**2)


def rotations(q):
    """Return rotation matrices (..., 3, 3) of quaternions (..., 4), w first, of any length."""
    w, v = q[..., :1, None], q[..., 1:]
    outer, square = v[..., :, None] * v[..., None, :], (v * v).sum(-1)[..., None, None]
    return ((w * w - square) * np.eye(3) + 2 * outer + 2 * w * hat(v)) / (w * w + square)


def hat(v):
    x, y, z = np.moveaxis(v, -1, 0)
    o = np.zeros_like(x)
    return np.moveaxis(np.array([[o, -z, y], [z, o, -x], [-y, x, o]]), (0, 1), (-2, -1))
