"""`contarm excite`: what to command next, so that a fit knows most."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import ANGLE, LENGTH, Command, json_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.view.prints import Prints

if TYPE_CHECKING:
    from contarm_sim.identify.excite import Excitation
    from contarm_sim.identify.fitted import Fit
    from contarm_sim.identify.recordings.recording import Recording
    from contarm_sim.identify.recordings.rig import Rig
    from contarm_sim.identify.replays.written import Written
    from contarm_sim.model.arm import Arm

ROWS = 3
"""Most commands that are printed: all are in commands.csv."""


@click.command(cls=Command)
@click.argument("arm_file", metavar="ARM.toml|FIT_FOLDER")
@click.argument("rig_file", metavar="RIG.toml|RECORDING.toml", required=False)
@click.option("--free", "free", multiple=True, metavar="NAME ...", help="Parameters that are to be known better.")
@click.option(
    "--count", type=click.IntRange(1, 1000), default=4, show_default=True, metavar="N",
    help="Patterns to propose; of candidates without patterns, poses.",
)  # fmt: skip
@click.option(
    "--candidates", default="60", show_default=True, metavar="N|FILE.csv",
    help="To choose among: random patterns of 12 poses, or commands, written as the recording has them; a column "
    "block names patterns that are taken whole.",
)  # fmt: skip
@click.option("--known", "known_file", metavar="RECORDING.toml", help="What has been measured already.")
@click.option(
    "--criterion", type=click.Choice(["D", "A"]), default="D", show_default=True,
    help="What is made small: the volume of the parameters' 95 % region (D), or the sum of their variances (A).",
)  # fmt: skip
@click.option("--noise", type=LENGTH, metavar="X", help="Noise of one coordinate [m]; default the fit's, or 0.5 mm.")
@click.option(
    "--bend", type=ANGLE, default=1.0, show_default=True, metavar="X", help="Largest bend of random patterns."
)
@click.option(
    "--limits",
    type=float,
    nargs=2,
    metavar="LOW HIGH",
    help="Lowest and highest command of a channel, in the unit of the commands.",
)
@click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    metavar="N",
    help="Of the random patterns: another number draws others.",
)
@out_option("runs/excite-<time>")
@figure_options()
@json_option
def excite(
    arm_file: str, rig_file: str | None, free: tuple[str, ...], count: int, candidates: str, known_file: str | None,
    criterion: Any, noise: float | None, bend: float, limits: tuple[float, float] | None, seed: int, out: str | None,
    prints: Prints, as_json: bool,
) -> None:  # fmt: skip
    """Propose what to command next, so that a fit of the free parameters knows most.

    Of a fit's folder the fitted arm, rig and noise are taken. A recording that is given counts as measured already, and
    says how commands are written. Leaves commands.csv, with the names, the unit and the sign of the recording (of a
    rig: SI units), ready for the rig; summary.json; and the figure gain: what each further pattern tells.

    \b
    contarm excite arm.toml rig.toml --free section_*.bending_stiffness actuation.slack --count 6
    contarm excite runs/fit-20260101-120000 day1.toml --free section_*.bending_stiffness --limits -10 4
    contarm excite arm.toml day1.toml --free frame.* --candidates possible.csv --count 20
    """
    from contarm_sim.cli.given import as_options
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import progress
    from contarm_sim.identify.asked import free_of, units_of
    from contarm_sim.identify.excite import excite as excited
    from contarm_sim.identify.replays.written import written_of
    from contarm_sim.view.report.excited import draw_gain
    from contarm_sim.view.style import save

    arm, rig, known, fit, recorded = _given(arm_file, rig_file, known_file)
    if not free:
        raise InputError("--free", "missing", "names of parameters; contarm fit ARM.toml --names lists all")
    names = [one.name for one in free_of(free, units_of(arm, [rig]))]
    written = written_of(rig, recorded)
    if lost := [name for name in names if "damping" in name]:
        raise InputError("--free", lost[0], "what poses show: an arm at rest does not show its damping")
    if limits is not None and limits[0] > limits[1]:
        raise InputError("--limits", f"{limits[0]:g} {limits[1]:g}", "the lowest first, then the highest")
    table, blocks = _candidates(candidates, written)
    target = output_for(out, "excite")
    ends = None if limits is None else tuple(sorted(written.worth * end for end in limits))
    with as_options("--count", "--free", "--noise", "--candidates"), progress("weighing candidates") as show:
        show(0, 1)
        found = excited(arm, rig, names, candidates=table, blocks=blocks, count=count, criterion=criterion,
                        recording=known, noise=noise or (fit.noise if fit else 0.0005), bend=bend, limits=ends,  # type: ignore[arg-type]
                        seed=seed)  # fmt: skip
    summary = signed({name: getattr(found, name) for name in _TOLD}) | _said(found, written, known)

    def draw(folder: Path) -> None:
        (folder / "commands.csv").write_text(written.text(found.commands, found.blocks), encoding="utf-8")
        save(folder, "gain", lambda sheet: draw_gain(sheet, found), prints)

    unsure = [one.name for one in fit.parameters if one.name not in names] if fit else []
    deliver(target, summary, as_json, lambda: _show(found, written, known, unsure), draw)


_TOLD = ("names", "units", "values", "sd_before", "sd_after", "steps", "gain", "refused")


def _said(found: Excitation, written: Written, known: Recording | None) -> dict[str, Any]:
    gains = zip(found.patterns, found.gains.tolist(), strict=True)
    return {
        "chosen": [found.patterns[k] for k in found.chosen],
        "gains": {name: None if gain != gain else gain for name, gain in gains},
        "known": None if known is None else known.name,
        "commands": {
            "columns": list(written.columns),
            "unit": written.unit,
            "rows": written.numbers(found.commands).tolist(),
            "blocks": found.blocks.tolist(),
        },
    }


def _given(
    arm_file: str, rig_file: str | None, known_file: str | None
) -> tuple[Arm, Rig, Recording | None, Fit | None, str | None]:
    """Return arm, rig, what is measured already, a fit, and the recording's file, as the arguments say.

    Raises:
        InputError: no rig.
    """
    from contarm_sim.cli.given import arm_named
    from contarm_sim.identify.fit_folder import load_fit
    from contarm_sim.identify.recordings.file import load_recording
    from contarm_sim.identify.recordings.rig_file import load_rig, read_toml

    fit = load_fit(arm_file) if Path(arm_file).is_dir() else None
    arm = arm_named(arm_file) if fit is None else fit.arm
    rig, known, recorded = None if fit is None else fit.rig, None, None
    if rig_file is not None and "data" in read_toml(Path(rig_file), "[frame], position = [0, 0, 0]"):
        recorded, known = rig_file, load_recording(rig_file, arm)
        rig = rig or known.rig
    elif rig_file is not None:
        rig = load_rig(rig_file, arm)
    if rig is None:
        raise InputError(
            "RIG.toml", "missing", "a rig or a recording: what the arm is driven by and what is seen of it"
        )
    if known_file is not None:
        known = load_recording(known_file, arm)
    return arm, rig, known, fit, recorded


def _candidates(given: str, written: Written) -> tuple[Any, list[str] | None]:
    """Return a number of random patterns, or a table of commands in SI units and the pattern of each row."""
    return (int(given), None) if given.isdigit() else written.read(given)


def _show(found: Excitation, written: Written, known: Recording | None, unsure: list[str]) -> None:
    """Print the proposed patterns, their commands, and what is known of the parameters before and after.

    Args:
        unsure: names of parameters that count as known, though a fit had them free.
    """
    import math

    import numpy as np

    from contarm_sim.cli.terminal import table, width
    from contarm_sim.view.report.excited import parameter_rows, pattern_rows, told

    table(
        "proposed, the most telling first",
        ["pattern", "poses", "information alone [nats]", "besides those above"],
        pattern_rows(found),
    )
    values = written.numbers(found.commands)
    places = max(0, 3 - math.floor(math.log10(max(float(np.abs(values).max()), 1e-9))))
    names = ["", *found.blocks.tolist()]
    rows = [
        [name if name != before else "", *(f"{x:.{places}f}" for x in row)]
        for before, name, row in zip(names, names[1:], values.tolist(), strict=False)
    ]
    more = "" if len(rows) <= ROWS else f", the first {ROWS} of {len(rows)} in commands.csv"
    table(f"commands, {written.unit}{more}", ["pattern", *written.columns], rows[:ROWS])
    table("expected standard deviations", ["", "unit", "value", "before", "after", "smaller by"], parameter_rows(found))
    click.echo(click.wrap_text(told(found, known), min(width(), 120)))
    if unsure:
        said = f"Taken as known, though the fit had them free: {', '.join(unsure)}."
        click.echo(click.wrap_text(said, min(width(), 120)))
