"""A released arm's swing as columns, as JSON, and as a picture."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.motion.swing_error import SwingError
from contarm_sim.view.colours import BLACK, BLUE, DISCRETISATION, ERROR, GREEN, ORANGE, SKY
from contarm_sim.view.style import Sheet

TINY = 1e-9
"""Smaller errors are drawn as this [% of length]."""


def swing_columns(found: SwingError) -> tuple[str, Array]:
    """Return the header and the columns of swing.csv, a row a sample.

    They are time and energy; position, orientation (quaternion w x y z) and extrapolated position of every place; the
    extrapolated tip, whatever the places.
    """
    swing = found.swing
    names, columns = ["time_s", "energy_j"], [swing.time[:, None], swing.energy[:, None]]
    for k, xi in enumerate(swing.xi):
        at = "tip" if xi == 1 else f"xi_{xi:g}"
        names += [f"{at}_{axis}_m" for axis in "xyz"] + [f"{at}_q{part}" for part in "wxyz"]
        columns += [swing.positions[:, k], swing.quaternions[:, k]]
        if xi != 1:
            names += [f"ideal_{at}_{axis}_m" for axis in "xyz"]
            columns.append(found.positions[:, k])
    names += [f"ideal_tip_{axis}_m" for axis in "xyz"]
    return ",".join(names), np.hstack([*columns, found.tip])


def swing_dict(found: SwingError) -> dict[str, Any]:
    """Return the samples as JSON holds them: time, energy, poses by place, the ideal tip, its distance."""
    swing = found.swing
    places = [
        {
            "xi": float(xi),
            "position": swing.positions[:, k].tolist(),
            "quaternion": swing.quaternions[:, k].tolist(),
            "ideal_position": found.positions[:, k].tolist(),
        }
        for k, xi in enumerate(swing.xi)
    ]
    return {
        "time": swing.time.tolist(),
        "energy": swing.energy.tolist(),
        "places": places,
        "ideal_tip": found.tip.tolist(),
        "tip_error": found.total.tolist(),
    }


def draw_swing(sheet: Sheet, arm: Arm, found: SwingError) -> None:
    """Draw a released tip's coordinates, its error by cause, and the energy left."""
    swing = found.swing
    sheet.tall(130 if sheet.wide else 140)
    top, middle, bottom = panels = sheet.subplots(3, 1, sharex=True, height_ratios=[2, 1.4, 1])
    looks = zip("xyz", (BLUE, ORANGE, GREEN), ("-", (0, (4, 1.5)), (0, (1, 1))), strict=True)
    for axis, (name, colour, dashes) in enumerate(looks):
        moved = 1e3 * (swing.tip[:, axis] - swing.tip[-1, axis])
        top.plot(swing.time, moved, color=colour, linestyle=dashes, label=name)
    top.set_ylabel("tip, from where\nit ends [mm]")
    most = 0.0
    for what, words, colour, dashes in (
        ("total", "both", ERROR, "-"),
        ("step", "of the time step", SKY, (0, (4, 1.5))),
        ("links", "of the links", DISCRETISATION, (0, (1, 1))),
    ):
        error = 100 * getattr(found, what)[1:] / arm.length
        most = max(most, float(error.max()))
        middle.semilogy(swing.time[1:], np.maximum(error, TINY), color=colour, linestyle=dashes, label=words)
    middle.set_ylim(max(TINY, 1e-3 * most), max(2 * most, 10 * TINY))
    middle.set_ylabel("tip error\n[% of length]")
    for ax in (top, middle):
        ax.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=3)
    bottom.plot(swing.time, 1e3 * (swing.energy - swing.energy.min()), color=BLACK)
    bottom.set_ylabel("energy above\nthe least [mJ]")
    bottom.set_xlabel("time since release [s]")
    sheet.align_ylabels(panels)
    sheet.heading("A released arm: its tip, the tip's error by cause, and energy")
