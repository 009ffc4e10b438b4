"""Where markers are predicted to be: many arms, each in its rig, under the commands of one recording.

A fit asks for a whole population at once: its present arm, and one with each parameter changed a little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Wrench
from contarm_sim.statics.equilibria import equilibria
from contarm_sim.statics.places import Places


class Predictor(Protocol):
    """Predicts a recording's markers."""

    recording: Recording

    def __call__(self, arms: Sequence[Arm], rigs: Sequence[Rig]) -> Array:
        """Return where the markers are measured, if these are the arms in their rigs [m], shape (B, T, K, 3).

        NaN where an arm has no pose. The first arm is the one that the others differ from a little.
        """
        ...


class AtRest:
    """Predicts static poses, each for itself: what came before a sample does not matter.

    Args:
        recording: what was commanded.
        threads: that share the work; 0: one a processor.

    Raises:
        InputError: when called, until an arm has been predicted: why the first cannot be. Later it has no pose: NaN.
    """

    def __init__(self, recording: Recording, threads: int = 0) -> None:
        self.recording, self._threads = recording, threads
        self._near: Array | None = None
        self._begun = False

    def __call__(self, arms: Sequence[Arm], rigs: Sequence[Rig]) -> Array:
        """Return where the markers are measured [m], shape (B, T, K, 3), see `Predictor`."""
        recording = self.recording
        out = np.full((len(arms), len(recording), len(recording.rig.markers), 3), np.nan)
        first: tuple[Any, ...] | None = None
        loads: list[Load] | None = None
        frames = np.empty(0)
        for place, (arm, rig) in enumerate(zip(arms, rigs, strict=True)):
            own = statics_of(arm, rig, recording)
            if first is None or own != first:  # frames and markers move nothing, unless gravity or a force turns
                same = None if first is None or own[1:] != first[1:] else loads
                try:
                    under_load = under(arm, rig, recording, same)
                except InputError:
                    if not self._begun:
                        raise
                    continue
                self._begun = True
                found = equilibria(*under_load, guess=self._near, threads=self._threads)
                if first is None:
                    first, frames, loads = own, found.frames, under_load[1]
                    far = np.zeros_like(found.qpos) if self._near is None else self._near
                    self._near = np.where(np.isfinite(found.qpos), found.qpos, far)
                out[place] = markers_at(arm, rig, found.frames)
            else:
                out[place] = markers_at(arm, rig, frames)
        return out


def statics_of(arm: Arm, rig: Rig, recording: Recording) -> tuple[Any, ...]:
    """Return all that the poses of an arm in a rig at the samples of a recording depend on; equal where they are."""
    return rig.holds(arm), rig.actuation, None if recording.force is None else rig.rotation.tolist()


def under(
    arm: Arm, rig: Rig, recording: Recording, loads: list[Load] | None = None
) -> tuple[list[Arm], list[Load]]:  # fmt: skip
    """Return the arm with what its tip carries, and its load, at each sample of a recording.

    Args:
        arm, rig, recording: of which.
        loads: where they are known already.
    """
    held = rig.holds(arm)
    if recording.payload is None:
        arms = [held] * len(recording)
    else:
        carrying = {kg: held.in_world(replace(held.world, payload=kg)) for kg in set(recording.payload.tolist())}
        arms = [carrying[kg] for kg in recording.payload.tolist()]
    if loads is not None:
        return arms, loads
    values, actuation = rig.actuation.values(recording.commands), rig.actuation
    wrenches: list[tuple[Wrench, ...]] = [()] * len(recording)
    if recording.force is not None:
        forces = recording.force @ rig.rotation
        wrenches = [(Wrench(xi=recording.force_xi, force=tuple(force)),) for force in forces.tolist()]
    loads = [Load(muscles=actuation.muscles(told), wrenches=own) for told, own in zip(values, wrenches, strict=True)]
    return arms, loads


def markers_at(arm: Arm, rig: Rig, frames: Array) -> Array:
    """Return where markers are measured [m], shape (T, K, 3), from the stations' frames, shape (T, N + 1, 4, 4)."""
    places = Places(arm, [marker.xi for marker in rig.markers])
    about = frames[:, places.stations]
    return rig.measured(places.between(about[..., :3, 3], about[..., :3, :3]))
