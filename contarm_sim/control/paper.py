"""The arc's lengths into plain position servos, which push as well as pull: the paper's, read literally."""

from __future__ import annotations

from contarm_sim.control.base import Controller
from contarm_sim.control.plan import Plan
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.muscles import each
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference


class Paper(Controller):
    """The arc's lengths (l_i = -r b . u_i), no feed-forward, no feedback."""

    name = "paper"
    pulls_only = False

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return the arc's lengths, and these as controls."""
        deltas = routing.arc_deltas(reference.bend, arm)
        return Plan(each(arm, lambda group: group.length) + deltas, deltas, deltas[0])
