"""What is said of a run's numbers, word by word, from summaries written by hand."""

import pytest
from references import along

from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.results.document import document
from contarm_sim.studies.judged_run import judge_run
from contarm_sim.view.report.words import (
    available,
    budget,
    curvature_words,
    explanation,
    in_short,
    muscle_words,
    remarks,
    simulation_words,
    targets_words,
    verdict_lines,
)

ARM = {"muscle": {"min_pressure": 90e3, "max_pressure": 700e3}}


def spread(mm):
    return {"max_m": 1e-3 * mm, "rms_m": 5e-4 * mm, "max_percent": mm / 3.7, "rms_percent": mm / 7.4}


def check(name="slack", value=2.0, limit=1.0, unit="%", passed=False, reason="why", group="explained"):
    return {
        "name": name, "value": value, "limit": limit, "unit": unit, "passed": passed, "reason": reason, "group": group
    }  # fmt: skip


TARGETS = check("targets off the dome", 0.25, 0.5, "% of length", True, "", "targets")
MUSCLE = {
    "min_force_n": 3.25, "max_force_n": 41.0, "pushes": 0, "push_fraction": 0.0, "largest_push_n": 0.0,
    "slack_fraction": 0.125, "max_pressure_needed_pa": 412.3e3, "min_contraction": -0.051, "max_contraction": 0.113,
    "beyond_max_pressure": 0, "below_min_pressure": 0,
}  # fmt: skip
SUMMARY = {
    "controller": "servo", "holds_lengths": True, "pulls_only": True,
    "samples": 200, "arm": ARM, "muscle": MUSCLE, "verdict": "pass", "explained": True,
    "converged": True, "targets_met": True, "checks": [TARGETS],
    "constant_curvature": {"holds": True, "error_percent": 0.421, "limit_percent": 1.0},
    "time_step": {"max_m": 2e-5, "rms_m": 1e-5, "max_percent": 0.005, "rms_percent": 0.003, "timestep_s": 0.001,
                  "compared": True},
    "target_error": spread(1.5), "tip_error": spread(1.25), "discretisation": spread(0.5), "servo": spread(0.25),
    "shape": spread(1.0), "sag": None, "inertia": None, "unexplained": spread(0.02), "motion": spread(0.75),
    "backbone_error": spread(1.75), "miss": spread(0.0),
}  # fmt: skip


def test_the_budget_lists_what_is_known_in_millimetres_and_percent():
    rows = dict(budget(SUMMARY))
    assert [name.strip().split(":")[0] for name in rows] == [
        "target against simulated tip", "analytic against simulated tip", "discretisation", "servo", "shape",
        "not explained (vs ideal rod in motion)", "motion", "largest along the backbone", "miss (target vs dome)",
        "time step",
    ]  # fmt: skip
    assert rows["target against simulated tip"] == pytest.approx([1.5, 0.75, 1.5 / 3.7, 1.5 / 7.4])
    assert rows["time step: 1 ms, its own error"] == pytest.approx([0.02, 0.01, 0.005, 0.003])
    unknown = SUMMARY | {"time_step": {"max_m": None}, "controller": "tip", "holds_lengths": False}
    assert not any("time step" in name for name, _ in budget(unknown))
    assert any("shifted for the tip" in name for name, _ in budget(unknown))


@pytest.mark.parametrize(
    ("found", "said"),
    [
        ({"holds": True, "error_percent": 0.421, "limit_percent": 1.0}, "holds within 0.42 % of length (limit 1 %)"),
        (
            {"holds": False, "error_percent": 5.04, "limit_percent": 1.0, "sag_percent": 4.96, "motion_percent": 0.4},
            "does not hold: the error is 5.0 % of length (limit 1 %); causes, each alone: sag 5.0 %",
        ),
        (
            {"holds": False, "error_percent": 2.0, "limit_percent": 1.0, "discretisation_percent": 0.3},
            "does not hold: the error is 2.0 % of length (limit 1 %); causes, each alone: the chain of links 0.3 %",
        ),
        (
            {"holds": False, "error_percent": 2.0, "limit_percent": 1.0},
            "does not hold: the error is 2.0 % of length (limit 1 %)",
        ),
    ],
)
def test_constant_curvature_is_said_to_hold_or_why_not(found, said):
    assert curvature_words(found) == said


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "explained and converged: the tip is within 0.005 % of length of an ideal rod's"),
        (
            {"unexplained": spread(0.0)},
            "explained and converged: the tip is within 0.001 % of length of an ideal rod's",
        ),
        ({"converged": None}, "explained: the tip is within 0.005 % of length of an ideal rod's"),
        ({"converged": False, "unexplained": None}, "explained, but NOT converged"),
        (
            {"explained": False, "converged": False, "checks": [check(), TARGETS]},
            "NOT explained and NOT converged: slack 2 % (limit 1): why",
        ),
        (
            {"explained": False, "checks": [check(value=None, reason=""), TARGETS]},
            "NOT explained, but converged: slack is not known (limit 1)",
        ),
        ({"verdict": "not judged"}, "not judged"),
        ({"verdict": "no rest pose", "reason": "it buckles"}, "no rest pose: it buckles"),
    ],
)
def test_the_simulation_is_said_to_be_explained_and_converged_or_why_not(given, said):
    assert simulation_words(SUMMARY | given) == said


def test_targets_are_said_to_be_reachable_or_how_far_off():
    assert targets_words(SUMMARY) == "at most 0.25 % of length from the dome of reachable tips (limit 0.5 %)"
    far = TARGETS | {"value": 16.04, "passed": False, "reason": "use --project"}
    assert targets_words({"checks": [far]}) == "targets off the dome 16.04 % of length (limit 0.5): use --project"
    unchecked = SUMMARY | {"time_step": SUMMARY["time_step"] | {"compared": False}}
    for summary, ending in (
        (SUMMARY, "within 0.005 % of length of an ideal rod's"),
        (unchecked, "; the time step was not checked"),
    ):
        names, sentences = zip(*verdict_lines(summary), strict=True)
        assert names == ("constant curvature", "simulation", "targets")
        assert sentences[1].endswith(ending)


def test_a_caption_says_it_in_short():
    said = in_short(SUMMARY)
    assert said == "constant curvature holds within 0.42 % of length   simulation explained within 0.005 %"
    bad = {"explained": False, "targets_met": False}
    bad["constant_curvature"] = {"holds": False, "error_percent": 5.0, "limit_percent": 1.0}
    said = in_short(SUMMARY | bad)
    assert said.startswith(
        "constant curvature does not hold: largest in the run 5.00 % of length   simulation not explained"
    )
    assert said.endswith("   targets off the dome")
    assert in_short(SUMMARY | {"converged": False}).endswith("   simulation explained, not converged")
    assert in_short(SUMMARY | {"explained": None, "converged": None}).endswith("   simulation not judged")


def test_the_explanation_names_every_part_in_millimetres():
    said = explanation(SUMMARY)
    for part in (
        "an arc cause up to 0.500 mm",
        "lengths cause up to 0.250 mm",
        "angles cause up to 1.000 mm",
        "up to 0.750 mm of this",
    ):
        assert part in said
    assert "within 0.020 mm" in said
    assert "off the dome" not in said
    said = explanation(SUMMARY | {"miss": spread(12.0), "motion": None, "holds_lengths": False, "unexplained": None})
    assert "up to 12.00 mm off the dome" in said
    assert "motion" not in said
    assert "to bring the tip to its target: 0.250 mm" in said
    assert "ideal rod" not in said


def test_muscles_are_said_in_newtons_kilopascals_and_percent():
    words = dict(muscle_words(MUSCLE))
    assert words["tensions"] == "3.2 to 41.0 N"
    assert words["pushes"] == "0 % of muscle samples"
    assert words["slack"] == "12.5 % of muscle samples"
    assert words["highest pressure needed"] == "412 kPa"
    assert words["contractions"] == "-5.1 to 11.3 %"
    pushing = MUSCLE | {"pushes": 3, "push_fraction": 0.015, "largest_push_n": 1.26, "max_pressure_needed_pa": None}
    words = dict(muscle_words(pushing))
    assert words["pushes"] == "1.5 % of muscle samples, largest 1.3 N"
    assert words["highest pressure needed"] == "no pressure is enough"


def test_remarks_are_made_only_where_there_is_something_to_say():
    assert available(SUMMARY) == "90 to 700 kPa"
    assert remarks(SUMMARY) == []
    odd = {"pushes": 3, "push_fraction": 0.015, "largest_push_n": 1.26, "beyond_max_pressure": 7,
           "max_pressure_needed_pa": 744e3, "below_min_pressure": 5}  # fmt: skip
    found = remarks(SUMMARY | {"muscle": MUSCLE | odd, "motion": None})
    assert len(found) == 4
    for line, part in zip(
        found, ("unstable or has no equilibrium", "1.5 % of muscle samples", "744 kPa", "less than 90 kPa"), strict=True
    ):
        assert part in line
    assert "7 of 200 samples exceed this" in found[2]
    plain = remarks(SUMMARY | {"muscle": MUSCLE | odd, "pulls_only": False})
    assert len(plain) == 2  # plain servos know of no pressure and may push
    assert "not judged" in plain[0]


def test_the_summary_by_hand_is_made_of_keys_that_a_run_has():
    arm = Arm(links=6)
    real = document(judge_run(simulate(arm, along(arm, "circle", 0.3, max_bend=0.3)), 2))
    assert set(SUMMARY) - {"arm"} <= set(real)
    for name in ("muscle", "time_step", "tip_error"):
        assert set(SUMMARY[name]) <= set(real[name])
    assert set(TARGETS) == set(real["checks"][0])
    assert set(SUMMARY["constant_curvature"]) <= set(real["constant_curvature"])
