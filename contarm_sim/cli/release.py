"""`contarm release`: hold a load, let go, and see whether the swing is to be believed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.arm import Arm
from contarm_sim.cli.options import Command, arm_options, json_option, muscles_option, out_option
from contarm_sim.errors import InputError

FINER = 20
LIMIT = 0.1
"""Largest mean tip error against the finer run [% of length]."""


@click.command(cls=Command)
@click.option(
    "--wrench", type=float, nargs=7, multiple=True, default=((1.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0),),
    metavar="XI FX FY FZ MX MY MZ", show_default="0.3 N sideways at the tip",
    help="Force [N] and couple [N m] at a backbone station that holds the arm until it is let go; repeatable.",
)  # fmt: skip
@muscles_option("How muscles are driven, before and after: off, tensions, pressures, ... as in contarm equilibrium.")
@click.option("--duration", type=float, default=2.0, show_default=True, metavar="S", help="Time of the swing [s].")
@click.option("--timestep", type=float, default=0.001, show_default=True, metavar="S", help="Engine step [s].")
@out_option("runs/release-<time>")
@json_option
@arm_options
def release(arm: Arm, wrench: Any, muscles: str, duration: float, timestep: float, out: str | None,
            as_json: bool) -> int:  # fmt: skip
    """Hold the arm by a load, let go, record the swing, and check it.

    Against a run of 20 times finer steps (tip error, and the order in which it falls), against physics (energy must
    not grow), and against the closed form of a clamped beam (natural frequencies). Exit code 1 if the mean tip error
    exceeds 0.1 % of length or energy grows.

    \b
    contarm release
    contarm release --wrench 1 0 0.5 0 0 0 0 --gravity 0 0 9.81 --payload 0.05 --duration 3
    """
    import numpy as np

    from contarm_sim.arm_file import arm_to_dict
    from contarm_sim.cli.options import muscles_from_words
    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.load import Load, Wrench
    from contarm_sim.report.figures import draw_swing
    from contarm_sim.report.output import OutputFolder, check_output, default_folder, to_json, versions
    from contarm_sim.simulation import release as swinging
    from contarm_sim.simulation.equilibrium import equilibrium

    if not 0.05 <= duration <= 60:
        raise InputError("duration", duration, "0.05 to 60 s")
    if not 1e-5 <= timestep <= swinging.SAMPLE_PERIOD:
        raise InputError("timestep", timestep, f"1e-5 to {swinging.SAMPLE_PERIOD:g} s")
    target = Path(out) if out is not None else default_folder("release")
    check_output(target)
    load = Load(
        wrenches=tuple(Wrench(xi=w[0], force=w[1:4], moment=w[4:]) for w in wrench), muscles=muscles_from_words(muscles)
    )
    held = equilibrium(arm, load)
    if not held.stable:
        say("the arm does not rest under this load: no stable pose to let go from")
        return 1
    steps = [timestep, timestep / 2, timestep / FINER]
    swings = [swinging.release(arm, held.qpos, load, steps[i], duration) for i in track(range(3), "swinging")]
    coarse, half, fine = swings
    errors = [np.linalg.norm(swing.tip - fine.tip, axis=1).mean() / arm.length for swing in (coarse, half)]
    grown = max(float(np.diff(coarse.energy).max()), 0.0)
    lost = float(coarse.energy[0] - coarse.energy[-1])
    passive = load.muscles.kind == "off" and arm.damping_time > 0  # undamped, energy wavers by the step's own error
    rounding = 1e-9 * abs(lost) + 1e-12 * float(np.abs(coarse.energy).max())
    frequencies = {
        "beam_hz": swinging.beam_frequencies(arm),
        "chain_hz": swinging.natural_frequencies(swinging.bare(arm), Load(), 6)[::2],
        "arm_hz": swinging.natural_frequencies(arm, load, 6),
    }
    summary: dict[str, Any] = {
        "tip_error_mean_percent": 100 * float(errors[0]),
        "tip_error_mean_percent_half_step": 100 * float(errors[1]),
        # Against 20 times finer steps, not exact ones: e(h) - e(h/20) over e(h/2) - e(h/20) is 1.9/0.9 for order 1.
        "observed_order": _order(float(errors[0]), float(errors[1])),
        "largest_energy_growth_j": grown if passive else None,
        "energy_lost_j": lost if passive else None,
        **{name: values.tolist() for name, values in frequencies.items()},
        "timestep": timestep, "duration": duration, "arm": arm_to_dict(arm), "versions": versions(),
        "command": command_line(),
    }  # fmt: skip
    good = summary["tip_error_mean_percent"] <= LIMIT and (not passive or grown <= rounding)
    summary["verdict"] = "pass" if good else "fail"
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        np.savetxt(
            opened.folder / "swing.csv", np.column_stack([coarse.time, coarse.tip, coarse.energy, fine.tip]),
            delimiter=",", fmt="%.9g", comments="",
            header="time_s,tip_x_m,tip_y_m,tip_z_m,energy_j,fine_tip_x_m,fine_tip_y_m,fine_tip_z_m",
        )  # fmt: skip
        draw_swing(opened.folder / "swing.png", arm, coarse, fine, timestep)
    if as_json:
        click.echo(to_json(summary))
    else:
        columns = ["mode", "clamped beam [Hz]", "chain, free [Hz]"]
        beam, chain = frequencies["beam_hz"], frequencies["chain_hz"]
        rows = [[str(i + 1), f"{beam[i]:.3f}", f"{chain[i]:.3f}"] for i in range(min(len(beam), len(chain)))]
        table("natural frequencies in either plane", columns, rows)
        click.echo(f"this arm, where it comes to rest: {', '.join(f'{f:.3f}' for f in frequencies['arm_hz'])} Hz")
        mean, order = summary["tip_error_mean_percent"], summary["observed_order"]
        click.echo(
            f"tip error against {FINER} times finer steps: {mean:.4f} % of length in the mean; order "
            + ("-" if order is None else f"{order:.2f}")
        )
        if passive:
            click.echo(f"energy: {lost:.4g} J lost in {duration:g} s, largest growth between samples {grown:.1g} J")
        click.echo(f"verdict: {summary['verdict'].upper()}")
    say(f"written: {opened.target}")
    return 0 if good else 1


def _order(coarse: float, half: float) -> float | None:
    """Return the order p at which (1 - f^p)/(2^-p - f^p), f = 1/20, is the ratio of errors of a step and its half.

    None where nothing moved, or no order explains them.
    """
    from scipy.optimize import brentq

    f = 1 / FINER

    def off(p: float) -> float:
        return float((1 - f**p) / (0.5**p - f**p) - coarse / half)

    if not half > 1e-12 or off(0.05) * off(6) > 0:
        return None
    return float(brentq(off, 0.05, 6))
