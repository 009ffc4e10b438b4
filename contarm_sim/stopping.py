"""Being stopped: Ctrl-C, SIGTERM and SIGHUP as one KeyboardInterrupt, which waits for what must be whole."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""What asks a process to end: the user, the system, a terminal that is closed."""

AGAIN = 0.02
"""Time after which an interruption that Python swallowed is tried once more [s]."""


class _State:
    """Signals belong to the process, and so does this.

    Attributes:
        number: the first signal that came, or None.
        blocks: how many blocks are running that a signal must wait for.
        waiting: whether one does.
    """

    number: int | None = None
    blocks = 0
    waiting = False


_state = _State()


def _come(number: int, frame: object) -> None:
    _state.number = _state.number or number
    if _state.blocks:
        _state.waiting = True
    else:
        raise KeyboardInterrupt


@contextmanager
def listening() -> Iterator[None]:
    """Raise KeyboardInterrupt in the main thread when a signal comes; one that the process was told to ignore stays so.

    Python swallows what is raised while it throws an object away: then it is raised again a moment later.
    """
    before = {number: signal.getsignal(number) for number in SIGNALS}
    hook = sys.unraisablehook
    try:
        sys.unraisablehook = lambda lost: _raise_again() if lost.exc_type is KeyboardInterrupt else hook(lost)
        for number, handler in before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, _come)
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = hook
        _state.number, _state.waiting = None, False


def _raise_again() -> None:
    import threading

    main, number = threading.main_thread().ident, _state.number or signal.SIGINT
    timer = threading.Timer(AGAIN, lambda: signal.pthread_kill(main, number) if main else None)
    timer.daemon = True
    timer.start()


@contextmanager
def unbroken() -> Iterator[None]:
    """Let a block end before a signal takes effect; may be nested. Without `listening` it changes nothing."""
    _state.blocks += 1
    try:
        yield
    finally:
        _state.blocks -= 1
        if not _state.blocks:
            break_off()


@contextmanager
def breakable() -> Iterator[None]:
    """Inside `unbroken`: a part that a signal may break off all the same."""
    blocks = _state.blocks
    try:
        _state.blocks = 0
        break_off()
        yield
    finally:
        _state.blocks = blocks


def break_off() -> None:
    """Raise KeyboardInterrupt if a signal is waiting: here, in an unbroken block, is a good place to end early."""
    if _state.waiting:
        _state.waiting = False
        raise KeyboardInterrupt


def came() -> signal.Signals | None:
    """Return the first signal that came since `listening` began, or None."""
    return None if _state.number is None else signal.Signals(_state.number)


def exit_code() -> int:
    """Return the exit code of an interrupted process: 128 and the signal's number; Ctrl-C's where none came."""
    return 128 + (_state.number or signal.SIGINT)
