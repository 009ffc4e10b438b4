"""Which parameters of an arm are uncertain, and how: read from TOML, drawn as cases.

    cases = 128        # arms that are drawn; default 128
    seed = 0           # the same seed draws the same arms
    [vary]
    bending_stiffness = { distribution = "normal", mean = 0.1, std = "10 %" }
    muscle.wall = { distribution = "uniform", low = "1.9 mm", high = "2.1 mm" }

Parameters are drawn independently of each other, by scrambled Sobol points through their quantiles: the same number of
cases says more of a distribution than random ones do.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.inputs import quoted, read_text
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.muscle_table import refuse_unknown
from contarm_sim.model.named import Named, find, named_parameters, with_parameters
from contarm_sim.sweeps.designs import points
from contarm_sim.sweeps.distributions import Normal, Varied, varied_from
from contarm_sim.sweeps.keys import by_full_names, whole_number

CASES = 128
"""Arms that are drawn unless a file says otherwise."""

FEWEST, MOST = 8, 65_536
"""Least and most arms that may be drawn."""

_KEYS = ("cases", "seed", "vary")
_EXAMPLE = '{ distribution = "normal", mean = 0.1, std = "10 %" }'


@dataclass(frozen=True)
class Uncertain:
    """Uncertain parameters of an arm, and how many arms are drawn.

    Attributes:
        arm: the nominal arm.
        vary: what each uncertain parameter may be, by its name.
        cases, seed: how many arms are drawn, from which random numbers.
    """

    arm: Arm
    vary: dict[str, Varied]
    cases: int = CASES
    seed: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the uncertain parameters."""
        return tuple(self.vary)

    @property
    def parameters(self) -> dict[str, Named]:
        """The uncertain parameters by name."""
        known = named_parameters(self.arm)
        return {name: known[name] for name in self.vary}

    @cached_property
    def shares(self) -> Array:
        """Sobol points, shape (cases, parameters): which share of its values is below that of a case."""
        return points("sobol", self.cases, len(self.vary), self.seed, 0, self.cases)

    @cached_property
    def values(self) -> dict[str, list[Any]]:
        """Values of each parameter in all cases."""
        return {name: one.at(self.shares[:, i]) for i, (name, one) in enumerate(self.vary.items())}

    @cached_property
    def arms(self) -> tuple[Arm, ...]:
        """The arms that are drawn.

        Raises:
            InputError: no arm can have one of the values.
        """
        made = []
        for case in range(self.cases):
            drawn = {name: values[case] for name, values in self.values.items()}
            try:
                made.append(with_parameters(self.arm, drawn))
            except InputError as error:
                said = f"{error.given}, drawn in case {case + 1} of {self.cases}"
                advice = f"{error.allowed}; least and most cut a distribution off"
                raise InputError(error.name, said, advice, error.where) from None
        return tuple(made)

    @property
    def standard(self) -> tuple[Array, list[bool]]:
        """Coordinates for polynomials, (cases, parameters): standard normal, or uniform on -1..1; and which are normal.

        A parameter of a normal or lognormal distribution has a normal one.
        """
        from scipy.special import ndtri

        normal = [isinstance(one, Normal) for one in self.vary.values()]
        return np.where(normal, ndtri(self.shares), 2 * self.shares - 1), normal


def read_uncertain(given: str | Path | Mapping[str, Any], arm: Arm) -> Uncertain:
    """Return the uncertain parameters of an arm that a TOML file, or a mapping of the same form, describes.

    Raises:
        InputError: no such file, an unknown key or parameter (with the nearest one), a distribution without its
            numbers, or one that draws an arm that cannot be.
    """
    if isinstance(given, Mapping):
        return _made(given, arm)
    wanted = "a TOML file of uncertain parameters, with a table [vary]"
    try:
        table = tomllib.loads(read_text(given, wanted))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError("file", f"not TOML ({error})", wanted, str(given)) from None
    try:
        return _made(table, arm)
    except InputError as error:
        raise error.located(error.where or str(given)) from None


def _made(table: Mapping[str, Any], arm: Arm) -> Uncertain:
    refuse_unknown(table, _KEYS)
    cases = whole_number("cases", table.get("cases", CASES), FEWEST, MOST)
    seed = whole_number("seed", table.get("seed", 0), 0, 2**32 - 1)
    asked = table.get("vary")
    if not isinstance(asked, Mapping) or not asked:
        raise InputError("vary", "missing" if asked is None else asked, f"a table of parameters, each {_EXAMPLE}")
    known, vary = named_parameters(arm), {}
    for name, value in by_full_names(asked, "vary", known).items():
        one = find(name, known)
        if not isinstance(one.value(arm), (int, float)):
            kind = "a text" if isinstance(one.value(arm), str) else "a vector"
            raise InputError(name, f"{kind}, which cannot be uncertain", "parameters that are numbers")
        if not isinstance(value, Mapping) or "distribution" not in value:
            raise InputError(name, quoted(value), f"a distribution: {_EXAMPLE}")
        vary[name] = varied_from(dict(value), name, one.unit)
    made = Uncertain(arm, vary, cases, seed)
    assert made.arms  # refused here, before anything is simulated
    return made
