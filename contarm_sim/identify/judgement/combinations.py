"""In words: which parameters may change together unseen, and what of them is determined."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contarm_sim.identify.fitted import Combination
from contarm_sim.kinematics.arrays import Array

PART = 0.1
"""Of the largest part in a direction, what takes part in it at least."""
SMALL_PART = 0.01
"""The same where nothing takes such a part."""
UNBOUNDED = 3.0
"""Scales beyond which nothing is said of how far a direction is open."""
READ = {"m": (1e3, "mm"), "rad": (180 / math.pi, "deg")}
"""Units that are read in others, and the factors."""
NEAR = 0.03
"""How near a power must be to a simple one to be called by it."""


@dataclass(frozen=True, eq=False)
class Direction:
    """How elements of the vector follow one that is held.

    Attributes:
        names, units, logarithmic: of all P parameters.
        scales: of all.
        held: number of the one that is held.
        follows: how all move with it, in the vector, shape (P,); 1 at itself.
        sd: along it, in steps of the scales.
    """

    names: Sequence[str]
    units: Sequence[str]
    logarithmic: Sequence[bool]
    scales: Array
    held: int
    follows: Array
    sd: float

    @property
    def scaled(self) -> Array:
        """In steps of the scales, of length 1, shape (P,)."""
        out = self.follows / self.scales
        return np.asarray(out / np.linalg.norm(out))

    @property
    def members(self) -> list[int]:
        """Numbers of the parameters that take part besides the held one, the largest part first."""
        parts = np.abs(self.scaled)
        order = sorted(range(len(parts)), key=lambda place: (-round(float(parts[place]), 6), place))
        others = [(place, parts[place] / parts.max()) for place in order if place != self.held]
        least = PART if any(part > PART for _, part in others) else SMALL_PART
        return [place for place, part in others if part > least]

    def combination(self) -> Combination:
        """Return it with its words."""
        own = sorted([self.held, *self.members], key=lambda place: (-round(abs(float(self.scaled[place])), 3), place))
        return Combination(
            tuple(self.names[place] for place in own), tuple(float(self.scaled[place]) for place in own), self.sd,
            self.said()
        )  # fmt: skip

    def said(self) -> str:
        """Return what may change together, and what of it is determined."""
        name, members = self.names[self.held], self.members
        if not members:
            if math.isinf(self.sd):
                return f"{name} changes nothing that was measured"
            if self.sd <= 1:
                return f"{name} was held"
            return f"{name} changes too little of what was measured: it may be off by {self._far()}"
        every, powers = [self.names[place] for place in sorted([*members, self.held])], self._powers(members)
        kinds = {bool(self.logarithmic[place]) for place in [*members, self.held]}
        factors = kinds == {True}
        alike = factors or (kinds == {False} and len({self.units[place] for place in [*members, self.held]}) == 1)
        amount = self._far()
        if alike and all(power == 1 for power in powers):
            what = ("ratio" if factors else "difference") + ("" if len(members) == 1 else "s")
            verb = "is" if len(members) == 1 else "are"
            return f"{listed(every)} may grow together by {amount}: only their {what} {verb} determined"
        if alike and powers == [-1]:
            what = "product" if factors else "sum"
            other = self.names[members[0]]
            return f"{name} may grow by {amount} while {other} falls by as much: only their {what} is determined"
        follow = listed([self.determined(place) for place in members])
        verb = "is" if len(members) == 1 else "are"
        others = listed([self.names[place] for place in members])
        with_it = "changes with it" if len(members) == 1 else "change with it"
        return f"{name} may change by {amount} if {others} {with_it}: only {follow} {verb} determined"

    def determined(self, member: int) -> str:
        """Return what is determined of a member that follows the held one alone."""
        factors = bool(self.logarithmic[member] and self.logarithmic[self.held])
        name = self.names[member]
        return (name if factors or not self.logarithmic[member] else f"ln({name})") + self.term(member, factors)

    def term(self, member: int, factors: bool) -> str:
        """Return what is taken off a member, in words, so that the rest does not follow the held one."""
        [power] = self._powers([member])
        held = self.names[self.held]
        if factors:
            return f" {'/' if power > 0 else '*'} {held}{_power(abs(power))}"
        by = "" if abs(power) == 1 else f"{abs(power):.3g} "
        return f" {'-' if power > 0 else '+'} {by}{f'ln({held})' if self.logarithmic[self.held] else held}"

    def power(self, member: int) -> float:
        """Return by how much a member follows the held one in the vector, simple where it is nearly so."""
        return self._powers([member])[0]

    def _powers(self, members: Sequence[int]) -> list[float]:
        out = []
        for member in members:
            found = float(self.follows[member])
            simple = round(2 * found) / 2
            same = self.units[member] == self.units[self.held] or self.logarithmic[member] == self.logarithmic[
                self.held]  # fmt: skip
            out.append(simple if same and simple and abs(found - simple) <= NEAR * abs(simple) else found)
        return out

    def _far(self) -> str:
        # along a direction of length 1, the held one moves by its own part of the direction alone
        if self.sd > UNBOUNDED:
            return "any factor" if self.logarithmic[self.held] else "any amount"
        step = self.sd * abs(float(self.scaled[self.held])) * float(self.scales[self.held])
        if self.logarithmic[self.held]:
            return f"a factor {math.exp(step):.2g}"
        factor, unit = READ.get(self.units[self.held], (1.0, self.units[self.held]))
        return f"{step * factor:.2g} {unit}"


def _power(power: float) -> str:
    return "" if power == 1 else f"^{power:.2g}"


def with_interval(value: float, half: float, unit: str, factors: bool) -> str:
    """Return a value of the vector and half of its 95 % interval in words, in as many digits as that leaves.

    Args:
        value, half: of the vector.
        unit: of both; "" for none.
        factors: whether they are logarithms, and what they are of is to be told.
    """
    factor, unit = READ.get(unit, (1.0, unit))
    ends = factor * np.array([value, value - half, value + half])
    ends = np.exp(ends) if factors else ends
    spread = max(float(ends[2] - ends[1]), 1e-300) / 2
    places = int(np.clip(1 - math.floor(math.log10(spread)), 0, 12))
    middle, low, high = (f"{end:.4g}" if factors else f"{end + 0.0:.{places}f}" for end in ends.tolist())
    return f"{middle} (95 %: {low} to {high}){f' {unit}' if unit else ''}"


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
