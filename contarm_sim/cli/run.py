"""`contarm run`: the main job. Follow a path, compare, draw, film."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.figure_options import figure_options
from contarm_sim.cli.options import (
    ANGLE,
    LENGTH,
    PLAIN,
    TIME,
    Command,
    arm_options,
    controller_option,
    json_option,
    out_option,
)
from contarm_sim.cli.uncertain import uncertain_option
from contarm_sim.errors import InputError, Interrupted
from contarm_sim.model.arm import Arm
from contarm_sim.view.prints import Prints


@click.command(cls=Command)
@click.option(
    "--path", "path_name", default="spiral", show_default=True, metavar="NAME|FILE.csv",
    help="spiral, sphere-spiral (the paper's), circle, line, figure-eight, or a CSV file x,y,z or t,x,y,z [m, s]; a "
    "header may give other units: x [mm].",
)  # fmt: skip
@click.option(
    "--duration", type=TIME, metavar="S", help="Time for the path [s]; default 10, or what the CSV file says."
)
@click.option("--turns", type=PLAIN, metavar="X", help="Turns of the spirals; default 2.")
@click.option("--max-bend", type=ANGLE, metavar="X", help="Largest bend angle [rad]; default 120deg.")
@click.option("--sphere-radius", type=LENGTH, metavar="X", help="Radius of the sphere-spiral [m]; default length.")
@click.option("--sphere-centre", type=LENGTH, nargs=3, metavar="X Y Z", help="Its centre [m]; default the base.")
@click.option(
    "--project", default="refuse", type=click.Choice(["refuse", "nearest", "ray", "paper"]), show_default=True,
    help="What to do with targets off the dome (see contarm ik --help).",
)  # fmt: skip
@click.option(
    "--direction", type=PLAIN, nargs=3, metavar="X Y Z",
    help="Direction of the tip on the whole way; for three sections or more.",
)  # fmt: skip
@controller_option(
    "paper: arc lengths, plain servos; chain: exact; feedforward: + tensions; servo: + integral; pressure: servo "
    "through pneumatic muscles and valves; tip: servo + planned rest of the model's tip + seen tip."
)
@click.option("--fast", is_flag=True, help="Steps of 10 ms, whatever error that makes; it is estimated and judged.")
@click.option(
    "--timestep", type=TIME, metavar="S",
    help="Engine step [s], a whole fraction of 0.01; default found: 0.005, or less where its error matters.",
)  # fmt: skip
@click.option(
    "--extrapolate", is_flag=True, help="Simulate half the links too, and extrapolate to infinitely many (order 4)."
)
@uncertain_option
@click.option("--no-video", is_flag=True, help="Numbers and figures only.")
@out_option("runs/run-<time>")
@figure_options()
@json_option
@arm_options
def run(arm: Arm, path_name: str, duration: float | None, project: Any, direction: Any,
        controller: Any, fast: bool, timestep: float | None, extrapolate: bool, uncertain_file: str | None,
        no_video: bool, out: str | None, prints: Prints, as_json: bool, **shape: Any) -> int:  # fmt: skip
    """Follow a path with the simulated arm and compare it with the analytic one.

    Leaves report.html, summary.json, samples.csv, trajectory.npz, arm.xml, arm.toml, figures and video.mp4. Says
    whether constant curvature holds (it need not), and whether the simulation is explained and converged: exit
    code 1 if it is not, or if targets lie more than 1 % of length off the dome of reachable tips. Ctrl-C keeps what was
    recorded; numbers are on disk before anything is drawn.

    \b
    contarm run
    contarm run --path sphere-spiral --project nearest --duration 20
    contarm run --gravity 0 0 9.81 --payload 0.1 --no-video --json
    contarm run --arm three.toml --path circle --direction 0 0 1 --no-video
    contarm run --objects post.toml --path line --gravity 0 0 9.81

    An arm can touch what tables [[object]] of --arm or --objects describe. It must begin clear of them. If it touches
    any, the motion is simulated again without them: contact is what they move the tip by, and the other parts of its
    error are of that motion.

    --uncertain FILE.toml says how uncertain parameters are: cases = 128, seed = 0, and below [vary] lines such as
    bending_stiffness = { distribution = "normal", mean = 0.1, std = "10 %" }, or lognormal, or uniform with low and
    high. Commands, feedback and arcs stay those of the nominal arm, the one you believe in; the simulated arms are the
    sampled ones. Exit code 1 if one has no result.

    The tip of several sections is led along the path by bends that change smoothly; the parts of its error are given
    section by section too: what the tip moves where one section alone has them.
    """
    from contarm_sim.cli import uncertain
    from contarm_sim.cli.drawing import draw, film_at_first, say_missing
    from contarm_sim.cli.path import parameters_of, path_of, reference_of
    from contarm_sim.cli.run_words import show_run
    from contarm_sim.cli.terminal import command_line, progress, say
    from contarm_sim.model.host_file import HOLDING
    from contarm_sim.motion.simulate import simulate
    from contarm_sim.stopping import break_off, exit_code, unbroken
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json

    target = Path(out) if out is not None else default_folder("run")
    check_output(target)
    shape = {name: value for name, value in shape.items() if value is not None}
    path, waypoints = path_of(arm, path_name, duration, shape)
    stepping = _stepping(fast, timestep)
    spread, asked = None, uncertain.read(uncertain_file, arm)
    if asked is not None and extrapolate:
        raise InputError("uncertain", "beside --extrapolate", "one of the two: sampled arms are not extrapolated")
    _refuse_too_long(path.duration, timestep, arm)
    reference = reference_of(arm, path, project, None if waypoints is None else waypoints.places, direction)
    for note in () if waypoints is None else waypoints.notes:
        say(note)
    with ExitStack() as whole:

        def on_tick(count: int) -> None:
            if count == 1:  # from here on, signals wait until there is a good place for them
                whole.enter_context(unbroken())
            show(count, len(reference))
            break_off()

        with progress("simulating") as show:
            given = {"stepping": stepping, "on_tick": on_tick, "check_step": True, "extrapolate": extrapolate}
            try:
                recorded = simulate(arm, reference, controller, **given)
            except Interrupted as stop:
                recorded = stop.trajectory
            except InputError as error:
                raise _advised(error) from None
        if len(recorded) < 2:
            raise KeyboardInterrupt
        if recorded.status == "interrupted":
            say(_HEARD)
        if asked is not None and recorded.status != "interrupted":
            spread = uncertain.motion_of(recorded, asked, stepping)
            if spread.interrupted:
                say(_HEARD)
        if recorded.contacts and recorded.base is None and recorded.status != "interrupted":
            say("simulating the same without objects, to tell what contact does")
        job, recorded = _report(recorded, spread)
        cut = spread is not None and spread.interrupted
        interrupted = cut or recorded.status == "interrupted"
        summary = job.told(
            path.name if waypoints is None else path_name,
            command=command_line(),
            video=film_at_first(interrupted, not no_video),
            duration=path.duration,
            parameters=parameters_of(arm, path_name, shape),
            project=project,
            direction=direction,
        )
        with OutputFolder(target) as opened:
            job.write(opened.folder)
            (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        missing, failed = draw(job, opened.target, summary, prints)
        if as_json:
            click.echo(to_json(summary))
        else:
            show_run(summary, arm)
        host = arm.world.host
        if host is not None and not host.read.holds and recorded.contacts is not None and len(recorded.contacts):
            say(f"friction creeps or buzzes under the options of {Path(host.file).name}; it holds with {HOLDING}")
        say(f"written: {opened.target}")
        if cut:
            said = f"{len(spread.status)} of {spread.uncertain.cases}"  # type: ignore[union-attr]
            say(f"interrupted after {said} sampled arms, which are kept; the motion of the nominal arm is whole")
        elif interrupted and len(recorded) < len(reference):
            say(f"interrupted at {recorded.time[-1]:.2f} s; what was recorded until then is kept")
        elif interrupted:
            say("interrupted after the motion, while its error was being estimated; the motion is whole")
        if missing:
            say_missing(missing, f"contarm render {opened.target}")
        if interrupted or missing:
            return exit_code()
        failed = failed or (spread is not None and bool(spread.failed))
        return 0 if summary["verdict"] == "pass" and not failed else 1


_HEARD = "interrupted: what was recorded is compared and written"


def _report(recorded: Any, spread: Any) -> tuple[Any, Any]:
    """Return the report of a recorded run, and the run; a signal cuts the report short, and the run counts as such."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.stopping import breakable
    from contarm_sim.view.report.run import RunReport

    try:
        with breakable():
            return RunReport(recorded, spread=spread), recorded
    except KeyboardInterrupt:
        if recorded.status != "interrupted":
            say(_HEARD)
        recorded = replace(recorded, status="interrupted")
        return RunReport(recorded, poses=2, spread=spread), recorded


def _stepping(fast: bool, timestep: float | None) -> Any:
    from contarm_sim.motion.simulate import CONTROL_RATE, FAST, Stepping

    if timestep is None:
        return FAST if fast else None
    if fast:
        raise InputError("timestep", timestep, "either --timestep or --fast")
    if not 1e-6 <= timestep <= 1 / CONTROL_RATE:
        raise InputError("timestep", timestep, f"1e-6 to {1 / CONTROL_RATE:g} s")
    stepping = Stepping(timestep)
    stepping.substeps(CONTROL_RATE)
    return stepping


MOST_STEPS = 100_000_000
"""Most engine steps of one run; they take about half an hour."""

MOST_MEMORY = 8 * 2**30
"""Most memory that a run may take for what it records and for the controls of its steps [bytes]."""


def _refuse_too_long(duration: float, timestep: float | None, arm: Arm) -> None:
    """Refuse a run of more steps, or more memory, than there is time or room for.

    Raises:
        InputError: says how many steps, or how much memory.
    """
    from contarm_sim.mechanics.muscles import count
    from contarm_sim.motion.simulate import CONTROL_RATE

    samples, muscles, partners = duration * CONTROL_RATE, count(arm), len(arm.world.objects) + arm.world.self_contact
    steps = duration / timestep if timestep is not None else samples
    numbers = (
        samples * (28 + 4 * muscles + (6 + 14 * partners) * (arm.links + 1)) * 4
    )  # recorded, compared, and copied while both are done
    memory = 8 * (numbers + 2 * muscles * steps)
    if steps > MOST_STEPS:
        allowed = f"at most {MOST_STEPS:,} steps: a longer time step, or a shorter path"
        raise InputError("timestep", f"{timestep:g} s, which makes {steps:,.0f} steps", allowed)
    if memory > MOST_MEMORY:
        allowed = f"at most {MOST_MEMORY / 2**30:g} GiB: a longer time step, fewer links, or a shorter path"
        raise InputError("duration", f"{duration:g} s, which takes about {memory / 2**30:.0f} GiB of memory", allowed)


def _advised(error: InputError) -> InputError:
    """Return an error of a bend that too few links cannot make, with the flag that asks for less of it."""
    if "more links" not in error.allowed:
        return error
    return InputError(error.name, error.given, f"{error.allowed}, or a smaller --max-bend", error.where)
