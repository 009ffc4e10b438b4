"""Inverse kinematics of a path: bends that follow its targets continuously through the redundancy.

A greedy course, from each target to the next, ends where its branch folds back or meets a limit. So the way is chosen
on a map of solutions along the whole path (`roadmap`), then followed in small steps, looked through for jumps, and
smoothed (`courses`). Where one is found, that step is barred and the way chosen anew.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone, as_bends, check_backbone
from contarm_sim.kinematics.inverse.checks import as_goals, check_choice
from contarm_sim.kinematics.inverse.choices import Choice
from contarm_sim.kinematics.inverse.general.free import turning
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.general.out_of_reach import approached
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.result import Index, Inverse
from contarm_sim.kinematics.inverse.targets import solve
from contarm_sim.kinematics.inverse.tracking import courses, roadmap

SPACING = 0.1
"""Distance between way points at most, as a fraction of the backbone's length; angles count as in a miss."""

_FINE = 10  # steps from a way point to the next, at least
_SAMPLES = {0: 24, 1: 32}  # samples at a way point, by the number of free parameters
_MANY = 32
_WIDTHS = ((), (1.0, 1.0, 0.5), (4.0, 4.0, 2.0, 1.0, 0.5))  # of smoothing, in way points, by free parameters
_ROUNDS, _STUCK = 12, 3  # most ways that are tried, and how many of them without fewer jumps
_MOST_PLACES = 400
_TURNS = 15  # most steps nearer to directions
_TURN = 300.0  # cost of missing a direction by 1 rad along the whole path, beside the square of its motion [rad^2]


@dataclass(frozen=True, repr=False)
class Track(Inverse):
    """One answer for each target of a path.

    Attributes:
        jumps: targets that bends do not come to continuously from the target before, in order; empty for none.
    """

    jumps: Index


def track(
    positions: Any,
    backbone: Backbone,
    directions: Any = None,
    rotations: Any = None,
    start: Any = None,
    choose: Choice = "nearest",
) -> Track:
    """Return bends that follow targets in order, without a jump where a continuous course is found.

    Between targets, tips go straight. Where no course goes through, the fewest jumps are made, and `Track.jumps` names
    the targets that they end at. Two sections reach positions; directions are followed as near as they let it.

    Args:
        positions: of the tips in the base frame [m], shape (T, 3).
        directions, rotations: as of `solve`, shape (T, 3) or (T, 3, 3), or one for all.
        start: bends [rad], shape (S, 2), that the course starts from: at the solution that they lead to. Default: free.
        choose: what the course makes small beside its motion, see `solve`; `nearest` is the motion alone.

    Raises:
        InputError: no backbone, targets that are none, or not in one row; an unknown choice.
    """
    check_backbone(backbone)
    check_choice(choose)
    goals, shape = as_goals(positions, directions, rotations, backbone.length)
    if len(shape) != 1:
        raise InputError("positions", f"of shape {(*shape, 3)}", "targets in a row, shape (T, 3)")
    first = None if start is None else as_bends(start, backbone, "start")
    if first is not None and first.ndim != 2:
        raise InputError("start", f"of shape {first.shape}", f"shape ({len(backbone)}, 2)")
    if len(backbone) == 1 or len(goals) < 2:
        return _apart(goals, backbone, first)
    hard = Goals(goals.position) if goals.conditions > 2 * len(backbone) else goals
    course, jumps = _course(hard, backbone, first, choose, goals)
    course, jumps = _closest(hard, backbone, course, jumps)
    if hard is not goals:
        course = _turned(goals, backbone, course)
    one = goals.answered(course, backbone, -1 if 2 * len(backbone) > goals.conditions else 1)
    return _with_jumps(one, jumps)


def _with_jumps(one: Inverse, jumps: Index) -> Track:
    return Track(one.bends, one.miss, one.angle_miss, one.reachable, one.solutions, jumps)


def _apart(goals: Goals, backbone: Backbone, start: Array | None) -> Track:
    choose: Choice = "least-bend" if start is None else "nearest"
    one = solve(goals.position, backbone, goals.direction, goals.rotation, choose, start)
    return _with_jumps(one, np.zeros(0, dtype=np.intp))


def _course(goals: Goals, backbone: Backbone, start: Array | None, choose: Choice, asked: Goals) -> tuple[Array, Index]:
    """Return bends for each goal, shape (T, S, 2), and the goals that they jump to; `asked` may say turns besides."""
    along = np.concatenate([[0.0], np.cumsum(courses.strides(goals, backbone.length))])
    count = int(np.clip(np.ceil(along[-1] / SPACING), 1, _MOST_PLACES))
    times = int(np.ceil(_FINE * count / (len(goals) - 1)))
    fine = courses.finer(goals, times)
    along = np.interp(np.arange(len(fine)) / times, np.arange(len(goals)), along)
    places = np.unique(np.searchsorted(along, np.linspace(0, along[-1], count + 1)).clip(0, len(fine) - 1))
    places[0], places[-1] = 0, len(fine) - 1
    free = 2 * len(backbone) - goals.conditions
    chain = roadmap.layers(fine, backbone, places, choose, start, _SAMPLES.get(free, _MANY))
    if asked is not goals:
        turns = courses.finer(asked, times)
        for layer in chain:
            own = turns.take(np.full(len(layer.bends), layer.place))
            layer.cost = layer.cost + _TURN * own.misses(layer.bends, backbone)[1]
    if start is not None:
        _begin(chain[0], fine.take([0]), backbone, start)
    course, jumps = _follow(fine, backbone, chain)
    width = len(fine) / len(places)
    bounds = [0, *jumps.tolist(), len(fine)]
    for a, b in pairwise(bounds):
        own = fine.take(slice(a, b))
        for share in _WIDTHS[min(max(free, 0), 2)]:
            course[a:b] = courses.smoothed(own, backbone, course[a:b], share * width)
    at = np.unique(np.ceil(jumps / times).astype(np.intp))
    return _polished(goals, backbone, course[::times]), at


def _polished(goals: Goals, backbone: Backbone, course: Array) -> Array:
    closer = descend(goals, backbone, course, limited=0.0, steps=8, near=True)
    better = goals.solved(closer, backbone) & (np.abs(closer - course).max(axis=(-1, -2)) < 1e-6)
    return np.where(better[:, None, None], closer, course)


def _closest(goals: Goals, backbone: Backbone, course: Array, jumps: Index) -> tuple[Array, Index]:
    """Return a course with the nearest poses known next to it where it misses its goals, and its jumps.

    A goal that is reached by none of these, but by others, is reached by a jump.
    """
    rows = np.flatnonzero(~goals.solved(course, backbone))
    if not len(rows):
        return course, jumps
    these, course = goals.take(rows), course.copy()
    near = approached(these, backbone, course[rows])
    found = solve(these.position, backbone, these.direction, these.rotation, near=near).bends
    aside = np.sqrt(((found - near) ** 2).sum(axis=(-1, -2)))
    closer = (these.off(found, backbone) < these.off(near, backbone)) & (aside < roadmap.FARTHEST_STEP)
    closer |= these.solved(found, backbone) & ~these.solved(near, backbone)
    course[rows] = np.where(closer[:, None, None], found, near)
    beside = np.unique(np.concatenate([rows, rows + 1]))
    beside = beside[(beside > 0) & (beside < len(course))]
    far = np.sqrt(((course[beside] - course[beside - 1]) ** 2).sum(axis=(-1, -2))) >= roadmap.FARTHEST_STEP
    return course, np.unique(np.concatenate([jumps, beside[far]]))


def _turned(goals: Goals, backbone: Backbone, course: Array) -> Array:
    """Return a course with the same tips, turned nearer to what is asked for as far as that makes no jumps."""
    position = Goals(goals.position)
    for _ in range(_TURNS):
        new = courses.follow(position, backbone, course + turning(goals, backbone, course))
        before, after = (goals.misses(bends, backbone)[1] for bends in (course, new))
        new = np.where((after < before)[:, None, None], new, course)
        if len(courses.jumps(position, backbone, new)) or not position.solved(new, backbone).all():
            break
        gain = float((before - np.minimum(before, after)).mean())
        course = new
        if gain < 1e-9:
            break
    return course


def _begin(layer: roadmap.Layer, goal: Goals, backbone: Backbone, start: Array) -> None:
    """Let the course begin at the solution that a start leads to, if it leads to one."""
    found = descend(goal, backbone, start[None])
    if goal.solved(found, backbone)[0]:
        layer.bends, layer.cost = found, np.zeros(1)


def _follow(goals: Goals, backbone: Backbone, chain: list[roadmap.Layer]) -> tuple[Array, Index]:
    """Follow the shortest way; bar steps that turn out to be jumps, and try again."""
    places = np.array([layer.place for layer in chain])
    fewest: tuple[Array, Index] | None = None
    since = 0
    for _ in range(_ROUNDS):
        way = roadmap.shortest(chain)
        nodes = np.array([layer.bends[k] for layer, k in zip(chain, way, strict=True)])
        guide = _between(places, nodes, len(goals))
        course = courses.follow(goals, backbone, guide)
        course[places] = nodes
        course = courses.mended(goals, backbone, course)
        jumps = courses.jumps(goals, backbone, course)
        since += 1
        if fewest is None or len(jumps) < len(fewest[1]):
            fewest, since = (course, jumps), 0
        before = sum(len(layer.barred) for layer in chain)
        for i in np.unique(np.searchsorted(places, jumps) - 1).tolist():
            chain[i].bar(way[i], nodes[i + 1])
        if not len(jumps) or since >= _STUCK or sum(len(layer.barred) for layer in chain) == before:
            break
    assert fewest is not None
    return fewest


def _between(places: Array, nodes: Array, count: int) -> Array:
    flat = nodes.reshape(len(nodes), -1)
    columns = [np.interp(np.arange(count), places, column) for column in flat.T]
    return np.stack(columns, axis=-1).reshape(count, *nodes.shape[1:])
