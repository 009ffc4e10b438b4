"""A motion, or poses at rest, as one value: when, where the tip should be, and which bends stand for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError, UnreachableError, expect
from contarm_sim.kinematics import arc, dome
from contarm_sim.kinematics.arrays import Array, ReadOnly, as_vectors
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number, check_count
from contarm_sim.paths.shapes import FASTEST, LONGEST, Path

RATE = 100.0
"""Samples, and control ticks, per second [Hz]."""

_EVEN = 1e-6
"""Share of a period that times may be off even ones."""


@dataclass(frozen=True, eq=False)
class Reference(ReadOnly):
    """What an arm of one length is asked to do. Arrays are copied and read-only.

    Attributes:
        time: [s], shape (T,): even times from 0, or all zero for poses at rest.
        target: tip positions asked for [m], shape (T, 3).
        bend: the bends that stand for them [rad], shape (T, 2).
        length: backbone length of the arm that they were made for [m].

    Raises:
        InputError: arrays of other shapes, numbers that are not finite, bends of pi or more, or uneven times.
    """

    time: Array
    target: Array
    bend: Array
    length: float

    def __post_init__(self) -> None:
        bend, target = arc.as_bend(self.bend), as_vectors(self.target, 3, "target")
        if bend.ndim != 2 or target.shape[:-1] != bend.shape[:-1] or not len(bend):
            raise InputError(
                "target", f"of shape {target.shape} beside bend of shape {bend.shape}", "(T, 3) and (T, 2)"
            )
        time = _times(self.time, len(bend))
        length = self.length
        if not 0 < as_number(length) < np.inf:
            raise InputError("length", length, "a positive number [m]")
        for name, array in (("time", time), ("target", target), ("bend", bend)):
            self._keep(name, array)

    def __len__(self) -> int:
        return len(self.bend)

    def __repr__(self) -> str:
        what = f"{self.time[-1]:g} s at {self.rate:g} Hz" if self.moving else "poses at rest"
        return f"Reference({len(self)} samples, {what}, length {self.length:g} m)"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Reference):
            return NotImplemented
        same = (np.array_equal(getattr(self, name), getattr(other, name)) for name in ("time", "target", "bend"))
        return self.length == other.length and all(same)

    __hash__ = None  # type: ignore[assignment]

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
        return Reference(self.time[:count], self.target[:count], self.bend[:count], self.length)

    def at_rest(self) -> Reference:
        """Return the same targets and bends as poses at rest."""
        return Reference(np.zeros(len(self)), self.target, self.bend, self.length) if self.moving else self

    def check_arm(self, arm: Arm) -> None:
        """Refuse an arm of another length: its tips lie elsewhere.

        Raises:
            InputError: says both lengths; or an arm of several sections.
        """
        _ = arm.section  # of several sections, bends and targets have another meaning
        if arm.length != self.length:
            raise InputError("reference", f"for an arm of {self.length:g} m", f"one for this arm, of {arm.length:g} m")

    @classmethod
    def from_path(cls, path: Path, arm: Arm, rate: float = RATE, project: dome.Projection = "refuse") -> Reference:
        """Return the motion along a path (`contarm_sim.paths.named`), sampled at a rate [Hz].

        Args:
            project: what to do with targets off the dome, see `kinematics.dome.bend_from_tip`.

        Raises:
            UnreachableError: a target off the dome; says how far along the path.
            InputError: a rate that is not positive.
        """
        expect("path", path, Path)
        expect("arm", arm, Arm)
        time, target = path.targets(rate)
        try:
            bend = dome.bend_from_tip(target, arm.length, project).bend
        except UnreachableError as error:
            share = 100 * error.index / len(target)
            raise error.located(f"path {path.name}, {share:.0f} % of the way") from None
        return cls(time, target, bend, arm.length)

    @classmethod
    def from_targets(cls, target: Any, arm: Arm, time: Any = None, project: dome.Projection = "refuse") -> Reference:
        """Return the motion through tip positions [m], shape (T, 3), at even times [s], shape (T,).

        Args:
            time: None: poses at rest.

        Raises:
            UnreachableError: a target off the dome, unless projected.
            InputError: as the class.
        """
        expect("arm", arm, Arm)
        target = as_vectors(target, 3, "target")
        bend = dome.bend_from_tip(target, arm.length, project).bend
        return cls(np.zeros(len(target)) if time is None else time, target, bend, arm.length)

    @classmethod
    def from_bends(cls, bend: Any, arm: Arm, time: Any = None) -> Reference:
        """Return the motion through bends [rad], shape (T, 2), at even times [s], shape (T,).

        Args:
            time: None: poses at rest.

        Raises:
            InputError: as the class.
        """
        expect("arm", arm, Arm)
        bend = arc.as_bend(bend)
        target = arc.position(bend, arm.length)
        return cls(np.zeros(len(bend)) if time is None else time, target, bend, arm.length)


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
