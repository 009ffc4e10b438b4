"""Draws the frames and signs, and which package may import which, into docs/images."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.patches import Arc

from contarm_sim import Arm
from contarm_sim.kinematics import arc
from contarm_sim.model.colours import muscle_hex

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs" / "images"
RED, GREEN, BLUE, GREY, DARK = "#c0392b", "#27863a", "#1f5fa8", "#9aa0a6", "#202428"
MUSCLES = tuple(muscle_hex(i) for i in range(3))
BEND = math.radians(75)


def _arrow(ax, start, way, colour, text="", shift=(0.0, 0.0), width=2.0):
    start, way = np.asarray(start), np.asarray(way)
    ax.annotate("", start + way, start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": width,
                                                     "shrinkA": 0, "shrinkB": 0})  # fmt: skip
    ax.text(*(start + way + shift), text, color=colour, ha="center", va="center", fontsize=10, fontweight="bold")


def _side(ax):
    """Draw the arm from the side, bent towards muscle 1: frames, bend angle, lengths."""
    arm, bend = Arm(), arc.from_polar(BEND, 0.0)
    xi = np.linspace(0, 1, 80)
    line = arc.position(bend, arm.length, xi)[:, [0, 2]]
    across = arc.rotation(bend, xi)[:, [0, 2], 0]
    wide = 2.0 * arm.muscle_radius  # the muscles' distance from the backbone is drawn twice as large
    ax.plot([0, 0], [0, arm.length], color=GREY, lw=3, ls=(0, (2, 2)))
    ax.text(-0.004, arm.length + 0.014, "straight", color=GREY, ha="center", fontsize=9)
    ax.plot(*(line + wide * across).T, color=MUSCLES[0], lw=2.5)
    ax.plot(*(line - 0.5 * wide * across).T, color=GREY, lw=2)
    ax.plot(*line.T, color=DARK, lw=4)
    middle = line[45] + wide * across[45]
    ax.annotate("muscle 1 shortens:\n$l_1 < 0$", middle, (0.135, 0.075), color=MUSCLES[0], fontsize=9,
                arrowprops={"arrowstyle": "-", "color": MUSCLES[0]})  # fmt: skip
    middle = line[28] - 0.5 * wide * across[28]
    ax.annotate("muscles 2 and 3 lengthen:\n$l_2, l_3 > 0$", middle, (-0.245, 0.10), color="#5f6368", fontsize=9,
                arrowprops={"arrowstyle": "-", "color": GREY})  # fmt: skip
    ax.annotate("backbone of constant\nlength $L_0$", line[44], (-0.245, 0.175), color=DARK, fontsize=9,
                arrowprops={"arrowstyle": "-", "color": DARK})  # fmt: skip
    ax.plot([-0.05, 0.05], [0, 0], color=DARK, lw=7, solid_capstyle="butt")
    _arrow(ax, (0, 0), (0, 0.075), BLUE, "+Z", (-0.024, -0.008))
    _arrow(ax, (0, 0), (0.095, 0), RED, "+X", (0.016, 0))
    ax.text(0.115, -0.022, "towards muscle 1", color=RED, fontsize=8, ha="center")
    ax.text(-0.028, -0.022, "base frame", color=DARK, fontsize=9, ha="right")
    tip, frame = line[-1], arc.rotation(bend)[[0, 2]]
    _arrow(ax, tip, 0.075 * frame[:, 2], BLUE, "+Z", (0.015, 0.006))
    _arrow(ax, tip, 0.075 * frame[:, 0], RED, "+X", (0.018, 0.002))
    ax.text(tip[0] - 0.004, tip[1] + 0.022, "tip", color=DARK, fontsize=9, ha="center")
    back = tip - 0.13 * frame[:, 2]
    corner = np.array([0.0, back[1] - back[0] * frame[1, 2] / frame[0, 2]])
    ax.plot(*np.array([tip, corner]).T, color=GREY, lw=1, ls=":")
    degrees = math.degrees(BEND)
    ax.add_patch(Arc(corner, 0.10, 0.10, theta1=90 - degrees, theta2=90, color="#d35400", lw=1.8))
    ax.text(corner[0] + 0.058, corner[1] + 0.052, "bend_angle", color="#d35400", fontsize=10, ha="center")
    ax.set_title("from the side: bent towards muscle 1", fontsize=10)
    ax.set(xlim=(-0.25, 0.29), ylim=(-0.05, 0.43))


def _top(ax):
    """Draw the base, looked at from above: muscles, bend vector, plane angle."""
    turn = np.linspace(0, 2 * np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=GREY, lw=1)
    for i, colour in enumerate(MUSCLES):
        where = np.array([math.cos(2 * math.pi * i / 3), math.sin(2 * math.pi * i / 3)])
        ax.plot([0, where[0]], [0, where[1]], color=GREY, lw=0.8, ls=":")
        ax.add_patch(plt.Circle(where, 0.13, color=colour, zorder=5))
        ax.text(*where, str(i + 1), color="white", ha="center", va="center", fontweight="bold", zorder=6)
    ax.text(-0.38, 0.36, "$r$", color="#5f6368", fontsize=10)
    _arrow(ax, (0, 0), (1.5, 0), RED, "+X", (0.13, 0.0))
    _arrow(ax, (0, 0), (0, 1.35), GREEN, "+Y", (0.0, 0.12))
    ax.plot(0, 0, "o", ms=11, mfc="white", mec=BLUE, mew=2)
    ax.plot(0, 0, ".", ms=6, color=BLUE)
    ax.text(-0.13, -0.19, "+Z", color=BLUE, fontweight="bold", ha="center")
    plane = math.radians(38)
    _arrow(ax, (0, 0), 1.25 * np.array([math.cos(plane), math.sin(plane)]), "#d35400", width=2.6)
    ax.text(1.02, 0.98, "bend", color="#d35400", fontsize=11, fontweight="bold")
    ax.add_patch(Arc((0, 0), 1.1, 1.1, theta1=0, theta2=38, color="#d35400", lw=1.8))
    ax.text(0.24, -0.2, "plane_angle", color="#d35400", fontsize=9)
    ax.text(0, -1.55, "bend = bend_angle · (cos plane_angle, sin plane_angle)\nthe tip moves the way that bend points",
            ha="center", fontsize=9, color=DARK)  # fmt: skip
    ax.set_title("from above: +Z points at you", fontsize=10)
    ax.set(xlim=(-1.4, 1.85), ylim=(-1.8, 1.65))


def frames(folder: Path) -> None:
    """Draw the frames and signs."""
    figure, axes = plt.subplots(1, 2, figsize=(9.6, 4.6), width_ratios=(1.1, 1), layout="constrained")
    for ax, draw in zip(axes, (_side, _top), strict=True):
        draw(ax)
        ax.set_aspect("equal")
        ax.axis("off")
    figure.savefig(folder / "frames.png", dpi=110, facecolor="white", metadata={"Software": None})


def _direct(may):
    """Return, for every package, the packages that it may import and that none of these may import for it."""
    return {one: {other for other in may[one] if not any(other in may[via] for via in may[one])} for one in may}


def imports(folder: Path) -> None:
    """Draw the packages in levels, as `tests/test_architecture.py` allows their imports."""
    sys.path.insert(0, str(ROOT / "tests"))
    from test_architecture import MAY

    packages = [name for name in MAY if (ROOT / "contarm_sim" / name).is_dir()]
    may = {name: {other for other in MAY[name] if other in packages} for name in packages}
    level: dict[str, int] = {}
    for _ in packages:
        level = {name: 1 + max((level.get(other, 0) for other in may[name]), default=-1) for name in packages}
    place = {}
    for height in set(level.values()):
        row = [name for name in packages if level[name] == height]
        for i, name in enumerate(row):
            place[name] = np.array([1.7 * (i - (len(row) - 1) / 2), 1.0 * height])
    figure, ax = plt.subplots(figsize=(6.4, 0.62 * (1 + max(level.values()))), layout="constrained")
    for name, others in _direct(may).items():
        for other in others:
            bow = 0.25 if place[name][0] == place[other][0] and level[name] - level[other] > 1 else 0.0
            style = {"arrowstyle": "-|>", "color": GREY, "connectionstyle": f"arc3,rad={bow}"}
            ax.annotate("", place[other] + (0, 0.24), place[name] - (0, 0.24), arrowprops=style)
    for name, at in place.items():
        free = name in ("model", "kinematics", "mechanics", "paths", "results")
        ax.text(*at, name, ha="center", va="center", fontsize=9, color="white" if free else DARK,
                bbox={"boxstyle": "round,pad=0.35", "fc": BLUE if free else "#dfe5ea", "ec": "none"})  # fmt: skip
    ax.axis("off")
    ax.set(xlim=(-3.6, 3.6), ylim=(-0.5, max(level.values()) + 0.5))
    figure.savefig(folder / "imports.png", dpi=110, facecolor="white", metadata={"Software": None})


if __name__ == "__main__":
    frames(IMAGES)
    imports(IMAGES)
