"""A controller of bends of any angle: sections that curl by more than half a turn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.feedforward import Feedforward
from contarm_sim.control.plan import Plan
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference

HALF_TURN = 0.95 * np.pi
"""Largest bend of a reference that stands for a curl [rad]."""


class Curl(Controller):
    """Feed-forward as far as references go, half a turn a section; beyond, muscles get the lengths of the longer arc.

    Args:
        bend: of all samples [rad], shape (T, 2 S), of any angle. The reference is `reference_of_curl` of the same.
    """

    name = "curl"

    def __init__(self, bend: Array) -> None:
        self._bend = np.asarray(bend, dtype=float)

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return lengths and set-points."""
        plan = Feedforward().plan(arm, reference)
        more = routing.arc_deltas(self._bend[: len(reference)] - reference.bend, arm)
        return replace(plan, lengths=plan.lengths + more, setpoint=plan.setpoint + more, start=plan.start + more[0])


def reference_of_curl(bend: Array, arm: Arm, time: Array) -> Reference:
    """Return the motion through bends [rad], shape (T, 2 S), each cut to `HALF_TURN`, at times [s], shape (T,)."""
    bends = bend.reshape(len(bend), -1, 2)
    angle = np.linalg.norm(bends, axis=-1, keepdims=True)
    cut = bends * np.minimum(1.0, HALF_TURN / np.maximum(angle, HALF_TURN))
    return Reference.from_bends(cut, arm, time)
