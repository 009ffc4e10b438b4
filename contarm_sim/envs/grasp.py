"""`grasp`: wrap a free object with the arm, lift it and keep it up; for arms of several sections.

The arm's world has one free object, and what it lies on. Every episode draws by how much the object's mass and friction
differ from the arm's own (up to 20 % each), how much smaller it is (up to 5 %), and where it lies with all that it lies
on (up to 20 % of its radius along each axis). It is lifted once it is 40 mm above where it began and leans by at most
20 deg; that for 1 s solves the task. An episode ends early where the object is lost: it lies deeper than it began, far
away, or fell from where it was lifted to. Of what is drawn only the place can be seen.

Actions are changes of length, which reach to twice half a turn here: a section that holds something is curled up
further than bends go.

    quantity  size  unit  scaled by
    rise      1     m     LIFT; how far the object is above where it began
    time      1     s     8 s; since the episode began

Beside these all of `touched` is observed. The shaped reward has shares of being near (tip to object), wrap (links of
the last section that touch it) and lift, times how little the object leans and falls; the error is the height that
lacks.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from contarm_sim.envs.actions import Mode
from contarm_sim.envs.state import State
from contarm_sim.envs.task import CONTROL_PERIOD, Goals, Task, norm
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors
from contarm_sim.model.arm import Arm
from contarm_sim.model.objects import Object

LIFT = 0.04
"""Height that the object is to be lifted to [m]."""

HELD = 1.0
"""Time that it is to be kept there [s]."""

TILT = float(np.radians(20))
"""Most that it may lean then [rad]."""

SPREAD = 0.2
"""How far mass and friction differ from the arm's own, and the place in radii of the object."""

SMALLER = 0.05
"""Most that the object is smaller than the arm's own."""

FALL, FAR, KEPT = 0.5, 0.5, 0.25
"""When the object is lost: so much of LIFT too low, of the arm's length away, or with so little left of its rise."""

NEAR, WRAP, UP = 0.2, 0.3, 0.5
"""Shares of the shaped reward."""

WRAPPED = 0.2
"""Links of the last section that touch the object where it is wrapped, of all of its links."""

FALLING = 0.1
"""Speed downwards that halves the reward [m/s]."""


class Grasp(Task):
    """Wrap an object and lift it."""

    name: ClassVar[str] = "grasp"
    time_limit: ClassVar[float] = 8.0
    modes: ClassVar[tuple[Mode, ...]] = ("lengths",)
    drawn = ("object_mass", "object_friction", "object_size", "object_offset")
    aimless: ClassVar[bool] = True
    touches: ClassVar[bool] = True
    half_turns: ClassVar[float] = 2.0

    @classmethod
    def usual(cls) -> Arm:
        """Return the arm of the demonstration, with its object."""
        from contarm_sim.demos.grasp_script import grasp_arm

        return grasp_arm()

    @classmethod
    def needs(cls, arm: Arm) -> str | None:
        """Say that there must be one thing to lift, and a section to wrap it with."""
        free = [each for each in arm.world.objects if each.free]
        fits = len(arm.sections) > 1 and len(free) == 1 and arm.world.gravity_strength > 0
        return None if fits else "an arm of several sections under gravity, and one free object in its world"

    @cached_property
    def thing(self) -> Object:
        """The object to lift, as the arm has it."""
        return next(each for each in self.arm.world.objects if each.free)

    @cached_property
    def up(self) -> Array:
        """Direction against gravity, shape (3,)."""
        return -np.array(self.arm.gravity) / self.arm.world.gravity_strength

    @cached_property
    def radius(self) -> float:
        """Half the least extent of the object [m]."""
        own = self.thing
        return own.radius if own.radius is not None else 0.5 * min(own.size or (0.0,))

    def draw(self, random: np.random.RandomState) -> dict[str, Any]:
        """Draw the object's mass [kg] and friction, its size over the arm's own, and where it is moved to [m]."""
        mass, friction = (1 + SPREAD * (2 * random.random_sample(2) - 1)).tolist()
        size = 1 - SMALLER * random.random_sample()
        offset = SPREAD * self.radius * (2 * random.random_sample(3) - 1)
        assert self.thing.mass is not None
        return {
            "object_mass": mass * self.thing.mass,
            "object_friction": friction * self.thing.friction,
            "object_size": size,
            "object_offset": offset,
        }

    def prepare(self, values: dict[str, Any], arm: Arm) -> Goals:
        """Keep where the object begins."""
        offset = as_vectors(values["object_offset"], 3, "object_offset")
        if offset.shape != (3,) or np.abs(offset).max() > self.arm.length:
            raise InputError("object_offset", offset.tolist(), f"3 numbers within {self.arm.length:g} m")
        start, turn = np.array(self.thing.position) + offset, np.array(self.thing.quaternion)
        return {"start": start, "axis": _axis(turn), "highest": np.zeros(1), "held": np.zeros(1)}

    def staged(self, values: dict[str, Any], arm: Arm) -> Arm:
        """Put the object of the episode where it begins, and what it lies on with it."""
        offset = np.asarray(values["object_offset"], dtype=float)

        def moved(each: Object) -> Object:
            place = tuple((np.array(each.position) + offset).tolist())
            if not each.free:
                return replace(each, position=place)
            return replace(
                each, position=place, mass=values["object_mass"], friction=values["object_friction"],
                **_sized(each, values["object_size"]),
            )  # fmt: skip

        return arm.in_world(replace(arm.world, objects=tuple(moved(each) for each in arm.world.objects)))

    def quantities(self, goals: Goals, state: State, tick: Array) -> dict[str, Array]:
        """Show how high the object is, and the time."""
        return {"rise": self._rise(goals, state)[..., None], "time": CONTROL_PERIOD * tick[..., None]}

    @property
    def scales(self) -> dict[str, tuple[float, float]]:
        """See the table above."""
        return {"rise": (0.0, LIFT), "time": (0.0, self.time_limit)}

    def error(self, goals: Goals, state: State, tick: Array) -> Array:
        """Measure the height that lacks."""
        return np.maximum(LIFT - self._rise(goals, state), 0.0)

    def reward(self, goals: Goals, state: State, error: Array) -> Array:
        """Return shares of near, wrap and lift, times how little the object leans and falls."""
        near = 0.1 * self.arm.length
        away = np.maximum(norm(state["object_positions"] - state["tip_position"]) - self.radius, 0.0)
        wrap = np.minimum(self._wrapping(state) / (WRAPPED * self.arm.sections[-1].links), 1.0)
        lifted = np.clip(self._rise(goals, state) / LIFT, 0.0, 1.0)
        steady = FALLING / (FALLING + np.maximum(-_along(state["object_velocities"], self.up), 0.0))
        upright = np.maximum(self._upright(goals, state), 0.0)
        return (NEAR * near / (near + away) + WRAP * wrap + UP * lifted) * steady * upright

    def solved(self, goals: Goals, state: State, error: Array) -> NDArray[np.bool_]:
        """Tell where the object has been up for long enough."""
        return goals["held"][..., 0] >= round(HELD / CONTROL_PERIOD)

    def follow(self, goals: Goals, state: State, stepped: NDArray[np.bool_]) -> None:
        """Count for how long the object has been up, and how high it was."""
        rise, tick = self._rise(goals, state), np.zeros(len(stepped))
        up = (rise >= LIFT) & (self._upright(goals, state) >= np.cos(TILT))
        held, highest = goals["held"][..., 0], goals["highest"][..., 0]
        held[:] = np.where(stepped, np.where(up, held + 1, tick), held)
        highest[:] = np.where(stepped, np.maximum(highest, rise), highest)

    def lost(self, goals: Goals, state: State) -> NDArray[np.bool_]:
        """Tell where the object lies too deep, is away, or fell from where it was."""
        rise, highest = self._rise(goals, state), goals["highest"][..., 0]
        away = norm(state["object_positions"] - goals["start"]) > FAR * self.arm.length
        fell = (highest > FALL * LIFT) & (rise < KEPT * highest)
        return (rise < -FALL * LIFT) | away | fell

    def _rise(self, goals: Goals, state: State) -> Array:
        return _along(state["object_positions"] - goals["start"], self.up)

    def _upright(self, goals: Goals, state: State) -> Array:
        """Return the cosine of how far the object leans from how it began, shape (B,)."""
        now, then = _axis(state["object_orientations"]), goals["axis"]
        return now[..., 0] * then[..., 0] + now[..., 1] * then[..., 1] + now[..., 2] * then[..., 2]

    def _wrapping(self, state: State) -> Array:
        """Return how many links of the last section touch the object, shape (B,)."""
        place = [each.free for each in self.arm.world.objects].index(True)
        return state["touching"][..., (place + 1) * len(self.arm.sections) - 1]


def _along(vectors: Array, direction: Array) -> Array:
    """Return what vectors, shape (B, 3), have of a direction, term by term."""
    return vectors[..., 0] * direction[0] + vectors[..., 1] * direction[1] + vectors[..., 2] * direction[2]


def _axis(quaternion: Array) -> Array:
    """Return the direction of Z of quaternions w x y z, shape (..., 4)."""
    w, x, y, z = (quaternion[..., i] for i in range(4))
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)


def _sized(each: Object, size: float) -> dict[str, Any]:
    """Return the fields of an object as large as this over its own."""
    if each.radius is not None:
        return {"radius": size * each.radius}
    if each.size is not None:
        return {"size": tuple(size * edge for edge in each.size)}
    return {"scale": size * each.scale}
