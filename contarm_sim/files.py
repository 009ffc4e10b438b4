"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from contarm_sim.stopping import unbroken


def scratch_name(target: Path) -> Path:
    """Return a hidden name beside `target` that nobody can guess, with the same ending."""
    return target.with_name(f".{target.stem[:30]}-{os.urandom(8).hex()}{target.suffix[:16]}")


@contextmanager
def appearing(target: Path) -> Iterator[Path]:
    """Yield a path beside `target` to write to; it becomes `target` when all went well, and is removed otherwise.

    The file is there already, empty, made new (no link is followed) and with the permissions that `open` gives.

    Raises:
        OSError: it cannot be made, or cannot take its name.
    """
    scratch = scratch_name(target)
    try:
        os.close(os.open(scratch, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666))
        yield scratch
        os.replace(scratch, target)
    except BaseException:
        with unbroken():
            scratch.unlink(missing_ok=True)
        raise


def write_whole(target: Path, text: str) -> None:
    """Write a text file (UTF-8) in place of what `target` held, if anything, in one stroke.

    Raises:
        OSError: as `appearing`.
    """
    with appearing(target) as scratch:
        scratch.write_text(text, encoding="utf-8")
