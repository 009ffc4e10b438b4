"""What a muscle law is: how a muscle pulls, and the length servo that drives it by default."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

from contarm_sim.errors import InputError
from contarm_sim.model.parameters import check_numbers

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class MuscleLaw(ABC):
    """The law of one muscle: what every muscle has, whatever makes it pull.

    A law is a frozen dataclass that subclasses this one or `PneumaticLaw`, declares its parameters as fields with
    defaults (by `parameters.number`), and calls `check` when it is made. The properties below may be fields of a law.
    Its methods take lengths [m] as arrays, broadcast, and load NumPy when they are called: parameters alone are made
    without it.
    """

    @property
    @abstractmethod
    def diameter(self) -> float:
        """Outer diameter at rest [m]."""

    @property
    @abstractmethod
    def blocked_force(self) -> float:
        """Highest tension [N]."""

    @property
    @abstractmethod
    def min_tension(self) -> float:
        """Tension that the slackest muscle is held at [N]."""

    @property
    def servo_stiffness(self) -> float | None:
        """Gain of the length servo [N/m]; None: what follows from the arm."""
        return None

    @property
    def servo_time(self) -> float | None:
        """Damping along the muscle over the length servo's gain [s]; None: what follows from the arm."""
        return None

    @property
    def mount_contraction(self) -> float:
        """Contraction in the straight arm, from the length without load [-]."""
        return 0.0

    @property
    def max_contraction(self) -> float:
        """Largest contraction from the length without load [-]."""
        return 1.0

    @property
    def max_stretch(self) -> float:
        """Largest strain from the length without load [-]: no bend of half a turn takes more than 1."""
        return 1.0

    @property
    def passive_stiffness(self) -> float | None:
        """Stiffness beyond the length without load, actuators apart [N/m], or None."""
        return None

    @property
    def dry_friction(self) -> float | None:
        """Dry friction along the muscle [N], or None."""
        return None

    @property
    def pressure_limits(self) -> tuple[float, float]:
        """Lowest gauge pressure when inflated, and highest [Pa]; 0 and inf for a muscle without pressures."""
        return 0.0, math.inf

    def servo_gain(self, length: float) -> float | None:
        """Return the gain of the length servo of a muscle of a length [m] in the straight arm [N/m].

        None: what follows from the arm.
        """
        return self.servo_stiffness

    def with_min_tension(self, tension: float) -> Self:
        """Return the same law with another tension of the slackest muscle [N]."""
        return replace(self, min_tension=tension)  # type: ignore[call-arg]  # a field of most laws

    def diameter_at(self, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the outer diameter [m] at lengths [m]: that at rest, unless a law says otherwise."""
        import numpy as np

        return np.full(np.shape(length), self.diameter)

    def check(self) -> None:
        """Check the fields' numbers, and that they fit together.

        Raises:
            InputError: names the first that does not.
        """
        check_numbers(self, "muscle.")
        if self.min_tension >= self.blocked_force:
            raise InputError(
                "muscle.min_tension", self.min_tension, f"below the blocked force, {self.blocked_force:.4g} N"
            )

    def passive_tension(self, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the tension [N] of the muscle's own stiffness alone: a spring beyond the rest length, slack below."""
        import numpy as np

        stretch = np.maximum(np.asarray(length, dtype=float) - rest_length, 0.0)
        return np.asarray((self.passive_stiffness or 0.0) * stretch)

    def passive_slope(self, length: Any, rest_length: float) -> NDArray[float64]:
        """Return dF/dL [N/m] of `passive_tension`."""
        import numpy as np

        return np.where(np.asarray(length) > rest_length, self.passive_stiffness or 0.0, 0.0)
