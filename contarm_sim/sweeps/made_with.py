"""What a table is made with: the last digits depend on it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path

from contarm_sim.sweeps.spec import FORMAT, Spec
from contarm_sim.versions import versions

CODE = "code"
"""The name of what stands for this package's sources."""

_DEPENDS = ("contarm-sim", "mujoco", "numpy", "scipy")

_APART = ("cli", "envs", "view", "sweeps/specs")
"""Folders of this package that no number of a table depends on."""


def made_with() -> dict[str, str]:
    """Return what all tables are made with, by name."""
    made = {"format": str(FORMAT)} | {name: versions()[name] for name in _DEPENDS}
    return made | {"pyarrow": version("pyarrow"), CODE: _code()}  # pyarrow writes its version into every part


def device_of(spec: Spec) -> str:
    """Return what steps the motions of a sweep in words, where that is no matter of the versions above alone.

    Raises:
        MissingError: the backend is not installed.
    """
    if spec.backend == "cpu":
        return ""
    from contarm_sim.engine.warp_library import made_by

    return made_by()


def changed(theirs: Mapping[str, str | None], mine: Mapping[str, str | None]) -> list[str]:
    """Return what differs from mine, in words."""
    return [
        "the code of contarm-sim has changed"
        if name == CODE
        else f"{name} {theirs.get(name) or 'unknown'} there, {own} here"
        for name, own in mine.items()
        if theirs.get(name) != own
    ]


@cache
def _code() -> str:
    """Return a hash of the sources that numbers depend on, 16 hexadecimal digits."""
    root, found = Path(__file__).parents[1], hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        name = path.relative_to(root).as_posix()
        if not name.startswith(_APART):
            found.update(f"{name}\n".encode() + path.read_bytes())
    return found.hexdigest()[:16]
