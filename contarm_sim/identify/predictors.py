"""Which predictor a recording takes: of poses at rest, of poses that remember, or of motions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.identify.predict import AtRest, Predictor
from contarm_sim.identify.recording import Recording
from contarm_sim.model.arm import Arm

Memory = Any
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
        threads: that share the work; 0: one a processor.

    Raises:
        InputError: a recording that nothing predicts.
    """
    if recording.kind == "static":
        return AtRest(recording, threads)
    raise InputError("kind", repr(recording.kind), "static", recording.name)
