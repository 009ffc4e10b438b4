"""The page of a replay: report.html, which opens offline."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import EncodingError
from contarm_sim.identify.replays.replay import Replay
from contarm_sim.view.report.filled import write_filled
from contarm_sim.view.report.pictures import embedded, encoded, figure, unshown
from contarm_sim.view.report.replays import words

CAPTIONS = {
    "components": "Coordinates of the last marker, measured and simulated; and what is between them. The "
    "band, if there is one, is where 95 % would be if the model were right.",
    "errors": "How far each marker was from where the arm has it, over the samples and block by block. Triangles at "
    "the upper edge are outliers.",
    "histogram": "Sizes of the errors, and their components, in the frame of the measurements.",
    "paths": "The last marker from three sides, measured and simulated.",
    "swings": "Free swings, measured and simulated: some of them over time, frequency and damping of all.",
    "worst": "The poses of the largest errors: measured markers beside the arm.",
}


def write_replay_page(folder: Path, replay: Replay, summary: dict[str, Any]) -> None:
    """Write report.html beside the figures and the film that a replay's folder holds already."""
    arm, gif = replay.recording.rig.holds(replay.arm), folder / "video.gif"
    captions = {stem: said for stem, said in CAPTIONS.items() if stem != "swings" or replay.swings}
    video, no_video = _film(folder / "video.mp4", replay, summary["video"])
    write_filled(
        folder,
        "replay.html.j2",
        arm,
        summary,
        title=f"contarm replay: {replay.recording.name}, {len(replay):,} samples",
        headline=words.headline(replay),
        lead=words.lead(replay),
        standings=words.standings(replay),
        remarks=[],
        meanings=words.MEANINGS,
        video=video,
        gif=encoded(gif.read_bytes()) if gif.is_file() else None,
        no_video=no_video,
        columns=words.COLUMNS,
        markers=words.marker_rows(replay),
        blocks=words.block_rows(replay),
        stretch=words.stretch_rows(replay),
        swing_columns=words.SWINGS,
        swings=words.swing_rows(replay),
        captions=captions,
        figures={stem: figure(folder, stem) for stem in captions},
        unshown=unshown(folder, captions),
    )


def _film(film: Path, replay: Replay, state: str) -> tuple[dict[str, Any] | None, str]:
    """Return the film to embed, or None and why there is none."""
    if not film.is_file():
        return None, f"No film: {state.removeprefix('none: ')}."
    from contarm_sim.view.rendering.look import Look
    from contarm_sim.view.rendering.replayed import ReplayShot

    shot = ReplayShot(replay, Look())
    rows = shot.rows
    worst = int(np.nanargmax(np.nan_to_num(replay.shape_error[rows], nan=-1.0)))
    try:
        return embedded(film, shot.count / shot.fps, worst / shot.fps), ""
    except EncodingError as error:
        return None, f"The film, {film.name}, is beside this page, which cannot show it: {error}."
