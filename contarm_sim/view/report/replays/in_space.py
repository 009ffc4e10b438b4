"""Figures of a replay in space: paths of the last marker from three sides, and the worst poses."""

from __future__ import annotations

import numpy as np

from contarm_sim.identify.replay import Replay
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import ERROR, FAINT, MEASURED, PLATE, SIMULATED
from contarm_sim.view.report.replays.course import broken, course_of
from contarm_sim.view.report.replays.words import millimetres, status_words
from contarm_sim.view.style import Sheet

MM = 1e3

_VIEWS = ((0, 1), (0, 2), (1, 2))

WORST = 6
"""Poses that are drawn."""


def draw_paths(sheet: Sheet, replay: Replay) -> None:
    """Draw where the last marker was and where the arm has it, from three sides."""
    sheet.tall(74 if sheet.wide else 190)
    course, dot = course_of(replay), 2.2 if len(replay) < 300 else 1.4
    real, own = MM * replay.recording.positions[:, -1], MM * replay.predicted[:, -1]
    panels = sheet.subplots(*((1, 3) if sheet.wide else (3, 1)))
    _, line = broken(own, course)
    for ax, (i, k) in zip(panels, _VIEWS, strict=True):
        if replay.recording.kind == "motion":
            _, path = broken(real, course)
            ax.plot(path[:, i], path[:, k], color=MEASURED, linewidth=0.9, label="measured")
            ax.plot(line[:, i], line[:, k], color=SIMULATED, linewidth=0.9, label="simulated")
        else:
            ends = np.full((3 * len(real), 3), np.nan)
            ends[::3], ends[1::3] = real, own
            ax.plot(ends[:, i], ends[:, k], color=ERROR, linewidth=0.4, alpha=0.5, label="error")
            ax.plot(real[:, i], real[:, k], "o", color=MEASURED, markersize=dot, markeredgewidth=0, label="measured")
            ax.plot(own[:, i], own[:, k], "o", color=SIMULATED, markersize=dot, markeredgewidth=0, label="simulated")
        ax.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[k]} [mm]")
        ax.set_aspect("equal", adjustable="datalim")
        ax.locator_params(nbins=5)
    sheet.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    name = replay.recording.rig.markers[-1].name
    sheet.heading(f"Where the marker {name} was and where the arm has it, from three sides")


def draw_worst(sheet: Sheet, replay: Replay) -> None:
    """Draw the poses of the largest errors: the arm, its markers, and where they were measured.

    Each is seen square to a plane along the base's axis that holds the error of its worst marker.
    """
    chosen = [row for row in replay.worst(WORST) if np.isfinite(replay.frames[row]).all()]
    across = min(3 if sheet.wide else 2, max(len(chosen), 1))
    down = -(-max(len(chosen), 1) // across)
    sheet.tall((62 if sheet.wide else 66) * down + 14)
    panels = sheet.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    rig, arm = replay.recording.rig, replay.arm
    hangs = rig.holds(arm).gravity[2] > 0
    for ax, row in zip(panels.ravel(), chosen, strict=False):
        real = (replay.recording.positions[row] - np.array(rig.position)) @ rig.rotation
        own = (replay.predicted[row] - np.array(rig.position)) @ rig.rotation
        side = _plane(real - own)
        flat = lambda points, side=side: (MM * points @ side, MM * points[..., 2])  # noqa: E731
        ax.plot([0, 0], [0, MM * arm.length], color=FAINT, linewidth=1.0)
        ax.plot(*flat(replay.frames[row, :, :3, 3]), color=SIMULATED, linewidth=2.2, label="simulated arm")
        wide = MM * 1.3 * arm.disk_radius
        ax.plot([-wide, wide], [0, 0], color=PLATE, linewidth=3.0, solid_capstyle="butt")
        for k, (one, other) in enumerate(zip(real, own, strict=True)):
            if np.isfinite(one).all():
                ends = flat(np.stack([one, other]))
                ax.plot(*ends, color=ERROR, linewidth=1.0, label=None if k else "error")
        ax.plot(*flat(own), "o", color=SIMULATED, markersize=3.2, markeredgecolor="white", markeredgewidth=0.5,
                label="its markers")  # fmt: skip
        ax.plot(*flat(real), "o", color=MEASURED, markersize=4.2, markeredgewidth=0, label="measured markers")
        held = status_words(replay, row)
        said = f"{replay.recording.blocks[row]}{', ' if held else ''}{held}"
        ax.set_title(f"sample {row + 1}: {millimetres(float(replay.shape_error[row]))} mm\n{said[:34]}")
        ax.set_aspect("equal", anchor="N")
        ax.locator_params(nbins=5)
    for ax in panels.ravel()[len(chosen) :]:
        ax.set_visible(False)
    if hangs:
        panels[0, 0].invert_yaxis()
    for ax in panels[-1]:
        ax.set_xlabel("across [mm]")
    for ax in panels[:, 0]:
        ax.set_ylabel("along the base's axis [mm]")
    if chosen:
        sheet.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4 if sheet.wide else 2)
    sheet.heading("The worst poses, each seen so that the error of its worst marker has its true length")


def _plane(error: Array) -> Array:
    """Return the direction across the base's axis, shape (3,), of the largest error of a pose, shape (K, 3)."""
    size = np.nan_to_num(np.linalg.norm(error, axis=-1))
    across = np.nan_to_num(error[int(size.argmax())]) * [1.0, 1.0, 0.0]
    norm = float(np.linalg.norm(across))
    return np.asarray(across / norm if norm > 1e-9 else np.array([1.0, 0.0, 0.0]))
