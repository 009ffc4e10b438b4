"""The report of a fit: its figures, and report.html."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.identify.fitted import Fit, Left
from contarm_sim.view.prints import PLAIN, Prints
from contarm_sim.view.report.filled import write_filled
from contarm_sim.view.report.fits import words
from contarm_sim.view.report.fits.bars import draw_blocks
from contarm_sim.view.report.fits.left_over import distances, driven, hysteresis
from contarm_sim.view.report.fits.matrices import draw_correlation, draw_singular_values
from contarm_sim.view.report.fits.over_time import draw_over_time, draw_paths
from contarm_sim.view.report.fits.parameters import draw_parameters
from contarm_sim.view.report.fits.spread import draw_by_command, draw_distribution, draw_history, draw_starts
from contarm_sim.view.report.fits.standings import standings
from contarm_sim.view.report.pictures import figure, unshown
from contarm_sim.view.style import Draw, Sheet, save

_PREDICTED: dict[str, Callable[..., None]] = {"paths": draw_paths, "blocks": draw_blocks, "over_time": draw_over_time,
              "distribution": draw_distribution, "by_command": draw_by_command, "history": draw_history}  # fmt: skip
"""Figures of what is left over of each recording."""

CAPTIONS = {
    "parameters": "Each parameter with its 95 % interval from the Jacobian, that of a bootstrap over blocks where one "
    "was asked for, its prior, and what it started from. Positive parameters are shown as multiples of their start.",
    "correlation": "Two parameters whose errors are correlated by nearly 1 or -1 may change together: the recording "
    "hardly tells them apart. Rows and columns are numbered alike; what is not determined has none.",
    "singular_values": "Directions of all parameters together, by how well the recording sees them: the larger, the "
    "better. Below, which parameters take part in those that it does not determine.",
    "starts": "Where searches from several starts end: many at the lowest cost mean that it is the best there is.",
    "paths": "Where the last marker was measured, with a line towards where it is predicted, drawn longer where the "
    "legend says so; of motions, both paths.",
    "blocks": "The rms of the errors by block, without outliers, what was held out hatched, and by marker where there "
    "are several.",
    "over_time": "Errors of the last marker, and their components, in the order of the recording. Every other block is "
    "shaded. What is the same in a whole block is not noise.",
    "distribution": "Shares of the samples by the size of their errors. The dotted line is how far samples of the same "
    "command are from their median: a model without memory can hardly be better. Outliers are in the last bin.",
    "by_command": "Errors by how far all channels together are commanded. Errors that grow with it are of the model.",
    "history": "The error along the way that a channel moves the last marker, coloured by which way its command went "
    "last; gaps are how much larger it is where the command grows. Two bands apart are hysteresis: friction, or slack.",
}


def numbered(stem: str, place: int, fit: Fit) -> str:
    """Return the stem of a figure of one of several recordings, from 0; other figures have their own."""
    return f"{stem}_{place + 1}" if stem in _PREDICTED and len(fit.left) > 1 else stem


def figures_of(fit: Fit) -> dict[str, Draw]:
    """Return what draws each figure that this fit has, by the stem of its files."""
    drawn: dict[str, Draw] = {"parameters": lambda sheet: draw_parameters(sheet, fit)}
    for place, left in enumerate(fit.left):
        for stem, draw in _PREDICTED.items():
            if _has(stem, left):
                draw = partial(draw_history, noise=fit.noise) if stem == "history" else draw
                drawn[numbered(stem, place, fit)] = _of(draw, left)
    if np.isfinite(fit.correlation).any() and len(fit.parameters) > 1:
        drawn["correlation"] = lambda sheet: draw_correlation(sheet, fit)
    if np.isfinite(fit.singular_values).any():
        drawn["singular_values"] = lambda sheet: draw_singular_values(sheet, fit)
    if len(fit.cost) > 1:
        drawn["starts"] = lambda sheet: draw_starts(sheet, fit)
    return drawn


def _of(draw: Callable[[Sheet, Left], object], left: Left) -> Draw:
    return lambda sheet: draw(sheet, left)


def _has(stem: str, left: Left) -> bool:
    """Tell whether a recording has what a figure shows."""
    if not np.isfinite(distances(left)).any():
        return False
    if stem not in ("by_command", "history"):
        return True
    found = driven(left)
    if found is None:
        return False
    if stem == "by_command":
        return bool(np.ptp(found.values))
    return left.recording.kind == "static" and any(
        hysteresis(left, found, place) is not None for place in range(len(found.channels))
    )


def write_fit_report(folder: Path, fit: Fit, summary: dict[str, Any], prints: Prints = PLAIN,
                     on_figure: Callable[[str], object] = lambda stem: None) -> None:  # fmt: skip
    """Draw the figures of a fit into a folder, and write report.html beside them.

    Args:
        folder: to write into.
        fit: what is reported.
        summary: its document, with `command` and `versions`.
        prints: kinds and widths of the figures.
        on_figure: told of each figure before it is drawn.
    """
    stems = figures_of(fit)
    for stem, draw in stems.items():
        on_figure(stem)
        save(folder, stem, draw, prints)
    own = [[stem for stem in (numbered(one, place, fit) for one in _PREDICTED) if stem in stems]
           for place in range(len(fit.left))]  # fmt: skip
    captions = CAPTIONS | {numbered(stem, place, fit): CAPTIONS[stem] for stem in _PREDICTED
                           for place in range(len(fit.left))}  # fmt: skip
    write_filled(
        folder,
        "fit.html.j2",
        fit.arm,
        summary,
        meanings=words.MEANINGS,
        title=f"contarm fit: {', '.join(left.recording.name for left in fit.left)}",
        headline=words.headline(fit),
        lead=words.lead(fit),
        standings=standings(fit),
        remarks=words.remarks(fit),
        parameter_columns=words.parameter_columns(fit),
        parameters=words.rows_of(fit),
        notes=words.notes(fit),
        undetermined=words.undetermined(fit),
        error_columns=words.error_columns(),
        errors=words.error_rows(fit),
        how=words.how(fit),
        recordings=list(zip([left.recording.name for left in fit.left], own, strict=True)),
        several=len(fit.left) > 1,
        stems=list(stems),
        captions=captions,
        figures={stem: figure(folder, stem) for stem in stems},
        unshown=unshown(folder, stems),
    )
