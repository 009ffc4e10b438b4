"""`contarm render`: a film or a picture of a recorded run, without simulating again."""

from __future__ import annotations

import re
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.cli.options import PLAIN, TIME, Command, json_option
from contarm_sim.errors import InputError
from contarm_sim.view.rendering.formats import SIZES, USUAL

if TYPE_CHECKING:
    from collections.abc import Iterator

    from contarm_sim.view.rendering.video import Shot

KINDS = (".mp4", ".mov", ".webm", ".gif", ".webp", ".png")


class Size(click.ParamType):
    """A picture's size: a name, or WIDTHxHEIGHT in pixels."""

    name = "size"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        """Return width and height [pixels]."""
        if isinstance(value, tuple):
            return value
        found = re.fullmatch(r"(\d{2,5})x(\d{2,5})", value)
        size = SIZES.get(value) or (found and (int(found[1]), int(found[2])))
        if not size or min(size) < 64 or max(size) > 8192:
            self.fail(f"{value!r}; allowed: {', '.join(SIZES)}, or WIDTHxHEIGHT, each 64 to 8192 pixels", param, ctx)
        return size


@click.command(cls=Command)
@click.argument("run_dir", metavar="RUN_DIR")
@click.option(
    "--out", metavar="FILE",
    help="A .mp4, .mov (ProRes 4444), .webm (VP9), .gif, .webp or .png, or a folder of pictures, frames/; must not "
    "exist yet. Default: RUN_DIR/render.mp4.",
)  # fmt: skip
@click.option("--beside", metavar="RUN_DIR", help="Show another run on the right.")
@click.option(
    "--camera", default="front", show_default=True, type=click.Choice(["front", "side", "top", "orbit", "tip"]),
    help="Fixed, circling once, or following the tip.",
)  # fmt: skip
@click.option(
    "--size", default=USUAL, show_default=True, type=Size(), metavar="NAME|WxH",
    help="480p, 720p, 1080p, 2160p, or width and height: 1080x1080.",
)  # fmt: skip
@click.option(
    "--fps", type=PLAIN, help="Frames per second, 1 to 60 (GIF 50); default 30, GIF and WebP 15, poses at rest 2."
)
@click.option("--speed", type=PLAIN, default=1.0, show_default=True, help="Simulated over shown time.")
@click.option("--time", "at", type=TIME, metavar="S", help="For a .png: the time to show [s]; default the end.")
@click.option("--plain", is_flag=True, help="The arm alone: nothing written, plotted or drawn over it.")
@click.option("--no-captions", is_flag=True, help="Leave the words along the top out.")
@click.option("--no-plots", is_flag=True, help="Leave the plots of error and pressure out.")
@click.option("--no-ghost", is_flag=True, help="Leave the analytic arm out.")
@click.option("--no-cloud", is_flag=True, help="Leave the sampled arms of run --uncertain out.")
@click.option(
    "--transparent", is_flag=True,
    help="Neither floor nor sky nor shadow, words and plots: opacity. For .mov, .webm, .webp, .png and folders.",
)  # fmt: skip
@json_option
def render(run_dir: str, out: str | None, beside: str | None, camera: str, size: tuple[int, int], fps: float | None,
           speed: float, at: float | None, plain: bool, no_captions: bool, no_plots: bool,
           no_ghost: bool, no_cloud: bool, transparent: bool, as_json: bool) -> None:  # fmt: skip
    """Draw what `contarm run` left in RUN_DIR, from its trajectory.npz and arm.toml.

    \b
    contarm render runs/run-... --camera orbit --size 1080p --fps 60 --out orbit.mp4
    contarm render runs/run-... --out spiral.gif --size 480p --speed 2
    contarm render runs/run-a --beside runs/run-b --out both.mp4
    contarm render runs/run-... --plain --transparent --out arm.mov
    contarm render runs/run-... --out frames/
    contarm render runs/run-... --out end.png
    """
    from contarm_sim.cli.drawing import say_backend
    from contarm_sim.cli.terminal import progress, say
    from contarm_sim.results.run_folder import load_folder
    from contarm_sim.view.rendering.cloud import Cloud
    from contarm_sim.view.rendering.draw import ALL
    from contarm_sim.view.rendering.formats import usual_fps
    from contarm_sim.view.rendering.look import Look
    from contarm_sim.view.rendering.video import WRITERS, Shot, write_pictures, write_still
    from contarm_sim.view.report.output import check_output, to_json
    from contarm_sim.view.report.words import noted

    target, kind = Path(out) if out is not None else Path(run_dir) / "render.mp4", _kind(out)
    if kind not in ("/", *KINDS):
        raise InputError("out", str(target), f"a name that ends in {', '.join(KINDS)}, or a folder: frames/")
    if at is not None and kind != ".png":
        raise InputError("time", at, "with a .png only")
    samples = load_folder(Path(run_dir))
    fps = fps if fps is not None else usual_fps(kind, samples.moving)
    if not 1 <= fps <= 60:
        raise InputError("fps", fps, "1 to 60")
    check_output(target)
    other = load_folder(Path(beside)) if beside is not None else None
    cloud = None if no_cloud or other is not None else Cloud.load(Path(run_dir), len(samples))
    overlays = replace(ALL, ghost=not no_ghost, cloud=cloud)
    look = Look(
        *size, camera, not no_plots, noted(Path(run_dir)), not no_captions, overlays, transparent
    )  # fmt: skip
    shot = Shot(samples, look.plain() if plain else look, fps, speed)
    if other is not None and beside is not None:
        folders = (Path(run_dir), Path(beside))
        one, two = (each.resolve().name for each in folders)
        shot = replace(shot, beside=other, names=(one, two), notes=(noted(folders[0]), noted(folders[1])))
    with _output(target, kind) as scratch, progress("drawing") as on_frame:
        if kind == ".png":
            write_still(shot, scratch, float(samples.time[-1]) if at is None else at)
        elif kind == "/":
            write_pictures(shot, scratch, on_frame)
        else:
            WRITERS[kind](shot, scratch, on_frame)
    say_backend()
    if as_json:
        click.echo(to_json({"file": str(target), "width": size[0], "height": size[1]} | _rate(shot, kind)))
    say(f"written: {target}" + (f", {shot.count} pictures, {fps:g} a second" if kind == "/" else ""))


def _kind(out: str | None) -> str:
    """Return the ending of a file's name, or a slash for a folder."""
    return ".mp4" if out is None else "/" if out.endswith("/") else Path(out).suffix


def _rate(shot: Shot, kind: str) -> dict[str, Any]:
    return {} if kind == ".png" else {"frames": shot.count, "fps": shot.fps}


@contextmanager
def _output(target: Path, kind: str) -> Iterator[Path]:
    """Yield a scratch file, or folder, that takes its name at the end."""
    from contarm_sim.view.report.output import OutputFolder, output_file

    if kind == "/":
        with OutputFolder(target) as opened:
            yield opened.folder
    else:
        with output_file(target) as scratch:
            yield scratch
