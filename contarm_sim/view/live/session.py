"""The arm under a hand that moves: the same controllers as `simulate`, tick by tick, towards a goal that changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from contarm_sim.control.feedback import Feedback, Seen
from contarm_sim.control.plan import Plan
from contarm_sim.control.registry import controller as resolved
from contarm_sim.engine.plant import Plant
from contarm_sim.engine.recorder import touched
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import pneumatics, routing, shape
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.mechanics.muscles import each, slices
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import cocontraction
from contarm_sim.mjcf.overlaps import STRAIGHT, refuse_overlaps
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import CONTROL_RATE
from contarm_sim.motion.time_step import stable_substeps
from contarm_sim.paths.reference import Reference
from contarm_sim.view.live.recording import Recording

PERIOD = 1 / CONTROL_RATE
"""Simulated time of a control tick of up to three sections [s]; of more it is twice that: a tick costs more time."""

_QUICK = 3
"""Sections whose control takes about half of `PERIOD`."""

_LAG = 0.2  # s, of each of two stages: a hand's jump becomes a motion that muscles can follow
_FASTEST = 2.0  # rad/s
_ON_ITS_WAY = 0.05  # rad, nearer to the goal, or farther, than where it was refused: it is followed again


@dataclass(frozen=True)
class Reading:
    """The arm at one moment.

    Attributes:
        time: simulated time [s].
        goal: bend asked for [rad], shape (2 S,) of S sections.
        bend: bend commanded now, on its way to the goal [rad], shape (2 S,).
        analytic, tip: tip of the arcs at that bend, and of the simulated arm [m], shape (3,).
        tensions: of the muscles [N], shape (n,).
        pressures: that give real muscles these tensions, inf where none does; under `pressure` those behind the
            valves [Pa], shape (n,).
        contact: sum of the sizes of all contact forces [N]; 0 where nothing can be touched.
    """

    time: float
    goal: Array
    bend: Array
    analytic: Array
    tip: Array
    tensions: Array
    pressures: Array
    contact: float = 0.0

    @property
    def error(self) -> float:
        """Distance from the simulated to the analytic tip [m]."""
        return float(np.linalg.norm(self.tip - self.analytic))


class Session:
    """A simulated arm that is told where to bend while it runs.

    Args:
        arm: its parameters.
        controller: paper, chain, feedforward, servo, pressure, or tip: servo with the seen tip fed back (`simulate`
            also plans the motion for it, which takes the motion in advance).

    Attributes:
        arm, controller, plant: the current ones; `change` replaces them.
        period: simulated time of a tick [s].
        goal: bend asked for [rad], shape (2 S,) of S sections.
        problem: why the goal is not followed, or "".
        trouble: what else went wrong, or "", for whoever shows it to say and to forget.
        reading: of the last tick.
        recording: takes a sample of every tick, or None; `change`, `reset` and `restart` end it.
    """

    def __init__(self, arm: Arm, controller: str = "servo") -> None:
        self._feedback: Feedback | None = None
        self.recording: Recording | None = None
        self.trouble = ""
        self._start(arm, controller)
        self.reset()

    def restart(self, arm: Arm) -> None:
        """Take another arm, straight and still at time 0; with length servos if the controller does not suit it.

        Raises:
            InputError: an arm that no time step suits; nothing is changed.
        """
        try:
            self._start(arm, self.controller)
        except InputError:
            self._start(arm, "servo")
        self.reset()

    def record(self) -> None:
        """Begin to record."""
        self.recording = Recording(self.plant, self._driver.about(), self.period)

    def reset(self) -> None:
        """Stand straight and still, at time 0, and stay so."""
        self._end_recording()
        size = 2 * len(self.arm.sections)
        self.goal, self.problem = np.zeros(size), ""
        self._ahead, self._speed, self._feedback = np.zeros((3, size)), np.zeros(size), None
        self._stuck = np.inf  # what was left to the goal where it was last refused [rad]
        self.plant.reset(self.goal)
        mujoco.mj_forward(self.plant.model, self.plant.data)
        self._sent = self.plant.control[0].copy()
        self.reading = self._read()

    def aim(self, bend: Array) -> None:
        """Go to a bend [rad], shape (2 S,), each section's cut to `LARGEST_BEND`."""
        bends = shape.bends_of(shape.as_coordinates(bend, self.arm), self.arm)
        self.goal = (bends * np.minimum(1.0, LARGEST_BEND / np.maximum(_angles(bends), 1e-12))[:, None]).reshape(-1)

    def change(self, arm: Arm | None = None, controller: str | None = None) -> None:
        """Take other parameters or another controller from here on; the pose and its speed stay.

        Raises:
            InputError: another number of links, an unknown controller, or an arm that no time step suits; nothing is
                changed.
        """
        arm, controller = arm or self.arm, controller or self.controller
        if _joints(arm) != _joints(self.arm):
            raise InputError("links", arm.links, "the same joints as before: start again for others")
        self._end_recording()
        before, same = self.plant, controller == self.controller
        self._start(arm, controller)
        for name in ("qpos", "qvel", "time"):
            setattr(self.plant.data, name, getattr(before.data, name))
        if not same:
            self._feedback = None
        if self.plant.pressure.shape == before.pressure.shape:
            self.plant.pressure[:] = before.pressure
        else:  # between servos and muscles: go on with the tensions that there were, as far as pressures can
            self._sent = self._takes_over(before)
        mujoco.mj_forward(self.plant.model, self.plant.data)
        self.reading = self._read()

    def _start(self, arm: Arm, controller: str) -> None:
        arm.refuse_memory("the live view moves arms")
        driver = resolved(controller).unplanned()
        plant = alone = Plant(arm.alone, driver.pulls_only, actuation=driver.actuation)
        if arm.world.touchable:
            plant = Plant(arm, driver.pulls_only, actuation=driver.actuation, in_world=True)
            plant.reset()
            mujoco.mj_forward(plant.model, plant.data)
            refuse_overlaps(arm, plant.model, plant.data, STRAIGHT)
        self.period = PERIOD * -(-len(arm.sections) // _QUICK)
        self._substeps = stable_substeps(alone, 1 / self.period, np.empty((0, 2)), arm.world.host)
        plant.own.step_by(self.period / self._substeps)
        self.plant, self.arm, self.controller, self._driver = plant, arm, controller, driver

    def _end_recording(self) -> None:
        """A recording is of one arm, one controller, and one motion."""
        if self.recording is not None:
            self.recording.ended = True

    def _takes_over(self, before: Plant) -> Array:
        """Return set-points with which the arm is bent as by the plant before, whose controls were of another kind."""
        arm, tensions, lengths = self.arm, before.actuator_tensions, before.muscle_lengths
        if not len(self.plant.pressure):
            return servo_control(lengths, tensions, arm)
        bend, _ = routing.bend_from_lengths(lengths, arm)
        per_pascal = np.maximum(pneumatics.force(1.0, lengths, arm), 1e-9)
        lowest = each(arm, lambda group: group.law.pressure_limits[0])
        highest = each(arm, lambda group: group.law.pressure_limits[1])
        for level, own in reversed(list(zip(cocontraction(bend, arm), slices(arm), strict=True))):
            # Enough of it that no pressure is too low; from the tip on, for muscles load all sections that they cross.
            tensions = tensions + level * ((lowest * per_pascal - tensions)[own] / level[own]).max()
        self.plant.pressure[:] = np.clip(tensions / per_pascal, lowest, highest)
        return self.plant.pressure[0].copy()

    def tick(self) -> Reading:
        """Step one control period towards the goal and return what was so at its beginning.

        Raises:
            DivergenceError: the arm is straight and still again, as after `reset`.
        """
        self._move_on()
        try:
            reference = self._reference()
            plan = self._driver.plan(self.arm, reference)
            if abs(self._way - self._stuck) > _ON_ITS_WAY:
                self.problem = ""
        except InputError as error:  # wait where the muscles still hold
            self._ahead[:], self._speed[:] = self._ahead[0], 0.0
            self.problem, self._stuck = str(error), self._way
            plan = None
        end = self._sent if plan is None else self._with_feedback(plan, reference)
        model, data, control = self.plant.model, self.plant.data, self.plant.control
        for i in range(self._substeps):
            control[:] = self._sent + i / self._substeps * (end - self._sent)
            mujoco.mj_step(model, data)
            if i == 0:
                if self.recording is not None:
                    self.recording.take(self._ahead[0], self._sent)
                self.reading = self._read()
                if plan is not None:
                    self._correct()
        self._sent = end
        try:
            self.plant.check({"controller": self.controller})
        except DivergenceError:
            self.reset()
            raise
        return self.reading

    def _move_on(self) -> None:
        """Shift the three bends commanded at the beginning of this tick, of the next, and of the one after."""
        speed = self._speed + self.period * ((self.goal - self._ahead[2]) / _LAG**2 - 2 * self._speed / _LAG)
        self._speed = speed * min(1.0, _FASTEST / max(float(_angles(speed).max()), 1e-12))
        self._ahead = np.vstack([self._ahead[1:], self._ahead[2] + self.period * self._speed])

    @property
    def _way(self) -> float:
        """What is left to the goal [rad]."""
        return float(_angles(self.goal - self._ahead[2]).max())

    def _reference(self) -> Reference:
        return Reference.from_bends(self._ahead, self.arm, self.period * np.arange(3))

    def _with_feedback(self, plan: Plan, reference: Reference) -> Array:
        """Return the set-points of the end of this tick, corrected by what was seen up to now."""
        before = self._feedback
        self._feedback = self._driver.feedback(self.arm, reference, plan)
        if self._feedback is None:
            return plan.setpoint[1]
        if before is not None:
            self._feedback.memory = before.memory
        end = plan.setpoint[1] + self._feedback.value
        limits = self._driver.limits(self.arm)
        return end if limits is None else end.clip(*limits)

    def _correct(self) -> None:
        """Let the feedback see the beginning of this tick."""
        if self._feedback is not None:
            seen = Seen.of(self.plant)
            self._feedback.update(0, seen, self.period / self._feedback.time)

    def _read(self) -> Reading:
        plant, bend = self.plant, self._ahead[0]
        tensions = plant.muscle_tensions
        if len(plant.pressure):
            pressures = plant.pressure[0].copy()
        else:
            pressures = pneumatics.pressure_for(tensions, plant.muscle_lengths, self.arm)
        return Reading(
            float(plant.data.time), self.goal.copy(), bend.copy(), shape.position(bend, self.arm), plant.tip,
            tensions, pressures, self._pressed(),
        )  # fmt: skip

    def _pressed(self) -> float:
        """Return the sum of the sizes of all contact forces [N]."""
        found = self.contacts
        return 0.0 if found is None else float(found.total(1)[0])

    @property
    def contacts(self) -> Contacts | None:
        """What the arm touches now, all of one sample; None where it can touch nothing."""
        found: Contacts | None = self._felt().get("contacts")
        return found

    @property
    def poses(self) -> Array:
        """Where the free objects are now, see `Trajectory.objects`, shape (F, 7)."""
        return np.asarray(self._felt().get("objects", np.zeros((1, 0, 7)))[0])

    def _felt(self) -> dict[str, Any]:
        return touched(self.plant.data.sensordata[None], self.plant.index, self.arm)


def _angles(bend: Array) -> Array:
    """Return the sizes of bends [rad], shape (S,), of all sections' coordinates."""
    x, y = bend.reshape(-1, 2).T
    return np.hypot(x, y)


def _joints(arm: Arm) -> list[tuple[int, bool]]:
    """Return what decides the joints of each section: their number, and whether they twist."""
    return [(section.links, section.torsional_stiffness is None) for section in arm.sections]
