"""Every check passes on a sound simulation, and fails on one that is wrong in just that."""

import json
from dataclasses import replace

import numpy as np
import pytest
from references import along

from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import STEP_LIMIT, simulate
from contarm_sim.studies import verdict as limits
from contarm_sim.studies.at_rest import examine
from contarm_sim.studies.checks import ideal_checks, loaded_checks
from contarm_sim.studies.scenarios import scenarios
from contarm_sim.studies.verdict import FAR_LIMIT, MODEL_LIMIT, at_most, verdict
from contarm_sim.view.report.run import RunReport
from contarm_sim.view.report.words import (
    budget,
    curvature_words,
    in_short,
    noted,
    remarks,
    simulation_words,
    targets_words,
)

HANGING = Arm(gravity=(0.0, 0.0, 9.81))


def _follow(arm, duration, controller="servo", **shape):
    return simulate(arm, along(arm, "spiral", duration, **shape), controller)


@pytest.fixture(scope="module")
def free():
    return _follow(Arm(), 5.0)


@pytest.fixture(scope="module")
def hanging():
    return _follow(HANGING, 4.0, turns=0.5)


@pytest.fixture(scope="module")
def soft():
    return _follow(replace(HANGING, bending_stiffness=0.01), 3.0)


def _judged(arm, run, controller="servo", step_error=None, **altered):
    run = replace(run, arm=arm, timestep=0.001, step_error=step_error, **altered)
    summary = RunReport(run, poses=20).summary
    json.dumps(summary, allow_nan=False, default=str)
    return summary


def _failed(summary):
    return [check["name"] for check in summary["checks"] if not check["passed"]]


def test_what_does_not_hold_constant_curvature_passes_if_it_is_explained(free, hanging):
    for arm, run in ((Arm(), free), (HANGING, hanging)):
        summary = _judged(arm, run)
        found = summary["constant_curvature"]
        assert not found["holds"]
        assert (found["error_percent"], found["limit_percent"]) == (summary["tip_error"]["max_percent"], MODEL_LIMIT)
        assert (summary["verdict"], summary["explained"], summary["targets_met"]) == ("pass", True, True)
        assert _failed(summary) == []
        assert summary["unexplained"]["max_percent"] < 0.05
        assert found["motion_percent"] == summary["motion"]["max_percent"]
        assert (found["sag_percent"] is None) is (arm is not HANGING)
        assert curvature_words(found).startswith("does not hold: ")
        assert simulation_words(summary).startswith("explained: ")


def test_a_holding_run_says_within_what():
    summary = _judged(Arm(), _follow(Arm(), 2.0, turns=0.1, max_bend=0.5))
    assert summary["constant_curvature"]["holds"]
    assert curvature_words(summary["constant_curvature"]).startswith("holds within 0.")
    assert in_short(summary).startswith("constant curvature holds within")


@pytest.mark.parametrize("wrong", [{"bending_stiffness": 0.105}, {"mass": 0.28}, {"gravity": (0.0, 0.5, 9.8)}])
def test_sag_that_the_arm_does_not_have_is_not_explained(hanging, wrong):
    summary = _judged(replace(HANGING, **wrong), hanging)
    assert _failed(summary) == ["not explained by an ideal rod"]
    assert (summary["verdict"], summary["explained"]) == ("fail", False)
    assert "NOT explained: not explained by an ideal rod" in simulation_words(summary)


@pytest.mark.parametrize("wrong", [{"mass": 0.36}, {"damping_time": 0.02}])
def test_motion_that_the_arm_does_not_make_is_not_explained(free, wrong):
    assert _failed(_judged(replace(Arm(), **wrong), free)) == ["not explained by an ideal rod"]


def test_the_rods_parts_add_up_to_the_shape(free):
    summary = _judged(Arm(), free)
    assert summary["sag"] is None
    assert summary["inertia"]["max_percent"] == pytest.approx(summary["shape"]["max_percent"], rel=0.05)


def test_a_pose_too_far_from_the_model_fails_though_the_rod_explains_it(soft):
    summary = _judged(replace(HANGING, bending_stiffness=0.01), soft)
    assert summary["unexplained"]["max_percent"] < 0.25
    assert summary["tip_error"]["max_percent"] > FAR_LIMIT
    assert _failed(summary) == ["distance from the model", "motion share"]


def test_lengths_that_are_not_held_fail(free):
    lengths = free.muscle_lengths + np.array([0.0, 1e-3, -1e-3])
    assert "servo holds lengths" in _failed(_judged(Arm(), free, muscle_lengths=lengths))


def _some(run, count, value):
    tensions = run.muscle_tensions.copy()
    tensions[:count, 0] = value
    return tensions


@pytest.mark.parametrize(("value", "name"), [(0.0, "slack"), (-0.1, "pushes")])
def test_a_moment_of_slack_or_of_pushing_passes_and_more_fails(free, value, name):
    once = _judged(Arm(), free, muscle_tensions=_some(free, 1, value))
    assert _failed(once) == []
    assert any("push" in remark and "damping" in remark for remark in remarks(once)) is (value < 0)
    assert _failed(_judged(Arm(), free, muscle_tensions=_some(free, 30, value))) == [name]


def test_a_deep_push_fails_however_short_and_says_how_deep(free):
    summary = _judged(Arm(), free, muscle_tensions=_some(free, 1, -20.0))
    assert _failed(summary) == ["largest push"]
    assert summary["muscle"]["largest_push_n"] == 20.0
    assert summary["muscle"]["push_fraction"] == pytest.approx(1 / (3 * len(free)))


def test_pushes_of_plain_servos_are_said_and_not_judged():
    summary = _judged(Arm(), _follow(Arm(), 5.0, "paper", turns=0.5), "paper")
    assert summary["muscle"]["push_fraction"] > 0.01
    assert _failed(summary) == []
    assert any("not judged" in remark for remark in remarks(summary))


@pytest.mark.parametrize(("factor", "name"), [(0.7, "contraction"), (1.3, "stretch")])
def test_lengths_beyond_the_braid_fail(free, factor, name):
    lengths = free.muscle_lengths.copy()
    lengths[7, 1] *= factor
    assert name in _failed(_judged(Arm(), free, muscle_lengths=lengths))


def test_the_time_step_is_checked_where_it_was_compared(free):
    count = len(free)
    small = np.full(count, np.nan)
    small[::10] = 1e-5
    for errors, converged, percent in (
        (None, None, None),
        (small, True, 1e-3 / 0.37),
        (1e2 * small, False, 0.1 / 0.37),
    ):
        summary = _judged(Arm(), free, step_error=errors)
        step = summary["time_step"]
        assert summary["converged"] is converged
        assert step["timestep_s"] == 0.001
        assert step["max_percent"] == (None if percent is None else pytest.approx(percent))
        assert _failed(summary) == (["time step"] if converged is False else [])
        assert any(name == "time step: 1 ms, its own error" for name, _ in budget(summary)) is (errors is not None)
        said = {
            None: "explained: ",
            True: "explained and converged: ",
            False: "explained, but NOT converged: time step",
        }
        assert simulation_words(summary).startswith(said[converged])
    blown = _judged(Arm(), free, step_error=np.full(count, np.inf))
    assert (_failed(blown), blown["converged"]) == (["time step"], False)
    assert "time step is not known" in simulation_words(blown)
    assert _judged(Arm(), free, step_error=np.full(count, np.nan))["converged"] is None


def test_the_step_that_is_found_meets_the_limit_that_judges_it():
    assert 100 * STEP_LIMIT == limits.STEP_LIMIT


def test_targets_off_the_dome_fail_and_millimetres_are_guessed(free):
    near = _judged(Arm(), free, target=1.005 * free.target)
    assert _failed(near) == []
    off = _judged(Arm(), free, target=1.1 * free.target)
    assert (_failed(off), off["explained"], off["targets_met"]) == (["miss"], True, False)
    assert "in metres?" not in targets_words(off)
    millimetres = _judged(Arm(), free, target=1e3 * free.target)
    assert _failed(millimetres) == ["miss"]
    assert "are they in metres?" in targets_words(millimetres)
    assert "targets off the dome" in in_short(millimetres)


def test_target_against_simulated_tip_comes_first(free):
    summary = _judged(Arm(), free, target=free.target + np.array([0.003, 0, 0]))
    first, second = budget(summary)[:2]
    assert first[0] == "target against simulated tip"
    assert second[0] == "analytic against simulated tip"
    offset = free.stations[:, -1] - free.target - np.array([0.003, 0, 0])
    assert first[1][0] == pytest.approx(1e3 * np.linalg.norm(offset, axis=1).max())
    assert second[1][0] == pytest.approx(1e3 * summary["tip_error"]["max_m"])


def test_a_film_drawn_later_says_the_same_and_nothing_where_nothing_is_told(free, tmp_path):
    summary = _judged(Arm(), free)
    assert noted(tmp_path) == ""
    for text in ("{", "[]", '{"constant_curvature": null}'):
        (tmp_path / "summary.json").write_text(text)
        assert noted(tmp_path) == ""
    (tmp_path / "summary.json").write_text(json.dumps(summary))
    assert noted(tmp_path) == in_short(summary) != ""


def test_a_number_that_is_not_known_fails():
    for value in (None, float("nan"), float("inf")):
        check = at_most("x", value, 1.0, "-")
        assert (check.value, check.passed) == (None, False)
    found = verdict([at_most("x", 0.5, 1.0, "-"), at_most("y", 2.0, 1.0, "-", "", "targets")])
    assert (found.verdict, found.explained, found.converged, found.targets_met) == ("fail", True, None, False)


RESTING = {
    "simulated against chain form": ("chain_error", 0.006),
    "simulated against arc": ("tip_error", 0.11),
    "tip orientation": ("orientation_error_deg", 0.06),
    "servo holds lengths": ("servo", 0.006),
    "not explained by an ideal rod": ("unexplained", 0.26),
    "distance from the model": ("tip_error", 26.0),
}


def _with(owner, name, value):
    """Return a copy of numbers in which one, or the largest percentage of one, is another."""
    if not hasattr(owner, name):
        return owner
    now = getattr(owner, name)
    return replace(owner, **{name: value if isinstance(now, float) else replace(now, max_percent=value)})


def test_every_check_at_rest_bites():
    bends = np.array([[0.5, 0.2], [1.5, -1.0]])
    ideal, _, gravity, *_ = scenarios(Arm())
    for scenario, checks in ((ideal, ideal_checks), (gravity, loaded_checks)):
        found = examine(scenario, bends)
        assert all(check.passed for check in found.judged.checks)
        for check in found.judged.checks:
            if check.name in RESTING:
                wrong = _with(found, *RESTING[check.name])
                errors, rod = _with(found.errors, *RESTING[check.name]), _with(found.rod, *RESTING[check.name])
                bitten = checks(scenario.arm, errors, rod, wrong.chain_error)
                assert [each.name for each in bitten if not each.passed] == [check.name]
