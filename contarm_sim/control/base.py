"""What a controller is: it turns bends into controls beforehand, and may correct them by what it sees."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np

from contarm_sim.errors import InputError, NotConvergedError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import as_number
from contarm_sim.paths.reference import Reference

if TYPE_CHECKING:
    from contarm_sim.engine.plant import Plant

SETTLED = 1e-9
"""Largest change of a correction, over the largest control, that counts as none."""


@dataclass(frozen=True)
class Plan:
    """What a controller works from, computed for all samples at once.

    Attributes:
        lengths: muscle lengths asked for [m], shape (T, n).
        setpoint: controls before feedback, shape (T, n): length changes [m], pressures [Pa] or tensions [N].
        start: controls that hold the first sample at rest, shape (n,).
    """

    lengths: Array
    setpoint: Array
    start: Array

    def __post_init__(self) -> None:
        for name in ("lengths", "setpoint", "start"):
            try:
                object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))
            except (TypeError, ValueError):
                raise InputError(f"plan.{name}", getattr(self, name), "an array of numbers") from None

    def checked(self, count: int, muscles: int) -> Self:
        """Return the plan, if it is one of so many samples and muscles.

        Raises:
            InputError: arrays of other shapes, or numbers that are not finite.
        """
        shapes = {"lengths": (count, muscles), "setpoint": (count, muscles), "start": (muscles,)}
        for name, shape in shapes.items():
            array = getattr(self, name)
            if np.shape(array) != shape:
                raise InputError(f"plan.{name}", f"of shape {np.shape(array)}", f"an array of shape {shape}")
            if not np.isfinite(array).all():
                raise InputError(f"plan.{name}", "not finite everywhere", "finite numbers")
        return self


@dataclass(slots=True)
class Seen:
    """What a feedback sees. Lists and array change with the arm: copy what must last.

    Attributes:
        lengths: of the muscles [m], n numbers.
        speeds: their rates [m/s], lengthening > 0.
        tensions: of servos and of damping along the muscles [N], pulling > 0.
        pulls: of the servos alone [N], pulling > 0.
        tip: position [m], shape (3,).
    """

    lengths: list[float]
    speeds: list[float]
    tensions: list[float]
    pulls: list[float]
    tip: Array

    @classmethod
    def of(cls, plant: Plant) -> Seen:
        """Return what there is to see of a plant now."""
        lengths, tensions = plant.muscle_lengths.tolist(), plant.actuator_tensions.tolist()
        return cls(lengths, plant.data.ten_velocity.tolist(), tensions, plant.servo_pulls.tolist(), plant.centres[-1])


Memory = tuple[Array, ...]
"""What a feedback has summed up so far; assigned to another of its kind, that goes on from there."""


class Feedback(ABC):
    """Slow corrections of controls.

    `value` is added to the plan's controls. `update` is called once a control tick, with gain = tick / `time`; at rest
    with gain 1, until nothing changes. All that is summed up belongs into `memory`: a simulation takes it over from one
    feedback to another.

    Attributes:
        time: time constant [s].
        value: the present correction, shape (n,), in the controls' unit; changed in place.
    """

    def __init__(self, time: float, muscles: int) -> None:
        self.time = time
        self.value: Array = np.zeros(muscles)

    @abstractmethod
    def update(self, index: int, seen: Seen, gain: float) -> None:
        """Integrate one interval of sample `index`: change `value` in place."""

    @property
    def memory(self) -> Memory:
        """What has been summed up; override both if that is more than `value`."""
        return (self.value.copy(),)

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self.value[:] = memory[0]


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

    def checked_limits(self, arm: Arm) -> tuple[float, float]:
        """Return the lowest and the highest control; without limits, infinite ones.

        Raises:
            InputError: the lowest is above the highest, or one is no number.
        """
        limits = self.limits(arm)
        numbers = (
            (-np.inf, np.inf) if limits is None else tuple(map(as_number, np.ravel(np.array(limits, dtype=object))))
        )
        if len(numbers) != 2 or not numbers[0] <= numbers[1]:
            raise InputError("limits", limits, "the lowest and the highest control")
        return numbers[0], numbers[1]

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

    def limits(self, arm: Arm) -> tuple[float, float] | None:
        """Return the lowest and the highest control there may be, or None; here, what the muscles can take."""
        if self.actuation == "pressures":
            return 0.0, arm.muscle.max_pressure
        return (0.0, arm.muscle.blocked_force) if self.actuation == "tensions" else None

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
