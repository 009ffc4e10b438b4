"""What a replay leaves behind: numbers and samples first, then figures, page and film."""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import EncodingError
from contarm_sim.identify.differences import root_mean_square
from contarm_sim.identify.prediction.swings import Swing
from contarm_sim.identify.replays.replay import Replay
from contarm_sim.model.arm_file import arm_to_toml
from contarm_sim.results.document import document
from contarm_sim.versions import versions
from contarm_sim.view.report.replays import words
from contarm_sim.view.report.replays.in_space import draw_paths, draw_worst
from contarm_sim.view.report.replays.over_time import draw_components, draw_errors, draw_histogram
from contarm_sim.view.report.replays.swings import draw_swings
from contarm_sim.view.style import Draw

FIGURES: dict[str, Callable[[Any, Replay], None]] = {
    "components": draw_components,
    "errors": draw_errors,
    "histogram": draw_histogram,
    "paths": draw_paths,
    "worst": draw_worst,
}
"""What draws the figures, by the stems of their files."""


class ReplayReport:
    """A replay in files, pictures and words."""

    def __init__(self, replay: Replay) -> None:
        self._replay = replay

    def told(self, *, command: str, video: str = "not asked for", within: float | None = None) -> dict[str, Any]:
        """Return what summary.json holds: SI units.

        Args:
            command: how to do it again.
            video: the name of the film, or why there is none.
            within: the largest rms that is asked for [m], or None.
        """
        replay, bands = self._replay, self._replay.bands
        recording, found = replay.recording, replay.differences()
        held = replay.held_out
        made: dict[str, Any] = {
            "recording": recording.name, "kind": recording.kind, "samples": len(replay), "length_m": replay.arm.length,
            "in_words": words.headline(replay), "error": found.to_dict(),
            "rms_percent": 100 * found.rms / replay.arm.length,
            "shape_rms_m": root_mean_square(replay.shape_error), "unpredicted": replay.unpredicted,
            "by_marker": {name: one.to_dict() for name, one in replay.by_marker().items()},
            "by_block": {name: one.to_dict() for name, one in replay.by_block().items()},
            "between_markers": [
                {"markers": name, "mean_m": mean, "rms_m": rms} for name, mean, rms in replay.stretch()
            ],
            "held_out": None if held is None else int(held.sum()),
            "error_held_out": None if held is None or not held.any() else replay.differences(held).to_dict(),
            "bands": None if bands is None else {
                "share_inside": bands.share, "meant_inside": words.INSIDE, "noise_m": bands.noise,
                "rms_interval_m": bands.rms, "rms_foreseen_m": bands.foreseen, "counted_as_known": bands.held,
            },
            "worst_samples": [row + 1 for row in replay.worst()], "swings": [_swing(one) for one in replay.swings],
            "within_m": within, "verdict": None if within is None else "pass" if found.rms <= within else "fail",
            "versions": versions(), "command": command, "video": video,
        }  # fmt: skip
        return dict(document(made))

    def write(self, folder: Path) -> None:
        """Write replay.csv, replay.npz and arm.toml."""
        replay = self._replay
        recording = replay.recording
        given: dict[str, Any] = {
            "time": recording.time, "block": recording.blocks, "commands": recording.commands,
            "measured": recording.positions, "predicted": replay.predicted, "stations": replay.frames[..., :3, 3],
        }  # fmt: skip
        if replay.bands is not None:
            given |= {"band_covariance": replay.bands.covariance, "inside": replay.bands.inside}
        if replay.held_out is not None:
            given["held_out"] = replay.held_out
        np.savez_compressed(folder / "replay.npz", **given)
        with (folder / "replay.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows(_table(replay))
        (folder / "arm.toml").write_text(arm_to_toml(replay.arm), encoding="utf-8")

    @property
    def figures(self) -> dict[str, Draw]:
        """What draws the figures, by their names."""
        if not self._replay.differences().count:
            return {}
        made: dict[str, Draw] = {stem: partial(_drawn, draw, self._replay) for stem, draw in FIGURES.items()}
        if self._replay.swings:
            made["swings"] = partial(_drawn, draw_swings, self._replay)
        return made

    def write_page(self, folder: Path, summary: dict[str, Any]) -> None:
        """Write report.html around the figures and the film that are there."""
        from contarm_sim.view.report.replays.page import write_replay_page

        write_replay_page(folder, self._replay, summary)

    def film(self, folder: Path, on_frame: Callable[[int, int], object]) -> str:
        """Write video.mp4 and return its name; where there is no encoder, video.gif.

        Raises:
            RenderingError: nothing draws here, or the encoder failed.
        """
        from contarm_sim.view.rendering.encode import encoder
        from contarm_sim.view.rendering.formats import SMALL
        from contarm_sim.view.rendering.look import Look
        from contarm_sim.view.rendering.replayed import ReplayShot
        from contarm_sim.view.rendering.video import write_gif, write_video

        note = words.headline(self._replay).removesuffix(".")
        try:
            encoder()
        except EncodingError:
            small = Look(width=SMALL[0], height=SMALL[1], note=note)
            write_gif(ReplayShot(self._replay, small, some_samples=150), folder / "video.gif", on_frame)
            return "video.gif"
        write_video(ReplayShot(self._replay, Look(note=note)), folder / "video.mp4", on_frame)
        return "video.mp4"


def _swing(one: Swing) -> dict[str, Any]:
    parts = (("measured", one.measured), ("simulated", one.simulated))
    told = {name: {"frequency_hz": each.frequency, "damping_per_s": each.damping, "amplitude_m": each.amplitude}
            for name, each in parts}  # fmt: skip
    own = {"frequency_percent": one.frequency_percent, "damping_percent": one.damping_percent}
    return {"block": one.block} | told | own


def _drawn(draw: Callable[[Any, Replay], None], replay: Replay, sheet: Any) -> None:
    draw(sheet, replay)


def _table(replay: Replay) -> list[list[Any]]:
    """Return the rows of replay.csv: a sample each, metres and seconds."""
    recording, bands = replay.recording, replay.bands
    names = [f"{name}.{axis}" for name in replay.by_marker() for axis in "xyz"]
    head = ["time_s", "block", *(f"measured.{name}_m" for name in names), *(f"predicted.{name}_m" for name in names)]
    head += [f"error.{name}_m" for name in replay.by_marker()]
    columns = [recording.positions.reshape(len(replay), -1), replay.predicted.reshape(len(replay), -1), replay.distance]
    if bands is not None:
        head += [f"band.{name}_m" for name in names]
        columns.append(bands.half_width.reshape(len(replay), -1))
    if replay.held_out is not None:
        head.append("held_out")
    rows: list[list[Any]] = [head]
    for k, values in enumerate(np.concatenate(columns, axis=1).tolist()):
        told = ["" if value != value else f"{value:.9g}" for value in values]
        held = [] if replay.held_out is None else [int(replay.held_out[k])]
        rows.append([f"{recording.time[k]:.9g}", recording.blocks[k], *told, *held])
    return rows
