"""Whether a recording can be that of an arm, and what is odd about it: drop-outs, outliers, constant commands."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.identify.recordings.measured import frozen_runs
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

FEWEST = 3
"""Samples that a marker must be seen in."""

FROZEN = 5
"""Samples at the very same place, one after the other, that count as a drop-out."""

_JUMP = 8.0
"""How often what is usual a marker must be out of line to count as an outlier."""

_PART = 0.02
"""Part of the marker's spread that it must be out of line by as well."""

_HOLE = 5.0
"""How often what is usual the time between two samples of a block must be to count as a gap."""

_LIMP = 0.02
"""Tensions that are all below this move no arm [N]."""

_TINY = 0.005
"""Of what a marker or tendon can move by: below this all is too small to be in metres."""


def check_enough(recording: Recording) -> None:
    """Refuse a recording that nothing can be learned from.

    Raises:
        InputError: a marker that is seen in fewer than three samples, or poses at rest under commands, payloads and
            forces that never change.
    """
    for marker, count in zip(recording.rig.markers, recording.seen.sum(axis=0).tolist(), strict=True):
        if count < min(FEWEST, len(recording)):
            given = f"seen in {count} of {len(recording)} samples"
            raise InputError(f"marker {marker.name}", given, f"{FEWEST} or more", recording.name)
    said = [x for x in (recording.commands, recording.payload, recording.force) if x is not None and x.size]
    if recording.kind == "static" and len(recording) > 1 and said and all((x == x[0]).all() for x in said):
        allowed = "commands, payloads or forces that differ between samples"
        raise InputError("commands", "the same in all samples", allowed, recording.name)


def check_against(recording: Recording, arm: Arm) -> None:
    """Refuse a recording that cannot be this arm's: too few channels, or numbers in another unit, it seems.

    Raises:
        InputError: says which unit explains it, where one does.
    """
    actuation, muscles = recording.rig.actuation, sum(group.routing.count for group in arm.groups)
    if actuation.drive != "none" and len(actuation.channels) != muscles:
        given = f"of {len(actuation.channels)} muscles"
        allowed = f"channels of {muscles}, as the arm has muscles, section by section; one channel may drive several"
        raise InputError("commands.channels", given, allowed, recording.name)
    for number in range(len(recording.rig.markers)):
        _check_marker(recording, arm, number)
    if actuation.drive != "none" and len(recording):
        _check_commands(recording, arm)


def _check_marker(recording: Recording, arm: Arm, number: int) -> None:
    marker = recording.rig.markers[number]
    seen = recording.positions[recording.seen[:, number], number]
    if not len(seen):
        return
    reach = max(marker.xi * arm.length + math.hypot(*marker.offset), 0.1 * arm.length)
    far = float(np.median(np.linalg.norm(seen - np.array(recording.rig.position), axis=1)))
    apart = _spread(seen)
    same = np.ptp(seen, axis=1) <= 1e-9 * np.abs(seen).max(axis=1)  # x, y and z alike
    missing = seen[same & (np.abs(seen).max(axis=1) > 10 * reach)]
    if len(missing):
        given = f"{len(missing)} times at {missing[0, 0]:.6g} m in x, y and z"
        allowed = f"positions within its reach, {reach:.3g} m; if this says missing: gaps.values = [-9999] or so"
        raise InputError(f"marker {marker.name}", given, allowed, recording.name)
    name, of = f"marker {marker.name}", f"the base of an arm of {arm.length:.3g} m"
    if far > 30 * reach or apart > 2.2 * reach:
        unit = _unit({"mm": 1e-3, "cm": 1e-2}, max(far, apart), reach)
        asked = f"; they seem to be {unit[1]}: unit = {unit[0]!r}" if unit else "; are units and frame right?"
        given = f"{far:.3g} m from {of}"
        if far <= 30 * reach:
            given = f"{apart:.3g} m from its median place, on an arm of {arm.length:.3g} m"
        raise InputError(name, given, f"positions within its reach, {reach:.3g} m{asked.replace(chr(39), chr(34))}",
                         recording.name)  # fmt: skip
    if far + apart < _TINY * reach and marker.xi > 0.1 and len(seen) >= FEWEST:
        given = f"at most {far + apart:.2g} m from {of}"
        allowed = f'positions of the size of its reach, {reach:.3g} m; they seem to be metres, not mm: unit = "m"'
        raise InputError(name, given, allowed, recording.name)


def _unit(sizes: dict[str, float], found: float, reach: float) -> tuple[str, str] | None:
    """Return the unit, and its name, that brings a distance nearest to the reach, if any does."""
    words = {"mm": "millimetres", "cm": "centimetres"}
    near = [(abs(math.log(found * size / reach)), unit) for unit, size in sizes.items()]
    off, unit = min(near)
    return (unit, words[unit]) if off < math.log(4) else None


def _check_commands(recording: Recording, arm: Arm) -> None:
    actuation = recording.rig.actuation
    told = np.abs(actuation.values(recording.commands) - actuation.values(np.zeros(recording.commands.shape[1])))
    most = float(told.max(initial=0.0))
    used = np.array(recording.commands)[:, sorted(set(actuation.channels))]
    angles = any(gain != 1 for gain in actuation.gains)
    if most == 0 or not used.size:
        return
    if actuation.drive == "windings":
        _check_windings(recording, most, max(group.length for group in arm.groups), angles)
    if actuation.drive == "tensions" and most > 1e5:
        raise InputError("commands", f"tensions up to {most:.3g} N", 'at most 1e5 N; mN? unit = "mN"', recording.name)
    if actuation.drive == "tensions":
        pulls = used * np.array(actuation.gains)[sorted(set(actuation.channels))]
        lets = min(actuation.signs) > 0 and pulls.min() < -0.05 * np.abs(pulls).max()
        if lets or most < _LIMP:
            given = f"tensions from {pulls.min():.3g} to {pulls.max():.3g} N"
            allowed = 'pulls above 0, not windings in m; kN? unit = "kN"; pulls written below 0? pull = "negative"'
            raise InputError("commands", given, allowed, recording.name)
    if actuation.drive == "pressures" and most < 1e3:
        allowed = 'pressures in Pa, 1000 or more; they seem to be kPa or bar: unit = "kPa"'
        raise InputError("commands", f"pressures up to {most:.3g} Pa", allowed, recording.name)
    if actuation.drive == "pressures" and most > 1e8:
        raise InputError("commands", f"pressures up to {most:.3g} Pa", "at most 1e8 Pa", recording.name)


def _check_windings(recording: Recording, most: float, length: float, angles: bool) -> None:
    given = f"windings up to {most:.3g} m, of tendons of {length:.3g} m"
    if most > length:
        asked = 'degrees? unit = "deg"' if angles else 'they seem to be millimetres: unit = "mm"'
        raise InputError("commands", given, f"windings below a tendon's length; {asked}", recording.name)
    if most < 2e-4 * length:
        asked = "radians or radii in metres, not deg or mm" if angles else 'metres, not mm: unit = "m"'
        allowed = f"windings above {2e-4 * length:.2g} m; they seem to be {asked}"
        raise InputError("commands", given, allowed, recording.name)


def frozen(recording: Recording, least: int = FROZEN) -> NDArray[np.bool_]:
    """Return where markers are at the very same place for long, as trackers write drop-outs, shape (T, K)."""
    return np.asarray(frozen_runs(recording.positions, recording.blocks, least))


def outliers(recording: Recording) -> NDArray[np.bool_]:
    """Return which positions are out of line with the two before and the two after them, shape (T, K).

    Out of line is what is off the smooth curve through these four by eight times what is usual for the marker and 2 %
    of its spread, more than its neighbours are, where the command is not.
    """
    out = np.zeros_like(recording.seen)
    runs = [np.flatnonzero(recording.blocks == block) for block in dict.fromkeys(recording.blocks.tolist())]
    along = recording.time if recording.kind == "motion" else np.arange(len(recording), dtype=float)
    told = np.zeros(len(recording))
    for rows in runs:
        told[rows] = _off_line(recording.commands[rows], along[rows])
    turns = told > _JUMP * np.median(told)
    for k in range(len(recording.rig.markers)):
        off = np.zeros(len(recording))
        for rows in runs:
            own = rows[recording.seen[rows, k]]
            off[own] = _off_line(recording.positions[own, k], along[own])
        usual = float(np.median(off[recording.seen[:, k]]))
        padded = np.concatenate([[0, 0], off, [0, 0]])
        near = np.max([padded[shift : shift + len(off)] for shift in (0, 1, 3, 4)], axis=0)
        least = max(_JUMP * usual, _PART * _spread(recording.positions[recording.seen[:, k], k]))
        out[:, k] = (off > least) & (off > near) & ~turns
    return out


def _spread(points: Array) -> float:
    """Return the distance from the median place that nine of ten points are within [m]."""
    return float(np.percentile(np.linalg.norm(points - np.median(points, axis=0), axis=1), 90))


def _off_line(points: Array, along: Array) -> Array:
    """Return how far points are from the cubic through the two before and the two after, shape (T,); 0 at the ends.

    Args:
        along: where each is, shape (T,): its time, or its number. Where the four are far apart, nothing is said: 0.
    """
    off = np.zeros(len(points))
    if len(points) < 5 or not points.shape[1]:
        return off
    near = [slice(0, -4), slice(1, -3), slice(3, -1), slice(4, None)]
    here, there = along[2:-2], [along[part] for part in near]
    line = np.zeros_like(points[2:-2])
    for one, own in zip(near, there, strict=True):
        others = [other for other in there if other is not own]
        weight = np.prod([(here - other) / (own - other) for other in others], axis=0)
        line += weight[:, None] * points[one]
    close = there[3] - there[0] <= 8 * np.median(np.diff(along))
    off[2:-2] = np.where(close, np.linalg.norm(points[2:-2] - line, axis=1), 0.0)
    return off


def findings(recording: Recording) -> tuple[str, ...]:
    """Return in words what the recording is and what is odd about it, one line each; a fit goes on all the same."""
    rig, seen = recording.rig, recording.seen
    blocks = len(set(recording.blocks.tolist()))
    own = [_several(blocks, "block"), _several(len(rig.markers), "marker"),
           _several(recording.commands.shape[1], "channel")]  # fmt: skip
    said = [f"{_several(len(recording), 'sample')} ({recording.kind}), {', '.join(own)}"]
    steps = np.diff(recording.time)[recording.blocks[1:] == recording.blocks[:-1]]
    if len(steps) and steps.max() > _HOLE * np.median(steps):
        usual, longest = float(np.median(steps)), float(steps.max())
        said.append(f"time: {_several(int((steps > _HOLE * usual).sum()), 'gap')}, the longest of {longest:.3g} s, "
                    f"where samples are usually {usual:.3g} s apart")  # fmt: skip
    stuck, jumped = frozen(recording), outliers(recording)
    for k, marker in enumerate(rig.markers):
        for mask, words in (
            (~seen[:, k], "not seen"),
            (stuck[:, k], f"at the very same place for {FROZEN} samples or more (drop-outs? gaps.frozen = {FROZEN})"),
            (jumped[:, k], "out of line (a robust loss leaves them out)"),
        ):
            if count := int(mask.sum()):
                said.append(f"marker {marker.name}: {count} of {len(seen)} samples {words}")
    if len(recording) > 1:
        for k, column in enumerate(recording.commands.T):
            if (column == column[0]).all():
                said.append(f"channel {k + 1}: the same in all samples; its gain and slack cannot be told apart")
    pulls = -rig.actuation.values(recording.commands) if rig.actuation.drive == "windings" else np.zeros((1, 0))
    if pulls.size and np.abs(pulls.min(axis=0)).sum() > 4 * np.abs(pulls.max(axis=0)).sum():
        said.append('tendons are let out more than wound in: pull = "negative"?')
    return tuple(said)


def _several(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"
