"""Poses at rest of arms of every size, weight and stiffness: found where the ideal rod stands, else refused."""

from dataclasses import replace

import numpy as np
import pytest
from random_arms import can_stand, random_arm
from references import moving, resting
from rod import parallel_rod

from contarm_sim.control.feedback import Seen
from contarm_sim.control.servo import LengthFeedback, Servo
from contarm_sim.control.tip_motion import plan_motion, plan_rest
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import EquilibriumError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import pneumatics, routing
from contarm_sim.mechanics.servos import servo_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.statics.solver import Solver, tolerance


def _random_bend(rng):
    return arc.from_polar(rng.uniform(0, 2.2) * (rng.random() < 0.8), rng.uniform(-3, 3))


def _at_rest(arm, bend, controller="servo"):
    bend = np.atleast_2d(bend)
    return poses_at_rest(arm, resting(arm, bend), controller)


def test_every_random_arm_that_can_stand_is_found_at_rest():
    rng, standing = np.random.default_rng(0), 0
    for _ in range(24):
        arm, bend = random_arm(rng), _random_bend(rng)
        if can_stand(arm, bend):
            standing += 1
            samples = _at_rest(arm, bend)
            assert samples.muscle_tensions.max() <= arm.muscle.blocked_force
            assert samples.muscle_tensions.min() == pytest.approx(arm.muscle.min_tension, abs=1e-6)
            lengths = routing.lengths_from_bend(bend, arm)
            np.testing.assert_allclose(samples.muscle_lengths[0], lengths, atol=1e-12 + 1e-12 * arm.length)
    assert standing > 8


def test_what_is_found_is_the_ideal_rod():
    """Of finer and finer chains, with second order."""
    rng, seen = np.random.default_rng(3), 0
    while seen < 4:
        arm, bend = random_arm(rng), _random_bend(rng)
        heavy = arm.mass * np.linalg.norm(arm.gravity) * arm.length**2 / arm.bending_stiffness
        if not 1 < heavy < 20 or not can_stand(arm, bend):
            continue
        seen += 1
        rod = parallel_rod(arm, lengths=arc_lengths(arm, bend))
        errors = [
            np.linalg.norm(_at_rest(replace(arm, links=links), bend).stations[0, -1] - rod.tip) for links in (30, 60)
        ]
        assert errors[1] < 2e-3 * arm.length
        assert errors[0] / errors[1] == pytest.approx(4, rel=0.2)


def arc_lengths(arm, bend):
    angles = np.radians([0.0, 120.0, 240.0])
    return arm.length - arm.muscle_radius * (bend[0] * np.cos(angles) + bend[1] * np.sin(angles))


def test_every_random_arm_settles_under_any_set_points():
    """Energy is bounded below, so there always is a pose, muscles slack or at their limit as may be."""
    rng = np.random.default_rng(4)
    for _ in range(40):
        arm, bend = random_arm(rng, twist=0.4, spans=0.3), _random_bend(rng)
        plant = Plant(arm)
        plant.reset(bend)
        setpoint = rng.uniform(*arm.setpoint_range, size=3)
        solver = Solver(plant)
        assert solver(setpoint) <= tolerance(arm)
        assert solver.softest() > 0
        assert solver.iterations < 700


@pytest.mark.parametrize("twist", [None, 0.05])
@pytest.mark.parametrize("path", ["parallel", "spans"])
def test_one_newton_finds_what_the_controller_at_rest_ends_in(path, twist):
    """Settling and correcting set-points by turns, as the controller in motion does, comes to the same pose."""
    arm = Arm(gravity=(1.0, 2.0, 8.0), payload=0.05, torsional_stiffness=twist, path=path)
    bend = np.array([[1.1, -0.7]])
    orders = Servo().plan(arm, resting(arm, bend))
    plant, feedback = Plant(arm), LengthFeedback(arm, orders.lengths)
    plant.reset(bend[0])
    solver = Solver(plant)
    for _ in range(60):
        solver(orders.setpoint[0] + feedback.value)
        used = orders.setpoint[0] + feedback.value
        seen = Seen.of(plant)
        feedback.update(0, seen, gain=1.0)
    samples = _at_rest(arm, bend)
    np.testing.assert_allclose(samples.stations[0, -1], plant.tip, atol=1e-8)
    np.testing.assert_allclose(samples.setpoint[0], used, atol=1e-8)


def test_pressures_at_rest_hold_the_bend_and_are_the_least():
    arm, bend = Arm(gravity=(2.0, 0.0, 9.0), payload=0.03), arc.from_polar(0.8, 0.7)
    samples = _at_rest(arm, bend, "pressure")
    pressures, lengths = samples.setpoint[0], samples.muscle_lengths[0]
    np.testing.assert_allclose(lengths, routing.lengths_from_bend(bend, arm), atol=1e-12)
    np.testing.assert_allclose(samples.muscle_tensions[0], pneumatics.force(pressures, lengths, arm), rtol=1e-9)
    per_pascal = pneumatics.force(1.0, lengths, arm)
    least = np.maximum(arm.pneumatics.min_pressure, arm.muscle.min_tension / per_pascal)
    assert (pressures - least).min() == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize(
    ("arm", "bend", "said"),
    [
        (Arm(bending_stiffness=2.0), 1.5, "limit of 177 N and would need 455"),
        (
            Arm(bending_stiffness=0.02, gravity=(0.0, 0.0, -9.81)),
            0.0,
            "buckles under its own weight: m g L^2/EI is 20.1",
        ),
        (Arm(length=0.1, muscle_radius=0.025, bending_stiffness=1e-3), 2.0, "set-point of"),
    ],
)
def test_where_there_is_no_rest_it_says_why(arm, bend, said):
    with pytest.raises(EquilibriumError) as caught:
        _at_rest(arm, arc.from_polar(bend, 0.0))
    assert said in str(caught.value)
    assert "at a bend of" in str(caught.value)
    assert isinstance(caught.value, EquilibriumError)


SHORT = Arm(length=0.25, muscle_radius=0.012, bending_stiffness=0.02, mass=0.12, gravity=(0.0, 0.0, 9.81), payload=0.05)


@pytest.mark.parametrize("links", [6, 12, 15, 18, 48])
def test_the_tip_is_planned_at_every_link_count(links):
    arm = replace(SHORT, links=links)
    bend = arc.from_polar(np.radians([0, 30, 60, 90, 120]), np.radians([0, 50, 120, 200, 300]))
    target = arc.position(bend, arm.length)
    plain, planned = (poses_at_rest(arm, resting(arm, bend, target), name) for name in ("servo", "tip"))
    off = [np.linalg.norm(samples.stations[:, -1] - target, axis=1) for samples in (plain, planned)]
    assert np.all(off[1] <= off[0] + 1e-9)
    left = np.einsum("tij,tj->ti", plan_rest(arm, bend, target).tip_to_bend, target - planned.stations[:, -1])
    np.testing.assert_allclose(left, 0, atol=2e-6)


def test_the_tip_is_planned_wherever_the_servo_rests():
    rng, planned = np.random.default_rng(6), 0
    for _ in range(25):
        arm, bend = random_arm(rng), _random_bend(rng)
        try:
            plain = _at_rest(arm, bend)
        except EquilibriumError:
            continue
        planned += 1
        target = arc.position(bend, arm.length)
        off = np.linalg.norm(_at_rest(arm, bend, "tip").stations[0, -1] - target)
        assert off <= np.linalg.norm(plain.stations[0, -1] - target) + 1e-6 * arm.length
    assert planned > 10


def test_planned_set_points_are_smooth():
    """No bursts: over ticks of 10 ms tensions change their rate by less than the path alone asks, within 1 %."""
    arm, time = replace(SHORT, links=12), np.arange(0, 3, 0.01)
    bend = arc.from_polar(1.6 * np.sin(np.pi * time / 6) ** 2, 2 * np.pi * time / 3)
    orders = plan_motion(arm, moving(arm, bend))
    tensions = servo_tensions(orders.setpoint, orders.lengths, arm)
    assert np.abs(np.diff(tensions, 2, axis=0)).max() < 0.01 * np.ptp(tensions)
