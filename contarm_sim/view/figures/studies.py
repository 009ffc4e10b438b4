"""Our own figures: where the two derivations differ, by pose, time, link count, controller and pressure."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.motion.lag import motion_part
from contarm_sim.results.compare import compare
from contarm_sim.studies import convergence as refinement
from contarm_sim.studies.at_rest import attempt
from contarm_sim.studies.controllers import Followed, compare_controllers
from contarm_sim.studies.scenarios import dome_grid, scenarios
from contarm_sim.studies.tip_stiffness import stiffness as tip_stiffness
from contarm_sim.view.colours import BLACK, BLUE, GREEN, ORANGE, SKY
from contarm_sim.view.figures.common import DURATION, Way, followed
from contarm_sim.view.report.figures import draw_convergence, draw_error_maps, draw_stiffness
from contarm_sim.view.style import Sheet

GRID = 6


def error_map(fig: Sheet, arm: Arm) -> None:
    """Draw tip error over the dome at rest, a polar map a scenario."""
    outcomes = [attempt(scenario, dome_grid(GRID)) for scenario in scenarios(arm)]
    draw_error_maps(fig, arm, outcomes)


def budget(fig: Sheet, arm: Arm, way: Way | None = None) -> None:
    """Draw the sizes of the parts of the tip error along the spiral, stacked; the error itself is their vector sum."""
    samples = followed(arm, way)
    comparison = compare(samples)
    time, motion = motion_part(samples)
    moving = np.minimum(np.interp(samples.time, time, motion), comparison.shape)
    parts = {
        "discretisation: arc vs links": comparison.discretisation,
        "servo: commanded vs measured lengths": comparison.servo,
        "shape at rest: sag, unequal joints": comparison.shape - moving,
        "motion: inertia, damping": moving,
    }
    fig.tall(86)
    ax = fig.subplots()
    stacked = 1e3 * np.array(list(parts.values()))
    layers = ax.stackplot(samples.time, stacked, labels=list(parts), colors=[BLUE, GREEN, SKY, ORANGE])
    for layer, hatch in zip(layers, ("", "....", "", "////"), strict=True):
        layer.set(hatch=hatch, edgecolor="white", linewidth=0)
    ax.plot(samples.time, 1e3 * comparison.tip_error, color=BLACK, label="tip error (vector sum)")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("distance [mm]")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)


def convergence(fig: Sheet, arm: Arm) -> None:
    """Draw the largest tip error over the dome against the number of links, with its slope."""
    draw_convergence(fig, arm, refinement.convergence(arm, dome_grid(GRID)))


def controllers(fig: Sheet, arm: Arm) -> None:
    """Draw the tip error of every controller along the spiral, split by the part that muscle lengths could correct."""
    from matplotlib.patches import Patch

    rows = compare_controllers(arm, DURATION).rows
    loads = list(dict.fromkeys(row.load for row in rows))
    fig.tall(81)
    axes = fig.subplots(1, len(loads), sharey=True)
    for ax, load in zip(axes, loads, strict=True):
        mine = [row for row in rows if row.load == load]
        for place, row in enumerate(mine):
            if not isinstance(row, Followed):
                ax.annotate("failed", (place, 1.2e-3), rotation=90, ha="center", va="bottom", fontsize=7)
                continue
            ax.bar(place - 0.2, row.tip_rms_percent, 0.4, color=BLUE)
            ax.bar(place + 0.2, row.along_rms_percent, 0.4, color=ORANGE, hatch="//", edgecolor="white")
        ax.set_yscale("log")
        ax.set_ylim(1e-3, 30)
        ax.set_xticks(range(len(mine)), [row.controller for row in mine], rotation=45, ha="right")
        ax.grid(False, axis="x")
        ax.set_title(load)
    axes[0].set_ylabel("tip error, rms [% of length]")
    whole = Patch(color=BLUE, label="tip error")
    removable = Patch(facecolor=ORANGE, hatch="//", edgecolor="white", label="part that muscle lengths could correct")
    fig.legend(handles=[whole, removable], loc="outside upper center", ncols=2)


def stiffness(fig: Sheet, arm: Arm) -> None:
    """Draw tip stiffness against pressure at 60 degrees, closed form and simulated."""
    draw_stiffness(fig, tip_stiffness(arm, arc.from_polar(np.pi / 3, 0.0)))
