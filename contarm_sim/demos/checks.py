"""What a demonstration must show, as numbers beside what is allowed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A number of a demonstration, and its limit.

    Attributes:
        what: is measured.
        value, limit: in the unit.
        unit: of both.
        least: whether the limit is the least that is allowed; else the most.
    """

    what: str
    value: float
    limit: float
    unit: str
    least: bool = False

    @property
    def passed(self) -> bool:
        """Whether the value is within its limit; what is no number is not."""
        return self.value >= self.limit if self.least else self.value <= self.limit
