"""When a user's own MJCF was written, and the files that it includes: what tells that it has to be read anew."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

Stamp = tuple[str, int, int]
"""A file, when it was written [ns], and its size: tell one that was written again."""


def stamps(file: str) -> tuple[Stamp, ...]:
    """Return the stamps of a file and of those that it includes."""
    return tuple(_stamps(file, Path(file).parent, set()))


def _stamps(file: str, folder: Path, seen: set[str]) -> Iterator[Stamp]:
    """Yield the stamps of a file and of those that it includes, named from its own folder or the first's, each once."""
    seen.add(file)
    status = os.stat(file)
    stamp = (file, status.st_mtime_ns, status.st_size)
    yield stamp
    for name in _included(*stamp):
        for part in (str(Path(file).parent / name), str(folder / name)):
            if part not in seen and os.path.isfile(part):
                yield from _stamps(part, folder, seen)


@lru_cache(maxsize=64)
def _included(file: str, changed: int, size: int) -> tuple[str, ...]:
    """Return the models that a file names: nothing of one that is no XML, which MuJoCo refuses."""
    try:
        tree = ElementTree.parse(file)
    except (ElementTree.ParseError, ValueError):
        return ()
    return tuple(part.get("file", "") for part in tree.iter() if part.tag in ("include", "model"))
