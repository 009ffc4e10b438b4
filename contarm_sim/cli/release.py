"""`contarm release`: hold a load, let go, and see whether the swing is to be believed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, muscles_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm

LIMIT = 0.1
"""Largest mean tip error, of step and links together [% of length]."""

GROWTH = 1e-3
"""Largest growth of energy between samples [shares of what the swing loses]: steps make it waver."""

DEFAULT_WRENCH = (1.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0)

MOST_SAMPLES = 100_000


@click.command(cls=Command)
@click.option(
    "--wrench", type=float, nargs=7, multiple=True,
    metavar="XI FX FY FZ MX MY MZ", show_default="0.3 N sideways at the tip",
    help="Force [N] and couple [N m] at a place on the backbone, 0 base to 1 tip, that hold the arm until it is let "
    "go; repeatable.",
)  # fmt: skip
@muscles_option("How muscles are driven, before and after: off, tensions, pressures, ... as in contarm equilibrium.")
@click.option(
    "--ramp-down", type=float, metavar="S", help="Let the load fade evenly over this time [s], not go at once."
)
@click.option(
    "--forces", metavar="FILE.csv",
    help="A force that changes: rows t,fx,fy,fz [s, N], t rising from 0, straight lines between. The arm is held "
    "by the first row; the last one stays.",
)  # fmt: skip
@click.option(
    "--forces-xi", type=float, default=1.0, show_default=True, metavar="X", help="Where the force of --forces acts."
)
@click.option("--duration", type=float, default=2.0, show_default=True, metavar="S", help="Time of the swing [s].")
@click.option("--timestep", type=float, default=0.001, show_default=True, metavar="S", help="Engine step [s].")
@click.option(
    "--sample-period", type=float, default=0.01, show_default=True, metavar="S",
    help="Time between samples [s], a multiple of the step.",
)  # fmt: skip
@click.option(
    "--xi", type=float, multiple=True, metavar="X ...", show_default="1, the tip",
    help="Places whose position and orientation are recorded, 0 base to 1 tip.",
)  # fmt: skip
@out_option("runs/release-<time>")
@json_option
@arm_options
def release(arm: Arm, wrench: Any, muscles: str, ramp_down: float | None, forces: str | None, forces_xi: float,
            duration: float, timestep: float, sample_period: float, xi: tuple[float, ...], out: str | None,
            as_json: bool) -> int:  # fmt: skip
    """Hold the arm by a load, let go, record the swing, and check it against the ideal arm.

    What steps in time leave is estimated from runs of half and a quarter of the step, what links leave from a run of
    half as many; where an arm with neither would be stands beside the swing in swing.csv. Without muscles energy must
    not grow. Natural frequencies stand beside those of a clamped beam with the arm's payload and rotary inertia, and a
    small swing of the first mode beside its frequency and decay. Exit code 1 if the mean tip error, of step and links
    together, exceeds 0.1 % of length, or energy grows.

    \b
    contarm release
    contarm release --section-radius 0.003 --xi 0.5 1 --sample-period 0.001
    contarm release --wrench 1 0 0.5 0 0 0 0 --gravity 0 0 9.81 --payload 0.05 --duration 3
    contarm release --wrench 1 0.3 0 0 0 0 0 --wrench 0.5 0 0.3 0 0 0 0 --ramp-down 0.2
    contarm release --forces push.csv --forces-xi 0.5

    Less error: smaller steps for the row "step", more --links for the row "links". An arm that diverges has too little
    damping for its step: take one below twice its --damping-time, or, with none, about 0.1 ms at 24 links.
    A thin rod: give --section-radius, or its mass fills a section as wide as the disks, which slows the higher modes.
    swing.csv has time and energy, position and orientation (quaternion w x y z) at every place, and the
    ideal position, extrapolated from those runs.
    """
    import numpy as np

    from contarm_sim.cli.options import muscles_from_words
    from contarm_sim.cli.terminal import command_line, say, track
    from contarm_sim.model.arm_file import arm_to_dict
    from contarm_sim.model.load import Load, Wrench
    from contarm_sim.motion.modes import swing_modes
    from contarm_sim.motion.swing_error import judged_release
    from contarm_sim.statics.equilibrium import equilibrium
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json, versions
    from contarm_sim.view.report.swing import draw_swing, swing_columns, swing_dict

    _check(duration, timestep, sample_period, ramp_down, forces)
    target = Path(out) if out is not None else default_folder("release")
    check_output(target)
    if not wrench and forces is None:
        wrench = (DEFAULT_WRENCH,)
    held = tuple(Wrench(xi=w[0], force=w[1:4], moment=w[4:]) for w in wrench)
    load, course = Load(wrenches=held, muscles=muscles_from_words(muscles)), None
    if ramp_down is not None or forces is not None:
        load, course = _changing(load, ramp_down, forces, forces_xi)
    if not equilibrium(arm, load).stable:
        say("the arm does not rest under this load: no stable pose to let go from")
        return 1
    found = judged_release(
        arm, load, timestep, duration, sample_period=sample_period, xi=xi or (1.0,), course=course,
        track=lambda runs: track(runs, "swinging"),
    )  # fmt: skip
    swing = found.swing
    grown, lost = max(float(np.diff(swing.energy).max()), 0.0), float(swing.energy[0] - swing.energy[-1])
    passive = load.muscles.kind == "off" and arm.damping_time > 0 and course is None
    rounding = 1e-12 * float(np.abs(swing.energy).max())
    percent = {name: 100 * float(getattr(found, name).mean()) / arm.length for name in ("total", "step", "links")}
    summary: dict[str, Any] = {
        "tip_error_mean_percent": percent["total"],
        "step_error_mean_percent": percent["step"],
        "links_error_mean_percent": percent["links"],
        "observed_order": found.order,
        "largest_energy_growth_j": grown if passive else None,
        "energy_lost_j": lost if passive else None,
        **swing_modes(arm, load, timestep),
        "timestep": timestep, "duration": duration, "sample_period": sample_period, "arm": arm_to_dict(arm),
        "versions": versions(), "command": command_line(),
    }  # fmt: skip
    reasons = []
    if not percent["total"] <= LIMIT:
        reasons.append(
            f"the tip error is {percent['total']:.3g} % of length (limit {LIMIT:g}): take smaller steps or more links"
        )
    if passive and not grown <= GROWTH * max(lost, 0.0) + rounding:
        reasons.append(f"energy grows by {grown:.2g} J: smaller steps")
    summary |= {"verdict": "fail" if reasons else "pass", "reasons": reasons}
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        header, columns = swing_columns(found)
        np.savetxt(opened.folder / "swing.csv", columns, delimiter=",", fmt="%.9g", comments="", header=header)
        draw_swing(opened.folder / "swing.png", arm, found)
    if as_json:
        click.echo(to_json({**summary, **swing_dict(found)}))
    else:
        _show(summary, arm, passive)
    say(f"written: {opened.target}")
    return 1 if reasons else 0


def _check(duration: float, timestep: float, sample_period: float, ramp_down: float | None, forces: str | None) -> None:
    if not 0.05 <= duration <= 60:
        raise InputError("duration", duration, "0.05 to 60 s")
    if not 1e-5 <= sample_period <= duration:
        raise InputError("sample-period", sample_period, f"1e-5 s to the duration, {duration:g} s")
    if duration / sample_period > MOST_SAMPLES:
        raise InputError("sample-period", sample_period, f"at most {MOST_SAMPLES} samples")
    if not 1e-5 <= timestep <= sample_period:
        raise InputError("timestep", timestep, f"1e-5 s to the sample period, {sample_period:g} s")
    if ramp_down is not None and forces is not None:
        raise InputError("input", "both --ramp-down and --forces", "one of them")


def _changing(load: Any, ramp: float | None, file: str | None, xi: float) -> tuple[Any, Any]:
    """Return the load that holds the arm, and its course."""
    import numpy as np

    from contarm_sim.motion.course import forces_over_time, load_at, ramp_down, remaining

    if ramp is not None:
        return load, ramp_down(ramp)
    assert file is not None
    allowed = "rows t,fx,fy,fz, a header above them if you like"
    try:
        lines = [line for line in Path(file).read_bytes().decode().splitlines() if line.strip()]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            "forces", f"unreadable ({getattr(error, 'strerror', None) or 'not text'})", allowed, file
        ) from error
    if lines and lines[0].lstrip()[:1].isalpha():
        lines = lines[1:]
    try:
        rows = np.array([[float(word) for word in line.split(",")] for line in lines])
    except ValueError as error:
        raise InputError("forces", f"not a table ({error})", allowed, file) from error
    if rows.ndim != 2 or rows.shape[1] != 4:
        raise InputError("forces", f"a table of shape {rows.shape}", allowed, file)
    try:
        course = forces_over_time(rows[:, 0], rows[:, 1:], remaining(load), xi)
        first = load_at(course, load, 0.0)[0]
    except InputError as error:
        raise error.located(file) from None
    return replace(load, wrenches=(*load.wrenches, *first.wrenches)), course


def _show(summary: dict[str, Any], arm: Arm, passive: bool) -> None:
    from contarm_sim.cli.terminal import table

    rows = []
    for name, what in (
        ("step_error_mean_percent", f"step, {1e3 * summary['timestep']:g} ms"),
        ("links_error_mean_percent", f"links, {arm.links}"),
        ("tip_error_mean_percent", "both together"),
    ):
        rows.append([what, f"{summary[name]:.4f}", f"{10 * summary[name] * arm.length:.4f}"])
    table("mean tip error, estimated", ["what leaves it", "[% of length]", "[mm]"], rows)
    columns = ["mode", "clamped beam [Hz]", "chain, no gravity [Hz]", "off [%]"]
    pairs = zip(summary["beam_hz"], summary["chain_hz"], strict=False)
    modes = [[str(i), f"{b:.3f}", f"{c:.3f}", f"{100 * (c / b - 1):+.3f}"] for i, (b, c) in enumerate(pairs, 1)]
    table("natural frequencies in either plane", columns, modes)
    small, expected = summary["small_swing"], summary["small_swing_of_beam"]
    if small is not None:
        click.echo(
            f"first mode in motion: {small['hz']:.4f} Hz, decay {small['decay_per_s']:.4f} /s; "
            f"beam {expected['hz']:.4f} Hz, {expected['decay_per_s']:.4f} /s"
        )
    click.echo(f"this arm, where it comes to rest: {', '.join(f'{f:.3f}' for f in summary['arm_hz'])} Hz")
    if passive:
        lost, grown = summary["energy_lost_j"], summary["largest_energy_growth_j"]
        click.echo(
            f"energy: {lost:.4g} J lost in {summary['duration']:g} s, largest growth between samples {grown:.1g} J"
        )
    reasons = f": {'; '.join(summary['reasons'])}" if summary["reasons"] else ""
    click.echo(f"verdict: {summary['verdict'].upper()}{reasons}")
