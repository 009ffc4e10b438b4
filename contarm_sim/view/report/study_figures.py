"""The figures of studies: convergence, controllers, stiffness, and a muscle's law."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.model.muscle_group import MuscleGroup
from contarm_sim.studies.controllers import ControllerComparison, Followed, NotFollowed
from contarm_sim.studies.convergence import Convergence
from contarm_sim.studies.tip_stiffness import Stiffness, directions_of
from contarm_sim.view.colours import ANALYTIC, BLUE, DISCRETISATION, ERROR, HELD, LIMIT, ORANGE, SIMULATED
from contarm_sim.view.style import Sheet

ROUNDING = 1e-6
"""Distance that is put down to rounding [mm]."""

APART = 0.17
"""Marks of a row are so far above and below it [rows]."""

_LOADS = {"free": "no gravity", "gravity": "under gravity", "payload": "under gravity, with payload"}

_DIRECTIONS = {
    "bending": "bending:\nas the bend grows",
    "sideways": "sideways:\nout of the bending plane",
    "along": "along:\nnormal to both",
}
_OF_SECTIONS = _DIRECTIONS | {"bending": "bending:\nas all bends grow", "sideways": "sideways of that\nand of the tip"}


def draw_convergence(sheet: Sheet, study: Convergence) -> None:
    """Draw the largest tip error of all poses against the number of links, with the slope of second order."""
    from matplotlib.ticker import LogLocator

    links = np.array(study.links)
    sheet.tall(80)
    ax = sheet.subplots()
    for errors, colour, marker, label in (
        (study.max_error_vs_arc_m, ERROR, "o", "simulated vs arc"),
        (study.max_error_vs_chain_m, DISCRETISATION, "s", "simulated vs chain's closed form"),
    ):
        error = 1e3 * np.array(errors)
        if error.max() < ROUNDING:  # it would squeeze the others
            ax.plot([], [], color=colour, marker=marker, label=f"{label}: below {ROUNDING * 1e6:g} nm")
            continue
        ax.loglog(links, error, color=colour, marker=marker, label=label)
    first = 1e3 * study.max_error_vs_arc_m[0]
    ax.loglog(links, 1.5 * first * (links[0] / links) ** 2.0, color=LIMIT, linestyle="--", label="second order")
    ax.set_xticks(links, [str(n) for n in links])
    ax.minorticks_off()
    ax.margins(x=0.08)
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("links N [-]")
    ax.set_ylabel("largest tip error [mm]")
    sheet.legend(loc="outside lower center", ncols=3 if sheet.wide else 1)
    sheet.heading("Largest tip error of all poses against the number of links")


def draw_controllers(sheet: Sheet, found: ControllerComparison) -> None:
    """Draw each controller's tip error along the spiral, a panel a load: the whole, and what lengths could correct.

    Where muscles would need more pressure than they have, or the spiral is not followed, words say so.
    """
    loads = list(dict.fromkeys(row.load for row in found.rows))
    names = list(dict.fromkeys(row.controller for row in found.rows))
    sheet.tall((10 + 7 * len(names)) * (1 if sheet.wide else len(loads)) + 30)
    shape = (1, len(loads)) if sheet.wide else (len(loads), 1)
    panels = sheet.subplots(*shape, sharex=True, sharey=True, squeeze=False).ravel()
    most = min((group.law.pressure_limits[1] for group in found.arm.groups), default=np.inf)
    followed = [row for row in found.rows if isinstance(row, Followed)]
    values = [value for row in followed for value in (row.tip_rms_percent, row.along_rms_percent)]
    for ax, load in zip(panels, loads, strict=True):
        for row in (row for row in found.rows if row.load == load):
            _row(ax, row, names.index(row.controller), most)
        ax.set_title(_LOADS[load])
    panels[0].set_xscale("log")
    panels[0].set_xlim(0.4 * min(values, default=0.1), 2.5 * max(values, default=10.0))
    panels[0].xaxis.set_major_formatter("{x:g}")
    panels[0].set_yticks(range(len(names)), names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)
    for ax in panels if sheet.wide else panels[-1:]:
        ax.set_xlabel("tip error, rms [% of length]")
    handles = [panels[0].plot([], [], **look)[0] for look in (_WHOLE, _ALONG)]
    sheet.legend(handles, ["tip error", "its part that muscle lengths could correct"], loc="outside lower center",
               ncols=2 if sheet.wide else 1)  # fmt: skip
    has = f"; muscles have {most / 1e3:g} kPa" if np.isfinite(most) else ""
    sheet.heading(f"Tip error along the spiral in {found.duration:g} s, by controller{has}")


_WHOLE: dict[str, Any] = {"marker": "o", "color": ERROR, "linestyle": "none", "markersize": 5}
_ALONG: dict[str, Any] = {"marker": "D", "markeredgecolor": ORANGE, "markerfacecolor": "white", "linestyle": "none",
                          "markeredgewidth": 1.4}  # fmt: skip


def _row(ax: Any, row: Followed | NotFollowed, place: int, most: float) -> None:
    """Draw one controller under one load; `most` is the highest pressure that there is [Pa]."""
    if isinstance(row, NotFollowed):
        needed = row.needed_pressure_pa
        said = "failed" if needed is None else f"needs {needed / 1e3:.0f} kPa"
        ax.annotate(said, (0.04, place), xycoords=("axes fraction", "data"), va="center")
        return
    ax.plot(row.tip_rms_percent, place - APART, **_WHOLE)
    ax.plot(row.along_rms_percent, place + APART, **_ALONG)
    if row.peak_pressure_pa is not None and row.peak_pressure_pa > most:
        ax.annotate(f"needs {row.peak_pressure_pa / 1e3:.0f} kPa", (row.tip_rms_percent, place - APART), xytext=(-5, 0),
                    textcoords="offset points", ha="right", va="center")  # fmt: skip


def draw_stiffness(sheet: Sheet, found: Stiffness) -> None:
    """Draw tip stiffness against mean pressure, a panel a direction: simulated as marks, closed form as lines."""
    pressure = [row.mean_pressure_pa / 1e3 for row in found.rows]
    closed = np.array([row.closed_form_n_per_m for row in found.rows])
    pushed = np.array([row.simulated_n_per_m for row in found.rows])
    several = len(found.arm.sections) > 1
    sheet.tall(76 if sheet.wide else 140)
    panels = sheet.subplots(1, 3, sharex=True) if sheet.wide else sheet.subplots(3, 1, sharex=True)
    for i, (ax, name) in enumerate(zip(panels, found.directions, strict=True)):
        ax.set_title((_OF_SECTIONS if several else _DIRECTIONS)[name].replace("\n", "\n" if sheet.wide else " "))
        if not np.isfinite(pushed[:, i]).all():
            ax.annotate("rigid", (0.5, 0.85), xycoords="axes fraction", ha="center")
            ax.tick_params(labelleft=False)
            continue
        ax.plot(pressure, closed[:, i], color=ANALYTIC, label="closed form")
        ax.plot(pressure, pushed[:, i], "o", color=SIMULATED, markersize=4, label="simulated, pushed")
        ax.set_ylim(0, 1.15 * pushed[:, i].max())
    for ax in panels if sheet.wide else panels[-1:]:
        ax.set_xlabel("mean pressure [kPa]")
    panels[0 if sheet.wide else 1].set_ylabel("tip stiffness [N/m]")
    if np.isfinite(pushed[:, :2]).all():  # both are as stiff, about: they have one scale
        panels[0].sharey(panels[1])
        panels[0].set_ylim(0, 1.15 * pushed[:, :2].max())
    if not several:
        _sketch(panels[2].inset_axes((0.25, 0.0, 0.75, 0.68)), found)
    handles, labels = next((got for ax in panels if (got := ax.get_legend_handles_labels())[0]), ([], []))
    sheet.legend(handles, labels, loc="outside lower center", ncols=2)
    angles = (float(arc.to_polar(own)[0]) for own in np.atleast_2d(found.bend))
    sheet.heading(
        f"Tip stiffness at a bend of {', '.join(f'{np.degrees(angle):.0f}°' for angle in angles)}, by direction"
    )


def _sketch(ax: Any, found: Stiffness) -> None:
    """Draw the arm in its bending plane, and the directions of the push at its tip."""
    bend, length = found.bend.reshape(2), found.arm.length
    plane = float(arc.to_polar(bend)[1])
    across = np.array([[np.cos(plane), np.sin(plane), 0.0], [0.0, 0.0, 1.0]])
    shares = np.linspace(0, 1, 40)[1:]
    backbone = np.array([arc.position(share * bend, share * length) for share in shares]) @ across.T / length
    ax.plot(*np.vstack([[0, 0], backbone]).T, color=LIMIT, linewidth=2)
    tip = backbone[-1]
    for name, towards in zip(("bending", "along"), directions_of(bend, found.arm)[[0, 2]] @ across.T, strict=True):
        end, arrow = tip + 0.35 * towards, {"arrowstyle": "-|>", "color": ERROR, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", end, tip, arrowprops=arrow)
        ax.annotate(name, end, xytext=tuple(7 * towards), textcoords="offset points", va="center",
                    ha="left" if towards[0] > 0.3 else "center")  # fmt: skip
    ax.plot(*tip, "o", color="white", markeredgecolor=ERROR, markersize=6)
    ax.plot(*tip, "o", color=ERROR, markersize=2)
    ax.annotate("sideways", tip, xytext=(-6, 3), textcoords="offset points", ha="right", va="bottom")
    ax.set(aspect="equal", xlim=(-0.45, 1.6), ylim=(-0.05, 1.35))
    ax.set_axis_off()


def draw_muscle_law(sheet: Sheet, group: MuscleGroup, pressures: Iterable[float]) -> None:
    """Draw a muscle's force against contraction at pressures [Pa], beside the lengths that bends to 170 deg ask for.

    A muscle that runs through several sections has those of all of them.
    """
    law, rest = group.pneumatics, group.rest_length
    contraction = np.linspace(-law.max_stretch, law.max_contraction, 200)
    crossed = group.section - group.first + 1
    reach = group.routing.radius * arc.LARGEST_BEND * crossed
    asked = "lengths for bends to 170°" if crossed == 1 else f"lengths for {crossed} sections bent to 170°"
    sheet.tall(88)
    ax = sheet.subplots()
    used = 100 * (1 - (group.length + np.array([reach, -reach])) / rest)
    ax.axvspan(*used, color=HELD, label=asked)
    ax.axvline(100 * law.mount_contraction, color=LIMIT, linewidth=0.9, linestyle="--", label="straight arm")
    low, high = 100 * contraction[0], 100 * contraction[-1]
    room = (0.13 if sheet.wide else 0.28) * (high - low)
    for pressure in pressures:
        curve = law.force(pressure, rest * (1 - contraction), rest)
        ax.plot(100 * contraction, curve, color=BLUE)
        ax.annotate(f"{pressure / 1e3:g} kPa", (low, curve[0]), xytext=(-3, 0), textcoords="offset points", ha="right",
                    va="center")  # fmt: skip
    ax.set_xlim(low - room, high + 0.04 * (high - low))
    ax.set_ylim(bottom=0)
    ax.set_xlabel("contraction from rest length [%]")
    ax.set_ylabel("force of one muscle [N]")
    sheet.legend(loc="outside lower center", ncols=2 if sheet.wide else 1)
    sheet.heading("Force of one muscle against contraction, by pressure")
