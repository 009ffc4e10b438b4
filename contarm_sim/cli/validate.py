"""`contarm validate`: the arm at rest all over its workspace, beside the closed forms."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from threading import Thread

import click

from contarm_sim import studies
from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import ANGLE, Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import PLAIN, Prints

QUICK_GRID = 3


@click.command(cls=Command)
@click.option(
    "--grid", type=click.IntRange(2, 40), default=8, show_default=True, metavar="N",
    help="Bend angles to the largest; with 3 N bending planes each. Of several sections about 3 N^2 poses in all.",
)  # fmt: skip
@click.option(
    "--max-bend", type=ANGLE, metavar="ANGLE",
    help="Largest bend angle [rad]; default 170deg, of several sections 120deg each.",
)  # fmt: skip
@click.option("--quick", is_flag=True, help="A coarse grid (N = 3), no figures and no report.html.")
@out_option("runs/validate-<time>")
@figure_options()
@json_option
@arm_options
def validate(
    arm: Arm, grid: int, quick: bool, max_bend: float | None, out: str | None, prints: Prints, as_json: bool
) -> int:
    """Compare the simulated arm with the constant-curvature model, at rest, over the whole dome.

    Scenarios: no gravity (ideal), the paper's lengths in plain servos (naive), hanging (gravity), hanging with a
    payload, standing up (upright). An arm with its own gravity or payload is judged under those. Says of each whether
    constant curvature holds (it need not), and whether the simulation is explained: exit code 1 if it is not, or
    if a scenario has no rest pose. Leaves report.html, summary.json, samples.csv and figures.

    Of several sections, poses are spread evenly (Sobol's points) over the bends of all of them; a second table has the
    parts of the error of each section alone.

    \b
    contarm validate
    contarm validate --links 48 --grid 12
    contarm validate --arm my_arm.toml --max-bend 120deg
    contarm validate --gravity 9.81 0 0 --bending-stiffness 0.2
    """
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import say, track

    if quick and prints != PLAIN:
        say("--quick draws no figures: leave it out, and --grid 3 is as coarse")
    target = output_for(out, "validate")
    if not quick:  # what draws loads while the arm is simulated
        Thread(target=import_module, args=("matplotlib.backends.backend_agg",), daemon=True).start()
    given = {} if max_bend is None else {"max_bend": max_bend}
    found = studies.validate(arm, QUICK_GRID if quick else grid, track, **given)

    def draw(folder: Path) -> None:
        from contarm_sim.view.report.validation import draw_validation, write_outcomes
        from contarm_sim.view.report.validation_page import write_validation_page

        write_outcomes(folder, found)
        if not quick:
            draw_validation(folder, found, prints)
            write_validation_page(folder, found, summary)

    summary = signed(found)
    deliver(target, summary, as_json, lambda: _show(found), draw)
    return 0 if found.verdict == "pass" else 1


def _show_sections(found: studies.Validation) -> None:
    from contarm_sim.cli.terminal import table

    rows = []
    for outcome in found.outcomes.values():
        if isinstance(outcome, studies.Failure):
            continue
        for own in outcome.errors.sections:
            parts = (f"{part.max_percent:.4f}" for part in (own.discretisation, own.servo, own.shape))
            muscle = own.muscle
            forces = "none" if muscle is None else f"{muscle.min_force_n:.1f} .. {muscle.max_force_n:.1f}"
            rows.append([outcome.scenario.name, str(own.section), *parts, forces])
    columns = ["scenario", "section", "discr. [%]", "servo [%]", "shape [%]", "force [N]"]
    table("what the tip moves by the parts of each section alone", columns, rows, caption="largest values")


def _show(found: studies.Validation) -> None:
    import numpy as np

    from contarm_sim.cli.terminal import table
    from contarm_sim.results.document import document
    from contarm_sim.studies.convergence import Convergence
    from contarm_sim.view.report.validation import findings, notes, rows
    from contarm_sim.view.report.words import simulation_words

    largest = float(np.degrees(np.hypot(found.bends[:, ::2], found.bends[:, 1::2]).max()))
    table(
        f"{len(found.bends)} poses at rest, bends to {largest:.4g} deg",
        *rows(found),
        caption="largest values; % of backbone length; rod: distance from an ideal rod's tip; turn: of the tip frame",
    )
    if len(found.arm.sections) > 1:
        _show_sections(found)
    study = found.convergence
    if isinstance(study, Convergence):
        steps = zip(study.links, study.max_error_vs_arc_m, strict=True)
        errors = ", ".join(f"{1e3 * e:.4f} mm at {n} links" for n, e in steps)
        click.echo(f"against the arc: {errors}; observed order {study.observed_orders[-1]:.3f}")
    click.echo()
    for line in findings(found):
        click.echo(line)
    click.echo(f"convergence: {simulation_words(document(study))}")
    for line in notes(found):
        click.echo(line)
