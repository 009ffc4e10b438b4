"""What axes and scales of colours name: levels that were run, or else round numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.report.sweeps.columns import Column, Sorted, in_digits

_LETTER, _LINE = 1.65, 4.5
"""Width of a letter, and height of a line of text [mm]."""

_FIRSTS = ((1.0, 2.0, 5.0), (1.0, 3.0), (1.0,))
"""Numbers of a decade that are named, and what is named where there is less room."""


def round_numbers(low: float, high: float, log: bool, most: int) -> list[float]:
    """Return some round numbers within bounds: 1, 2 and 5 of each decade on a logarithmic scale, or fewer.

    The bounds themselves where nothing round is between them.
    """
    from matplotlib.ticker import MaxNLocator

    slack = 1e-9 * max(abs(low), abs(high))
    if log and high > 3 * low:
        decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
        sets = [[first * 10.0**decade for decade in decades for first in firsts] for firsts in _FIRSTS]
        sets = [[number for number in named if low - slack <= number <= high + slack] for named in sets]
        sets = [named for named in sets if len(named) > 1]
        if sets:
            named = next((named for named in sets if len(named) <= most), sets[-1])
            return named[:: -(-len(named) // max(most, 2))]
    evenly = MaxNLocator(max(most - 1, 1), steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    named = [float(number) for number in evenly if low - slack <= number <= high + slack]
    return named or [low, high]


def name_places(axis: Any, column: Column, groups: Sorted, room: float) -> None:
    """Name levels on an axis of their numbers, or, of bins and where names need more than the room [mm], round numbers.

    Texts are all named: they stand upright where they do not fit.
    """
    from matplotlib.ticker import NullLocator

    upwards = axis.axis_name == "y"
    axis.set_minor_locator(NullLocator())
    if not column.numeric:
        step = max(int(np.ceil(_LINE * groups.count / room)), 1)
        if not upwards and _size(groups.names) * groups.count > room:
            axis.set_tick_params(rotation=90)
        axis.set_ticks(np.arange(groups.count)[::step], groups.names[::step])
        return
    chosen = column.spaced is None or all(float(f"{level:.2g}") == float(f"{level:.12g}") for level in groups.at)
    if not groups.binned and chosen and (_LINE if upwards else _size(groups.names)) * groups.count <= room:
        axis.set_ticks(np.arange(groups.count), groups.names)
        return
    for most in range(10, 0, -1):
        numbers = round_numbers(groups.at[0], groups.at[-1], column.log, most)
        numbers = numbers if most > 1 else [numbers[0], numbers[-1]]
        names, places = [in_digits(number) for number in numbers], _placed(np.array(numbers), groups, column.log)
        if (_LINE if upwards else _size(names)) <= np.diff(places).min(initial=np.inf) * room / groups.count:
            break
    axis.set_ticks(places, names)


def _size(names: list[str]) -> float:
    """Return how far names beside each other have to be apart [mm]."""
    letters = np.array([len(name) for name in names])
    return _LETTER * (float(np.max(letters[1:] + letters[:-1], initial=letters[0])) / 2 + 1)


def _placed(numbers: Array, groups: Sorted, log: bool) -> Array:
    """Return the places of numbers between those of levels or edges."""
    of = np.log if log else np.asarray
    return np.interp(of(numbers), of(groups.at), np.arange(len(groups.at)) - 0.5 * groups.binned)


def name_numbers(axis: Any, shown: Array, log: bool, most: int) -> None:
    """Name round numbers on an axis in true scale, or on a scale of colours."""
    from matplotlib.ticker import NullFormatter

    numbers = round_numbers(float(np.min(shown)), float(np.max(shown)), log, most)
    axis.set_ticks(numbers, labels=[in_digits(number) for number in numbers])
    axis.set_minor_formatter(NullFormatter())
