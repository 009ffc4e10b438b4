"""Models of many arms as one of MuJoCo Warp's, whose fields have a leading axis of arms where they differ."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import mujoco
import numpy as np

from contarm_sim.engine.warp_library import library
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array

_UNUSED = ("geom_", "mat_", "cam_", "light_", "pair_", "dof_length", "opt", "stat")
"""What fields begin with that steps never read here: arms in the engine touch nothing, sleep not, and are not drawn."""

_OPTIONS = ("timestep", "gravity")
"""Options that differ from arm to arm."""

_IN_WORDS = {"wrap_prm": "the places of muscles along the backbone"}
"""What fields of which there is one for all arms mean."""

_ALWAYS = ("jnt_stiffness",)
"""Fields that are written during motions."""


class WarpModels:
    """Models of B arms on the present device.

    Attributes:
        model: MuJoCo Warp's.

    Raises:
        InputError: they differ in what MuJoCo Warp keeps once for all arms.
    """

    def __init__(self, models: Sequence[mujoco.MjModel]) -> None:
        self._wp, self._mjw = library()
        once, per_arm = _kept(models[0])
        self._batched = [name for name in per_arm if name in _ALWAYS or not _alike(models, name)]
        self._once = {name: copy.copy(getattr(models[0], name)) for name in once}
        self._alike = {name: getattr(models[0], name).copy() for name in per_arm if name not in self._batched}
        self._check(models)
        # At least one row: without any, MuJoCo Warp 3.17 skips its solver, which computes what `implicitfast` needs.
        self._rows = max(1, *map(_constraints, models))
        self._template = _template(models)
        self.model = self._mjw.put_model(self._template, dict.fromkeys(self._batched, len(models)))
        for name in _OPTIONS:
            array = getattr(self.model.opt, name)
            shape = (len(models), *array.numpy().shape[1:])
            setattr(self.model.opt, name, self._wp.array(np.zeros(shape, np.float32), dtype=array.dtype))
        self._write(models)

    def _check(self, models: Sequence[mujoco.MjModel]) -> None:
        for name, first in self._once.items():
            if not _alike(models, name, first):
                what = _IN_WORDS.get(name, f"the engine's {name}")
                raise InputError("arms", f"arms that differ in {what}", "arms alike in that, on the backend warp")

    def data(self, count: int) -> Any:
        """Return room for the states of so many arms on the device."""
        return self._mjw.make_data(self._template, nworld=count, nconmax=0, njmax=self._rows)

    def take(self, models: Sequence[mujoco.MjModel]) -> bool:
        """Take other parameters in place, if what was alike is alike still; return whether that was so.

        Raises:
            InputError: as above.
        """
        self._check(models)
        same = all(_alike(models, name, first) for name, first in self._alike.items())
        if not same or max(map(_constraints, models)) > self._rows:
            return False
        self._write(models)
        return True

    def _write(self, models: Sequence[mujoco.MjModel]) -> None:
        for name in _OPTIONS:
            _assign(getattr(self.model.opt, name), np.stack([getattr(model.opt, name) for model in models]))
        for name in self._batched:
            self.write(name, np.stack([getattr(model, name) for model in models]))

    def write(self, name: str, values: Array) -> None:
        """Write a field of all arms, shape (B, ...)."""
        _assign(getattr(self.model, name), values)


def kept_once(model: mujoco.MjModel) -> list[str]:
    """Return the fields that MuJoCo Warp keeps once for all arms."""
    return _kept(model)[0]


def _kept(model: mujoco.MjModel) -> tuple[list[str], list[str]]:
    """Return which of a model's fields are kept once for all arms, and which may be kept for each."""
    kinds = [one for one in fields(library()[1].Model) if not one.name.startswith(_UNUSED)]
    shapes = {one.name: getattr(one.type, "shape", None) for one in kinds if hasattr(model, one.name)}
    per_arm = [name for name, shape in shapes.items() if shape and shape[0] == "*"]
    return [name for name in shapes if name not in per_arm], per_arm


def _assign(array: Any, values: Array) -> None:
    array.assign(np.ascontiguousarray(values, dtype=np.float32).reshape(array.numpy().shape))


def _alike(models: Sequence[mujoco.MjModel], name: str, first: Any = None) -> bool:
    """Whether a field of all models is that of the first, or the value given."""
    one = getattr(models[0], name) if first is None else first
    return all(np.array_equal(getattr(model, name), one) for model in dict.fromkeys(models))


def _template(models: Sequence[mujoco.MjModel]) -> mujoco.MjModel:
    """Return a model with all that any of them has: what is zero in it would be left out of every step."""
    template = copy.copy(models[0])
    for name in ("tendon_stiffness", "tendon_damping"):
        getattr(template, name)[:] = np.max([getattr(model, name) for model in models], axis=0)
    return template


def _constraints(model: mujoco.MjModel) -> int:
    """Return how many rows dry friction and limits take at most."""
    rubbing = np.count_nonzero(model.dof_frictionloss) + np.count_nonzero(model.tendon_frictionloss)
    return int(rubbing + 2 * np.count_nonzero(model.jnt_limited) + 2 * np.count_nonzero(model.tendon_limited))
