"""Every program in examples/ runs as it is, and finds what it is there to show."""

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


def _run(name):
    done = subprocess.run([sys.executable, "-W", "error", EXAMPLES / name], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def _numbers(text, pattern):
    return [float(x) for x in re.findall(pattern, text)]


def test_first_arm():
    assert "bend from it [1.5708 0.    ] rad" in (printed := _run("first_arm.py"))
    assert _numbers(printed, r"tip error ([\d.]+) mm")[0] < 0.5


def test_own_arm_sags_more_the_more_it_bends():
    errors = _numbers(_run("own_arm.py"), r"tip +([\d.]+) %")
    assert len(errors) == 4
    assert errors == sorted(errors)
    assert errors[0] > 1  # hanging, m g L^2/EI = 1.8


def test_many_arms_differ_by_stiffness_and_mass():
    printed = _run("many_arms.py")
    assert "16 of 16 arms" in printed
    least, most, median = _numbers(printed, r"([\d.]+) (?:to|% of length|%)")
    assert 1 < least < median < most < 10


def test_own_controller_is_worse_than_one_that_measures():
    own, servo = _numbers(_run("own_controller.py"), r"tip error +([\d.]+) mm")
    assert servo < own < 37  # it follows, within a tenth of length


def test_a_force_moves_the_tip_its_own_way():
    sideways = _numbers(_run("equilibrium_under_load.py"), r"tip \[ *[-\d.]+ +(-?[\d.]+)")
    assert sideways[0] == pytest.approx(0, abs=0.05)
    assert sideways[2] == pytest.approx(2 * sideways[1], rel=0.05)


def test_stiffer_arms_sag_less():
    errors = _numbers(_run("sweep_stiffness.py"), r"tip +([\d.]+) %")
    assert len(errors) == 4
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.3 * errors[0]  # eight times as stiff


def test_one_of_two_attached_arms_bends():
    x = _numbers(_run("attach.py"), r"tip \[ *(-?[\d.]+)")
    assert x[0] > 0.02
    assert x[1] == pytest.approx(0, abs=1e-3)


def test_of_two_sections_many_poses_reach_a_point_and_one_rests_there():
    printed = _run("two_sections.py")
    assert _numbers(printed, r"(\d+) poses")[0] > 50
    assert 90 < _numbers(printed, r"take (\d+) kPa")[0] < 700
    assert _numbers(printed, r"tip: ([\d.]+) mm")[0] < 0.01


def test_a_recording_tells_stiffness_and_place_and_no_damping():
    printed = _run("fit_recording.py")
    found = re.findall(r"(\S+) +(-?[\d.]+|nan), 95 % interval +(-?[\d.]+|nan) to +(-?[\d.]+|nan)", printed)
    truth = {"section_1.bending_stiffness": 0.022, "section_2.bending_stiffness": 0.037, "frame.x": 0.003,
             "frame.y": -0.002}  # fmt: skip
    assert [name for name, *_ in found] == [*truth, "damping_time"]
    for name, value, low, high in found[:-1]:
        assert float(low) <= truth[name] <= float(high)
        assert float(low) < float(value) < float(high)
    assert found[-1][1] == "nan"
    assert _numbers(printed, r"held out ([\d.]+) mm")[0] == pytest.approx(0.5 * 3**0.5, rel=0.15)


@pytest.mark.skipif(importlib.util.find_spec("gymnasium") is None, reason="gymnasium is not installed")
def test_the_baseline_reaches_and_chance_does_not():
    assert _numbers(_run("gymnasium_reach.py"), r"solved (\d) of 5") == [5, 0]


EXECUTE = """
import json, sys, nbclient, nbformat
notebook = nbformat.read(sys.argv[1], 4)
nbformat.validate(notebook)
nbclient.NotebookClient(notebook, timeout=240, resources={"metadata": {"path": sys.argv[2]}}).execute()
print(json.dumps(notebook))
"""


def _executed(name, folder):
    """Run a notebook in a folder; return what its cells say in words, and how many bytes each kind of output has."""
    if importlib.util.find_spec("nbclient") is None or importlib.util.find_spec("ipykernel") is None:
        pytest.skip("nbclient and ipykernel are not installed")
    command = [sys.executable, "-c", EXECUTE, EXAMPLES / name, folder]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    words, sizes = "", {}
    for cell in json.loads(done.stdout)["cells"]:
        for output in cell.get("outputs", ()):
            assert output.get("name") != "stderr", output["text"]
            words += output.get("text", "")
            for kind, data in output.get("data", {}).items():
                sizes.setdefault(kind, []).append(len(data))
    return words, sizes


@pytest.mark.gl
def test_the_notebook_of_an_own_arm(gl, tmp_path):
    words, sizes = _executed("own_arm.ipynb", tmp_path)
    errors = _numbers(words, r"deg: +([\d.]+) %")
    assert len(errors) == 7
    assert errors == sorted(errors)
    assert "circle-run" in words
    assert (len(sizes["image/png"]), len(sizes["text/html"])) == (2, 4)  # two figures; arm, motion, comparison, film
    assert max(sizes["image/png"] + sizes["text/html"]) < 600_000
    assert {file.name for file in tmp_path.iterdir()} == {"circle.mp4", "circle-run", "muscles.pdf"}


@pytest.mark.skipif(importlib.util.find_spec("gymnasium") is None, reason="gymnasium is not installed")
def test_the_notebook_of_controllers_and_environments(tmp_path):
    words, sizes = _executed("controllers_and_environments.ipynb", tmp_path)
    errors = dict(re.findall(r"(\S+) +off its target by at most +([\d.]+)", words))
    assert float(errors["tip"]) < 0.5 * float(errors["servo"]) < 0.5 * float(errors["open-loop"])
    assert _numbers(words, r"solved (\d) of 3") == [3, 0]
    assert len(sizes["image/png"]) == 2
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["own_arm.ipynb", "controllers_and_environments.ipynb"])
def test_notebooks_are_kept_without_outputs_and_are_formatted(name):
    cells = json.loads((EXAMPLES / name).read_text())["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    assert not any(cell["outputs"] or cell["execution_count"] for cell in code)
    assert not any(cell["metadata"] for cell in cells)
    words = [cell for cell in cells if cell["cell_type"] == "markdown"]
    assert len(words) >= len(code) / 2
    assert "".join(cells[0]["source"]).startswith("# ")
    for command in (["check"], ["format", "--check"]):
        ruff = [sys.executable, "-m", "ruff", *command, str(EXAMPLES / name)]
        if importlib.util.find_spec("ruff") is not None:
            assert subprocess.run(ruff, capture_output=True).returncode == 0


def test_all_are_tested_and_named():
    text, listed = Path(__file__).read_text(), (EXAMPLES / "README.md").read_text()
    for file in EXAMPLES.glob("*.ipynb"):
        assert f'"{file.name}"' in text, file.name
        assert f"`{file.name}`" in listed, file.name
    for file in EXAMPLES.glob("*.py"):
        assert f'"{file.name}"' in text, file.name
        assert f"`{file.name}`" in listed, file.name
        assert len(file.read_text().splitlines()) <= 40


def test_what_rubs_comes_back_another_way_and_takes_work():
    printed = _run("hysteresis.py")
    apart, lost = _numbers(printed, r"ways +([\d.]+) mm"), _numbers(printed, r"turn +(-?[\d.]+) mJ")
    assert [apart[0], lost[0]] == pytest.approx([0, 0], abs=0.01)
    assert min(apart[1:]) > 1
    assert min(lost[1:]) > 10
