"""Arms, motions and results as HTML. Kinds go by their names, so that none is loaded to show another."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from html import escape
from typing import Any

import numpy as np

from contarm_sim.brevity import brief
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import shape
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import SIMULATED
from contarm_sim.view.notebook import studies
from contarm_sim.view.notebook.page import card, grid, pairs
from contarm_sim.view.notebook.sketch import Line, Things, curve, side_view, tip_line

POSES = 5
"""Poses of a motion that are drawn."""

LISTED = 6
"""Answers that are listed, at most."""

_PARTS = ("target_error", "tip_error", "discretisation", "servo", "shape")


def html(result: Any) -> str:
    """Return what a notebook shows of a result: a table and, of some, a picture; below 30 kB."""
    for kind in type(result).__mro__:
        if kind.__name__ in _CARDS:
            return _CARDS[kind.__name__](result)
    return _any(result)


def _any(result: Any) -> str:
    found = [(item.name, getattr(result, item.name)) for item in fields(result)]
    rows = [(name, "-" if isinstance(value, float) and math.isnan(value) else brief(value)) for name, value in found]
    return card(type(result).__name__, pairs(rows))


def _arm(arm: Arm) -> str:
    count = len(arm.sections)
    rows = [("length", f"{1e3 * arm.length:g} mm"), ("mass", f"{arm.mass:g} kg"), ("links", f"{arm.links}")]
    each = [_section(arm, number) for number in range(count)]
    if count == 1:
        rows += list(zip(_SECTION[3:], each[0][3:], strict=True))
    rows += [("gravity", "none" if not any(arm.gravity) else f"{brief(arm.gravity)} m/s², base frame")]
    rows += [("payload", f"{arm.payload:g} kg")] if arm.payload else []
    rows += [("objects", ", ".join(each.name for each in arm.world.objects))] if arm.world.objects else []
    down = np.arctan2(arm.gravity[1], arm.gravity[0])  # of a level arm, where it would sag to
    bends = np.tile(arc.from_polar(np.radians(90 / count), down), count)
    places = shape.stations(arm)
    straight, bent = (shape.position(pose, arm, places) for pose in (0 * bends, bends))
    lines = [Line(straight, opacity=0.4, width=2.0, dashes="5 5"), Line(bent, width=4.0), *_ends(bent, arm)]
    picture = side_view(lines, "The arm straight and bent by 90 degrees, from the side", arm.world, things=_things(arm))
    below = grid(["section", *_SECTION], [[str(i + 1), *own] for i, own in enumerate(each)]) if count > 1 else ""
    title = "Arm of one section" if count == 1 else f"Arm of {count} sections"
    return card(title, pairs(rows), picture, below)


_SECTION = ("length", "mass", "links", "bending stiffness", "muscles")


def _section(arm: Arm, number: int) -> list[str]:
    section, routing, law = arm.sections[number], arm.routings[number], arm.laws[number]
    pulls = f"{routing.count} {type(law).__name__} at {1e3 * routing.radius:g} mm" if routing.count else "none"
    stiffness = f"{section.bending_stiffness:g} N m²"
    return [f"{1e3 * section.length:g} mm", f"{section.mass:g} kg", f"{section.links}", stiffness, pulls]


def _trajectory(samples: Any) -> str:
    if not len(samples):
        return card("Trajectory without samples", pairs([("arm", _in_words(samples.arm))]))
    arm, error, tensions = samples.arm, samples.tip_error, samples.muscle_tensions
    what = f"{samples.time[-1]:g} s, {len(samples)} samples" if samples.moving else f"{len(samples)} poses"
    rows = [("arm", _in_words(arm)), ("controller", samples.controller), ("motion" if samples.moving else "rest", what)]
    rows += [("tip error", f"{_size(error)} at most ({100 * error.max() / arm.length:.3g} % of length)")]
    missed = np.linalg.norm(samples.tip - samples.target, axis=1)
    rows += [("off the target", f"{_size(missed)} at most")]
    if tensions.size:
        rows += [("tensions", f"{tensions.min():.3g} to {tensions.max():.3g} N")]
    needed = samples.pressure
    if needed.size and needed.max() > 0:
        most = f"{needed.max() / 1e3:.3g} kPa" if np.isfinite(needed).all() else "more than any gives"
        rows += [("highest pressure", most)]
    if samples.contacts is not None:
        rows += [("touched", _touched(samples))]
    picked = np.unique(np.linspace(0, len(samples) - 1, POSES).astype(int))
    lines = [Line(samples.stations[i], opacity=0.3, width=2.5) for i in picked[:-1]]
    if samples.moving:
        lines += [Line(samples.target, width=1.2, opacity=0.7, dashes="4 3"), tip_line(samples.tip)]
    lines += [Line(samples.stations[-1], width=4.0), *_ends(samples.stations[-1], arm)]
    things = _things(arm, None if samples.objects is None else samples.objects[-1])
    seen = "The arm at some moments, the tip's path and its targets, from the side"
    title = f"Trajectory, {samples.status}"
    legend = f'<br><small><span style="color:{SIMULATED}">━</span> tip &nbsp; ┅ its targets</small>'
    return card(
        title, pairs(rows), side_view(lines, seen, arm.world, things=things) + (legend if samples.moving else "")
    )


def _things(arm: Arm, poses: Any = None) -> Things:
    """Return what is drawn of the objects of an arm's world: those that have an end."""
    if not arm.world.objects:  # the engine is not loaded for none
        return []
    from contarm_sim.view.outlines import placed_objects

    return [(each.colour, points) for each, points, _ in placed_objects(arm, poses) if each.shape != "plane"]


def _touched(samples: Any) -> str:
    """Return what an arm touched, how hard and how deep."""
    found = samples.contacts
    if not len(found):
        return "nothing"
    what = ", ".join(found.touched)
    return f"{what}: up to {found.total(len(samples)).max():.3g} N, {1e3 * found.depth.max():.2g} mm deep"


def _reference(reference: Any) -> str:
    what = f"{reference.time[-1]:g} s at {reference.rate:g} Hz" if reference.moving else "poses at rest"
    largest = np.degrees(np.linalg.norm(reference.bends, axis=-1).max())
    rows = [("samples", f"{len(reference)}, {what}"), ("largest bend", f"{largest:.3g}°")]
    rows += [("for an arm of", " + ".join(f"{1e3 * x:g}" for x in reference.lengths) + " mm")]
    rows += [("direction of the tip", "asked for")] if reference.direction is not None else []
    axis = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, sum(reference.lengths)]])
    lines = [Line(axis, opacity=0.4, width=2.0, dashes="5 5"), Line(reference.target, width=1.8)]
    picture = side_view(lines, "The targets and the straight arm, from the side", width=180, height=160)
    return card("Reference", pairs(rows), picture)


def _comparison(found: Any) -> str:
    rows = []
    for name in _PARTS:
        sizes = 1e3 * getattr(found, name)
        rows.append([f"{name.replace('_', ' ')} [mm]", f"{sizes.max():.3f}", f"{np.sqrt(np.mean(sizes**2)):.3f}"])
    degrees = np.degrees(found.orientation_error)
    rows.append(["orientation error [°]", f"{degrees.max():.3f}", f"{np.sqrt(np.mean(degrees**2)):.3f}"])
    columns = ["", "largest", "root mean square"]
    title = f"Comparison of {len(found.tip_error)} samples with the closed forms"
    said = "tip error, sample by sample"
    return card(title, grid(columns, rows), f"{curve(found.tip_error, said)}<br><small>{said}</small>")


def _inverse(found: Any) -> str:
    bends = found.bends.reshape(-1, *found.bends.shape[-2:])
    rows = []
    for i, own in enumerate(bends[:LISTED]):
        said = ", ".join(f"{a:.1f}° ({p:.0f}°)" for a, p in (np.degrees(arc.to_polar(each)) for each in own))
        number, miss = int(found.solutions.reshape(-1)[i]), 1e3 * found.miss.reshape(-1)[i]
        known = "a continuum" if number < 0 else str(number)
        rows.append([said, f"{round(miss, 6):.3g}", f"{np.degrees(found.angle_miss.reshape(-1)[i]):.3g}", known])
    left = len(bends) - len(rows)
    columns = ["bends (planes)", "miss [mm]", "angle off [°]", "solutions"]
    reached = f"{int(found.reachable.sum())} of {len(bends)} targets reached"
    below = grid(columns, rows) + (f"<small>and {left} more</small>" if left else "")
    return card(f"Inverse kinematics: {reached}", below)


def _equilibrium(found: Any) -> str:
    tip = ", ".join(f"{1e3 * x:.1f}" for x in found.tip)
    rows = [("stable", "yes" if found.stable else "no"), ("tip", f"({tip}) mm")]
    if len(found.muscle_tensions):
        rows += [("tensions", ", ".join(f"{x:.1f}" for x in found.muscle_tensions) + " N")]
    rows += [("softest mode", f"{found.smallest_eigenvalue:.3g} N m/rad"), ("residual", f"{found.residual:.2g} N m")]
    for one in found.contacts:
        rows.append((f"leans on {one.object}", f"{one.force:.3g} N at {100 * one.xi:.0f} % of its length"))
    points = found.frames[:, :3, 3]
    return card(
        "Equilibrium", pairs(rows), side_view([Line(points, width=4.0)], "The arm at rest", width=180, height=160)
    )


def _fit(found: Any) -> str:
    from contarm_sim.view.notebook.fits import html as made  # with what draws figures

    return made(found)


def _replay(found: Any) -> str:
    from contarm_sim.view.report.replays import words

    table = grid(["", *words.COLUMNS], words.marker_rows(found))
    said = "".join(f"<br><small>{escape(f'{one.title} {one.text}')}</small>" for one in words.standings(found))
    return card(words.headline(found), table, "", said.replace("`", ""))


def _ends(stations: Any, arm: Arm) -> list[Line]:
    """Return the places [m] at which a section ends and another begins."""
    ends = np.cumsum([section.links for section in arm.sections])[:-1]
    return [Line(stations[end : end + 1]) for end in ends]


def _in_words(arm: Arm) -> str:
    sections = f", {len(arm.sections)} sections" if len(arm.sections) > 1 else ""
    pull = ", gravity" if any(arm.gravity) else ""
    load = f", payload {arm.payload:g} kg" if arm.payload else ""
    return f"{1e3 * arm.length:g} mm{sections}, {arm.links} links{pull}{load}"


def _size(distances: Any) -> str:
    return f"{1e3 * distances.max():.3g} mm"


_CARDS: dict[str, Callable[[Any], str]] = {
    "Arm": _arm, "Trajectory": _trajectory, "Reference": _reference, "Comparison": _comparison, "Inverse": _inverse,
    "Equilibrium": _equilibrium, "Fit": _fit, "Replay": _replay, **studies.CARDS,
}  # fmt: skip
