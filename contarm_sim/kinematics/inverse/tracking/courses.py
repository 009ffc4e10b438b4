"""Paths of targets between way points: made finer, followed along a guide, smoothed, and looked through for jumps."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.general.least_squares import descend
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import clamped
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH, Index
from contarm_sim.kinematics.inverse.rotations import between_directions, between_rotations, turned

_ROUNDING = 0.02  # steps of bends shorter than this are no jumps [rad]
_ABOVE = 6.0  # times the mean of their surroundings: steps longer than this are looked at
_WINDOWS = (5, 10, 20)  # steps to either side over which a course is mended
_SPOTS, _MISSED = 20, 4  # so many spots are mended; where more targets of a window are missed, they are out of reach
_PARTS, _SHARE = 16, 0.35  # a jump is a step with one of so many parts that is more than this share of it


def finer(goals: Goals, times: int) -> Goals:
    """Return goals with `times` - 1 more between each and the next, on straight lines and shortest turns."""
    if times == 1:
        return goals
    count = (len(goals) - 1) * times + 1
    left = np.minimum(np.arange(count) // times, len(goals) - 2)
    share = (np.arange(count) - left * times) / times
    return between(goals.take(left), goals.take(left + 1), share)


def between(first: Goals, last: Goals, share: Array) -> Goals:
    """Return goals at shares of the way from some to others."""
    t = share[:, None]
    position = (1 - t) * first.position + t * last.position
    direction = rotation = None
    if first.direction is not None and last.direction is not None:
        turn = turned(t * between_directions(first.direction, last.direction))
        direction = (turn @ first.direction[..., None])[..., 0]
    if first.rotation is not None and last.rotation is not None:
        rotation = turned(t * between_rotations(first.rotation, last.rotation)) @ first.rotation
    return Goals(position, direction, rotation)


def strides(goals: Goals, length: float) -> Array:
    """Return the distances from each goal to the next, free of units, shape (T - 1,)."""
    distance = np.sqrt((np.diff(goals.position, axis=0) ** 2).sum(axis=-1)) / length
    turns = []
    if goals.direction is not None:
        turns.append(between_directions(goals.direction[:-1], goals.direction[1:]))
    if goals.rotation is not None:
        turns.append(between_rotations(goals.rotation[:-1], goals.rotation[1:]))
    for turn in turns:
        distance += ANGLE_LENGTH * np.sqrt((turn**2).sum(axis=-1))
    return distance


def follow(goals: Goals, backbone: Backbone, guide: Array) -> Array:
    """Return the solutions nearest to a guide, shape (T, S, 2), inside the limits."""
    return clamped(descend(goals, backbone, guide, steps=25, near=True), backbone)


def mended(goals: Goals, backbone: Backbone, course: Array) -> Array:
    """Return a course without the short hops to the twin of a branch, and the misses, that folds lead to.

    Where the Jacobian is singular two branches meet, and the nearest solution to a guide may lie on the wrong one. The
    smooth curve between the courses on both sides is a better guide.
    """
    for width in _WINDOWS:
        missed = ~goals.solved(course, backbone)
        spots = np.unique(np.concatenate([jumps(goals, backbone, course), np.flatnonzero(missed)]))
        for spot in spots[:_SPOTS].tolist():
            first, last = max(spot - width, 0), min(spot + width, len(course) - 1)
            if last - first < 2 or missed[first : last + 1].sum() > _MISSED:
                continue
            own, before = goals.take(slice(first, last + 1)), course[first : last + 1]
            guide = _bridge(course, first, last)
            after = clamped(descend(own, backbone, guide, near=True), backbone)
            after[0], after[-1] = before[0], before[-1]
            if _faults(own, backbone, after) < _faults(own, backbone, before):
                course[first : last + 1] = after
    return course


def _faults(goals: Goals, backbone: Backbone, course: Array) -> int:
    return len(jumps(goals, backbone, course)) + int((~goals.solved(course, backbone)).sum())


def _bridge(course: Array, first: int, last: int) -> Array:
    """Return the cubic curve between two places of a course that leaves and enters it at its own slopes."""
    span, top = last - first, len(course) - 1
    out = (course[first] - course[first - 2]) / 2 * span if first >= 2 else course[last] - course[first]
    into = (course[last + 2] - course[last]) / 2 * span if last + 2 <= top else course[last] - course[first]
    t = np.linspace(0, 1, span + 1)[:, None, None]
    return np.asarray(
        (1 + 2 * t) * (1 - t) ** 2 * course[first]
        + t * (1 - t) ** 2 * out
        + t * t * (3 - 2 * t) * course[last]
        + t * t * (t - 1) * into
    )


def smoothed(goals: Goals, backbone: Backbone, course: Array, width: float) -> Array:
    """Return a course without jumps with less to and fro, its ends where they were; as it was, if that fails."""
    if len(course) < 5 or width < 1:
        return course
    reach = int(min(3 * width, len(course) - 1))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    kernel /= kernel.sum()
    # Mirrored through its ends, a course keeps them.
    flat = course.reshape(len(course), -1)
    wide = np.concatenate([2 * flat[:1] - flat[reach:0:-1], flat, 2 * flat[-1:] - flat[-2 : -reach - 2 : -1]])
    guide = np.stack([np.convolve(column, kernel, "valid") for column in wide.T], axis=-1).reshape(course.shape)
    new = follow(goals, backbone, guide)
    new[0], new[-1] = course[0], course[-1]
    as_good = goals.solved(new, backbone) | ~goals.solved(course, backbone)
    steps, old = _steps(new), _steps(course)
    return new if as_good.all() and steps.max() <= max(old.max(), _ROUNDING) else course


def jumps(goals: Goals, backbone: Backbone, course: Array) -> Index:
    """Return the places of a course that its bends do not come to continuously from the place before."""
    steps = _steps(course)
    window = min(33, len(steps))
    mean = np.convolve(steps, np.full(window, 1 / window), "same") if window > 1 else steps
    places: Index = np.flatnonzero(steps > np.maximum(_ROUNDING, _ABOVE * (mean - steps / window)))
    if not len(places):
        return places
    share = np.tile(np.arange(1, _PARTS) / _PARTS, len(places))
    row = np.repeat(places, _PARTS - 1)
    fine = between(goals.take(row), goals.take(row + 1), share)
    guide = (1 - share)[:, None, None] * course[row] + share[:, None, None] * course[row + 1]
    inner = follow(fine, backbone, guide).reshape(len(places), _PARTS - 1, -1)
    ends = course.reshape(len(course), -1)
    parts = np.diff(np.concatenate([ends[places, None], inner, ends[places + 1, None]], axis=1), axis=1)
    longest = np.sqrt((parts**2).sum(axis=-1)).max(axis=-1)
    return np.asarray(places[longest > _SHARE * steps[places]] + 1)


def _steps(course: Array) -> Array:
    return np.sqrt((np.diff(course, axis=0) ** 2).sum(axis=(-1, -2)))
