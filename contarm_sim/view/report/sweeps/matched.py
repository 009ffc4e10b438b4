"""Cases that may be compared: where some failed, those that did not are of other settings, and turn results round."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from contarm_sim.view.report.sweeps.columns import Column


class Matched(NamedTuple):
    """Cases of a grid that differ in one parameter alone.

    Attributes:
        rows: those that are of settings in which all levels have a value, shape (K,).
        settings: how many such settings of the other parameters there are.
        tried: how many settings there are.
    """

    rows: NDArray[np.bool_]
    settings: int
    tried: int


def matched(column: Column, others: list[Column], known: NDArray[Any]) -> Matched:
    """Return the cases of a grid by which levels of a parameter may be compared.

    Args:
        column: the parameter.
        others: the other parameters that vary.
        known: which cases have a value, shape (K,). A level at which none has one is not asked for.
    """
    level = _numbered(column)
    setting = np.zeros(len(level), dtype=int)
    for other in others:
        place = _numbered(other)
        setting = np.unique(setting * (place.max() + 1) + place, return_inverse=True)[1]
    has = np.zeros((setting.max() + 1, level.max() + 1), dtype=bool)
    has[setting[known], level[known]] = True
    asked = np.flatnonzero(has.any(axis=0))
    whole: NDArray[np.bool_] = np.asarray(has[:, asked].all(axis=1) & has.any(axis=1))
    return Matched(known & whole[setting], int(whole.sum()), len(whole))


def _numbered(column: Column) -> NDArray[Any]:
    values = column.values if column.numeric else column.values.astype(str)
    return np.asarray(np.unique(values, return_inverse=True)[1])
