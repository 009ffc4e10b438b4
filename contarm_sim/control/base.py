"""What a controller is: it turns bends into controls beforehand, and may correct them by what it sees."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from contarm_sim.control.feedback import Feedback, Seen
from contarm_sim.control.plan import Plan
from contarm_sim.errors import InputError, NotConvergedError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import count, each
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number
from contarm_sim.paths.reference import Reference

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant
    from contarm_sim.statics.rested import Rested

Samples = NDArray[np.integer]
"""Numbers of samples."""

SETTLED = 1e-9
"""Largest change of a correction, over the largest control, that counts as none."""


class Controller(ABC):
    """Drives an arm along a reference. Subclass it, give `plan`, and pass an object of it to `simulate`.

    The simulation asks once for the `plan`, and for the `feedback` before every pass over the motion: it may simulate a
    motion again in shorter steps. It then sends, every control tick, plan.setpoint[i] + feedback.value to the muscles,
    cut to the `limits`, and lets the feedback see the arm. Between two ticks controls move in a straight line.

    Class attributes:
        name: what it is called in results.
        actuation: what its controls are: `lengths` (length changes of servos from the straight arm [m]), `pressures`
            (gauge [Pa]) or `tensions` [N].
        pulls_only: whether muscles are limited to pulling; False lets servos push.
        holds_lengths: whether it means muscle lengths to be those of the bend; False where it shifts them on purpose.
    """

    name: ClassVar[str] = "own"
    actuation: ClassVar[Literal["lengths", "pressures", "tensions"]] = "lengths"
    pulls_only: ClassVar[bool] = True
    holds_lengths: ClassVar[bool] = True

    @abstractmethod
    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return lengths and controls of all samples; `reference.moving` tells a motion from poses at rest.

        Raises:
            InputError: a bend that these muscles cannot hold.
        """

    def feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback | None:
        """Return what corrects the plan's controls, a new one at each call, or None."""
        return None

    def about(self) -> dict[str, Any]:
        """Return what a trajectory keeps of its controller."""
        return {
            "controller": self.name, "actuation": self.actuation, "pulls_only": self.pulls_only,
            "holds_lengths": self.holds_lengths,
        }  # fmt: skip

    def unplanned(self) -> Controller:
        """Return what to use where a motion is not known in advance, as on the live page; here, the same."""
        return self

    def checked_plan(self, arm: Arm, reference: Reference, muscles: int) -> Plan:
        """Return the plan, if it is one for so many muscles.

        Raises:
            InputError: it is none, or does not fit.
        """
        plan = self.plan(arm, reference)
        expect("plan", plan, Plan)
        return plan.checked(len(reference), muscles)

    def checked_limits(self, arm: Arm) -> tuple[Array, Array]:
        """Return the lowest and the highest control of each muscle, shape (n,); without limits, infinite ones.

        Raises:
            InputError: the lowest is above the highest, or one is no number.
        """
        limits, muscles = self.limits(arm), count(arm)
        try:
            low, high = (
                np.broadcast_to([as_number(x) for x in np.ravel(np.array(limit, dtype=object))], muscles)
                for limit in ((-np.inf, np.inf) if limits is None else limits)
            )
        except (TypeError, ValueError):
            low = high = np.full(muscles, np.nan)
        if not np.all(low <= high):
            raise InputError("limits", limits, "the lowest and the highest control")
        return low, high

    def checked_feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback | None:
        """Return the feedback, if its correction and time constant can be.

        Raises:
            InputError: says which cannot.
        """
        feedback = self.feedback(arm, reference, plan)
        if feedback is None:
            return None
        expect("feedback", feedback, Feedback)
        value, shape = feedback.value, plan.start.shape
        if not isinstance(value, np.ndarray) or value.dtype != float or value.shape != shape:
            raise InputError("feedback.value", f"of shape {np.shape(value)}", f"an array of floats, {shape}")
        if not 0 < feedback.time < np.inf:
            raise InputError("feedback.time", feedback.time, "a positive time [s]")
        return feedback

    def limits(self, arm: Arm) -> tuple[Any, Any] | None:
        """Return the lowest and the highest control there may be, or None; here, what the muscles can take.

        Each is a number, or one for each muscle, shape (n,).
        """
        if self.actuation == "pressures":
            return 0.0, each(arm, lambda group: group.pneumatics.max_pressure)
        return (0.0, each(arm, lambda group: group.law.blocked_force)) if self.actuation == "tensions" else None

    def resting(self, plant: Plant, reference: Reference) -> Callable[[int], Array]:
        """Return a function that brings a plant to rest in a sample, and returns the controls that hold it.

        It starts from the plant's pose. Here, the plan is sent and the feedback called until it changes nothing.

        Raises:
            EquilibriumError: from the function: the arm has no pose at rest there; says why.
        """
        from contarm_sim.statics.solver import Solver

        arm, settle = plant.arm, Solver(plant)
        plan = self.checked_plan(arm, reference, plant.control.shape[1])
        low, high = self.checked_limits(arm)

        def rest(index: int) -> Array:
            setpoint = plan.setpoint[index].clip(low, high)
            settle(setpoint)
            feedback = self.checked_feedback(arm, reference, plan)
            return setpoint if feedback is None else self._corrected(plant, settle, setpoint, feedback, index)

        return rest

    def resting_together(self, plant: Plant, reference: Reference) -> Callable[[Samples], Rested] | None:
        """Return a function that finds rest and controls of many samples at once, or None.

        It finds what that of `resting` finds, to the bit, and leaves out samples that take more care. A class that
        has its own `resting`, and not this, has its samples solved one by one.
        """
        if type(self).feedback is not Controller.feedback:
            return None
        from contarm_sim.statics.rested import settled

        plan = self.checked_plan(plant.arm, reference, plant.control.shape[1])
        low, high = self.checked_limits(plant.arm)

        def rest(samples: Samples) -> Rested:
            return settled(plant, reference.bend[samples], plan.setpoint[samples].clip(low, high))

        return rest

    def _corrected(
        self, plant: Plant, settle: Callable[[Array], float], setpoint: Array, feedback: Feedback, index: int
    ) -> Array:
        low, high = self.checked_limits(plant.arm)
        sent, most = setpoint, 2000
        for _ in range(most):
            feedback.update(index, Seen.of(plant), 1.0)
            before, sent = sent, np.clip(setpoint + feedback.value, low, high)
            if np.isnan(sent).any():
                raise InputError("feedback.value", "not a number", "finite corrections of the controls")
            settle(sent)
            if np.abs(sent - before).max() <= SETTLED * max(1e-3, float(np.abs(sent).max())):
                return sent
        left = float(np.abs(sent - before).max())
        reason = f"the feedback of controller {self.name!r} still changes its controls by {left:.3g} after {most} steps"
        raise NotConvergedError(reason, left, SETTLED, pose=plant.data.qpos.copy(), residual=0.0)
