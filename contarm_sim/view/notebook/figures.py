"""The figures of a trajectory by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.mechanics.muscles import each, slices
from contarm_sim.model.colours import muscle_hex
from contarm_sim.results.compare import compare
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import ERROR
from contarm_sim.view.notebook.places import check_switches
from contarm_sim.view.prints import WIDTHS
from contarm_sim.view.report.budget import draw_budget
from contarm_sim.view.report.contact_figure import draw_contact
from contarm_sim.view.report.run_figures import draw_muscles, draw_path
from contarm_sim.view.sections import section_hex
from contarm_sim.view.style import Sheet, drawn


def plot(samples: Trajectory, figure: str = "overview", width: Any = "page", titles: bool = True) -> Sheet:
    """Return a figure of a trajectory, see `Trajectory.plot`."""
    check_switches(titles=titles)
    if not isinstance(figure, str) or figure not in FIGURES:
        raise InputError("figure", repr(figure), ", ".join(FIGURES))
    if width not in WIDTHS:
        raise InputError("width", repr(width), ", ".join(WIDTHS))
    if not len(samples):
        raise InputError("trajectory", "without samples", "one with samples")
    if figure in _OVER_TIME and not samples.moving:
        raise InputError("figure", repr(figure), "overview or path, of poses at rest")
    if figure == "contact" and samples.contacts is None:
        raise InputError("figure", repr(figure), "another one: this arm can touch nothing")
    return drawn(lambda sheet: FIGURES[figure](sheet, samples), width, titles)


def draw_overview(sheet: Sheet, samples: Trajectory) -> None:
    """Draw tip error, length changes and tensions of the muscles, over time or over poses.

    Of several sections, all muscles of one have its colour.
    """
    sheet.tall(105)
    top, middle, bottom = sheet.subplots(3, 1, sharex=True)
    error, arm, moving = samples.tip_error, samples.arm, samples.moving
    over = samples.time if moving else range(1, len(samples) + 1)
    marks: dict[str, Any] = {} if moving else {"marker": "o", "linestyle": "none"}
    top.plot(over, 1e3 * error, color=ERROR, **marks)
    straight = each(arm, lambda group: group.length)
    several = len(arm.sections) > 1
    for group, muscles in zip(arm.groups, slices(arm), strict=True):
        for i in range(muscles.start, muscles.stop):
            first = i == muscles.start
            colour = section_hex(group.section) if several else muscle_hex(i - muscles.start)
            name = (f"section {group.section + 1}" if first else None) if several else f"muscle {i + 1}"
            change = 1e3 * (samples.muscle_lengths[:, i] - straight[i])
            middle.plot(over, change, color=colour, label=name, **marks)
            bottom.plot(over, samples.muscle_tensions[:, i], color=colour, **marks)
    top.set_ylim(0, 1.1 * (1e3 * error.max() or 1.0))
    top.set_ylabel("tip error\n[mm]")
    middle.set_ylabel("length\nchange [mm]")
    bottom.set_ylabel("tension\n[N]")
    bottom.set_xlabel("time [s]" if moving else "pose")
    if not moving:
        bottom.xaxis.get_major_locator().set_params(integer=True)
    if arm.groups:
        middle.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=6 if sheet.wide else 3)
    for axes in (top, middle, bottom):
        axes.margins(x=0.01 if moving else 0.05)
    sheet.align_ylabels()
    what = f"{samples.time[-1]:g} s with the controller {samples.controller}" if moving else "Poses at rest"
    worst = f"{1e3 * error.max():.3g} mm ({100 * error.max() / arm.length:.3g} % of length)"
    sheet.heading(f"{what}: the tip is at most {worst} from that of the arc")


FIGURES: dict[str, Callable[[Sheet, Trajectory], None]] = {
    "overview": draw_overview,
    "path": lambda sheet, samples: draw_path(sheet, samples, compare(samples)),
    "budget": lambda sheet, samples: draw_budget(sheet, samples, compare(samples)),
    "muscles": draw_muscles,
    "contact": draw_contact,
}
"""What `plot` draws."""

_OVER_TIME = ("budget", "muscles")
