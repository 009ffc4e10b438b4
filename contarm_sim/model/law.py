"""What a muscle law is: how a pneumatic muscle pulls, by its pressure and its length."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from contarm_sim.errors import InputError
from contarm_sim.model.parameters import check_numbers

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class MuscleLaw(ABC):
    """The law of one pneumatic muscle, and the length servo that stands for its valve and controller.

    A law is a frozen dataclass that subclasses this one and declares the attributes below as its fields (with
    `parameters.number`), and calls `check` when it is made. Its force must be proportional to the pressure: force by
    pascal is `force(1, ...)`. Its methods take pressures [Pa] and lengths [m] as arrays, broadcast, and load NumPy when
    they are called: parameters alone are made without it.

    Attributes:
        min_pressure, max_pressure: lowest gauge pressure when inflated, and highest [Pa].
        max_contraction: contraction from the rest length at which the force vanishes [-].
        mount_contraction: contraction in the straight arm [-].
        min_tension: tension that the slackest muscle is held at [N].
        passive_stiffness: of the silicone beyond its rest length [N/m], or None.
        braid_friction: dry friction along the muscle [N], or None.
        valve_time: time constant of valve and filling [s].
        servo_stiffness, servo_time: of the length servo [N/m], [s], or None for what follows from the arm.
    """

    if TYPE_CHECKING:  # each law declares its own fields, in its own order, with defaults and limits
        min_pressure: float
        max_pressure: float
        max_contraction: float
        mount_contraction: float
        min_tension: float
        passive_stiffness: float | None
        braid_friction: float | None
        valve_time: float
        servo_stiffness: float | None
        servo_time: float | None

    @property
    @abstractmethod
    def diameter(self) -> float:
        """Outer diameter at rest [m]."""

    @property
    @abstractmethod
    def max_stretch(self) -> float:
        """Largest strain from the rest length [-]."""

    @property
    @abstractmethod
    def blocked_force(self) -> float:
        """Force at rest length and highest pressure [N]."""

    @abstractmethod
    def force(self, pressure: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the pulling force [N], 0 or more."""

    @abstractmethod
    def slope(self, pressure: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return dF/dL [N/m] of `force` at constant pressure."""

    def check(self) -> None:
        """Check the fields' numbers, and that they fit together.

        Raises:
            InputError: names the first that does not.
        """
        check_numbers(self, "muscle.")
        if self.min_pressure >= self.max_pressure:
            raise InputError("muscle.min_pressure", self.min_pressure, f"below max_pressure ({self.max_pressure:g} Pa)")
        if self.mount_contraction >= self.max_contraction:
            raise InputError(
                "muscle.mount_contraction", self.mount_contraction, f"below max_contraction ({self.max_contraction:g})"
            )
        if self.min_tension >= self.blocked_force:
            raise InputError(
                "muscle.min_tension", self.min_tension, f"below the blocked force, {self.blocked_force:.4g} N"
            )

    def pressure_for(self, tension: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the gauge pressure [Pa] at which a muscle of a length [m] has a tension [N], its silicone's included.

        0 where that alone pulls more; inf where no pressure does it.
        """
        import numpy as np

        per_pascal = self.force(1.0, length, rest_length)
        wanted = np.maximum(np.asarray(tension, dtype=float) - self.passive_tension(length, rest_length), 0.0)
        out = np.full(np.broadcast(wanted, per_pascal).shape, np.inf)
        return np.divide(wanted, per_pascal, out=out, where=per_pascal > 0)

    def passive_tension(self, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the tension [N] of the silicone alone: a spring beyond the rest length, slack below."""
        import numpy as np

        stretch = np.maximum(np.asarray(length, dtype=float) - rest_length, 0.0)
        return np.asarray((self.passive_stiffness or 0.0) * stretch)

    def passive_slope(self, length: Any, rest_length: float) -> NDArray[float64]:
        """Return dF/dL [N/m] of `passive_tension`."""
        import numpy as np

        return np.where(np.asarray(length) > rest_length, self.passive_stiffness or 0.0, 0.0)
