"""A validation as people read it: a table's rows, a line for every scenario, notes, samples and figures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from contarm_sim.mechanics.muscles import each
from contarm_sim.results.document import document
from contarm_sim.results.summary import Spread
from contarm_sim.studies.at_rest import Failure, Outcome
from contarm_sim.studies.convergence import Convergence
from contarm_sim.studies.validation import Validation
from contarm_sim.view.prints import PLAIN, Prints
from contarm_sim.view.report.error_maps import draw_error_maps
from contarm_sim.view.report.errors_by_bend import draw_errors_by_bend
from contarm_sim.view.report.samples_csv import write_samples
from contarm_sim.view.report.study_figures import draw_convergence
from contarm_sim.view.report.words import curvature_words, simulation_words
from contarm_sim.view.style import save

COLUMNS = ["scenario", "tip [mm]", "[%]", "discr. [%]", "servo [%]", "shape [%]", "rod [%]", "turn [deg]", "force [N]",
           "pushes [%]"]  # fmt: skip


def _rested(found: Validation) -> list[Outcome]:
    return [outcome for outcome in found.outcomes.values() if isinstance(outcome, Outcome)]


def rows(found: Validation) -> tuple[list[str], list[list[str]]]:
    """Return the columns of the table, and a row a scenario: largest values."""
    return COLUMNS, [_row(outcome) for outcome in found.outcomes.values()]


def _row(outcome: Outcome | Failure) -> list[str]:
    name = outcome.scenario.name
    if isinstance(outcome, Failure):
        return [name, "no rest", *[""] * (len(COLUMNS) - 2)]
    errors, muscle = outcome.errors, outcome.errors.muscle
    parts = (errors.tip_error, errors.discretisation, errors.servo, errors.shape, outcome.rod.unexplained)
    return [
        name,
        f"{1e3 * errors.tip_error.max_m:.3f}",
        *(_percent(part) for part in parts),
        f"{errors.orientation_error_deg:.3f}",
        f"{muscle.min_force_n:.1f} .. {muscle.max_force_n:.1f}",
        f"{100 * muscle.push_fraction:.3g}",
    ]


def _percent(part: Spread | None) -> str:
    if part is None:
        return "not known"
    return f"{part.max_percent:.3g}" if part.max_percent >= 1 else f"{part.max_percent:.4f}"


def findings(found: Validation) -> list[str]:
    """Say of every scenario whether constant curvature holds, and whether the simulation is explained."""
    return [_finding(outcome) for outcome in found.outcomes.values()]


def _finding(outcome: Outcome | Failure) -> str:
    name, simulation = outcome.scenario.name, simulation_words(document(outcome))
    if isinstance(outcome, Failure):
        return f"{name}: {simulation}"
    weight, curvature = outcome.setting.weight_over_stiffness, outcome.constant_curvature
    mass = "(m + payload)" if outcome.setting.arm.payload else "m"
    under = f" at {mass} g L^2/EI = {weight:.2f}" if weight and not curvature.holds else ""
    return f"{name}: constant curvature {curvature_words(document(curvature))}{under}; simulation {simulation}"


def notes(found: Validation) -> list[str]:
    """Say what the table does not: what the link count leaves under load, and what real muscles could not hold."""
    outcomes = _rested(found)
    links = ", ".join(
        f"{outcome.scenario.name} "
        + (f"{error.spread.max_percent:.2f} %" if (error := outcome.link_error) else "not known, for it does not rest")
        for outcome in outcomes
        if any(outcome.scenario.arm.gravity)
    )
    lines = (
        [f"what the number of links alone makes of it, at the worst pose (estimated from twice the links): {links}"]
        if links
        else []
    )
    blown = ", ".join(outcome.scenario.name for outcome in outcomes if outcome.real_time_factor is None)
    if blown:
        lines.append(f"{blown}: stepping blows up at the default time step, so there is no real-time factor")
    return lines + [_pressure_note(o) for o in outcomes if o.errors.muscle.beyond_max_pressure and o.scenario.checks]


def _pressure_note(outcome: Outcome) -> str:
    arm, samples = outcome.scenario.arm, outcome.samples
    highest = each(arm, lambda group: group.law.pressure_limits[1])
    bends = samples.bends[(samples.pressure > highest).any(axis=1)]
    over = np.hypot(bends[..., 0], bends[..., 1]).max(axis=1)
    most, beyond = outcome.errors.muscle.max_pressure_needed_pa, outcome.errors.muscle.beyond_max_pressure
    needs = "more than any pressure" if most is None else f"up to {most / 1e3:.0f} kPa"
    where = f"{beyond} of {len(samples)} poses, from {np.degrees(over.min()):.0f} deg on"
    ranges = dict.fromkeys(group.law.pressure_limits for group in arm.groups)
    said = " or ".join(f"{low / 1e3:.0f} to {high / 1e3:.0f} kPa" for low, high in ranges if np.isfinite(high))
    return f"{outcome.scenario.name}: a muscle needs {needs} ({where}); available {said}"


def write_outcomes(folder: Path, found: Validation) -> None:
    """Write samples.csv, every pose of every scenario that rests."""
    write_samples(folder / "samples.csv", {o.scenario.name: (o.samples, o.comparison) for o in _rested(found)})


def draw_validation(folder: Path, found: Validation, prints: Prints = PLAIN) -> None:
    """Draw the figures `errors_by_bend`, of one section `error_maps`, and `convergence` where that was found."""
    outcomes = list(found.outcomes.values())
    save(folder, "errors_by_bend", lambda sheet: draw_errors_by_bend(sheet, found.arm, outcomes), prints)
    if len(found.arm.sections) == 1:
        save(folder, "error_maps", lambda sheet: draw_error_maps(sheet, found.arm, outcomes), prints)
    study = found.convergence
    if isinstance(study, Convergence):
        save(folder, "convergence", lambda sheet: draw_convergence(sheet, study), prints)
