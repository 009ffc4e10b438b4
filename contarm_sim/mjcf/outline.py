"""What an arm of several sections can touch, as seen from its side."""

from __future__ import annotations

import math

import numpy as np

from contarm_sim.model.arm import Arm

_DIRECTIONS = 72
_BENDS = np.linspace(-math.pi, math.pi, 73)
"""Bends of a section from half a turn to half a turn the other way [rad]: a whole number of directions each."""


def outline(arm: Arm) -> list[tuple[float, float]]:
    """Return radius and height of points about all centrelines bent in one plane by up to half a turn [lengths].

    Section by section from the tip, the farthest that an arm reaches in a direction is the most that this section's
    chord and the farthest of the sections beyond, seen from its end, give together. No point along an arm is farther
    than all tips: from any end, bent by half a turn, a section comes back at least to where it began.
    """
    turn = 2 * math.pi / _DIRECTIONS
    angle = turn * np.arange(_DIRECTIONS)  # from the section's own axis
    half = 0.5 * _BENDS
    chord = np.sinc(half / math.pi)
    steps = np.rint(_BENDS / turn).astype(int)
    farthest = np.zeros((_DIRECTIONS, 2))  # the point farthest in each direction: to the side, and along the axis
    for section in reversed(arm.sections):
        ends = section.length / arm.length * chord[:, None] * np.stack([np.sin(half), np.cos(half)], axis=1)
        seen = farthest[(np.arange(_DIRECTIONS)[:, None] - steps) % _DIRECTIONS]  # (direction, bend, 2)
        side = np.cos(_BENDS) * seen[..., 0] + np.sin(_BENDS) * seen[..., 1]
        axial = np.cos(_BENDS) * seen[..., 1] - np.sin(_BENDS) * seen[..., 0]
        points = np.stack([side, axial], axis=-1) + ends
        reach = points[..., 0] * np.sin(angle)[:, None] + points[..., 1] * np.cos(angle)[:, None]
        best = reach.argmax(axis=1)
        farthest = points[np.arange(_DIRECTIONS), best]
    return [(abs(float(x)), float(z)) for x, z in farthest]
