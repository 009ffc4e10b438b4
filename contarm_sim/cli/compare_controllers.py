"""`contarm compare-controllers`: the spiral under every controller, with and without gravity and payload."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.arm import Arm
from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.errors import ConvergenceError, DivergenceError, InputError

SETTLED = 1.0
"""Errors count from this time on [s]: a path may start in a sagging pose."""


@click.command(cls=Command, name="compare-controllers")
@click.option("--duration", type=float, default=10.0, show_default=True, metavar="S", help="Time for the spiral [s].")
@out_option("runs/compare-controllers-<time>")
@json_option
@arm_options
def compare_controllers(arm: Arm, duration: float, out: str | None, as_json: bool) -> None:
    """Run the spiral with each controller, free, hanging and hanging with a payload, and print one table.

    Errors are from target to simulated tip, after the first second. `along` is the part along the surface that the
    tip can reach under that load; what lies across it no lengths can remove, for it is not the dome of the targets.
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
    rows, reach = [], {}
    for i in track(range(len(jobs)), "controllers"):
        load, controller = jobs[i]
        if load not in reach:
            reach[load] = _reachable(arms[load], duration)
        rows.append({"load": load, "controller": controller, **_row(arms[load], controller, duration, reach[load])})
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
        for row in rows:
            if "failed" in row:
                click.echo(f"{row['load']}, {row['controller']}: {row['failed']}")
    say(f"written: {opened.target}")


def _path(arm: Arm, duration: float) -> tuple[Any, Any, Any]:
    """Return times [s], targets [m] and bends [rad] of the spiral."""
    from contarm_sim import paths
    from contarm_sim.kinematics import dome
    from contarm_sim.simulation.run import CONTROL_RATE

    time, targets = paths.named("spiral", arm.length, duration).targets(CONTROL_RATE)
    return time, targets, dome.bend_from_tip(targets, arm.length).bend


EVERY = 10
"""Errors are split at every tenth sample."""


def _reachable(arm: Arm, duration: float) -> Any:
    """Return what projects an error on the surface that the tip can reach, shape (K, 3, 3), at every tenth sample.

    Where that has no rest pose, the dome's.
    """
    import numpy as np

    from contarm_sim.kinematics import arc
    from contarm_sim.simulation.plan import plan_rest

    _, targets, bend = _path(arm, duration)
    targets, bend = targets[::EVERY], bend[::EVERY]
    inverse: Any
    try:
        inverse = plan_rest(arm, bend, targets).tip_to_bend
    except ConvergenceError:
        inverse = np.linalg.pinv(arc.jacobian(bend, arm.length))
    return np.linalg.pinv(inverse) @ inverse


def _row(arm: Arm, controller: Any, duration: float, reach: Any) -> dict[str, Any]:
    import numpy as np

    from contarm_sim.simulation.run import simulate
    from contarm_sim.validation.compare import muscle_summary

    time, targets, bend = _path(arm, duration)
    try:
        samples = simulate(arm, targets, bend, controller).samples
    except (ConvergenceError, DivergenceError, InputError) as error:
        return {"failed": str(error)}
    tips, after = samples.stations[:, -1], time >= min(SETTLED, 0.5 * duration)
    offset = tips - targets
    along = np.einsum("tij,tj->ti", reach, offset[::EVERY])[after[::EVERY]]
    muscle = muscle_summary(arm, samples)
    return {
        "tip_rms_percent": _rms(offset[after], arm),
        "tip_max_percent": 100 * float(np.linalg.norm(offset[after], axis=1).max()) / arm.length,
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
