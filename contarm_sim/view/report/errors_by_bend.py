"""Tip error at rest against how far the arm bends, scenario by scenario, on one logarithmic axis."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.studies.verdict import MODEL_LIMIT
from contarm_sim.view.colours import LIMIT, SCENARIOS
from contarm_sim.view.report.error_field import error_field
from contarm_sim.view.sections import section_marks
from contarm_sim.view.style import Sheet

LEAST = 1e-3
"""Smaller errors are not drawn [% of length]: a straight arm without load has none."""

FINE, PLANES = 171, np.linspace(0, 2 * np.pi, 72, endpoint=False)
"""Bend angles, and planes [rad], that lines and bands are drawn of."""

HOLDS = f"below {MODEL_LIMIT:g} %: constant curvature holds"
_HEADING = "Tip error at rest against bend"


def draw_errors_by_bend(sheet: Sheet, arm: Arm, outcomes: Sequence[Outcome | Failure]) -> None:
    """Draw tip error against bend angle, a line a scenario: the median of all bending planes in a band of their spread.

    Marks are medians of poses that were examined; the error between those is `error_field`'s.

    Of several sections against the sum of all bend angles, a panel a scenario; each pose is a mark, that of the section
    whose shape or links move the tip most. A scenario without rest poses says so.
    """
    if len(arm.sections) > 1:
        _draw_poses(sheet, arm, outcomes)
        return
    sheet.tall(100 if sheet.wide else 106)
    ax = sheet.subplots()
    most = 2.0
    for outcome in outcomes:
        colour, dashes, mark = SCENARIOS[outcome.scenario.name]
        words = outcome.scenario.meaning
        if isinstance(outcome, Failure):
            ax.plot([], [], " ", label=f"{words}: {outcome.verdict}")
            continue
        angle, error = _total(outcome), 100 * outcome.comparison.tip_error / arm.length
        at = np.linspace(0, np.radians(angle.max()), FINE)
        low, middle, high = np.quantile(error_field(outcome, at[:, None], PLANES), (0, 0.5, 1), axis=1)
        ax.fill_between(np.degrees(at), low, high, color=colour, alpha=0.3, linewidth=0)
        ax.plot(np.degrees(at), middle, color=colour, linestyle=dashes)
        rings = np.unique(angle)
        ax.plot(rings, [np.median(error[angle == ring]) for ring in rings], mark, color=colour, linestyle="none")
        ax.plot([], [], mark, color=colour, linestyle=dashes, label=words)
        most = max(most, float(high.max()))
    _scale(ax, LEAST, 1.5 * most)
    ax.set_xlabel("bend angle [deg]")
    ax.set_ylabel("tip error vs arc [% of length]")
    sheet.legend(loc="outside lower center", ncols=2 if sheet.wide else 1)
    sheet.heading(f"{_HEADING}: median of all bending planes; bands are their spread")


def _total(outcome: Outcome) -> Array:
    """Return the sum of the bend angles of all sections [deg], shape (T,), free of rounding."""
    bends = outcome.samples.bends
    return np.round(np.degrees(np.hypot(bends[..., 0], bends[..., 1]).sum(axis=-1)), 6)


def _scale(ax: Any, least: float, most: float) -> None:
    """Make the axis of errors logarithmic, with a line at the limit that the verdict on constant curvature has."""
    ax.set_yscale("log")
    ax.set_ylim(least, most)
    ax.yaxis.set_major_formatter("{x:g}")
    ax.axhline(MODEL_LIMIT, color=LIMIT, linewidth=0.9, label=HOLDS)


def _draw_poses(sheet: Sheet, arm: Arm, outcomes: Sequence[Outcome | Failure]) -> None:
    columns = 2 if sheet.wide else 1
    rows = -(-len(outcomes) // columns)
    sheet.tall((58 if sheet.wide else 48) * rows + 24)
    panels = sheet.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    rested = [outcome.comparison.tip_error for outcome in outcomes if isinstance(outcome, Outcome)]
    found = 100 * np.concatenate([*rested, np.zeros(0)]) / arm.length
    found = np.append(found[found > LEAST], MODEL_LIMIT)
    for ax, outcome in zip(panels.flat, outcomes, strict=False):
        ax.set_title(outcome.scenario.meaning)
        ax.margins(x=0.08)
        _scale(ax, 0.5 * found.min(), 2 * found.max())
        if isinstance(outcome, Failure):
            ax.text(0.5, 0.5, outcome.verdict, ha="center", va="center", transform=ax.transAxes)
            continue
        total, compared = _total(outcome), outcome.comparison
        error = 100 * compared.tip_error / arm.length
        parts = compared.section_discretisation + compared.section_servo + compared.section_shape
        largest = parts.argmax(axis=-1)
        for number in range(len(arm.sections)):
            own = largest == number
            ax.plot(total[own], error[own], **section_marks(number))
    for ax in panels.flat[len(outcomes) :]:
        ax.set_axis_off()
    for ax in panels[-1]:
        ax.set_xlabel("sum of bend angles [deg]")
        ax.tick_params(labelbottom=True)
    for ax in panels[:, 0]:
        ax.set_ylabel("tip error vs arcs\n[% of length]")
    marks = [panels[0, 0].plot([], [], **section_marks(i))[0] for i in range(len(arm.sections))]
    names = [f"section {i + 1} moves the tip most" for i in range(len(marks))]
    limit, _ = panels[0, 0].get_legend_handles_labels()
    sheet.legend([*marks, limit[0]], [*names, HOLDS], loc="outside lower center", ncols=2 if sheet.wide else 1)
    sheet.heading(f"{_HEADING} of all sections")
