"""The option --uncertain of `run` and `equilibrium`, and what is printed of sampled arms."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.stopping import breakable

if TYPE_CHECKING:
    from contarm_sim.sweeps.spread_of_motion import UncertainMotion
    from contarm_sim.sweeps.spread_of_pose import UncertainPose
    from contarm_sim.sweeps.uncertain import Uncertain

HELP = (
    "Sample arms with parameters as distributed as this file says, all commanded as the nominal arm; give percentiles "
    "of the results, and Sobol indices: which parameter causes the spread."
)

uncertain_option = click.option("--uncertain", "uncertain_file", metavar="FILE.toml", help=HELP)


def read(file: str | None, arm: Any) -> Uncertain | None:
    """Return the uncertain parameters of an arm that a file describes, or None without a file.

    Raises:
        InputError: what is wrong with it.
    """
    if file is None:
        return None
    from contarm_sim.sweeps.uncertain import read_uncertain

    return read_uncertain(Path(file), arm)


def sampled(what: Callable[[Callable[[int, int], None]], Any]) -> Any:
    """Return what a function finds of sampled arms, given what to call with how many are done, of all."""
    from contarm_sim.cli.pace import pace

    with pace("sampled arms") as show:
        show(0, 0)
        return what(show)


def motion_of(recorded: Any, uncertain: Uncertain, stepping: Any) -> UncertainMotion:
    """Return a recorded motion of sampled arms."""
    from contarm_sim.sweeps.spread_of_motion import uncertain_motion

    with breakable():  # Ctrl-C is heard in there, and what is done is returned
        return sampled(lambda on_done: uncertain_motion(recorded, uncertain, stepping=stepping, on_done=on_done))


def sampled_arms(arm: Any, load: Any, file: str, method: Any, out: str | None, as_json: bool) -> int:
    """Print, and leave in a folder if one is given, a static pose of sampled arms; return the exit code."""
    from contarm_sim.cli.terminal import command_line, say
    from contarm_sim.errors import EquilibriumError
    from contarm_sim.stopping import exit_code
    from contarm_sim.sweeps.spread_of_pose import uncertain_pose
    from contarm_sim.versions import versions
    from contarm_sim.view.report.output import check_output, to_json
    from contarm_sim.view.report.uncertainty_words import pose_rows

    if out is not None:
        check_output(Path(out))
    asked = read(file, arm)
    assert asked is not None
    try:
        found: UncertainPose = sampled(lambda done: uncertain_pose(arm, load, asked, method, on_done=done))
    except EquilibriumError as error:
        raise error.located("the nominal arm") from None
    if found.interrupted and not found.status:
        raise KeyboardInterrupt
    told = found.document() | {"command": command_line(), "versions": versions()}
    where = "" if out is None else leave(found, told, Path(out))
    if as_json:
        click.echo(to_json(told))
    else:
        show(told, pose_rows(told), "tip", "the tip's place (all three coordinates)")
        click.echo(ellipsoid_words(told["ellipsoid"]))
    if where:
        say(f"written: {where}")
    if not found.nominal.stable:
        say("the nominal arm would not stay in its pose")
    if found.interrupted:
        kept = "which are kept" if out is not None else "which these numbers are of"
        say(f"interrupted after {len(found.status)} of {found.uncertain.cases} sampled arms, {kept}")
        return exit_code()
    return 1 if found.failed or not found.nominal.stable else 0


def leave(found: UncertainPose, told: dict[str, Any], target: Path) -> str:
    """Leave a static pose of sampled arms in a folder, which is returned: table, summary.json, figures."""
    from contarm_sim.sweeps.case_table import write_cases
    from contarm_sim.view.report.output import OutputFolder, to_json
    from contarm_sim.view.report.uncertainty import figures_of_pose
    from contarm_sim.view.style import save

    with OutputFolder(target) as opened:
        write_cases(opened.folder, found)
        (opened.folder / "summary.json").write_text(to_json(told) + "\n")
        for stem, draw in figures_of_pose(found).items():
            save(opened.folder, stem, draw)
    return str(opened.target)


def ellipsoid_words(ellipsoid: dict[str, Any]) -> str:
    """Say how large the ellipsoid of the tip is, and how it lies."""
    deviations = ellipsoid["deviations_m"]
    if deviations is None:
        return "too few tips for an ellipsoid"
    shown = (size if size > 1e-6 * max(deviations) else 0.0 for size in deviations)  # less is rounding
    sizes = ", ".join(f"{1e3 * size:.3g}" for size in shown)
    longest = ", ".join(f"{round(part, 3) + 0.0:.3f}" for part in ellipsoid["axes"][0])
    return f"standard deviations of the tip along the axes of its ellipsoid {sizes} mm; the longest is ({longest})"


def show(found: dict[str, Any], rows: Any, quantity: str, words: str) -> None:
    """Print what is known of sampled arms.

    Args:
        found: the document.
        rows: of what was found, as `error_rows` or `pose_rows` return them.
        quantity, words: whose causes are printed.
    """
    from contarm_sim.cli.terminal import table
    from contarm_sim.view.report import uncertainty_words as said

    columns = ["nominal", "5 %", "median", "95 %"]
    click.echo(said.cases_words(found))
    table("", ["", *columns], [[name, *values] for name, values in rows])
    own = said.parameter_rows(found, quantity)
    shares = ["alone [%]", "with others [%]"]
    known = "reason" not in found["causes"][quantity]
    end = None if known else -2
    table("uncertain parameters", ["", *columns, *(shares if known else [])], [[name, *v[:end]] for name, v in own])
    click.echo(said.causes_words(found, quantity, words))
    for line in said.limit_words(found) + said.apart_words(found):
        click.echo(line)
