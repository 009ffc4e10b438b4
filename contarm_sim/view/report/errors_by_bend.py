"""Tip error of several sections at rest: their bends have too many dimensions for a map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contarm_sim.model.arm import Arm
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.view.colours import BLUE, GREEN, ORANGE, PURPLE, RED
from contarm_sim.view.style import Sheet

_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED, "#666666")


def draw_errors_by_bend(fig: Sheet, arm: Arm, outcomes: Sequence[Outcome | Failure]) -> None:
    """Draw tip error against the sum of all bend angles, one panel a scenario: each pose in the colour of a section.

    The colour is that of the section whose shape or links move the tip most.
    """
    columns = min(3, len(outcomes))
    rows = -(-len(outcomes) // columns)
    fig.tall(25.4 * (2.8 * rows))
    for index, outcome in enumerate(outcomes):
        ax = fig.add_subplot(rows, columns, index + 1)
        ax.set_title(f"{outcome.scenario.name}: {outcome.scenario.meaning}", fontsize=7.5)
        if isinstance(outcome, Failure):
            ax.set_axis_off()
            ax.text(0.5, 0.5, outcome.verdict, ha="center", va="center")
            continue
        compared, bends = outcome.comparison, outcome.samples.bends
        total = np.degrees(np.hypot(bends[..., 0], bends[..., 1]).sum(axis=-1))
        error = 100 * compared.tip_error / arm.length
        parts = compared.section_discretisation + compared.section_servo + compared.section_shape
        largest = parts.argmax(axis=-1)
        for number in range(len(arm.sections)):
            own, colour = largest == number, _COLOURS[number % len(_COLOURS)]
            ax.plot(total[own], error[own], "o", color=colour, markersize=3, label=f"section {number + 1}")
        ax.set_ylim(bottom=0)
        ax.set_xlabel("sum of bend angles [deg]", fontsize=7.5)
        ax.set_ylabel("tip error vs arcs [% of length]", fontsize=7.5)
        ax.tick_params(labelsize=7)
    names, labels = next((ax.get_legend_handles_labels() for ax in fig.axes if ax.get_legend_handles_labels()[0]),
                         ([], []))  # fmt: skip
    if names:
        title = "moves the tip most"
        fig.legend(names, labels, title=title, loc="outside lower center", ncols=len(names), fontsize=7.5)
