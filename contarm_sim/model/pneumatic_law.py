"""What a pneumatic muscle law is: how a muscle pulls by its pressure and its length."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from contarm_sim.errors import InputError
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.parameters import check_numbers

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray


@dataclass(frozen=True, kw_only=True)
class PneumaticLaw(MuscleLaw):
    """The law of one pneumatic muscle; the length servo stands for its valve and controller.

    Its force must be proportional to the pressure: force by pascal is `force(1, ...)`.

    Attributes:
        min_pressure, max_pressure: lowest gauge pressure when inflated, and highest [Pa].
        max_contraction: contraction from the rest length at which the force vanishes [-].
        mount_contraction: contraction in the straight arm [-].
        passive_stiffness: of the silicone beyond its rest length [N/m], or None.
        braid_friction: dry friction along the muscle [N], or None.
        valve_time: time constant of valve and filling [s].
    """

    if TYPE_CHECKING:  # fields of each law
        min_pressure: float
        max_pressure: float
        max_contraction: float
        mount_contraction: float
        passive_stiffness: float | None
        braid_friction: float | None
        valve_time: float
        min_tension: float
        servo_stiffness: float | None
        servo_time: float | None

    @property
    @abstractmethod
    def max_stretch(self) -> float:
        """Largest strain from the rest length [-]."""

    @property
    @abstractmethod
    def blocked_force(self) -> float:
        """Force at rest length and highest pressure [N]."""

    @property
    def pressure_limits(self) -> tuple[float, float]:
        """Lowest gauge pressure when inflated, and highest [Pa]."""
        return self.min_pressure, self.max_pressure

    @property
    def dry_friction(self) -> float | None:
        """Dry friction of braid and guides [N], or None."""
        return self.braid_friction

    @abstractmethod
    def force(self, pressure: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the pulling force [N], 0 or more, at a gauge pressure [Pa] and a length [m]."""

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
        super().check()

    def pressure_for(self, tension: Any, length: Any, rest_length: float) -> NDArray[float64]:
        """Return the gauge pressure [Pa] at which a muscle of a length [m] has a tension [N], its silicone's included.

        0 where that alone pulls more; inf where no pressure does it.
        """
        import numpy as np

        per_pascal = self.force(1.0, length, rest_length)
        wanted = np.maximum(np.asarray(tension, dtype=float) - self.passive_tension(length, rest_length), 0.0)
        out = np.full(np.broadcast(wanted, per_pascal).shape, np.inf)
        return np.divide(wanted, per_pascal, out=out, where=per_pascal > 0)


def as_pneumatic(law: MuscleLaw) -> PneumaticLaw:
    """Return a law, for callers that need its pressures.

    Raises:
        InputError: it has none.
    """
    if not isinstance(law, PneumaticLaw):
        given = f"'pressures' with the law {type(law).__name__}, which has none"
        raise InputError("actuation", given, "lengths, tensions, or a pneumatic law, such as mckibben")
    return law
