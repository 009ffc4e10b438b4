"""Motions predicted: free swings and commanded motions, every block of every arm in one batch of rollouts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.models import Built, built
from contarm_sim.engine.plant import engine_room
from contarm_sim.engine.plants import Plants
from contarm_sim.errors import InputError
from contarm_sim.identify.prediction.base import under
from contarm_sim.identify.prediction.swing_start import ShapesFromMarkers, smoothed, start_of
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Drive, Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Drive as LoadDrive
from contarm_sim.model.load import Load
from contarm_sim.motion.rollout_step import step_for
from contarm_sim.motion.rollouts import Rollouts
from contarm_sim.statics.driving import DRIVEN
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.statics.places import Places

_DRIVEN: dict[Drive, LoadDrive] = {
    "windings": "setpoints", "tensions": "tensions", "pressures": "pressures", "none": "off"
}  # fmt: skip
"""How a load says what a rig does."""


@dataclass(frozen=True)
class _Block:
    """A motion of its own: the samples that it is followed at, and what it starts from.

    Attributes:
        rows: of the recording, the first is the start, shape (T,).
        time: since the start [s], shape (T,).
        start: positions [m] and velocities [m/s] of the markers at the start, shape (2, K, 3); NaN: not known.
        held: their positions while a hand still held the arm [m], shape (K, 3).
    """

    rows: NDArray[np.intp]
    time: Array
    start: Array
    held: Array


@dataclass(frozen=True)
class _Pair:
    """An arm with its payload, in its rig (of a number), in a block, its first load, and its step [s]."""

    number: int
    rig: Rig
    block: _Block
    arm: Arm
    load: Load
    step: float

    @property
    def geometry(self) -> object:
        """What its shape by the markers depends on."""
        rig, lengths = self.rig, tuple(section.length for section in self.arm.sections)
        return id(self.block), lengths, rig.markers, rig.position, rig.orientation, rig.turn


class InMotion:
    """Predicts motions: a rollout for each block.

    A commanded motion starts at rest under its first command. A free swing (`drive` is `none`) starts from the shape
    and the speed that its markers have where the hand has let go, see `swing_start`; friction in the backbone then
    holds what the way from rest to the shape that was held, and on to the start, leaves of it.

    An arm that no step is stable for, or that cannot be under the first load, has no motion: NaN.

    Args:
        recording: of a motion.
        threads: that share the work; 0: one a processor.
        timestep: of the engine [s]; default what each arm takes, see `step_for`.

    Attributes:
        recording: the one given; markers at samples before a swing's start are not seen in it, nor those of a swing
            whose start no marker tells of. Compare predictions with this one.

    Raises:
        InputError: a recording at rest, forces on the backbone, which motions do not know, a payload that changes
            within a block, or no swing with a start. When called: friction along driven tendons, which motions do not
            know; or, until an arm has been predicted, why the first of them has no motion.
    """

    def __init__(self, recording: Recording, threads: int = 0, timestep: float | None = None) -> None:
        if recording.kind != "motion":
            raise InputError("kind", repr(recording.kind), "'motion'", recording.name)
        if recording.force is not None:
            raise InputError("force", "given", "none: in motions only a payload loads the arm", recording.name)
        self._threads, self._given, self._begun = threads, timestep, False
        drive = recording.rig.actuation.drive
        self._swings, self._actuation = drive == "none", DRIVEN[_DRIVEN[drive]][1]
        _check_payload(recording)
        every = [self._block(recording, name) for name in dict.fromkeys(recording.blocks.tolist())]
        self._blocks = [one for one in every if not self._swings or np.isfinite(one.start).any()]
        if not self._blocks:
            allowed = "swings with four samples or more, about their start, at which a marker is seen"
            raise InputError("blocks", f"{len(every)}, none of them with a start", allowed, recording.name)
        followed = np.zeros(len(recording), dtype=bool)
        followed[np.concatenate([one.rows for one in self._blocks])] = True
        self.recording = replace(recording, positions=np.where(followed[:, None, None], recording.positions, np.nan))

    def _block(self, recording: Recording, name: str) -> _Block:
        rows = np.flatnonzero(recording.blocks == name)
        time, positions = recording.time[rows], recording.positions[rows]
        start, held = start_of(time, positions, recording.release) if self._swings else (0, 0)
        begin, before = np.stack(smoothed(time, positions, start)), smoothed(time, positions, held)[0]
        return _Block(rows[start:], time[start:] - time[start], begin, before)

    def __call__(self, arms: Sequence[Arm], rigs: Sequence[Rig]) -> Array:
        """Return where the markers are measured [m], shape (B, T, K, 3), see `Predictor`; NaN before a swing starts."""
        recording, blocks = self.recording, self._blocks
        out = np.full((len(arms), len(recording), len(recording.rig.markers), 3), np.nan)
        heads = recording.part([int(one.rows[0]) for one in blocks])
        pairs, first, steps = list[_Pair](), None, dict[Arm, float]()
        for number, (arm, rig) in enumerate(zip(arms, rigs, strict=True)):
            if not self._swings:
                arm.refuse_memory("motions of driven tendons are predicted", backbone=False)
            try:
                held, loads = under(arm, rig, heads)
                step = min(self._step(one, first, steps) for one in dict.fromkeys(held))
            except InputError:
                if not self._begun:
                    raise
                continue
            self._begun, first = True, first or step
            pairs += [_Pair(number, rig, *own, step) for own in zip(blocks, held, loads, strict=True)]
        alike: dict[tuple[bool, float], list[_Pair]] = {}
        for pair in pairs:  # of two layouts
            alike.setdefault((pair.arm.payload > 0, pair.step), []).append(pair)
        with engine_room(), np.errstate(all="ignore"):  # arms that diverge
            for some in alike.values():
                self._follow(some, out)
        return out

    def _step(self, arm: Arm, usual: float | None, known: dict[Arm, float]) -> float:
        """Return the step of an arm [s]."""
        if self._given is not None:
            return self._given
        if arm not in known:
            known[arm] = step_for(arm, self._actuation, usual)
        return known[arm]

    def _follow(self, pairs: list[_Pair], out: Array) -> None:
        plants = self._plants([one.arm.without_memory for one in pairs])
        step = pairs[0].step
        rollouts = Rollouts(plants, [one.arm for one in pairs], step)
        places = [Places(one.arm, [marker.xi for marker in one.rig.markers]) for one in pairs]
        stations, columns = np.unique([own.stations for own in places], return_inverse=True)
        columns = columns.reshape(len(pairs), -1, 2)
        coordinates = [one.block.time / step for one in pairs]
        before = [np.floor(at + 1e-6).astype(int) for at in coordinates]
        after = [np.ceil(at - 1e-6).astype(int) for at in coordinates]
        seen = np.unique(np.concatenate([*before, *after]))
        qpos, qvel = self._start(plants, rollouts, pairs)
        points, turns = rollouts.run(
            np.nan_to_num(qpos), qvel, np.array([own[-1] for own in after]), seen, stations,
            self._controls(pairs, step, int(seen[-1])),
        )  # fmt: skip
        lost = {int(p) for p in np.flatnonzero(np.isnan(qpos).any(axis=1))} | set(plants.failed)
        for p, one in enumerate(pairs):
            if p in lost:
                continue
            met = []
            for steps in (before[p], after[p]):
                rows = np.searchsorted(seen, steps)[:, None, None]
                met.append(one.rig.measured(places[p].between(points[rows, p, columns[p]], turns[rows, p, columns[p]])))
            part = (coordinates[p] - before[p]).clip(0.0, 1.0)[:, None, None]
            out[one.number, one.block.rows] = met[0] + part * (met[1] - met[0])

    def _plants(self, arms: list[Arm]) -> Plants:
        """Return the arms in the engine."""
        made: dict[Arm, Built] = {}
        alone = any(section.torsional_stiffness is not None for section in arms[0].sections)  # see `stiffen_twist`

        def compiled(arm: Arm, _: object) -> Built:
            if alone or arm not in made:
                made[arm] = built(arm, self._actuation)
            return made[arm]

        pull_only = self._actuation != "tensions"
        return Plants(arms, self._actuation, pull_only=pull_only, threads=self._threads, compiled=compiled)

    def _start(self, plants: Plants, rollouts: Rollouts, pairs: list[_Pair]) -> tuple[Array, Array]:
        """Return angles and rates [rad, rad/s], shape (P, D), and let friction hold what it does there."""
        arms, loads = [one.arm.without_memory for one in pairs], [one.load for one in pairs]
        if not self._swings:
            rest = equilibria(arms, loads, threads=self._threads).qpos
            controls = np.array([load.muscles.values for load in loads])
            plants.restart(None, np.nan_to_num(rest), controls)
            if rollouts.friction is not None:
                rollouts.friction.start(np.nan_to_num(rest))
            return rest, np.zeros(rest.shape)
        alike: dict[object, int] = {}  # shapes are the same for arms of the same geometry in the same rig
        of = [alike.setdefault(one.geometry, len(alike)) for one in pairs]
        first = [pairs[of.index(k)] for k in range(len(alike))]
        shapes = ShapesFromMarkers(self._plants([one.arm.without_memory for one in first]), [one.rig for one in first])
        if rollouts.friction is not None:
            rollouts.friction.start(np.nan_to_num(equilibria(arms, loads, threads=self._threads).qpos))
            rollouts.friction.follow(shapes.angles(np.stack([one.block.held for one in first]))[of])
        qpos = shapes.angles(np.stack([one.block.start[0] for one in first]))
        qvel = shapes.rates(qpos, np.stack([one.block.start[1] for one in first]))
        plants.restart(None, qpos[of], np.zeros((len(pairs), plants.index.actuators.shape[1])))
        return qpos[of], qvel[of]

    def _controls(self, pairs: list[_Pair], step: float, last: int) -> Callable[[int], Array] | None:
        """Return what gives controls at steps, shape (P, M); None where nothing drives the muscles."""
        if self._swings:
            return None
        rigs = {one.number: one.rig for one in pairs}
        told = {number: rig.actuation.values(self.recording.commands) for number, rig in rigs.items()}
        times = np.arange(last + 1) * step
        at = {}
        for one in pairs:
            if id(one.block) not in at:
                at[id(one.block)] = np.interp(times, one.block.time, one.block.rows)
        numbers = [one.number for one in pairs]
        values = np.stack([told[number] for number in sorted(told)])
        index = np.searchsorted(sorted(told), numbers)
        coordinates = np.stack([at[id(one.block)] for one in pairs])
        low = np.floor(coordinates).astype(int)
        part = coordinates - low
        high = np.minimum(low + 1, len(self.recording) - 1)

        def controls(k: int) -> Array:
            share = part[:, k, None]
            return (1 - share) * values[index, low[:, k]] + share * values[index, high[:, k]]

        return controls


def _check_payload(recording: Recording) -> None:
    """Refuse a payload that changes within a block of a motion."""
    if recording.payload is None:
        return
    for name in dict.fromkeys(recording.blocks.tolist()):
        carried = recording.payload[recording.blocks == name]
        if carried.min() != carried.max():
            given = f"{carried.min():g} to {carried.max():g} kg in block {name!r}"
            raise InputError("payload", given, "one payload in each block of a motion", recording.name)
