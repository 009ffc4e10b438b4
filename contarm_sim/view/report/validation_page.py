"""report.html of a validation: where constant curvature holds, and whether the simulation is explained."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.results.document import document
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.studies.convergence import Convergence
from contarm_sim.studies.validation import Validation
from contarm_sim.view.report.filled import write_filled
from contarm_sim.view.report.headline import Standing, near
from contarm_sim.view.report.pictures import figure, unshown
from contarm_sim.view.report.validation import findings, notes, rows
from contarm_sim.view.report.words import simulation_words

_CAPTIONS = {
    "errors_by_bend": "Tip error at rest against bend, in every scenario, on a logarithmic scale.",
    "error_maps": "Tip error at rest over the dome: bend angle outwards, bending plane around.",
    "convergence": "Largest tip error of arms of more and more links, without gravity: it falls with the square of "
    "their number where the simulation is right.",
}


def write_validation_page(folder: Path, found: Validation, summary: dict[str, Any]) -> None:
    """Write report.html beside the figures that a validation's folder holds already."""
    columns, cells = rows(found)
    largest = float(np.degrees(np.hypot(found.bends[:, ::2], found.bends[:, 1::2]).max()))
    write_filled(
        folder,
        "validation.html.j2",
        found.arm,
        summary,
        title=f"contarm validate: {len(found.bends)} poses at rest, bends to {largest:.4g} deg",
        headline=headline(found),
        lead="The simulated arm comes to rest in poses all over its workspace, and its tip is held against the tip of "
        "the arc. Up to 1 % of length between the two counts as holding.",
        standings=[_explained(found), _converged(found)],
        remarks=[],
        notes=notes(found),
        findings=findings(found),
        columns=columns,
        rows=cells,
        captions=_CAPTIONS,
        figures={stem: figure(folder, stem) for stem in _CAPTIONS},
        unshown=unshown(folder, _stems(found)),
    )


def _stems(found: Validation) -> list[str]:
    """Return the figures that `draw_validation` draws of a validation."""
    absent = {"error_maps"} if len(found.arm.sections) > 1 else set()
    if not isinstance(found.convergence, Convergence):
        absent.add("convergence")
    return [stem for stem in _CAPTIONS if stem not in absent]


def headline(found: Validation) -> str:
    """Say in one sentence in how many scenarios constant curvature holds, and within what."""
    rested = [each for each in found.outcomes.values() if isinstance(each, Outcome)]
    holding = [each for each in rested if each.constant_curvature.holds]
    errors = {each.scenario.name: each.constant_curvature.error_percent for each in rested}
    if not rested:
        return "The arm rests nowhere, so nothing can be said of constant curvature."
    most = max(errors, key=lambda name: errors[name])
    if len(holding) == len(found.outcomes):
        return f"Constant curvature holds within {near(errors[most])} % of length in every scenario."
    said = f"Constant curvature holds in {len(holding) or 'none'} of {len(found.outcomes)} scenarios"
    return f"{said}; the largest error is {near(errors[most])} % of length ({most})."


def _explained(found: Validation) -> Standing:
    bad = [f"{name}: {simulation_words(document(each))}" for name, each in found.outcomes.items()
           if isinstance(each, Failure) or each.judged.verdict == "fail"]  # fmt: skip
    if bad:
        return Standing("bad", "Not every scenario is explained.", "; ".join(bad) + ".")
    text = "In every scenario that is judged, an ideal rod has its tip where the simulated arm has it."
    return Standing("good", "The simulation is explained.", text)


def _converged(found: Validation) -> Standing:
    said = simulation_words(document(found.convergence))
    if found.convergence.verdict == "pass":
        text = "The error of the links falls with the square of their number, as it must."
        return Standing("good", "The simulation is converged.", text)
    return Standing("bad", "The simulation is not converged.", f"{said[0].upper()}{said[1:]}.")
