"""The arm: one set of parameters that the analytic and the simulated arm are both derived from.

`Arm()` is the paper's arm. What the paper does not publish is an assumption; each one's reason stands
in its field's help and in the README's table. Imports nothing heavy: the command line is built from it.
"""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

from contarm_sim.errors import InputError
from contarm_sim.model.parameters import Quaternion, Vector, check_numbers, check_vector, number

MAX_LINKS = 400

Path = Literal["parallel", "spans"]
PATHS: tuple[Path, ...] = get_args(Path)

GUIDE = 1 / math.sqrt(6)
"""Height of a link's guide above its middle [link pitches], where muscles run in straight spans.

A rod bent by beta between two disks shortens a straight span by h beta^2/24 beside r beta; a joint between guides a
below and b above it does so by a b/(2 h) beta^2. Both are the same for a b = h^2/12, which is here.
"""

SERVO_RATIO = 180.0
"""Stiffness of length servos over that of the bent arm: the feed-forward's part of a muscle's stretch is then small."""

SERVO_TIME = 0.005
"""Least damping along a muscle over its servo's gain [s]: keeps one at its force limit from hunting at 5 ms steps."""


@dataclass(frozen=True, kw_only=True)
class Muscle:
    """One pneumatic muscle (PMA) and the length servo that stands for its valve and controller.

    `path` says where muscles run. `parallel`: sheathed along the backbone, everywhere at the muscle radius from it, as
    the paper draws them; lengths are those of the arc. `spans`: straight from disk to disk, one disk a link, as cables
    through few disks run.
    """

    inner_diameter: float = number(0.009, "m", "bladder bore (paper: 9 mm)", above=0)
    wall: float = number(0.002, "m", "bladder wall thickness (paper: 2 mm)", above=0)
    braid_min_diameter: float = number(0.010, "m", "smallest diameter of the braid (paper: 10 mm)", above=0)
    max_contraction: float = number(
        0.25, "-", "contraction at which the force vanishes (paper: 25 %)", above=0, below=0.42
    )
    min_pressure: float = number(90e3, "Pa", "lowest gauge pressure but none (paper: 90 kPa)", above=0)
    max_pressure: float = number(700e3, "Pa", "highest gauge pressure (paper: 700 kPa)", above=0)
    mount_contraction: float = number(
        0.05, "-", "contraction in the straight arm, so that a muscle can also lengthen", least=0, below=0.42
    )
    min_tension: float = number(5.0, "N", "tension that the slackest muscle is held at", above=0)
    passive_stiffness: float | None = number(
        None, "N/m", "of the silicone stretched beyond its rest length; omitted: bending_stiffness has it", above=0
    )
    braid_friction: float | None = number(None, "N", "dry friction of braid and guides; omitted: none", above=0)
    valve_time: float = number(0.05, "s", "time constant of valve and filling", above=0)
    servo_stiffness: float | None = number(
        None, "N/m", "gain of the muscle's length servo; omitted: 180 times what the bent arm resists with", above=0
    )
    servo_time: float | None = number(
        None, "s", "damping along the muscle over the servo's gain; omitted: 5 ms, more for slow arms", least=0
    )
    path: Path = field(
        default="parallel",
        metadata={
            "unit": "-",
            "help": "where muscles run: parallel to the backbone, or in straight spans from disk to disk",
            "choices": PATHS,
        },
    )

    def __post_init__(self) -> None:
        check_numbers(self, "muscle.")
        if self.path not in PATHS:
            raise InputError("muscle.path", repr(self.path), ", ".join(PATHS))
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

    length: float = number(0.37, "m", "backbone length L0 (paper)", above=0)
    links: int = field(
        default=24, metadata={"unit": "-", "help": f"joints of the rigid-link backbone, 2 to {MAX_LINKS}"}
    )
    mass: float = number(0.3, "kg", "mass of the whole arm, spread evenly", above=0)
    bending_stiffness: float = number(0.1, "N m^2", "EI of backbone and passive muscles", above=0)
    torsional_stiffness: float | None = number(None, "N m^2", "GJ; omitted: rigid, as the paper claims", above=0)
    damping_time: float = number(0.05, "s", "Kelvin-Voigt time: joint damping over joint stiffness", least=0)
    joint_friction: float | None = number(
        None, "N m", "dry friction of each hinge, which creeps; omitted: none", above=0
    )
    muscle_radius: float = number(0.018, "m", "radius r of the muscles' attachment circle (paper)", above=0)
    section_radius: float | None = number(
        None, "m", "radius of the round section that the mass fills (rotary inertia); omitted: the disks'", above=0
    )
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
    payload: float = number(0.0, "kg", "point mass at the tip", least=0)
    muscle: Muscle = field(default_factory=Muscle)

    def __post_init__(self) -> None:
        check_numbers(self)
        try:
            links = 0 if isinstance(self.links, bool) else operator.index(self.links)
        except TypeError:
            links = 0
        if not 2 <= links <= MAX_LINKS:
            raise InputError("links", self.links, f"a whole number from 2 to {MAX_LINKS}")
        object.__setattr__(self, "links", links)
        check_vector(self, "gravity", 3)
        if self.base_orientation is not None:
            check_vector(self, "base_orientation", 4)
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
    def disk_radius(self) -> float:
        """Radius of the disks [m]: they enclose the muscles."""
        return self.muscle_radius + 0.5 * self.muscle.diameter + 0.0015

    @property
    def bending_resistance(self) -> float:
        """What the arm resists a uniform bend with [N m/rad]: EI/L0, or a share of its weight if that is more."""
        weight = (0.5 * self.mass + self.payload) * math.hypot(*self.gravity) * self.length
        return max(self.bending_stiffness / self.length, 0.25 * weight)

    @property
    def servo_stiffness(self) -> float:
        """Gain of the muscles' length servos [N/m]: the muscle's, or `SERVO_RATIO` times what the bent arm resists."""
        if self.muscle.servo_stiffness is not None:
            return self.muscle.servo_stiffness
        gain = SERVO_RATIO * self.bending_resistance / (1.5 * self.muscle_radius**2)
        return float(f"{gain:.1e}")  # two digits say enough

    @property
    def bend_inertia(self) -> float:
        """Inertia of the straight arm's uniform bend [kg m^2], whose tip moves by half a length a radian."""
        return (self.mass / 20 + self.payload / 4) * self.length**2

    @property
    def bend_frequency(self) -> float:
        """Angular frequency [rad/s] at which the arm's uniform bend swings by itself, muscles off, without gravity."""
        return math.sqrt(self.bending_stiffness / self.length / self.bend_inertia)

    @property
    def servo_frequency(self) -> float:
        """Angular frequency [rad/s] at which the arm's uniform bend swings on its length servos."""
        return math.sqrt(1.5 * self.muscle_radius**2 * self.servo_stiffness / self.bend_inertia)

    @property
    def servo_time(self) -> float:
        """Damping along a muscle over its servo's gain [s]: the muscle's, or a fifth of critical, 5 ms at least."""
        if self.muscle.servo_time is not None:
            return self.muscle.servo_time
        return float(f"{max(SERVO_TIME, 0.4 / self.servo_frequency):.1e}")

    @property
    def guide_height(self) -> float:
        """Height [m] of the guides of straight spans above the middle of their link, see `GUIDE`."""
        return GUIDE * self.link_pitch

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
        """Lowest and highest control of a length servo, a length change from the straight arm [m].

        The lowest gives the shortest muscle its full force.
        """
        shortest, longest = self.muscle_length_range
        most = self.muscle.blocked_force - self.muscle.min_tension
        return shortest - self.length - most / self.servo_stiffness, longest - self.length
