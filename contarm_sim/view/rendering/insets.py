"""What the plots in the lower corners show: tip error, and what the muscles need or do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.studies.verdict import MODEL_LIMIT
from contarm_sim.view.colours import ERROR, SIMULATED
from contarm_sim.view.rendering.panel import LETTERS, Curve, Panel, Plot, fits
from contarm_sim.view.sections import muscle_hexes, pressure_limits, section_hex

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

_WIDE, _HIGH = 0.27, 0.27
"""Size of a card, in widths and heights of the picture."""

_NARROW, _WIDEST = 0.42, 0.46
"""Least width of a card, in heights of the picture, and its largest, in widths."""

_SMALLEST = 9.0
"""Size of letters below which nobody reads them [pixels]."""


def inset_cards(
    samples: Trajectory, picture: tuple[int, int], error: float, pressure: float, tension: float,
    band: Array | None = None,
) -> dict[str, Panel]:  # fmt: skip
    """Return the cards of the `left` and `right` lower corner, where a picture [pixels] has room for them.

    Args:
        error: the largest tip error that is to be shown [m].
        pressure, tension: likewise [Pa], [N].
        band: percentiles of the tip error of other arms [m], shape (3, T), or None.
    """
    size, letters = card_size(*picture)
    plots = {"left": error_plot(samples, error, band)}
    if samples.muscle_tensions.shape[1]:
        plots["right"] = muscle_plot(samples, pressure, tension)
    return {corner: Panel(size, letters, plot) for corner, plot in plots.items() if fits(size, letters, plot)}


def card_size(width: int, height: int) -> tuple[tuple[int, int], float]:
    """Return width and height of a card [pixels] in pictures of a size [pixels], and the size of its letters."""
    letters = max(LETTERS * height, _SMALLEST)
    return (round(min(_WIDEST * width, max(_WIDE * width, _NARROW * height))), round(_HIGH * height)), letters


def error_plot(samples: Trajectory, largest: float, band: Array | None = None) -> Plot:
    """Return the plot of the tip error, up to the largest [m], with the limit that constant curvature is held to.

    Args:
        band: its percentiles for other arms [m], shape (3, T), or None.
    """
    limit = 10 * MODEL_LIMIT * samples.arm.length
    titles, shade = ["tip error [mm]"], None
    if band is not None:
        titles.insert(0, "tip error [mm], 5 to 95 %")
        shade, largest = (1e3 * band[0], 1e3 * band[-1], SIMULATED), max(largest, float(band[-1].max()))
    return Plot(
        titles, curves=[Curve(1e3 * samples.tip_error, ERROR)], top=1e3 * largest, band=shade,
        limits=[(limit, f"{MODEL_LIMIT:g} % of length")], **_course(samples),
    )  # fmt: skip


def muscle_plot(samples: Trajectory, pressure: float, tension: float) -> Plot:
    """Return the plot of the muscles' pressures up to a largest one [Pa], or of their tensions where none has any [N].

    Under length servos the pressures are those that real muscles would need.
    """
    arm = samples.arm
    if len(arm.sections) == 1:
        colours = muscle_hexes(arm)
        kind, names = "muscle", {f"{i}": colour for i, colour in enumerate(colours, 1)}
    else:  # what the muscles of one section do differs less than what the sections do
        colours = [section_hex(group.section) for group in arm.groups for _ in range(group.routing.count)]
        kind, names = "section", {f"{group.section + 1}": section_hex(group.section) for group in arm.groups}
    highest = pressure_limits(arm)[:, 1]
    if np.isfinite(highest).any():
        needed = ["pressure [kPa]"] if samples.actuation == "pressures" else ["pressure needed [kPa]", "pressure [kPa]"]
        titles, values, top = needed, 1e-3 * samples.pressure, 1e-3 * pressure
    else:  # no pressure drives any
        titles, values, top = ["tension [N]"], samples.muscle_tensions, tension
    sections = {
        float(value): [group.section + 1 for group, own in zip(arm.groups, highest, strict=True) if own == value]
        for value in sorted(set(highest)) if math.isfinite(value)
    }  # fmt: skip
    limits = []
    for value, numbers in sections.items():
        whose = "" if len(sections) == 1 else f" in {', '.join(str(number) for number in numbers)}"
        limits.append((1e-3 * value, f"highest{whose}: {1e-3 * value:.0f} kPa"))
    curves = [Curve(values[:, i], colour) for i, colour in enumerate(colours)]
    return Plot(titles, curves=curves, top=top, limits=limits, kind=kind, names=names, **_course(samples))


def _course(samples: Trajectory) -> dict[str, Any]:
    """Return what curves are drawn over: time, or the number of the pose where there is none."""
    if samples.time[-1] > samples.time[0]:
        return {"course": samples.time, "course_name": "time [s]"}
    return {"course": np.arange(1.0, len(samples) + 1), "course_name": "pose"}
