"""An arm as TOML: the names are those of `Arm`, muscle parameters in a [muscle] table, SI units."""

from __future__ import annotations

import difflib
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS
from contarm_sim.model.routing import Routing

_ROUTED = ("count", "offset")
"""Keys of [muscle] beside the parameters that are flags: of the routing, left out where they are the default's."""


def arm_from_dict(values: dict[str, Any], where: str | None = None, base: Arm | None = None) -> Arm:
    """Return `base` (default: `Arm()`), an arm of one section, with the given parameters changed.

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
    _refuse_unknown(values, [*PARAMETERS, "muscle"], "", where)
    _refuse_unknown(muscle, [*MUSCLE_PARAMETERS, *_ROUTED], "muscle.", where)
    try:
        routed = {name: muscle[name] for name in ("path", *_ROUTED) if name in muscle}
        law = {name: value for name, value in muscle.items() if name not in routed}
        routing = replace(base.routing, **routed)
        return replace(base, routings=(routing,), laws=(replace(base.laws[0], **law),), **values)
    except InputError as error:
        raise error.located(where) from None


def _refuse_unknown(values: dict[str, Any], known: list[str], prefix: str, where: str | None) -> None:
    for name in values:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
            raise InputError(
                f"key {prefix + name!r}", "unknown", f"did you mean {prefix + near!r}? All: {', '.join(known)}", where
            )


def arm_to_dict(arm: Arm) -> dict[str, Any]:
    """Return the parameters of an arm of one section as plain values; omitted options are left out.

    Raises:
        InputError: an arm of several sections.
    """
    routing, usual = arm.routing, Routing()
    muscle = {**{name: getattr(arm.muscle, name) for name in MUSCLE_PARAMETERS if name != "path"}, "path": routing.path}
    muscle |= {name: getattr(routing, name) for name in _ROUTED if getattr(routing, name) != getattr(usual, name)}
    return _plain({name: getattr(arm, name) for name in PARAMETERS}) | {"muscle": _plain(muscle)}


def _plain(values: dict[str, Any]) -> dict[str, Any]:
    given = {key: value for key, value in values.items() if value is not None}
    return {key: list(value) if isinstance(value, tuple) else value for key, value in given.items()}


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
