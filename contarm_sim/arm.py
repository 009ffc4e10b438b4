"""The arm: one set of parameters that the analytic and the simulated arm are both derived from.

`Arm()` is the paper's arm. What the paper does not publish is an assumption; each one's reason stands
in its field's help and in the README's table. Imports nothing heavy: the command line is built from it.
"""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field, fields, replace
from typing import Any

from contarm_sim.errors import InputError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

MAX_LINKS = 400

LARGEST = 1e9
"""Largest value of any parameter, in its SI unit: beyond it arithmetic, not mechanics, decides."""


def _number(
    default: float | None,
    unit: str,
    meaning: str,
    *,
    above: float | None = None,
    least: float | None = None,
    below: float | None = None,
) -> Any:
    """Declare a scalar parameter: its default, unit and meaning, and the interval it must lie in."""
    bounds = {"above": above, "least": least, "below": below}
    return field(default=default, metadata={"unit": unit, "help": meaning, "bounds": bounds})


def _allowed(bounds: dict[str, float | None]) -> str:
    words = {"above": "greater than", "least": "at least", "below": "below"}
    said = [f"{words[key]} {value:g}" for key, value in bounds.items() if value is not None]
    return f"a finite number, {' and '.join([*said, f'at most {LARGEST:g}'])}"


def _check_number(owner: Any, name: str, prefix: str, bounds: dict[str, float | None], optional: bool) -> None:
    value = getattr(owner, name)
    if value is None and optional:
        return
    ok = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    ok = ok and (bounds["above"] is None or value > bounds["above"])
    ok = ok and (bounds["least"] is None or value >= bounds["least"])
    ok = ok and (bounds["below"] is None or value < bounds["below"]) and abs(value) <= LARGEST
    if not ok:
        raise InputError(prefix + name, value, _allowed(bounds))
    object.__setattr__(owner, name, float(value))


def _check_numbers(owner: Any, prefix: str = "") -> None:
    for item in fields(owner):
        if "bounds" in item.metadata:
            _check_number(owner, item.name, prefix, item.metadata["bounds"], item.default is None)


def _check_vector(owner: Any, name: str, size: int) -> None:
    value = getattr(owner, name)
    try:
        vector = () if isinstance(value, (str, dict)) else tuple(float(x) for x in value)
    except (TypeError, ValueError):
        vector = ()
    if len(vector) != size or not all(abs(x) <= LARGEST for x in vector):
        raise InputError(name, value, f"{size} finite numbers, at most {LARGEST:g}")
    object.__setattr__(owner, name, vector)


@dataclass(frozen=True, kw_only=True)
class Muscle:
    """One pneumatic muscle (PMA) and the length servo that stands for its valve and controller."""

    inner_diameter: float = _number(0.009, "m", "bladder bore (paper: 9 mm)", above=0)
    wall: float = _number(0.002, "m", "bladder wall thickness (paper: 2 mm)", above=0)
    braid_min_diameter: float = _number(0.010, "m", "smallest diameter of the braid (paper: 10 mm)", above=0)
    max_contraction: float = _number(
        0.25, "-", "contraction at which the force vanishes (paper: 25 %)", above=0, below=0.42
    )
    min_pressure: float = _number(90e3, "Pa", "lowest gauge pressure but none (paper: 90 kPa)", above=0)
    max_pressure: float = _number(700e3, "Pa", "highest gauge pressure (paper: 700 kPa)", above=0)
    mount_contraction: float = _number(
        0.05, "-", "contraction in the straight arm, so that a muscle can also lengthen", least=0, below=0.42
    )
    min_tension: float = _number(5.0, "N", "tension that the slackest muscle is held at", above=0)
    passive_stiffness: float | None = _number(
        None, "N/m", "of the silicone stretched beyond its rest length; omitted: bending_stiffness has it", above=0
    )
    braid_friction: float | None = _number(None, "N", "dry friction of braid and guides; omitted: none", above=0)
    valve_time: float = _number(0.05, "s", "time constant of valve and filling", above=0)
    servo_stiffness: float = _number(1e5, "N/m", "gain of the muscle's length servo", above=0)
    servo_time: float = _number(0.02, "s", "damping of the length servo over its stiffness", least=0)

    def __post_init__(self) -> None:
        _check_numbers(self, "muscle.")
        if self.min_pressure >= self.max_pressure:
            raise InputError("muscle.min_pressure", self.min_pressure, f"below max_pressure ({self.max_pressure:g} Pa)")
        if self.mount_contraction >= self.max_contraction:
            raise InputError(
                "muscle.mount_contraction", self.mount_contraction, f"below max_contraction ({self.max_contraction:g})"
            )
        if self.braid_min_diameter >= self.diameter:
            raise InputError(
                "muscle.braid_min_diameter", self.braid_min_diameter, f"below the bladder's {self.diameter:g} m"
            )
        if self.min_tension >= self.blocked_force:
            raise InputError(
                "muscle.min_tension", self.min_tension, f"below the blocked force, {self.blocked_force:.4g} N"
            )

    @property
    def diameter(self) -> float:
        """Outer diameter of the bladder, hence of the braid at rest, D0 [m]."""
        return self.inner_diameter + 2 * self.wall

    @property
    def braid_angle(self) -> float:
        """Angle alpha0 between braid and axis at rest [rad], from eps_max = 1 - 1/(sqrt(3) cos alpha0)."""
        return math.acos(1 / (math.sqrt(3) * (1 - self.max_contraction)))

    @property
    def max_stretch(self) -> float:
        """Strain at which the braid closes on its smallest diameter [-].

        The fibres keep their length: sin(alpha) = (D/D0) sin(alpha0), L/L_rest = cos(alpha)/cos(alpha0).
        """
        sine = self.braid_min_diameter / self.diameter * math.sin(self.braid_angle)
        return math.sqrt(1 - sine**2) / math.cos(self.braid_angle) - 1

    @property
    def blocked_force(self) -> float:
        """Force at rest length and highest pressure [N] (Chou and Hannaford 1996)."""
        area = math.pi * self.diameter**2 / 4
        return self.max_pressure * area * (3 / math.tan(self.braid_angle) ** 2 - 1 / math.sin(self.braid_angle) ** 2)


@dataclass(frozen=True, kw_only=True)
class Arm:
    """A single-section inextensible continuum arm. SI units, vectors in the base frame, checked at construction.

    Raises:
        InputError: a parameter is not a finite number in its stated interval.
    """

    length: float = _number(0.37, "m", "backbone length L0 (paper)", above=0)
    links: int = field(
        default=24, metadata={"unit": "-", "help": f"joints of the rigid-link backbone, 2 to {MAX_LINKS}"}
    )
    mass: float = _number(0.3, "kg", "mass of the whole arm, spread evenly", above=0)
    bending_stiffness: float = _number(0.1, "N m^2", "EI of backbone and passive muscles", above=0)
    torsional_stiffness: float | None = _number(None, "N m^2", "GJ; omitted: rigid, as the paper claims", above=0)
    damping_time: float = _number(0.05, "s", "Kelvin-Voigt time: joint damping over joint stiffness", least=0)
    joint_friction: float | None = _number(
        None, "N m", "dry friction of each hinge, which creeps; omitted: none", above=0
    )
    muscle_radius: float = _number(0.018, "m", "radius r of the muscles' attachment circle (paper)", above=0)
    gravity: Vector = field(
        default=(0.0, 0.0, 0.0),
        metadata={"unit": "m/s^2", "help": "gravity in the base frame; 0 0 9.81 hangs the arm, 0 0 -9.81 stands it up"},
    )
    base_orientation: Quaternion | None = field(
        default=None,
        metadata={
            "unit": "-",
            "help": "quaternion w x y z of the drawn base; omitted: gravity points down the picture",
        },
    )
    payload: float = _number(0.0, "kg", "point mass at the tip", least=0)
    muscle: Muscle = field(default_factory=Muscle)

    def __post_init__(self) -> None:
        _check_numbers(self)
        try:
            links = 0 if isinstance(self.links, bool) else operator.index(self.links)
        except TypeError:
            links = 0
        if not 2 <= links <= MAX_LINKS:
            raise InputError("links", self.links, f"a whole number from 2 to {MAX_LINKS}")
        object.__setattr__(self, "links", links)
        _check_vector(self, "gravity", 3)
        if self.base_orientation is not None:
            _check_vector(self, "base_orientation", 4)
            norm = math.hypot(*self.base_orientation)
            if norm == 0:
                raise InputError("base_orientation", self.base_orientation, "a quaternion w x y z, not zero")
            object.__setattr__(self, "base_orientation", tuple(x / norm for x in self.base_orientation))
        if self.muscle_radius * math.pi >= self.length:
            raise InputError("muscle_radius", self.muscle_radius, f"below length/pi, {self.length / math.pi:.4g} m")
        if not isinstance(self.muscle, Muscle):
            raise InputError("muscle", self.muscle, "a table of muscle parameters")

    @property
    def unloaded(self) -> Arm:
        """The same arm without gravity and payload."""
        return replace(self, gravity=(0.0, 0.0, 0.0), payload=0.0)

    @property
    def link_pitch(self) -> float:
        """Distance h between neighbouring joints [m]."""
        return self.length / self.links

    @property
    def muscle_rest_length(self) -> float:
        """Length of a muscle without pressure or load [m]; mounted pre-contracted, it is length in the straight arm."""
        return self.length / (1 - self.muscle.mount_contraction)

    @property
    def muscle_length_range(self) -> tuple[float, float]:
        """Shortest and longest length [m] that a muscle can take: full contraction, closed braid."""
        rest = self.muscle_rest_length
        return rest * (1 - self.muscle.max_contraction), rest * (1 + self.muscle.max_stretch)

    @property
    def setpoint_range(self) -> tuple[float, float]:
        """Lowest and highest set-point [m] of a length servo: the lowest gives the shortest muscle its full force."""
        shortest, longest = self.muscle_length_range
        return shortest - self.muscle.blocked_force / self.muscle.servo_stiffness, longest
