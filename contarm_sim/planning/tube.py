"""The arm as a tube about its arcs: places along them, how thick it is there, and how far chords cut corners."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm

CHORDS = 32
"""Chords of each section, nearly. Bent by half a turn, an arc lies 0.04 % of its length beside its chords."""

_SAME = 1e-6  # places nearer than this are one, as a share of a section


@dataclass(frozen=True, eq=False)
class Tube:
    """An arm's arcs, cut into M chords at M + 1 places from base to tip, and the radius about them.

    Attributes:
        lengths: of the sections [m].
        shares: where the chords of each section end, as shares of it: evenly, and where its plates end.
        along: arc lengths of the places [m], shape (M + 1,).
        chord_radius: of the tube about each chord [m], shape (M,): of the geoms that touch.
    """

    lengths: tuple[float, ...]
    shares: tuple[Array, ...]
    along: Array
    chord_radius: Array

    @classmethod
    def of(cls, arm: Arm, chords: int = CHORDS) -> Tube:
        """Return the tube of an arm."""
        from contarm_sim.mjcf.backbone import links

        lengths = tuple(section.length for section in arm.sections)
        shares = tuple(_shares(chords, section.links) for section in arm.sections)
        starts = np.concatenate([[0.0], np.cumsum(lengths)])
        along = np.concatenate([[0.0], *(a + x * share for a, x, share in zip(starts, lengths, shares, strict=False))])
        each, stations = links(arm), shape.stations(arm) * arm.length
        low = stations - [link.half(link.below) for link in each]
        high = stations + [link.half(link.above) for link in each]
        middle = 0.5 * (along[:-1] + along[1:])[:, None]
        radius = np.where((low < middle) & (middle < high), [link.contact_radius for link in each], 0.0)
        return cls(lengths, shares, along, radius.max(axis=1))

    @property
    def length(self) -> float:
        """Length of the backbone [m]."""
        return sum(self.lengths)

    @cached_property
    def radius(self) -> Array:
        """Radius of the tube at each place [m], shape (M + 1,)."""
        ends = self.chord_radius
        return np.maximum(np.append(ends[0], ends), np.append(ends, ends[-1]))

    def places(self, bends: Array) -> Array:
        """Return the places [m] of poses with bends [rad], (K, S, 2), shape (K, M + 1, 3)."""
        out, first = np.zeros((len(bends), len(self.along), 3)), 1
        start, turn = np.zeros((len(bends), 1, 3)), np.broadcast_to(np.eye(3), (len(bends), 3, 3))
        for number, (length, share) in enumerate(zip(self.lengths, self.shares, strict=True)):
            own = arc.position(bends[:, number, None], length, share, check=False)
            part = out[:, first : first + len(share)]
            part[:] = start + own @ turn.swapaxes(1, 2)
            start, turn = part[:, -1:], turn @ arc.rotation(bends[:, number], check=False)
            first += len(share)
        return out

    def sagitta(self, bends: Array) -> Array:
        """Return how far arcs lie beside their chords [m], shape (K, M), of bends [rad], shape (K, S, 2)."""
        angle = np.hypot(bends[..., 0], bends[..., 1])
        parts = []
        for number, (length, share) in enumerate(zip(self.lengths, self.shares, strict=True)):
            step = np.diff(share, prepend=0.0)
            parts.append(0.5 * length * step * np.tan(0.25 * angle[:, number, None] * step))  # at most: chords are less
        return np.concatenate(parts, axis=-1)

    def between(self, margin: float) -> float:
        """Return how much nearer to objects an arm may be than its places are, clear by about a margin [m].

        Where the distance d from an object is least along a line, a place s farther along is sqrt(d^2 + s^2), at most,
        from the same point of the object: s^2/(2 d) more. Some place that is looked at lies within half a chord of
        length h: h^2/(8 d). Arcs lie beside their chords by the sagitta, which counts twice.
        """
        steps = np.diff(self.along)
        bent = np.array([[[np.pi, 0.0]] * len(self.lengths)])
        beside = float(self.sagitta(bent).max())
        return 2 * beside + float((0.125 * steps**2 / (self.chord_radius + margin)).max()) + 1e-5


def _shares(chords: int, links: int) -> Array:
    """Return where the chords of a section end, as shares of it, from the first to 1."""
    plates = np.array([0.5, links - 0.5]) / links
    out = np.sort(np.concatenate([np.arange(1, chords + 1) / chords, plates]))
    return np.asarray(out[np.diff(out, prepend=0.0) > _SAME])
