"""`contarm init`: a TOML file of one's own arm, to be filled in."""

from __future__ import annotations

from pathlib import Path

import click

from contarm_sim.cli.options import Command, arm_options, json_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.argument("file", metavar="FILE.toml")
@json_option
@arm_options
def init(arm: Arm, file: str, as_json: bool) -> None:
    """Write a TOML file with every parameter of an arm, its unit, its meaning and its default.

    Parameters that can be omitted stand in comments, and so does an object that the arm could touch. Flags change the
    values that are written.

    \b
    contarm init my_arm.toml
    contarm init my_arm.toml --length 250mm --links 32
    contarm init my_arm.toml --preset two
    contarm run --arm my_arm.toml
    """
    from contarm_sim.cli.terminal import say
    from contarm_sim.errors import InputError
    from contarm_sim.model.template import arm_template
    from contarm_sim.view.report.output import output_file, to_json

    target = Path(file)
    if target.suffix != ".toml":
        raise InputError("file", repr(file), "a name that ends in .toml")
    with output_file(target) as scratch:
        scratch.write_text(arm_template(arm), encoding="utf-8")
    if as_json:
        click.echo(to_json({"file": file}))
    say(f"written: {file}; change it, and give it to any command as --arm {file}")
