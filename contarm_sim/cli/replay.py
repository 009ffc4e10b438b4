"""`contarm replay`: a recording of a real arm, predicted by a simulated one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import LENGTH, Command, json_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.view.prints import Prints

if TYPE_CHECKING:
    from contarm_sim.identify.fitted import Fit
    from contarm_sim.identify.recordings.recording import Recording
    from contarm_sim.identify.replays.replay import Replay
    from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.argument("words", metavar="[ARM.toml|FIT_FOLDER] RECORDING.toml", nargs=-1)
@click.option("--fit", "fit_folder", metavar="FOLDER", help="What contarm fit left: its arm, its rig, its covariance.")
@click.option(
    "--rig", "rig_file", metavar="RIG.toml", help="What stands around the arm, in place of what is said there."
)
@click.option(
    "--samples", type=click.IntRange(1), metavar="N",
    help="Predict so many only: evenly picked where samples do not remember those before, else the first.",
)  # fmt: skip
@click.option("--within", type=LENGTH, metavar="X", help="Exit code 1 if the rms is larger [m]: 0.01, 10mm.")
@click.option(
    "--threads",
    type=click.IntRange(0, 4096),
    default=0,
    metavar="N",
    help="Most threads; default one a processor. Poses with memory take one.",
)
@click.option("--no-video", is_flag=True, help="Numbers and figures only.")
@out_option("runs/replay-<time>")
@figure_options()
@json_option
def replay(words: tuple[str, ...], fit_folder: str | None, rig_file: str | None, samples: int | None,
           within: float | None, threads: int, no_video: bool, out: str | None, prints: Prints, as_json: bool,
           ) -> int:  # fmt: skip
    """Predict a recording of a real arm, and compare: markers, whole shape, swings.

    ARM.toml may be the name of a preset, or the folder of a fit; then the fit's rig takes the place of the recording's,
    and its covariance gives each sample a 95 % band. Leaves report.html, replay.csv, replay.npz, summary.json, figures
    and video.mp4: the simulated arm with the real markers. Exit code 1 if --within is not met, or nothing is predicted.

    \b
    contarm replay arm.toml day2.toml
    contarm replay runs/fit-20260101-120000 day2.toml --within 10mm
    contarm replay --fit runs/fit-20260101-120000 day2.toml --samples 200 --no-video --json
    """
    from contarm_sim.cli.drawing import draw, film_at_first, say_missing
    from contarm_sim.cli.given import say_findings
    from contarm_sim.cli.study import output_for
    from contarm_sim.cli.terminal import command_line, progress, say
    from contarm_sim.stopping import exit_code, unbroken
    from contarm_sim.view.report.output import OutputFolder, to_json
    from contarm_sim.view.report.replays.report import ReplayReport

    arm, recording, given = _given(words, fit_folder, rig_file)
    if within is not None and within >= arm.length:
        allowed = f"a length with its unit, such as 5mm, below that of the arm, {arm.length:.3g} m"
        raise InputError("--within", f"{within:g} m", allowed)
    target = output_for(out, "replay")
    say_findings(recording)
    with progress("predicting") as show:
        show(0, 1)
        found = _predicted(arm, recording, given, rig_file is None, samples, threads)
    job = ReplayReport(found)
    summary = job.told(command=command_line(), video=film_at_first(False, not no_video), within=within)
    with unbroken():  # numbers first, whole; a signal then ends the drawing
        with OutputFolder(target) as opened:
            job.write(opened.folder)
            (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        missing, failed = draw(job, opened.target, summary, prints, again="contarm replay")
        if as_json:
            click.echo(to_json(summary))
        else:
            show_replay(found)
        say(f"written: {opened.target}")
        if missing:
            say_missing(missing)
            return exit_code()
    return 1 if failed or _short(found, within) else 0


def _given(words: tuple[str, ...], fit_folder: str | None, rig_file: str | None) -> tuple[Arm, Recording, Fit | None]:
    """Return arm, recording and fit that the arguments name.

    Raises:
        InputError: not one recording, or no arm.
    """
    from contarm_sim.cli.given import arm_named, recording_in
    from contarm_sim.identify.fit_folder import load_fit

    files = list(words)
    if len(files) == 2 and Path(files[0]).is_dir():
        if fit_folder is not None:
            raise InputError("--fit", fit_folder, "one fit: its folder is the first argument already")
        fit_folder = files.pop(0)
    if len(files) != 2 - (fit_folder is not None and len(files) == 1):
        given = f"{len(words)} arguments" if len(words) != 1 else repr(words[0])
        raise InputError("arguments", given, "an arm (or the folder of a fit) and a recording")
    fit = load_fit(fit_folder) if fit_folder is not None else None
    if len(files) == 2:
        arm = arm_named(files[0])
    else:
        assert fit is not None
        arm = fit.arm
    return arm, recording_in(files[-1], arm, rig_file), fit


def _predicted(arm: Arm, recording: Recording, fit: Fit | None, fitted_rig: bool, samples: int | None, threads: int,
               ) -> Replay:  # fmt: skip
    """Return the recording, or some samples of it, predicted, with bands where the fit is of this arm."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.identify.replays.by_fit import by_fit
    from contarm_sim.identify.replays.replay import replay as replayed
    from contarm_sim.identify.replays.replay import some_samples

    covariance, held_out = None, None
    if fit is not None:
        found = by_fit(fit, arm, recording, own_rig=not fitted_rig)
        recording, held_out, covariance = found.recording, found.held_out, found.covariance
        if covariance is None:
            say("no bands: the arm or the rig is not the fit's, or the fit determined nothing")
    rows = some_samples(arm, recording, samples)
    held = None if held_out is None else held_out[rows]
    return replayed(arm, recording.part(rows), covariance, held_out=held, threads=threads)


def _short(found: Replay, within: float | None) -> bool:
    """Tell whether a replay does not keep to what was asked, and say so."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.report.replays.words import millimetres

    error = found.differences()
    if not error.count:
        say("contarm: nothing was predicted")
        return True
    if within is not None and error.rms > within:
        say(
            f"contarm: the rms of {millimetres(error.rms)} mm is above the {millimetres(within)} mm that were asked for"
        )
        return True
    return False


def show_replay(found: Replay) -> None:
    """Print errors by marker and by block, and what they are to be compared with."""
    from contarm_sim.cli.terminal import table, width
    from contarm_sim.view.report.replays import words

    table("errors [mm]", ["", *words.COLUMNS], words.marker_rows(found))
    blocks = words.block_rows(found, words.MOST_BLOCKS)
    count = len(found.by_block())
    if count > 1:
        title = "by block" if len(blocks) == count else f"by block, the {len(blocks)} worst of {count}"
        table(f"{title} [mm]", ["", *words.COLUMNS], blocks)
    if stretch := words.stretch_rows(found):
        table("distances between markers [mm]", ["", "mean difference", "its rms"], stretch)
    if found.swings:
        table("free swings", ["block", *words.SWINGS], words.swing_rows(found))
    line = min(width(), 120)
    for said in (words.headline(found), words.lead(found)):
        click.echo(click.wrap_text(said, line))
    for each in words.standings(found):
        click.echo(click.wrap_text(f"{each.title} {each.text}".replace("`", ""), line))
