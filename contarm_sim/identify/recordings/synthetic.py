"""Recordings that the simulator itself makes: commands as people give them, and what a tracker would have seen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.prediction.base import Predictor
from contarm_sim.identify.prediction.choice import predictor_of
from contarm_sim.identify.recordings.recording import Kind, Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.muscles import towards_muscles
from contarm_sim.model.arm import Arm

LOST = 5
"""Mean number of samples that a marker is lost for."""

JUMP = 0.03
"""Size of outliers [m], on average."""


def recorded(
    arm: Arm,
    rig: Rig,
    commands: Any,
    *,
    seed: int,
    kind: Kind = "static",
    time: Any = None,
    noise: float = 0.0005,
    gaps: float = 0.0,
    outliers: float = 0.0,
    drift: float = 0.0,
    payload: Any = None,
    force: Any = None,
    force_xi: float = 1.0,
    blocks: Sequence[str] | None = None,
    predictor: Callable[[Recording], Predictor] | None = None,
    name: str = "synthetic",
) -> Recording:
    """Return what would have been recorded of an arm in a rig.

    Args:
        commands: of the channels, SI units, shape (T, C); see `random_windings`.
        seed: of all that is random.
        kind: `static` or `motion`.
        time: of the samples [s], shape (T,); default: one a second at rest, 100 a second of a motion.
        noise: standard deviation of each coordinate of each marker [m].
        gaps: part of the samples in which a marker is lost, some at a time.
        outliers: part of the samples in which a marker jumps, by 30 mm or so.
        drift: how far the measuring frame is off at the end [m], in a random direction, growing evenly.
        payload: that the tip carries [kg]: a number, or shape (T,).
        force: on the backbone at `force_xi`, in the frame of the measurements [N], shape (3,) or (T, 3).
        blocks: what each sample belongs to; default: all to one.
        predictor: what says where the markers are, made of the recording; default that of `predictor_of`.

    Raises:
        InputError: arrays that do not fit together, free swings, which start from markers that were measured, or a
            command under which the arm has no pose.
    """
    arm.refuse_objects("recordings are made")
    told = np.array(commands, dtype=float)
    if told.ndim != 2:
        raise InputError("commands", f"of shape {told.shape}", "an array of samples x channels")
    if kind == "motion" and predictor is None and rig.actuation.drive == "none":
        raise InputError("predictor", "missing", "one of free swings: theirs start from markers that were measured")
    for key, value in {"noise": noise, "gaps": gaps, "outliers": outliers, "drift": drift}.items():
        most = np.inf if key in ("noise", "drift") else 0.9
        if not 0 <= value <= most:
            raise InputError(key, value, "0 or more [m]" if np.isinf(most) else f"a part from 0 to {most}")
    count, random = len(told), np.random.default_rng(seed)
    seconds = np.arange(count) / (1.0 if kind == "static" else 100.0) if time is None else time
    bare = Recording(
        kind=kind,
        time=seconds,
        positions=np.zeros((count, len(rig.markers), 3)),
        commands=told,
        rig=rig,
        blocks=np.array([""] * count if blocks is None else list(blocks)),
        payload=None if payload is None else np.broadcast_to(np.asarray(payload, dtype=float), (count,)),
        force=None if force is None else np.broadcast_to(np.asarray(force, dtype=float), (count, 3)),
        force_xi=force_xi,
        name=name,
    )
    predicts = predictor_of(bare, arm) if predictor is None else predictor(bare)
    where = predicts([arm], [rig])[0]
    if not np.isfinite(where).all():
        number = int(np.argwhere(~np.isfinite(where))[0][0])
        raise InputError(
            f"sample {number + 1}, commands", told[number].tolist(), "commands that the arm has a pose under"
        )
    return replace(bare, positions=_seen(where, bare.time, random, noise, gaps, outliers, drift))


def _seen(
    where: Array, time: Array, random: np.random.Generator, noise: float, gaps: float, outliers: float, drift: float
) -> Array:
    """Return what a tracker sees of markers, shape (T, K, 3)."""
    count, markers = where.shape[:2]
    away = random.normal(size=3)
    part = (time - time[0]) / max(float(np.ptp(time)), 1e-12)
    seen = where + random.normal(0.0, 1.0, where.shape) * noise
    seen += drift * part[:, None, None] * away / np.linalg.norm(away)
    jumps = random.random((count, markers)) < outliers
    seen[jumps] += random.normal(0.0, JUMP / np.sqrt(3), (int(jumps.sum()), 3))
    for k in range(markers):
        lost = np.zeros(count, dtype=bool)
        while lost.sum() < round(gaps * count):
            begin, length = int(random.integers(count)), int(random.geometric(1 / LOST))
            lost[begin : begin + min(length, round(gaps * count) - int(lost.sum()))] = True
        seen[lost, k] = np.nan
    return seen


def random_windings(
    arm: Arm, count: int, seed: int, *, bend: float = 1.0, taut: float = 0.0005, samples: int = 24
) -> tuple[Array, list[str]]:
    """Return windings of all muscles, and the pattern that each sample belongs to, as people record them.

    Closed patterns that begin and end in the straight arm: circles and there-and-backs of one section at a time, then
    of all together.

    Args:
        count: of samples.
        bend: largest bend of a section [rad]; several are bent less, so that their bends add up to twice this at most.
        taut: what is wound in of each muscle beside, so that it is taut [m].
        samples: of each pattern.

    Returns:
        windings [m], shape (T, M), muscles section by section; names of patterns, T of them.

    Raises:
        InputError: no samples, or a bend that is not above 0.
    """
    if isinstance(count, bool) or not isinstance(count, int) or count < 1:
        raise InputError("count", count, "a whole number, at least 1")
    if not 0 < bend <= 2 * np.pi:
        raise InputError("bend", bend, "an angle above 0 [rad], at most 2 pi")
    random, sections = np.random.default_rng(seed), len(arm.sections)
    bends, names = np.zeros((count, sections, 2)), []
    for number in range(-(-count // samples)):
        alone = number % (2 * sections)
        moving = [alone] if alone < sections and sections > 1 else list(range(sections))
        rows = slice(number * samples, min(count, (number + 1) * samples))
        steps = np.arange(rows.stop - rows.start) / samples
        for section in moving:
            most = bend * random.uniform(0.5, 1.0) * min(1.0, 2 / len(moving))
            bends[rows, section] = most * _closed(steps, random)
        word = f"section_{alone + 1}" if len(moving) < sections else "all"
        names += [f"{number + 1}_{word}"] * len(steps)
    parts = []
    for group in arm.groups:
        own = [k for k in range(sections) if group.crosses(k)]
        parts.append(group.routing.radius * sum(towards_muscles(bends[:, k], group.routing.angles) for k in own) + taut)
    return np.concatenate(parts, axis=1), names


def _closed(steps: Array, random: np.random.Generator) -> Array:
    """Return a closed pattern of bends of size 1, shape (T, 2), at steps from 0 to 1: a loop or a there-and-back."""
    turn, round_about = random.uniform(0, 2 * np.pi), random.random() < 0.5
    size = np.sin(np.pi * steps) ** (0.5 if round_about else 1.0)
    angle = turn + (2 * np.pi * steps * random.choice([-1, 1]) if round_about else 0.3 * np.sin(2 * np.pi * steps))
    return np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)
