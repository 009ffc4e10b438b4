"""A controller that takes its arm for another one: it commands with what it believes, the arm is what it is."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from contarm_sim.control.base import Controller
from contarm_sim.control.feedback import Feedback
from contarm_sim.control.plan import Plan
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import count
from contarm_sim.model.arm import Arm
from contarm_sim.paths.reference import Reference


class Believing(Controller):
    """Plans and corrects for the arm it believes in, whatever arm it drives; what it sees is of the arm it drives.

    Args:
        controller: what drives the arm.
        arm: the arm that it is believed to be; it has as many muscles.
        reference: what that arm is to do. The arm that is driven may have other lengths.
    """

    def __init__(self, controller: Controller, arm: Arm, reference: Reference) -> None:
        self._controller, self._arm, self._reference = controller, arm, reference
        for name, value in controller.about().items():
            setattr(self, "name" if name == "controller" else name, value)

    @cached_property
    def _plan(self) -> Plan:
        """The same for all arms that are driven."""
        return self._controller.checked_plan(self._arm, self._reference, count(self._arm))

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return the plan for the arm believed in."""
        return self._plan

    def feedback(self, arm: Arm, reference: Reference, plan: Plan) -> Feedback | None:
        """Return what would correct the arm believed in."""
        return self._controller.checked_feedback(self._arm, self._reference, plan)

    def limits(self, arm: Arm) -> tuple[Any, Any]:
        """Return the limits that both arms have: no more is asked for, and no more is there."""
        (low, high), (lowest, highest) = (self._controller.checked_limits(each) for each in (self._arm, arm))
        top: Array = np.minimum(high, highest)
        return np.minimum(np.maximum(low, lowest), top), top
