"""Entry point of `contarm`: subcommands, exit codes, and one clear line for every error.

Exit codes: 0 done; 1 the job ran and its verdict is negative, or it could not finish; 2 the input is wrong; 130
Ctrl-C, 143 SIGTERM, 129 SIGHUP (a terminal that was closed).
"""

from __future__ import annotations

import os
import re
import signal
import sys

import click

from contarm_sim.cli import (
    build,
    compare_controllers,
    demo,
    doctor,
    envs,
    equilibrium,
    excite,
    figures,
    fit,
    fit_report,
    fk,
    hold,
    ik,
    init,
    muscle,
    possibility,
    release,
    render,
    replay,
    run,
    stiffness,
    sweep,
    sweep_report,
    trust,
    validate,
    view,
)
from contarm_sim.cli.terminal import say
from contarm_sim.errors import ContarmError, InputError, one_line
from contarm_sim.stopping import came, exit_code, listening

MESSAGE = 330
"""Most characters of a message about an argument; its middle is left out where it would be longer."""

_VARIADIC = ("--xi", "--pressure", "--free")
_JOINED = "--muscles"


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="contarm-sim")
def cli() -> None:
    """A continuum arm modelled twice, in closed form and in MuJoCo, and the measured difference.

    \b
    contarm run                            follow the spiral, compare, film it
    contarm view                           steer it by hand, in a browser
    contarm validate --quick               how far to trust the constant-curvature model
    contarm fk --bend 1.57 0               closed-form pose of the arm bent by 90 deg
    contarm ik --tip 0.2355 0 0.2355       bend and muscle lengths that reach a point

    Units are SI (m, rad, s, N, Pa). Every subcommand has --help and --json.
    """


COMMANDS = (
    run.run,
    render.render,
    view.view,
    demo.demo,
    validate.validate,
    trust.trust,
    compare_controllers.compare_controllers,
    equilibrium.equilibrium,
    stiffness.stiffness,
    release.release,
    hold.hold,
    possibility.possibility,
    muscle.muscle,
    sweep.sweep,
    sweep_report.sweep_report,
    fit.fit,
    fit_report.fit_report,
    replay.replay,
    excite.excite,
    figures.figures,
    fk.fk,
    ik.ik,
    build.build,
    init.init,
    envs.envs,
    doctor.doctor,
)
SHORT = {
    "run": "Follow a path and compare with theory.",
    "render": "Draw a film or picture of a run.",
    "view": "Steer the arm live in a browser.",
    "demo": "Grasp, reach around, lean.",
    "validate": "Test the constant-curvature model.",
    "trust": "How far to bend and trust theory.",
    "compare-controllers": "Run the spiral with every controller.",
    "equilibrium": "Find the pose at rest under loads.",
    "stiffness": "Tip stiffness against co-contraction.",
    "release": "Let a loaded arm go and record it.",
    "hold": "Pressures that hold a bend.",
    "possibility": "Map the bends that pressures can hold.",
    "muscle": "Force of one muscle.",
    "sweep": "Run many cases and keep a table.",
    "sweep-report": "Draw a sweep and the validity chart.",
    "fit": "Fit an arm to recordings of a real one.",
    "fit-report": "Draw a fit and what it leaves over.",
    "replay": "Predict a recording and compare.",
    "excite": "Propose what to command next.",
    "figures": "Draw the figures of the paper and more.",
    "fk": "Pose of a bend or of muscle lengths.",
    "ik": "Bend and muscle lengths for a position.",
    "build": "Write the arm as MJCF files.",
    "init": "Write a TOML file to describe an arm.",
    "envs": "List the learning tasks and their scores.",
    "doctor": "Check what this machine can do.",
}
"""What each command does, in a line of `contarm --help`."""

for command in COMMANDS:
    command.short_help = SHORT[str(command.name)]
    cli.add_command(command)


def _spell_out(arguments: list[str]) -> list[str]:
    """Make flags that take any number of words digestible.

    --xi 0 1 becomes --xi 0 --xi 1, --free likewise, and --muscles bend 1 0 becomes --muscles "bend 1 0".
    """
    spelt: list[str] = []
    flag = None
    for word in arguments:
        if word.startswith("-") and not _is_number(word):
            flag = word if word in (*_VARIADIC, _JOINED) else None
            spelt.append(word)
        elif flag == _JOINED and spelt[-1] != flag:
            spelt[-1] += " " + word
        elif flag == "--free" and word.endswith(".toml"):  # no parameter: the files come after the names
            spelt.append(word)
            flag = None
        elif flag is not None and spelt[-1] != flag:
            spelt += [flag, word]
        else:
            spelt.append(word)
    return spelt


def _is_number(word: str) -> bool:
    """Tell a negative number, perhaps with a unit, -5mm, from a flag."""
    return re.match(r"-(\d|\.\d|inf|nan)", word) is not None


def main() -> None:
    """Run `contarm` and exit."""
    _open_standard_files()
    with listening():
        try:
            code = _run()
        except KeyboardInterrupt:  # once more, while the first was answered
            code = exit_code()
    sys.exit(code)


def _open_standard_files() -> None:
    """Keep files that are opened later from taking the places of standard files that are closed."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


def _call(arguments: list[str]) -> int:
    """Run the subcommand; return its exit code.

    Not by `cli.main`, which makes an exit code of its own of an output that nobody reads.
    """
    for word in arguments:
        try:
            word.encode()
        except UnicodeEncodeError:
            raise InputError("argument", repr(word), "names in UTF-8") from None
    if "_CONTARM_COMPLETE" in os.environ:
        cli.main(args=arguments, prog_name="contarm", standalone_mode=False)
        return 0
    try:
        with cli.make_context("contarm", _spell_out(arguments)) as context:
            code = cli.invoke(context)
    except click.exceptions.Exit as ended:  # --help, --version
        code = ended.exit_code
    if sys.stdout is not None:
        sys.stdout.flush()
    return code if isinstance(code, int) else 0


def _run() -> int:
    """Run `contarm`, say what went wrong, and return the exit code."""
    try:
        code = _call(sys.argv[1:])
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help() if error.ctx else error.format_message())
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        hint = f" (see {context.command_path} --help)" if context is not None else ""
        message = error.format_message().rstrip(".")
        if message.endswith("does not take a value"):
            message += "; it is a switch: write its name alone"
        return _failed(one_line(message, MESSAGE) + hint, 2)
    except InputError as error:
        return _failed(str(error), 2)
    except BrokenPipeError:  # the reader of our output went away
        _silence_stdout()
        return 141
    except (Exception, KeyboardInterrupt) as error:
        if came() is not None or isinstance(error, (KeyboardInterrupt, click.Abort)):  # or what a library made of it
            return _interrupted()
        if isinstance(error, ContarmError):
            return _failed(one_line(str(error), 4 * MESSAGE), 1)
        if isinstance(error, OSError):  # no space left, say
            _silence_stdout()
            return _failed(f"cannot write: {error.strerror}", 1)
        raise
    if not code and came() in (signal.SIGTERM, signal.SIGHUP):  # of `view`, which Ctrl-C ends as it should
        return exit_code()
    return code


def _interrupted() -> int:
    if sys.stderr is not None and sys.stderr.isatty():  # the terminal has written ^C
        say("")
    number = came()
    return _failed("interrupted" if number in (None, signal.SIGINT) else f"ended by {number.name}", exit_code())


def _silence_stdout() -> None:
    """Keep Python from trying once more to write what could not be written."""
    if sys.stdout is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _failed(message: str, code: int) -> int:
    say(f"contarm: {message}")
    return code
