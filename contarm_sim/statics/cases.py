"""Cases of statics in bulk: who stands under what load, and which of them are solved together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.engine.models import structure
from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.statics.driving import DRIVEN

BUNCH = 128
"""Cases that are solved together: enough to share Python's own time, few enough for a processor's cache."""

CASES_A_THREAD = 16
"""Fewest cases of one structure that a thread is for: it makes a model of its own."""


@dataclass(frozen=True)
class Bunch:
    """Cases of one structure, driven alike.

    Attributes:
        places: of the cases among all.
        arms, loads: theirs.
        guesses: joint angles to start from [rad], or None.
    """

    places: NDArray[np.intp]
    arms: Sequence[Arm]
    loads: Sequence[Load]
    guesses: Sequence[Array] | None


def cases(arms: Any, loads: Any) -> tuple[Sequence[Arm], Sequence[Load]]:
    """Return an arm and a load for each case, of one or many each.

    Raises:
        InputError: arguments of another kind, or not as many arms as loads.
    """
    loads = Load() if loads is None else loads
    many = {}
    for name, given, kind in (("arms", arms, Arm), ("loads", loads, Load)):
        if not isinstance(given, kind):
            try:
                many[name] = list(given)
            except TypeError:
                raise InputError(name, repr(given), f"one {kind.__name__}, or a sequence of them") from None
            for each in many[name]:
                expect(name, each, kind)
    counts = {len(each) for each in many.values()}
    if len(counts) > 1:
        raise InputError("loads", f"{len(many['loads'])}", f"one, or as many as arms: {len(many['arms'])}")
    count = counts.pop() if counts else 1
    return many.get("arms", [arms] * count), many.get("loads", [loads] * count)


def guesses(guess: Any, count: int) -> Sequence[Array] | None:
    """Return joint angles to start from [rad] for each case, or None.

    Raises:
        InputError: no numbers, or not for each case.
    """
    if guess is None:
        return None
    allowed = f"shape (dofs,) or ({count}, dofs)"
    try:
        given = np.asarray(guess, dtype=float)
    except (TypeError, ValueError):
        raise InputError("guess", repr(guess), f"numbers of {allowed}") from None
    if given.ndim not in (1, 2) or (given.ndim == 2 and len(given) != count):
        raise InputError("guess", f"of shape {given.shape}", allowed)
    return list(np.broadcast_to(given, (count, given.shape[-1])))


def bunched(arms: Sequence[Arm], loads: Sequence[Load], given: Any, threads: int) -> list[Bunch]:
    """Return the cases in bunches of one structure, driven alike."""
    known: dict[tuple[int, str], list[int]] = {}
    alike: dict[Any, list[int]] = {}
    for case, (arm, load) in enumerate(zip(arms, loads, strict=True)):
        key = id(arm), load.muscles.kind
        if key not in known:
            pull_only, actuation = DRIVEN[load.muscles.kind]
            known[key] = alike.setdefault((pull_only, structure(arm, actuation)), [])
        known[key].append(case)
    made = []
    for cases in alike.values():
        parts = max(math.ceil(len(cases) / BUNCH), min(threads, len(cases) // CASES_A_THREAD))
        for own in np.array_split(np.array(cases), parts):
            part = own.tolist()
            guessed = None if given is None else [given[case] for case in part]
            made.append(Bunch(own, [arms[case] for case in part], [loads[case] for case in part], guessed))
    return made
