"""Files that users hand in: opened in one place, so that every reader refuses the same things in the same words."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError

MOST_BYTES = 64 * 2**20
"""Largest text file that is read [bytes]: a path of an hour at 100 Hz has 40 MB."""


def as_path(name: str, given: Any, allowed: str) -> Path:
    """Return a path that a user gave; a ~ in front is the user's folder.

    Raises:
        InputError: it is none, has a null character, which no system takes, or begins with a ~ of nobody.
    """
    if not isinstance(given, (str, os.PathLike)) or "\0" in os.fspath(given):
        raise InputError(name, quoted(given), allowed)
    try:
        return Path(given).expanduser()
    except RuntimeError:  # ~somebody that the system does not know
        raise InputError(name, quoted(given), allowed) from None


def quoted(given: Any) -> Any:
    """Return what a message says of a text or path: it in quotes; anything else as it is."""
    return repr(os.fspath(given)) if isinstance(given, (str, os.PathLike)) else given


def read_bytes(path: str | Path, wanted: str, most: int = MOST_BYTES) -> bytes:
    """Return the content of a regular file.

    Devices, pipes and folders are refused before anything is read: some of them never end.

    Args:
        wanted: what the file should be, for the message.
        most: the largest size that is read [bytes].

    Raises:
        InputError: it cannot be opened, is no regular file, or is larger.
    """
    where = str(path)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except OSError as error:
        raise InputError("file", f"unreadable ({error.strerror})", wanted, where) from error
    except ValueError as error:  # a null character in the name
        raise InputError("file", f"unreadable ({error})", wanted, where) from error
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise InputError("file", "a folder, device or pipe", wanted, where)
    with os.fdopen(descriptor, "rb") as file:
        try:
            content = file.read(most + 1)
        except (OSError, MemoryError) as error:
            raise InputError("file", f"unreadable ({error})", wanted, where) from error
    if len(content) > most:
        raise InputError("file", f"larger than {most / 2**20:g} MiB", wanted, where)
    return content


def read_text(path: str | Path, wanted: str, most: int = MOST_BYTES) -> str:
    """Return the text of a regular file in UTF-8, without a byte order mark.

    Raises:
        InputError: as `read_bytes`, or it is not such text.
    """
    content = read_bytes(path, wanted, most)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("file", "not text in UTF-8", wanted, str(path)) from error
    if "\0" in text:
        raise InputError("file", "not text (it has null characters)", wanted, str(path))
    return text
