"""Paths of the tip: shapes in closed form, travelled evenly.

A path is a curve of targets over a parameter in [0, 1], travelled at even tip speed, slower in tight turns,
with a soft start and stop. Curves on the dome are drawn in bend space, where they are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.parameters import as_number

RAMP = 0.1
"""Fraction of the duration spent in each of the soft start and stop."""

MOST_TURNS = 100

LONGEST = 3600.0
"""Longest path [s]: an hour of samples still fits in memory."""

FASTEST = 1e5
"""Highest rate of samples [Hz]."""

Curve = Callable[[Array], Array]


@dataclass(frozen=True)
class Path:
    """A curve and its timing.

    Attributes:
        name: what it is called.
        curve: parameter in [0, 1], shape (T,), to targets [m], shape (T, 3).
        duration: time it takes [s].
        even: travel at even tip speed; otherwise with the curve's own timing.
    """

    name: str
    curve: Curve
    duration: float
    even: bool = True

    def __repr__(self) -> str:
        return f"Path({self.name}, {self.duration:g} s{'' if self.even else ', its own timing'})"

    def targets(self, rate: float) -> tuple[Array, Array]:
        """Return (times [s], shape (T,); targets [m], shape (T, 3)) at `rate` [Hz], both ends included."""
        _require("rate", rate, 0, FASTEST, f"more than 0 and at most {FASTEST:g} Hz")
        ticks = round(self.duration * rate)
        time = np.arange(ticks + 1) / rate
        if ticks < 1:
            raise InputError("duration", f"{self.duration:g} s", f"at least one control period, {1 / rate:g} s")
        phase = np.clip(time / self.duration, 0.0, 1.0)
        return time, self.curve(self._evenly(_soft(phase)) if self.even else phase)

    def _evenly(self, fraction: Array) -> Array:
        """Turn fractions of the travelling time into the curve's parameter.

        Speed is proportional to 1/sqrt(1 + kappa R) at a path curvature kappa, R the path's largest extent: even on
        wide arcs, and nowhere more centripetal acceleration than speed^2/R.
        """
        parameter = np.linspace(0, 1, 4001)
        points = self.curve(parameter)
        velocity = np.gradient(points, parameter, axis=0)
        speed = np.linalg.norm(velocity, axis=1)
        turning = np.linalg.norm(np.cross(velocity, np.gradient(velocity, parameter, axis=0)), axis=1)
        curvature = np.divide(turning, speed**3, out=np.zeros_like(speed), where=speed > 0)
        extent = np.ptp(points, axis=0).max()
        slowness = speed * np.sqrt(1 + curvature * extent)
        time = np.concatenate([[0.0], np.cumsum(0.5 * (slowness[1:] + slowness[:-1]))])
        return np.interp(fraction, time / time[-1], parameter) if time[-1] > 0 else fraction


def _soft(phase: Array) -> Array:
    """Return distance over time: speed rises and falls over `RAMP` with no jump in acceleration."""

    def ramp(x: Array) -> Array:  # integral of the speed 3 x^2 - 2 x^3
        return x**3 - 0.5 * x**4

    speed = 1 / (1 - RAMP)
    up = RAMP * ramp(np.clip(phase / RAMP, 0, 1)) + np.clip(phase - RAMP, 0, 1 - 2 * RAMP)
    down = RAMP * (0.5 - ramp(np.clip((1 - phase) / RAMP, 0, 1)))
    return speed * (up + np.where(phase > 1 - RAMP, down, 0.0))


def _on_dome(bend_angle: Array, plane_angle: Array, length: float) -> Array:
    bend = np.stack([bend_angle * np.cos(plane_angle), bend_angle * np.sin(plane_angle)], axis=-1)
    return arc.position(bend, length)


def spiral(length: float, turns: float, max_bend: float) -> Curve:
    """Return a spiral on the dome: from straight to `max_bend` [rad] while the bending plane turns."""
    return lambda s: _on_dome(max_bend * s, 2 * np.pi * turns * s, length)


def sphere_spiral(turns: float, max_bend: float, radius: float, centre: tuple[float, float, float]) -> Curve:
    """Return the paper's spiral on a spherical shell, from its highest point; its targets lie off the dome."""

    def curve(s: Array) -> Array:
        polar, plane = 0.5 * max_bend * s, 2 * np.pi * turns * s
        unit = np.stack([np.sin(polar) * np.cos(plane), np.sin(polar) * np.sin(plane), np.cos(polar)], axis=-1)
        return np.array(centre) + radius * unit

    return curve


def circle(length: float, max_bend: float) -> Curve:
    """Return the circle of tips at one bend angle [rad]."""
    return lambda s: _on_dome(np.full_like(s, max_bend), 2 * np.pi * s, length)


def line(length: float, max_bend: float) -> Curve:
    """Return the meridian through the straight pose, from `max_bend` [rad] one way to `max_bend` the other."""
    return lambda s: _on_dome(max_bend * (2 * s - 1), np.zeros_like(s), length)


def figure_eight(length: float, max_bend: float) -> Curve:
    """Return a figure of eight through the straight pose, `max_bend` [rad] at its widest."""

    def curve(s: Array) -> Array:
        bend = max_bend * np.stack([np.sin(2 * np.pi * s), 0.5 * np.sin(4 * np.pi * s)], axis=-1)
        return arc.position(bend, length)

    return curve


NAMES = ("spiral", "sphere-spiral", "circle", "line", "figure-eight")


def named(
    name: str,
    length: float,
    duration: float = 10.0,
    turns: float = 2.0,
    max_bend: float = math.radians(120),
    sphere_radius: float | None = None,
    sphere_centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Path:
    """Return one of the paths in `NAMES`.

    Args:
        length: backbone length [m].
        duration: [s].
        turns: of the spirals.
        max_bend: largest bend angle [rad]; for the sphere spiral twice the largest polar angle, which is the same.
        sphere_radius: of the shell [m]; default `length`, the shell that touches the dome at its top.
        sphere_centre: of the shell [m].

    Raises:
        InputError: unknown name, or a number out of range.
    """
    require_duration(duration)
    _require("turns", turns, 0, MOST_TURNS, f"more than 0, at most {MOST_TURNS}")
    _require("max_bend", max_bend, 0, math.nextafter(math.pi, 0), "0 < max_bend < pi [rad]")
    radius = length if sphere_radius is None else sphere_radius
    _require("sphere_radius", radius, 0, 1e9, "a positive radius [m]")
    for value in sphere_centre:
        _require("sphere_centre", value, -1e3 * length, 1e3 * length, "three numbers [m]")
    if name == "spiral":
        curve = spiral(length, turns, max_bend)
    elif name == "sphere-spiral":
        curve = sphere_spiral(turns, max_bend, radius, sphere_centre)
    elif name == "circle":
        curve = circle(length, max_bend)
    elif name == "line":
        curve = line(length, max_bend)
    elif name == "figure-eight":
        curve = figure_eight(length, max_bend)
    else:
        raise InputError("path", repr(name), ", ".join(NAMES) + ", or a CSV file")
    return Path(name, curve, duration)


def _require(name: str, value: Any, above: float, most: float, allowed: str) -> None:
    if not above < as_number(value) <= most:
        raise InputError(name, value, allowed)


def require_duration(duration: float) -> None:
    """Refuse a duration [s] that is not positive, or absurd."""
    _require("duration", duration, 0, LONGEST, f"more than 0 and at most {LONGEST:g} s")
