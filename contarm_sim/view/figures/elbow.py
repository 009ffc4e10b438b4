"""The poses of two sections that reach one point, and their elbows."""

from __future__ import annotations

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics import sections
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import PURPLE, TARGET
from contarm_sim.view.once import once
from contarm_sim.view.sections import section_look, section_places
from contarm_sim.view.space import add_space
from contarm_sim.view.style import Sheet


def elbow(sheet: Sheet, arm: Arm) -> None:
    """Draw the poses of two sections that reach one point: some arms, the curve of their elbows, and their bends.

    Raises:
        InputError: an arm of other than two sections.
    """
    backbone = shape.backbone(arm)
    if len(backbone) != 2:
        raise InputError("figure", "elbow", "an arm of two sections")
    sheet.heading("Poses of two sections that reach one point: the elbow runs along a curve")
    target = _seen_from_the_side(backbone)
    curves = _poses(backbone)
    sheet.tall(84 if sheet.wide else 150)
    layout = {"width_ratios": [1.5, 1]} if sheet.wide else {"height_ratios": [1.5, 1]}
    grid = sheet.add_gridspec(*((1, 2) if sheet.wide else (2, 1)), **layout)  # type: ignore[arg-type]
    ax, plain = add_space(sheet, arm, grid[0]), sheet.add_subplot(grid[1])
    for curve in curves:
        for bends in curve[:: max(len(curve) // 10, 1)]:
            for number, xi in enumerate(section_places(arm, 30)):
                line = sections.position(bends, backbone, xi)
                ax.trace(line, **section_look(number), linewidth=1.0, alpha=0.7)
        ax.trace(sections.frames(curve, backbone)[:, 1, :3, 3], color=PURPLE, linewidth=1.8)
        share = np.linspace(0, 100, len(curve))
        for number in range(2):
            angle = np.degrees(np.hypot(*curve[:, number].T))
            plain.plot(share, angle, **section_look(number))
    for number in range(2):
        ax.plot([], [], **section_look(number), label=f"section {number + 1}")
    ax.plot([], [], color=PURPLE, linewidth=1.8, label="elbow's curve")
    ax.trace(target[None], color=TARGET, linestyle="", marker="o", markersize=5, label="target")
    ax.settle(legend=False)
    sheet.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=4 if sheet.wide else 2)
    plain.set_xlabel("along the elbow's curve [%]")
    plain.set_ylabel("bend angle [deg]")
    plain.set_xlim(0, 100)
    plain.set_ylim(bottom=0)


@once
def _poses(backbone: Backbone) -> list[Array]:
    """Return curves of bends that reach that place [rad], each of shape (K, 2, 2)."""
    from contarm_sim.kinematics.inverse import family

    return list(family(_seen_from_the_side(backbone), backbone).curve(121))


def _seen_from_the_side(backbone: Backbone) -> Array:
    """Return a place off the axis that many poses reach [m], shape (3,)."""
    limits = np.array(backbone.limits)
    bends = np.array([[0.45 * limits[0], 0.0], [0.25 * limits[1], 0.3 * limits[1]]])
    return sections.position(bends, backbone)
