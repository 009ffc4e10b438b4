"""The layout of a model: what arms must have in common to be stepped together."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from contarm_sim.engine.models import Built

_SIZES = (
    "nq", "nv", "na", "nu", "nbody", "njnt", "ngeom", "nsite", "ntendon", "nwrap", "nsensor", "nsensordata", "neq",
    "nmocap", "nuserdata", "nplugin", "nJten", "nJmom", "nM", "nC", "nD", "nB", "nbvh", "ntree",
)  # fmt: skip

_PER_ARM = ("zero", "by_angle")


def layout(own: Built) -> tuple[Any, ...]:
    """Return what is alike in models that go into one batch: sizes of the engine's data, and where the parts are.

    It may be compared and hashed. Arms of other link counts, routings, or actuators have others; so have arms with and
    without a payload, which is a body of its own form.
    """
    sizes = tuple(getattr(own.model, name, 0) for name in _SIZES)
    places = (getattr(own.index, field.name) for field in fields(own.index) if field.name not in _PER_ARM)
    return sizes, tuple(_plain(place) for place in places)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.shape, value.dtype.str, value.tobytes()
    if isinstance(value, dict):
        return tuple((key, _plain(one)) for key, one in value.items())
    if isinstance(value, slice):
        return value.start, value.stop
    return tuple(map(_plain, value)) if isinstance(value, tuple) else value
