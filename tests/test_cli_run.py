"""`contarm run` and `render`: what they leave, say and end with."""

import json
import math
import os
import re
import signal
import subprocess
import sys

import mujoco
import numpy as np
import pytest
from waiting import PATIENCE, processor_time, wait_for

from contarm_sim.kinematics import arc

RUN_FILES = {
    "summary.json",
    "samples.csv",
    "trajectory.npz",
    "arm.xml",
    "arm.toml",
    "path.png",
    "budget.png",
    "report.html",
    "muscles.png",
}


@pytest.mark.parametrize(
    "words",
    [
        ("--turns", 0.5),
        ("--turns", 0.5, "--path", "sphere-spiral", "--project", "nearest"),
        ("--path", "circle", "--gravity", 0, 0, 9.81, "--fast"),
    ],
)
def test_run_leaves_everything_it_promises(contarm, tmp_path, words):
    code, out, err = contarm("run", *words, "--duration", 2, "--max-bend", 0.4, "--no-video", "--out", "r", "--json")
    assert code == 0, err
    summary = json.loads(out)
    assert set(os.listdir(tmp_path / "r")) == RUN_FILES
    assert json.loads((tmp_path / "r/summary.json").read_text()) == summary
    for name in ("target_error", "tip_error", "discretisation", "servo", "shape", "motion", "unexplained", "miss"):
        assert set(summary[name]) == {"max_m", "rms_m", "max_percent", "rms_percent"}
    for name in ("orientation_error_deg", "real_time_factor", "arm", "versions", "command", "verdict", "muscle"):
        assert name in summary
    assert {"holds", "error_percent", "limit_percent"} <= set(summary["constant_curvature"])
    assert {"timestep_s", "max_percent"} <= set(summary["time_step"])
    assert {"min_force_n", "max_force_n", "pushes", "slack_fraction"} <= set(summary["muscle"])
    table = np.genfromtxt(tmp_path / "r/samples.csv", delimiter=",", names=True)
    assert len(table) == 201
    assert table["tip_error_m"].max() == pytest.approx(summary["tip_error"]["max_m"], rel=1e-6)
    if "sphere-spiral" in words:
        assert summary["miss"]["max_m"] > 0.001


@pytest.mark.usefixtures("blank_figures")
def test_run_of_a_csv_path(contarm, tmp_path):
    tips = arc.position(arc.from_polar(np.array([0.0, 0.1, 0.2]), np.array([0.0, 0.3, 1.0])), 0.37)
    (tmp_path / "t.csv").write_text(
        "t,x,y,z\n" + "\n".join(f"{t},{x!r},{y!r},{z!r}" for t, (x, y, z) in enumerate(tips.tolist()))
    )
    code, out, err = contarm("run", "--path", "t.csv", "--no-video", "--json")
    assert code == 0, err
    assert json.loads(out)["duration"] == 2


def test_doctor_reports_versions_backends_and_encoder(contarm):
    code, out, _ = contarm("doctor", "--json")
    found = json.loads(out)
    assert found["versions"]["mujoco"].startswith("3.")
    assert found["cores"] >= 1
    assert found["gl"]["attempts"]
    assert code == (0 if found["verdict"] == "pass" else 1)


@pytest.mark.usefixtures("blank_figures")
def test_what_is_not_explained_is_exit_code_1(contarm):
    """A heavy arm on a fast path is flung about: no answer about constant curvature, and not a crash."""
    code, out, err = contarm("run", "--duration", 2, "--turns", 4, "--max-bend", 2.5, "--mass", 1, "--no-video")
    assert code == 1
    assert re.search(r"^simulation: NOT explained.*distance from the model", out, re.M)
    assert "Traceback" not in err


@pytest.mark.usefixtures("blank_figures")
def test_an_explained_error_is_an_answer_and_exit_code_0(contarm):
    words = ("--gravity", 0, 0, 9.81, "--turns", 0.5, "--duration", 5)
    code, out, err = contarm("run", *words, "--no-video", "--out", "r")
    assert code == 0, err
    assert re.search(
        r"^constant curvature: does not hold: the error is [\d.]+ % of length \(limit 1 %\); causes, each alone: sag",
        out,
        re.M,
    )
    assert re.search(r"^simulation: explained", out, re.M)
    lines = [line.strip() for line in out.splitlines()]
    row = next(i for i, line in enumerate(lines) if line.startswith("target against simulated tip"))
    assert lines[row + 1].startswith("analytic against simulated tip")
    assert lines[row - 1].startswith("──")


@pytest.mark.usefixtures("blank_figures")
def test_a_path_in_millimetres_fails_and_asks_for_metres(contarm, tmp_path):
    tips = 1e3 * arc.position(arc.from_polar(np.array([0.1, 0.3, 0.5]), 0.3), 0.37)
    rows = "\n".join(",".join(map(repr, row)) for row in tips.tolist())
    (tmp_path / "t.csv").write_text("x,y,z\n" + rows)
    words = ("run", "--path", "t.csv", "--project", "nearest", "--duration", 3, "--no-video", "--out", "r")
    code, out, err = contarm(*words)
    assert code == 1, err
    assert "targets: miss" in out
    assert "are they in metres?" in out
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    assert (summary["verdict"], summary["targets_met"], summary["targets_in_millimetres"]) == ("fail", False, True)


def test_ctrl_c_in_a_run_keeps_a_whole_folder(tmp_path):
    """A real signal to a real process in the middle of a long run."""
    words = [sys.executable, "-m", "contarm_sim", "run", "--duration", "600", "--no-video", "--out", "kept"]
    process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    wait_for(lambda: process.poll() is not None or processor_time(process.pid) > 2.5)  # the start takes about one
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130, err
    assert "interrupted at" in err
    summary = json.loads((tmp_path / "kept/summary.json").read_text())
    assert summary["interrupted"] is True
    assert set(os.listdir(tmp_path / "kept")) == RUN_FILES
    assert os.listdir(tmp_path) == ["kept"]


def test_outputs_are_whole_or_absent(tmp_path):
    from contarm_sim.view.report.output import OutputFolder, output_file

    def fail(open_output, error):
        with open_output as opened:
            scratch = opened.folder / "half" if isinstance(opened, OutputFolder) else opened
            scratch.write_text("x")
            raise error

    for error in (RuntimeError, KeyboardInterrupt):
        with pytest.raises(error):
            fail(OutputFolder(tmp_path / "a/b/c"), error)
        with pytest.raises(error):
            fail(output_file(tmp_path / "d.csv"), error)
    assert os.listdir(tmp_path) == []


def test_numbers_shown_are_finite():
    from contarm_sim.view.report.output import to_json

    with pytest.raises(ValueError, match="JSON compliant"):
        to_json({"x": math.nan})


def test_a_name_taken_meanwhile_costs_no_results(tmp_path):
    from contarm_sim.view.report.output import OutputFolder

    with OutputFolder(tmp_path / "run") as one:
        with OutputFolder(tmp_path / "run") as two:
            (two.folder / "b").write_text("b")
        (one.folder / "a").write_text("a")
    assert (two.target / "b").exists()
    assert (one.target / "a").exists()
    with OutputFolder(tmp_path / "run") as three:  # the name is taken before the results are ready to be written
        (three.folder / "c").write_text("c")
    assert (three.target / "c").exists()
    assert sorted(os.listdir(tmp_path)) == ["run", "run-1", "run-2"]


@pytest.mark.usefixtures("blank_figures")
def test_a_run_under_pressure_leaves_pressures(contarm, tmp_path):
    words = ["run", "--controller", "pressure", "--duration", 2, "--turns", 0.3, "--no-video", "--out", "r", "--json"]
    code, _, err = contarm(*words)
    assert code in (0, 1), err
    header = (tmp_path / "r" / "samples.csv").read_text().splitlines()[0]
    assert "muscle_1_pressure_asked_pa" in header
    assert "muscle_1_pressure_pa" in header
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "r" / "arm.xml")).na == 6
    code, _, err = contarm("run", "--controller", "pressure", "--max-bend", 3, "--no-video", "--out", "x")
    assert code == 2
    assert "kPa" in err


@pytest.mark.gl
@pytest.mark.usefixtures("blank_figures")
def test_render_draws_what_a_run_left_and_refuses_the_rest(contarm, tmp_path):
    code, _, err = contarm("run", "--duration", 1, "--turns", 0.2, "--no-video", "--out", "r")
    assert code in (0, 1), err
    code, out, err = contarm("render", "r", "--size", "480p", "--fps", 5, "--out", "r.webp", "--json")
    if code == 1 and "GL" in err:
        pytest.skip("no GL library here")
    assert (code, json.loads(out)) == (0, {"file": "r.webp", "width": 854, "height": 480, "frames": 6, "fps": 5.0}), err
    assert contarm("render", "r", "--beside", "r", "--camera", "tip", "--size", "480p", "--out", "two.png")[0] == 0
    for words, said in (
        (("r", "--out", "r.avi"), "a name that ends in"),
        (("none",), "a folder that contarm run left"),
        (("r", "--out", "r.webp"), "exist"),
        (("r", "--fps", 0), "1 to 60"),
        (("r", "--time", 1, "--out", "t.mp4"), "with a .png only"),
        (("r", "--time", 9, "--out", "t.png"), "0 to 1 s"),
        (("r", "--camera", "back"), "front"),
    ):
        code, _, err = contarm("render", *words)
        assert code == 2
        assert said in err
        assert err.count("\n") == 1
    assert set(os.listdir(tmp_path)) == {"r", "r.webp", "two.png"}


@pytest.mark.gl
@pytest.mark.usefixtures("blank_figures")
def test_without_an_encoder_a_run_leaves_an_animated_picture(contarm, tmp_path, monkeypatch):
    import imageio_ffmpeg

    def missing():
        raise RuntimeError("No ffmpeg exe could be found.")

    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", missing)
    code, out, err = contarm("run", "--duration", 1, "--turns", 0.2, "--out", "r", "--json")
    assert code in (0, 1), err
    found = json.loads(out)["video"]
    if found.startswith("none: no picture"):
        pytest.skip("no GL library here")
    assert found == "video.gif"
    assert "data:image/gif;base64" in (tmp_path / "r" / "report.html").read_text()


@pytest.mark.usefixtures("blank_figures")
def test_a_run_through_poses_that_have_no_rest_is_kept_and_says_so(contarm, tmp_path):
    """Muscles of 177 N cannot hold 4 kg out sideways."""
    load, path = ("--gravity", 0, 0, 9.81, "--payload", 4), ("--duration", 2, "--turns", 1, "--no-video")
    code, out, _ = contarm("run", *load, *path, "--out", "r")
    assert code in (0, 1)
    assert "motion share unavailable: a commanded pose is unstable or has no equilibrium" in out
    assert "motion: simulated tip vs at rest" not in out
    assert json.loads((tmp_path / "r" / "summary.json").read_text())["motion"] is None
    assert "Motion share unavailable" in (tmp_path / "r" / "report.html").read_text()
