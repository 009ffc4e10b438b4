"""The tables [[object]] of TOML: what an arm can touch."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.muscle_table import plain, refuse_unknown
from contarm_sim.model.objects import MAX_OBJECTS, SIZED_BY, Object, said_of_object

OBJECT = [item.name for item in fields(Object)]
"""Keys of [[object]]."""

OBJECT_UNITS = {item.name: item.metadata["unit"] for item in fields(Object) if item.metadata}
"""Units of those that have one."""


def objects_from_tables(tables: Any, folder: Path | None = None) -> tuple[Object, ...]:
    """Return the objects of a world.

    Args:
        tables: what [[object]] holds, a list of dicts.
        folder: that files of meshes are named from; default the current one.

    Raises:
        InputError: an unknown key (with the nearest known one), or a bad value; says of which object.
    """
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise InputError("object", tables, "tables, [[object]], one for each object")
    if len(tables) > MAX_OBJECTS:
        raise InputError("object", f"{len(tables)} tables", f"at most {MAX_OBJECTS}")
    return tuple(_object(number, table, folder) for number, table in enumerate(tables))


def _object(number: int, table: dict[str, Any], folder: Path | None) -> Object:
    where = said_of_object(table.get("name", number + 1)) if "name" in table else f"object {number + 1}"
    try:
        refuse_unknown(table, OBJECT, "")
        for name in ("name", "shape"):
            if name not in table:
                allowed = "a name of its own" if name == "name" else ", ".join(SIZED_BY)
                raise InputError(name, "missing", allowed)
    except InputError as error:
        raise error.located(where) from None
    values = dict(table)
    if folder is not None and isinstance(values.get("file"), str):
        file = values["file"]
        values["file"] = str(_found(folder, file, f"{values['name']}{Path(file).suffix.lower()}"))
    return Object(**values)


def _found(folder: Path, file: str, beside: str) -> Path:
    """Return the file of a mesh: as it is named, or a copy beside where what was named is there no longer."""
    named, copied = (folder / file).resolve(), folder / beside
    try:
        return copied.resolve() if not named.is_file() and copied.is_file() else named
    except ValueError:  # a null character
        return Path(file)


def objects_to_tables(objects: tuple[Object, ...], beside: bool = False) -> list[dict[str, Any]]:
    """Return [[object]] of a world, what `objects_from_tables` reads; what is usual is left out.

    Args:
        beside: name meshes as the copies that lie beside the file.
    """
    usual = {item.name: item.default for item in fields(Object)}
    every = [vars(each) | ({"file": each.beside} if beside else {}) for each in objects]
    return [plain({name: x for name, x in each.items() if x != usual[name]}) for each in every]
