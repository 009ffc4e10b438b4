"""The one-parameter family of the poses of two sections that reach a tip position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone, as_bends
from contarm_sim.kinematics.inverse.checks import one_goal
from contarm_sim.kinematics.inverse.limits import angles_of, excess
from contarm_sim.kinematics.inverse.result import TOLERANCE, Index
from contarm_sim.kinematics.inverse.two.curve import ON_AXIS, bends_at, places, planar_ends
from contarm_sim.kinematics.inverse.two.equations import as_targets
from contarm_sim.kinematics.inverse.two.newton import polish
from contarm_sim.kinematics.inverse.two.pair import as_pair
from contarm_sim.kinematics.inverse.two.pieces import find

_NODES = 257  # samples of beta1
_CLOSE = 1e-9  # a parameter this far off a piece [rad] is within


@dataclass(frozen=True)
class Piece:
    """An interval of the first section's bend angle within which both mirror branches reach the target.

    Attributes:
        low, high: its ends [rad].
        low_end, high_end: how it ends: "planar", a planar pose where the branches meet, or "limit", a bend angle at its
            limit.
        circle: the target is on the axis: every azimuth solves, at one bend angle.
    """

    low: float
    high: float
    low_end: str
    high_end: str
    circle: bool = False

    @property
    def shape(self) -> str:
        """What the poses form: "loop", "arc" or "two arcs"."""
        planar = (self.low_end == "planar") + (self.high_end == "planar")
        return "loop" if self.circle or planar == 2 else "arc" if planar else "two arcs"


@dataclass(frozen=True)
class Family:
    """All poses of two sections whose tip is at a target.

    Attributes:
        target: tip position [m], shape (3,).
        backbone: of the two sections.
        pieces: feasible intervals of the free parameter, the first section's bend angle, in order; none where the
            target is out of reach.
    """

    target: Array
    backbone: Backbone
    pieces: tuple[Piece, ...]

    @property
    def reachable(self) -> bool:
        """Whether any pose reaches the target."""
        return bool(self.pieces)

    def bends(self, parameter: Any, branch: int = 1) -> Array:
        """Return bends [rad], shape (..., 2, 2), at bend angles of section 1 [rad], shape (...).

        Args:
            parameter: within a piece.
            branch: +1 or -1: the elbow at a larger or smaller azimuth than the target.

        Raises:
            InputError: a parameter in no piece, or a branch that is none.
        """
        beta1 = np.asarray(parameter, dtype=float)
        if branch not in (1, -1):
            raise InputError("branch", branch, "+1 or -1")
        inside = [(beta1 >= x.low - _CLOSE) & (beta1 <= x.high + _CLOSE) for x in self.pieces]
        if not self.pieces or not np.all(np.any(inside, axis=0)):
            allowed = (
                " or ".join(f"{x.low:.6g} to {x.high:.6g}" for x in self.pieces) or "none: the target is not reached"
            )
            raise InputError("parameter", parameter, f"{allowed} rad")
        flat = beta1.reshape(-1)
        return self._at(flat, np.ones_like(flat), np.full_like(flat, branch)).reshape(*beta1.shape, 2, 2)

    def curve(self, points: int = 100) -> list[Array]:
        """Return bends [rad] along every connected curve of poses, in order, arrays of shape (K, 2, 2).

        A loop returns to its first pose; K is 2 `points` - 1 for loops and arcs, `points` for each of two arcs.
        """
        out = []
        for piece in self.pieces:
            tau = np.linspace(0, np.pi, points)
            # from the planar end, if there is one, along one branch and back along the other
            turned = piece.high_end == "planar" and piece.low_end != "planar"
            one, other = self._branch(piece, tau, 1.0), self._branch(piece, tau, -1.0)
            if piece.shape == "two arcs":
                out += [one, other]
            elif piece.shape == "arc" and not turned:
                out.append(np.concatenate([one[::-1], other[1:]]))
            else:
                out.append(np.concatenate([one, other[-2::-1]]))
        return out

    def contains(self, bends: Any, tolerance: float = 1e-6) -> bool:
        """Return whether a pose belongs to the family.

        Args:
            bends: of both sections [rad], shape (2, 2).
            tolerance: for the miss as a fraction of the length, and for the distance from a piece [rad].
        """
        bends = as_bends(bends, self.backbone).reshape(2, 2)
        miss = np.abs(sections.position(bends, self.backbone) - self.target)
        if not np.all(miss <= tolerance * self.backbone.length) or excess(bends, self.backbone) > tolerance:
            return False
        angle = angles_of(bends)
        return any(x.low - tolerance <= angle[0] <= x.high + tolerance for x in self.pieces)

    def _branch(self, piece: Piece, tau: Array, branch: float) -> Array:
        cosine = np.cos(tau)
        beta1 = 0.5 * ((piece.low + piece.high) - (piece.high - piece.low) * cosine)
        return self._at(beta1, cosine, np.full_like(tau, branch))

    def _at(self, beta1: Array, cosine: Array, branch: Array) -> Array:
        pair, point = as_pair(self.backbone), self.target / self.backbone.length
        points = np.broadcast_to(point, (len(beta1), 3))
        found = bends_at(pair, as_targets(points), beta1, cosine, branch)
        return polish(pair, points, found)[0]


def family(target: Any, backbone: Backbone) -> Family:
    """Return all poses of two sections whose tip is at a target.

    Args:
        target: tip position in the base frame [m], shape (3,).
        backbone: of two sections.

    Raises:
        InputError: a target that is not one finite position, or a backbone of other than two sections.
    """
    pair, points = as_pair(backbone), one_goal(target, None, None, backbone.length).position
    targets = as_targets(points / backbone.length)
    found = find(pair, targets, _NODES)
    ends = planar_ends(pair, targets.at(found.owner), found)
    circle = bool(targets.rho[0] < ON_AXIS)
    one, other = (["planar" if x else "limit" for x in end] for end in ends)
    places = zip(found.low.tolist(), found.high.tolist(), one, other, strict=True)
    return Family(points[0], backbone, tuple(Piece(low, high, a, b, circle) for low, high, a, b in places))


def family_samples(positions: Array, backbone: Backbone, each: int) -> tuple[Array, Index]:
    """Return samples of the families of tip positions [m], shape (n, 3), denser towards the ends of each piece.

    Bends [rad], shape (K, 2, 2), some `each` of every branch, and the positions that they are of, shape (K,).
    """
    pair, points = as_pair(backbone), positions / backbone.length
    targets = as_targets(points)
    pieces = find(pair, targets)
    row = np.repeat(pieces.owner, 2 * each)
    cosine = np.cos(np.linspace(0, np.pi, each))
    beta1, cosine, branch = np.broadcast_arrays(
        places(pieces, cosine[None, None]), cosine, np.array([1.0, -1.0])[:, None]
    )
    found = bends_at(pair, targets.at(row), beta1.ravel(), cosine.ravel(), branch.ravel())
    found, miss = polish(pair, points[row], found)
    good = miss <= TOLERANCE
    return found[good], row[good]
