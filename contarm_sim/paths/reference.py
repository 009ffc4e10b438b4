"""A motion, or poses at rest, as one value: when, where the tip should be, and which bends stand for it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, UnreachableError, expect
from contarm_sim.kinematics import arc, dome
from contarm_sim.kinematics.arrays import Array, ReadOnly, as_vectors
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number, check_count
from contarm_sim.paths.bends import bends_to, directions_of
from contarm_sim.paths.shapes import FASTEST, LONGEST, Path

RATE = 100.0
"""Samples, and control ticks, per second [Hz]."""

_EVEN = 1e-6
"""Share of a period that times may be off even ones."""


@dataclass(frozen=True, eq=False, repr=False)
class Reference(ReadOnly, Shown):
    """What an arm of one length, or of sections of some lengths, is asked to do. Arrays are copied and read-only.

    Attributes:
        time: [s], shape (T,): even times from 0, or all zero for poses at rest.
        target: tip positions asked for [m], shape (T, 3).
        bend: the bends that stand for them [rad], shape (T, 2 S): x and y of section 1, of section 2, and so on.
        length: backbone length of the arm that they were made for [m]; of several sections, a tuple of theirs.
        direction: directions of the tip asked for, unit vectors, shape (T, 3), or None for any.

    Raises:
        InputError: arrays of other shapes, numbers that are not finite, bends of pi or more, or uneven times.
    """

    time: Array
    target: Array
    bend: Array
    length: float | tuple[float, ...]
    direction: Array | None = None

    def __post_init__(self) -> None:
        lengths = self.length if isinstance(self.length, tuple) else (self.length,)
        if not lengths or not all(0 < as_number(length) < np.inf for length in lengths):
            raise InputError("length", self.length, "a positive number [m], or a tuple of them, one for each section")
        object.__setattr__(self, "length", self.length if len(lengths) > 1 else lengths[0])
        size = 2 * len(lengths)
        bend, target = as_vectors(self.bend, size, "bend"), as_vectors(self.target, 3, "target")
        if bend.ndim != 2 or target.shape[:-1] != bend.shape[:-1] or not len(bend):
            raise InputError(
                "target", f"of shape {target.shape} beside bend of shape {bend.shape}", f"(T, 3) and (T, {size})"
            )
        arc.as_bend(bend.reshape(-1, 2))
        time = _times(self.time, len(bend))
        for name, array in (("time", time), ("target", target), ("bend", bend)):
            self._keep(name, array)
        if self.direction is not None:
            self._keep("direction", directions_of(self.direction, len(bend)))

    def __len__(self) -> int:
        return len(self.bend)

    def __repr__(self) -> str:
        what = f"{self.time[-1]:g} s at {self.rate:g} Hz" if self.moving else "poses at rest"
        return f"Reference({len(self)} samples, {what}, length {' + '.join(f'{x:g}' for x in self.lengths)} m)"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reference):
            return NotImplemented
        same = (np.array_equal(getattr(self, name), getattr(other, name)) for name in ("time", "target", "bend"))
        return self.length == other.length and all(same) and _same(self.direction, other.direction)

    __hash__ = None  # type: ignore[assignment]

    @property
    def lengths(self) -> tuple[float, ...]:
        """Lengths of the sections [m]."""
        return self.length if isinstance(self.length, tuple) else (self.length,)

    @property
    def bends(self) -> Array:
        """Bends of all sections [rad], shape (T, S, 2)."""
        return self.bend.reshape(len(self), -1, 2)

    @property
    def moving(self) -> bool:
        """Whether the samples follow one another in time."""
        return bool(self.time[-1] > 0)

    @property
    def rate(self) -> float:
        """Samples per second [Hz]; 100 where there is one sample, or none moves."""
        return float(f"{(len(self) - 1) / self.time[-1]:.12g}") if self.moving else RATE

    def first(self, count: int) -> Reference:
        """Return the first `count` samples.

        Raises:
            InputError: not a whole number, or below 1.
        """
        check_count("count", count, 1, "samples")
        direction = None if self.direction is None else self.direction[:count]
        return Reference(self.time[:count], self.target[:count], self.bend[:count], self.length, direction)

    def at_rest(self) -> Reference:
        """Return the same targets and bends as poses at rest."""
        return replace(self, time=np.zeros(len(self))) if self.moving else self

    def check_arm(self, arm: Arm) -> None:
        """Refuse an arm of another length, or of other sections: its tips lie elsewhere.

        Raises:
            InputError: says both lengths.
        """
        found = section_lengths(arm)
        if found != self.length:
            mine, theirs = (
                f"{x:g} m" if isinstance(x, float) else f"sections of {', '.join(f'{each:g}' for each in x)} m"
                for x in (self.length, found)
            )
            raise InputError("reference", f"for an arm of {mine}", f"one for this arm, of {theirs}")

    @classmethod
    def from_path(
        cls, path: Path, arm: Arm, rate: float = RATE, project: dome.Projection = "refuse", direction: Any = None
    ) -> Reference:
        """Return the motion along a path (`contarm_sim.paths.named`), sampled at a rate [Hz].

        Of several sections, bends are those of a continuous way through all the poses that reach the path.

        Args:
            project: what to do with targets out of reach, see `kinematics.dome.bend_from_tip`; several sections
                refuse them, or take the nearest.
            direction: of the tip on the whole way, shape (3,); needs three sections or more.

        Raises:
            UnreachableError: a target out of reach; says how far along the path.
            InputError: a rate that is not positive, or a direction that this arm cannot be asked for.
        """
        expect("path", path, Path)
        expect("arm", arm, Arm)
        time, target = path.targets(rate)
        if direction is not None:
            direction = np.broadcast_to(as_vectors(direction, 3, "direction"), target.shape)
        try:
            bend = bends_to(target, direction, arm, project, moving=True)
        except UnreachableError as error:
            share = 100 * error.index / len(target)
            raise error.located(f"path {path.name}, {share:.0f} % of the way") from None
        return cls(time, target, bend, section_lengths(arm), direction)

    @classmethod
    def from_targets(
        cls, target: Any, arm: Arm, time: Any = None, project: dome.Projection = "refuse", direction: Any = None
    ) -> Reference:
        """Return the motion through tip positions [m], shape (T, 3), at even times [s], shape (T,).

        Args:
            time: None: poses at rest.
            direction: of the tip, shape (T, 3); needs three sections or more.

        Raises:
            UnreachableError: a target out of reach, unless projected.
            InputError: as the class.
        """
        expect("arm", arm, Arm)
        target = as_vectors(target, 3, "target")
        bend = bends_to(target, direction, arm, project, moving=time is not None)
        return cls(np.zeros(len(target)) if time is None else time, target, bend, section_lengths(arm), direction)

    @classmethod
    def from_bends(cls, bend: Any, arm: Arm, time: Any = None) -> Reference:
        """Return the motion through bends [rad], shape (T, 2 S) or (T, S, 2), at even times [s], shape (T,).

        Args:
            time: None: poses at rest.

        Raises:
            InputError: as the class.
        """
        expect("arm", arm, Arm)
        bend = shape.as_coordinates(bend, arm)
        target = shape.position(bend, arm)
        return cls(np.zeros(len(bend)) if time is None else time, target, bend, section_lengths(arm))


def section_lengths(arm: Arm) -> float | tuple[float, ...]:
    """Return the length of an arm's only section [m], or those of all in a tuple."""
    lengths = tuple(section.length for section in arm.sections)
    return lengths[0] if len(lengths) == 1 else lengths


def _same(one: Array | None, other: Array | None) -> bool:
    return one is other if one is None or other is None else np.array_equal(one, other)


def _times(time: Any, count: int) -> Array:
    """Return times [s], shape (count,), that are even from 0, or all zero."""
    try:
        found = np.asarray(time, dtype=float)
    except (TypeError, ValueError):
        found = np.full(1, np.nan)
    even = np.linspace(0, found[-1], count) if found.shape == (count,) and np.isfinite(found).all() else None
    if even is None or found[-1] < 0 or np.abs(found - even).max() > _EVEN * found[-1] / max(count - 1, 1):
        given = "uneven, or not from 0" if found.shape == (count,) else f"of shape {found.shape}"
        raise InputError("time", given, f"{count} even times that rise from 0 [s], or zeros")
    if found[-1] > 0 and not count - 1 <= FASTEST * found[-1] <= LONGEST * FASTEST:
        given = f"{found[-1]:g} s for {count} samples"
        raise InputError("time", given, f"at most {LONGEST:g} s, and {FASTEST:g} samples a second")
    return found
