"""The figures of a run and of a validation."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import each, slices
from contarm_sim.mechanics.routing import arc_deltas
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.results.compare import Comparison
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.studies.convergence import Convergence
from contarm_sim.studies.tip_stiffness import Stiffness
from contarm_sim.view.colours import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED
from contarm_sim.view.sections import backbone_lines, reachable_tips, section_hex
from contarm_sim.view.style import Sheet

_BUDGET = (("discretisation", BLUE, "--"), ("servo", GREEN, ":"), ("shape", ORANGE, "-."))

_BACKBONE: dict[str, Any] = {"linewidth": 2.2, "marker": "o", "markersize": 2.4}

ROUNDING = 1e-6
"""Distance that is put down to rounding [mm]."""


def draw_path(fig: Sheet, samples: Trajectory, comparison: Comparison) -> None:
    """Draw target and simulated tips in three dimensions, with the reachable tips behind and the backbone at the end.

    Of one section these are the dome; of several their hull is drawn.
    """
    mm, arm = 1e3, samples.arm
    fig.tall(132)
    ax = fig.add_subplot(projection="3d", computed_zorder=False)
    ax.plot_wireframe(*np.moveaxis(mm * reachable_tips(arm, 13, 37), -1, 0), color="#C8CED6", linewidth=0.4)
    ax.plot(*(mm * samples.target.T), color=BLACK, linewidth=1.0, linestyle="--", label="target")
    ax.plot(*(mm * comparison.simulated_tip.T), color=RED, linewidth=1.4, label="simulated tip")
    for name, colour, stations in backbone_lines(mm * samples.stations[-1], arm):
        ax.plot(*stations.T, color=colour, **_BACKBONE, label=f"{name}, last sample")
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("y [mm]")
    ax.set_zlabel("z [mm]")
    ax.set_aspect("equal")
    ax.set_box_aspect(None, zoom=0.86)  # or the z label is cut off
    ax.view_init(24, -55)
    ax.legend(loc="upper left")
    several = len(arm.sections) > 1
    ax.set_title(f"Tip path {'inside the hull' if several else 'on the dome'} of reachable tips")


def draw_budget(
    fig: Sheet, samples: Trajectory, comparison: Comparison, motion: tuple[Array, Array] | None = None
) -> None:
    """Draw tip error and its parts, and orientation error, over time; `motion` is what `motion_part` returned.

    Of several sections, also what the tip moves where one section alone has a part.
    """
    t, arm = samples.time, samples.arm
    several = len(arm.sections) > 1
    fig.tall(25.4 * (6.2 if several else 4.6))
    panels = fig.subplots(2 + several, 1, sharex=True, height_ratios=[2, 1.6, 1] if several else [2, 1])
    top, bottom = panels[0], panels[-1]
    top.plot(t, 1e3 * comparison.tip_error, color=BLACK, label="analytic vs simulated tip")
    for name, colour, dashes in _BUDGET:
        top.plot(t, 1e3 * getattr(comparison, name), color=colour, linestyle=dashes, label=name)
    if motion is not None:
        top.plot(motion[0], 1e3 * motion[1], ".", color=PURPLE, markersize=3, label="motion (simulated vs at rest)")
    if comparison.miss.max() > 1e-6:
        out = "target out of reach" if several else "target off the dome"
        top.plot(t, 1e3 * comparison.miss, color=RED, linewidth=1.0, label=f"miss ({out})")
    top.set_yscale("log")
    top.set_ylim(bottom=1e-4)
    top.set_ylabel("distance [mm]")
    percent = top.secondary_yaxis("right", functions=(lambda x: x / 10 / arm.length, lambda x: x * 10 * arm.length))
    percent.set_ylabel("distance [% of length]")
    top.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    if several:
        _draw_section_parts(panels[1], t, comparison)
    bottom.plot(t, np.degrees(comparison.orientation_error), color=BLACK)
    bottom.set_ylabel("orientation\nerror [deg]")
    bottom.set_xlabel("time [s]")


def _draw_section_parts(ax: Any, time: Array, comparison: Comparison) -> None:
    """Draw the parts of each section [mm]: the colour is the section's, the dashes are the part's."""
    from matplotlib.lines import Line2D

    handles = [Line2D([], [], color="#888888", linestyle=dashes, label=name) for name, _, dashes in _BUDGET]
    for number in range(comparison.section_shape.shape[1]):
        for name, _, dashes in _BUDGET:
            own = 1e3 * getattr(comparison, f"section_{name}")[:, number]
            ax.plot(time, own, color=section_hex(number), linestyle=dashes)
        handles.append(Line2D([], [], color=section_hex(number), label=f"section {number + 1}"))
    ax.set_yscale("log")
    ax.set_ylim(bottom=1e-4)
    ax.set_ylabel("one section's part [mm]")
    ax.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=min(len(handles), 5))


def draw_muscles(fig: Sheet, samples: Trajectory, comparison: Comparison) -> None:
    """Draw muscle length changes, analytic and simulated, tensions and, where there are any, pressures over time.

    Each section has a column.
    """
    t, arm = samples.time, samples.arm
    analytic, straight = arc_deltas(samples.bend, arm), each(arm, lambda group: group.length)
    pressure = 1e-3 * np.where(np.isfinite(samples.pressure), samples.pressure, np.nan)
    pneumatic = any(isinstance(group.law, PneumaticLaw) for group in arm.groups)
    fig.tall(25.4 * (5.8 if pneumatic else 4.2))
    rows = 3 if pneumatic else 2
    columns = fig.subplots(rows, len(arm.groups), sharex=True, sharey="row", squeeze=False).T
    for group, muscles, (top, middle, *others) in zip(arm.groups, slices(arm), columns, strict=True):
        for i in range(muscles.start, muscles.stop):
            colour, name = muscle_hex(i - muscles.start), f"muscle {i - muscles.start + 1}"
            top.plot(t, 1e3 * (samples.muscle_lengths[:, i] - straight[i]), color=colour, label=name)
            top.plot(t, 1e3 * analytic[:, i], color=BLACK, linewidth=0.8, linestyle=":")
            middle.plot(t, samples.muscle_tensions[:, i], color=colour)
            for bottom in others:
                bottom.plot(t, pressure[:, i], color=colour)
        top.plot([], [], color=BLACK, linewidth=0.8, linestyle=":", label="arc (paper)")
        title, wide = (None, 4) if len(arm.sections) == 1 else (f"section {group.section + 1}", 2)
        top.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=wide, title=title)
        middle.axhline(group.law.min_tension, color="#888888", linewidth=0.8, linestyle="--")
        for bottom in others:
            bottom.axhline(group.law.pressure_limits[0] / 1e3, color="#888888", linewidth=0.8, linestyle="--")
        (others or [middle])[-1].set_xlabel("time [s]")
    top, middle, *others = columns[0]
    top.set_ylabel("length change [mm]")
    middle.set_ylim(bottom=min(0.0, float(samples.muscle_tensions.min())))
    middle.set_ylabel("tension [N]")
    for bottom in others:
        bottom.set_ylim(bottom=0)
        bottom.set_ylabel("pressure\nneeded [kPa]")


def draw_error_maps(fig: Sheet, arm: Arm, outcomes: Sequence[Outcome | Failure]) -> None:
    """Draw tip error over the dome, one polar map a scenario: bend angle outwards, bending plane around.

    A scenario without rest poses has a panel that says so.
    """
    from matplotlib.ticker import MaxNLocator

    columns = min(3, len(outcomes))
    rows = -(-len(outcomes) // columns)
    fig.tall(25.4 * (3.3 * rows))
    for index, outcome in enumerate(outcomes):
        title = f"{outcome.scenario.name}: {outcome.scenario.meaning}"
        if isinstance(outcome, Failure):
            ax = fig.add_subplot(rows, columns, index + 1)
            ax.set_axis_off()
            ax.text(0.5, 0.5, outcome.verdict, ha="center", va="center")
            ax.set_title(title, fontsize=7.5)
            continue
        ax = fig.add_subplot(rows, columns, index + 1, projection="polar")
        angle, plane = arc.to_polar(outcome.samples.bend[1:])
        grid = round((len(angle) / 3) ** 0.5)
        shape = (grid, 3 * grid)
        error = 100 * outcome.comparison.tip_error[1:].reshape(shape) / arm.length
        theta = np.mod(plane.reshape(shape), 2 * np.pi)
        theta, radius = np.column_stack([theta, theta[:, :1] + 2 * np.pi]), np.degrees(angle.reshape(shape))
        radius = np.column_stack([radius, radius[:, :1]])
        start = 100 * outcome.comparison.tip_error[0] / arm.length
        error = np.vstack([np.full(3 * grid + 1, start), np.column_stack([error, error[:, :1]])])
        theta, radius = np.vstack([theta[:1], theta]), np.vstack([np.zeros(3 * grid + 1), radius])
        ax.grid(False)
        levels = MaxNLocator(12, steps=[1, 2, 2.5, 5, 10]).tick_values(0, max(error.max(), 1e-9))
        ticks = levels[::2]
        filled = ax.contourf(theta, radius, error, levels=levels, cmap="cividis")
        ax.set_axisbelow(False)
        ax.set_yticks([60, 120, 170], ["60°", "120°", "bend 170°"], fontsize=6.5)
        for label in ax.get_yticklabels():
            label.set_bbox({"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.6})
        ax.set_rlabel_position(22)  # type: ignore[attr-defined]
        ax.tick_params(axis="x", labelsize=7)
        ax.grid(True, color="white", linewidth=0.6)
        ax.set_title(title, fontsize=7.5)
        bar = fig.colorbar(filled, ax=ax, orientation="horizontal", ticks=ticks, shrink=0.8, aspect=28, format="%.3g")
        bar.set_label("tip error vs arc [% of length]", fontsize=7)
        bar.ax.tick_params(labelsize=6.5)


def draw_convergence(fig: Sheet, arm: Arm, study: Convergence) -> None:
    """Draw the largest tip error over the dome against the number of links, with the slope of second order."""
    from matplotlib.ticker import LogLocator

    links = np.array(study.links)
    fig.tall(86)
    ax = fig.subplots()
    for errors, colour, marker, label in (
        (study.max_error_vs_arc_m, BLACK, "o", "simulated vs arc"),
        (study.max_error_vs_chain_m, BLUE, "s", "simulated vs chain form"),
    ):
        error = 1e3 * np.array(errors)
        if error.max() < ROUNDING:  # it would squeeze the others
            ax.plot([], [], color=colour, label=f"{label}: below 10$^{{-6}}$ mm")
            continue
        ax.loglog(links, error, color=colour, marker=marker, label=label)
    first = 1e3 * study.max_error_vs_arc_m[0]
    ax.loglog(links, 1.5 * first * (links[0] / links) ** 2.0, color="#888888", linestyle="--", label="slope -2")
    ax.set_xticks(links, [str(n) for n in links])
    ax.minorticks_off()
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("links N [-]")
    ax.set_ylabel("largest tip error, dome to 170° [mm]" if len(arm.sections) == 1 else "largest tip error [mm]")
    ax.legend()


def draw_muscle_law(fig: Sheet, group: MuscleGroup, pressures: Iterable[float]) -> None:
    """Draw a muscle's force against contraction at pressures [Pa], beside the lengths that bends to 170 deg ask for.

    A muscle that runs through several sections has those of all of them.
    """
    law, rest = group.pneumatics, group.rest_length
    contraction = np.linspace(-law.max_stretch, law.max_contraction, 200)
    crossed = group.section - group.first + 1
    reach = group.routing.radius * arc.LARGEST_BEND * crossed
    asked = "lengths of the dome to 170°" if crossed == 1 else f"lengths of {crossed} sections bent to 170°"
    fig.tall(91)
    ax = fig.subplots()
    used = 100 * (1 - (group.length + np.array([reach, -reach])) / rest)
    ax.axvspan(*used, color="#D5DEEA", label=asked)
    ax.axvline(100 * law.mount_contraction, color="#888888", linewidth=0.8, linestyle="--", label="straight arm")
    for pressure in pressures:
        curve = law.force(pressure, rest * (1 - contraction), rest)
        ax.plot(100 * contraction, curve, color=BLUE, linewidth=1.2)
        ax.annotate(f"{pressure / 1e3:g} kPa", (100 * contraction[0], curve[0]), xytext=(-3, 0),
                    textcoords="offset points", ha="right", va="center", fontsize=7)  # fmt: skip
    ax.margins(x=0.12)
    ax.set_ylim(bottom=0)
    ax.set_xlabel("contraction from rest length [%]")
    ax.set_ylabel("force of one muscle [N]")
    ax.legend()


def draw_stiffness(fig: Sheet, found: Stiffness) -> None:
    """Draw tip stiffness against mean pressure, a panel a direction: simulated as marks, closed form as lines."""
    pressure = [row.mean_pressure_pa / 1e3 for row in found.rows]
    closed = np.array([row.closed_form_n_per_m for row in found.rows])
    pushed = np.array([row.simulated_n_per_m for row in found.rows])
    fig.tall(74)
    panels = fig.subplots(1, len(found.directions))
    for i, (ax, name, colour) in enumerate(zip(panels, found.directions, (BLUE, ORANGE, GREEN), strict=True)):
        ax.set_title(name)
        ax.set_xlabel("mean pressure [kPa]")
        if not np.isfinite(pushed[:, i]).all():
            ax.annotate("rigid", (0.5, 0.5), xycoords="axes fraction", ha="center")
            continue
        ax.plot(pressure, closed[:, i], color=colour, label="closed form")
        ax.plot(pressure, pushed[:, i], "o", color=BLACK, markersize=4, label="simulated, pushed")
        ax.set_ylim(0, 1.15 * pushed[:, i].max())
        ax.legend(loc="lower right")
    panels[0].set_ylabel("tip stiffness [N/m]")
