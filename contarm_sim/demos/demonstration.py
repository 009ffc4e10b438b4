"""What a demonstration gives: motions, and what they must show, as numbers beside what is allowed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from contarm_sim.results.trajectory import Trajectory

STEP = 0.0025
"""Engine step of all demonstrations [s]."""

OnTick = Callable[[int, int], object]
"""Called with the number of samples so far, and of all."""


@dataclass(frozen=True)
class Requirement:
    """A number of a demonstration, and its limit.

    Attributes:
        what: is measured.
        value, limit: in the unit.
        unit: of both, an SI unit or %; "" of a ratio.
        least: whether the limit is the least that is allowed; else the most.
    """

    what: str
    value: float
    limit: float
    unit: str
    least: bool = False

    @property
    def passed(self) -> bool:
        """Whether the value is within its limit; what is no number is not."""
        return self.value >= self.limit if self.least else self.value <= self.limit


@dataclass(frozen=True)
class Demonstration:
    """A motion that shows something, and what it must show.

    Attributes:
        run: the motion.
        checks: what must hold.
        said: what was found, in a sentence.
        beside: the motion that it is compared with, or None.
        names: of both, for films.
        aims: whether the tip has a target that films show.
        camera: where films of it are seen from: a name, or azimuth and elevation [deg].
        size: width and height of a film [pixels].
    """

    run: Trajectory
    checks: list[Requirement]
    said: str
    beside: Trajectory | None = None
    names: tuple[str, str] = ("", "")
    aims: bool = False
    camera: str | tuple[float, float] = "front"
    size: tuple[int, int] = (1280, 720)

    @property
    def passed(self) -> bool:
        """Whether all checks hold."""
        return all(check.passed for check in self.checks)


def ticks(on_tick: OnTick | None, number: int, count: int) -> Callable[[int], object] | None:
    """Return what a motion calls with its samples so far, the `number`-th of two of `count` samples each."""
    return None if on_tick is None else lambda done: on_tick(number * count + done, 2 * count)
