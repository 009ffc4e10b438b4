"""Figures of a replay in space: paths of the last marker from three sides, and the worst poses."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.identify.replays.replay import Replay
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import ERROR, FAINT, MEASURED, PLATE, SIMULATED
from contarm_sim.view.report.outliers import enlarged
from contarm_sim.view.report.replays.course import broken, course_of
from contarm_sim.view.report.replays.words import millimetres, named, status_words
from contarm_sim.view.style import Sheet
from contarm_sim.view.trim import trim

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
            ax.plot(path[:, i], path[:, k], "o", color=MEASURED, markersize=1.3, markeredgewidth=0, label="measured")
            ax.plot(line[:, i], line[:, k], color=SIMULATED, linewidth=0.6, label="simulated")
        else:
            ends = np.full((3 * len(real), 3), np.nan)
            ends[::3], ends[1::3] = real, own
            ax.plot(ends[:, i], ends[:, k], color=ERROR, linewidth=0.8, label="error")
            ax.plot(real[:, i], real[:, k], "o", markerfacecolor="none", markeredgecolor=MEASURED,
                    markersize=2.4 * dot, markeredgewidth=0.8, label="measured")  # fmt: skip
            ax.plot(own[:, i], own[:, k], "o", color=SIMULATED, markersize=dot, markeredgewidth=0, label="simulated")
        ax.set(xlabel=f"{'xyz'[i]} [mm]", ylabel=f"{'xyz'[k]} [mm]")
        ax.set_aspect("equal", adjustable="datalim")
        ax.locator_params(nbins=5)
    sheet.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    name = replay.recording.rig.markers[-1].name
    sheet.heading(f"{name[:1].upper()}{name[1:]} from three sides: measured and simulated")


def draw_worst(sheet: Sheet, replay: Replay) -> None:
    """Draw the poses of the largest errors: the arm, its markers, where they were measured, and the error enlarged.

    Each is seen square to a plane along the base's axis that holds the error of its worst marker.
    """
    chosen = [row for row in replay.worst(WORST) if np.isfinite(replay.frames[row]).all()]
    across = min(3 if sheet.wide else 2, max(len(chosen), 1))
    down = -(-max(len(chosen), 1) // across)
    panels = sheet.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    rig, arm = replay.recording.rig, replay.arm
    often = enlarged(max((float(np.nanmax(replay.distance[row])) for row in chosen), default=0.0) / arm.length)
    for ax, row in zip(panels.ravel(), chosen, strict=False):
        real = (replay.recording.positions[row] - np.array(rig.position)) @ rig.rotation
        own = (replay.predicted[row] - np.array(rig.position)) @ rig.rotation
        _pose(ax, replay, row, real, own, often)
        held = status_words(replay, row)
        said = f"{named(str(replay.recording.blocks[row]))}{', ' if held else ''}{held}"
        ax.set_title(f"sample {row + 1}: {millimetres(float(replay.shape_error[row]))} mm\n{said[:34]}")
    _limits(panels[0, 0], arm, hangs=rig.holds(arm).gravity[2] > 0)
    for ax in panels.ravel():
        ax.set_aspect("equal", anchor="N")
        ax.locator_params(axis="y", nbins=5)
        ax.locator_params(axis="x", nbins=4 if sheet.wide else 3)
    for ax in panels.ravel()[len(chosen) :]:
        ax.set_visible(False)
    for ax in panels[-1]:
        ax.set_xlabel("across [mm]")
    for ax in panels[:, 0]:
        ax.set_ylabel("along base's\naxis [mm]")
    if chosen:
        sheet.legend(
            *panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4 if sheet.wide else 2
        )
    of = " and rms of its markers" if len(rig.markers) > 1 else ""
    sheet.heading(f"The worst poses: sample{of}; seen square to the error of the worst marker" if sheet.wide else
                  f"The worst poses: sample{of}")  # fmt: skip
    left, right = panels[0, 0].get_xlim()
    low, high = sorted(panels[0, 0].get_ylim())
    tall = (150 if sheet.wide else 62) / across * (high - low) / (right - left)
    trim(sheet, min(down * (tall + 10) + (20 if sheet.wide else 30), 165 if sheet.wide else 215))


def _pose(ax: Any, replay: Replay, row: int, real: Array, own: Array, often: int) -> None:
    """Draw one pose: markers in the base's frame [m], shape (K, 3), measured and the arm's; errors `often` as long."""
    side, arm = _plane(real - own), replay.arm

    def flat(points: Array) -> tuple[Array, Array]:
        return MM * points @ side, MM * points[..., 2]

    ax.plot([0, 0], [0, MM * arm.length], color=FAINT, linewidth=1.0)
    ax.plot(*flat(replay.frames[row, :, :3, 3]), color=SIMULATED, linewidth=2.2, label="simulated arm")
    wide = MM * 1.3 * arm.disk_radius
    ax.plot([-wide, wide], [0, 0], color=PLATE, linewidth=3.0, solid_capstyle="butt")
    words = "error" if often == 1 else f"error, {often} times as long"
    for k, (one, other) in enumerate(zip(real, own, strict=True)):
        ends = np.stack([other, other + often * (one - other)])
        ax.plot(*flat(ends), color=ERROR, linewidth=1.2, zorder=3, label=None if k else words)
    ax.plot(*flat(real), "o", color=MEASURED, markersize=4.4, markeredgewidth=0, zorder=4, label="measured markers")
    ax.plot(*flat(own), "o", color="white", markersize=2.6, markeredgecolor=SIMULATED, markeredgewidth=0.9, zorder=5,
            label="markers of the arm")  # fmt: skip


def _limits(ax: Any, arm: Arm, hangs: bool) -> None:
    """Leave an arm that hardly bends room beside it, and draw one that hangs downwards."""
    reach = max(0.26 * MM * arm.length, 1.05 * max(map(abs, ax.get_xlim())))
    ax.set_xlim(-reach, reach)
    low, high = ax.get_ylim()
    ax.set_ylim(*((high, low) if hangs else (low, high)))


def _plane(error: Array) -> Array:
    """Return the direction across the base's axis, shape (3,), of the largest error of a pose, shape (K, 3)."""
    size = np.nan_to_num(np.linalg.norm(error, axis=-1))
    across = np.nan_to_num(error[int(size.argmax())]) * [1.0, 1.0, 0.0]
    norm = float(np.linalg.norm(across))
    return np.asarray(across / norm if norm > 1e-9 else np.array([1.0, 0.0, 0.0]))
