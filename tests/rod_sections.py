"""The ideal rod of several sections, as a boundary value problem: the truth that arms of sections are measured against.

A clamped Kirchhoff rod, inextensible and unshearable, of curvature u(s) in its own axes, K = diag(EI, EI, GJ), with
muscles sheathed at r_i without friction, each a load on the rod (Rucker and Webster 2011, Till, Aloi and Rucker 2019):

    p' = R e3,  R' = R [u]x,  n' + f + sum T_i t_i' = 0,  (R m)' + R e3 x n + sum R r_i x T_i t_i' = 0,  m = K u - a

t_i is the unit tangent of p + R r_i, f the weight, a the uniform material moment. Where GJ is None, u3 = 0, and m3 is
what keeps it so. Where sections or loads begin and end, each muscle pulls at the rod with -T_i t_i just before and with
T_i t_i just after, if it is there. Solved for N = n + sum T_i t_i, for then N' = -f: n and tensions nearly cancel.
Tensions are given, or follow from pressures by the muscles' lengths, as unknowns.

scipy's `solve_bvp`, see `rod_pieces`. Of the package it shares the parameters alone; with `rod` nothing at all.
"""

from dataclasses import dataclass

import numpy as np
from rod_pieces import Pieces, rotations


class NoEquilibriumError(Exception):
    """Raising the loads from none met a pose that `solve_bvp` could not go on from."""


@dataclass(frozen=True)
class Rod:
    """An equilibrium: base frame, SI units.

    Attributes:
        lengths, tensions: of the muscles [m], [N], section by section.
        bends: integral of the magnitude of bending over each section [rad].
    """

    lengths: np.ndarray
    tensions: np.ndarray
    bends: np.ndarray
    pieces: Pieces
    solution: object

    def at(self, s):
        """Return points (X, 3) [m] and orientations (X, 3, 3) at arc lengths s [m]."""
        pieces, s = self.pieces, np.atleast_1d(s) / self.pieces.length
        piece = np.clip(np.searchsorted(pieces.edges, s, side="right") - 1, 0, pieces.count - 1)
        x = np.clip((s - pieces.edges[piece]) / pieces.spans[piece], 0.0, 1.0)
        p, q, *_ = pieces.split(self.solution(x))
        every = np.arange(len(s))
        return pieces.length * p[piece, every], rotations(q)[piece, every]

    def moments(self, s):
        """Return force [N] and moment [N m] across the rod and the muscles, base frame, (X, 3) each, within pieces."""
        pieces, s = self.pieces, np.atleast_1d(s) / self.pieces.length
        piece = np.clip(np.searchsorted(pieces.edges, s) - 1, 0, pieces.count - 1)
        y = self.solution((s - pieces.edges[piece]) / pieces.spans[piece])
        _, q, n, w = pieces.split(y)
        moment, every = pieces.across(rotations(q), w, self.tensions / pieces.force), np.arange(len(s))
        return pieces.force * n[piece, every], pieces.moment * moment[piece, every]


def rod(
    arm, *, tensions=None, pressures=None, wrenches=(), actuation_moment=(0, 0), follower_moment=(0, 0, 0), steps=3
):
    """Return the equilibrium, everything raised from none in `steps`, halved where no solution is found.

    Args:
        arm: sections, routings and laws, gravity and payload are read.
        tensions, pressures: of all muscles, section by section: one of them [N], [Pa], or none.
        wrenches: dead loads, as (xi, force, moment), xi above 0.
        actuation_moment, follower_moment: as of `contarm_sim.model.load.Load`.

    Raises:
        NoEquilibriumError: says how far it got.
    """
    pieces = Pieces(arm, tensions, pressures, wrenches, actuation_moment, follower_moment)
    x = np.linspace(0, 1, 7)
    y, done, step = pieces.straight(x), 0.0, 1 / steps
    while done < 1:
        share = done + step if done + step < 1 - 1e-9 else 1.0
        found = pieces.solve(x, y, pieces.pulls(y, share), share)
        if not found.success:
            step /= 2
            if step < 0.02:
                raise NoEquilibriumError(f"at {100 * done:.0f} % of the loads")
            continue
        x, y, done = found.x, found.y, share
    lengths, tensions = found.y[13 * pieces.count :, -1], pieces.tensions if pressures is None else found.p
    return Rod(pieces.length * lengths, pieces.force * tensions, pieces.bends(found.sol), pieces, found.sol)
