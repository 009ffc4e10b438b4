"""The path that `contarm run` follows: one of the shapes by name, or a file of waypoints."""

from __future__ import annotations

import os
from typing import Any

from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.model.arm import Arm

_SHAPE = {
    "spiral": {"turns", "max_bend"},
    "sphere-spiral": {"turns", "max_bend", "sphere_radius", "sphere_centre"},
    "circle": {"max_bend"},
    "line": {"max_bend"},
    "figure-eight": {"max_bend"},
}


def parameters_of(arm: Arm, name: str, given: dict[str, Any]) -> dict[str, Any]:
    """Return all parameters of a path, those that were not given with their defaults."""
    from inspect import signature

    from contarm_sim import paths

    known = signature(paths.named).parameters
    defaults = {flag: known[flag].default for flag in sorted(_SHAPE.get(name, ()))}
    if "sphere_radius" in defaults:
        defaults["sphere_radius"] = arm.length
    return defaults | given


def path_of(arm: Arm, name: str, duration: float | None, shape: dict[str, Any]) -> tuple[Any, Any]:
    """Return a path, and the waypoints that it goes through where these come from a file."""
    from contarm_sim import paths
    from contarm_sim.paths.waypoints import from_waypoints, read_csv

    for flag in shape:
        if flag not in _SHAPE.get(name, set()):
            known = ", ".join(sorted(_SHAPE.get(name, set()))) or "no such flag"
            raise InputError(flag, shape[flag], f"for path {name!r}: {known}")
    if name in paths.NAMES:
        return paths.named(name, arm.length, 10.0 if duration is None else duration, **shape), None
    if not name.endswith(".csv") and not os.path.isfile(name):
        raise InputError("path", repr(name), ", ".join(paths.NAMES) + ", or a CSV file")
    waypoints = read_csv(name)
    return from_waypoints(waypoints, arm.length, duration, on_dome=len(arm.sections) == 1), waypoints


def reference_of(arm: Arm, path: Any, project: Any, places: list[str] | None, direction: Any = None) -> Any:
    """Return the motion along a path; `places` are those of its waypoints, for messages."""
    from contarm_sim.cli.ik import asking
    from contarm_sim.paths.reference import Reference

    try:
        return Reference.from_path(path, arm, project=project, direction=direction)
    except UnreachableError as error:
        where = error.where if places is None else places[0].split(", row")[0]
        raise asking(error, arm).located(where) from None
