"""A user's own controller: a subclass, passed to `simulate` and to `poses_at_rest`."""

from dataclasses import replace

import numpy as np
import pytest
from references import along, resting

from contarm_sim.control.base import Controller
from contarm_sim.control.feedback import Feedback
from contarm_sim.control.plan import Plan
from contarm_sim.control.registry import NAMES
from contarm_sim.control.registry import controller as resolved
from contarm_sim.control.servo import LengthFeedback, Servo
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import Stepping, simulate


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


class Broken(Pull):
    """`Pull` with something wrong."""

    def __init__(self, **wrong):
        self._wrong = wrong

    def plan(self, arm, reference):
        return replace(super().plan(arm, reference), **{k: v(arm, reference) for k, v in self._wrong.items()})


WRONG = {
    "too few rows": {"setpoint": lambda arm, r: np.ones((3, 3))},
    "one column": {"setpoint": lambda arm, r: np.ones((len(r), 1))},
    "not a number": {"setpoint": lambda arm, r: np.full((len(r), 3), np.nan)},
    "lengths of one sample": {"lengths": lambda arm, r: np.ones(3)},
    "a start of one muscle": {"start": lambda arm, r: np.ones(1)},
    "a short list": {"setpoint": lambda arm, r: [1.0, 2.0]},
    "words": {"setpoint": lambda arm, r: [["a", "b", "c"]] * len(r)},
}


@pytest.mark.parametrize("wrong", WRONG.values(), ids=WRONG)
def test_a_plan_that_does_not_fit_is_refused(wrong):
    arm = Arm(links=6)
    for call, reference in ((simulate, along(arm, "circle", 0.2, max_bend=0.3)), (poses_at_rest, resting(arm, BEND))):
        with pytest.raises(InputError, match=r"plan\."):
            call(arm, reference, Broken(**wrong))


BEND = np.array([[0.2, 0.1], [0.3, 0.0]])


class Odd(Servo):
    """A servo with a feedback that a test makes."""

    def __init__(self, feedback):
        self._feedback = feedback

    def feedback(self, arm, reference, plan):
        return self._feedback(arm, plan)


def _spoiled(name, value):
    def feedback(arm, plan):
        made = LengthFeedback(arm, plan.lengths)
        setattr(made, name, value)
        return made

    return feedback


class Late(LengthFeedback):
    """Sums up what is no number after a while."""

    def update(self, index, seen, gain):
        super().update(index, seen, gain)
        if index == 5:
            self.value[1] = np.nan


@pytest.mark.parametrize(
    ("feedback", "said"),
    [
        (_spoiled("value", np.zeros(5)), r"feedback\.value is of shape \(5,\)"),
        (_spoiled("value", [0.0, 0.0, 0.0]), r"feedback\.value"),
        (_spoiled("time", 0.0), r"feedback\.time is 0"),
        (_spoiled("time", np.nan), r"feedback\.time is nan"),
        (lambda arm, plan: Late(arm, plan.lengths), "not a number"),
    ],
)
def test_a_feedback_that_cannot_be_is_refused(feedback, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arm = Arm(links=6)
    with pytest.raises(InputError, match=said):
        simulate(arm, along(arm, "circle", 0.2, max_bend=0.3), Odd(feedback))
    assert not list(tmp_path.iterdir())


def test_a_feedback_that_is_returned_again_starts_anew_in_every_pass():
    arm, kept = Arm(links=8), {}
    reference = along(arm, "circle", 0.6, max_bend=0.6)

    def same(arm, plan):
        return kept.setdefault("one", LengthFeedback(arm, plan.lengths))

    fresh, again = (simulate(arm, reference, Odd(f)) for f in (lambda a, p: LengthFeedback(a, p.lengths), same))
    assert fresh.timestep < 0.005  # it took more than one pass
    assert again == fresh
    assert simulate(arm, reference, Odd(same)) == fresh  # nor does a run go on from the last


def test_controls_are_cut_to_what_muscles_take_and_recorded_so():
    class Strong(Pull):
        """Asks for a thousand newtons of muscle 1, and for pushing of muscle 2."""

        def plan(self, arm, reference):
            plan = super().plan(arm, reference)
            return replace(plan, setpoint=plan.setpoint + np.array([1000.0, -1000.0, 0.0]))

    arm = Arm(links=6, bending_stiffness=3.0)
    run = simulate(arm, along(arm, "circle", 0.1, max_bend=0.01), Strong())
    assert (run.setpoint[:, 0] == arm.muscle.blocked_force).all()
    assert (run.setpoint[:, 1] == 0).all()


def test_lists_are_plans_too():
    class Listed(Pull):
        """The same numbers as lists."""

        def plan(self, arm, reference):
            plan = super().plan(arm, reference)
            return Plan(plan.lengths.tolist(), plan.setpoint.tolist(), plan.start.tolist())

    arm, bend = Arm(links=6), np.array([[0.2, 0.1]])
    reference = along(arm, "circle", 0.2, max_bend=0.3)
    assert simulate(arm, reference, Listed()) == simulate(arm, reference, Pull())
    assert poses_at_rest(arm, resting(arm, bend), Listed()) == poses_at_rest(arm, resting(arm, bend), Pull())


def test_what_is_no_plan_or_feedback_is_refused_in_motion_and_at_rest():
    class Nothing(Pull):
        """Plans nothing."""

        def plan(self, arm, reference):
            return None

    class Wrong(Pull):
        """Has a feedback that is none."""

        def feedback(self, arm, reference, plan):
            return 3

    class Large(Pull):
        """Corrects five muscles."""

        def feedback(self, arm, reference, plan):
            return Sized(0.1, 5)

    class Sized(Feedback):
        """Does nothing."""

        def update(self, index, seen, gain):
            pass

    arm = Arm(links=6)
    for call, reference in ((simulate, along(arm, "circle", 0.2, max_bend=0.3)), (poses_at_rest, resting(arm, BEND))):
        for wrong, said in ((Nothing(), "plan"), (Wrong(), "feedback"), (Large(), r"feedback\.value")):
            with pytest.raises(InputError, match=said):
                call(arm, reference, wrong)


def test_a_correction_that_is_replaced_instead_of_changed_is_refused():
    class Replaced(LengthFeedback):
        """Makes a new array at every tick."""

        def update(self, index, seen, gain):
            super().update(index, seen, gain)
            self.value = self.value + 0.0

    arm = Arm(links=6)
    with pytest.raises(InputError, match="changed in place"):
        simulate(arm, along(arm, "circle", 0.6, max_bend=0.3), Odd(lambda a, plan: Replaced(a, plan.lengths)))


def test_a_feedback_sees_what_the_recording_says():
    seen_so_far = []

    class Watching(LengthFeedback):
        """Keeps what it sees."""

        def update(self, index, seen, gain):
            seen_so_far.append([list(seen.lengths), list(seen.speeds), list(seen.tensions), seen.tip.copy()])
            super().update(index, seen, gain)

    arm = Arm(links=6)
    stepping = Stepping(0.005)
    run = simulate(
        arm, along(arm, "circle", 0.6, max_bend=0.3), Odd(lambda a, p: Watching(a, p.lengths)), stepping=stepping
    )
    lengths, speeds, tensions, tips = (np.array(each) for each in zip(*seen_so_far, strict=True))
    np.testing.assert_allclose(lengths, run.muscle_lengths, atol=1e-15)
    np.testing.assert_allclose(tensions, run.muscle_tensions, atol=1e-9)
    np.testing.assert_array_equal(tips, run.tip)
    measured = np.gradient(lengths, 0.01, axis=0)
    np.testing.assert_allclose(speeds[2:-2], measured[2:-2], atol=0.05 * np.abs(measured).max())


@pytest.mark.parametrize("limits", [(5.0, 1.0), (np.nan, np.nan), (0.0,), "ab", 5, (0.0, None)])
def test_limits_that_are_none_are_refused_in_motion_and_at_rest(limits):
    class Limited(Pull):
        """Has limits that cannot be."""

        def limits(self, arm):
            return limits

    arm = Arm(links=6)
    for call, reference in ((simulate, along(arm, "circle", 0.2, max_bend=0.3)), (poses_at_rest, resting(arm, BEND))):
        with pytest.raises(InputError, match="limits"):
            call(arm, reference, Limited())
