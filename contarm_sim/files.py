"""Files and folders that appear whole or not at all; what killed processes left of them goes at the next start."""

from __future__ import annotations

import fcntl
import os
import re
import shutil
import stat
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from contarm_sim.stopping import unbroken

_SCRATCH = re.compile(r"\..{0,30}\.contarm-[0-9a-f]{16}(\..*)?", re.DOTALL)

_FRESH = 1.0
"""Age below which a scratch file is left alone: it may have been made, but not claimed yet [s]."""


def scratch_name(target: Path) -> Path:
    """Return a hidden name beside `target` that nobody can guess, with the same ending."""
    return target.with_name(f".{target.stem[:30]}.contarm-{os.urandom(8).hex()}{target.suffix[:16]}")


def claim(descriptor: int) -> None:
    """Mark an open scratch file or folder as in use; the system takes the mark away when the process ends, however."""
    with suppress(OSError):  # a file system without locks keeps what killed processes leave
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def remove_leftovers(folder: Path) -> None:
    """Remove scratch files and folders of processes that are gone: those of this user that no process claims."""
    with suppress(OSError):
        for entry in os.scandir(folder):
            if _SCRATCH.fullmatch(entry.name):
                found = entry.stat(follow_symlinks=False)
                if found.st_uid == os.getuid() and time.time() - found.st_mtime > _FRESH:
                    with suppress(OSError):
                        _remove_unclaimed(entry.path)


def _remove_unclaimed(path: str) -> None:
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)  # an OSError if somebody is at work there
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            shutil.rmtree(path, ignore_errors=True)
        else:
            os.unlink(path)
    finally:
        os.close(descriptor)


@contextmanager
def appearing(target: Path, new: bool = False) -> Iterator[Path]:
    """Yield a path beside `target` to write to; it becomes `target` when all went well, and is removed otherwise.

    The file is there already, empty, made new (no link is followed) and with the permissions that `open` gives.

    Args:
        new: leave what has taken the name meanwhile as it is.

    Raises:
        OSError: it cannot be made, or cannot take its name; a FileExistsError if `new` and it is taken.
    """
    scratch, descriptor = scratch_name(target), -1
    try:
        with unbroken():
            descriptor = os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o666)
            claim(descriptor)
        yield scratch
        if new:
            _take_free_name(scratch, target)
        else:
            os.replace(scratch, target)
    except BaseException:
        with unbroken():
            scratch.unlink(missing_ok=True)
        raise
    finally:
        if descriptor >= 0:
            os.close(descriptor)


def _take_free_name(scratch: Path, target: Path) -> None:
    """Rename a file to a name that nobody has; of two that try at once, one succeeds."""
    try:
        with unbroken():
            os.link(scratch, target, follow_symlinks=False)
            scratch.unlink()
    except FileExistsError:
        raise
    except OSError:  # a file system without links
        if target.exists() or target.is_symlink():
            raise FileExistsError(17, os.strerror(17), str(target)) from None
        os.replace(scratch, target)


def write_whole(target: Path, text: str) -> None:
    """Write a text file (UTF-8) in place of what `target` held, if anything, in one stroke.

    Raises:
        OSError: as `appearing`.
    """
    with appearing(target) as scratch:
        scratch.write_text(text, encoding="utf-8")
