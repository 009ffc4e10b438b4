"""Poses at rest of many samples at once: the bits of one sample after the other."""

from dataclasses import replace

import numpy as np
import pytest

from contarm_sim import Arm, Reference, poses_at_rest, presets
from contarm_sim.control.base import Controller
from contarm_sim.control.feedforward import Feedforward
from contarm_sim.control.servo import Servo
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics import arc
from contarm_sim.motion import rest
from contarm_sim.statics.holding import Holder
from contarm_sim.statics.solver import Solver

MEASURED = ("setpoint", "muscle_lengths", "muscle_tensions", "pressure", "stations", "tip_rotation", "qpos")
HANGING = {"gravity": (0.0, 2.0, 9.81), "payload": 0.05}
ARMS = {
    "parallel": Arm(links=12, **HANGING),
    "spans": Arm(links=12, path="spans", **HANGING),
    "twist": Arm(links=12, torsional_stiffness=0.05, **HANGING),
    "two": replace(presets.two(), gravity=(0.0, 0.0, 9.81)),
}


def _reference(arm, count=12, largest=1.0):
    rng, sections = np.random.default_rng(1), len(arm.sections)
    bends = arc.from_polar(rng.uniform(0, largest, (count, sections)), rng.uniform(-3, 3, (count, sections)))
    return Reference.from_bends(bends.reshape(count, -1), arm)


@pytest.fixture
def one_by_one(monkeypatch):
    """Have samples solved one by one from now on."""

    def now():
        monkeypatch.setattr(rest, "_home", lambda controller, name: name)

    return now


@pytest.fixture
def solved(monkeypatch):
    """How many samples the solvers of one sample settled."""
    calls: list[int] = []
    for solver in (Holder, Solver):
        plain = solver.__call__

        def counted(self, *given, plain=plain):
            calls.append(1)
            return plain(self, *given)

        monkeypatch.setattr(solver, "__call__", counted)
    return calls


@pytest.mark.parametrize("controller", ["servo", "paper", "feedforward", "pressure"])
@pytest.mark.parametrize("name", ARMS)
def test_many_samples_at_once_are_the_same_as_one_by_one(name, controller, one_by_one, solved):
    arm = ARMS[name]
    reference = _reference(arm, largest=0.8)
    together, at_once = poses_at_rest(arm, reference, controller), len(solved)
    one_by_one()
    alone = poses_at_rest(arm, reference, controller)
    assert at_once <= 1 < len(solved) - at_once
    for measured in MEASURED:
        np.testing.assert_array_equal(getattr(together, measured), getattr(alone, measured), err_msg=measured)


def test_the_first_pose_without_rest_is_named_as_it_is_one_by_one(one_by_one):
    arm = Arm(links=12, gravity=(0.0, 0.0, 9.81), payload=6.0)
    bends = arc.from_polar(np.radians([10.0, 20.0, 170.0, 170.0, 30.0]), np.radians([0.0, 20.0, 40.0, 60.0, 0.0]))
    reference = Reference.from_bends(bends, arm)
    told = []
    for prepare in (lambda: None, one_by_one):
        prepare()
        ticks = iter(range(5))
        with pytest.raises(EquilibriumError) as refused:
            poses_at_rest(arm, reference, "servo", ticks)
        told.append((str(refused.value), list(ticks)))
    assert told[0] == told[1]
    assert told[0][0].startswith("at a bend of 170 deg towards 40 deg")
    assert told[0][1] == [3, 4]


def test_samples_may_be_asked_for_in_any_order():
    arm = ARMS["parallel"]
    reference = _reference(arm, 6)
    usual = poses_at_rest(arm, reference)
    turned = poses_at_rest(arm, reference, ticks=reversed(range(6)))
    for measured in MEASURED:
        np.testing.assert_array_equal(getattr(usual, measured), getattr(turned, measured))


class _Own(Servo):
    """Rests its own way, one sample at a time."""

    def resting(self, plant, reference):
        rest = super().resting(plant, reference)
        return lambda index: rest(index)


class _Corrects(Feedforward):
    """Has a feedback of its own, which is asked sample by sample."""

    def feedback(self, arm, reference, plan):
        return Servo().feedback(arm, reference, plan)


@pytest.mark.parametrize("own", [_Own(), _Corrects()])
def test_users_own_controllers_are_asked_sample_by_sample(own, solved):
    arm = ARMS["parallel"]
    found, usual = poses_at_rest(arm, _reference(arm, 3), own), poses_at_rest(arm, _reference(arm, 3))
    assert len(solved) >= 3
    np.testing.assert_allclose(found.tip, usual.tip, atol=1e-7)
    assert isinstance(own, Controller)
