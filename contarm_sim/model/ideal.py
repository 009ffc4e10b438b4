"""The law of an ideal muscle: its tension is what is asked for."""

from __future__ import annotations

from dataclasses import dataclass

from contarm_sim.brevity import Told
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.parameters import number


@dataclass(frozen=True, kw_only=True, repr=False)
class Ideal(Told, MuscleLaw):
    """A muscle without mass, stiffness or friction: driven by tension, it pulls with its control, within limits.

    Driven by length it has the length servo that other muscles have.

    Raises:
        InputError: a parameter is not a finite number in its stated interval.
    """

    min_tension: float = number(5.0, "N", "tension that the slackest muscle is held at", above=0)
    max_tension: float = number(200.0, "N", "highest tension", above=0)
    diameter: float = number(0.004, "m", "diameter that it is drawn with", above=0)
    servo_stiffness: float | None = number(
        None, "N/m", "gain of the muscle's length servo; omitted: 180 EI/(1.5 r^2 L0), more for heavy arms", above=0
    )
    servo_time: float | None = number(
        None, "s", "damping along the muscle over the servo's gain; omitted: 5 ms, more for slow arms", least=0
    )

    def __post_init__(self) -> None:
        self.check()

    @property
    def blocked_force(self) -> float:
        """Highest tension [N]."""
        return self.max_tension
