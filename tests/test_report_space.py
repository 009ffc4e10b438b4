"""The report's view in three dimensions, and its colours: turned as the arm stands, and seen in light and dark."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from references import along

from contarm_sim.mjcf.scene import world_gravity
from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.results.compare import compare
from contarm_sim.view.colours import ANALYTIC, DARK_PAGE, SIMULATED, TARGET
from contarm_sim.view.report import space as written
from contarm_sim.view.report.contrast import contrast, lightened
from contarm_sim.view.report.space import space, telling

CSS = (Path(written.__file__).parent / "pages" / "page.css").read_text()
DOWN = {
    "hanging": (0.0, 0.0, 9.81),
    "standing": (0.0, 0.0, -9.81),
    "sideways": (9.81, 0.0, 0.0),
    "askew": (3.0, -4.0, 8.0),
}


@pytest.fixture(scope="module")
def run():
    arm = Arm(links=6)
    return simulate(arm, along(arm, "spiral", 1.0, turns=0.5))


def _found(run, **world):
    return space(replace(run, arm=replace(run.arm, **world)), compare(run))


def _schemes():
    """Return the page's colours by name, of its light and its dark scheme."""
    light, dark = (dict(re.findall(r"--(\w+): (#\w{6})", part)) for part in CSS.split("@media screen")[:2])
    return {"light": light, "dark": light | dark}


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_contrast_enough(scheme):
    colours = _schemes()[scheme]
    assert contrast("#ffffff", "#000000") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)
    for text in ("ink", "soft", "good", "bad", "note", "link"):
        for paper in ("paper", "card"):
            assert contrast(colours[text], colours[paper]) >= 4.5, (text, paper)
    assert contrast("#777777", colours["sheet"]) >= 3  # the faintest letters of figures lie on it


def test_lines_are_seen_in_the_dark_and_keep_their_hue(run):
    assert _schemes()["dark"]["paper"] == DARK_PAGE
    found = _found(run, gravity=(0.0, 0.0, 9.81))
    for trace, others in zip(found["data"], found["dark"], strict=True):
        colours = [others.get("line.color"), others.get("textfont.color")]
        colours += [colour for _, colour in others.get("line.colorscale", others.get("colorscale", []))]
        for colour in filter(None, colours):
            assert contrast(colour, DARK_PAGE) >= 3, trace["name"]
    assert lightened("#ffffff", DARK_PAGE) == "#ffffff"
    red, green, blue = (int(lightened(SIMULATED, DARK_PAGE, 7)[i : i + 2], 16) for i in (1, 3, 5))
    assert red > green > blue


def test_colours_are_those_of_the_roles(run):
    lines = {trace["name"]: trace["line"]["color"] for trace in _found(run)["data"] if trace["type"] == "scatter3d"}
    assert (lines["target"], lines["tip of the arc"], lines["simulated tip"]) == (TARGET, ANALYTIC, SIMULATED)


@pytest.mark.parametrize("name", DOWN)
def test_gravity_points_down_in_the_picture_and_its_arrow_along_it(run, name):
    pull = np.array(DOWN[name])
    found = _found(run, gravity=DOWN[name])
    up = np.array([found["layout"]["scene"]["camera"]["up"][axis] for axis in "xyz"])
    np.testing.assert_allclose(up, -pull / np.linalg.norm(pull), atol=1e-9)
    assert world_gravity(replace(run.arm, gravity=DOWN[name]))[2] < 0
    arrow = next(trace for trace in found["data"] if trace.get("name") == "gravity")
    ends = np.array([arrow[axis] for axis in "xyz"])
    along_it = np.diff(ends, axis=1)[:, 0]
    assert along_it @ pull == pytest.approx(np.linalg.norm(along_it) * np.linalg.norm(pull), rel=1e-4)
    tips = np.array([found["data"][0][axis] for axis in "xyz"]).reshape(3, -1).T
    side = ends[:, 0] - pull * (ends[:, 0] @ pull) / (pull @ pull)
    side /= np.linalg.norm(side)
    assert (tips @ side).max() < ends[:, 0] @ side, "the arrow stands beside what the arm reaches"
    assert [trace["text"] for trace in found["data"] if trace.get("mode") == "text"] == [["gravity"]]


def test_without_gravity_there_is_no_arrow_and_z_points_up(run):
    found = _found(run)
    assert not any(trace.get("name") == "gravity" for trace in found["data"])
    assert found["layout"]["scene"]["camera"]["up"] == {"x": 0.0, "y": 0.0, "z": 1.0}


def test_a_base_that_is_stated_turns_the_picture_too(run):
    found = _found(run, gravity=(0.0, 0.0, -9.81), base_orientation=(0.0, 1.0, 0.0, 0.0))
    assert found["layout"]["scene"]["camera"]["up"]["z"] == pytest.approx(-1)


def test_arm_and_arc_are_drawn_where_their_tips_are_apart(run):
    compared = compare(run)
    best = telling(run, compared)
    bent = np.hypot(*run.bend.T)
    assert compared.tip_error[best] * bent[best] == (compared.tip_error * bent).max()
    data = {trace["name"]: trace for trace in space(run, compared)["data"] if "name" in trace}
    ends = [
        np.array([data[f"{what} at {run.time[best]:.2f} s"][axis][-1] for axis in "xyz"])
        for what in ("simulated arm", "arc")
    ]
    assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(1e3 * compared.tip_error[best], abs=0.05)
