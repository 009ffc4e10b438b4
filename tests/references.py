"""Motions and poses for tests."""

import numpy as np

from contarm_sim import paths
from contarm_sim.kinematics import arc
from contarm_sim.paths.reference import Reference


def along(arm, name="spiral", duration=1.0, **shape):
    """Return the motion along a named path."""
    return Reference.from_path(paths.named(name, arm.length, duration, **shape), arm)


def moving(arm, bend, target=None, rate=100.0):
    """Return the motion through bends; targets are their arcs' tips unless given."""
    target = arc.position(bend, arm.length) if target is None else target
    return Reference(np.arange(len(bend)) / rate, target, bend, arm.length)


def resting(arm, bend, target=None):
    """Return poses at rest."""
    target = arc.position(bend, arm.length) if target is None else target
    return Reference(np.zeros(len(bend)), target, bend, arm.length)
