"""Arms and recordings that arguments name."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contarm_sim.identify.recordings.recording import Recording
    from contarm_sim.model.arm import Arm


def arm_named(word: str) -> Arm:
    """Return the arm of a file or, where there is no such file, of a preset.

    Raises:
        InputError: neither, or a file that is no arm's.
    """
    from contarm_sim.model.arm_file import load_arm
    from contarm_sim.model.presets import PRESETS

    return PRESETS[word]() if word in PRESETS and not Path(word).exists() else load_arm(word)


def recording_in(file: str, arm: Arm, rig_file: str | None = None) -> Recording:
    """Return the recording of a file, in the rig of another file if one is given.

    Raises:
        InputError: a file that cannot be read, or of another arm.
    """
    from contarm_sim.identify.recordings.file import load_recording
    from contarm_sim.identify.recordings.rig_file import load_rig

    recording = load_recording(file, arm)
    return recording if rig_file is None else recording.in_rig(load_rig(rig_file, arm))
