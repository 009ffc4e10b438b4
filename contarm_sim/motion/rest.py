"""Poses of the simulated arm at rest under commanded bends, corrected as the controller in motion would."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property

import mujoco
import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import ControllerName
from contarm_sim.control.registry import controller as resolved
from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.engine.recorder import Recorder
from contarm_sim.errors import EquilibriumError, InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.pneumatics import pressure_for
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.versions import versions


def poses_at_rest(
    arm: Arm,
    reference: Reference,
    controller: ControllerName | Controller = "servo",
    ticks: Iterable[int] | None = None,
) -> Trajectory:
    """Return the arm's poses at rest under commanded bends, whatever the reference's times.

    Args:
        ticks: an iterable over range(T), for progress.

    Raises:
        EquilibriumError: no equilibrium that the arm or its muscles can hold; says why.
        InputError: a reference of another arm's length, or a bend that pulling muscles, or pressures, cannot hold.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("poses at rest are found")
    expect("reference", reference, Reference)
    reference.check_arm(arm)
    chosen, still = resolved(controller), reference.at_rest()
    plant = Plant(arm, chosen.pulls_only, actuation=chosen.actuation)
    count, bend = len(still), still.bend
    recorder, setpoint = Recorder(plant, count), np.empty((count, plant.control.shape[1]))
    with engine_room():
        find, felt = _Finder(chosen, plant, still), {}
        for i in ticks if ticks is not None else range(count):
            setpoint[i] = find(i)
            recorder.take(i)
            felt[i] = (plant.muscle_lengths, plant.muscle_tensions) if plant.twisted is not None else ()
    if sorted(felt) != list(range(count)):
        raise InputError("ticks", f"an iterable over {len(felt)} poses", f"one over all of range({count})")
    measured = recorder.arrays(count)
    if plant.twisted is not None:  # the engine's tendons do not feel what twist adds to the muscles
        lengths, tensions = (np.array(each) for each in zip(*(felt[i] for i in range(count)), strict=True))
        measured |= {"muscle_lengths": lengths, "muscle_tensions": tensions}
        measured["pressure"] = pressure_for(tensions, lengths, arm)
    return Trajectory(
        arm=arm, **chosen.about(), status="at rest",
        time=still.time, target=still.target, bend=bend, direction=still.direction, setpoint=setpoint, **measured,
        versions=versions(),
    )  # fmt: skip


TOGETHER = 64
"""Samples that are looked for at once."""


class _Finder:
    """Brings a plant to rest in one sample after the other, those that follow looked for at once where that goes."""

    def __init__(self, controller: Controller, plant: Plant, reference: Reference) -> None:
        self._controller, self._plant, self._reference = controller, plant, reference
        self._found: dict[int, tuple[Array, Array]] = {}
        self._looked: set[int] = set()
        alike = _home(controller, "resting") is _home(controller, "resting_together")
        self._together = controller.resting_together(plant, reference) if alike else None

    def __call__(self, index: int) -> Array:
        """Derive all of a sample at rest, and return the controls that hold it."""
        plant = self._plant
        if self._together is not None and index not in self._looked:
            samples = np.arange(index, min(index + TOGETHER, len(self._reference)))
            self._looked.update(samples.tolist())
            found = self._together(samples)
            which = samples[found.samples].tolist()
            self._found.update(zip(which, zip(found.qpos, found.setpoint, strict=True), strict=True))
        if index in self._found:
            qpos, setpoint = self._found.pop(index)
            plant.restart(qpos, setpoint)
            return setpoint
        bend = self._reference.bend[index]
        plant.reset(bend)
        try:
            setpoint = self._alone(index)
        except EquilibriumError as error:
            arm = plant.arm
            raise error.located(f"at {shape.described(bend, arm)} with {arm.links} links") from None
        mujoco.mj_forward(plant.model, plant.data)  # the sensors
        return setpoint

    @cached_property
    def _alone(self) -> Callable[[int], Array]:
        return self._controller.resting(self._plant, self._reference)


def _home(controller: Controller, name: str) -> type:
    """Return the class that a method of a controller is from."""
    return next(each for each in type(controller).__mro__ if name in vars(each))
