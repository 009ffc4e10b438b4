"""The McKibben law of a pneumatic muscle (Chou and Hannaford 1996), from the paper's dimensions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from contarm_sim.brevity import Told
from contarm_sim.errors import InputError
from contarm_sim.model.parameters import check_numbers, number
from contarm_sim.model.pneumatic_law import PneumaticLaw

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True, repr=False)
class McKibben(Told, PneumaticLaw):
    """One braided pneumatic muscle (PMA) and the length servo that stands for its valve and controller.

    Raises:
        InputError: a parameter is not a finite number in its stated interval.
    """

    inner_diameter: float = number(0.009, "m", "bladder bore (paper: 9 mm)", above=0)
    wall: float = number(0.002, "m", "bladder wall thickness (paper: 2 mm)", above=0)
    braid_min_diameter: float = number(0.010, "m", "smallest diameter of the braid (paper: 10 mm)", above=0)
    max_contraction: float = number(
        0.25, "-", "contraction at which the force vanishes (paper: 25 %)", above=0, below=0.42
    )
    min_pressure: float = number(90e3, "Pa", "lowest gauge pressure when inflated (paper: 90 kPa)", above=0)
    max_pressure: float = number(700e3, "Pa", "highest gauge pressure (paper: 700 kPa)", above=0)
    mount_contraction: float = number(
        0.05, "-", "contraction in the straight arm, so that a muscle can also lengthen", least=0, below=0.42
    )
    min_tension: float = number(5.0, "N", "tension that the slackest muscle is held at", above=0)
    passive_stiffness: float | None = number(
        None, "N/m", "of the silicone stretched beyond its rest length; omitted: bending_stiffness has it", above=0
    )
    braid_friction: float | None = number(None, "N", "dry friction of braid and guides; omitted: none", above=0)
    valve_time: float = number(0.05, "s", "time constant of valve and filling", above=0)
    servo_stiffness: float | None = number(
        None, "N/m", "gain of the muscle's length servo; omitted: 180 EI/(1.5 r^2 L0), more for heavy arms", above=0
    )
    servo_time: float | None = number(
        None, "s", "damping along the muscle over the servo's gain; omitted: 5 ms, more for slow arms", least=0
    )

    def __post_init__(self) -> None:
        check_numbers(self, "muscle.")  # the braid's shape, before forces are made of it
        if self.braid_min_diameter >= self.diameter:
            raise InputError(
                "muscle.braid_min_diameter", self.braid_min_diameter, f"below the bladder's {self.diameter:g} m"
            )
        self.check()

    @property
    def diameter(self) -> float:
        """Outer diameter of the bladder, hence of the braid at rest, D0 [m]."""
        return self.inner_diameter + 2 * self.wall

    @property
    def braid_angle(self) -> float:
        """Angle alpha0 between braid and axis at rest [rad], from eps_max = 1 - 1/(sqrt(3) cos alpha0)."""
        return math.acos(1 / (math.sqrt(3) * (1 - self.max_contraction)))

    @property
    def max_stretch(self) -> float:
        """Strain at which the braid closes on its smallest diameter [-].

        The fibres keep their length: sin(alpha) = (D/D0) sin(alpha0), L/L_rest = cos(alpha)/cos(alpha0).
        """
        sine = self.braid_min_diameter / self.diameter * math.sin(self.braid_angle)
        return math.sqrt(1 - sine**2) / math.cos(self.braid_angle) - 1

    @property
    def blocked_force(self) -> float:
        """Force at rest length and highest pressure [N] (Chou and Hannaford 1996)."""
        area = math.pi * self.diameter**2 / 4
        return self.max_pressure * area * (3 / math.tan(self.braid_angle) ** 2 - 1 / math.sin(self.braid_angle) ** 2)

    @property
    def pull_per_pascal(self) -> float:
        """Share of the braid in the force at rest length, by pressure [m^2]."""
        return math.pi * self.diameter**2 / 4 * 3 / math.tan(self.braid_angle) ** 2

    def diameter_at(self, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the braid's diameter [m] at lengths [m]: it swells as it shortens, its fibres keeping their length.

        sin(alpha) = (D/D0) sin(alpha0), cos(alpha) = (L/L_rest) cos(alpha0), as in `max_stretch`.
        """
        import numpy as np

        cosine = np.asarray(length, dtype=float) / rest_length * math.cos(self.braid_angle)
        swollen = self.diameter * np.sqrt(np.maximum(1 - cosine**2, 0.0)) / math.sin(self.braid_angle)
        return np.maximum(swollen, self.braid_min_diameter)

    def force(self, pressure: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the pulling force [N] of a muscle at a gauge pressure [Pa] and a length [m].

        F = P (pi D0^2/4) (3 (1 - eps)^2/tan^2(alpha0) - 1/sin^2(alpha0)), eps the contraction from the rest length; a
        muscle contracted beyond `max_contraction` goes slack, it cannot push.
        """
        import numpy as np

        stretch = np.asarray(length, dtype=float) / rest_length
        area = np.pi * self.diameter**2 / 4
        shape = 3 * stretch**2 / np.tan(self.braid_angle) ** 2 - 1 / np.sin(self.braid_angle) ** 2
        return np.asarray(pressure, dtype=float) * area * np.maximum(shape, 0.0)

    def slope(self, pressure: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return dF/dL [N/m] of `force` at constant pressure: the stiffness of a muscle at constant pressure."""
        import numpy as np

        stretch = np.asarray(length, dtype=float) / rest_length
        area = np.pi * self.diameter**2 / 4
        slope = np.asarray(pressure, dtype=float) * area * 6 * stretch / (np.tan(self.braid_angle) ** 2 * rest_length)
        return np.where(self.force(1.0, length, rest_length) > 0, slope, 0.0)
