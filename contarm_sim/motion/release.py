"""Free swing: the arm held by a load until time zero, then let go, at once or as a course of the load says.

The engine's step kicks velocities, then moves positions by the new ones: a leapfrog whose velocities lie half a step
off its positions. An arm at rest has no velocity half a step *before* the start, though: taken so, as plain stepping
does, the swing runs half a step ahead of itself (0.2 to 0.5 mm at 1 ms). So the first kick lasts half a step.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np

from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.motion.course import Course, load_at, remaining
from contarm_sim.results.document import HIDDEN
from contarm_sim.statics.equilibrium import driven_plant
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.places import Places, quaternions

TIMESTEP = 0.001
"""Engine step [s]."""


@dataclass(frozen=True)
class SwingSettings:
    """How a swing is stepped and recorded, and what acts during it.

    Attributes:
        timestep: engine step [s].
        duration: [s]; the last sample is the one nearest to it.
        sample_period: between samples [s], a multiple of the step.
        xi: places whose frames are recorded, 0 base to 1 tip.
        course: what of the load acts later, a function of time since the release [s] that returns the share of the load
            that is left, or a whole `Load` with the same muscles; default nothing from time zero on.
    """

    timestep: float = TIMESTEP
    duration: float = 2.0
    sample_period: float = 0.01
    xi: tuple[float, ...] = field(default=(1.0,), metadata=HIDDEN)
    course: Course | None = field(default=None, metadata=HIDDEN)


DEFAULT = SwingSettings()


@dataclass(frozen=True)
class Swing:
    """T samples of a released arm at K places; base frame.

    Attributes:
        time: since the release [s], shape (T,).
        xi: places, normalised arc lengths from 0 (base) to 1 (tip), shape (K,).
        frames: 4x4 frames there, positions in [m], shape (T, K, 4, 4).
        tip: [m], shape (T, 3), whatever the places.
        energy: kinetic, elastic and of weight [J], shape (T,).
    """

    time: Array
    xi: Array
    frames: Array
    tip: Array
    energy: Array

    @property
    def positions(self) -> Array:
        """Of the places [m], shape (T, K, 3)."""
        return self.frames[..., :3, 3]

    @property
    def quaternions(self) -> Array:
        """Orientations at the places, unit quaternions w x y z with w >= 0, shape (T, K, 4)."""
        return quaternions(self.frames)


def release(arm: Arm, held: Array, load: Load, settings: SwingSettings = DEFAULT) -> Swing:
    """Let an arm go, at rest until then, and record its swing; the load's muscles stay driven as they are.

    Args:
        held: joint angles [rad] at time zero, shape (dofs,), as `equilibrium` under the load returns them.
        load: what holds the arm.
        settings: how the swing is stepped and recorded, and what of the load acts later.

    Raises:
        InputError: a step that does not divide the sample period, a place off the arm, a course that is no load.
        DivergenceError: the engine met a bad state, as it does where the step is longer than twice the damping time and
            than 2 over the highest frequency of the chain [rad/s].
    """
    arm.refuse_memory("released arms swing")
    arm.refuse_objects("released arms swing")
    timestep, period = settings.timestep, settings.sample_period
    steps = period / timestep
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-6 * steps:
        raise InputError("timestep", f"{timestep:g} s", f"a whole fraction of the sample period, {period:g} s")
    plant, places = driven_plant(arm, remaining(load)), Places(arm, settings.xi)
    plant.data.qpos[:] = held
    count = round(settings.duration / period) + 1
    tip, energy = np.empty((count, 3)), np.empty(count)
    points, turns = np.empty((count, *places.stations.shape, 3)), np.empty((count, *places.stations.shape, 3, 3))
    with engine_room():
        stepper = _Leapfrog(plant, load, timestep, settings.course)
        met = {"timestep": timestep, "damping_time": min(section.damping_time for section in arm.sections)}
        for i in range(count):
            if i:
                stepper.advance(round(steps))
                plant.check(met)
            energy[i] = stepper.energy()
            tip[i], points[i], turns[i] = plant.tip, plant.centres[places.stations], plant.rotations[places.stations]
    return Swing(period * np.arange(count, dtype=float), places.xi, places.between(points, turns), tip, energy)


class _Leapfrog:
    """Steps a plant that starts at rest, and tells its energy at whole steps."""

    def __init__(self, plant: Plant, load: Load, timestep: float, course: Course | None) -> None:
        self._model, self._data = plant.model, plant.data
        self._plant, self._load, self._course = plant, load, course
        self._timestep, self._fresh = timestep, True
        self._applied: tuple[Load, AppliedLoad] | None = None
        self._model.opt.timestep = timestep
        mujoco.mj_forward(self._model, self._data)
        plant.stiffen_twist()

    def advance(self, steps: int) -> None:
        """Take steps; the first one of all kicks for half of its time only."""
        model, data = self._model, self._data
        if self._fresh:
            self._fresh, steps = False, steps - 1
            self._push()
            self._half_step()
            data.qpos += 0.5 * self._timestep * data.qvel
            data.time += 0.5 * self._timestep
        if self._course is None:
            if steps:
                mujoco.mj_step(model, data, steps)
            return
        for _ in range(steps):
            self._push()
            mujoco.mj_step(model, data)

    def energy(self) -> float:
        """Return the energy at this time [J]; leaves poses of this time, not of a step earlier."""
        model, data = self._model, self._data
        qpos, qvel, act, time = data.qpos.copy(), data.qvel.copy(), data.act.copy(), data.time
        if not self._fresh:
            self._push()
            self._half_step()
        data.qpos[:], data.act[:], data.time = qpos, act, time
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_energyPos(model, data)
        mujoco.mj_energyVel(model, data)
        data.qvel[:] = qvel
        return float(data.energy.sum())

    def _half_step(self) -> None:
        self._model.opt.timestep = 0.5 * self._timestep
        mujoco.mj_step(self._model, self._data)
        self._model.opt.timestep = self._timestep

    def _push(self) -> None:
        """Apply what acts of the load at this time and pose."""
        if self._course is None:
            return
        load, share = load_at(self._course, self._load, self._data.time)
        if self._applied is None or self._applied[0] is not load:
            self._applied = load, AppliedLoad(self._plant, load)
        mujoco.mj_kinematics(self._model, self._data)
        self._applied[1].fraction = share
        self._data.qfrc_applied[:] = self._applied[1].generalised_forces()
