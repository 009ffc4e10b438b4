"""Motion: determinism, timing of samples, divergence, interruption, and accuracy of the default step."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from references import along, moving, resting

from contarm_sim.control.tip_motion import plan_rest
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import DivergenceError, InputError, Interrupted
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import routing
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import ACCURATE, FAST, STEP_LIMIT, Stepping, simulate
from contarm_sim.results.trajectory import Trajectory


def _spiral(arm, duration=1.0, **shape):
    return along(arm, "spiral", duration, **shape)


@pytest.fixture(scope="module")
def recorded():
    arm = Arm()
    return arm, simulate(arm, _spiral(arm, 2.0, turns=0.5, max_bend=1.0))


def test_the_same_input_gives_bit_identical_samples(recorded):
    arm, run = recorded
    assert run == simulate(arm, _spiral(arm, 2.0, turns=0.5, max_bend=1.0))


def test_poses_belong_to_the_sampled_time(recorded):
    """Recomputing every pose from the recorded joint angles gives the recorded pose, not the one a step earlier."""
    arm, run = recorded
    plant = Plant(arm)
    for i in range(0, len(run), 25):
        plant.data.qpos[:] = run.qpos[i]
        mujoco.mj_forward(plant.model, plant.data)
        np.testing.assert_allclose(plant.stations, run.stations[i], atol=1e-15)
        np.testing.assert_allclose(plant.muscle_lengths, run.muscle_lengths[i], atol=1e-15)
        np.testing.assert_allclose(plant.tip_rotation, run.tip_rotation[i], atol=1e-15)
    np.testing.assert_allclose(run.time, np.arange(201) / 100, atol=1e-9)


def test_tensions_are_those_of_the_servo_law(recorded):
    arm, run = recorded
    s = run
    speed = np.gradient(s.muscle_lengths, 0.01, axis=0)
    changes = s.muscle_lengths - arm.length
    servo = arm.servo_stiffness * (changes - s.setpoint) + arm.muscle.min_tension
    expected = servo + arm.servo_stiffness * arm.servo_time * speed
    assert servo[5:-5].min() > 0
    np.testing.assert_allclose(s.muscle_tensions[5:-5], expected[5:-5], atol=1.0)


def test_a_motion_stays_near_the_arc_and_every_muscle_pulls(recorded):
    arm, run = recorded
    error = np.linalg.norm(run.stations[:, -1] - arc.position(run.bend, arm.length), axis=-1)
    assert error.max() < 0.02 * arm.length
    assert run.muscle_tensions.min() > 0.5 * arm.muscle.min_tension


def test_the_default_step_errs_by_less_than_a_fiftieth_of_a_percent(recorded):
    """Against ten times finer stepping, hanging with a payload too; --fast is about twice as coarse."""
    for arm in (Arm(), Arm(gravity=(0, 0, 9.81), payload=0.1)):
        reference = _spiral(arm, 3.0, turns=0.6)
        fine = simulate(arm, reference, stepping=Stepping(ACCURATE.timestep / 10)).stations[:, -1]
        for stepping, limit in ((ACCURATE, 2e-4), (FAST, 5e-4)):
            coarse = simulate(arm, reference, stepping=stepping).stations[:, -1]
            assert np.linalg.norm(coarse - fine, axis=-1).max() < limit * arm.length


def test_divergence_raises_with_time_dof_and_settings_and_leaves_no_log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    wild = Arm(damping_time=0.0, mass=0.01, muscle=McKibben(servo_stiffness=1e7, servo_time=0.0))
    with pytest.raises(DivergenceError) as caught:
        simulate(wild, _spiral(wild), controller="paper", stepping=ACCURATE)
    error = caught.value
    assert 0 < error.time < 1
    assert error.joint.startswith("joint_")
    assert error.settings["timestep"] == ACCURATE.timestep
    assert not list(tmp_path.iterdir())


def test_ctrl_c_keeps_what_was_recorded():
    arm = Arm()

    def press(count):
        if count == 40:
            raise KeyboardInterrupt

    reference = _spiral(arm)
    with pytest.raises(Interrupted) as caught:
        simulate(arm, reference, stepping=ACCURATE, on_tick=press)
    run = caught.value.trajectory
    assert isinstance(caught.value, KeyboardInterrupt)
    assert run.status == "interrupted"
    assert len(run) == 40
    whole = simulate(arm, reference, stepping=ACCURATE)
    assert replace(run, status="finished") == whole.first(40)


def test_ctrl_c_while_a_finer_step_is_tried_keeps_the_coarser_run():
    arm, seen = Arm(), []

    def press(count):
        seen.append(count)
        if len(seen) > 150:
            raise KeyboardInterrupt

    reference = _spiral(arm)
    with pytest.raises(Interrupted) as caught:
        simulate(arm, reference, on_tick=press)
    run = caught.value.trajectory
    assert run.status == "interrupted"
    assert len(run) == len(reference)
    again = simulate(arm, reference, stepping=Stepping(run.timestep))
    assert replace(run, status="finished", step_error=None) == again
    assert np.nanmax(run.step_error) > STEP_LIMIT * arm.length


def test_a_step_that_does_not_divide_the_tick_is_refused():
    arm = Arm()
    with pytest.raises(InputError, match="whole fraction"):
        simulate(arm, _spiral(arm), stepping=Stepping(0.003))
    with pytest.raises(InputError, match="paper, chain"):
        simulate(arm, _spiral(arm), controller="pid")


def test_controllers_improve_from_paper_to_servo():
    """With a soft servo under gravity, each step of the ladder follows lengths better than the one before."""
    arm = Arm(gravity=(0, 0, 9.81), muscle=McKibben(servo_stiffness=2e4))
    bend = np.repeat(arc.from_polar(np.array([1.5]), 0.5), 201, axis=0)
    reference, errors = moving(arm, bend), []
    for controller in ("paper", "feedforward", "servo"):
        s = simulate(arm, reference, controller)
        wanted = s.bend[-1]
        measured, _ = routing.bend_from_lengths(s.muscle_lengths[-1], arm)
        errors.append(np.linalg.norm(measured - wanted))
    assert errors[0] > 4 * errors[1] > 20 * errors[2]


def test_samples_survive_the_disk(recorded, tmp_path):
    _, run = recorded
    run.save(tmp_path / "trajectory.npz")
    assert Trajectory.load(tmp_path / "trajectory.npz") == run
    (tmp_path / "bad.npz").write_text("no")
    with pytest.raises(InputError):
        Trajectory.load(tmp_path / "bad.npz")


@pytest.mark.parametrize(
    "arm",
    [Arm(links=7), Arm(torsional_stiffness=0.05), Arm(length=1.0, muscle_radius=0.05, mass=2.0, bending_stiffness=4.0)],
    ids=["7 links", "twists", "1 m"],
)
def test_unusual_arms_move_as_usual_ones_do(arm):
    """Without gravity every arm follows the arc, but for its links, and its muscles pull."""
    reference = _spiral(arm, 8.0, turns=0.2, max_bend=0.5)
    run = simulate(arm, reference)
    off = np.linalg.norm(run.tip - reference.target, axis=1)
    assert off.max() < 0.002 * arm.length
    links = 0.5**2 / (12 * arm.links**2)
    assert off[-1] < (links + 0.0005) * arm.length
    assert run.muscle_tensions.min() > 0.5 * arm.muscle.min_tension


def _tangents(arm, bend, step=1e-4):
    """Return where the resting tip goes as the bend that servos hold changes [m/rad], shape (T, 3, 2), by differences.

    Nothing of it is the planner's: poses of the `servo` controller, found from scratch.
    """
    changed = [
        [poses_at_rest(arm, resting(arm, bend + sign * step * one), "servo").tip for sign in (1, -1)]
        for one in np.eye(2)
    ]
    return np.stack([(more - less) / (2 * step) for more, less in changed], axis=-1)


def _along(tangents, offset):
    """Return the part of offsets (T, 3) in the planes of tangents (T, 3, 2)."""
    basis = np.linalg.qr(tangents)[0]
    return np.einsum("tij,tkj,tk->ti", basis, basis, offset)


def test_the_tip_is_brought_as_near_as_two_degrees_of_freedom_allow():
    """Hanging with 100 g and seeing its tip, what error is left at rest is normal to what lengths can change."""
    arm = Arm(gravity=(0, 0, 9.81), payload=0.1)
    bend = arc.from_polar(np.array([0.6, 1.4]), np.array([0.3, -2.0]))
    target = arc.position(bend, arm.length)
    blind, seeing = (poses_at_rest(arm, resting(arm, bend, target), controller) for controller in ("servo", "tip"))
    before, after = (samples.stations[:, -1] - target for samples in (blind, seeing))
    assert np.all(np.linalg.norm(after, axis=1) < 0.5 * np.linalg.norm(before, axis=1))
    held, _ = routing.bend_from_lengths(seeing.muscle_lengths, arm)
    same = poses_at_rest(arm, resting(arm, held), "servo").tip
    np.testing.assert_allclose(same, seeing.stations[:, -1], atol=1e-7)
    assert np.abs(_along(_tangents(arm, held), after)).max() < 1e-6


def test_the_tip_controller_follows_a_slow_path_under_gravity():
    arm = Arm(gravity=(0, 0, 9.81))
    reference = _spiral(arm, 4.0, turns=0.5, max_bend=1.0)
    errors = {}
    for controller in ("servo", "tip"):
        offset = simulate(arm, reference, controller).tip - reference.target
        errors[controller] = np.sqrt(np.mean(np.sum(offset[100:] ** 2, axis=1)))
    assert errors["tip"] < 0.5 * errors["servo"]


def test_pressures_move_the_arm_within_their_limits():
    """Through McKibben muscles and valves; the lag of 50 ms is led, so the tip is not late."""
    arm = Arm()
    reference = _spiral(arm, 6.0, turns=1.0)
    samples = simulate(arm, reference, "pressure")
    error = np.linalg.norm(samples.tip - reference.target, axis=1)
    assert np.sqrt(np.mean(error[100:] ** 2)) < 0.01 * arm.length
    for pressures in (samples.setpoint, samples.pressure):
        assert pressures.min() >= 0.999 * arm.pneumatics.min_pressure
        assert pressures.max() <= 1.001 * arm.pneumatics.max_pressure
    lagging = np.gradient(samples.pressure, 0.01, axis=0) * arm.pneumatics.valve_time + samples.pressure
    np.testing.assert_allclose(lagging[20:-20], samples.setpoint[20:-20], rtol=0.02, atol=3e3)


def test_at_rest_pressures_bring_lengths_where_servos_would_under_load():
    arm = Arm(gravity=(0, 0, 9.81))
    bend = arc.from_polar(np.array([0.4, 1.2]), np.array([0.2, -2.0]))
    target = arc.position(bend, arm.length)
    pressed, served = (
        poses_at_rest(arm, resting(arm, bend, target), controller) for controller in ("pressure", "servo")
    )
    found = [routing.bend_from_lengths(s.muscle_lengths, arm)[0] for s in (pressed, served)]
    np.testing.assert_allclose(*found, atol=1e-5)
    assert pressed.pressure.min() >= arm.pneumatics.min_pressure * (1 - 1e-9)


def test_the_planned_tips_derivative_is_that_of_the_resting_tip():
    """Taken at the bend that the plan holds, which is some degrees further than the one asked for."""
    arm = Arm(gravity=(0, 0, 9.81), payload=0.1)
    bend = arc.from_polar(np.array([1.1, 0.4]), np.array([0.7, -2.5]))
    target = arc.position(bend, arm.length)
    planned = plan_rest(arm, bend, target)
    held, _ = routing.bend_from_lengths(planned.lengths, arm)
    assert np.linalg.norm(held - bend, axis=1).min() > 0.03
    np.testing.assert_allclose(
        planned.tip_to_bend @ _tangents(arm, held), np.broadcast_to(np.eye(2), (2, 2, 2)), atol=1e-4
    )


@pytest.mark.parametrize("load", [{}, {"gravity": (0, 0, 9.81), "payload": 0.1}])
def test_the_tip_controller_leaves_next_to_nothing_that_lengths_could_remove(load):
    """0.1 % of length, after the first second, along the surface that the tip can reach; free, in all."""
    arm = Arm(**load)
    reference = _spiral(arm, 5.0, turns=1.0)
    run = simulate(arm, reference, "tip")
    offset = (run.tip - reference.target)[100::20]
    held, _ = routing.bend_from_lengths(run.muscle_lengths[100::20], arm)
    left = _along(_tangents(arm, held), offset) if load else offset
    assert np.sqrt(np.mean(np.sum(left**2, axis=1))) < 1e-3 * arm.length
