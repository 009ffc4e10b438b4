"""Angles and muscle lengths along a path, over time: analytic, simulated, and what the two differ by."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.model.arm import Arm
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import DISCRETISATION, ERROR
from contarm_sim.view.figures.common import BROAD, THIN, OwnPath, called, followed
from contarm_sim.view.sections import section_hex, section_look
from contarm_sim.view.stance import stance
from contarm_sim.view.style import Sheet

MM = 1e3

_CLEAR = np.radians(5.0)
"""Bends below it have no plane that would be worth a number [rad]."""


def angles(sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
    """Draw bend and plane angle along a path, as commanded and as simulated lengths show them, and the differences."""
    samples = followed(arm, own)
    sheet.heading(f"Bend along {called(own)}, asked for and as muscle lengths show it ({stance(arm)})")
    commanded, measured = _angles(samples)
    several = len(arm.sections) > 1
    for i, (value, off) in enumerate(_panels(sheet)):
        for number in range(len(arm.sections)):
            look = {"color": section_hex(number), "label": f"section {number + 1}", "alpha": 0.45} if several else {}
            value.plot(samples.time, measured[i][:, number], **BROAD | look)
            off.plot(
                samples.time,
                (measured[i] - commanded[i])[:, number],
                **section_look(number) if several else {"color": ERROR},
            )
        for number in range(len(arm.sections)):
            value.plot(samples.time, commanded[i][:, number], **THIN | ({"label": None} if number else {}))
        value.set_ylabel(("bend angle [deg]", "plane angle [deg]")[i])
        off.set_ylabel(("difference\n[deg]", "difference where\nbent > 5° [deg]")[i])
        if i == 0:
            value.legend(loc="best")
        elif several:
            for number in range(len(arm.sections)):
                off.plot([], [], **section_look(number), label=f"section {number + 1}")
            off.legend(loc="best")


def _angles(samples: Trajectory) -> list[list[Array]]:
    """Return commanded and measured, each bend and plane angles [deg], each of shape (T, S); planes without jumps."""
    arm, out = samples.arm, []
    measured, _ = routing.bend_from_lengths(samples.muscle_lengths, arm)
    first, clear = None, None
    for bends in (samples.bend, measured):
        angle, plane = arc.to_polar(bends.reshape(len(samples.time), -1, 2))
        clear = angle > _CLEAR if clear is None else clear
        plane = np.where(clear, plane, np.nan)
        if first is None:
            first = plane = np.stack([_unwrapped(own) for own in plane.T], axis=1)
        else:
            plane = first + np.angle(np.exp(1j * (plane - first)))
        out.append([np.degrees(angle), np.degrees(plane)])
    return out


def lengths(sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
    """Draw length changes of muscles 2 and 3 along a path, the arc's (paper) and simulated, and what they differ by.

    Beside it what the chain of links has otherwise than the arc: next to nothing, unless muscles run in spans.
    """
    samples = followed(arm, own)
    sheet.heading(f"Lengths of muscles 2 and 3 along {called(own)}, of arcs and simulated ({stance(arm)})")
    analytic = routing.arc_deltas(samples.bend, arm)
    simulated = samples.muscle_lengths - arm.length
    chained = routing.lengths_from_bend(samples.bend, arm) - arm.length
    for i, (value, off) in zip((1, 2), _panels(sheet), strict=True):
        value.plot(samples.time, MM * simulated[:, i], **BROAD)
        value.plot(samples.time, MM * analytic[:, i], **THIN | {"label": "arc (paper)"})
        value.set_ylabel(f"muscle {i + 1}:\nlength change [mm]")
        look: dict[str, Any] = {"color": DISCRETISATION, "linestyle": (0, (4, 1.5)), "label": "chain of links"}
        off.plot(samples.time, MM * (simulated - analytic)[:, i], color=ERROR, label="simulated")
        off.plot(samples.time, MM * (chained - analytic)[:, i], **look)
        off.set_ylabel("difference from\nthe arc's [mm]")
        if i == 1:
            value.legend(loc="upper left")
            off.legend(loc="upper left")


def _panels(sheet: Sheet) -> list[tuple[Any, Any]]:
    """Return two pairs of panels, a value over what it is off: beside each other on a page."""
    if sheet.wide:
        sheet.tall(88)
        panels = sheet.subplots(2, 2, sharex=True, height_ratios=[1.5, 1], squeeze=False)
        pairs = [(panels[0, i], panels[1, i]) for i in range(2)]
    else:
        sheet.tall(150)
        column = sheet.subplots(4, 1, sharex=True, height_ratios=[1.5, 1, 1.5, 1])
        pairs = [(column[0], column[1]), (column[2], column[3])]
    for _, off in pairs[0 if sheet.wide else 1 :]:
        off.set_xlabel("time [s]")
    sheet.align_ylabels()
    return pairs


def _unwrapped(angle: Array) -> Array:
    """Return angles [rad] without jumps of a turn, NaN left alone."""
    out, good = angle.copy(), np.isfinite(angle)
    out[good] = np.unwrap(angle[good])
    return out
