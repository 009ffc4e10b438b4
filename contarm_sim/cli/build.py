"""`contarm build`: the arm as MJCF files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, out_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--actuation", default="lengths", show_default=True, type=click.Choice(["lengths", "pressures", "tensions"]),
    help="lengths: a length servo a muscle. pressures: McKibben muscles behind valves; controls are p1 p2 p3 p1 p2 p3. "
    "tensions: a force a muscle.",
)  # fmt: skip
@out_option("runs/build-<time>")
@json_option
@arm_options
def build(arm: Arm, actuation: Any, out: str | None, as_json: bool) -> None:
    """Write the arm as MJCF: arm.xml (attachable) and scene.xml (with floor, light and cameras).

    What it can touch is in both; files of meshes are copied beside them, so that the folder may be moved.

    \b
    contarm build --links 48 --out my_arm
    contarm build --actuation pressures --out my_pneumatic_arm
    contarm build --preset two --out my_arm_of_two
    contarm build --objects post.toml --gravity 0 0 9.81
    python -m mujoco.viewer --mjcf=my_arm/scene.xml
    """
    from contarm_sim.mjcf import write_models
    from contarm_sim.model.arm_file import arm_to_toml
    from contarm_sim.view.report.output import OutputFolder, check_output, default_folder, to_json

    target = Path(out) if out is not None else default_folder("build")
    check_output(target)
    with OutputFolder(target) as out_folder:
        folder = out_folder.folder
        write_models(arm, folder, actuation)
        (folder / "arm.toml").write_text(arm_to_toml(arm, beside=True))
    files = [str(out_folder.target / name) for name in ("arm.xml", "scene.xml", "arm.toml")]
    click.echo(to_json({"files": files}) if as_json else "\n".join(files))
