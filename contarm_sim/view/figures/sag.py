"""How far weight moves the resting tip, against weight over stiffness."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.errors import EquilibriumError, InputError
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.studies.scenarios import HANGING
from contarm_sim.view.colours import LIMIT, NOTE
from contarm_sim.view.figures.common import bend_colours
from contarm_sim.view.once import once
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet

BENDS = (30, 90, 150)
"""[deg]."""

_MARKS = ("o", "s", "D")


def sag(sheet: Sheet, arm: Arm) -> None:
    """Draw how far weight moves the resting tip with perfect lengths, against weight over stiffness, at three bends.

    The weight is that of the arm and its payload; an arm without gravity hangs.
    """
    weights, own, moved = _moved(arm)
    pulled = _pulled(arm)
    sheet.heading(f"How far weight moves the resting tip, by bend ({stance(pulled)})")
    sheet.tall(92 if sheet.wide else 80)
    ax = sheet.subplots()
    for degrees, colour, marker, each in zip(BENDS, bend_colours(BENDS), _MARKS, moved, strict=True):
        ax.loglog(weights, each, color=colour, marker=marker, label=f"bend {degrees}°")
    ax.axvline(own, color=LIMIT, linestyle=(0, (4, 2)), linewidth=1.0)
    ax.axhline(1.0, color=LIMIT, linestyle=":", linewidth=1.0)
    look: dict[str, Any] = {"textcoords": "offset points", "color": NOTE}
    ax.annotate("1 % of length", (weights[0], 1.0), (0, 3), va="bottom", **look)
    ax.annotate(f"this arm: {own:.3g}", (own, 0.03), (-3, 4), xycoords=("data", "axes fraction"), ha="right",
                va="bottom", **look)  # fmt: skip
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter("{x:g}")
    ax.set_xlabel("weight over stiffness, (m + payload) g L²/EI [-]" if arm.payload else
                  "weight over stiffness, m g L²/EI [-]")  # fmt: skip
    ax.set_ylabel("tip moved by weight [% of length]")
    ax.legend(loc="upper left")


def _pulled(arm: Arm) -> Arm:
    return arm if any(arm.gravity) else replace(arm, gravity=HANGING)


@once
def _moved(arm: Arm) -> tuple[Array, float, Array]:
    """Return weights over stiffness [-], shape (K,), the arm's own, and how far each moves the tip [% of length].

    The last of shape (bends, K), NaN where the arm does not rest under such a weight.
    """
    pulled = _pulled(arm)
    gravity = np.array(pulled.gravity)
    own = float((arm.mass + arm.payload) * np.linalg.norm(gravity) * arm.length**2 / arm.bending_stiffness)
    weights = np.geomspace(0.02, max(4.0, 1.5 * own), 9)
    reference = Reference.from_bends(arc.from_polar(np.radians(BENDS), 0.4), arm)
    free, moved = poses_at_rest(arm.unloaded, reference).tip, np.full((len(BENDS), len(weights)), np.nan)
    for i, bend in enumerate(reference.bend):
        for k, weight in enumerate(weights):
            heavy = replace(pulled, gravity=tuple((weight / own * gravity).tolist()))
            try:
                tip = poses_at_rest(heavy, Reference.from_bends(bend[None], arm)).tip[0]
            except (EquilibriumError, InputError):
                break
            moved[i, k] = 100 * np.linalg.norm(tip - free[i]) / arm.length
    return weights, own, moved
