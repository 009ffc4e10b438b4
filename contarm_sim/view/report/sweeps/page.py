"""The report of a sweep: its figures, and report.html."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from contarm_sim.view.prints import PLAIN, Prints
from contarm_sim.view.report.filled import arm_words, write_filled
from contarm_sim.view.report.pictures import figure, unshown
from contarm_sim.view.report.sweeps import words
from contarm_sim.view.report.sweeps.failures import draw_failures
from contarm_sim.view.report.sweeps.found import Found
from contarm_sim.view.report.sweeps.heat_maps import draw_heat_map
from contarm_sim.view.report.sweeps.indices import draw_indices
from contarm_sim.view.report.sweeps.marginals import draw_marginals
from contarm_sim.view.report.sweeps.validity import draw_validity
from contarm_sim.view.style import Draw, save

_CAPTIONS = {
    "validity": "The validity chart: how far the tip at rest is from the arc's at most, by the arm's weight over its "
    "stiffness, and by payload, bend and number of links. One arm is one vertical line.",
    "heat_map": "Two numbers that vary, those of the largest effect, are the axes. In a grid, each map shows one level "
    "of every other parameter, named above it; in other designs, a cell is the median of its cases.",
    "marginals": "The same by each parameter alone; that of the largest effect comes first. Where cases of a grid "
    "failed, levels are compared in those settings of the other parameters in which all levels have a result; "
    "the number of these is above each.",
    "indices": "Sobol's indices: the share of the variance that each parameter causes alone, and together with others. "
    "Where a total is well above the first order, parameters interact.",
    "failures": "Where cases failed, and why: over two parameters, and by each alone.",
}


def figures_of(found: Found) -> dict[str, Draw]:
    """Return what draws each figure that this sweep has, by the stem of its files."""
    drawn: dict[str, Draw] = {}
    chart, indices, failed = found.chart, found.indices, found.failed
    columns = [column for column in found.columns if len(set(column.values.tolist())) > 1] or found.columns
    if chart is not None:
        drawn["validity"] = lambda sheet: draw_validity(sheet, chart)
    if len(found.known):
        if len(columns) > 1:
            drawn["heat_map"] = lambda sheet: draw_heat_map(sheet, columns, found.value, failed, found.grid)
        drawn["marginals"] = lambda sheet: draw_marginals(sheet, columns, found.value, found.grid)
    if indices is not None:
        drawn["indices"] = lambda sheet: draw_indices(sheet, indices, found.value)
    if failed.any():
        drawn["failures"] = lambda sheet: draw_failures(sheet, columns, found.status)
    return drawn


def write_sweep_report(folder: Path, found: Found, summary: dict[str, Any], prints: Prints = PLAIN,
                       on_figure: Callable[[str], object] = lambda stem: None) -> None:  # fmt: skip
    """Draw the figures of a sweep into a folder, and write report.html beside them."""
    stems = figures_of(found)
    for stem, draw in stems.items():
        on_figure(stem)
        save(folder, stem, draw, prints)
    spec, (columns, rows) = found.sweep.spec, words.cases(found)
    write_filled(
        folder,
        "sweep.html.j2",
        found.arm,
        summary,
        about=f"{arm_words(found.arm, spec.vary)}; cases differ in {', '.join(spec.vary)}",
        command=f"{words.command(found)}\n{summary['command']}",
        meanings=words.meanings(found),
        title=f"contarm sweep-report: {spec.name}, {len(found.sweep):,} of {spec.cases:,} cases",
        headline=words.headline(found),
        lead=words.lead(found),
        standings=words.standings(found),
        remarks=words.remarks(found),
        value=found.value.label,
        parameters=words.parameters(found),
        fixed=words.fixed(found),
        columns=columns,
        rows=rows,
        why=found.why(),
        stems=list(stems),
        captions=_CAPTIONS,
        figures={stem: figure(folder, stem) for stem in stems},
        unshown=unshown(folder, stems),
        table=str(found.sweep.folder),
    )
