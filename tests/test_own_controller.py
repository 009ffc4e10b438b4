"""A user's own controller: a subclass, passed to `simulate` and to `poses_at_rest`."""

import numpy as np
import pytest
from references import along, resting

from contarm_sim.control.base import Controller, Feedback, Plan
from contarm_sim.control.registry import NAMES
from contarm_sim.control.registry import controller as resolved
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate


class Pull(Controller):
    """Plain tensions that hold the bend."""

    name = "pull"
    actuation = "tensions"

    def plan(self, arm, reference):
        """Return the tensions that hold each bend."""
        tensions = holding_tensions(reference.bend, arm)
        return Plan(routing.lengths_from_bend(reference.bend, arm), tensions, tensions[0])


class Integral(Feedback):
    """Adds tension where a muscle is too long."""

    def __init__(self, plan):
        self.time, self._wanted, self.value = 0.2, plan.lengths, np.zeros(3)

    def update(self, index, seen, gain):
        off = np.asarray(seen.lengths) - self._wanted[index]
        self.value += gain * 50.0 * (off - off.mean())


class PullAndLook(Pull):
    """The same, corrected by what is seen."""

    name = "pull and look"

    def feedback(self, arm, reference, plan):
        return Integral(plan)


def test_a_subclass_drives_the_arm():
    arm = Arm(links=12)
    run = simulate(arm, along(arm, "circle", 8.0, max_bend=0.8), Pull())
    assert (run.controller, run.actuation, run.status) == ("pull", "tensions", "finished")
    assert run.tip_error.max() < 0.05 * arm.length
    assert run.muscle_tensions.min() > 0.9 * arm.muscle.min_tension


def test_at_rest_its_feedback_is_called_until_it_changes_nothing():
    """Under gravity tensions alone leave the bend; their integral brings muscle lengths back, as the servo does."""
    arm = Arm(links=12, gravity=(0.0, 0.0, 9.81))
    reference = resting(arm, arc.from_polar(np.array([0.5, 1.2]), np.array([0.3, 2.0])))
    heavy = Arm(links=12, gravity=(0.0, 0.0, 9.81), payload=0.05)
    blind, seeing = (poses_at_rest(heavy, reference, controller) for controller in (Pull(), PullAndLook()))
    wanted = routing.lengths_from_bend(reference.bend, heavy)
    assert np.abs(blind.muscle_lengths - wanted).max() > 1e-5
    np.testing.assert_allclose(seeing.muscle_lengths, wanted, atol=1e-8)


def test_what_is_no_controller_is_refused():
    for wrong in ("pid", Pull, 3, None):
        with pytest.raises(InputError, match="paper, chain, feedforward"):
            resolved(wrong)
    assert [resolved(name).name for name in NAMES] == list(NAMES)


def test_a_controller_without_a_plan_cannot_be_made():
    class Lazy(Controller):
        """Nothing."""

    with pytest.raises(TypeError, match="plan"):
        Lazy()
