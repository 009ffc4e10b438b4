"""What users hand to methods that draw: switches, functions that are told of progress, places to write to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.files import scratch_name
from contarm_sim.inputs import quoted


def check_switches(**given: Any) -> None:
    """Refuse what is neither True nor False.

    Raises:
        InputError: names the first one.
    """
    for name, value in given.items():
        if not isinstance(value, bool):
            raise InputError(name, quoted(value), "True or False")


def check_progress(on_frame: Any) -> None:
    """Refuse what cannot be called.

    Raises:
        InputError: it is neither None nor callable.
    """
    if on_frame is not None and not callable(on_frame):
        raise InputError("on_frame", quoted(on_frame), "a function of two numbers: frames drawn, and their total")


def check_writable(target: Path) -> None:
    """Refuse a file that cannot be made: this is tried, beside it.

    Raises:
        InputError: says why.
    """
    trial = scratch_name(target)
    try:
        trial.touch(exist_ok=False)
        trial.unlink()
    except OSError as error:
        raise not_written(target, error) from error


def not_written(target: Path, error: OSError) -> InputError:
    """Return the error that says why a file could not be written."""
    return InputError("path", f"{quoted(target)} ({error.strerror})", "a file that can be written")
