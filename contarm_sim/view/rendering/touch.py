"""What the arm touches in pictures: arrows of contact forces, to a scale that the caption states."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.view.colours import CONTACT, rgb
from contarm_sim.view.rendering.overlays import Colour, add_arrow, add_ball, placed

if TYPE_CHECKING:
    from contarm_sim.model.arm import Arm
    from contarm_sim.results.trajectory import Trajectory

FORCE: Colour = (*rgb(CONTACT), 1.0)
"""Of the arrows of forces, which have a white edge."""

LIT: Colour = (1.0, 0.72, 0.88, 1.0)
"""Of links that touch: pale, so that arrows are seen before them."""

_EDGE: Colour = (1.0, 1.0, 1.0, 1.0)

_LONGEST = 0.32
"""Length of the arrow of a large force [of the arm's length]: of all but the largest 2 %, which blows have."""

_CLOSER = 0.5
"""Share of the way to the eye at which arrows are drawn, and so much smaller: over all else, at the same pixels."""

_THICK, _BALL, _LEAST = 0.0055, 0.008, 0.02
"""Radius of an arrow and of the ball at its foot, and the shortest arrow that is drawn [of the arm's length]."""

_WIDER, _BEHIND = 0.003, 0.98
"""How much wider the edge is [of the arm's length], and how much less close to the eye: it is behind all arrows."""


def metres_per_newton(*runs: Trajectory) -> float:
    """Return how long arrows of runs are drawn [m/N], see `arrow_scale`; 0 where nothing is touched."""
    forces = [np.linalg.norm(run.contacts.force, axis=1) for run in runs if run.contacts is not None]
    every = np.concatenate([*forces, np.zeros(0)])
    large = float(np.percentile(every, 98)) if len(every) else 0.0
    return arrow_scale(large, max(run.arm.length for run in runs))


def arrow_scale(force: float, length: float) -> float:
    """Return how long arrows are drawn [m/N] where a force [N] is large: 1, 2 or 5 of a power of ten; 0 for no force.

    Args:
        length: of the arm [m].
    """
    if force <= 0:
        return 0.0
    most = _LONGEST * length / force
    power = 10.0 ** math.floor(math.log10(most))
    return power * max(step for step in (1, 2, 5) if step * power <= most * (1 + 1e-9))


def scale_words(scale: float) -> str:
    """Return a scale [m/N] in words, in whole millimetres: `1 N = 5 mm`."""
    newton = 1
    while 1e3 * scale * newton < 1 - 1e-9:
        newton *= 10
    return f"{newton} N = {1e3 * scale * newton:.3g} mm"


def contact_words(contacts: Contacts) -> str:
    """Return what the arm touches in one sample, in a few words: links and net force."""
    if not len(contacts):
        return "no contact"
    links = len(np.unique(contacts.station))
    net = float(np.linalg.norm(contacts.force.sum(axis=0)))
    return f"contact: {links} link{'s' * (links > 1)}, net force {net:.1f} N"


def add_contacts(
    scene: Any, base: Any, contacts: Contacts, arm: Arm, scale: float, closer: float = _CLOSER
) -> None:  # fmt: skip
    """Draw a ball at each contact, and the force on the arm from there, `scale` long [m/N].

    Args:
        base: the engine's view of the base body.
        contacts: of one sample.
        closer: how far towards the eye they are drawn, and so much smaller; 0 where there is no one eye.
    """
    eye = np.mean([camera.pos for camera in scene.camera], axis=0) if closer else np.zeros(3)
    starts, ends = placed(base, contacts.point), placed(base, contacts.point + scale * contacts.force)
    looks = ((closer, 0.0, FORCE), (_BEHIND * closer, _WIDER, _EDGE)) if closer else ((0.0, 0.0, FORCE),)
    for near, wider, colour in looks:
        length = (1 - near) * arm.length
        for start, end in zip(starts, ends, strict=True):
            foot, head = start + near * (eye - start), end + near * (eye - end)
            add_ball(scene, foot, (_BALL + wider) * length, colour)
            along = head - foot
            if np.linalg.norm(along) > _LEAST * length:
                beyond = 2 * wider * length * along / np.linalg.norm(along)
                add_arrow(scene, foot, head + beyond, (_THICK + wider) * length, colour)
