"""Gauss collocation on panels: functions are polynomials through their values at nodes, integrals are matrices."""

from functools import lru_cache

import numpy as np


def hat(v):
    """Return [v]x of vectors (..., 3)."""
    x, y, z = np.moveaxis(v, -1, 0)
    o = np.zeros_like(x)
    return np.moveaxis(np.array([[o, -z, y], [z, o, -x], [-y, x, o]]), (0, 1), (-2, -1))


def cross(a, v):
    """Return the columns of a (X, 3, n) crossed with v (X, 3)."""
    return -hat(v) @ a


class Grid:
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
        """Return R (G, 3, 3) at the nodes from R' = R [u]x, R = 1 at 0."""
        G, turn = len(self.nodes), hat(u)
        matrix = np.eye(3 * G) - np.einsum("gj,jab->gbja", self.S, turn).reshape(3 * G, 3 * G)
        return np.linalg.solve(matrix, np.tile(np.eye(3), (G, 1))).reshape(G, 3, 3).swapaxes(1, 2)


@lru_cache(maxsize=64)
def grid_of(breaks, length, order):
    """Return a grid on panels between breaks, as shares of a length; kept for the next call."""
    return Grid(np.array(breaks) * length, order)
