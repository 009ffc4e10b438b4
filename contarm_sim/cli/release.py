"""`contarm release`: hold a load, let go, and see whether the swing is to be believed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim import studies
from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import TIME, Command, arm_options, json_option, muscles_option, out_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints


@click.command(cls=Command)
@click.option(
    "--wrench", type=float, nargs=7, multiple=True,
    metavar="XI FX FY FZ MX MY MZ", show_default="0.3 N sideways at the tip",
    help="Force [N] and couple [N m] at a place on the backbone, 0 base to 1 tip, that hold the arm until it is let "
    "go; repeatable.",
)  # fmt: skip
@muscles_option("How muscles are driven, before and after: off, tensions, pressures, ... as in contarm equilibrium.")
@click.option(
    "--ramp-down", type=TIME, metavar="S", help="Let the load fade evenly over this time [s], not go at once."
)
@click.option(
    "--forces", metavar="FILE.csv",
    help="A force that changes: rows t,fx,fy,fz [s, N], t rising from 0, straight lines between. The arm is held "
    "by the first row; the last one stays.",
)  # fmt: skip
@click.option(
    "--forces-xi", type=float, default=1.0, show_default=True, metavar="X", help="Where the force of --forces acts."
)
@click.option("--duration", type=TIME, default=2.0, show_default=True, metavar="S", help="Time of the swing [s].")
@click.option("--timestep", type=TIME, default=0.001, show_default=True, metavar="S", help="Engine step [s].")
@click.option(
    "--sample-period", type=TIME, default=0.01, show_default=True, metavar="S",
    help="Time between samples [s], a multiple of the step.",
)  # fmt: skip
@click.option(
    "--xi", type=float, multiple=True, metavar="X ...", show_default="1, the tip",
    help="Places whose position and orientation are recorded, 0 base to 1 tip.",
)  # fmt: skip
@out_option("runs/release-<time>")
@figure_options()
@json_option
@arm_options
def release(arm: Arm, wrench: Any, muscles: str, ramp_down: float | None, forces: str | None, forces_xi: float,
            duration: float, timestep: float, sample_period: float, xi: tuple[float, ...], out: str | None,
            prints: Prints, as_json: bool) -> int:  # fmt: skip
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
    from contarm_sim.cli.study import deliver, output_for, signed
    from contarm_sim.cli.terminal import track
    from contarm_sim.model.load import Load, Wrench
    from contarm_sim.motion.course import ramp_down as fading
    from contarm_sim.studies.force_table import forces_from_file
    from contarm_sim.studies.swings import SIDEWAYS
    from contarm_sim.view.report.swing import draw_swing, swing_columns, swing_dict
    from contarm_sim.view.style import save

    if ramp_down is not None and forces is not None:
        raise InputError("input", "both --ramp-down and --forces", "one of them")
    target = output_for(out, "release")
    held = tuple(Wrench(xi=w[0], force=w[1:4], moment=w[4:]) for w in wrench)
    if not wrench and forces is None:
        held = SIDEWAYS.wrenches
    load, course = Load(wrenches=held, muscles=muscles_from_words(muscles)), None
    if ramp_down is not None:
        course = fading(ramp_down)
    if forces is not None:
        load, course = forces_from_file(forces, load, forces_xi)
    found = studies.release(
        arm, load, studies.SwingSettings(timestep, duration, sample_period, xi or (1.0,), course), track
    )

    def draw(folder: Path) -> None:
        header, columns = swing_columns(found.swing)
        np.savetxt(folder / "swing.csv", columns, delimiter=",", fmt="%.9g", comments="", header=header)
        save(folder, "swing", lambda sheet: draw_swing(sheet, arm, found.swing), prints)

    summary = signed(found)
    summary |= {name: summary.pop(name) for name in ("verdict", "reasons")}  # they come last
    deliver(target, summary, as_json, lambda: _show(found), draw, swing_dict(found.swing))
    return 0 if found.verdict == "pass" else 1


def _show(found: studies.Release) -> None:
    from contarm_sim.cli.terminal import table

    rows = [
        [what, f"{percent:.4f}", f"{10 * percent * found.arm.length:.4f}"]
        for what, percent in (
            (f"step, {1e3 * found.settings.timestep:g} ms", found.step_error_mean_percent),
            (f"links, {found.arm.links}", found.links_error_mean_percent),
            ("both together", found.tip_error_mean_percent),
        )
    ]
    table("mean tip error, estimated", ["what leaves it", "[% of length]", "[mm]"], rows)
    modes = found.modes
    columns = ["mode", "clamped beam [Hz]", "chain, no gravity [Hz]", "off [%]"]
    pairs = zip(modes.beam_hz, modes.chain_hz, strict=False)
    lines = [[str(i), f"{b:.3f}", f"{c:.3f}", f"{100 * (c / b - 1):+.3f}"] for i, (b, c) in enumerate(pairs, 1)]
    table("natural frequencies in either plane", columns, lines)
    small, expected = modes.small_swing, modes.small_swing_of_beam
    if small is not None and expected is not None:
        click.echo(
            f"first mode in motion: {small.hz:.4f} Hz, decay {small.decay_per_s:.4f} /s; "
            f"beam {expected.hz:.4f} Hz, {expected.decay_per_s:.4f} /s"
        )
    click.echo(f"this arm, where it comes to rest: {', '.join(f'{f:.3f}' for f in modes.arm_hz)} Hz")
    lost, grown = found.energy_lost_j, found.largest_energy_growth_j
    if lost is not None:
        within = f"{found.settings.duration:g} s"
        click.echo(f"energy: {lost:.4g} J lost in {within}, largest growth between samples {grown:.1g} J")
    reasons = f": {'; '.join(found.reasons)}" if found.reasons else ""
    click.echo(f"verdict: {found.verdict.upper()}{reasons}")
