"""Uncertain parameters: what is sampled, what stays the nominal arm's, which parameter causes what."""

import json
import re
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.stats import qmc
from text_boxes import faults

from contarm_sim import Arm, InputError, Load, Muscles, Reference, World, Wrench, equilibrium, paths, simulate
from contarm_sim.cli.uncertain import ellipsoid_words
from contarm_sim.control.believed import Believing
from contarm_sim.control.registry import controller
from contarm_sim.sweeps.case_table import write_cases
from contarm_sim.sweeps.causes import causes
from contarm_sim.sweeps.spread_of_motion import uncertain_motion
from contarm_sim.sweeps.spread_of_pose import uncertain_pose
from contarm_sim.sweeps.uncertain import read_uncertain
from contarm_sim.view.colours import SIMULATED, rgb
from contarm_sim.view.prints import WIDTHS
from contarm_sim.view.report.uncertainty import figures_of_motion, figures_of_pose
from contarm_sim.view.report.uncertainty_words import limit_words, parameter_rows, pose_rows
from contarm_sim.view.style import drawn

VARY = {
    "length": {"distribution": "normal", "mean": 0.37, "std": "1 %"},
    "bending_stiffness": {"distribution": "lognormal", "mean": 0.1, "std": "20 %"},
    "muscle": {"wall": {"distribution": "uniform", "low": "1.9 mm", "high": "2.1 mm"}},
}


@pytest.fixture(scope="module")
def motion():
    """The nominal arm, hanging, on a short path from the straight pose, and 32 sampled arms."""
    arm = Arm(links=6, world=World(gravity=(0, 0, 9.81), payload=0.05))
    path = paths.named("spiral", arm.length, duration=0.4, max_bend=1.0)
    run = simulate(arm, Reference.from_path(path, arm), "feedforward")
    return uncertain_motion(run, {"cases": 32, "vary": VARY})


def test_texts_and_vectors_cannot_be_uncertain():
    spread = {"distribution": "uniform", "low": 0, "high": 1}
    for name, kind in (("muscle.path", "a text"), ("gravity", "a vector")):
        with pytest.raises(InputError, match=f"{name} is {kind}, which cannot be uncertain"):
            read_uncertain({"vary": {name: spread}}, Arm())


def test_what_is_sampled_has_its_distribution():
    asked = {"cases": 1000, "seed": 3, "vary": VARY}
    found = read_uncertain(asked, Arm())
    length, stiffness, wall = (np.array(found.values[name]) for name in found.names)
    assert found.names == ("length", "bending_stiffness", "muscle.wall")
    assert length.mean() == pytest.approx(0.37, rel=1e-4)
    assert length.std() == pytest.approx(0.0037, rel=0.02)
    assert np.log(stiffness).std() == pytest.approx(np.sqrt(np.log(1.04)), rel=0.02)
    assert stiffness.mean() == pytest.approx(0.1, rel=2e-3)
    assert np.percentile(wall, (0, 50, 100)) == pytest.approx([1.9e-3, 2e-3, 2.1e-3], abs=1e-6)
    assert abs(np.corrcoef([length, np.log(stiffness), wall]) - np.eye(3)).max() < 0.02
    assert found.arms[7].sections[0].bending_stiffness == stiffness[7]
    assert found.values == read_uncertain(asked, Arm()).values
    assert found.values != read_uncertain(asked | {"seed": 4}, Arm()).values


def test_causes_are_those_of_ishigami_s_function():
    """Ishigami and Homma 1990: sin x + 7 sin^2 y + 0.1 z^4 sin x, each uniform on -pi..pi."""
    x, y, z = pi * (2 * qmc.Sobol(3, seed=1).random(256).T - 1)
    values = np.sin(x) + 7 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    alone, both, pair = 0.5 * (1 + 0.1 * pi**4 / 5) ** 2, 49 / 8, 0.01 * pi**8 * (1 / 18 - 1 / 50)
    whole = alone + both + pair
    found = causes(np.stack([x, y, z], axis=1) / pi, [False] * 3, values)
    assert found.first == pytest.approx(np.array([alone, both, 0]) / whole, abs=0.02)
    assert found.total == pytest.approx(np.array([alone + pair, both, pair]) / whole, abs=0.02)
    assert 0.9 < found.explained < 1
    inside = (found.total_interval[:, 0] <= found.total) & (found.total <= found.total_interval[:, 1])
    assert inside.all()
    few = causes(np.stack([x, y, z], axis=1)[:64] / pi, [False] * 3, values[:64])
    assert "explains only" in few.reason
    assert np.isnan(few.first).all()


def test_causes_of_a_sum_are_shares_of_its_variance():
    """Normal and uniform parameters together, and a place: variances of its coordinates add up."""
    chance = np.random.default_rng(0)
    places = np.stack([chance.standard_normal(64), chance.uniform(-1, 1, 64)], axis=1)
    found = causes(places, [True, False], 2 * places[:, 0] + 3 * places[:, 1] + 5)
    assert found.first == pytest.approx(np.array([4, 3]) / 7, abs=1e-9)
    assert found.total == pytest.approx(found.first, abs=1e-9)
    of_place = causes(places, [True, False], np.stack([places[:, 0], places[:, 1], 4 + places[:, 1]], axis=1))
    assert of_place.first == pytest.approx(np.array([1, 2 / 3]) / (5 / 3), abs=1e-9)
    assert causes(places, [True, False], np.ones(64)).reason == "it is the same in all cases"
    lost = np.where(np.arange(64) < 10, np.nan, places[:, 0])
    assert causes(places, [True, False], lost).reason == "10 of 64 cases have no result"


@pytest.mark.parametrize("name", ["servo", "pressure"])
def test_an_arm_that_is_as_believed_moves_as_ever(name):
    arm = Arm(links=4)
    reference = Reference.from_path(paths.named("circle", arm.length, duration=0.3, max_bend=0.8), arm)
    driver = Believing(controller(name), arm, reference)
    assert simulate(arm, reference, driver) == simulate(arm, reference, name)


def test_commands_are_those_of_the_nominal_arm(motion):
    """Without feedback a sampled arm is sent, to the bit, what the nominal one is, and goes elsewhere."""
    run, case = motion.nominal, 5
    arm = motion.uncertain.arms[case]
    driver = Believing(controller("feedforward"), run.arm, run.reference)
    again = simulate(arm, replace(run.reference, length=arm.length), driver)
    assert np.array_equal(again.setpoint, run.setpoint)
    assert not np.array_equal(simulate(arm, again.reference, "feedforward").setpoint, run.setpoint)
    assert motion.tips[case] == pytest.approx(again.tip, abs=1e-7)
    assert np.linalg.norm(again.tip - run.tip, axis=1).max() > 1e-4


def test_the_error_is_from_the_arcs_of_the_nominal_arm(motion):
    """The path begins in the straight pose: there the tip is off by what the length is."""
    longer = np.array(motion.uncertain.values["length"]) - 0.37
    assert motion.errors[:, 0] == pytest.approx(np.abs(longer), abs=1e-7)
    assert motion.band[:, 0] == pytest.approx(np.percentile(np.abs(longer), (5, 50, 95)), abs=1e-7)
    told = motion.document()
    assert told["tip_error"]["max"]["p95_m"] == np.percentile(motion.errors.max(axis=1), 95)
    assert told["tip_error"]["end"]["nominal_m"] == pytest.approx(motion.nominal.tip_error[-1])
    assert told["with_result"] == told["run"] == told["cases"] == 32
    shares = told["causes"]["tip"]["parameters"]
    assert shares["muscle.wall"]["total"] < 0.05 < shares["length"]["first"]  # servos hide the muscles' law
    assert json.loads(json.dumps(told, allow_nan=False)) == told


def test_a_pose_keeps_the_set_points_of_the_nominal_arm(tmp_path):
    arm = Arm(links=6, world=World(gravity=(0, 0, 9.81), payload=0.05))
    load = Load(muscles=Muscles(kind="bend", values=(1.5, 0.3)), wrenches=(Wrench(xi=1, force=(0.1, 0, 0)),))
    found = uncertain_pose(arm, load, {"cases": 64, "vary": VARY | {"payload": VARY["length"] | {"mean": 0.05}}})
    assert np.array_equal(found.nominal.tip, equilibrium(arm, load).tip)
    # Other payloads alone would move the tip by what the compliance says.
    told = uncertain_pose(arm, load, {"cases": 8, "vary": {"payload": VARY["length"] | {"mean": 0.05}}})
    moved = told.tips - told.nominal.tip
    pull = np.array([[0, 0, 9.81 * (value - 0.05)] for value in told.uncertain.values["payload"]])
    assert moved == pytest.approx(pull @ told.nominal.tip_compliance[:3, :3].T, abs=2e-6)
    deviations, axes = found.ellipsoid
    assert np.sum(deviations**2) == pytest.approx(np.trace(np.cov(found.tips.T)))
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-9)
    for width in WIDTHS:
        assert not faults(drawn(figures_of_pose(found)["uncertain_tip"], width))
    assert not found.at_limit.any()
    parquet = pytest.importorskip("pyarrow.parquet")
    assert write_cases(tmp_path, found) == "cases.parquet"
    table = parquet.read_table(tmp_path / "cases.parquet")
    assert table.schema.field("muscle.wall").metadata == {b"role": b"parameter", b"unit": b"m"}
    assert table["tip_z"].to_pylist() == found.tips[:, 2].tolist()
    assert set(table["status"].to_pylist()) == {"ok"}


def test_a_bend_in_one_plane_is_drawn_in_that_plane_and_said_without_rounding():
    """A coordinate that all arms share is left out. Servos that should shorten all muscles are at their limits."""
    arm, vary = Arm(links=4), {"cases": 8, "vary": {"length": VARY["length"]}}
    found = uncertain_pose(arm, Load(muscles=Muscles(kind="bend", values=(1.0, 0.0))), vary)
    for width in WIDTHS:
        sheet = drawn(figures_of_pose(found)["uncertain_tip"], width)
        assert [ax.get_xlabel() for ax in sheet.axes] == ["x from nominal tip [mm]"]
        assert not faults(sheet)
    document = found.document()
    words = ellipsoid_words(document["ellipsoid"]) + str(pose_rows(document) + parameter_rows(document, "tip"))
    assert "e-" not in words
    assert "-0.000" not in words
    assert "length [mm]" in words
    assert not limit_words(document)
    far = Load(muscles=Muscles(kind="setpoints", values=(-0.2, -0.2, -0.2)))
    assert "in 8 of 8 arms" in limit_words(uncertain_pose(arm, far, vary).document())[0]


def test_arms_without_a_result_are_counted_and_an_end_keeps_what_is_done(tmp_path, monkeypatch):
    """Upright, with a heavy payload, soft arms have no rest to start from."""
    arm = Arm(links=6, world=World(gravity=(0, 0, -9.81), payload=0.1))
    path = paths.named("spiral", arm.length, duration=0.2, max_bend=0.3)
    run = simulate(arm, Reference.from_path(path, arm), "feedforward")
    vary = {"bending_stiffness": {"distribution": "uniform", "low": 0.005, "high": 0.1}}
    found = uncertain_motion(run, {"cases": 16, "vary": vary})
    told, soft = found.document(), np.array(found.uncertain.values["bending_stiffness"])
    assert 0 < sum(told["failed"].values()) < 16
    assert told["with_result"] + sum(told["failed"].values()) == 16
    assert soft[~found.good].max() < soft[found.good].min()
    assert "cases have no result" in told["causes"]["mean"]["reason"]
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    assert write_cases(tmp_path, found) == "cases.npz"
    with np.load(tmp_path / "cases.npz") as table:
        assert np.array_equal(np.isnan(table["tip_error_max"]), ~found.good)
        assert all(table["error"][~found.good] != "")

    def stop(done, count):
        if done == 16:
            raise KeyboardInterrupt

    cut = uncertain_motion(run, {"cases": 20, "vary": vary}, on_done=stop)
    assert cut.interrupted
    assert cut.status == found.status
    assert cut.document()["run"] == 16


def test_figures_have_all_their_words_inside(motion):
    for width in WIDTHS:
        for name, draw in figures_of_motion(motion).items():
            assert not faults(drawn(draw, width)), (name, width)


def test_a_film_shows_the_sampled_arms_and_the_band(gl, motion):
    from contarm_sim.view.rendering.cloud import Cloud
    from contarm_sim.view.rendering.film import film
    from contarm_sim.view.rendering.insets import error_plot
    from contarm_sim.view.rendering.look import Look

    look, cloud = Look(320, 240, plots=False, captions=False).plain(), Cloud(motion.bones, motion.band)
    looks = (replace(look, overlays=replace(look.overlays, cloud=each)) for each in (None, cloud))
    without, with_them = (next(film(motion.nominal, [len(motion.nominal) - 1], each)) for each in looks)
    changed = np.abs(without.astype(int) - with_them).sum(axis=2) > 60
    assert changed.sum() > 30
    towards = with_them[changed].mean(axis=0) - without[changed].mean(axis=0)
    assert towards @ (255 * np.array(rgb(SIMULATED)) - without[changed].mean(axis=0)) > 0
    plot = error_plot(motion.nominal, float(motion.nominal.tip_error.max()), cloud.band)
    assert plot.top == pytest.approx(1e3 * max(motion.band[-1].max(), motion.nominal.tip_error.max()))


WRONG = {
    "[vary]\nbending_stifness = {distribution = 'normal', mean = 1, std = 1}": "did you mean 'bending_stiffness'",
    "[vary]\nmass = {distribution = 'normal', std = '10 %'}": "mass.mean is missing",
    "case = 3\n[vary]\nmass = 1": "did you mean 'cases'",
    "cases = 3\n[vary]\nmass = 1": "cases is 3; allowed: a whole number from 8",
    "[vary]\nmass = 0.3": "mass is 0.3; allowed: a distribution",
    "[vary]\nmass = {distribution = 'normal', mean = 0.3, std = '80 %'}": "drawn in case",
    "cases = 16": "vary is missing",
    "[vary": "not TOML",
}


@pytest.mark.parametrize("command", ["run", "equilibrium"])
def test_wrong_files_are_refused_in_one_line(contarm, tmp_path, command):
    for text, said in WRONG.items() if command == "equilibrium" else list(WRONG.items())[:1]:
        (tmp_path / "wrong.toml").write_text(text)
        code, out, err = contarm(command, "--uncertain", "wrong.toml")
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert said in err
        assert "wrong.toml" in err
    assert [each.name for each in tmp_path.iterdir()] == ["wrong.toml"]


def test_the_command_leaves_numbers_and_a_page(contarm, tmp_path):
    lines = ["cases = 16", "[vary]", "payload = { distribution = 'uniform', low = 0, high = '50 g' }"]
    (tmp_path / "u.toml").write_text("\n".join(lines))
    words = ("run", "--links", 4, "--duration", 0.3, "--max-bend", 0.5, "--gravity", 0, 0, 9.81, "--payload", 0.025)
    code, out, err = contarm(*words, "--no-video", "--figures", "none", "--uncertain", "u.toml", "--out", "r")
    summary = json.loads((tmp_path / "r/summary.json").read_text())
    assert code == (0 if summary["verdict"] == "pass" else 1), err
    assert "16 sampled arms, all commanded as the nominal one" in out
    assert summary["uncertainty"]["parameters"]["payload"]["nominal"] == 0.025
    share = summary["uncertainty"]["causes"]["tip"]["parameters"]["payload"]
    assert share["first"] == share["total"] == 1
    page = (tmp_path / "r/report.html").read_text()
    assert "<h2>Uncertainty</h2>" in page
    assert "16 sampled arms" in page
    assert page.count("cases.") == 1  # the one file that there is
    for table in re.findall(r'<table aria-label="(?:tip error of sampled arms|uncertain parameters)"', page):
        assert f'<div class="wide">{table}' in page
    assert {"cloud.npz", "report.html"} <= {each.name for each in (tmp_path / "r").iterdir()}
    code, out, err = contarm("equilibrium", "--muscles", "bend 1 0", "--uncertain", "u.toml", "--json", "--links", 4)
    assert code == 0, err
    assert json.loads(out)["ellipsoid"]["deviations_m"]
