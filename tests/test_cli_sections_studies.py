"""Commands of the studies for an arm of two sections: documents, tables, files and what they refuse."""

import json
import os
import re

import numpy as np
import pytest

from contarm_sim.cli import possibility
from contarm_sim.studies import pressure_map

TWO = """
gravity = [0, 0, 9.81]
[[section]]
length = 0.20
links = 8
mass = 0.10
bending_stiffness = 0.04
muscle_radius = 0.014
[[section]]
length = 0.17
links = 8
mass = 0.06
bending_stiffness = 0.02
muscle_radius = 0.013
muscle_offset = 0.3
"""
BENDS = ("--bend", 1, 0.5, "--bend", "40deg", -1)


@pytest.fixture
def two(contarm, tmp_path):
    """Run a command with the arm of two sections."""
    (tmp_path / "two.toml").write_text(TWO)
    return lambda command, *words: contarm(command, "--arm", "two.toml", *words)


def test_hold_takes_a_bend_for_each_section(two):
    code, out, err = two("hold", *BENDS, "--json")
    assert code == 0, err
    found = json.loads(out)
    np.testing.assert_allclose(np.hypot(*np.transpose(found["bend"])), [1, np.radians(40)])
    assert np.shape(found["pressures"]) == (2, 3)
    code, out, err = two("hold", *BENDS)
    assert "section 2, muscle 3" in out
    assert "section 2: co-contraction can rise by" in out


@pytest.mark.parametrize("command", ["hold", "stiffness", "possibility"])
def test_another_number_of_bends_than_of_sections_is_one_line(two, command):
    for words, count in ((BENDS[:3], 1), (BENDS + BENDS[:3], 3)):
        code, _, err = two(command, *words)
        times, allowed = "time" if count == 1 else "times", "2 times, once for each section from the base to the tip"
        assert (code, err) == (2, f"contarm: --bend is given {count} {times}; allowed: {allowed}\n")


def test_bends_of_one_section(contarm):
    assert contarm("hold", *BENDS)[::2] == (2, "contarm: --bend is given 2 times; allowed: once\n")
    code, _, err = contarm("possibility", "--bend", 1, 0)
    assert code == 2
    assert err.startswith("contarm: --bend is given for an arm of one section; allowed: none")
    code, _, err = contarm("hold", "--bend", "200deg", 0)
    assert (code, err.count("\n")) == (2, 1)


def test_stiffness_prints_and_writes(two, tmp_path):
    code, out, err = two("stiffness", "--levels", 2, "--out", "s", "--json")
    assert code == 0, err
    found = json.loads(out)
    assert np.shape(found["bend"]) == (2, 2)
    assert np.shape(found["rows"][0]["pressures_pa"]) == (6,)
    assert set(os.listdir(tmp_path / "s")) == {"summary.json", "stiffness.png"}
    assert "tip stiffness at 57, 40 deg" in two("stiffness", *BENDS, "--levels", 2)[1]


def test_equilibrium_has_bars_between_sections(two):
    code, out, err = two("equilibrium", "--muscles", "bend 1 0 0.5 1", "--xi", 0.5)
    assert code == 0, err
    assert re.search(r"muscles( +[\d.]+){3} +\|( +[\d.]+){3} N, which takes", out)
    code, _, err = two("equilibrium", "--muscles", "bend 1 0")
    assert (code, err.count("\n")) == (2, 1)
    assert "4 finite numbers" in err


def test_release_swings(two, tmp_path):
    code, out, err = two("release", "--duration", 0.1, "--wrench", 1, 0.1, *[0] * 5, "--out", "r", "--json")
    found = json.loads(out)
    assert code == (0 if found["verdict"] == "pass" else 1), err
    assert found["chain_hz"][0] == pytest.approx(found["beam_hz"][0], rel=0.02)
    assert set(os.listdir(tmp_path / "r")) == {"summary.json", "swing.csv", "swing.png"}


def test_validate_says_errors_by_section(two, tmp_path):
    words = ("validate", "--grid", 2, "--max-bend", "80deg", "--out")
    code, out, err = two(*words, "v")
    assert code == 0, err
    assert re.search(r"gravity +2 +0\.\d{4} +0\.0000 +\d\.\d{4}", out)
    assert "of each section alone" in out
    assert {"errors_by_bend.png", "convergence.png", "samples.csv"} <= set(os.listdir(tmp_path / "v"))
    summary = json.loads((tmp_path / "v" / "summary.json").read_text())
    assert [own["section"] for own in summary["gravity"]["sections"]] == [1, 2]
    assert len(summary["arm"]["section"]) == 2


def test_possibility_has_rows_for_each_section(two, tmp_path, monkeypatch):
    monkeypatch.setattr(possibility, "PLANES_OF_SECTIONS", 1)
    monkeypatch.setattr(pressure_map, "every_bend", lambda *_: 1.0)
    monkeypatch.setattr(pressure_map, "fallen_from", lambda *_: [0.1])
    code, out, err = two("possibility", "--out", "p", "--bend", 0.2, 0, "--bend", 0.2, 1)
    assert code == 0, err
    assert len(re.findall(r"^ *(?:free|gravity|payload) +(?:1 +0|2 +17) +", out, re.MULTILINE)) == 6
    assert "section 2: in every plane" in out
    assert "section 1: free: smaller bends are NOT all held" in out
    assert os.listdir(tmp_path / "p") == ["summary.json"]


def test_muscle_wants_a_section_where_they_differ(two):
    code, out, err = two("muscle", "--section", 2, "--json")
    assert code == 0, err
    assert json.loads(out)["rest_length_m"] == pytest.approx(0.17 / 0.95)
    code, _, err = two("muscle")
    assert (code, err) == (2, "contarm: section is not given, and they differ; allowed: one with muscles: 1, 2\n")


def test_run_follows_a_path_and_says_errors_by_section(two, tmp_path):
    words = ("--path", "circle", "--max-bend", "50deg", "--duration", 1, "--no-video")
    code, out, err = two("run", *words, "--out", "r")
    assert code in (0, 1), err
    assert "of each section alone" in out
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert [own["section"] for own in summary["sections"]] == [1, 2]
    assert summary["miss"]["max_percent"] < 1e-6
    assert summary["unexplained"]["max_percent"] < 0.5
    code, _, err = two("run", *words, "--direction", 0, 0, 1)
    assert (code, err.count("\n")) == (2, 1)
    assert "direction" in err
    code, _, err = two("run", *words, "--project", "ray")
    assert (code, err) == (2, "contarm: project is 'ray'; allowed: refuse or nearest, for an arm of several sections\n")
