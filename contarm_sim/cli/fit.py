"""`contarm fit`: an arm fitted to recordings of a real one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import LENGTH, Command, json_option, out_option
from contarm_sim.view.prints import Prints

if TYPE_CHECKING:
    from contarm_sim.identify.fitted import Fit
    from contarm_sim.identify.recordings.recording import Recording
    from contarm_sim.model.arm import Arm

_METHODS = ("least-squares", "cma")
_LOSSES = ("soft_l1", "linear", "huber", "cauchy")
_MEMORY = {"auto": "auto", "on": True, "off": False}


@click.command(cls=Command)
@click.argument("arm_file", metavar="ARM.toml")
@click.argument("recording_files", metavar="RECORDING.toml [...]", nargs=-1)
@click.option("--free", "free", multiple=True, metavar="NAME ...", help="Parameters that the fit may change.")
@click.option(
    "--bounds", multiple=True, nargs=3, metavar="NAME LOW HIGH", help="Bounds of a free parameter; may come often."
)
@click.option(
    "--prior",
    multiple=True,
    nargs=3,
    metavar="NAME MEAN SD",
    help="What is known of a free parameter from elsewhere: mean and standard deviation; may come often.",
)
@click.option(
    "--hold-out",
    metavar="BLOCK,...|SHARE",
    help="Samples that are only predicted: blocks by name (* stands for anything), or a share of them, 0.25 or 25%.",
)
@click.option(
    "--starts",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    metavar="N",
    help="Searches: one from the arm as it is, the others from draws of priors and bounds.",
)
@click.option(
    "--loss",
    type=click.Choice(_LOSSES),
    default=_LOSSES[0],
    show_default=True,
    help="How large errors count: all but linear take outliers for what they are.",
)
@click.option(
    "--noise", type=LENGTH, metavar="X", help="Noise of one coordinate [m]; default estimated from what is left over."
)
@click.option(
    "--method",
    type=click.Choice(_METHODS),
    default=_METHODS[0],
    show_default=True,
    help="cma, an evolution strategy that least squares finish, is for many valleys; it needs the extra fit.",
)
@click.option(
    "--bootstrap",
    type=click.IntRange(0, 100_000),
    default=0,
    show_default=True,
    metavar="N",
    help="Resamplings of blocks, for a second kind of intervals.",
)
@click.option(
    "--rig",
    "rig_file",
    metavar="RIG.toml",
    help="What stands around the arm, in place of what the recordings say: a rig.toml of another fit, say.",
)
@click.option(
    "--memory",
    type=click.Choice(list(_MEMORY)),
    default="auto",
    show_default=True,
    help="Whether a pose at rest depends on those before; auto: where the arm has friction.",
)
@click.option(
    "--threads",
    type=click.IntRange(0, 4096),
    default=0,
    metavar="N",
    help="Most threads; default one for each processor. Poses with memory take one.",
)
@click.option("--names", is_flag=True, help="List all parameters that may be free, with units and present values.")
@out_option("runs/fit-<time>")
@figure_options()
@json_option
def fit(
    arm_file: str, recording_files: tuple[str, ...], free: tuple[str, ...], bounds: tuple[tuple[str, str, str], ...],
    prior: tuple[tuple[str, str, str], ...], hold_out: str | None, starts: int, loss: str, noise: float | None,
    method: str, bootstrap: int, rig_file: str | None, memory: str, threads: int, names: bool, out: str | None,
    prints: Prints, as_json: bool,
) -> int:  # fmt: skip
    """Fit an arm to recordings of a real one: parameters with intervals, and what the data do not determine.

    ARM.toml, or the name of a preset, is where the search starts from. RECORDING.toml says what was commanded and
    measured. Names with a star stand for several: section_*.bending_stiffness gives each section a value of its own.
    Leaves a folder: the fitted arm.toml and rig.toml, report.html, summary.json, tables. Ctrl-C ends the search and
    keeps what was found so far. Exit code 1 if the search did not converge, or nothing is determined.

    \b
    contarm fit arm.toml --names
    contarm fit arm.toml day1.toml --free bending_stiffness frame.* actuation.slack_*
    contarm fit arm.toml day1.toml --free muscle.stiffness --bounds muscle.stiffness 1kN 1e5
    contarm fit arm.toml day1.toml day2.toml --free section_*.bending_stiffness marker.offset.z
        --prior marker.offset.z 12mm 1mm --hold-out "circle*" --starts 8 --bootstrap 200
    """
    from contarm_sim.cli.given import arm_named, as_options, recording_in, say_findings
    from contarm_sim.cli.study import output_for
    from contarm_sim.errors import InputError
    from contarm_sim.identify.asked import free_of, held_out_from, units_of
    from contarm_sim.identify.fit import fit as fitted

    for option, rows, allowed in (("--bounds", bounds, "NAME LOW HIGH"), ("--prior", prior, "NAME MEAN SD")):
        if short := [row for row in rows if any(word.startswith("--") for word in row)]:  # the next option was taken
            raise InputError(option, " ".join(short[0]), allowed)
    arm = arm_named(arm_file)
    recordings = [recording_in(file, arm, rig_file) for file in recording_files]
    if names:
        _show_names(arm, recordings, rig_file, as_json)
        return 0
    if not recordings:
        raise InputError("RECORDING.toml", "missing", "one recording or more (see contarm fit --help)")
    if not free:
        raise InputError("--free", "missing", "names of parameters; contarm fit ARM.toml --names lists all")
    asked = free_of(free, units_of(arm, [one.rig for one in recordings]), bounds, prior)
    target, held = output_for(out, "fit"), held_out_from(hold_out, recordings)
    for recording in recordings:
        say_findings(recording)
    with as_options("--free", "--hold-out", "--noise", "--starts", "--memory"), _told() as told:
        found = fitted(arm, recordings, asked, held_out=held, loss=loss, noise=noise, method=method,  # type: ignore[arg-type]
                       starts=starts, bootstrap=bootstrap, memory=_MEMORY[memory], threads=threads,  # type: ignore[arg-type]
                       on_progress=told)  # fmt: skip
    if isinstance(held, float):
        _say_share(found, held)
    return _deliver(found, target, prints, as_json)


def _say_share(found: Fit, asked: float) -> None:
    """Say what share of the samples was held out, for blocks are not divided."""
    from contarm_sim.cli.terminal import say

    share = sum(int(left.held_out.sum()) for left in found.left) / sum(len(left.recording) for left in found.left)
    said = f"{100 * asked:.3g} % were asked for, and blocks are not divided"
    say(f"held out: {100 * share:.3g} % of the samples{'' if abs(share - asked) < 0.01 else f'; {said}'}")


def _told() -> Any:
    """Return a context of a function that is told of progress, and shows it on stderr: phase, evaluations, rms."""
    from contextlib import contextmanager

    from contarm_sim.cli.terminal import progress

    @contextmanager
    def opened() -> Any:
        last: list[Any] = []

        def words(done: int, total: int) -> str:
            step = last[0]
            of = f" of {step.of:,}" if step.of else ""
            return f"{step.phase}, evaluation {step.evaluation:,}{of}, rms {1e3 * step.rms:.3g} mm"

        with progress("fit", words) as show:

            def told(step: Any) -> None:
                last[:] = [step]
                show(step.evaluation, step.of)

            yield told

    return opened()


def _deliver(found: Fit, target: Path, prints: Prints, as_json: bool) -> int:
    """Write the folder, whole or not at all, print what was found, and return the exit code."""
    from contarm_sim.cli.study import deliver
    from contarm_sim.cli.terminal import command_line, say
    from contarm_sim.identify.fit_folder import save_fit
    from contarm_sim.stopping import came, exit_code
    from contarm_sim.view.report.fits.page import write_fit_report
    from contarm_sim.view.report.fits.summary import summary_of
    from contarm_sim.view.report.fits.words import negative

    summary = summary_of(found, command_line())

    def draw(folder: Path) -> None:
        save_fit(found, folder)
        write_fit_report(folder, found, summary, prints)

    deliver(target, summary, as_json, lambda: show(found), draw)
    if came() is not None:
        say("contarm: interrupted; what was found so far is kept")
        return exit_code()
    why = negative(found)
    if why:
        say(f"contarm: {why}")
    return 1 if why else 0


def show(found: Fit) -> None:
    """Print parameters with intervals, what is not determined, and errors."""
    from contarm_sim.cli.terminal import table, width
    from contarm_sim.view.report.fits import words

    table("", words.parameter_columns(found), words.rows_of(found))
    line, noted = min(width(), 120), dict[str, list[str]]()
    for one in found.parameters:
        if one.said:
            noted.setdefault(one.said, []).append(one.name)
    told = {name for names in noted.values() for name in names}
    twice = {one.said.rstrip(".") for one in found.undetermined if len(one.names) == 1 and one.names[0] in told}
    said = [f"{', '.join(names)}: {why}" for why, names in noted.items()]
    lost = [text for text in words.undetermined(found) if text not in twice]
    for title, lines in (("of single parameters:", said), ("not determined by the data:", lost)):
        if lines:
            click.echo("\n".join([title, *(click.wrap_text(text, line, "- ", "  ") for text in lines)]))
    table("", words.error_columns(), words.error_rows(found))
    for remark in words.remarks(found):
        click.echo(click.wrap_text(f"{remark[0].upper()}{remark[1:]}.", line))
    if not found.converged:
        click.echo(click.wrap_text(f"Unfinished: {found.message}.", line))
    click.echo(click.wrap_text(words.headline(found), line))


def _show_names(arm: Arm, recordings: list[Recording], rig_file: str | None, as_json: bool) -> None:
    from contarm_sim.identify.asked import units_of
    from contarm_sim.identify.freedom import values_of
    from contarm_sim.identify.recordings.rig import Rig
    from contarm_sim.identify.wildcards import families

    if recordings:
        rigs = [recording.rig for recording in recordings]
    elif rig_file is not None:
        from contarm_sim.identify.recordings.rig_file import load_rig

        rigs = [load_rig(rig_file, arm)]
    else:
        rigs = [Rig()]
    units, values = units_of(arm, rigs), dict[str, float]()
    for rig in reversed(rigs):
        own = list(units_of(arm, [rig]))
        values |= zip(own, values_of(arm, rig, own).tolist(), strict=True)
    starred = families(units)
    if as_json:
        from contarm_sim.view.report.output import to_json

        told = {name: {"unit": unit, "value": values[name]} for name, unit in units.items()}
        click.echo(to_json({"parameters": told, "together": starred}))
        return
    click.echo("May be free, with the present value (of several sections or markers, that of the first):")
    for name, unit in units.items():
        click.echo(f"  {name:36} {values[name]:>12.6g} {unit.replace('-', '')}".rstrip())
    click.echo("Names with a star give each of several a value of its own; without one, they share it:")
    for name, of_them in starred.items():
        click.echo(f"  {name:36} {len(of_them)} of them: {of_them[0]} to {of_them[-1]}")
