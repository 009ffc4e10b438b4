"""The figure of what a run's arm touches: forces and depths of objects over time, and which links touch when."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mjcf import names
from contarm_sim.results.touched import link_forces, object_depths, object_force_sizes
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import LIMIT, contact_map, things
from contarm_sim.view.style import Sheet

_COLUMNS = 500
"""Times that the map shows, at most: more than print can tell apart."""

_USUAL = 99.0
"""Percentile of the forces on links that the map's colours reach to: a blow would make all else pale."""


def draw_contact(sheet: Sheet, samples: Trajectory) -> None:
    """Draw forces and depths of all objects that are touched over time, and below, link by link, where they act.

    Raises:
        ValueError: an arm that can touch nothing.
    """
    found, count = samples.contacts, len(samples)
    if found is None:
        raise ValueError("nothing can be touched")
    sheet.tall(125)
    force, depth, links = sheet.subplots(3, 1, sharex=True, height_ratios=[36, 24, 40])
    forces, depths = object_force_sizes(found, count), object_depths(found, count)
    for look, place in zip(things(), np.unique(found.partner), strict=False):
        style: dict[str, Any] = {"color": look.colour, "linestyle": look.dashes}
        force.plot(samples.time, forces[:, place], label=found.names[place], **style)
        depth.plot(samples.time, 1e3 * depths[:, place], **style)
    _draw_links(sheet, links, samples)
    force.set_ylabel("net force on\nthe arm [N]")
    depth.set_ylabel("depth\n[mm]")
    links.set_xlabel("time [s]")
    links.set_xlim(float(samples.time[0]), float(samples.time[-1]))
    for ax, values in ((force, forces), (depth, 1e3 * depths)):
        ax.set_ylim(0, 1.08 * float(values.max(initial=0.0)) or 1.0)
    if len(found):
        force.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=5 if sheet.wide else 3)
    sheet.align_ylabels([force, depth, links])
    sheet.heading("What the arm touches: forces on it, how far links and objects overlap, and which links touch")


def _draw_links(sheet: Sheet, ax: Any, samples: Trajectory) -> None:
    """Draw a map of the forces on links over time, lines where a section ends."""
    found, arm = samples.contacts, samples.arm
    assert found is not None
    forces = link_forces(found, len(samples), arm.links + 1)
    edges, binned = _binned(samples.time, forces)
    acting = binned[binned > 0]
    most = float(np.percentile(acting, _USUAL)) if len(acting) else 1.0
    drawn = ax.pcolormesh(
        edges, np.arange(arm.links + 2) - 0.5, np.ma.masked_equal(binned, 0.0).T, cmap=contact_map(), vmin=0.0,
        vmax=most, rasterized=True,
    )  # fmt: skip
    for end in names.section_stations(arm)[1:-1]:
        ax.axhline(end, color=LIMIT, linewidth=0.8, linestyle="--")
    ax.set_ylabel(f"link (0: base,\n{arm.links}: tip)")
    ax.set_ylim(-0.5, arm.links + 0.5)
    ax.yaxis.get_major_locator().set_params(integer=True)
    beyond = "max" if len(acting) and acting.max() > 1.001 * most else "neither"
    bar = sheet.colorbar(drawn, ax=ax, location="bottom", extend=beyond, aspect=50, pad=0.04)
    bar.set_label("contact force on a link [N]")


def _binned(time: Array, values: Array) -> tuple[Array, Array]:
    """Return edges [s] and the largest values in between, of few enough samples in a row to be drawn together."""
    stride = -(-len(time) // _COLUMNS)
    starts = np.arange(0, len(time), stride)
    step = 0.5 * float(time[1] - time[0]) if len(time) > 1 else 0.5
    return np.append(time[starts] - step, time[-1] + step), np.maximum.reduceat(values, starts, axis=0)
