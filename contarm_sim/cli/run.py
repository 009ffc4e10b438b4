"""`contarm run`: the main job. Follow a path, compare, draw, film."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import click

from contarm_sim.arm import Arm
from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.errors import InputError, RenderingError, UnreachableError


@click.command(cls=Command)
@click.option(
    "--path", "path_name", default="spiral", show_default=True, metavar="NAME|FILE.csv",
    help="spiral, sphere-spiral (the paper's), circle, line, figure-eight, or a CSV file x,y,z or t,x,y,z [m, s].",
)  # fmt: skip
@click.option(
    "--duration", type=float, metavar="S", help="Time for the path [s]; default 10, or what the CSV file says."
)
@click.option("--turns", type=float, default=2.0, show_default=True, metavar="X", help="Turns of the spirals.")
@click.option(
    "--max-bend",
    type=float,
    default=math.radians(120),
    metavar="X",
    help="Largest bend angle [rad]; default 2.094 (120 deg).",
)
@click.option(
    "--sphere-radius", type=float, metavar="X", help="Radius of the sphere-spiral's shell [m]; default length."
)
@click.option(
    "--sphere-centre",
    type=float,
    nargs=3,
    default=(0.0, 0.0, 0.0),
    metavar="X Y Z",
    help="Its centre [m]; default the base.",
)
@click.option(
    "--project", default="refuse", type=click.Choice(["refuse", "nearest", "ray", "paper"]), show_default=True,
    help="What to do with targets off the dome (see contarm ik --help).",
)  # fmt: skip
@click.option(
    "--controller", default="servo", type=click.Choice(["paper", "chain", "feedforward", "servo"]), show_default=True,
    help="paper: arc lengths, plain servos; chain: exact lengths; feedforward: + tensions, pulling; servo: + integral.",
)  # fmt: skip
@click.option(
    "--fast", is_flag=True, help="Coarse stepping, 10 ms: about twice as fast, about twice the step's own error."
)
@click.option("--no-video", is_flag=True, help="Numbers and figures only.")
@out_option("runs/run-<time>")
@json_option
@arm_options
def run(arm: Arm, path_name: str, duration: float | None, project: Any, controller: Any, fast: bool, no_video: bool,
        out: str | None, as_json: bool, **shape: Any) -> int:  # fmt: skip
    """Follow a path with the simulated arm and compare it with the analytic one.

    Leaves summary.json, samples.csv, trajectory.npz, arm.xml, arm.toml, figures and video.mp4. Exit code 1 if a
    check fails. Ctrl-C keeps what was recorded.

    \b
    contarm run
    contarm run --path sphere-spiral --project nearest --duration 20
    contarm run --gravity 0 0 9.81 --payload 0.1 --no-video --json
    """
    from contarm_sim.cli.terminal import command_line, progress, say
    from contarm_sim.report.output import check_output, default_folder, output_folder, to_json
    from contarm_sim.report.run import RunReport
    from contarm_sim.simulation.run import ACCURATE, CONTROL_RATE, FAST, simulate

    target = Path(out) if out is not None else default_folder("run")
    check_output(target)
    path, places = _path(arm, path_name, duration, shape)
    targets, bend = _commands(arm, path, project, places)
    stepping = FAST if fast else ACCURATE
    with progress("simulating") as show:
        recorded = simulate(
            arm, targets, bend, controller, stepping=stepping, on_tick=lambda count: show(count, len(bend))
        )
    if len(recorded.samples) < 2:
        raise KeyboardInterrupt
    job = RunReport(arm, recorded, controller)
    summary = job.summary | {"path": path.name if places is None else path_name, "duration": path.duration}
    summary |= {"timestep": stepping.timestep, "rate": CONTROL_RATE, "command": command_line()}
    with output_folder(target) as folder:
        job.write(folder)
        summary["video"] = "not asked for" if no_video or recorded.interrupted else _film(job, folder)
        (folder / "summary.json").write_text(to_json(summary) + "\n")
    if as_json:
        click.echo(to_json(summary))
    else:
        _show(summary)
    say(f"written: {target}")
    if recorded.interrupted:
        say(f"interrupted at {recorded.samples.time[-1]:.2f} s; what was recorded until then is kept")
        return 130
    return 0 if summary["verdict"] == "pass" else 1


def _path(arm: Arm, name: str, duration: float | None, shape: dict[str, Any]) -> tuple[Any, list[str] | None]:
    from contarm_sim import paths
    from contarm_sim.waypoints import from_waypoints, read_csv

    if name in paths.NAMES:
        return paths.named(name, arm.length, 10.0 if duration is None else duration, **shape), None
    if not name.endswith(".csv") and not Path(name).exists():
        raise InputError("path", repr(name), ", ".join(paths.NAMES) + ", or a CSV file")
    waypoints = read_csv(name)
    return from_waypoints(waypoints, arm.length, duration), waypoints.places


def _commands(arm: Arm, path: Any, project: Any, places: list[str] | None) -> tuple[Any, Any]:
    from contarm_sim.kinematics import arc, dome
    from contarm_sim.simulation.run import CONTROL_RATE

    _, targets = path.targets(CONTROL_RATE)
    try:
        bend = dome.bend_from_tip(targets, arm.length, project).bend
    except UnreachableError as error:
        where = (
            f"path {path.name}, {100 * error.index / len(targets):.0f} % of the way"
            if places is None
            else places[0].split(", row")[0]
        )
        raise UnreachableError(error.target, error.miss, error.nearest, error.tolerance, error.index, where) from None
    return targets, arc.as_bend(bend)


def _film(job: Any, folder: Path) -> str:
    """Film the run; return the file's name, or why there is none: numbers are never lost for want of a picture."""
    from contarm_sim.cli.terminal import progress, say

    try:
        with progress("filming") as on_frame:
            return str(job.film(folder, on_frame))
    except (RenderingError, KeyboardInterrupt) as error:
        reason = str(error) or "interrupted"
        say(f"no video: {reason}")
        return f"none: {reason}"


def _show(summary: dict[str, Any]) -> None:
    from contarm_sim.cli.terminal import table, verdict_line

    meanings = {
        "tip_error": "tip error (simulated vs analytic)",
        "discretisation": "  discretisation: arc vs chain form",
        "servo": "  servo: commanded vs measured lengths",
        "shape": "  shape: inertia, gravity, unequal joints",
        "motion": "    of which motion (vs at rest)",
        "backbone_error": "largest along the backbone",
        "miss": "miss (target vs dome)",
    }
    keys = ("max_m", "rms_m", "max_percent", "rms_percent")
    rows = []
    for name, meaning in meanings.items():
        most, rms, most_percent, rms_percent = (summary[name][key] for key in keys)
        rows.append([meaning, f"{1e3 * most:.4f}", f"{1e3 * rms:.4f}", f"{most_percent:.4f}", f"{rms_percent:.4f}"])
    title = f"{summary['path']}, {summary['duration']:g} s, controller {summary['controller']}"
    table(title, ["", "max [mm]", "rms [mm]", "max [% L0]", "rms [% L0]"], rows)
    muscle, degrees, speed = summary["muscle"], summary["orientation_error_deg"], summary["real_time_factor"]
    forces = f"{muscle['min_force_n']:.1f} to {muscle['max_force_n']:.1f} N"
    slack = f"{muscle['pushes']} pushes, {100 * muscle['slack_fraction']:.3g} % slack"
    click.echo(f"orientation error {degrees['max']:.3f} deg max; muscles {forces}, {slack}; {speed:.0f} x real time")
    click.echo(verdict_line("verdict", summary))
