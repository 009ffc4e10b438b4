"""Many arms at once: the bits of each alone, whatever differs between them; one that blows up leaves others alone."""

from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest
from references import along, moving
from test_own_controller import PullAndLook

from contarm_sim import ContarmError, DivergenceError, InputError, InterruptedMany, simulate, simulate_many
from contarm_sim.control.base import Controller
from contarm_sim.control.feedback import Feedback
from contarm_sim.control.servo import LengthFeedback, Servo
from contarm_sim.engine import threads
from contarm_sim.engine.moved import STATE
from contarm_sim.engine.plant import Plant
from contarm_sim.engine.plants import Plants
from contarm_sim.engine.room import engine_room
from contarm_sim.kinematics import arc
from contarm_sim.mjcf.muscles import straight_controls
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.presets import two
from contarm_sim.motion import legs
from contarm_sim.motion.simulate import Stepping

HANGING = {"gravity": (0.0, 0.0, 9.81)}
DIFFER = (
    {}, {"bending_stiffness": 0.2}, {"mass": 0.2, **HANGING}, {"damping_time": 0.1}, {"length": 0.3},
    {"muscle": McKibben(servo_stiffness=3e4)}, {"muscle": McKibben(max_pressure=7e5, min_tension=8.0)},
)  # fmt: skip
TWISTING = {"torsional_stiffness": 0.08, "links": 6}
KINDS = {
    "parallel": ([Arm(links=6, **own) for own in DIFFER], "lengths"),
    "spans": ([Arm(links=6, path="spans", **own) for own in DIFFER], "lengths"),
    "payloads": ([Arm(links=6, payload=0.1), Arm(links=6, payload=0.2, **HANGING)], "lengths"),
    "twist": ([Arm(**TWISTING, **own) for own in DIFFER], "lengths"),
    "twist by tensions": ([Arm(**TWISTING, **own) for own in DIFFER], "tensions"),
    "twist by pressures": ([Arm(**TWISTING, **own) for own in DIFFER], "pressures"),
    "friction": ([Arm(links=6, muscle=McKibben(braid_friction=f)) for f in (0.2, 0.5)], "pressures"),
    "two sections": ([two(), replace(two(), world=replace(two().world, gravity=(9.81, 0.0, 0.0)))], "lengths"),
    "bare": ([Arm(links=6, **own) for own in DIFFER], "none"),
}
READ = ("stations", "tip", "rotations", "muscle_lengths", "muscle_tensions", "actuator_tensions")


@pytest.fixture
def eager(monkeypatch):
    """Two threads, and flights together, also for few arms."""
    monkeypatch.setattr(threads, "ARMS_A_THREAD", 1)
    monkeypatch.setattr(legs, "FEWEST", 1)


@pytest.mark.parametrize("kind", KINDS)
def test_many_have_the_bits_of_each_alone(kind, eager):
    arms, actuation = KINDS[kind]
    rng = np.random.default_rng(0)
    steps = np.linspace(0.002, 0.004, len(arms))
    bend = rng.uniform(-1, 1, (len(arms), 2 * len(arms[0].sections)))
    start = np.array([straight_controls(arm, actuation) for arm in arms])
    jolts = [start * rng.uniform(0.9, 1.1, start.shape) - 1e-3 * (actuation == "lengths") for _ in range(20)]
    many = Plants(arms, actuation, timestep=steps, threads=2)
    many.reset(bend=bend)
    singles = [Plant(arm, actuation=actuation, timestep=step) for arm, step in zip(arms, steps, strict=True)]
    with engine_room():
        many.forward()
        for single, own in zip(singles, bend, strict=True):
            single.reset(own)
            mujoco.mj_forward(single.model, single.data)
        for jolt in jolts:
            if actuation != "none":
                many.send(jolt)
            many.stiffen_twist()
            many.step(2)
            for single, own in zip(singles, jolt, strict=True):
                if actuation != "none":
                    single.control[:] = own
                single.stiffen_twist()
                mujoco.mj_step(single.model, single.data, 2)
    assert not many.failed
    for place, single in enumerate(singles):
        state = np.empty(many.state.shape[1])
        mujoco.mj_getState(single.model, single.data, state, STATE)
        np.testing.assert_array_equal(many.state[place], state)
        for name in READ[: 5 if actuation == "none" else None]:
            np.testing.assert_array_equal(getattr(many, name)[place], getattr(single, name), err_msg=name)


def test_arms_of_several_layouts_are_refused_together():
    for other in (Arm(links=8), Arm(links=6, payload=0.1)):
        with pytest.raises(InputError, match="of several layouts"):
            Plants([Arm(links=6), other])
    with pytest.raises(InputError, match="arms is none"):
        Plants([])


def test_an_arm_that_diverges_is_frozen_and_comes_back_as_another():
    arms = [Arm(links=6), Arm(links=6, damping_time=0.0, mass=0.01)]
    many, alone = Plants(arms), Plant(arms[0])
    with engine_room():
        many.reset(bend=np.full((2, 2), 0.5))
        alone.reset(np.full(2, 0.5))
        for _ in range(49):
            many.step(2)
        assert list(many.failed) == [1]
        assert 0 < many.failed[1].time < 0.5
        frozen = many.state[1].copy()
        many.step(2)
        np.testing.assert_array_equal(many.state[1], frozen)
        mujoco.mj_step(alone.model, alone.data, 100)
        np.testing.assert_array_equal(many.qpos[0], alone.data.qpos)
        many.become({1: Arm(links=6, mass=0.2)})
        many.reset([1])
        many.step(100)
    assert not many.failed


def _same(one, other):
    for name in (field.name for field in fields(one)):
        if name != "real_time_factor":
            np.testing.assert_equal(getattr(one, name), getattr(other, name), err_msg=name)


class Sum(LengthFeedback):
    """A user's own, on top of one that can correct many arms at once."""

    def update(self, index, seen, gain):
        super().update(index, seen, 0.5 * gain)


class Summing(Servo):
    """Corrects half as fast."""

    def feedback(self, arm, reference, plan):
        return Sum(arm, plan.lengths)


def test_motions_at_once_have_the_bits_of_each_alone(eager):
    soft, heavy = Arm(links=6), Arm(links=6, mass=0.15, bending_stiffness=0.3, **HANGING)
    wild, long = Arm(links=6, damping_time=0.0, mass=0.1), Arm(links=6, length=0.5)
    cases = [
        (arm, along(arm, "circle", duration, max_bend=0.1), name, None if name == sought else Stepping(2.5e-3))
        for arm, duration, sought in ((soft, 0.3, "servo"), (heavy, 0.5, "tip"))
        for name in ("paper", "feedforward", "servo", "pressure", "tip", PullAndLook(), Summing())
    ]
    cases += [(wild, along(wild, "circle", 0.1, max_bend=0.1), "servo", step) for step in (None, Stepping(0.005))]
    cases += [(long, cases[0][1], "servo", None), (soft, cases[0][1], "servo", Stepping(0.0025))]
    cases += [(two(), along(two(), "circle", 0.3, max_bend=0.3), "servo", Stepping())]
    done = []
    arms, references, controllers, stepping = (list(each) for each in zip(*cases, strict=True))
    found = simulate_many(arms, references, controllers, stepping=stepping, threads=2, on_done=done.append)
    assert sorted(done) == list(range(len(cases)))
    for (arm, reference, controller, step), one in zip(cases, found, strict=True):
        if isinstance(one, ContarmError):
            with pytest.raises(type(one)) as alone:
                simulate(arm, reference, controller, stepping=step)
            assert str(alone.value) == str(one)
        else:
            _same(one, simulate(arm, reference, controller, stepping=step))
    kinds = [type(one) for one in found if isinstance(one, ContarmError)]
    assert kinds == [DivergenceError, InputError]  # a step that is too long, and another length


class Nervous(Controller):
    """Breaks off in the middle, in one of two ways."""

    actuation = "lengths"

    def __init__(self, breaks, at=3):
        self._breaks, self._at, self.plan = breaks, at, Servo().plan

    def plan(self, arm, reference):
        raise NotImplementedError

    def feedback(self, arm, reference, plan):
        return Breaking(len(plan.start), self._breaks, self._at)


class Breaking(Feedback):
    """Calls a function at a sample."""

    def __init__(self, muscles, breaks, at=3):
        super().__init__(0.1, muscles)
        self._breaks, self._at = breaks, at

    def update(self, index, seen, gain):
        if index == self._at:
            self._breaks(self)


def test_a_feedback_that_fails_leaves_the_other_arms_alone():
    def spoil(feedback):
        feedback.value[0] = np.nan

    arm = Arm(links=6)
    spiral = along(arm, "circle", 0.2, max_bend=0.3)
    found = simulate_many(arm, spiral, ["servo", "paper", "feedforward", Nervous(spoil)], stepping=Stepping())
    assert isinstance(found[3], InputError)
    assert "not a number" in str(found[3])
    _same(found[0], simulate(arm, spiral, stepping=Stepping()))


@pytest.mark.parametrize("arms", [[Arm(links=6)] * 4, [Arm(links=6), Arm(links=8)]], ids=["four", "two"])
def test_one_feedback_for_several_arms_is_refused(arms):
    shared = Servo()
    kept = Breaking(3, lambda feedback: None)
    shared.feedback = lambda *given: kept
    found = simulate_many(arms, along(arms[0], "circle", 0.2, max_bend=0.3), shared, stepping=Stepping())
    assert all("one object for several arms" in str(one) for one in found)


def test_a_feedback_that_gives_up_as_its_arm_blows_up_is_said_as_alone(eager):
    wild, step = Arm(links=6, damping_time=0.0, mass=0.1), Stepping(0.005)
    reference = along(wild, "circle", 0.1, max_bend=0.1)
    with pytest.raises(DivergenceError) as blown:
        simulate(wild, reference, stepping=step)

    def give_up(feedback):
        raise InputError("this feedback", "at its end", "more")

    last = Nervous(give_up, at=round(blown.value.time * reference.rate))
    with pytest.raises(InputError, match="this feedback"):
        simulate(wild, reference, last, stepping=step)
    assert "this feedback" in str(simulate_many(wild, reference, last, stepping=step)[0])


@pytest.mark.parametrize("count", [2, 5])
def test_ctrl_c_carries_what_is_done(count):
    """Motions of another layout are flown first, and kept."""

    def press(feedback):
        raise KeyboardInterrupt

    first, arm = Arm(links=4), Arm(links=6)
    bend = np.repeat(arc.from_polar(np.array([0.3]), np.array([1.0])), 8, axis=0)
    with pytest.raises(InterruptedMany) as caught:
        simulate_many(
            [first] + [arm] * count, moving(arm, bend), ["servo"] * count + [Nervous(press)], stepping=Stepping()
        )
    assert [one is not None for one in caught.value.results] == [True] + [False] * count
    assert "1 of" in str(caught.value)


def test_arguments_of_unlike_counts_are_refused():
    arm = Arm(links=6)
    spiral = along(arm, "circle", 0.2, max_bend=0.3)
    with pytest.raises(InputError, match="references"):
        simulate_many([arm] * 3, [spiral] * 2)
    with pytest.raises(InputError, match="backend"):
        simulate_many(arm, spiral, backend="cloud")
    with pytest.raises(InputError, match="threads"):
        simulate_many(arm, spiral, threads=-1)
    with pytest.raises(InputError, match="controller"):
        simulate_many(arm, spiral, ["servo", "pid"])
    assert simulate_many([], spiral) == []
