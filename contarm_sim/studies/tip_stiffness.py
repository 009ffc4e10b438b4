"""Co-contraction at one pose: how stiff the tip gets, in closed form and as the simulated arm shows it when pushed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from contarm_sim.display import Shown
from contarm_sim.errors import expect
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.compliance import tip_compliance
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope
from contarm_sim.mechanics.pressures import holding_pressures
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.model.parameters import check_count
from contarm_sim.statics.equilibrium import Equilibrium, equilibrium
from contarm_sim.studies.poses import by_section, one_bend
from contarm_sim.studies.progress import Track, quietly

DIRECTIONS = ("bending", "sideways", "along")
"""Towards more bend, out of the bending plane, and normal to both.

Of several sections: where the tip goes when all bends grow alike; sideways of that and of the tip's own direction; and
normal to both.
"""

PROBE = 1e-3
"""Force that probes the tip [N]."""

NOWHERE = 1e-6
"""Sine of an angle, or share of a length, that is put down to rounding."""

RIGID = 1e-7
"""Compliance that is put down to rounding [m/N]."""


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class StiffnessLevel(Shown):
    """The tip at one level of co-contraction.

    Attributes:
        least_tension_n: of all muscles [N].
        pressures_pa: [Pa], shape (n,).
        mean_pressure_pa: [Pa].
        tip: its position [m], shape (3,).
        closed_form_n_per_m: tip stiffness in closed form [N/m], shape (3,), in the order of `DIRECTIONS`; inf where the
            arm does not give way, as a straight one does not along itself.
        simulated_n_per_m: the same of the simulated arm under pressure, when pushed.
        drift_percent: how far the tip is from where it is at the first level [% of length].
    """

    least_tension_n: float
    pressures_pa: Array
    mean_pressure_pa: float
    tip: Array
    closed_form_n_per_m: Array
    simulated_n_per_m: Array
    drift_percent: float = 0.0


@dataclass(frozen=True, eq=False, repr=False)  # arrays have no single answer to ==
class Stiffness(Shown):
    """The tip's stiffness at one bend.

    Attributes:
        rows: levels of co-contraction, from the least to the most that pressures allow.
        bend: that is held [rad], shape (2,); of several sections (S, 2).
        directions: what the three stiffnesses of a level are along.
        arm: that holds it, without gravity and payload.
    """

    rows: tuple[StiffnessLevel, ...]
    bend: Array
    directions: tuple[str, ...]
    arm: Arm

    def __repr__(self) -> str:
        ends = zip(self.directions, self.rows[0].simulated_n_per_m, self.rows[-1].simulated_n_per_m, strict=True)
        said = ", ".join(f"{name} {low:.3g} to {high:.3g} N/m" for name, low, high in ends)
        bends = " and ".join(f"{np.degrees(np.hypot(*bend)):.3g}" for bend in self.bend.reshape(-1, 2))
        return f"Stiffness(tip at {bends} deg, by co-contraction, simulated: {said}; {len(self.rows)} levels)"


def stiffness(arm: Arm, bend: Array, levels: int = 6, track: Track = quietly) -> Stiffness:
    """Hold a bend [rad], shape (2,), without gravity and payload, and raise co-contraction from the least to the most.

    Args:
        bend: of several sections (S, 2) or (2 S,); co-contraction of all of them is raised alike.
        levels: of co-contraction, at least 2.
        track: shows progress.

    Raises:
        InputError: fewer than 2 levels, or pressures cannot hold the bend; says what it would take.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("stiffness is found")
    check_count("levels", levels, 2)
    arm, bend = arm.unloaded, one_bend(bend, arm)
    holding_pressures(bend, arm)
    rows = [_level(arm, bend, i / (levels - 1)) for i in track(range(levels), "levels")]
    drifts = [100 * float(np.linalg.norm(row.tip - rows[0].tip)) / arm.length for row in rows]
    drifted = tuple(replace(row, drift_percent=drift) for row, drift in zip(rows, drifts, strict=True))
    return Stiffness(drifted, by_section(bend, arm), DIRECTIONS, arm)


def _level(arm: Arm, bend: Array, share: float) -> StiffnessLevel:
    pressures = holding_pressures(bend, arm, share)
    muscles = Muscles(kind="pressures", values=tuple(pressures))
    held = equilibrium(arm, Load(muscles=muscles))
    slopes = force_slope(pressures, held.muscle_lengths, arm) + passive_slope(held.muscle_lengths, arm)
    closed = tip_compliance(bend, held.muscle_tensions, slopes, arm)
    directions = directions_of(bend, arm)
    return StiffnessLevel(
        least_tension_n=float(held.muscle_tensions.min()),
        pressures_pa=pressures,
        mean_pressure_pa=float(pressures.mean()),
        tip=held.tip,
        closed_form_n_per_m=np.array([_stiffness(float(d @ closed @ d)) for d in directions]),
        simulated_n_per_m=np.array([_stiffness(_pushed(arm, muscles, held, d)) for d in directions]),
    )


def directions_of(bend: Array, arm: Arm) -> Array:
    """Return unit vectors of `DIRECTIONS` at a bend [rad], shape (2 S,), in the base frame, shape (3, 3)."""
    if len(arm.sections) > 1:
        return _directions_of_sections(arm, bend)
    _, plane = arc.to_polar(bend)
    sideways = np.array([-np.sin(plane), np.cos(plane), 0.0])
    outwards = arc.jacobian(bend, arm.length) @ [np.cos(plane), np.sin(plane)]
    outwards /= np.linalg.norm(outwards)
    return np.stack([outwards, sideways, np.cross(outwards, sideways)])


def _directions_of_sections(arm: Arm, bend: Array) -> Array:
    growing = bend if bend.any() else np.tile([1.0, 0.0], len(arm.sections))
    moved, tangent = shape.tip_jacobian(bend, arm) @ growing, shape.rotation(bend, arm)[:, 2]
    size = float(np.linalg.norm(moved))
    if size < NOWHERE * arm.length * float(np.linalg.norm(growing)):  # bends that undo each other
        moved, size = shape.rotation(bend, arm)[:, 0], 1.0
    outwards = moved / size
    sideways = np.cross(tangent, outwards)
    if np.linalg.norm(sideways) < NOWHERE:  # the tip goes where it points
        sideways = shape.rotation(bend, arm)[:, 1]
    sideways = sideways / np.linalg.norm(sideways)
    return np.stack([outwards, sideways, np.cross(outwards, sideways)])


def _pushed(arm: Arm, muscles: Muscles, held: Equilibrium, direction: Array) -> float:
    """Return how far the tip gives way along a direction when pushed that way and back [m/N]."""
    tips = [
        equilibrium(
            arm,
            Load(muscles=muscles, wrenches=(Wrench(xi=1, force=tuple(sign * PROBE * direction)),)),
            guess=held.qpos,
        ).tip
        for sign in (1, -1)
    ]
    return float((tips[0] - tips[1]) @ direction) / (2 * PROBE)


def _stiffness(compliance: float) -> float:
    """Return its inverse [N/m]; inf where the arm does not give way."""
    return 1 / compliance if compliance > RIGID else np.inf
