"""Which predictor a recording takes: of poses at rest, of poses that remember, or of motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from contarm_sim.errors import InputError
from contarm_sim.identify.prediction.base import AtRest, Predictor
from contarm_sim.identify.prediction.remembering import WithMemory, remembers
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.model.arm import Arm

Memory = Literal["auto"] | bool
"""`auto`: poses remember what came before where the arm rubs; True or False: they do or do not."""


def predictor_of(
    recording: Recording, arm: Arm, *, names: Sequence[str] = (), memory: Memory = "auto", threads: int = 0
) -> Predictor:
    """Return what predicts the markers of a recording.

    Args:
        recording: what was commanded.
        arm: that it is of.
        names: of the parameters that are free.
        memory: see `Memory`.
        threads: that share the work; 0: one a processor. Poses that remember are found by one.

    Raises:
        InputError: friction is free that the arm does not have, friction along tendons that drive a motion, or a
            `memory` that is none.
    """
    if recording.kind == "motion":
        from contarm_sim.identify.prediction.moving import InMotion

        if recording.rig.actuation.drive != "none":
            arm.refuse_memory("motions of driven tendons are predicted", backbone=False)
        return InMotion(recording, threads)
    if memory not in ("auto", True, False):
        raise InputError("memory", repr(memory), "'auto', True or False")
    if memory is True or (memory == "auto" and remembers(arm, names)):
        return WithMemory(recording)
    return AtRest(recording, threads)
