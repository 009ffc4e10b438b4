"""A sweep as TOML: in full, parameters in their order, one line for each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from contarm_sim.sweeps.spec import Spec

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def as_toml(spec: Spec, made: Mapping[str, Any]) -> str:
    """Return a sweep as TOML that `sweeps.read` reads back to the same cases.

    Args:
        made: what a table [made] says, which is no part of it.
    """
    tables = spec.to_dict()
    lines = [f"{name} = {_value(value)}" for name, value in tables.items() if not isinstance(value, dict)]
    for name in ("fixed", "vary"):
        if name in tables:
            lines += ["", f"[{name}]", *(f"{_key(key)} = {_value(value)}" for key, value in tables[name].items())]
    return "\n".join([*lines, *_table("arm", tables["arm"]), *_table("made", made)]) + "\n"


def _table(name: str, table: Mapping[str, Any], double: bool = False) -> list[str]:
    """Return the lines of a table, and then those of tables in it."""
    lines = ["", f"[[{name}]]" if double else f"[{name}]"]
    lines += [f"{_key(key)} = {_value(value)}" for key, value in table.items() if not _tables(value)]
    for key, value in table.items():
        if _tables(value):
            for each in value if isinstance(value, list) else [value]:
                lines += _table(f"{name}.{_key(key)}", each, isinstance(value, list))
    return lines


def _tables(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else f'"{name}"'


def _value(value: Any) -> str:
    """Return a value on one line."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {_value(each)}' for key, each in value.items())} }}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    import tomli_w

    return tomli_w.dumps({"x": value}).removeprefix("x = ").rstrip("\n")
