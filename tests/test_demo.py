"""`contarm demo`: what the demonstrations show is measured on their motions, and the checks can fail."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from contarm_sim.cli.main import cli
from contarm_sim.demos import grasp, lean, reach_around
from contarm_sim.demos.curl import HALF_TURN, Curl, reference_of_curl
from contarm_sim.demos.demonstration import Requirement
from contarm_sim.demos.grasp_script import END, bends_at, controls_at, grasp_arm
from contarm_sim.mechanics import routing
from contarm_sim.results.run_folder import load_folder


@pytest.fixture(scope="module")
def grasped():
    """Return the motion of the grasp."""
    return grasp.run(grasp_arm())


@pytest.fixture(scope="module")
def leant():
    """Return the demonstration of leaning."""
    return lean.demonstrate()


def test_the_log_is_lifted_carried_held_and_put_down(grasped):
    checks = grasp.checks(grasped)
    assert [check.what for check in checks if not check.passed] == []
    log = grasped.objects[:, 0]
    assert (log[0, 2] - log[:, 2]).max() > 0.08
    top = grasped.contacts.at(720)
    weight = 0.25 * 9.81
    assert top.force[:, 2].sum() == pytest.approx(weight, rel=0.02)  # +Z points down: the log presses the arm down
    assert len(np.unique(top.station)) >= 5  # it is wrapped, not pinched


def test_a_log_that_stays_on_its_forks_is_not_lifted(grasped):
    """Checks that hold for every motion would show nothing."""
    still = replace(grasped, objects=np.broadcast_to(grasped.objects[:1], grasped.objects.shape))
    failed = {check.what for check in grasp.checks(still) if not check.passed}
    assert {"height of the log over its forks, while it is up", "slip in the grip"} <= failed


def test_what_slips_is_seen(grasped):
    """A log that is moved by 8 mm within the grip slips by that."""
    moved = grasped.objects.copy()
    moved[720:, 0, 1] += 0.008
    slipped, turned = grasp.slip(replace(grasped, objects=moved))
    assert slipped == pytest.approx(0.008, abs=1e-3)
    assert turned < np.radians(5)


def test_curls_go_beyond_half_a_turn_and_ask_no_more_than_references_can():
    arm, time = grasp_arm().alone, np.arange(round(END * 100) + 1) / 100
    bend = bends_at(time)
    assert np.degrees(bend[:, 2]).max() > 270
    reference = reference_of_curl(bend, arm, time)
    assert np.abs(reference.bend).max() <= HALF_TURN * (1 + 1e-12)
    plan = Curl(bend).plan(arm, reference)
    lengths = routing.arc_deltas(bend, arm)  # the curled section's muscles get those of the whole arc, nearly
    off = plan.lengths - lengths - (plan.lengths - lengths)[0]
    assert np.abs(off[:, 3:]).max() < 2e-4
    assert np.array_equal(plan.setpoint, controls_at(time, grasp_arm()))
    assert bends_at(-1.0) == pytest.approx(bends_at(0.0))
    assert bends_at(END + 9) == pytest.approx(bends_at(END))


def test_logs_vary_by_a_fifth_and_lie_on_their_forks():
    arm = grasp_arm()
    logs = [grasp.varied(arm, seed).world.objects[0] for seed in range(50)]
    for values in ([log.mass / 0.25 for log in logs], [log.friction / 0.8 for log in logs]):
        assert 0.8 <= min(values) < 0.85 < 1.15 < max(values) <= 1.2
    other = grasp.varied(arm, 3).world.objects
    fork = np.subtract(other[1].position, arm.world.objects[1].position)
    assert fork == pytest.approx(np.subtract(other[0].position, arm.world.objects[0].position) * [1, 0, 1])


def test_the_planned_way_is_free_and_the_plain_one_is_not():
    found = reach_around.demonstrate()
    assert found.passed
    assert not len(found.run.contacts)
    assert set(found.beside.contacts.names) == {"post"}
    assert np.allclose(found.run.target, found.beside.target)


def test_the_arm_is_stiffer_leaning(leant):
    assert leant.passed
    assert leant.beside.contacts is None
    assert np.array_equal(leant.run.setpoint, leant.beside.setpoint)  # the wall alone makes the difference


def test_the_command_leaves_a_folder_that_can_be_opened_and_tells_failures(leant, tmp_path, monkeypatch):
    target, found = tmp_path / "lean", leant
    monkeypatch.setattr(lean, "demonstrate", lambda show: found)
    words = ["demo", "lean", "--no-video", "--json", "--out", str(target)]
    done = CliRunner().invoke(cli, words, standalone_mode=False)
    assert done.return_value == 0
    summary = json.loads((target / "summary.json").read_text())
    assert summary["verdict"] == "pass"
    assert len(summary["checks"]) == len(found.checks)
    assert load_folder(target) == found.run
    assert load_folder(target / "beside") == found.beside
    assert (target / "contact.png").exists()
    assert not (target / "beside" / "contact.png").exists()  # it touches nothing

    failed = replace(found, checks=[Requirement("height", 1.0, 2.0, "m", least=True)])
    monkeypatch.setattr(lean, "demonstrate", lambda show: replace(failed, run=found.beside, beside=found.run))
    words = ["demo", "lean", "--no-video", "--out", str(tmp_path / "other")]
    done = CliRunner().invoke(cli, words, standalone_mode=False)
    assert done.return_value == 1
    assert "FAIL" in done.output
    assert "at least 2000 mm" in done.output
    assert (tmp_path / "other" / "beside" / "contact.png").exists()  # each figure lies beside its own contacts.csv
    assert not (tmp_path / "other" / "contact.png").exists()


def test_an_interrupted_film_leaves_the_numbers_and_says_so(leant, tmp_path, monkeypatch):
    def stop(*given):
        raise KeyboardInterrupt

    monkeypatch.setattr(lean, "demonstrate", lambda show: leant)
    monkeypatch.setattr("contarm_sim.view.rendering.video.write_video", stop)
    done = CliRunner().invoke(cli, ["demo", "lean", "--out", str(tmp_path / "cut")], standalone_mode=False)
    assert done.return_value == 130
    assert "while drawing, so video.mp4 is missing; the numbers are whole" in done.output
    assert (tmp_path / "cut/contact.png").is_file()
    assert load_folder(tmp_path / "cut") == leant.run


def test_a_check_that_measured_nothing_fails():
    assert not Requirement("height", float("nan"), 1.0, "m").passed
    assert not Requirement("height", float("nan"), 1.0, "m", least=True).passed


@pytest.mark.slow
def test_twenty_of_twenty_other_logs_are_lifted():
    for seed in range(20):
        checks = grasp.checks(grasp.run(grasp.varied(grasp_arm(), seed)))
        assert [check.what for check in checks if not check.passed] == [], seed
