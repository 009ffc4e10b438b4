"""Contact as a part of the tip error: what objects move, beside the same motion without them."""

from dataclasses import replace

import numpy as np
import pytest
from references import along

from contarm_sim import Arm, compare, simulate, studies
from contarm_sim.errors import InputError
from contarm_sim.mechanics import shape
from contarm_sim.model.objects import Object
from contarm_sim.motion.lag import moved_by_motion
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference
from contarm_sim.results.document import document
from contarm_sim.results.trajectory import STEP_LIMIT
from contarm_sim.studies.explained import explain
from contarm_sim.view.report.budget import parts_of
from contarm_sim.view.report.words import budget

ALONE = Arm(links=12, gravity=(0, 0, 9.81))
POST = Object(name="post", shape="cylinder", radius=0.01, length=0.4, axis=(0, 1, 0), position=(0.14, 0, 0.3))
BALL = Object(name="ball", shape="sphere", radius=0.02, mass=0.05, position=(0, 0.4, 0.3))
STEP = Stepping()


def _bending():
    time = np.arange(0, 1.2, 0.01)
    bend = np.stack([0.9 * np.sin(0.5 * np.pi * np.minimum(time, 1)) ** 2, 0 * time], axis=1)
    return Reference(time, shape.position(bend, ALONE), bend, (ALONE.length,))


@pytest.fixture(scope="module")
def runs():
    """The same motion against a post, far from one, and alone."""
    arms = (replace(ALONE, objects=(POST, BALL)), replace(ALONE, objects=(replace(POST, position=(2, 0, 0)),)), ALONE)
    return [simulate(arm, _bending(), stepping=STEP) for arm in arms]


@pytest.fixture(scope="module")
def judged(runs):
    return [studies.judge_run(run, poses=10) for run in runs]


def test_without_contact_the_part_is_exactly_zero_and_all_others_are_those_of_the_arm_alone(judged):
    _, far, alone = (document(each) for each in judged)
    assert far["contact_error"] == {"max_m": 0, "rms_m": 0, "max_percent": 0, "rms_percent": 0}
    assert "contact_error" not in alone
    for name in ("tip_error", "discretisation", "servo", "shape", "sag", "inertia", "unexplained", "motion"):
        assert far[name]["max_m"] == pytest.approx(alone[name]["max_m"], abs=1e-9), name
    assert [check["passed"] for check in far["checks"]] == [check["passed"] for check in alone["checks"]]


def test_with_contact_the_part_is_the_difference_of_two_simulations(runs, judged):
    touching, _, alone = runs
    first = touching.contacts.sample[0]
    assert 20 < first < len(touching) - 20
    moved = np.linalg.norm(touching.tip - alone.tip, axis=1)
    contact = judged[0].comparison.contact
    assert (contact[:first] == 0).all()
    assert contact[first:] == pytest.approx(moved[first:], abs=1e-9)
    assert contact.max() > 0.005
    assert document(judged[0])["contact_error"]["max_m"] == contact.max()
    for name in ("sag", "inertia", "unexplained"):
        ours, theirs = getattr(judged[0].rod, name), getattr(judged[2].rod, name)
        assert ours.max_m == pytest.approx(theirs.max_m, abs=1e-8), name


def test_the_parts_add_up_to_the_tip_error(runs, judged):
    run, comparison = runs[0], judged[0].comparison
    free = studies.without_objects(run)
    for motion in (None, moved_by_motion(free, 10)):
        index, parts = parts_of(run, comparison, motion)
        total = sum(part.moved for part in parts)
        np.testing.assert_allclose(total, (comparison.simulated_tip - comparison.analytic_tip)[index], atol=1e-12)
        assert parts[-1].words.startswith("contact")
        assert np.linalg.norm(parts[-1].moved, axis=1) == pytest.approx(comparison.contact[index], abs=1e-15)


def test_what_contact_does_is_neither_sag_nor_unexplained(runs, judged):
    touching, comparison = runs[0], judged[0].comparison
    assert judged[0].judged.explained
    mixed = explain(replace(touching, arm=touching.arm.alone, contacts=None, objects=None), compare(touching), 10)
    assert np.nanmax(mixed.remainder) > 10 * judged[0].rod.unexplained.max_m
    assert judged[0].constant_curvature.contact_percent == pytest.approx(100 * comparison.contact.max() / ALONE.length)
    summary = document(judged[0]) | {"path": "x", "duration": 1.0}
    rows = dict(budget(summary))
    assert rows["  contact: with objects vs without"][0] == pytest.approx(1e3 * comparison.contact.max())


def test_other_motions_are_refused_and_one_that_was_interrupted_has_no_such_part(runs):
    touching, far, alone = runs
    for other, why in ((far, "arm"), (alone.first(50), "times"), (replace(alone, bend=alone.bend + 0.1), "bends")):
        with pytest.raises(InputError, match=why):
            compare(touching, other)
    cut = replace(touching, status="interrupted")
    with pytest.raises(InputError, match="interrupted"):
        studies.without_objects(cut)
    with pytest.raises(InputError, match="before it touches anything"):
        studies.without_objects(replace(touching, controller="paper"))
    found = studies.judge_run(cut, poses=2)
    assert found.comparison.contact is None
    assert "contact_error" not in document(found)
    assert found.judged.verdict == "interrupted"


def test_the_step_is_shortened_until_plain_leaning_converges():
    wall = Object(name="wall", shape="plane", position=(0.05, 0, 0), axis=(-1, 0, 0))
    arm = replace(ALONE, objects=(wall,))
    run = simulate(arm, along(arm, "line", 2.0, max_bend=np.radians(40)))
    assert run.contacts
    assert np.nanmax(run.step_error) < STEP_LIMIT * arm.length
