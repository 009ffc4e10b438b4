"""An arm as TOML: the names are those of `Arm`, muscle parameters in a [muscle] table, SI units."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm, Muscle


def arm_from_dict(values: dict[str, Any], where: str | None = None, base: Arm | None = None) -> Arm:
    """Return `base` (default: `Arm()`) with the given parameters changed.

    Args:
        values: parameters by name; `muscle` holds a dict of its own.
        where: the file the values came from, for error messages.

    Raises:
        InputError: an unknown name (with the nearest known one), or a value out of range.
    """
    base = base or Arm()
    values = dict(values)
    muscle = values.pop("muscle", {})
    if not isinstance(muscle, dict):
        raise InputError("muscle", repr(muscle), "a table, [muscle]", where)
    _refuse_unknown(values, Arm, "", where)
    _refuse_unknown(muscle, Muscle, "muscle.", where)
    try:
        return Arm(**{**_own(base), **values, "muscle": Muscle(**{**_own(base.muscle), **muscle})})
    except InputError as error:
        raise error.located(where) from None


def _own(owner: Arm | Muscle) -> dict[str, Any]:
    return {item.name: getattr(owner, item.name) for item in fields(owner)}


def _refuse_unknown(values: dict[str, Any], kind: type, prefix: str, where: str | None) -> None:
    known = [item.name for item in fields(kind)]
    for name in values:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
            raise InputError(
                f"key {prefix + name!r}", "unknown", f"did you mean {prefix + near!r}? All: {', '.join(known)}", where
            )


def arm_to_dict(arm: Arm) -> dict[str, Any]:
    """Return the arm's parameters as plain values; omitted options are left out."""
    return _plain(asdict(arm))


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    plain: dict[str, Any] = {}
    for key, value in values.items():
        if isinstance(value, dict):
            plain[key] = _plain(value)
        elif value is not None:
            plain[key] = list(value) if isinstance(value, tuple) else value
    return plain


def load_arm(path: str | Path) -> Arm:
    """Read an arm from a TOML file.

    Raises:
        InputError: the file cannot be read, is not TOML, or holds an unknown key or a bad value.
    """
    try:
        text = Path(path).read_bytes().decode("utf-8-sig")
        return arm_from_dict(tomllib.loads(text), str(path))
    except OSError as error:
        raise InputError("file", f"unreadable ({error.strerror})", "a TOML file", str(path)) from error
    except UnicodeDecodeError as error:
        raise InputError("file", "not text", "a TOML file", str(path)) from error
    except (ValueError, RecursionError) as error:  # TOMLDecodeError is a ValueError, as is a number of 5000 digits
        raise InputError("file", f"not TOML ({error})", "lines such as: length = 0.37", str(path)) from error


def arm_to_toml(arm: Arm) -> str:
    """Return the arm as TOML text; `load_arm` reads it back to an equal arm."""
    import tomli_w

    return tomli_w.dumps(arm_to_dict(arm))
