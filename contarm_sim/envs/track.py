"""`track`: follow a path of `contarm_sim.paths` with the tip for 10 s.

One of the five paths, its largest bend from 30 to 120 deg, turned about the base's axis by any angle. The paths lie on
the dome (the sphere spiral is brought onto it); with gravity or payload the targets are where the tip rests at the
path's bends, see `resting`. The first second is not judged: the arm starts straight, most paths do not.

Of several sections the path is where the tip rests while every section's bend goes once around an ellipse of its own,
of any direction, shape and phase; the largest bend bounds them, and all are shortened until the muscles hold them.

    quantity   size  unit  scaled by
    target     3     m     L0; of this moment
    to_target  3     m     L0
    next       3     m     L0; the target at the next action
    ahead      3     m     L0; the target five actions ahead
"""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from contarm_sim import paths
from contarm_sim.envs.actions import Mode
from contarm_sim.envs.ellipses import around, draw_ellipses
from contarm_sim.envs.state import State
from contarm_sim.envs.task import CONTROL_PERIOD, Goals, Task, norm
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, dome
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

BENDS = (np.radians(30), np.radians(120))
AHEAD = 5
EVERY = 4


class Track(Task):
    """Follow a path with the tip."""

    name: ClassVar[str] = "track"
    time_limit: ClassVar[float] = 10.0
    modes: ClassVar[tuple[Mode, ...]] = ("bend", "lengths", "tensions", "pressures")
    drawn: tuple[str, ...] = ("path", "max_bend", "turn")
    over_time: ClassVar[bool] = True

    def __init__(self, arm: Arm, mode: Mode) -> None:
        super().__init__(arm, mode)
        if len(arm.sections) > 1:
            self.drawn = ("max_bend", "ellipses")

    def draw(self, random: np.random.RandomState) -> dict[str, Any]:
        """Draw the path's name, its largest bend [rad] and the angle it is turned by [rad]; or bends of sections."""
        if len(self.arm.sections) > 1:
            largest = BENDS[0] + (BENDS[1] - BENDS[0]) * random.random_sample()
            return {"max_bend": largest, "ellipses": draw_ellipses(random, len(self.arm.sections))}
        return {
            "path": paths.NAMES[random.randint(len(paths.NAMES))],
            "max_bend": self._held(BENDS[0] + (BENDS[1] - BENDS[0]) * random.random_sample()),
            "turn": 2 * np.pi * random.random_sample(),
        }

    def _held(self, largest: float) -> float:
        """Return a bend angle, shortened until the muscles hold it in every plane."""
        ring = arc.from_polar(largest, np.radians(np.arange(0, 360, 15)))
        return float(np.hypot(*self.actions.within(ring)[0]))

    def prepare(self, values: dict[str, Any], arm: Arm) -> Goals:
        """Lay the path out, a target a control period, the last one repeated."""
        if len(self.arm.sections) > 1:
            return self._laid_out(self._of_sections(values))
        name, bend, turn = values["path"], values["max_bend"], values["turn"]
        if not isinstance(turn, (int, float)) or not np.isfinite(turn):
            raise InputError("turn", turn, "a finite number [rad]")
        length = self.arm.length
        path = paths.named(str(name), length, duration=self.time_limit, max_bend=bend)
        _, points = path.targets(1 / CONTROL_PERIOD)
        bends = dome.bend_from_tip(points, length, "nearest").bend
        if name == "sphere-spiral":
            points = arc.position(bends, length)
        x, y, (c, s) = points[:, 0], points[:, 1], (np.cos(turn), np.sin(turn))
        turned = np.column_stack([c * x - s * y, s * x + c * y, points[:, 2]])
        if self.resting.loaded:
            turned = self._rested(bends @ np.array([[c, s], [-s, c]]))
        return self._laid_out(turned)

    def _of_sections(self, values: dict[str, Any]) -> Array:
        """Return the resting tips [m], shape (T, 3), of bends that go around ellipses."""
        share = np.linspace(0.0, 1.0, round(self.time_limit / CONTROL_PERIOD) + 1)
        bends = around(values["max_bend"], values["ellipses"], share, len(self.arm.sections))
        some = bends[::EVERY]
        bends = bends * (np.linalg.norm(self.actions.within(some)) / np.linalg.norm(some))
        return self._rested(bends) if self.resting.loaded else self.resting.tips(bends)

    def _laid_out(self, points: Array) -> Goals:
        return {"path": np.concatenate([points, np.repeat(points[-1:], AHEAD, axis=0)])}

    def _rested(self, bends: Array) -> Array:
        """Return resting tips [m], shape (T, 3), of bends: statics at every fourth, splines between."""
        from scipy.interpolate import CubicSpline

        ticks = np.arange(len(bends))
        solved = np.unique(np.append(ticks[::EVERY], ticks[-1]))
        return CubicSpline(solved, self.resting.tips(bends[solved]))(ticks)

    def quantities(self, goals: Goals, state: State, tick: Array) -> dict[str, Array]:
        """Show the targets of now and soon."""
        now = _at(goals, tick)
        return {
            "target": now,
            "to_target": now - state["tip_position"],
            "next": _at(goals, tick + 1),
            "ahead": _at(goals, tick + AHEAD),
        }

    @property
    def scales(self) -> dict[str, tuple[float, float]]:
        """Lengths of the arm."""
        return dict.fromkeys(("target", "to_target", "next", "ahead"), (0.0, self.arm.length))

    def error(self, goals: Goals, state: State, tick: Array) -> Array:
        """Measure the distance from tip to the target of this moment."""
        return norm(_at(goals, tick) - state["tip_position"])

    def target(self, goals: Goals, tick: int) -> Array:
        """Draw the target of this moment."""
        return goals["path"][tick]


def _at(goals: Goals, tick: Array) -> Array:
    return goals["path"][np.arange(len(tick)), tick]
