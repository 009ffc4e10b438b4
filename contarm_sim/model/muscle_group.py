"""The muscles of one section: where they run, their law, and the length servos that drive them by default.

The set-point of a length servo is said here and nowhere else: `setpoint`, and its inverse `servo_tension`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.pneumatic_law import PneumaticLaw, as_pneumatic
from contarm_sim.model.routing import Routing

SERVO_RATIO = 180.0
"""Stiffness of length servos over that of the bent arm: the feed-forward's part of a muscle's stretch is then small."""

SERVO_TIME = 0.005
"""Least damping along a muscle over its servo's gain [s]: keeps one at its force limit from hunting at 5 ms steps."""


@dataclass(frozen=True, kw_only=True)
class MuscleGroup:
    """The muscles of one section, all alike.

    Attributes:
        section: number of the section that they end with, from 0.
        first: number of the section that they begin with, from 0.
        routing, law: where they run, and by which law they pull.
        length: length of the straight arm's muscles [m].
        bending_resistance: what the section and all beyond it resist a uniform bend of the section with [N m/rad].
        bend_inertia: inertia of a uniform bend of the section and of all beyond it [kg m^2].
    """

    section: int
    first: int
    routing: Routing
    law: MuscleLaw
    length: float
    bending_resistance: float
    bend_inertia: float

    def crosses(self, section: int) -> bool:
        """Tell whether the muscles run through a section, numbered from 0."""
        return self.first <= section <= self.section

    @property
    def pneumatics(self) -> PneumaticLaw:
        """The law, if pressure drives the muscles.

        Raises:
            InputError: it has no pressures.
        """
        return as_pneumatic(self.law)

    @property
    def rest_length(self) -> float:
        """Length without pressure or load [m]; mounted pre-contracted, a muscle has `length` in the straight arm."""
        return self.length / (1 - self.law.mount_contraction)

    @property
    def length_range(self) -> tuple[float, float]:
        """Shortest and longest length [m] that a muscle can take, such as full contraction and closed braid."""
        rest = self.rest_length
        return rest * (1 - self.law.max_contraction), rest * (1 + self.law.max_stretch)

    @property
    def reach(self) -> float:
        """How far its muscles reach from the backbone at their fattest [m]: as short as they can be.

        That is contracted as far as their law lets them, or as half a turn of each section that they cross takes.
        """
        turned = self.length - math.pi * self.routing.radius * (self.section - self.first + 1)
        shortest = max(self.length_range[0], turned)
        return self.routing.radius + 0.5 * float(self.law.diameter_at(shortest, self.rest_length))

    @property
    def stiffness_share(self) -> float:
        """What muscles of stiffness 1 N/m resist a bend with in any plane [m^2/rad]."""
        return 0.5 * self.routing.count * self.routing.radius**2

    @property
    def servo_stiffness(self) -> float:
        """Gain of the length servos [N/m]: the law's, or `SERVO_RATIO` times what the bent section resists with."""
        gain = self.law.servo_gain(self.length)
        if gain is not None:
            return gain
        return float(f"{SERVO_RATIO * self.bending_resistance / self.stiffness_share:.1e}")  # two digits say enough

    @property
    def servo_frequency(self) -> float:
        """Angular frequency [rad/s] at which a uniform bend swings on the length servos."""
        return math.sqrt(self.stiffness_share * self.servo_stiffness / self.bend_inertia)

    @property
    def servo_time(self) -> float:
        """Damping along a muscle over its servo's gain [s]: the law's, or a fifth of critical, 5 ms at least."""
        if self.law.servo_time is not None:
            return self.law.servo_time
        return float(f"{max(SERVO_TIME, 0.4 / self.servo_frequency):.1e}")

    def setpoint(self, lengths: Any, tensions: Any) -> Any:
        """Return the controls of length servos [m] at which muscles of these lengths [m] have tensions [N]; broadcasts.

        A control is a length change from the straight arm. At 0 the servos hold the straight arm at the least tension.
        """
        return lengths - self.length - (tensions - self.law.min_tension) / self.servo_stiffness

    def servo_tension(self, control: Any, lengths: Any) -> Any:
        """Return the tensions [N] of muscles of these lengths [m] under controls [m], limits apart; see `setpoint`."""
        return self.law.min_tension + self.servo_stiffness * (lengths - self.length - control)

    @property
    def setpoint_range(self) -> tuple[float, float]:
        """Lowest and highest control of a length servo, a length change from the straight arm [m].

        The lowest gives the shortest muscle its full force.
        """
        shortest, longest = self.length_range
        return self.setpoint(shortest, self.law.blocked_force), self.setpoint(longest, self.law.min_tension)
