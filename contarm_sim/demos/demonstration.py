"""What a demonstration gives: motions, and the checks that they pass or do not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from contarm_sim.demos.checks import Check
from contarm_sim.results.trajectory import Trajectory

OnTick = Callable[[int, int], object]
"""Called with the number of samples so far, and of all."""


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
    checks: list[Check]
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
