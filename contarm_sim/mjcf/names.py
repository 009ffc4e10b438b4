"""Every name in a model of the arm: said here, used by what builds the model and by what finds its parts again.

An arm of one section has the plain names: bodies `base`, `link_01`, ..., `tip`, joints `joint_01_x`, tendons
`muscle_1`. With more sections all but `base`, `tip` and `payload` begin with that of their section, counted from the
base: `section_2_link_03`, `section_2_joint_03_x`, `section_2_muscle_1`. The plate at the end of section 1 is
`section_1_tip`, which section 2 begins with.
"""

from __future__ import annotations

from dataclasses import dataclass

from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.objects import ITSELF

BASE, TIP, PAYLOAD = "base", "tip", "payload"
TIP_POSITION, TIP_ORIENTATION = "tip_position", "tip_orientation"
LENGTH, VELOCITY, FORCE = "length", "velocity", "force"
TOUCH, DEPTH = "touch", "depth"
POSITION, ORIENTATION = "position", "orientation"


@dataclass(frozen=True)
class Joint:
    """One hinge: its name, its axis (x, y or z), its section (from 0), and the station of the body that it turns."""

    name: str
    axis: str
    section: int
    station: int


def of_section(arm: Arm, section: int) -> str:
    """Return what the names of a section's parts begin with, numbered from 0; nothing for an arm of one section."""
    return "" if len(arm.sections) == 1 else f"section_{section + 1}_"


def stations(arm: Arm) -> list[str]:
    """Return the names of the bodies at the stations: base, links, the ends of sections, tip."""
    names = [BASE]
    for number, section in enumerate(arm.sections):
        names += [f"{of_section(arm, number)}link_{index:02d}" for index in range(1, section.links)]
        names.append(f"{of_section(arm, number)}{TIP}")
    return [*names[:-1], TIP]


def section_stations(arm: Arm) -> list[int]:
    """Return the number of the station that each section begins at, and of the tip's."""
    ends = [0]
    for section in arm.sections:
        ends.append(ends[-1] + section.links)
    return ends


def joint_axes(arm: Arm, section: int, index: int) -> str:
    """Return the hinge order of joint `index` (from 0) of a section, parent side first."""
    if arm.sections[section].torsional_stiffness is None:
        return ("xy", "yx", "yx", "xy")[index % 4]
    return ("xyz", "zyx", "zyx", "xyz")[index % 4]


def joints(arm: Arm) -> list[Joint]:
    """Return all hinges, base first."""
    starts = section_stations(arm)
    return [
        Joint(f"{of_section(arm, number)}joint_{index + 1:02d}_{axis}", axis, number, starts[number] + index + 1)
        for number, section in enumerate(arm.sections)
        for index in range(section.links)
        for axis in joint_axes(arm, number, index)
    ]


def group_muscles(arm: Arm, group: MuscleGroup) -> list[str]:
    """Return the names of the muscles of one section, which are their tendons'."""
    return [f"{of_section(arm, group.section)}muscle_{index + 1}" for index in range(group.routing.count)]


def muscles(arm: Arm) -> list[str]:
    """Return the names of all muscles, section by section."""
    return [name for group in arm.groups for name in group_muscles(arm, group)]


def guide(station: str, muscle: str) -> str:
    """Return the name of what is drawn of a muscle at a station, or of the site that guides it."""
    return f"{station}_{muscle}"


def sensor(part: str, quantity: str) -> str:
    """Return the name of a sensor: a muscle's `LENGTH`, `VELOCITY` or `FORCE`, an object's `POSITION`, ..."""
    return f"{part}_{quantity}"


def angle_sensor(joint: str) -> str:
    """Return the name of the sensor of a joint's angle."""
    return f"{joint}_angle"


def partners(arm: Arm) -> list[str]:
    """Return the bodies of what the arm can touch, as in `World.partners`: `BASE` stands for the arm itself."""
    return [BASE if name == ITSELF else name for name in arm.world.partners]


def touch_sensor(station: str, partner: str, felt: str) -> str:
    """Return the name of the sensor of `TOUCH` or `DEPTH` of a station's body and what it touches."""
    return f"{station}_{felt}_{partner}"


def host_sensors(arm: Arm, joint: str, free: bool) -> list[str]:
    """Return the names of the sensors of a joint in a host, free or not; none of the arm's and of its objects'."""
    if joint in {each.name for each in joints(arm)} or joint in arm.world.movable:
        return []
    return [f"world_{joint}_{part}" for part in ([POSITION, ORIENTATION] if free else ["angle"])]
