"""Entry point of `contarm`: subcommands, exit codes, and one clear line for every error.

Exit codes: 0 done; 1 the job ran and its verdict is negative, or it could not finish; 2 the input is wrong; 130
Ctrl-C, 143 SIGTERM, 129 SIGHUP (a terminal that was closed).
"""

from __future__ import annotations

import os
import signal
import sys
from typing import Any

import click

from contarm_sim.cli import (
    build,
    compare_controllers,
    doctor,
    envs,
    equilibrium,
    figures,
    hold,
    kinematics,
    muscle,
    possibility,
    release,
    render,
    run,
    stiffness,
    validate,
    view,
)
from contarm_sim.cli.terminal import say
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.stopping import came, exit_code, listening

_VARIADIC = ("--xi", "--pressure")
_JOINED = "--muscles"


class BrokenOffError(Exception):
    """Ctrl-C on its way past click, which would write an empty line."""


class Group(click.Group):
    """The subcommands."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the subcommand."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise BrokenOffError from None


@click.group(cls=Group, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="contarm-sim")
def cli() -> None:
    """A continuum arm derived twice, in closed form and in MuJoCo, and the measured difference.

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
    validate.validate,
    compare_controllers.compare_controllers,
    equilibrium.equilibrium,
    stiffness.stiffness,
    release.release,
    hold.hold,
    possibility.possibility,
    muscle.muscle,
    figures.figures,
    kinematics.fk,
    kinematics.ik,
    build.build,
    envs.envs,
    doctor.doctor,
)
for command in COMMANDS:
    cli.add_command(command)


def _spell_out(arguments: list[str]) -> list[str]:
    """Make flags that take any number of words digestible.

    --xi 0 1 becomes --xi 0 --xi 1, and --muscles bend 1 0 becomes --muscles "bend 1 0".
    """
    spelt: list[str] = []
    flag = None
    for word in arguments:
        if word.startswith("-") and not _is_number(word):
            flag = word if word in (*_VARIADIC, _JOINED) else None
            spelt.append(word)
        elif flag == _JOINED and spelt[-1] != flag:
            spelt[-1] += " " + word
        elif flag is not None and spelt[-1] != flag:
            spelt += [flag, word]
        else:
            spelt.append(word)
    return spelt


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def main() -> None:
    """Run `contarm` and exit."""
    with listening():
        try:
            code = _run()
        except KeyboardInterrupt:  # once more, while the first was answered
            code = exit_code()
    sys.exit(code)


def _run() -> int:
    """Run `contarm`, say what went wrong, and return the exit code."""
    try:
        code = cli.main(args=_spell_out(sys.argv[1:]), prog_name="contarm", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.ctx.get_help() if error.ctx else error.format_message())
        return 2
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        hint = f" (see {context.command_path} --help)" if context is not None else ""
        return _failed(error.format_message().rstrip(".").replace("\n", " ") + hint, 2)
    except InputError as error:
        return _failed(str(error), 2)
    except BrokenPipeError:  # the reader of our output went away
        _silence_stdout()
        return 141
    except Exception as error:
        if came() is not None or isinstance(error, BrokenOffError):  # or what a library made of it
            return _interrupted()
        if isinstance(error, ContarmError):
            return _failed(str(error), 1)
        if isinstance(error, OSError):  # no space left, say
            _silence_stdout()
            return _failed(f"cannot write: {error.strerror}", 1)
        raise
    if not code and came() in (signal.SIGTERM, signal.SIGHUP):  # of `view`, which Ctrl-C ends as it should
        return exit_code()
    return code if isinstance(code, int) else 0


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
