"""The figures of the paper, from our own computation: forward kinematics, possible lengths, the spiral."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.pressures import pressure_needed
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.studies.scenarios import under_loads
from contarm_sim.view.colours import BLACK, BLUE, GREEN, ORANGE, RED
from contarm_sim.view.figures.common import followed
from contarm_sim.view.report.map import draw_possibility
from contarm_sim.view.sections import reachable_tips
from contarm_sim.view.style import Sheet

MM = 1e3

SIMULATED = {"color": ORANGE, "linestyle": "-", "linewidth": 3.0, "label": "simulated"}
ANALYTIC = {"color": BLACK, "linestyle": "--", "linewidth": 0.9}
"""A broad bright line with a thin dark one on it: both stay visible where they agree."""


def fan(fig: Sheet, arm: Arm) -> None:
    """Draw arcs of growing bend in six planes, and simulated chains at rest at two of the bends."""
    angles, planes = np.radians([30, 60, 90, 120, 150]), np.radians(np.arange(0, 360, 60))
    xi = np.linspace(0, 1, 60)
    fig.tall(127)
    ax = _space(fig)
    for plane in planes:
        for angle in angles:
            line = MM * arc.position(arc.from_polar(angle, plane), arm.length, xi)
            ax.plot(*line.T, color=BLUE, linewidth=0.9)
    shown = arc.from_polar(angles[[1, 3]], 0.0)
    chains = poses_at_rest(arm.unloaded, Reference.from_bends(shown, arm)).stations
    for i, stations in enumerate(chains):
        ax.plot(*(MM * stations.T), "o", color=RED, markersize=2.6, label="simulated chain" if not i else None)
    ax.plot([], [], color=BLUE, label="arc, bends of 30° to 150°")
    ax.legend(loc="upper left")


def possibility(fig: Sheet, arm: Arm) -> None:
    """Draw the pressure-limited possibility map inside the paper's ellipse, free and loaded."""
    draw_possibility(fig, under_loads(arm))


def spiral(fig: Sheet, arm: Arm) -> None:
    """Draw the paper's spiral on its spherical shell, the nearest reachable tips, and the simulated ones."""
    samples = followed(arm, "sphere-spiral", "nearest")
    fig.tall(127)
    ax = _space(fig)
    ax.plot_wireframe(*np.moveaxis(MM * reachable_tips(arm, 13, 37), -1, 0), color="#C8CED6", linewidth=0.4)
    ax.plot(*(MM * samples.target.T), color=BLACK, linestyle="--", label="the paper's, on its shell")
    reached = MM * arc.position(samples.bend, arm.length)
    ax.plot(*reached.T, color=BLUE, linewidth=2.4, label="nearest on the dome (analytic)")
    ax.plot(*(MM * samples.stations[:, -1].T), color=ORANGE, linewidth=1.0, label="simulated tip")
    ax.legend(loc="upper left")


def angles(fig: Sheet, arm: Arm) -> None:
    """Draw bend and plane angle along the spiral: commanded, and as simulated lengths show them."""
    samples = followed(arm)
    measured, _ = routing.bend_from_lengths(samples.muscle_lengths, arm)
    fig.tall(97)
    axes = fig.subplots(2, 1, sharex=True)
    for bend, look in ((measured, SIMULATED), (samples.bend, ANALYTIC | {"label": "analytic"})):
        angle, plane = arc.to_polar(bend)
        turning = np.where(angle > 1e-3, plane, np.nan)
        axes[0].plot(samples.time, np.degrees(angle), **look)
        axes[1].plot(samples.time, np.degrees(_unwrapped(turning)), **look)
    axes[0].set_ylabel("bend angle [deg]")
    axes[1].set_ylabel("plane angle [deg]")
    axes[1].set_xlabel("time [s]")
    axes[0].legend()


def lengths(fig: Sheet, arm: Arm) -> None:
    """Draw length changes of muscles 2 and 3 along the spiral, arc (paper) and simulated, and what they differ by.

    Beside it what the chain of links has otherwise than the arc: next to nothing, unless muscles run in spans.
    """
    samples = followed(arm)
    analytic = routing.arc_deltas(samples.bend, arm)
    simulated, chained = samples.muscle_lengths - arm.length, _chain_deltas(samples.bend, arm)
    fig.tall(137)
    *axes, off = fig.subplots(3, 1, sharex=True)
    for ax, i, colour in zip(axes, (1, 2), (BLUE, GREEN), strict=True):
        ax.plot(samples.time, MM * simulated[:, i], **SIMULATED)
        ax.plot(samples.time, MM * analytic[:, i], **ANALYTIC, label="arc (paper)")
        ax.set_ylabel(f"length change\nof muscle {i + 1} [mm]")
        name = f"muscle {i + 1}, simulated" if i == 1 else "muscle 3"
        off.plot(samples.time, MM * (simulated - analytic)[:, i], color=colour, label=name)
        chain = {"color": colour, "linestyle": "--", "linewidth": 0.9}
        off.plot(samples.time, MM * (chained - analytic)[:, i], **chain, label="chain of links" if i == 1 else None)
    off.set_ylabel("difference from\nthe arc's [mm]")
    off.set_xlabel("time [s]")
    axes[0].legend(loc="upper left", ncols=2)
    off.legend(loc="upper left")


def lengths_on_map(fig: Sheet, arm: Arm) -> None:
    """Draw the spiral's lengths over the ellipse, the bends that pressure holds shaded."""
    samples = followed(arm)
    bends = arc.from_polar(np.radians(np.linspace(0, 179.9, 120))[:, None], np.linspace(0, 2 * np.pi, 541))
    deltas = MM * routing.arc_deltas(bends, arm)
    held = pressure_needed(bends, arm)[1] <= arm.pneumatics.max_pressure
    fig.tall(107)
    ax = fig.subplots()
    ax.contourf(deltas[..., 1], deltas[..., 2], held.astype(float), [0.5, 1.5], colors=["#DCE6F2"])
    ax.plot(deltas[-1, :, 1], deltas[-1, :, 2], color=BLACK, label="paper's ellipse, bends of 180°")
    walked = MM * (samples.muscle_lengths - arm.length)
    ax.plot(walked[:, 1], walked[:, 2], color=RED, label="spiral, simulated")
    ax.fill([], [], color="#DCE6F2", label=f"held by {arm.pneumatics.max_pressure / 1e3:.0f} kPa")
    ax.set_aspect("equal")
    edge = 1.04 * np.abs(deltas).max()
    ax.set(xlim=(-edge, edge), ylim=(-edge, edge))
    ax.set_xlabel("length change of muscle 2 [mm]")
    ax.set_ylabel("length change of muscle 3 [mm]")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0))


def _chain_deltas(bend: Array, arm: Arm) -> Array:
    return routing.lengths_from_bend(bend, arm) - arm.length


def _unwrapped(angle: Array) -> Array:
    """Return angles [rad] without jumps of a turn, NaN left alone."""
    out, good = angle.copy(), np.isfinite(angle)
    out[good] = np.unwrap(angle[good])
    return out


def _space(fig: Any) -> Any:
    """Return equal three-dimensional axes in mm, nothing cut off."""
    ax = fig.add_subplot(projection="3d", computed_zorder=False)
    ax.set_xlabel("x [mm]", labelpad=7)
    ax.set_ylabel("y [mm]", labelpad=9)
    ax.set_zlabel("z [mm]")
    ax.view_init(24, -55)
    ax.set_box_aspect((1, 1, 0.75), zoom=0.86)
    return ax
