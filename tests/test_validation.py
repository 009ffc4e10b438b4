"""The comparison: its parts add up, its limits bite, and the stated accuracy is reached over the dome."""

import json

import mujoco
import numpy as np
import pytest
from references import resting
from scipy.spatial.transform import Rotation

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import EquilibriumError, InputError
from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.results.compare import rotation_angle
from contarm_sim.results.document import document
from contarm_sim.studies.at_rest import Failure, examine, stepping_speed
from contarm_sim.studies.attempts import attempt
from contarm_sim.studies.convergence import attempt_convergence, convergence
from contarm_sim.studies.scenarios import dome_grid, scenarios
from contarm_sim.studies.validation import validate


@pytest.fixture(scope="module")
def outcomes():
    bends = dome_grid(4)
    return {s.name: examine(s, bends) for s in scenarios(Arm())}


def test_ideal_reaches_the_stated_accuracy_over_the_whole_dome(outcomes):
    ideal = outcomes["ideal"]
    assert ideal.chain_error.max_m <= 2e-5
    assert ideal.errors.tip_error.max_percent <= 0.1
    assert ideal.errors.orientation_error_deg <= 0.05
    assert ideal.errors.muscle.pushes == 0
    assert ideal.errors.muscle.slack_fraction == 0
    assert ideal.verdict == "pass"


def test_discretisation_converges_with_second_order():
    study = convergence(Arm(), dome_grid(3))
    assert study.links == [12, 24, 48]
    np.testing.assert_allclose(study.observed_orders, 2, atol=0.1)


def test_the_papers_lengths_in_plain_servos_push_and_miss_more(outcomes):
    naive, ideal = outcomes["naive"], outcomes["ideal"]
    assert naive.errors.tip_error.max_m > 5 * ideal.errors.tip_error.max_m
    assert naive.errors.muscle.min_force_n < -20
    assert naive.errors.muscle.pushes > 0
    assert (naive.verdict, naive.judged.explained, naive.judged.checks) == ("not judged", None, ())
    assert naive.constant_curvature.holds


@pytest.mark.parametrize("name", ["gravity", "payload", "upright"])
def test_gravity_is_all_in_the_shape_term(outcomes, name):
    found = outcomes[name]
    errors, rod = found.errors, found.rod
    assert errors.servo.max_percent < 0.001
    assert errors.shape.max_percent > 5
    assert errors.shape.max_percent == pytest.approx(errors.tip_error.max_percent, rel=0.01)
    assert rod.unexplained.max_percent < 0.1
    assert rod.sag.max_percent == pytest.approx(errors.shape.max_percent, rel=0.01)
    assert (found.verdict, found.judged.explained) == ("pass", True)
    curvature = found.constant_curvature
    assert (curvature.holds, curvature.error_percent) == (False, errors.tip_error.max_percent)


@pytest.mark.parametrize("name", ["payload", "naive"])
def test_the_budget_is_that_of_chains_that_others_bend(outcomes, name):
    """As measured: hinges that MuJoCo turns, all alike, by what they turned in sum. As commanded: ball joints."""
    outcome = outcomes[name]
    c, arm, samples = outcome.comparison, outcome.scenario.arm, outcome.samples
    plant, measured, commanded, arcs = Plant(arm), [], [], []
    axes, half = plant.model.jnt_axis, np.array([0.0, 0.0, arm.link_pitch / 2])
    for qpos, (x, y) in zip(samples.qpos, samples.bend, strict=True):
        plant.data.qpos[:] = axes @ (qpos @ axes) / arm.links
        mujoco.mj_kinematics(plant.model, plant.data)
        measured.append(plant.tip.copy())
        turns = Rotation.from_rotvec(np.arange(arm.links + 1)[:, None] * [-y, x, 0.0] / arm.links).as_matrix()
        commanded.append((turns[:-1] @ half + turns[1:] @ half).sum(axis=0))
        angle = np.hypot(x, y)
        radial = (1 - np.cos(angle)) / angle**2 if angle else 0.5
        arcs.append(arm.length * np.array([radial * x, radial * y, np.sinc(angle / np.pi)]))
    simulated = samples.stations[:, -1]
    for found, one, two, near in (
        (c.discretisation, commanded, arcs, 2e-5),  # pairs of hinges are no ball joints
        (c.servo, measured, commanded, 2e-5),
        (c.shape, simulated, measured, 1e-9),
        (c.tip_error, simulated, arcs, 1e-12),
        (c.target_error, simulated, samples.target, 1e-12),
    ):
        np.testing.assert_allclose(found, np.linalg.norm(np.subtract(one, two), axis=1), atol=near)
    assert (c.shape if name == "payload" else c.servo).max() > 0.005 * arm.length


def test_small_sag_is_that_of_the_guided_beam():
    """A straight arm under a little sideways gravity: lengths fix the total bend, so the tip cannot turn."""
    arm = Arm(gravity=(0.05, 0, 0), payload=0.1, links=48)
    samples = poses_at_rest(arm, resting(arm, np.zeros((1, 2))))
    sag = 0.05 * (arm.mass / 24 + arm.payload / 12) * arm.length**3 / arm.bending_stiffness
    assert samples.stations[0, -1, 0] == pytest.approx(sag, rel=0.01)
    assert np.degrees(rotation_angle(samples.tip_rotation[0], np.eye(3))) < 1e-3


def test_rotation_angle_is_accurate_for_small_angles():
    for angle in (1e-9, 1e-4, 1.0, 3.0):
        R = arc.rotation([angle, 0.0])
        assert rotation_angle(R, np.eye(3)) == pytest.approx(angle, rel=1e-6)


def test_summaries_are_strict_json(outcomes):
    for outcome in outcomes.values():
        json.dumps(document(outcome), allow_nan=False)


@pytest.mark.parametrize("links", [6, 9, 14, 25])
def test_other_link_counts_pass_limits_scaled_to_them(links):
    outcome = examine(scenarios(Arm(links=links))[0], dome_grid(3))
    assert outcome.verdict == "pass", outcome.judged.checks


def test_an_arm_with_its_own_gravity_is_judged_under_it():
    given = scenarios(Arm(gravity=(1.0, 0, 0), payload=0.05))
    assert [s.name for s in given] == ["ideal", "naive", "gravity", "payload"]
    assert given[0].arm.gravity == (0, 0, 0)
    assert given[2].arm.gravity == (1.0, 0, 0)
    assert given[3].arm.payload == 0.05


def test_an_arm_that_blows_up_has_no_real_time_factor_and_writes_no_log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arm = Arm(mass=0.01, damping_time=0.0, muscle=McKibben(servo_time=0.0))
    outcome = examine(scenarios(arm)[0], dome_grid(2))
    assert outcome.real_time_factor is None
    assert stepping_speed(Arm(), examine(scenarios(Arm())[0], dome_grid(2)).samples) > 0
    assert list(tmp_path.iterdir()) == []


def test_a_scenario_without_rest_poses_is_a_failure_with_its_reason():
    found = [attempt(scenario, dome_grid(2)) for scenario in scenarios(Arm(bending_stiffness=0.02))]
    assert [isinstance(each, Failure) for each in found] == [False, False, False, False, True]
    upright = found[-1]
    assert upright.verdict == "no rest pose"
    assert upright.reason.startswith("at a bend of 0 deg")
    assert upright.setting.weight_over_stiffness > 10
    study = attempt_convergence(Arm(bending_stiffness=2.0), dome_grid(2))
    assert (study.verdict, "limit of 177 N" in study.reason) == ("no rest pose", True)


def test_a_link_error_that_cannot_be_found_costs_nothing_else(monkeypatch):
    from contarm_sim.studies import at_rest as module

    def none_for_more_links(arm, *given):
        if arm.links == 48:
            raise EquilibriumError("settling")
        return poses_at_rest(arm, *given)

    monkeypatch.setattr(module, "poses_at_rest", none_for_more_links)
    outcome = examine(scenarios(Arm())[2], dome_grid(2))
    assert outcome.link_error is None
    assert outcome.verdict == "pass"


def test_bends_up_to_a_largest_are_compared():
    found = validate(Arm(links=6), 2, max_bend=1.0)
    assert np.hypot(*found.bends.T).max() == pytest.approx(1.0)
    for wrong in (0, -1, 3.1, "x", True, np.nan):
        with pytest.raises(InputError, match="max_bend"):
            validate(Arm(links=6), 2, max_bend=wrong)
