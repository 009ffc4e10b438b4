"""An arm read as if it were of one section: the parameters of its sections, muscles and world under flat names.

Lengths, links and masses add up. Anything else has one value where all sections agree, and is refused where they do
not. `PARAMETERS` and `MUSCLE_PARAMETERS` are what TOML files and flags are made of.
"""

from __future__ import annotations

import math
from dataclasses import Field, fields
from typing import TYPE_CHECKING, Any, TypeVar

from contarm_sim.errors import InputError
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.parameters import Quaternion, Vector
from contarm_sim.model.pneumatic_law import PneumaticLaw, as_pneumatic
from contarm_sim.model.routing import Path, Routing
from contarm_sim.model.section import Section
from contarm_sim.model.world import WORLD_PARAMETERS, World

Value = TypeVar("Value")


def _named(kind: type) -> dict[str, Field[Any]]:
    return {item.name: item for item in fields(kind)}


def _parameters() -> dict[str, Field[Any]]:
    section, routing = _named(Section), _named(Routing)
    radii = {name: section.pop(name) for name in ("section_radius", "contact_radius")}
    return {**section, "muscle_radius": routing["radius"], **radii, **WORLD_PARAMETERS}


PARAMETERS: dict[str, Field[Any]] = _parameters()
"""Declarations of the parameters of an arm of one section, by their flat names."""

MUSCLE_PARAMETERS: dict[str, Field[Any]] = {**_named(McKibben), "path": _named(Routing)["path"]}
"""Declarations of the parameters of its muscles, of the default law."""


ONE_SECTION = "an arm of one section"


class FlatArm:
    """The properties of an arm under flat names."""

    if TYPE_CHECKING:
        sections: tuple[Section, ...]
        routings: tuple[Routing, ...]
        laws: tuple[MuscleLaw, ...]
        world: World

        @property
        def groups(self) -> tuple[MuscleGroup, ...]:
            """The muscles, see `Arm`."""
            ...

        @property
        def disk_radii(self) -> tuple[float, ...]:
            """Radii of disks [m], see `Arm`."""
            ...

    @property
    def section(self) -> Section:
        """The only section.

        Raises:
            InputError: the arm has several.
        """
        if len(self.sections) != 1:
            raise InputError("sections", f"{len(self.sections)} of them", ONE_SECTION)
        return self.sections[0]

    @property
    def routing(self) -> Routing:
        """The routing of the only section's muscles; refused as `section` is."""
        _ = self.section
        return self.routings[0]

    @property
    def group(self) -> MuscleGroup:
        """The only section's muscles.

        Raises:
            InputError: the arm has several sections, or no muscles.
        """
        _ = self.section
        if not self.groups:
            raise InputError("muscle.count", 0, "an arm with muscles")
        return self.groups[0]

    @property
    def length(self) -> float:
        """Length of the backbone L0 [m]."""
        return float(sum(section.length for section in self.sections))

    @property
    def links(self) -> int:
        """Joints of the backbone, all sections together."""
        return sum(section.links for section in self.sections)

    @property
    def mass(self) -> float:
        """Mass of the whole arm without payload [kg]."""
        return float(sum(section.mass for section in self.sections))

    @property
    def bending_stiffness(self) -> float:
        """EI of backbone and passive muscles [N m^2]."""
        return _agreed("bending_stiffness", [section.bending_stiffness for section in self.sections])

    @property
    def torsional_stiffness(self) -> float | None:
        """GJ [N m^2], or None where the backbone is rigid against twist."""
        return _agreed("torsional_stiffness", [section.torsional_stiffness for section in self.sections])

    @property
    def damping_time(self) -> float:
        """Kelvin-Voigt time [s]: joint damping over joint stiffness."""
        return _agreed("damping_time", [section.damping_time for section in self.sections])

    @property
    def joint_friction(self) -> float | None:
        """Dry friction of each hinge [N m], or None."""
        return _agreed("joint_friction", [section.joint_friction for section in self.sections])

    @property
    def friction_moment(self) -> float | None:
        """Bending moment at which friction in the backbone slides [N m], or None."""
        return _agreed("friction_moment", [section.friction_moment for section in self.sections])

    @property
    def friction_stiffness(self) -> float | None:
        """Bending stiffness that this friction adds while it sticks [N m^2], or None."""
        return _agreed("friction_stiffness", [section.friction_stiffness for section in self.sections])

    @property
    def section_radius(self) -> float | None:
        """Radius of the round section that the mass fills [m], or None for that of the disks."""
        return _agreed("section_radius", [section.section_radius for section in self.sections])

    @property
    def contact_radius(self) -> float | None:
        """Radius of what touches [m], or None for that of the disks, or of fatter muscles."""
        return _agreed("contact_radius", [section.contact_radius for section in self.sections])

    @property
    def link_pitch(self) -> float:
        """Distance h between neighbouring joints [m]."""
        return _agreed("link_pitch", [section.link_pitch for section in self.sections])

    @property
    def guide_height(self) -> float:
        """Height [m] of the guides of straight spans above the middle of their link."""
        return _agreed("guide_height", [section.guide_height for section in self.sections])

    @property
    def _routings(self) -> list[Routing]:
        """Those of sections with muscles, or all of an arm without."""
        return [group.routing for group in self.groups] or list(self.routings)

    @property
    def muscle_radius(self) -> float:
        """Radius r of the muscles' attachment circle [m]."""
        return _agreed("muscle_radius", [routing.radius for routing in self._routings])

    @property
    def path(self) -> Path:
        """Where muscles run: `parallel` or in straight `spans`."""
        return _agreed("muscle.path", [routing.path for routing in self._routings])

    @property
    def muscle(self) -> MuscleLaw:
        """The law by which muscles pull."""
        return _agreed("muscle", [group.law for group in self.groups] or list(self.laws))

    @property
    def pneumatics(self) -> PneumaticLaw:
        """The law by which pneumatic muscles pull.

        Raises:
            InputError: sections differ, or their law has no pressures.
        """
        return as_pneumatic(self.muscle)

    @property
    def gravity(self) -> Vector:
        """Gravity in the base frame [m/s^2]."""
        return self.world.gravity

    @property
    def base_orientation(self) -> Quaternion | None:
        """Quaternion w x y z of the drawn base, or None."""
        return self.world.base_orientation

    @property
    def payload(self) -> float:
        """Point mass at the tip [kg]."""
        return self.world.payload

    @property
    def disk_radius(self) -> float:
        """Radius of the largest disks [m]."""
        return max(self.disk_radii)

    @property
    def bending_resistance(self) -> float:
        """What the arm resists a uniform bend with [N m/rad]: EI/L0, or a share of its weight if that is more."""
        weight = self.world.moment(self.mass, self.length)
        return max(*(part.bending_stiffness / part.length for part in self.sections), weight)

    @property
    def bend_inertia(self) -> float:
        """Inertia of the straight arm's uniform bend [kg m^2], whose tip moves by half a length a radian."""
        return self.world.bend_inertia(self.mass, self.length)

    @property
    def bend_frequency(self) -> float:
        """Angular frequency [rad/s] at which the arm's uniform bend swings by itself, muscles off, without gravity."""
        if len(self.sections) == 1:
            return math.sqrt(self.section.bending_stiffness / self.length / self.bend_inertia)
        softness = sum(section.length / section.bending_stiffness for section in self.sections)
        return math.sqrt(1 / softness / self.bend_inertia)

    @property
    def servo_stiffness(self) -> float:
        """Gain of the muscles' length servos [N/m]."""
        return _agreed("servo_stiffness", [group.servo_stiffness for group in self.groups])

    @property
    def servo_frequency(self) -> float:
        """Angular frequency [rad/s] at which the arm's uniform bend swings on its length servos."""
        return self.group.servo_frequency

    @property
    def servo_time(self) -> float:
        """Damping along a muscle over its servo's gain [s]."""
        return _agreed("servo_time", [group.servo_time for group in self.groups])

    @property
    def muscle_rest_length(self) -> float:
        """Length of a muscle without pressure or load [m]; mounted pre-contracted, it is length in the straight arm."""
        return _agreed("muscle_rest_length", [group.rest_length for group in self.groups])

    @property
    def muscle_length_range(self) -> tuple[float, float]:
        """Shortest and longest length [m] that a muscle can take: full contraction, closed braid."""
        return _agreed("muscle_length_range", [group.length_range for group in self.groups])

    @property
    def setpoint_range(self) -> tuple[float, float]:
        """Lowest and highest control of a length servo, a length change from the straight arm [m]."""
        return _agreed("setpoint_range", [group.setpoint_range for group in self.groups])


def _agreed(name: str, values: list[Value]) -> Value:
    """Return the value that all sections have.

    Raises:
        InputError: they differ, or there is none.
    """
    if not values:
        raise InputError(name, "nothing, without muscles", "an arm with muscles")
    if any(value != values[0] for value in values):
        raise InputError(
            name,
            f"not one value but {values}",
            f"{ONE_SECTION}, or sections that agree; read sections, routings, laws or groups",
        )
    return values[0]
