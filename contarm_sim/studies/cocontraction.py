"""Co-contraction at one pose: how stiff the tip gets, in closed form and as the simulated arm shows it when pushed."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.compliance import tip_compliance
from contarm_sim.mechanics.pneumatics import force_slope, passive_slope
from contarm_sim.mechanics.statics import holding_pressures
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.studies.scenarios import Track

DIRECTIONS = ("bending", "sideways", "along")
"""Towards more bend, out of the bending plane, and normal to both."""

PROBE = 1e-3
"""Force that probes the tip [N]."""

RIGID = 1e-7
"""Compliance that is put down to rounding [m/N]."""


def stiffness_levels(arm: Arm, bend: Array, levels: int, track: Track) -> list[dict[str, Any]]:
    """Hold a bend [rad], shape (2,), with co-contraction from the least to the most that pressures allow.

    Returns:
        one row a level: pressures, tip, tip stiffness in the three directions by closed form and by pushing [N/m],
        and how far the tip drifted from the first level's [% of length].

    Raises:
        InputError: pressures cannot hold the bend; says what it would take.
    """
    holding_pressures(bend, arm)
    rows = [_row(arm, bend, i / (levels - 1)) for i in track(range(levels), "levels")]
    for row in rows:
        row["drift_percent"] = 100 * float(np.linalg.norm(np.subtract(row["tip"], rows[0]["tip"]))) / arm.length
    return rows


def _row(arm: Arm, bend: Array, share: float) -> dict[str, Any]:
    pressures = holding_pressures(bend, arm, share)
    muscles = Muscles(kind="pressures", values=tuple(pressures))
    held = equilibrium(arm, Load(muscles=muscles))
    slopes = force_slope(pressures, held.muscle_lengths, arm) + passive_slope(held.muscle_lengths, arm)
    closed = tip_compliance(bend, held.muscle_tensions, slopes, arm)
    _, plane = arc.to_polar(bend)
    sideways = np.array([-np.sin(plane), np.cos(plane), 0.0])
    outwards = arc.jacobian(bend, arm.length) @ [np.cos(plane), np.sin(plane)]
    outwards /= np.linalg.norm(outwards)
    directions = np.stack([outwards, sideways, np.cross(outwards, sideways)])
    simulated = []
    for direction in directions:
        tips = [
            equilibrium(
                arm,
                Load(muscles=muscles, wrenches=(Wrench(xi=1, force=tuple(sign * PROBE * direction)),)),
                guess=held.qpos,
            ).tip
            for sign in (1, -1)
        ]
        simulated.append(_stiffness(float((tips[0] - tips[1]) @ direction) / (2 * PROBE)))
    return {
        "least_tension_n": float(held.muscle_tensions.min()),
        "pressures_pa": pressures.tolist(),
        "mean_pressure_pa": float(pressures.mean()),
        "tip": held.tip.tolist(),
        "closed_form_n_per_m": [_stiffness(float(d @ closed @ d)) for d in directions],
        "simulated_n_per_m": simulated,
    }


def _stiffness(compliance: float) -> float | None:
    """Return its inverse [N/m]; None where the arm does not give way, as a straight one does not along itself."""
    return 1 / compliance if compliance > RIGID else None
