"""Slow motions of arms that rub: one pose at rest after the other, each remembering what came before.

The arms are the batch, time is not: what B arms differ in is what a fit varies. See `rubbing` for what rubs.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.engine.plant import engine_room
from contarm_sim.errors import ContarmError, InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.statics.walking import Walk
from contarm_sim.statics.ways import Way, way_of, ways_of

TOGETHER = 64
"""Arms that take their steps together: their arrays fit a processor's cache."""


@dataclass(frozen=True, eq=False, repr=False)
class States(Shown):
    """Where B arms are, and what rubs in them remembers: what `settle` goes on from.

    NaN where an arm has fewer joints or muscles than others.

    Attributes:
        qpos: joint angles [rad], shape (B, dofs).
        slid: what friction of the backbone has slid by, of each joint about x and y [rad], shape (B, J, 2).
        grip: of each muscle, -1 to 1, shape (B, M).
        lengths: of the muscles [m], shape (B, M).
        loads: that the arms are under.
    """

    qpos: Array
    slid: Array
    grip: Array
    lengths: Array
    loads: tuple[Load, ...]

    def __len__(self) -> int:
        return len(self.qpos)


@dataclass(frozen=True, eq=False, repr=False)
class Settled(Shown):
    """Poses at rest of B arms, under T loads one after the other; positions [m] and frames in the base frame.

    NaN from where an arm found no rest on, and for what an arm of fewer joints or muscles does not have.

    Attributes:
        frames: 4x4 frames at the stations asked for, shape (B, T, S, 4, 4).
        tip: tip positions [m], shape (B, T, 3).
        qpos: joint angles [rad], shape (B, T, dofs).
        muscle_lengths: [m], shape (B, T, M).
        start_tensions: of each muscle at its winch [N], shape (B, T, M).
        end_tensions: where it is fastened to the arm [N], shape (B, T, M).
        grip: of what rubs on each muscle, 1: it slides towards its winch, shape (B, T, M).
        states: to go on from.
        failed: why an arm stopped, by its number.
        stopped: at which load, by its number.
        seconds: that it took.
    """

    frames: Array
    tip: Array
    qpos: Array
    muscle_lengths: Array
    start_tensions: Array
    end_tensions: Array
    grip: Array
    states: States
    failed: dict[int, ContarmError]
    stopped: dict[int, int]
    seconds: float

    def __len__(self) -> int:
        return len(self.tip)

    def __repr__(self) -> str:
        arms, times = self.tip.shape[:2]
        return f"Settled({arms} arms, {times} loads, {len(self.failed)} stopped)"


def settle(
    arms: Arm | Sequence[Any],
    loads: Sequence[Any],
    *,
    states: States | None = None,
    stations: Sequence[int] | None = None,
    guess: Array | None = None,
) -> Settled:
    """Return the poses of arms under loads one after the other, with friction that remembers.

    The first pose is the equilibrium without friction, unless the arms go on from `states`; from there each step is
    implicit: friction at its end balances the arm there. An arm that has no friction rests where `equilibrium` finds it
    as long as it need not snap from one pose to another. Each arm has the result that it has alone.

    Args:
        arms: one, or B of them; each an Arm, or T of them that differ in what they carry and in gravity alone.
        loads: T, the same for all arms; or, for each arm, T of its own. They drive an arm's muscles alike.
        states: to go on from, as an earlier call left them.
        stations: whose frames are kept, from 0 (base); default all.
        guess: joint angles near the first pose [rad], shape (B, dofs).

    Raises:
        InputError: arguments of another kind, or that do not fit together. What is wrong with one arm alone is in
            `failed`.
    """
    began = time.perf_counter()
    ways = ways_of(arms, loads)
    if states is not None and len(states) != len(ways):
        raise InputError("states", f"of {len(states)} arms", f"of as many as there are arms, {len(ways)}")
    fewest, most = (of(way.arms[0].links for way in ways) for of in (min, max))
    kept = np.arange(most + 1) if stations is None else np.asarray(stations, dtype=int)
    if stations is not None and (kept.ndim != 1 or not len(kept) or kept.min() < 0 or kept.max() > fewest):
        raise InputError("stations", list(stations), f"whole numbers from 0 (base) to {fewest}")
    groups: dict[Any, list[int]] = {}
    begun = np.full(len(ways), True) if states is None else np.array(np.isfinite(states.qpos).any(axis=1))
    for number, way in enumerate(ways):
        if way.error is None and begun[number]:
            groups.setdefault(way.key, []).append(number)
    parts = [
        part for group in groups.values() for part in np.array_split(np.array(group), math.ceil(len(group) / TOGETHER))
    ]
    out = _Rows(ways, kept)
    for number, way in enumerate(ways):
        if way.error is not None or not begun[number]:
            out.stop(number, 0, way.error or InputError("states", "of an arm that never rested", "one that did"))
    with engine_room():
        for part in parts:
            _walk(out, part, states, guess)
    return out.settled(time.perf_counter() - began)


def _walk(out: _Rows, part: NDArray[np.intp], states: States | None, guess: Array | None) -> None:
    """Take arms that go together through their loads."""
    ways = [out.ways[number] for number in part.tolist()]
    kind, times = ways[0].loads[0].muscles.kind, len(ways[0].loads)
    control = np.stack([way.control for way in ways])
    walk = Walk([way.arms[0] for way in ways], [way.bare[0] for way in ways], kind)
    going = np.ones(len(part), dtype=bool)
    about = np.stack([way.about for way in ways])
    before = about[:, 0]
    dofs = walk.poses.qpos.shape[1]
    if states is None:
        first = equilibria(
            [way.bare[0] for way in ways], [way.loads[0] for way in ways],
            guess=None if guess is None else np.asarray(guess)[part][:, :dofs],
        )  # fmt: skip
        for row, error in first.failed.items():
            going[row] = False
            out.stop(int(part[row]), 0, error)
        walk.begin(np.where(going[:, None], first.qpos, 0.0), control[:, 0], [way.loads[0] for way in ways])
    else:
        last = [states.loads[number] for number in part.tolist()]
        were = [way_of(way.arms[:1], way.bare[:1], [load]) for way, load in zip(ways, last, strict=True)]
        before = np.stack([way.about[0] for way in were])
        walk.begin(states.qpos[part][:, :dofs], np.stack([way.control[0] for way in were]), last)
        walk.rubbing.remember(states.slid[part], states.grip[part], states.lengths[part])
    lead = np.diff(about, axis=1, prepend=before[:, None])
    changing = any(way.changes for way in ways)
    for moment in range(times):
        rows = np.flatnonzero(going)
        if not len(rows):
            break
        bare = [way.bare[moment] for way in ways] if changing else None
        failed = walk.step(rows, control[:, moment], [way.loads[moment] for way in ways], lead[:, moment], bare)
        for row, error in failed.items():
            going[row] = False
            out.stop(int(part[row]), moment, error)
        out.keep(walk, part, np.flatnonzero(going), moment)
    out.leave(walk, part)


class _Rows:
    """The arrays of `Settled`, NaN where nothing is written."""

    def __init__(self, ways: Sequence[Way], kept: NDArray[np.intp]) -> None:
        self.ways, self._kept = ways, kept
        count, times = len(ways), len(ways[0].loads)
        links = max(way.arms[0].links for way in ways)
        tendons = max(way.control.shape[1] for way in ways)
        dofs = max(way.about.shape[1] for way in ways)
        shapes = {
            "frames": (times, len(kept), 4, 4), "tip": (times, 3), "qpos": (times, dofs),
            "muscle_lengths": (times, tendons), "start_tensions": (times, tendons), "end_tensions": (times, tendons),
            "grip": (times, tendons),
        }  # fmt: skip
        self._arrays = {name: np.full((count, *shape), np.nan) for name, shape in shapes.items()}
        left = {"qpos": (dofs,), "slid": (links, 2), "grip": (tendons,), "lengths": (tendons,)}
        self._states = {name: np.full((count, *shape), np.nan) for name, shape in left.items()}
        self._failed: dict[int, ContarmError] = {}
        self._stopped: dict[int, int] = {}

    def stop(self, number: int, moment: int, error: ContarmError) -> None:
        """Note that an arm found no rest."""
        self._failed[number], self._stopped[number] = error, moment

    def keep(self, walk: Walk, part: NDArray[np.intp], rows: NDArray[np.intp], moment: int) -> None:
        """Write what arms are at rest with.

        Args:
            walk: C arms.
            part: their numbers among all, shape (C,).
            rows: of those that are at rest, from 0 in the walk.
            moment: number of the load.
        """
        poses, rubbing, at = walk.poses, walk.rubbing, part[rows]
        out, stations = self._arrays, poses.index.stations
        positions, own = poses.data.xpos[:, stations], self._kept[self._kept < poses.data.xpos[:, stations].shape[1]]
        place = slice(0, len(own))
        block = np.zeros((len(rows), len(own), 4, 4))
        block[..., :3, 3] = positions[rows][:, own]
        block[..., :3, :3] = poses.data.xmat[rows][:, stations][:, own].reshape(len(rows), len(own), 3, 3)
        block[..., 3, 3] = 1.0
        out["frames"][at, moment, place] = block
        out["tip"][at, moment] = positions[rows, -1]
        found = {"qpos": poses.qpos, "muscle_lengths": rubbing.lengths, "start_tensions": rubbing.start,
                 "end_tensions": rubbing.end, "grip": rubbing.grip}  # fmt: skip
        for name, array in found.items():
            out[name][at, moment, : array.shape[1]] = array[rows]

    def leave(self, walk: Walk, part: NDArray[np.intp]) -> None:
        """Write what arms go on from.

        Args:
            walk: C arms.
            part: their numbers among all, shape (C,).
        """
        rubbing = walk.rubbing
        found = {"qpos": walk.poses.qpos, "slid": rubbing.slid, "grip": rubbing.grip, "lengths": rubbing.lengths}
        for name, array in found.items():
            self._states[name][part, : array.shape[1]] = array

    def settled(self, seconds: float) -> Settled:
        """Return all that was written."""
        states = States(**self._states, loads=tuple(way.loads[-1] for way in self.ways))
        failed = dict(sorted(self._failed.items()))
        return Settled(**self._arrays, states=states, failed=failed, stopped=self._stopped, seconds=seconds)
