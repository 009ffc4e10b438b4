"""What a case tells, each part found when a quantity first asks for it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import muscles, routing, shape
from contarm_sim.mechanics.pneumatics import pressure_for
from contarm_sim.model.arm import Arm
from contarm_sim.results.compare import Comparison, compare
from contarm_sim.results.summary import Spread
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.statics.equilibria import Equilibria
from contarm_sim.studies.explained import RodParts, explain
from contarm_sim.studies.judged_run import JudgedRun, judge_run
from contarm_sim.studies.load_cases import beyond
from contarm_sim.studies.scenarios import weight_over_stiffness
from contarm_sim.studies.timestep import TimeStep, step_summary
from contarm_sim.studies.trusted_bends import WITHIN, bend_within, bends_within_of_lost, have_enough


@dataclass(frozen=True, eq=False)
class Told:
    """What is known of every case."""

    arm: Arm

    @property
    def stable(self) -> bool:
        """Whether the arm stays where it is; of a pose at rest under a load it is found out."""
        return True

    @property
    def weight_over_stiffness(self) -> float:
        """(m + payload) g L^2/EI [-], as `contarm validate` has it."""
        return weight_over_stiffness(self.arm)

    @property
    def own_weight_over_stiffness(self) -> float:
        """m g L^2/EI [-], without payload."""
        return weight_over_stiffness(replace(self.arm, payload=0.0))

    @property
    def payload_over_mass(self) -> float:
        """Payload over the mass of the arm [-]."""
        return self.arm.payload / self.arm.mass


@dataclass(frozen=True, eq=False)
class Followed(Told):
    """Poses at rest, or a motion, beside the closed forms."""

    samples: Trajectory

    @cached_property
    def comparison(self) -> Comparison:
        """Sample by sample; of an arm that can touch something, with contact as a part of its own."""
        if self.arm.world.touchable and self._judged is not None:
            return self._judged.comparison
        return compare(self.samples)

    @cached_property
    def rod(self) -> RodParts:
        """What an ideal rod explains of the shape."""
        return self._judged.rod if self._judged else explain(self.samples, self.comparison).summary(self.arm)

    @cached_property
    def _judged(self) -> JudgedRun | None:
        """A motion as `contarm run` judges it; None of poses at rest, and where it cannot be."""
        try:
            return judge_run(self.samples) if self.samples.moving else None
        except ContarmError:
            return None

    @property
    def explained(self) -> bool | None:
        """Whether the motion is explained, as `contarm run` has it."""
        return None if self._judged is None else self._judged.judged.explained

    @cached_property
    def step(self) -> TimeStep:
        """The engine's step and its own error."""
        return step_summary(self.samples)

    @property
    def worst_bend(self) -> Array:
        """The bend at which the tip error is largest [rad], shape (2 S,)."""
        return np.asarray(self.samples.bend[int(self.comparison.tip_error.argmax())])

    def largest(self, part: str) -> float:
        """Return the largest of a distance [m] of the comparison."""
        return float(getattr(self.comparison, part).max())

    def rod_part(self, part: str) -> float | None:
        """Return the largest of a part that the rod explains [m]; None where there is none."""
        found: Spread | None = getattr(self.rod, part)
        return None if found is None else found.max_m

    def bend_within(self, percent: float) -> float | None:
        """Return the largest bend within a tip error [% of length], [rad]."""
        return bend_within(self.samples, percent)

    @property
    def pressure(self) -> float | None:
        """The highest pressure of muscles that have any [Pa]; inf where none does it."""
        return highest(self.samples.pressure, self.arm)

    @property
    def feasible(self) -> bool:
        """Whether muscles have the tensions and pressures."""
        return bool(have_enough(self.samples).all())


@dataclass(frozen=True, eq=False)
class Lost(Told):
    """Poses at rest that an arm with servos does not have, or not all of them.

    Attributes:
        bends: of the poses [rad], shape (T, 2 S).
    """

    bends: Array

    @cached_property
    def _within(self) -> dict[float, float | None]:
        return dict(zip(WITHIN, bends_within_of_lost(self.arm, self.bends, WITHIN), strict=True))

    def bend_within(self, percent: float) -> float | None:
        """Return the largest bend within a tip error [% of length], [rad], at most that where rest ends."""
        return self._within[percent]


@dataclass(frozen=True, eq=False)
class Rested(Told):
    """A pose at rest under a load: a row of `Equilibria`.

    Attributes:
        every, row: where it is, of cases that were solved together.
        bend: that the muscles ask for [rad], shape (2 S,); None where they ask for none.
    """

    every: Equilibria
    row: int
    bend: Array | None

    def of(self, name: str) -> Any:
        """Return the row of an array."""
        return getattr(self.every, name)[self.row]

    @property
    def stable(self) -> bool:
        """Whether disturbances die out."""
        return bool(self.of("stable"))

    @cached_property
    def tensions(self) -> Array:
        """Tensions of the arm's muscles [N], shape (n,)."""
        return np.asarray(self.of("muscle_tensions")[: muscles.count(self.arm)])

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the arm's muscles [m], shape (n,)."""
        return np.asarray(self.of("muscle_lengths")[: muscles.count(self.arm)])

    @cached_property
    def pressures(self) -> Array:
        """Pressures that the tensions need [Pa], shape (n,)."""
        return pressure_for(self.tensions, self.lengths, self.arm)

    @property
    def pressure(self) -> float | None:
        """The highest of them; None where muscles have none."""
        return highest(self.pressures, self.arm)

    @property
    def feasible(self) -> bool:
        """Whether muscles have the tensions and pressures."""
        return beyond(self.arm, self.tensions, self.pressures) == ""

    @property
    def held(self) -> bool | None:
        """Whether no length servo is at its limit; None where muscles are driven otherwise."""
        return bool(self.of("held")) if self.every.loads[self.row].muscles.kind in ("deltas", "bend") else None

    @property
    def tip_error(self) -> float | None:
        """Distance from the tip of the arcs that were asked for [m]; None where no bend was."""
        return None if self.bend is None else self._from(self.bend)

    @property
    def shape_error(self) -> float | None:
        """Distance from the tip of arcs with the muscle lengths as they are [m]; None where no arcs have them."""
        try:
            return self._from(routing.bend_from_lengths(self.lengths, self.arm)[0])
        except InputError:
            return None

    def _from(self, bend: Array) -> float:
        return float(np.linalg.norm(self.of("tip") - shape.position(bend, self.arm)))

    @property
    def compliance(self) -> float:
        """How far the tip gives way at most to a force [m/N]."""
        return float(np.linalg.norm(self.of("tip_compliance")[:3, :3], 2))


def highest(pressures: Array, arm: Arm) -> Any:
    """Return the highest pressure [Pa] of muscles that have any; None where none has."""
    pressed = _pressed(arm)
    return float(pressures[..., pressed].max()) if pressed.any() else None


def has_pressure(arm: Arm) -> bool:
    """Whether some of an arm's muscles have pressure."""
    return bool(_pressed(arm).any())


def _pressed(arm: Arm) -> NDArray[np.bool_]:
    return np.isfinite(muscles.each(arm, lambda group: group.law.pressure_limits[1]))
