"""Pulling muscles: the tensions that hold the bend fold into the controls of the length servos."""

from __future__ import annotations

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.plan import Plan
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.muscles import each
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference


class Feedforward(Controller):
    """The chain's lengths and the tensions that hold it; in motion also the backbone's damping and the servo's lag."""

    name = "feedforward"

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return lengths and set-points."""
        bend = reference.bend
        lengths = routing.lengths_from_bend(bend, arm)
        if not reference.moving:
            held = _hold(arm, bend, lengths, None)
            return Plan(lengths, held, held[0])
        period = 1 / reference.rate
        setpoint = _hold(arm, bend, lengths, np.gradient(bend, period, axis=0))
        setpoint = setpoint + each(arm, lambda group: group.servo_time) * np.gradient(lengths, period, axis=0)
        return Plan(lengths, setpoint, _hold(arm, bend[:1], lengths[:1], None)[0])


def _hold(arm: Arm, bend: Array, lengths: Array, rate: Array | None) -> Array:
    """Return set-points [m] with which muscles of these lengths [m] carry the arm."""
    return servo_control(lengths, holding_tensions(bend, arm, rate=rate), arm)
