"""Arms and recordings that arguments name."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
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


@contextmanager
def as_options(*options: str) -> Iterator[None]:
    """Let errors name the options, `--hold-out`, in place of the arguments that they are given to, `held_out`."""
    from contarm_sim.errors import InputError

    named = {"held_out" if one == "--hold-out" else one.strip("-").replace("-", "_"): one for one in options}
    try:
        yield
    except InputError as error:
        if error.name not in named:
            raise
        raise InputError(named[error.name], error.given, error.allowed, error.where) from None


def say_findings(recording: Recording) -> None:
    """Say what is odd about a recording, on stderr."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.identify.recordings.checks import findings

    for finding in findings(recording)[1:]:  # the first says what it is
        say(f"{recording.name}: {finding}")
