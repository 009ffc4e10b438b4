"""The table [world] of TOML: a user's own MJCF, and where the arm is attached to it."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.host import Host
from contarm_sim.model.muscle_table import plain, refuse_unknown

HOST = [item.name for item in fields(Host)]
"""Keys of [world]."""

HOST_UNITS = {item.name: item.metadata["unit"] for item in fields(Host) if item.metadata}
"""Units of those that have one."""


def host_from_table(table: Any, folder: Path | None = None) -> Host:
    """Return a host.

    Args:
        table: what [world] holds.
        folder: that its file is named from; default the current one.

    Raises:
        InputError: an unknown key (with the nearest known one), or a bad value.
    """
    if not isinstance(table, dict):
        raise InputError("world", table, "a table, [world], with file and site")
    refuse_unknown(table, HOST, "world.")
    if not isinstance(table.get("file"), str):
        raise InputError("world.file", table.get("file", "missing"), "an MJCF file, .xml")
    file = Path(table["file"]).expanduser()
    return Host(**{**table, "file": str(file if folder is None else folder / file)})


def host_to_table(host: Host) -> dict[str, Any]:
    """Return [world], what `host_from_table` reads; what is usual is left out."""
    usual = {item.name: item.default for item in fields(host)}
    return plain({name: x for name, x in vars(host).items() if x != usual[name]})
