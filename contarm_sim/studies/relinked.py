"""The same arm with other links: what the number of links does to a result."""

from __future__ import annotations

from dataclasses import replace

from contarm_sim.model.arm import Arm
from contarm_sim.model.section import MAX_LINKS


def can_double(arm: Arm) -> bool:
    """Tell whether an arm of twice the links is not too long a chain."""
    return 2 * arm.links <= MAX_LINKS


def relinked(arm: Arm, double: bool) -> Arm:
    """Return an arm whose sections have twice the links, or half as many.

    Raises:
        InputError: too many links, or links that are too light.
    """
    count = (lambda links: 2 * links) if double else (lambda links: max(links // 2, 2))
    return replace(arm, sections=tuple(replace(section, links=count(section.links)) for section in arm.sections))
