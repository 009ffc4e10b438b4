"""Replays of recordings in notebooks: figures by name, films, the report."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.identify.replays.replay import Replay
from contarm_sim.inputs import as_path
from contarm_sim.view.notebook.films import Film, filmed, size_of, target_of
from contarm_sim.view.notebook.places import check_progress, check_switches, check_writable, told
from contarm_sim.view.notebook.reports import ToldReport
from contarm_sim.view.prints import WIDTHS
from contarm_sim.view.rendering.film import Progress
from contarm_sim.view.rendering.formats import SIZES, SMALL, USUAL
from contarm_sim.view.rendering.look import Look
from contarm_sim.view.rendering.replayed import ReplayShot
from contarm_sim.view.rendering.video import WRITERS
from contarm_sim.view.report.output import OutputFolder, check_output, to_json
from contarm_sim.view.report.replays import words
from contarm_sim.view.report.replays.report import ReplayReport
from contarm_sim.view.style import Sheet, drawn, save


def figure(replay: Replay, name: str, width: Any, titles: bool) -> Sheet:
    """Return a figure of a replay, see `Replay.figure`.

    Raises:
        InputError: no such figure of the replay, or no such width.
    """
    check_switches(titles=titles)
    figures = ReplayReport(replay).figures
    if name not in figures:
        raise InputError("figure", repr(name), ", ".join(figures) or "none: nothing was predicted")
    if width not in WIDTHS:
        raise InputError("width", repr(width), ", ".join(WIDTHS))
    return drawn(figures[name], width, titles)


def film(replay: Replay, path: str | Path | None = None, *, camera: str = "front", size: Any = None,
         frames: int | None = None, on_frame: Progress | None = None) -> Film:  # fmt: skip
    """Film a replay, see `Replay.film`.

    Raises:
        InputError: no such file ending, size or camera, or a file that cannot be written.
    """
    check_progress(on_frame)
    target = None if path is None else target_of(path, tuple(WRITERS))
    suffix = ".mp4" if target is None else target.suffix.lower()
    width, height = size_of(size, SMALL if target is None else SIZES[USUAL])
    look = Look(width, height, camera, note=words.headline(replay).removesuffix("."))
    shot = ReplayShot(replay, look, frames).checked()
    if target is not None:
        check_writable(target)
    return filmed(shot, suffix, (width, height), shot.count / shot.fps, target, on_frame)


def report(replay: Replay, folder: str | Path | None = None, *, film: bool = False) -> ToldReport:
    """Report a replay, see `Replay.report`.

    Raises:
        InputError: the folder is there already, or cannot be written to.
    """
    check_switches(film=film)
    target = None if folder is None else as_path("folder", folder, "a folder that is not there yet")
    if target is not None:
        check_output(target)
    job = ReplayReport(replay)
    summary = job.told(command="from Python; replay.npz holds what was measured and predicted")
    with TemporaryDirectory() as made, OutputFolder(Path(made) / "replay" if target is None else target) as opened:
        job.write(opened.folder)
        for stem, draw in job.figures.items():
            save(opened.folder, stem, draw)
        if film:
            summary["video"] = job.film(opened.folder, told(None))
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        job.write_page(opened.folder, summary)
        page = (opened.folder / "report.html").read_text(encoding="utf-8")
    return ToldReport(page, summary, None if target is None else opened.target)
