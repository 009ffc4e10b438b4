"""What users hand to methods that draw: switches, functions that are told of progress, places to write to."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contarm_sim.errors import InputError
from contarm_sim.files import scratch_name
from contarm_sim.inputs import quoted

if TYPE_CHECKING:
    from contarm_sim.view.rendering.film import Progress

PATIENCE = 2.0
"""Time before somebody who waits for a film is told how far it is [s]."""

_PAUSE = 0.2  # between two such lines [s]


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


def told(on_frame: Progress | None) -> Progress:
    """Return what is told of frames: what was given, or else a line that somebody reads, after two seconds."""
    if on_frame is not None:
        return on_frame
    write, due, written = _line(), time.monotonic() + PATIENCE, False

    def show(done: int, total: int) -> None:
        nonlocal due, written
        if written and done == total:
            write("")
        elif done < total and time.monotonic() >= due:
            write(f"filming: {done} of {total} frames")
            due, written = time.monotonic() + _PAUSE, True

    return show


def _line() -> Callable[[str], object]:
    """Return what writes a line in place of the one before: in a notebook, on a terminal, or nowhere."""
    if "ipykernel" in sys.modules:
        from IPython.display import display

        line: list[Any] = []

        def shown(words: str) -> None:
            if line:
                line[0].update({"text/plain": words}, raw=True)
            else:
                line.append(display({"text/plain": words}, raw=True, display_id=True))

        return shown
    if sys.stderr.isatty():
        return lambda words: print(f"\r{words:<40}\r{words}", end="", file=sys.stderr, flush=True)
    return lambda words: None


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
