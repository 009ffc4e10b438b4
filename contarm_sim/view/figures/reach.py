"""What several sections reach: slices of the workspace, how often and how well, and the poses that reach one point."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics import sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import BLACK, PURPLE
from contarm_sim.view.sections import section_hex, section_places
from contarm_sim.view.style import Sheet
from contarm_sim.view.workspace import Workspace, folds, hull, planar_tips, workspace

MM = 1e3
CELLS, POSES = 64, 1_000_000
"""Cells of a map in the length of the arm, and poses that it is drawn from."""

_LOOK: dict[str, Any] = {"cmap": "viridis", "rasterized": True}


def slices(fig: Sheet, arm: Arm) -> None:
    """Draw where the tip can be in a plane through the axis, its convex hull, and arms bent in that plane.

    Of two sections also the curves at which poses fold or bends are at their limits: the edges are among them.
    """
    backbone = shape.backbone(arm)
    found, outer = workspace(backbone, 2 * CELLS, POSES), hull(backbone)
    wide, low, high = MM * outer[:, 0].max(), *(MM * np.array([outer[:, 1].min(), outer[:, 1].max()]))
    edge = 0.06 * wide
    fig.tall(25.4 * (2.0 + 2.7 * (high - low) / wide))
    ax = fig.subplots()
    reached = _filled(found, backbone)
    both = np.concatenate([reached[::-1], reached]).astype(float)
    distances = MM * np.concatenate([-found.grid.distances[::-1], found.grid.distances])
    ax.contourf(distances, MM * found.grid.heights, both.T, [0.5, 1.5], colors=["#DCE6F2"])
    ax.fill([], [], color="#DCE6F2", label="reachable tips")
    for side in (-1, 1):
        ax.plot(side * MM * outer[:, 0], MM * outer[:, 1], color=BLACK, linewidth=0.8, linestyle="--")
    ax.plot([], [], color=BLACK, linewidth=0.8, linestyle="--", label="convex hull")
    if len(backbone) == 2:
        for curve in folds(backbone):
            ax.plot(*(MM * curve.T), color=PURPLE, linewidth=0.9)
        ax.plot([], [], color=PURPLE, linewidth=0.9, label="folds and limits")
    _draw_examples(ax, arm, backbone)
    ax.set_aspect("equal", anchor="N")
    ax.set_xlim(-wide - edge, wide + edge)
    ax.set_ylim(low - edge, high + edge)
    ax.set_xlabel("distance from the axis, in the plane [mm]")
    ax.set_ylabel("height z [mm]")
    fig.legend(*ax.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    fig.draw_without_rendering()  # axes of equal scales leave room below: cut it off
    fig.set_size_inches(5.4, fig.get_figheight() - fig.get_tightbbox().y0 + 0.05)


def _filled(found: Workspace, backbone: Backbone) -> NDArray[np.bool_]:
    """Return the cells that drawn poses reach, and planar ones, which find the edges."""
    tips = np.insert(planar_tips(backbone), 1, 0.0, axis=1)
    reached = found.reached.ravel().copy()
    reached[found.grid.cell(tips)] = True
    return reached.reshape(found.grid.shape)


def _draw_examples(ax: Any, arm: Arm, backbone: Backbone) -> None:
    """Draw three planar arms: straight, bent one way, bent one way and back."""
    limits = np.array(backbone.limits)
    signs = np.where(np.arange(len(limits)) % 2, -1.0, 1.0)
    for angles in (0 * limits, 0.6 * limits / np.sqrt(len(limits)), -0.75 * limits * signs):
        bends = np.stack([angles, 0 * angles], axis=-1)
        for number, xi in enumerate(section_places(arm, 40)):
            line = MM * sections.position(bends, backbone, xi)[:, [0, 2]]
            ax.plot(*line.T, color=section_hex(number), linewidth=2.2)
            ax.plot(*line[-1], "o", color=section_hex(number), markersize=3.5)
    for number in range(len(limits)):
        limit = np.degrees(limits[number])
        ax.plot([], [], color=section_hex(number), linewidth=2.2, label=f"section {number + 1}, to {limit:.0f}°")


def density(fig: Sheet, arm: Arm) -> None:
    """Draw how much of all poses, drawn evenly from each section's disk of bends, have their tip in a volume."""
    found = workspace(shape.backbone(arm), CELLS, POSES)
    _draw_map(fig, found, 0.1 * found.density, "share of poses with their tip there [% per litre]")


def dexterity(fig: Sheet, arm: Arm) -> None:
    """Draw how well the tip does at a place: by the directions that it can have, or by how it can move.

    Three sections and more reach a place in directions of a whole range, whose share of all directions says how free a
    tool is. Two sections have a single curve of directions, a share of nothing; of them the figure shows the smallest
    singular value of the position's Jacobian, of the best pose: the way of the tip for one radian of bends where it
    moves least.
    """
    backbone = shape.backbone(arm)
    found = workspace(backbone, CELLS if len(backbone) < 3 else CELLS // 2, POSES)
    if len(backbone) < 3:
        _draw_map(fig, found, MM * found.slowest, "least tip motion, best pose [mm/rad]")
    else:
        _draw_map(fig, found, 100 * found.directions, "tip directions reached [% of all]")


def _draw_map(fig: Sheet, found: Workspace, values: Array, label: str) -> None:
    fig.tall(109)
    ax = fig.subplots()
    shown = np.where(found.reached, values, np.nan)
    size = 0.5 * found.grid.size
    edges = np.append(found.grid.distances - size, found.grid.distances[-1] + size)
    heights = np.append(found.grid.heights - size, found.grid.heights[-1] + size)
    top = float(np.nanpercentile(shown, 99.5))
    mesh = ax.pcolormesh(MM * edges, MM * heights, shown.T, vmin=0, vmax=top, **_LOOK)
    ax.set_aspect("equal")
    ax.set_xlabel("distance from the axis [mm]")
    ax.set_ylabel("height z [mm]")
    fig.colorbar(mesh, ax=ax, label=label, extend="max")


def elbow(fig: Sheet, arm: Arm) -> None:
    """Draw the poses of two sections that reach one point: some arms, the curve of their elbows, and their bends.

    Raises:
        InputError: an arm of other than two sections.
    """
    from matplotlib.ticker import MaxNLocator

    from contarm_sim.kinematics.inverse import family

    backbone = shape.backbone(arm)
    if len(backbone) != 2:
        raise InputError("figure", "elbow", "an arm of two sections")
    target = _seen_from_the_side(backbone)
    found = family(target, backbone)
    fig.tall(91)
    left, right = fig.subfigures(1, 2, width_ratios=[1.25, 1])  # type: ignore[misc]
    space = left.add_subplot(projection="3d", computed_zorder=False)
    plain = right.subplots()
    for curve in found.curve(121):
        space.plot(*(MM * sections.frames(curve, backbone)[:, 1, :3, 3].T), color=PURPLE, linewidth=1.6)
        for bends in curve[:: max(len(curve) // 10, 1)]:
            for number, xi in enumerate(section_places(arm, 30)):
                space.plot(*(MM * sections.position(bends, backbone, xi).T), color=section_hex(number), alpha=0.55)
        share = np.linspace(0, 100, len(curve))
        for number in range(2):
            angle = np.degrees(np.hypot(*curve[:, number].T))
            plain.plot(share, angle, color=section_hex(number), label=f"section {number + 1}")
    space.plot([], [], color=PURPLE, label="elbow's curve")
    space.plot(*(MM * target), "o", color=BLACK, markersize=5, label="target")
    for axis in "xyz":
        getattr(space, f"set_{axis}label")(f"{axis} [mm]")
    space.set_aspect("equal")
    space.set_box_aspect(None, zoom=0.86)
    space.view_init(20, -60)
    for axis in (space.xaxis, space.yaxis, space.zaxis):
        axis.set_major_locator(MaxNLocator(4))
    space.legend(loc="upper left")
    plain.set_xlabel("along the curve [%]")
    plain.set_ylabel("bend angle [deg]")
    plain.set_xlim(0, 100)
    plain.set_ylim(bottom=0)
    names = dict(zip(*plain.get_legend_handles_labels()[::-1], strict=True))  # each once
    plain.legend(names.values(), names.keys())


def _seen_from_the_side(backbone: Backbone) -> Array:
    """Return a place off the axis that many poses reach [m], shape (3,)."""
    limits = np.array(backbone.limits)
    bends = np.array([[0.45 * limits[0], 0.0], [0.25 * limits[1], 0.3 * limits[1]]])
    return sections.position(bends, backbone)
