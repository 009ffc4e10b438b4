"""`hold`: keep a bend and a stiffness while a wrench pulls at the tip; for arms of one section.

The wrench is a dead force (up to 0.3 N any way) and couple (up to 20 mN m) in the base frame, from the start and all
the time. Asked for are a bend up to 80 deg, as the three muscle lengths measure it (its error is given as what it moves
the straight arm's tip by, half a length per radian), and a bending stiffness: the least eigenvalue of
EI/L0 + J^T diag(dT/dL) J, the McKibben muscles' own slopes at their pressures, J at the bend asked for. It is drawn
from what 90 to 700 kPa allow at that bend under that wrench; what they cannot hold is shrunk until they can.

    quantity            size  unit     scaled by
    bend_asked          2     rad      pi
    bend_error          2     rad      pi / 4; asked minus measured
    force               3     N        0.3 N
    couple              3     N m      0.02 N m
    stiffness_asked     1     N m/rad  that of the straight arm at the highest pressure
    stiffness           1     N m/rad  the same; measured
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from contarm_sim.envs.actions import Mode
from contarm_sim.envs.state import State, bend_shown
from contarm_sim.envs.task import LIMIT, Goals, Task, even_bend, even_direction, norm
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.moments import wrench_moment
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope
from contarm_sim.mechanics.pressures import level_range
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import Balance, balance
from contarm_sim.model.arm import Arm
from contarm_sim.model.pneumatic_law import PneumaticLaw

MAX_BEND = float(np.radians(80))
MAX_FORCE, MAX_COUPLE = 0.3, 0.02
"""Largest force [N] and couple [N m]."""

SHARES = (0.1, 0.7)
"""Co-contraction that the stiffness asked for takes, as shares of what the limits of pressure leave."""

ROOM = 3.0
"""Co-contraction that a goal leaves between its limits, at least [N]."""


class Hold(Task):
    """Keep a bend and a stiffness under a wrench."""

    name: ClassVar[str] = "hold"
    time_limit: ClassVar[float] = 4.0
    aimless: ClassVar[bool] = True
    modes: ClassVar[tuple[Mode, ...]] = ("pressures",)
    drawn = ("bend", "force", "couple", "share")

    @classmethod
    def needs(cls, arm: Arm) -> str | None:
        """Say that the stiffness asked for is that of three muscles about one section."""
        fits = len(arm.sections) == 1 and arm.routings[0].count == 3 and isinstance(arm.laws[0], PneumaticLaw)
        return None if fits else "an arm of one section with three pneumatic muscles"

    def draw(self, random: np.random.RandomState) -> dict[str, Any]:
        """Draw bend [rad], force [N], couple [N m] and the share of co-contraction."""
        return {
            "bend": even_bend(random, MAX_BEND),
            "force": MAX_FORCE * random.random_sample() * even_direction(random),
            "couple": MAX_COUPLE * random.random_sample() * even_direction(random),
            "share": SHARES[0] + (SHARES[1] - SHARES[0]) * random.random_sample(),
        }

    def prepare(self, values: dict[str, Any], arm: Arm) -> Goals:
        """Shrink what pressures cannot hold, and find the stiffness to ask for."""
        bend, wrench, share = _checked(values)
        for _ in range(100):
            held = balance(bend, self.arm, load=wrench_moment(bend, wrench[:3], wrench[3:], self.arm))
            low, high = (level[..., 0] for level in level_range(held, self.arm))
            if high - low >= ROOM:
                break
            bend, wrench = 0.95 * bend, 0.95 * wrench
        else:
            raise InputError("arm", "one that pressures cannot hold straight", "an arm that they can")
        lengths, jacobian = _pose(bend, self.arm)
        asked = stiffness_at(held, low + share * (high - low), lengths, jacobian, self.arm)
        return {
            "bend": bend,
            "measured": bend_shown(lengths, self.arm),
            "wrench": wrench,
            "jacobian": jacobian,
            "asked": np.array([asked]),
            "elastic": np.array([arm.bending_stiffness / arm.length]),
        }

    def quantities(self, goals: Goals, state: State, tick: Array) -> dict[str, Array]:
        """Show what is asked for, the wrench, and what there is."""
        return {
            "bend_asked": goals["bend"],
            "bend_error": self._off(goals, state),
            "force": goals["wrench"][..., :3],
            "couple": goals["wrench"][..., 3:],
            "stiffness_asked": goals["asked"],
            "stiffness": self.stiffness(goals, state)[..., None],
        }

    @property
    def scales(self) -> dict[str, tuple[float, float]]:
        """See the table above."""
        arm = self.arm
        slope = float(force_slope(arm.pneumatics.max_pressure, arm.length, arm))
        most = arm.bending_stiffness / arm.length + 1.5 * arm.muscle_radius**2 * slope
        return {
            "bend_asked": (0.0, np.pi),
            "bend_error": (0.0, 0.25 * np.pi),
            "force": (0.0, MAX_FORCE),
            "couple": (0.0, MAX_COUPLE),
            "stiffness_asked": (0.0, most),
            "stiffness": (0.0, most),
        }

    def stiffness(self, goals: Goals, state: State) -> Array:
        """Return the bending stiffness that there is [N m/rad], shape (B,)."""
        lengths = state["muscle_lengths"]
        slopes = force_slope(state["pressures"], lengths, self.arm) + passive_slope(lengths, self.arm)
        return _least(goals["jacobian"], slopes, goals["elastic"][..., 0])

    def error(self, goals: Goals, state: State, tick: Array) -> Array:
        """Measure the error of the bend as what it moves the straight arm's tip by."""
        return 0.5 * self.arm.length * norm(self._off(goals, state))

    def quality(self, goals: Goals, state: State) -> Array:
        """Return the share of the stiffness asked for."""
        return np.minimum(self.stiffness(goals, state) / goals["asked"][..., 0], 1.0)

    def force(self, goals: Goals) -> Array:
        """Return the wrench."""
        return goals["wrench"]

    def _off(self, goals: Goals, state: State) -> Array:
        return goals["measured"] - bend_shown(state["muscle_lengths"], self.arm)


def _checked(values: dict[str, Any]) -> tuple[Array, Array, float]:
    bend = arc.as_bend(values["bend"])
    parts = [as_vectors(values[name], 3, name) for name in ("force", "couple")]
    share = values["share"]
    if bend.shape != (2,) or any(part.shape != (3,) for part in parts):
        raise InputError("bend, force, couple", "of other shapes", "shapes (2,), (3,) and (3,)")
    for name, part, most in zip(("force", "couple"), parts, (MAX_FORCE, MAX_COUPLE), strict=True):
        if np.abs(part).max() > LIMIT * most:
            raise InputError(name, part.tolist(), f"at most {LIMIT * most:g} each way, which is what can be observed")
    if isinstance(share, bool) or not isinstance(share, int | float) or not 0 <= share <= 1:
        raise InputError("share", share, "a number from 0 to 1")
    return bend, np.concatenate(parts), share


def _pose(bend: Array, arm: Arm) -> tuple[Array, Array]:
    """Return muscle lengths [m] and their derivative by the bend [m/rad] at a uniform bend."""
    return routing.lengths_from_bend(bend, arm), length_jacobian(bend, arm)


def _least(jacobian: Array, slopes: Array, elastic: Array | float) -> Array:
    """Return the least eigenvalue [N m/rad] of elastic + J^T diag(slopes) J, shape (...), term by term."""
    weighted = slopes[..., None] * jacobian
    entries = []
    for i, j in ((0, 0), (1, 1), (0, 1)):
        terms = weighted[..., i] * jacobian[..., j]
        entries.append(terms[..., 0] + terms[..., 1] + terms[..., 2])
    half = 0.5 * (entries[0] - entries[1])
    return elastic + 0.5 * (entries[0] + entries[1]) - np.sqrt(half * half + entries[2] * entries[2])


def stiffness_at(held: Balance, level: Any, lengths: Array, jacobian: Array, arm: Arm) -> float:
    """Return the bending stiffness [N m/rad] of a pose at a level of co-contraction [N]."""
    pressures = held.at(np.asarray(level)[..., None]) / held.per_pascal
    slopes = force_slope(pressures, lengths, arm) + passive_slope(lengths, arm)
    return float(_least(jacobian, slopes, arm.bending_stiffness / arm.length))
