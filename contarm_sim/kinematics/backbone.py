"""What the kinematics of several sections must know of an arm: lengths, links, largest bends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array, as_vectors

LARGEST = float(0.98 * np.pi)
"""Largest bend angle of a section that inverse kinematics of several sections go to by default [rad]."""

MOST_SECTIONS = 6
"""Most sections of an arm."""


@dataclass(frozen=True, kw_only=True)
class Backbone:
    """The sections of an arm as its kinematics sees them, from the base to the tip. Checked at construction.

    Attributes:
        lengths: of the sections [m], S numbers.
        links: None: sections are arcs. Else the links of each section: they are chains of ball joints, each joint of a
            section bent alike, with a half link at each end.
        limits: largest bend angle of each section [rad], below pi; one number stands for all.
        connectors: straight, rigid lengths that follow each section [m], the tool at the tip last; one number stands
            for all.

    Raises:
        InputError: names what is not in its stated interval.
    """

    lengths: tuple[float, ...]
    links: tuple[int, ...] | None = None
    limits: tuple[float, ...] = (LARGEST,)
    connectors: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        lengths = _numbers("lengths", self.lengths, None)
        if not all(0 < x < np.inf for x in lengths):
            raise InputError("lengths", list(lengths), "positive numbers [m]")
        object.__setattr__(self, "lengths", lengths)
        limits = _numbers("limits", self.limits, len(lengths))
        if not all(0 < x < np.pi for x in limits):
            raise InputError("limits", list(limits), "largest bend angles above 0 and below pi [rad]")
        object.__setattr__(self, "limits", limits)
        connectors = _numbers("connectors", self.connectors, len(lengths))
        if not all(0 <= x < np.inf for x in connectors):
            raise InputError("connectors", list(connectors), "lengths of 0 or more [m]")
        object.__setattr__(self, "connectors", connectors)
        if self.links is not None:
            links = _numbers("links", self.links, len(lengths))
            if not all(x >= 1 and x == int(x) for x in links):
                raise InputError("links", list(links), "whole numbers of 1 or more")
            object.__setattr__(self, "links", tuple(int(x) for x in links))

    def __len__(self) -> int:
        return len(self.lengths)

    @property
    def length(self) -> float:
        """Length of the whole backbone, connectors included [m]."""
        return sum(self.lengths) + sum(self.connectors)


def _numbers(name: str, values: Any, count: int | None) -> tuple[float, ...]:
    """Return finite numbers as a tuple, one for each of `count` sections.

    Raises:
        InputError: not numbers, or not so many.
    """
    try:
        numbers = tuple(float(x) for x in np.atleast_1d(np.asarray(values, dtype=float)))
    except (TypeError, ValueError):
        raise InputError(name, repr(values), "numbers, one for each section") from None
    if count is not None and len(numbers) == 1:
        numbers *= count
    if not 1 <= len(numbers) <= MOST_SECTIONS or count not in (None, len(numbers)):
        allowed = f"1 to {MOST_SECTIONS} of them" if count is None else f"{count}, one for each section"
        raise InputError(name, f"{len(numbers)} of them", allowed)
    return numbers


def check_backbone(backbone: Any) -> None:
    """Refuse what is no backbone, such as an arm.

    Raises:
        InputError: says so.
    """
    if not isinstance(backbone, Backbone):
        given = f"{type(backbone).__name__} {backbone!r}" if isinstance(backbone, str) else type(backbone).__name__
        raise InputError("backbone", given, "a Backbone, such as mechanics.shape.backbone(arm)")


def as_bends(value: Any, backbone: Backbone, name: str = "bends") -> Array:
    """Return bends of all sections [rad] as an array of shape (..., S, 2), each shorter than pi.

    Raises:
        InputError: no backbone, or bends that are not finite, of another shape, or a bend angle of pi or more.
    """
    check_backbone(backbone)
    allowed = f"shape (..., {len(backbone)}, 2)"
    try:
        bends = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(name, repr(value), f"numbers, {allowed}") from None
    if bends.ndim < 2 or bends.shape[-2:] != (len(backbone), 2):
        raise InputError(name, f"of shape {bends.shape}", allowed)
    bends = as_vectors(bends, 2, name)
    angle = np.hypot(bends[..., 0], bends[..., 1])
    if not np.all(angle < np.pi):
        worst = float(angle.max())
        raise InputError("bend_angle", f"{worst:.9g} rad ({np.degrees(worst):.6g} deg)", "0 <= bend_angle < pi rad")
    return bends
