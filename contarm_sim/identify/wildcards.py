"""Names of free parameters with a star: one name for several of a kind.

section_*.bending_stiffness    of each section, a value each
actuation.slack_*              of each muscle, marker_*.offset.z of each marker
frame.*                        x, y and z; frame.turn_* likewise

A star stands for a number, or for an axis.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from contarm_sim.errors import InputError, did_you_mean


def spread(name: str, *known: Iterable[str]) -> list[str]:
    """Return the known names that a name, perhaps with stars, stands for, in their order.

    Args:
        known: names; of several lists the first that has any.

    Raises:
        InputError: none; says the nearest.
    """
    lists = [list(names) for names in known]
    every = lists[0]
    pattern = re.compile("(?:[0-9]+|[xyz])".join(map(re.escape, name.split("*"))))
    found = next((own for names in lists if (own := [one for one in names if pattern.fullmatch(one)])), [])
    alone = re.sub(r"^section_(\*|1)\.", "", name)
    several = any(one.startswith("section_2.") for one in every)
    if not found and not several and alone in every:  # an arm of one section
        found = [alone]
    if not found:
        near = (did_you_mean(name, families(every)), did_you_mean(name.replace("*", "1"), every))
        asked = next((one for one in (*near, did_you_mean(alone, every)) if one), "")
        asked = "did you mean 'muscle.offset'? It turns all. " if alone == "muscle.angle" else asked
        star = "A star stands for a number, or for an axis. " if "*" in name else ""
        raise InputError(f"parameter {name!r}", "unknown", f"{asked}{star}contarm fit ARM.toml --names lists all")
    return found


def families(known: Iterable[str]) -> dict[str, list[str]]:
    """Return what names with a star stand for, by these names: those that stand for two or more."""
    found: dict[str, list[str]] = {}
    for name in known:
        for starred in {re.sub(r"_\d+", "_*", name), re.sub(r"(?<=[._])[xyz]$", "*", name)} - {name}:
            found.setdefault(starred, []).append(name)
    return {starred: names for starred, names in found.items() if len(names) > 1}
