"""`contarm compare-controllers`: the spiral under every controller, with and without gravity and payload."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.arm import Arm
from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.errors import ConvergenceError, DivergenceError

SETTLED = 1.0
"""Errors count from this time on [s]: a path may start in a sagging pose."""


@click.command(cls=Command, name="compare-controllers")
@click.option("--duration", type=float, default=10.0, show_default=True, metavar="S", help="Time for the spiral [s].")
@out_option("runs/compare-controllers-<time>")
@json_option
@arm_options
def compare_controllers(arm: Arm, duration: float, out: str | None, as_json: bool) -> None:
    """Run the spiral with each controller, free, hanging and hanging with a payload, and print one table.

    Errors are from target to simulated tip, after the first second. `along` is the part along the dome: what lies
    across it no lengths can remove, for under load the reachable tips form another surface than the dome.
    """
    from contarm_sim.arm_file import arm_to_dict
    from contarm_sim.cli.terminal import command_line, say, table, track
    from contarm_sim.report.output import OutputFolder, check_output, default_folder, to_json, versions
    from contarm_sim.simulation.control import CONTROLLERS
    from contarm_sim.validation.scenarios import under_load

    target = Path(out) if out is not None else default_folder("compare-controllers")
    check_output(target)
    pulled, loaded = under_load(arm)
    arms = {"free": arm.unloaded, "gravity": pulled, "payload": loaded}
    jobs = [(load, controller) for load in arms for controller in CONTROLLERS]
    rows = [
        {"load": jobs[i][0], "controller": jobs[i][1], **_row(arms[jobs[i][0]], jobs[i][1], duration)}
        for i in track(range(len(jobs)), "controllers")
    ]
    summary = {"rows": rows, "duration": duration, "arm": arm_to_dict(arm)}
    summary |= {"versions": versions(), "command": command_line()}
    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
    if as_json:
        click.echo(to_json(summary))
    else:
        columns = ["load", "controller", "tip rms [%]", "max [%]", "along [%]", "lag [ms]", "tension [N]"]
        columns += ["kPa", "pushes", "effort [N]"]
        table(f"spiral, {duration:g} s; % of backbone length", columns, [_cells(row) for row in rows])
    say(f"written: {opened.target}")


def _row(arm: Arm, controller: Any, duration: float) -> dict[str, Any]:
    import numpy as np

    from contarm_sim import paths
    from contarm_sim.kinematics import arc, dome
    from contarm_sim.simulation.run import CONTROL_RATE, simulate
    from contarm_sim.validation.compare import muscle_summary

    time, targets = paths.named("spiral", arm.length, duration).targets(CONTROL_RATE)
    bend = dome.bend_from_tip(targets, arm.length).bend
    try:
        samples = simulate(arm, targets, bend, controller).samples
    except (ConvergenceError, DivergenceError) as error:
        return {"failed": str(error)}
    tips, after = samples.stations[:, -1], time >= min(SETTLED, 0.5 * duration)
    offset = (tips - targets)[after]
    J = arc.jacobian(bend[after], arm.length)
    along = np.einsum("tij,tjk,tk->ti", J, np.linalg.pinv(J), offset)
    muscle = muscle_summary(arm, samples)
    return {
        "tip_rms_percent": _rms(offset, arm),
        "tip_max_percent": 100 * float(np.linalg.norm(offset, axis=1).max()) / arm.length,
        "along_rms_percent": _rms(along, arm),
        "lag_s": _lag(time, targets, tips),
        "peak_tension_n": muscle["max_force_n"],
        "peak_pressure_pa": muscle["max_pressure_needed_pa"],
        "pushes": muscle["pushes"],
        "effort_n": float(np.abs(samples.muscle_tensions).sum(axis=1).mean()),
    }


def _rms(vectors: Any, arm: Arm) -> float:
    import numpy as np

    return 100 * float(np.sqrt(np.mean(np.sum(vectors**2, axis=1)))) / arm.length


def _lag(time: Any, targets: Any, tips: Any) -> float:
    """Return the delay [s] at which the targets' path fits the tips best."""
    import numpy as np
    from scipy.optimize import minimize_scalar

    def misfit(delay: float) -> float:
        late = np.column_stack([np.interp(time - delay, time, column) for column in targets.T])
        inner = slice(len(time) // 10, -len(time) // 10)
        return float(np.sum((late - tips)[inner] ** 2))

    return float(minimize_scalar(misfit, bounds=(-0.2, 0.2), method="bounded", options={"xatol": 1e-5}).x)


def _cells(row: dict[str, Any]) -> list[str]:
    head = [row["load"], row["controller"]]
    if "failed" in row:
        return [*head, "failed", *[""] * 7]
    pressure = row["peak_pressure_pa"]
    return [
        *head,
        f"{row['tip_rms_percent']:.3f}",
        f"{row['tip_max_percent']:.3f}",
        f"{row['along_rms_percent']:.3f}",
        f"{1e3 * row['lag_s'] + 0.0:.1f}",
        f"{row['peak_tension_n']:.1f}",
        "beyond" if pressure is None else f"{pressure / 1e3:.0f}",
        str(row["pushes"]),
        f"{row['effort_n']:.1f}",
    ]
