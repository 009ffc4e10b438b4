"""Arms on MuJoCo Warp: against the chain's closed form, and against the engine itself in double precision.

On Warp's processor device, whose kernels take some 13 s of one processor to compile where none are kept yet; one test
has the arms for all that needs kernels.
"""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

from contarm_sim import Arm, paths, simulate_many
from contarm_sim.engine.plants import Plants
from contarm_sim.errors import InputError, MissingError
from contarm_sim.kinematics import hinges
from contarm_sim.mechanics.routing import lengths_from_bend
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.model.objects import Object
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference

pytestmark = pytest.mark.slow  # by hand: all checks are to take less than ten minutes

LINKS, LENGTH = 6, 0.37
BENDS = np.array([[0.0, 0.0], [1.0, 0.3], [-0.4, 1.2], [1e-7, 0.0]])
CLOSED_FORM = 1e-6 * LENGTH
"""Tolerance [m] of tips at rest against the closed form: thirty roundings of the length in single precision."""

ENGINE = 1e-6 * LENGTH
"""Tolerance [m] of tips after 1 s of motion against the engine in double precision."""

ANGLES = 1e-7
"""Tolerance [rad] of joint angles against the same after one step."""


@pytest.fixture(scope="module")
def kind():
    """Return `WarpPlants`, its kernels compiled quickly instead of well."""
    config = pytest.importorskip("warp").config
    pytest.importorskip("mujoco_warp")
    from contarm_sim.engine.warp import WarpPlants

    before, config.optimization_level = config.optimization_level, 0
    yield WarpPlants
    config.optimization_level = before


def loaded():
    """Return arms that differ in all that may: stiffness, damping, mass, gravity, payload, length, servo."""
    return [
        Arm(links=LINKS, length=LENGTH * (1 + 0.05 * k), gravity=(0.5 * k, 0, -9.81 + 3 * k), payload=0.02 * (k + 1),
            bending_stiffness=0.4 + 0.1 * k, damping_time=0.02 + 0.01 * k, mass=0.2 + 0.05 * k)
        for k in range(3)
    ]  # fmt: skip


def straight(plants):
    """Put arms straight, the controls of muscles at 0."""
    count, muscles = plants.zero.shape
    plants.restart(None, np.zeros((count, plants.models[0].nq)), np.zeros((count, muscles)))


def pull(tick):
    """Return controls of a motion [m], shape (3,)."""
    return -0.004 * np.arange(3) * (1 - np.cos(0.05 * tick))


def test_arms_at_rest_have_the_tips_of_the_closed_form(kind):
    """Set-points that hold uniform bends, and nothing else that acts: the chain comes to rest in these bends."""
    arm = Arm(links=LINKS, length=LENGTH, gravity=(0, 0, 0), damping_time=0.05)
    plants = kind([arm] * len(BENDS))
    straight(plants)
    plants.send(servo_control(lengths_from_bend(BENDS, arm), holding_tensions(BENDS, arm), arm))
    plants.step(400)
    plants.forward()
    assert np.abs(plants.qvel).max() < 1e-3
    off = np.linalg.norm(plants.tip - hinges.tip(BENDS, LENGTH, LINKS), axis=-1)
    assert off.max() < CLOSED_FORM, off


def test_unlike_arms_move_as_in_the_engine(kind):
    """One step, and 1 s; and controls that are known beforehand give the same, all in one go."""
    ours, engine, at_once = kind(loaded()), Plants(loaded()), kind(loaded())
    for plants in (ours, engine, at_once):
        straight(plants)
    for tick in range(200):
        for plants in (ours, engine):
            plants.send(np.tile(pull(tick), (3, 1)))
            plants.step()
        if tick == 0:
            assert np.abs(ours.qpos - engine.qpos).max() < ANGLES
            assert np.abs(engine.qpos).max() > 100 * ANGLES
    assert np.ptp(engine.tip, axis=0).max() > 0.01  # the arms differ
    assert np.abs(ours.tip - engine.tip).max() < ENGINE
    assert np.abs(ours.muscle_lengths - engine.muscle_lengths).max() < ENGINE
    assert np.abs(ours.muscle_tensions - engine.muscle_tensions).max() < 1e-5 * np.abs(engine.muscle_tensions).max()
    assert np.abs(ours.rotations - engine.rotations).max() < 1e-5
    assert np.abs(ours.batch.time - engine.batch.time).max() < 1e-12
    controls = np.stack([np.tile(pull(tick), (3, 1)) for tick in range(200)])
    for first in range(0, 200, 25):
        at_once.batch.roll(controls[first : first + 25])
    assert np.array_equal(at_once.state[:, 1:], ours.state[:, 1:])  # the first is the clock


def test_arms_go_on_from_copied_states_and_alone(kind):
    plants = kind(loaded())
    straight(plants)
    plants.send(np.tile(pull(60), (3, 1)))
    plants.step(20)
    kept = plants.state.copy()
    plants.step(20)
    end = plants.state.copy()
    plants.state[:] = kept
    plants.step(20, places=[0, 2])
    again = plants.state.copy()
    assert np.array_equal(again[[0, 2]], end[[0, 2]])
    assert np.allclose(again[1], kept[1], rtol=1e-7, atol=0)
    assert not np.array_equal(kept, end)


def test_an_arm_that_diverges_is_told_of_and_leaves_the_others_alone(kind):
    plants, others = kind(loaded()), kind(loaded())
    for each in (plants, others):
        straight(each)
        each.send(np.tile(pull(60), (3, 1)))
        each.step(5)
    plants.qvel[1, 4] = np.nan
    for each in (plants, others):
        for _ in range(10):
            each.step()
    assert set(plants.failed) == {1}
    assert "diverged at t = 0.0" in str(plants.failed[1])
    assert np.array_equal(plants.state[[0, 2]], others.state[[0, 2]])
    assert np.isfinite(plants.state).all()
    plants.reset([1])
    assert not plants.failed


def test_parameters_follow_their_arm(kind):
    """An arm that takes another's place behaves as that one does."""
    arms = loaded()
    plants, other = kind(arms), kind([arms[2], arms[1], arms[0]])
    plants.become({0: arms[2], 2: arms[0]})
    for each in (plants, other):
        straight(each)
        each.send(np.tile(pull(60), (3, 1)))
        each.step(20)
    assert np.array_equal(plants.qpos, other.qpos)


def spiral(arm, duration=0.3):
    return Reference.from_path(paths.named("spiral", arm.length, duration, turns=0.2), arm)


def test_motions_on_this_backend_are_those_of_the_processor(kind):
    """With feedback and without; muscles in other places, or that push, in groups of their own; one ends earlier."""
    arms = [*loaded(), Arm(links=LINKS, muscle_radius=0.03), loaded()[0]]
    references = [spiral(arm, 0.2 if number == 1 else 0.3) for number, arm in enumerate(arms)]
    controllers = ["servo", "servo", "tip", "servo", "chain"]
    steppings = [None, None, Stepping(), Stepping(), Stepping()]  # None: found, by several passes
    given = {"stepping": steppings, "check_step": False}
    cpu, warp = (simulate_many(arms, references, controllers, backend=name, **given) for name in ("cpu", "warp"))
    for ours, theirs in zip(warp, cpu, strict=True):
        assert len(ours) == len(theirs)
        assert ours.timestep == theirs.timestep
        assert np.abs(ours.tip - theirs.tip).max() < ENGINE
        assert np.abs(ours.setpoint - theirs.setpoint).max() < ENGINE
        assert not np.array_equal(ours.tip, theirs.tip)  # in another precision


# What compiles nothing.


@pytest.mark.parametrize("name", ["EULER", "RK4", "IMPLICIT", "DISCRETE"])
def test_only_the_proven_integrator_is_offered(kind, name):
    with pytest.raises(InputError, match="implicitfast on the backend warp") as refused:
        kind([Arm(links=LINKS)], integrator=getattr(mujoco.mjtIntegrator, f"mjINT_{name}"))
    assert name.lower() in str(refused.value)


def test_motions_with_other_integrators_are_refused(kind):
    arm = Arm(links=LINKS)
    with pytest.raises(InputError, match="integrator is rk4; allowed: implicitfast"):
        simulate_many(arm, spiral(arm), stepping=Stepping(0.005, mujoco.mjtIntegrator.mjINT_RK4), backend="warp")


def test_arms_that_can_touch_something_are_refused(kind):
    arm = Arm(links=4, objects=(Object(name="wall", shape="plane", position=(0, 0, 1), axis=(0, 0, -1)),))
    (refusal,) = simulate_many([arm], Reference.from_path(paths.named("circle", LENGTH, 0.1), arm), backend="warp")
    assert refusal.name == "objects"
    with pytest.raises(InputError, match="wall"):
        kind([arm])


def test_muscles_in_other_places_are_refused(kind):
    plants = kind([Arm(links=LINKS), Arm(links=LINKS, muscle_radius=0.03)])
    with pytest.raises(InputError, match="differ in the places of muscles along the backbone"):
        plants.step()


def test_without_the_library_one_line_says_how_to_get_it(monkeypatch):
    from contarm_sim.engine.warp import WarpPlants

    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    with pytest.raises(MissingError, match=r"mujoco-warp is not installed; get it with: pip install '\.\[warp\]'"):
        WarpPlants([Arm(links=LINKS)])
    with pytest.raises(MissingError, match="mujoco-warp is not installed"):
        simulate_many(Arm(links=LINKS), spiral(Arm(links=LINKS)), backend="warp")


def test_nothing_of_warp_loads_with_the_engine():
    code = "import sys, contarm_sim.engine.plants, contarm_sim.cli.main; sys.exit('warp' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "actuation", "tolerance"),
    [
        ({}, "lengths", 1e-6),
        ({}, "tensions", 1e-6),
        ({}, "pressures", 1e-6),
        ({"path": "spans"}, "lengths", 3e-5),
        ({"torsional_stiffness": 0.5}, "lengths", 1e-6),
        ({"torsional_stiffness": 0.5}, "tensions", 1e-6),
        ({"joint_friction": 0.002}, "lengths", 1e-4),
    ],
)
@pytest.mark.parametrize("links", [6, 24])
def test_all_kinds_of_arms_move_as_in_the_engine(kind, given, actuation, tolerance, links):
    """1 s of every actuation, and of all that arms may have; tips within a share of length."""
    arms = [Arm(links=links, gravity=(0.3, 0, -9.81 + k), payload=0.02 * (k + 1), **given) for k in range(3)]
    both = kind(arms, actuation), Plants(arms, actuation)
    scale = {"lengths": -0.01, "tensions": 8.0, "pressures": 1e5}[actuation]
    for plants in both:
        straight(plants)
        for tick in range(200):
            plants.stiffen_twist()
            plants.send(np.tile(scale * np.arange(3) * (1 - np.cos(0.05 * tick)), (3, 1)))
            plants.step()
        plants.forward()
    assert np.abs(both[1].tip[:, :2]).max() > 0.01 * arms[0].length
    assert np.abs(both[0].tip - both[1].tip).max() < tolerance * arms[0].length
