"""The lengths that the chain of links really has, into plain position servos."""

from __future__ import annotations

from contarm_sim.control.base import Controller
from contarm_sim.control.plan import Plan
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.muscles import each
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference


class Chain(Controller):
    """As `Paper`, with the chain's lengths: others than the arc's where muscles run in straight spans."""

    name = "chain"
    pulls_only = False

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return the chain's lengths, and these as controls."""
        lengths = routing.lengths_from_bend(reference.bend, arm)
        setpoint = lengths - each(arm, lambda group: group.length)
        return Plan(lengths, setpoint, setpoint[0])
