"""Predicts static recordings of arms that rub: where the markers are depends on all that was commanded before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.identify.prediction.base import markers_at, under
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.memory import settle
from contarm_sim.statics.places import Places

RUBS = ("friction_moment", "friction_stiffness", "friction", "friction_coefficient", "braid_friction")
"""Last parts of names of parameters that poses remember by."""


def rubs(arm: Arm) -> bool:
    """Return whether poses of an arm remember what came before: friction in its backbone, at or along its muscles."""
    backbone = any(section.friction_moment is not None for section in arm.sections)
    return backbone or any(
        group.law.dry_friction is not None or getattr(group.law, "friction_coefficient", None) is not None
        for group in arm.groups
    )


def remembers(arm: Arm, names: Sequence[str] = ()) -> bool:
    """Return whether a fit of these parameters needs memory.

    Raises:
        InputError: friction is free that the arm has no start value of.
    """
    free = [name for name in names if name.split(".")[-1] in RUBS]
    if free and not rubs(arm):
        last = free[0].split(".")[-1]
        raise InputError(free[0], "omitted", f"a value in the arm's file to start from, such as {last} = 0.05")
    return rubs(arm)


class WithMemory:
    """Predicts the samples of a static recording one after the other, with friction that remembers.

    The first sample is the equilibrium without friction; gaps in time do not matter, for friction knows no time. What
    an arm sees of its rig alone, such as the offset of a marker, costs nothing: its poses are found once.

    Args:
        recording: what was commanded, in the order of time.

    Attributes:
        recording: as given.

    Raises:
        InputError: when called, until an arm has been predicted: why the first cannot be. Later it has no pose: NaN.
    """

    def __init__(self, recording: Recording) -> None:
        self.recording = recording
        self._near: Array | None = None
        self._begun = False

    def __call__(self, arms: Sequence[Arm], rigs: Sequence[Rig]) -> Array:
        """Return where the markers are measured [m], shape (B, T, K, 3), see `Predictor`."""
        recording = self.recording
        poses: dict[Any, int | None] = {}
        ways: list[tuple[list[Arm], list[Load]]] = []
        which: list[int | None] = []
        for arm, rig in zip(arms, rigs, strict=True):
            key = (
                arm,
                rig.actuation,
                rig.holds(arm).gravity,
                None if recording.force is None else rig.rotation.tobytes(),
            )
            if key not in poses:
                try:
                    ways.append(under(arm, rig, recording))
                    poses[key] = len(ways) - 1
                except InputError:
                    if not self._begun:
                        raise
                    poses[key] = None
            which.append(poses[key])
        out = np.full((len(arms), len(recording), len(recording.rig.markers), 3), np.nan)
        if not ways:
            return out
        places = [Places(arm, [marker.xi for marker in rig.markers]) for arm, rig in zip(arms, rigs, strict=True)]
        stations = np.unique(np.concatenate([place.stations.ravel() for place in places]))
        guess = None if self._near is None else np.tile(self._near, (len(ways), 1))
        found = settle([way[0] for way in ways], [way[1] for way in ways], stations=stations.tolist(), guess=guess)
        if not self._begun and isinstance(found.failed.get(0), InputError):
            raise found.failed[0]
        self._begun = True
        first = found.qpos[0, 0]
        if np.isfinite(first).any():
            self._near = np.where(np.isfinite(first), first, 0.0)
        frames = np.full((len(recording), int(stations[-1]) + 1, 4, 4), np.nan)
        for place, (arm, rig) in enumerate(zip(arms, rigs, strict=True)):
            if which[place] is None:
                continue
            frames[:, stations] = found.frames[which[place]]
            out[place] = markers_at(arm, rig, frames)
        return out
