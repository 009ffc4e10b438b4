"""Names of files and folders that users hand to methods."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError


def as_path(name: str, given: Any, allowed: str) -> Path:
    """Return a path.

    Raises:
        InputError: it is none, or has a null character, which no system takes.
    """
    if not isinstance(given, (str, os.PathLike)) or "\0" in os.fspath(given):
        raise InputError(name, repr(given), allowed)
    return Path(given)
