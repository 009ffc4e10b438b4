"""The law of a tendon: an elastic cable behind a winch."""

from __future__ import annotations

from dataclasses import dataclass, replace

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.parameters import check_numbers, number


@dataclass(frozen=True, kw_only=True, repr=False)
class Tendon(Told, MuscleLaw):
    """A cable along the arm, wound up at its start; driven by the length that is wound out, or by its tension.

    Driven by length, its tension is pretension + (stiffness/L) (l - L - control): l is its length, L that in the
    straight arm, and the control is what the winch has let out [m], so -0.01 winds 10 mm up. It never pushes: a slack
    cable has no tension. Friction opposes its slip: with at most `friction` between winch and arm, and by
    `friction_coefficient` along its way through the arm, where tension falls by exp(-coefficient times the angle that
    the cable turns by). Recordings of slow arms are fitted with both (`statics.memory`); motions have `friction` alone,
    and single poses neither.

    Raises:
        InputError: a parameter is not a finite number in its stated interval.
    """

    stiffness: float = number(
        2e4, "N", "EA, force by strain, so that a longer cable is softer: 2e4 for 1 mm of aramid or wire rope", above=0
    )
    pretension: float = number(5.0, "N", "tension that the slackest cable keeps", above=0)
    max_tension: float = number(200.0, "N", "highest tension, at which the winch slips", above=0)
    friction: float | None = number(None, "N", "dry friction of the cable in its guides; omitted: none", above=0)
    friction_coefficient: float | None = number(
        None, "-", "Coulomb friction of the cable along its bends (capstan), in slow poses; omitted: none", above=0
    )
    diameter: float = number(0.001, "m", "outer diameter of the cable", above=0)
    servo_time: float | None = number(
        None, "s", "damping along the cable over its stiffness; omitted: 5 ms, more for slow arms", least=0
    )

    def __post_init__(self) -> None:
        check_numbers(self, "muscle.")
        if self.pretension >= self.max_tension:
            raise InputError("muscle.pretension", self.pretension, f"below max_tension ({self.max_tension:g} N)")

    @property
    def min_tension(self) -> float:
        """Tension that the slackest cable keeps [N]."""
        return self.pretension

    def with_min_tension(self, tension: float) -> Tendon:
        """Return the same cable with another pretension [N]."""
        return replace(self, pretension=tension)

    @property
    def blocked_force(self) -> float:
        """Highest tension [N]."""
        return self.max_tension

    @property
    def dry_friction(self) -> float | None:
        """Dry friction of the cable in its guides [N], or None."""
        return self.friction

    def servo_gain(self, length: float) -> float:
        """Return the stiffness of a cable of a length [m] along itself [N/m]: the winch holds its other end."""
        return self.stiffness / length
