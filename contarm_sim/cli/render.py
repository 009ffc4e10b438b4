"""`contarm render`: a film or a picture of a recorded run, without simulating again."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import PLAIN, TIME, Command, json_option
from contarm_sim.errors import InputError

SIZES = {"480p": (854, 480), "720p": (1280, 720), "1080p": (1920, 1080)}


@click.command(cls=Command)
@click.argument("run_dir", metavar="RUN_DIR")
@click.option(
    "--out", metavar="FILE", help="A .mp4, .gif, .webp or .png; must not exist yet. Default: RUN_DIR/render.mp4."
)
@click.option("--beside", metavar="RUN_DIR", help="Show another run on the right.")
@click.option(
    "--camera", default="front", show_default=True, type=click.Choice(["front", "side", "top", "orbit", "tip"]),
    help="Fixed, circling once, or following the tip.",
)  # fmt: skip
@click.option("--size", default="720p", show_default=True, type=click.Choice(list(SIZES)), help="Size of the picture.")
@click.option("--fps", type=PLAIN, help="Frames per second, 1 to 60 (GIF 50); default 30, GIF and WebP 15.")
@click.option("--speed", type=PLAIN, default=1.0, show_default=True, help="Simulated over shown time.")
@click.option("--time", "at", type=TIME, metavar="S", help="For a .png: the time to show [s]; default the end.")
@click.option(
    "--quality", default="draft", show_default=True, type=click.Choice(["draft", "final"]),
    help="final: smooth edges and sharp shadows, slower.",
)  # fmt: skip
@click.option("--no-plots", is_flag=True, help="Leave the plots of error and pressure out.")
@json_option
def render(run_dir: str, out: str | None, beside: str | None, camera: str, size: str, fps: float | None, speed: float,
           at: float | None, quality: Any, no_plots: bool, as_json: bool) -> None:  # fmt: skip
    """Draw what `contarm run` left in RUN_DIR, from its trajectory.npz and arm.toml.

    \b
    contarm render runs/run-... --camera orbit --quality final --size 1080p --out orbit.mp4
    contarm render runs/run-... --out spiral.gif --size 480p --speed 2
    contarm render runs/run-a --beside runs/run-b --out both.mp4
    contarm render runs/run-... --out end.png
    """
    from contarm_sim.cli.drawing import say_backend
    from contarm_sim.cli.terminal import progress, say
    from contarm_sim.view.rendering.film import Look
    from contarm_sim.view.rendering.video import WRITERS, Shot, write_still
    from contarm_sim.view.report.output import check_output, output_file, to_json
    from contarm_sim.view.report.words import noted

    target = Path(out) if out is not None else Path(run_dir) / "render.mp4"
    if target.suffix not in (*WRITERS, ".png"):
        raise InputError("out", str(target), f"a name that ends in {', '.join(WRITERS)} or .png")
    fps = fps if fps is not None else 30.0 if target.suffix == ".mp4" else 15.0
    if not 1 <= fps <= 60:
        raise InputError("fps", fps, "1 to 60")
    if at is not None and target.suffix != ".png":
        raise InputError("time", at, "with a .png only")
    samples = _recorded(run_dir)
    check_output(target)
    width, height = SIZES[size]
    other = _recorded(beside) if beside is not None else None
    names = (Path(run_dir).resolve().name, Path(beside).resolve().name) if beside is not None else ("", "")
    look = Look(width, height, camera, quality, not no_plots, noted(Path(run_dir)))
    shot = Shot(samples, look, fps, speed, other, names)
    with output_file(target) as scratch:
        if target.suffix == ".png":
            write_still(shot, scratch, float(samples.time[-1]) if at is None else at)
        else:
            with progress("drawing") as on_frame:
                WRITERS[target.suffix](shot, scratch, on_frame)
    say_backend()
    if as_json:
        click.echo(to_json({"file": str(target)}))
    say(f"written: {target}")


def _recorded(run_dir: str) -> Any:
    """Return the trajectory of a folder that `contarm run` left.

    Raises:
        InputError: it is no such folder, or a damaged one.
    """
    from contarm_sim.model.arm_file import load_arm
    from contarm_sim.results.trajectory import Trajectory

    folder = Path(run_dir)
    if not all(os.path.isfile(folder / name) for name in ("trajectory.npz", "arm.toml")):
        raise InputError("run_dir", run_dir, "a folder that contarm run left, with trajectory.npz and arm.toml")
    arm, samples = load_arm(folder / "arm.toml"), Trajectory.load(folder / "trajectory.npz")
    if samples.arm != arm:
        raise InputError("arm.toml", "another arm than that of trajectory.npz", "the arm that was recorded", run_dir)
    return samples
