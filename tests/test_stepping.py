"""Large steps of set-points, fast motions, unusual arms: nothing hunts, and the time step hardly matters."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from references import along, moving, resting

from contarm_sim.engine.plant import Plant, engine_room
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.servos import servo_control
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.mjcf import arm_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import STEP_LIMIT, Stepping, simulate

SCENE = Path(__file__).parents[1] / "models" / "contarm" / "scene.xml"
HANGING = {"gravity": (0.0, 0.0, 9.81), "payload": 0.1}


def _controls(arm, count, seed):
    rng = np.random.default_rng(seed)
    bend = arc.from_polar(np.radians(rng.uniform(5, 150, count)), rng.uniform(-np.pi, np.pi, count))
    return servo_control(routing.lengths_from_bend(bend, arm), holding_tensions(bend, arm), arm)


def _stepped(model, controls, timestep, seconds):
    """Step from set-points to set-points; return the tips and the largest swing of their last half second, both [m]."""
    model.opt.timestep = timestep
    data, tips, swings = mujoco.MjData(model), [], []
    base, tip = model.body("base").id, model.body("tip").id
    with engine_room():
        for control in controls:
            data.ctrl[:] = control
            mujoco.mj_step(model, data, round((seconds - 0.5) / timestep))
            late = []
            for _ in range(50):
                mujoco.mj_step(model, data, round(0.01 / timestep))
                late.append(data.xpos[tip] - data.xpos[base])
            tips.append(late[-1])
            swings.append(np.ptp(late, axis=0).max())
    assert not data.warning.number.any()
    return np.array(tips), max(swings)


@pytest.mark.parametrize(
    "arm", [Arm(), Arm(**HANGING), Arm(gravity=(9.81, 0, 0), links=12)], ids=["free", "hanging", "12"]
)
def test_no_servo_hunts_after_large_steps_of_its_set_points(arm):
    """Muscles at their force limit lose no damping: at 5 ms the arm comes to rest where it does at 0.5 ms."""
    controls = _controls(arm, 4, 1)
    rested, swing = _stepped(arm_spec(arm).compile(), controls, 0.005, 6.0)
    fine, _ = _stepped(arm_spec(arm).compile(), controls, 0.0005, 6.0)
    assert swing < 2e-4 * arm.length
    assert np.linalg.norm(rested - fine, axis=1).max() < 5e-4 * arm.length


def test_the_committed_scene_comes_to_rest_under_plain_steps():
    """From its keyframe to an 86 degree bend, as anybody would try it."""
    model = mujoco.MjModel.from_xml_path(str(SCENE))
    bend = arc.from_polar(1.5, 0.6)
    control = servo_control(routing.lengths_from_bend(bend, Arm()), holding_tensions(bend, Arm()), Arm())
    _, swing = _stepped(model, control[None], 0.005, 4.0)
    assert swing < 1e-5


def test_at_zero_control_the_committed_arm_stays_straight():
    model = mujoco.MjModel.from_xml_path(str(SCENE))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 200)
    np.testing.assert_allclose(data.actuator_force, -Arm().muscle.min_tension, rtol=1e-6)
    assert np.abs(data.qpos).max() < 1e-9


@pytest.mark.parametrize("kp", [2e4, 3e5])
def test_softer_and_stiffer_servos_do_not_hunt_either(kp):
    arm = Arm(muscle=McKibben(servo_stiffness=kp, servo_time=0.005))
    _, swing = _stepped(arm_spec(arm).compile(), _controls(arm, 4, 2), 0.005, 4.0)
    assert swing < 1e-3 * arm.length


@pytest.mark.parametrize(("timestep", "most", "share"), [(0.005, 30.0, 0.005), (0.001, 0.2, 0.005)])
def test_damping_hardly_pushes_a_muscle_that_the_servo_has_let_go_of(timestep, most, share):
    """After set-point steps of up to 150 degrees: tens of newtons for single steps of 5 ms, next to nothing at 1 ms."""
    plant, forces = Plant(Arm(), timestep=timestep), []
    with engine_room():
        for control in _controls(plant.arm, 6, 3):
            plant.control[:] = control
            for _ in range(round(2 / timestep)):
                mujoco.mj_step(plant.model, plant.data)
                assert plant.data.actuator_force.max() <= 0  # the servo itself never does
                forces.append(plant.actuator_tensions.min())
    assert min(forces) > -most
    assert np.mean(np.array(forces) < -0.1) < share


def _spiral(arm, duration):
    return along(arm, "spiral", duration)


def _off(arm, one, other):
    return np.linalg.norm(one.tip - other.tip, axis=1).max() / arm.length


def test_a_slow_path_takes_the_longest_step_and_a_fast_one_as_short_a_step_as_it_needs():
    arm = Arm()
    slow = simulate(arm, _spiral(arm, 10.0))
    assert slow.timestep == 0.005
    assert np.isnan(slow.step_error).any()  # seen in a window only
    fast = simulate(arm, _spiral(arm, 1.0))
    assert fast.timestep < 5e-4
    for run, duration in ((slow, 10.0), (fast, 1.0)):
        finer = simulate(arm, _spiral(arm, duration), stepping=Stepping(min(2.5e-4, 0.25 * run.timestep)))
        assert _off(arm, run, finer) < STEP_LIMIT
        assert np.nanmax(run.step_error) < STEP_LIMIT * arm.length


def test_a_step_that_is_asked_for_but_too_long_is_told():
    arm = Arm()
    spiral = _spiral(arm, 2.0)
    coarse = simulate(arm, spiral, stepping=Stepping(0.005), check_step=True)
    assert coarse.timestep == 0.005
    truth = _off(arm, coarse, simulate(arm, spiral, stepping=Stepping(1e-4)))
    assert truth > STEP_LIMIT
    assert coarse.step_error.max() / arm.length == pytest.approx(truth, rel=0.3)


@pytest.mark.parametrize("controller", ["paper", "servo", "pressure"])
def test_an_undamped_arm_gets_a_step_that_it_stands(controller):
    arm = Arm(damping_time=0.0, links=12, mass=0.1)
    spiral = _spiral(arm, 3.0).first(100)
    with pytest.raises(DivergenceError):
        simulate(arm, spiral, controller, stepping=Stepping(0.005))
    run = simulate(arm, spiral, controller)
    assert run.timestep < 0.005
    assert np.nanmax(run.step_error) < STEP_LIMIT * arm.length


def test_models_are_written_with_a_step_that_they_stand():
    arm = Arm(damping_time=0.0, mass=0.05)
    model = arm_spec(arm).compile()
    assert model.opt.timestep < 0.005
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    with engine_room():
        for _ in range(2000):
            data.ctrl[:] = rng.uniform(*model.actuator_ctrlrange.T)
            mujoco.mj_step(model, data)
    assert not data.warning.number.any()


def test_an_arm_that_no_step_suits_is_refused_with_the_remedy():
    arm = replace(Arm(), damping_time=0.0, mass=1e-9, bending_stiffness=1e3)
    with pytest.raises(InputError, match="more damping, fewer links"):
        simulate(arm, _spiral(arm, 1.0))


@pytest.mark.parametrize("count", [102, 115])
def test_the_steps_error_is_seen_wherever_the_arm_is_jolted(count):
    """The hardest moment lies at the very end of this motion, with or without a whole window before it."""
    arm = Arm(length=0.27, bending_stiffness=0.116, mass=0.163, muscle_radius=0.0252, links=12, payload=0.045)
    share = np.linspace(0, 1, count)
    share = share**2 * (3 - 2 * share)
    bend = arc.from_polar(0.3 + 0.7 * share, 2.4 - 1.5 * share)
    reference = moving(arm, bend)
    run = simulate(arm, reference, "pressure")
    finer = simulate(arm, reference, "pressure", stepping=Stepping(run.timestep / 8))
    truth = _off(arm, run, finer)
    assert truth < 0.5 * STEP_LIMIT
    assert np.nanmax(run.step_error) / arm.length > 0.7 * truth


def test_where_muscles_rub_the_whole_motion_is_compared():
    arm = Arm(links=8, muscle=McKibben(braid_friction=0.5))
    run = simulate(arm, _spiral(arm, 3.0))
    assert np.isfinite(run.step_error).all()


def test_twisting_arms_stand_still_where_they_rest():
    arm = Arm(links=12, torsional_stiffness=0.08, gravity=(9.81, 0.0, 0.0), payload=0.1)
    bend = np.repeat(arc.from_polar(np.radians([73.0]), np.radians(271.0)), 300, axis=0)
    stood = simulate(arm, moving(arm, bend), stepping=Stepping(0.005))
    rested = poses_at_rest(arm, resting(arm, bend[:1]))
    assert np.linalg.norm(stood.stations[-1, -1] - rested.stations[0, -1]) < 1e-5 * arm.length
    assert rested.muscle_tensions.min() == pytest.approx(arm.muscle.min_tension, abs=1e-6)
