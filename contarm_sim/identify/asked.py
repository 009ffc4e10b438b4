"""What is asked of a fit, as people write it: names with stars, quantities with units, blocks or a share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.identify.freedom import Free, free_names
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.identify.wildcards import spread
from contarm_sim.model.arm import Arm
from contarm_sim.model.units import quantity

Numbers = Iterable[tuple[str, str, str]]
"""A name and two quantities each."""


def units_of(arm: Arm, rigs: Sequence[Rig]) -> dict[str, str]:
    """Return the units of all parameters that may be free, by name: of an arm, and of its rigs."""
    return {name: unit for rig in rigs for name, unit in free_names(arm, rig).items()}


def free_of(names: Iterable[str], units: Mapping[str, str], bounds: Numbers = (), priors: Numbers = ()) -> list[Free]:
    """Return free parameters, with bounds and priors in SI units.

    Args:
        names: with stars or without.
        units: of all parameters that may be free, see `units_of`.
        bounds: a name, low and high, each with a unit or without.
        priors: a name, mean and standard deviation, likewise.

    Raises:
        InputError: an unknown name, no quantity of the unit, or a bound or prior of what is not free.
    """
    given: dict[str, dict[str, float]] = {one: {} for name in names for one in spread(name, units)}
    for option, keys, rows in (("--bounds", ("low", "high"), bounds), ("--prior", ("mean", "sd"), priors)):
        for name, *texts in rows:
            for one in spread(name, units):
                if one not in given:
                    raise InputError(f"{option} {name}", "of a parameter that is not free", ", ".join(given))
                unit = units[one].removesuffix("/command")
                values = [quantity(text, unit, f"{option} {name}") for text in texts]
                given[one] |= dict(zip(keys, values, strict=True))
    return [Free(name=name, **known) for name, known in given.items()]


def held_out_from(text: str | None, recordings: Iterable[Recording]) -> Any:
    """Return the names of blocks, or the share of samples, that a text says: "circle*,line 3", "0.25", "25%".

    Blocks win: "2" is the block of that name where there is one.

    Raises:
        InputError: a share that holds nothing or everything out.
    """
    if text is None:
        return ()
    names = tuple(name.strip() for name in text.split(","))
    blocks = list(dict.fromkeys(block for one in recordings for block in one.blocks.tolist()))
    if set(names) <= set(blocks):
        return names
    try:
        share = float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return names
    if not 0 < share < 1:
        some = ", ".join(blocks[:8]) + (", ..." if len(blocks) > 8 else "")
        raise InputError("--hold-out", text, f"a fraction above 0 and below 1 (25%), or blocks: {some}")
    return share
