"""The feedbacks of many arms, each kind at once where it can."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.control.feedback import Feedback, Memory, Seen
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array


@dataclass(frozen=True)
class _Kind:
    """Feedbacks of one class, as one: `many`, of the arms at these places, for so many ticks; `at` picks the arms."""

    many: Feedback
    places: list[int]
    ticks: int
    at: Any


class Corrections:
    """Corrects the controls of B arms of n muscles, to the bits of each arm's own feedback.

    Args:
        each: the feedback of each arm, its own, or None.
        ticks: the samples of each that it is to correct.
        muscles: n.

    Attributes:
        value: added to the plans' controls, shape (B, n).
        failed: why the feedback of an arm gave up, by the place of the arm.
    """

    def __init__(self, each: Sequence[Feedback | None], ticks: Sequence[slice], muscles: int) -> None:
        self.value, self.failed = np.zeros((len(each), muscles)), dict[int, ContarmError]()
        self._ticks, self._kinds, self._alone = ticks, list[_Kind](), dict[int, Feedback]()
        kinds = dict[type[Feedback], list[int]]()
        for place, one in enumerate(each):
            if one is not None:
                kinds.setdefault(type(one), []).append(place)
        for kind, places in kinds.items():
            self._add(kind, places, [each[place] for place in places])
        self._values = {place: one.value for place, one in self._alone.items()}
        self._gather()

    def _add(self, kind: type[Feedback], places: list[int], each: list[Any]) -> None:
        own = [self._ticks[place] for place in places]
        # A method that a subclass inherits knows another `update`.
        many = kind.together(each, own) if "together" in vars(kind) else None
        if many is None:
            self._alone |= dict(zip(places, each, strict=True))
            return
        ticks = max(one.stop - one.start for one in own)
        self._kinds.append(_Kind(many, places, ticks, slice(None) if len(places) == len(self.value) else places))

    def __bool__(self) -> bool:
        return bool(self._kinds or self._alone)

    def update(self, tick: int, seen: Seen, gain: Array, going: NDArray[np.bool_]) -> None:
        """Let the feedbacks see their arms.

        Args:
            tick: counted from the first of each.
            seen: of all arms, with arrays as `Feedback.together` says.
            gain: tick over time constant, of each arm.
            going: which arms count still.
        """
        for kind in self._kinds:
            if tick < kind.ticks:
                gains: Any = gain[kind.at]
                kind.many.update(tick, _part(seen, kind.at), gains)
        for place, one in self._alone.items():
            if going[place] and place not in self.failed:
                try:
                    one.update(self._ticks[place].start + tick, _single(seen, place), float(gain[place]))
                except ContarmError as error:
                    self.failed[place] = error
        self._gather()

    def memories(self) -> list[Memory | None]:
        """Return what the feedback of each arm has summed up."""
        out: list[Memory | None] = [None] * len(self.value)
        for kind in self._kinds:
            parts = kind.many.memory
            for number, place in enumerate(kind.places):
                out[place] = tuple(part[number] for part in parts)
        for place, one in self._alone.items():
            if one.value is not self._values[place]:
                allowed = "the same one, changed in place"
                self.failed[place] = InputError("feedback.value", "another array than before", allowed)
            out[place] = one.memory
        return out

    def _gather(self) -> None:
        for kind in self._kinds:
            self.value[kind.at] = kind.many.value
        for place, value in self._values.items():
            self.value[place] = value


def _part(seen: Seen, places: Any) -> Seen:
    """Return what is seen of some of the arms."""
    if isinstance(places, slice):
        return seen
    lengths, speeds, tensions, pulls = (part[:, places] for part in _numbers(seen))
    return Seen(lengths, speeds, tensions, pulls, seen.tip[places])


def _single(seen: Seen, place: int) -> Seen:
    """Return what is seen of one arm, as its own feedback expects it."""
    lengths, speeds, tensions, pulls = (part[:, place].tolist() for part in _numbers(seen))
    return Seen(lengths, speeds, tensions, pulls, seen.tip[place])


def _numbers(seen: Seen) -> tuple[Any, Any, Any, Any]:
    return seen.lengths, seen.speeds, seen.tensions, seen.pulls
