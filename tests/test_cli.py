"""The command line as a user types it: documents, exit codes, files, and one clear line for everything wrong."""

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

from contarm_sim.cli.main import COMMANDS, SHORT, main
from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import load_arm
from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS


@pytest.fixture
def contarm(monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)

    def call(*words):
        monkeypatch.setattr(sys, "argv", ["contarm", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            main()
        printed = capsys.readouterr()
        return ended.value.code, printed.out, printed.err

    return call


def test_fk_by_bend_and_by_deltas_agree(contarm):
    code, out, err = contarm("fk", "--bend", 1.2, -2.5, "--json")
    one = json.loads(out)
    assert (code, err) == (0, "")
    assert one["bend_angle"] == pytest.approx(1.2)
    assert one["plane_angle"] == pytest.approx(-2.5)
    assert one["curvature"] == pytest.approx(1.2 / 0.37)
    assert np.shape(one["transform"]) == (4, 4)
    np.testing.assert_allclose(np.array(one["transform"])[:3, 3], one["tip"])
    two = json.loads(contarm("fk", "--deltas", *one["muscle_deltas"], "--json")[1])
    np.testing.assert_allclose(two["tip"], one["tip"], atol=1e-15)
    np.testing.assert_allclose(np.array(two["muscle_lengths"]) - 0.37, one["muscle_deltas"])


def test_fk_lists_transforms_over_xi(contarm):
    found = json.loads(contarm("fk", "--bend", 2, 1, "--xi", 0, "0.5", 1, "--json")[1])
    np.testing.assert_allclose(found["transform"], arc.transform(arc.from_polar(2, 1), 0.37, [0, 0.5, 1]))


def test_fk_takes_the_arm_from_flags_and_toml_with_flags_winning(contarm, tmp_path):
    (tmp_path / "arm.toml").write_text("length = 0.5\nmuscle_radius = 0.02\n[muscle]\nmin_tension = 1\n")
    found = json.loads(contarm("fk", "--bend", 1, 0, "--arm", "arm.toml", "--length", 1.0, "--json")[1])
    assert found["curvature"] == 1.0
    assert found["muscle_deltas"][0] == -0.02


def test_ik_inverts_fk_and_prints_a_list(contarm):
    tip = json.loads(contarm("fk", "--bend", 1.5, 2.0, "--json")[1])["tip"]
    (solution,) = json.loads(contarm("ik", "--tip", *tip, "--json")[1])
    assert solution["bend_angle"] == pytest.approx(1.5, abs=1e-12)
    assert solution["reachable"] is True
    assert solution["miss"] < 1e-12
    for key in ("target", "plane_angle", "curvature", "muscle_deltas", "muscle_lengths", "tip", "transform"):
        assert key in solution


def test_ik_of_a_file_writes_solutions(contarm, tmp_path):
    tips = arc.position(arc.from_polar(np.array([0.0, 1.0, 2.0]), 0.3), 0.37)
    rows = "\n".join(",".join(map(repr, row)) for row in tips.tolist())
    (tmp_path / "t.csv").write_text("x,y,z\n" + rows)
    code, out, _ = contarm("ik", "--file", "t.csv", "--out", "s.csv", "--json")
    assert code == 0
    assert len(json.loads(out)) == 3
    table = np.genfromtxt(tmp_path / "s.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["bend_angle_rad"], [0, 1, 2], atol=1e-12)
    code, _, err = contarm("ik", "--file", "t.csv", "--out", "s.csv")
    assert code == 2
    assert "does not exist yet" in err


@pytest.mark.parametrize("project", ["nearest", "ray", "paper"])
def test_ik_projects_on_request_and_says_the_miss(contarm, project):
    code, out, _ = contarm("ik", "--tip", 0.1, 0.1, 0.3, "--project", project, "--json")
    (solution,) = json.loads(out)
    assert code == 0
    assert solution["reachable"] is False
    miss = np.linalg.norm(np.subtract(solution["tip"], solution["target"]))
    assert solution["miss"] == pytest.approx(miss)


def test_human_output_has_units(contarm):
    _, out, _ = contarm("ik", "--tip", 0.2355, 0, 0.2355)
    assert "bend angle               90.0000 deg" in out
    assert "mm" in out


def test_build_writes_models_that_compile(contarm, tmp_path):
    import mujoco

    code, out, _ = contarm("build", "--links", 8, "--out", "new/model", "--json")
    assert code == 0
    assert len(json.loads(out)["files"]) == 3
    for name in ("arm.xml", "scene.xml"):
        assert mujoco.MjModel.from_xml_path(str(tmp_path / "new/model" / name)).nv == 16
    assert "contarm" not in " ".join(os.listdir(tmp_path))


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


def test_run_of_a_csv_path(contarm, tmp_path):
    tips = arc.position(arc.from_polar(np.array([0.0, 0.1, 0.2]), np.array([0.0, 0.3, 1.0])), 0.37)
    (tmp_path / "t.csv").write_text(
        "t,x,y,z\n" + "\n".join(f"{t},{x!r},{y!r},{z!r}" for t, (x, y, z) in enumerate(tips.tolist()))
    )
    code, out, err = contarm("run", "--path", "t.csv", "--no-video", "--json")
    assert code == 0, err
    assert json.loads(out)["duration"] == 2


def test_validate_nests_scenarios_and_passes(contarm):
    code, out, err = contarm("validate", "--quick", "--links", 12, "--out", "v", "--json")
    summary = json.loads(out)
    assert code == 0, err
    for scenario in ("ideal", "gravity", "payload"):
        assert summary[scenario]["verdict"] == "pass"
        assert {"tip_error", "discretisation", "servo", "shape", "muscle", "orientation_error_deg"} <= set(
            summary[scenario]
        )
    assert summary["ideal"]["real_time_factor"] > 0
    assert summary["payload"]["arm"]["payload"] == 0.1
    assert summary["verdict"] == "pass"
    assert summary["convergence"]["observed_orders"][-1] == pytest.approx(2, abs=0.1)


def test_validate_keeps_the_other_scenarios_where_one_has_no_rest_pose(contarm, tmp_path):
    words = ("validate", "--grid", 2, "--bending-stiffness", 0.02)
    code, out, err = contarm(*words, "--out", "v", "--json")
    assert code == 1, err
    summary = json.loads(out)
    assert summary["verdict"] == "fail"
    assert summary["upright"]["verdict"] == "no rest pose"
    assert "unstable" in summary["upright"]["reason"]
    assert summary["ideal"]["tip_error"]["max_percent"] > 0
    assert json.loads((tmp_path / "v/summary.json").read_text()) == summary
    assert set(os.listdir(tmp_path / "v")) == {"summary.json", "samples.csv", "error_maps.png", "convergence.png"}
    code, out, err = contarm(*words, "--quick", "--out", "w")
    assert code == 1
    assert re.search(r"upright +no rest", out)
    assert "upright: no rest pose: at a bend of 0 deg" in out
    assert "gravity: constant curvature does not hold: " in out


def test_validate_of_an_arm_that_rests_nowhere_says_so(contarm, tmp_path):
    code, out, err = contarm("validate", "--grid", 2, "--links", 8, "--bending-stiffness", 2, "--out", "v")
    assert code == 1, err
    assert "convergence: no rest pose" in out
    assert "gravity: no rest pose" in out
    assert "simulation explained" not in out
    assert set(os.listdir(tmp_path / "v")) == {"summary.json", "samples.csv", "error_maps.png"}


def test_validate_of_an_arm_that_blows_up_gives_no_real_time_factor(contarm, tmp_path):
    words = ("--muscle.servo-time", 0, "--damping-time", 0, "--mass", 0.01)
    code, out, err = contarm("validate", "--quick", *words, "--out", "v")
    assert code == 0, err
    assert "ideal, naive, gravity, payload, upright: stepping blows up" in out
    assert json.loads((tmp_path / "v/summary.json").read_text())["ideal"]["real_time_factor"] is None
    assert os.listdir(tmp_path) == ["v"]


def test_doctor_reports_versions_backends_and_encoder(contarm):
    code, out, _ = contarm("doctor", "--json")
    found = json.loads(out)
    assert found["versions"]["mujoco"].startswith("3.")
    assert found["cores"] >= 1
    assert found["gl"]["attempts"]
    assert code == (0 if found["verdict"] == "pass" else 1)


WRONG = {
    "fk --bend nan 0": "bend_angle",
    "fk --bend 3.1416 0": "bend_angle",
    "fk --bend -1 0": "bend_angle",
    "fk --bend 1 inf": "plane_angle",
    "fk --bend 1": "2 arguments",
    "fk --bend a b": "'a'; allowed: a number [rad], or with its unit, such as 90deg",
    "fk --bend 1.57 90": "in degrees? write 90deg",
    "fk --bend 1 0 --length 370": "in millimetres? write 370mm",
    "fk --bend 1 0 --length 0.37 --length 1": "--length is given 2 times",
    "ik --tip 5 0 235.5": "in millimetres?",
    "ik --file mm.csv": "(in millimetres?)",
    "run --payload 50": "in grams? write 50g",
    "run --links 3 --max-bend 170deg --muscle.path spans": "a smaller --max-bend",
    "run --timestep 1e-6 --duration 3600": "at most 100,000,000 steps",
    "run --duration 3600 --links 400": "GiB of memory",
    "fk --bend 1 0 --json=1": "write its name alone",
    "equilibrium --muscles pressures 500 0 0": "in kPa? write 500kPa",
    "fk": "just one of --deltas, --bend",
    "fk --bend 1 0 --deltas 0 0 0": "just one of",
    "fk --deltas 0.001 0.001 0.001": "sum is 0.003 m",
    "fk --deltas nan 0 0": "finite",
    "fk --deltas -0.06 0.03 0.03": "below pi",
    "fk --bend 1 0 --xi 2": "xi",
    "fk --bend 1 0 --length 0": "greater than 0",
    "fk --bend 1 0 --length -0.37": "greater than 0",
    "fk --bend 1 0 --mass nan": "finite",
    "fk --bend 1 0 --links 0": "2 to 400",
    "fk --bend 1 0 --links 1": "2 to 400",
    "fk --bend 1 0 --links 1000000": "2 to 400",
    "fk --bend 1 0 --links 2.5": "not a valid integer",
    "fk --bend 1 0 --gravity 0 0 inf": "gravity",
    "fk --bend 1 0 --arm missing.toml": "No such file",
    "fk --bend 1 0 --arm typo.toml": "did you mean 'length'",
    "fk --bend 1 0 --lenght 1": "did you mean",
    "ik --tip 0.1 0.1 0.3": "26.17 mm off the dome",
    "ik --tip 0 0 0": "off the dome",
    "ik --tip nan 0 0": "finite",
    "ik --file missing.csv": "No such file",
    "ik --file cell.csv": "row 3, column y is 'two'",
    "ik --file off.csv": "off.csv, row 3",
    "ik --file empty.csv": "empty",
    "ik --file binary.csv": "not text",
    "ik --file column.csv": "missing: z",
    "ik --tip 0 0 0.37 --project sideways": "sideways",
    "run --duration 0": "duration",
    "run --duration -1": "duration",
    "run --path nowhere": "figure-eight",
    "run --path sphere-spiral": "mm off the dome",
    "run --path off.csv": "off.csv",
    "run --path column.csv": "missing: z",
    "run --max-bend 4": "max_bend",
    "run --out taken": "does not exist yet",
    "run --out /proc/none": "can be written",
    "run --controller pid": "pid",
    "run --links 3 --max-bend 2.9 --muscle.path spans": "more links",
    "validate --grid 1": "grid",
    "validate --out taken": "does not exist yet",
    "validate --links 3 --muscle.path spans": "more links",
    "build --out taken": "does not exist yet",
    "equilibrium --muscles on": "off, deltas, tensions, pressures, bend",
    "equilibrium --muscles tensions 1 2": "3 finite numbers",
    "equilibrium --muscles tensions -1 2 3": "pull",
    "equilibrium --muscles pressures 50000 0 0": "0, or 90000 to 700000 Pa",
    "equilibrium --muscles pressures 800000 0 0": "0, or 90000 to 700000 Pa",
    "equilibrium --muscles bend 4 0": "bend_angle",
    "equilibrium --wrench 2 0 0 0 0 0 0": "0 (base) to 1 (tip)",
    "equilibrium --wrench 1 0 0": "7 arguments",
    "equilibrium --wrench 1 nan 0 0 0 0 0": "finite",
    "equilibrium --xi 1.5": "xi",
    "equilibrium --file missing.json": "No such file",
    "equilibrium --file binary.csv": "not text",
    "equilibrium --file empty.csv": "not JSON",
    "equilibrium --file empty.csv --muscles bend 1 0": "either --file, or flags",
    "stiffness --bend 2.9 0": "kPa",
    "stiffness --bend 4 0": "bend_angle",
    "stiffness --levels 1": "levels",
    "muscle --pressure 800000": "0 to 700000 Pa",
    "muscle --pressure nan": "0 to 700000 Pa",
    "muscle --out picture.txt": ".png, .pdf or .svg",
    "muscle --muscle.max-contraction 0.5": "below 0.42",
    "dance": "No such command",
}


@pytest.mark.parametrize("line", WRONG)
def test_wrong_input_is_one_clear_line_and_exit_2_and_nothing_is_written(contarm, tmp_path, line):
    (tmp_path / "typo.toml").write_text("lenght = 1\n")
    (tmp_path / "cell.csv").write_text("x,y,z\n0,0,0.37\n0,two,0\n")
    (tmp_path / "mm.csv").write_text("x,y,z\n235.5,0,235.5\n")
    (tmp_path / "off.csv").write_text("x,y,z\n0,0,0.37\n0.1,0.1,0.3\n")
    (tmp_path / "column.csv").write_text("x,y\n0,0\n")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "taken").mkdir()
    before = sorted(tmp_path.rglob("*"))
    code, out, err = contarm(*line.split())
    assert (code, out) == (2, "")
    assert WRONG[line].lower() in err.lower()
    assert err.startswith("contarm: ")
    assert err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_what_is_not_explained_is_exit_code_1(contarm):
    """A heavy arm on a fast path is flung about: no answer about constant curvature, and not a crash."""
    code, out, err = contarm("run", "--duration", 2, "--turns", 4, "--max-bend", 2.5, "--mass", 1, "--no-video")
    assert code == 1
    assert re.search(r"^simulation: NOT explained.*distance from the model", out, re.M)
    assert "Traceback" not in err


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


def test_help_teaches(contarm):
    for command in (
        "fk",
        "ik",
        "build",
        "run",
        "validate",
        "doctor",
        "equilibrium",
        "muscle",
        "compare-controllers",
        "stiffness",
    ):
        code, out, _ = contarm(command, "--help")
        assert code == 0
        assert "--json" in out
    _, out, _ = contarm("run", "--help")
    assert "Arm (SI units):" in out
    assert "--muscle.max-pressure" in out
    assert "[N m^2]" in out


def test_ctrl_c_in_a_run_keeps_a_whole_folder(tmp_path):
    """A real signal to a real process in the middle of a long run."""
    words = [sys.executable, "-m", "contarm_sim", "run", "--duration", "600", "--no-video", "--out", "kept"]
    process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
    wait_for(lambda: process.poll() is not None or processor_time(process.pid) > 5)  # the start takes about one
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


def test_tables_keep_their_units(contarm):
    _, out, _ = contarm("validate", "--quick", "--links", 6)
    for unit in ("[mm]", "[%]", "[deg]", "[N]"):
        assert unit in out


def test_equilibrium_of_flags_and_of_a_file_agree(contarm, tmp_path):
    flags = [
        "--gravity",
        0,
        0,
        9.81,
        "--payload",
        0.1,
        "--wrench",
        0.5,
        0.1,
        0,
        0,
        0,
        0,
        0,
        "--muscles",
        "bend",
        1.0,
        -0.5,
    ]
    code, out, err = contarm("equilibrium", *flags, "--xi", 0, 0.3, "--json")
    assert code == 0, err
    one = json.loads(out)
    assert np.shape(one["backbone"]["frames"]) == (25, 4, 4)
    assert np.shape(one["poses"]) == (2, 4, 4)
    assert one["residual"] <= 1e-9
    assert one["stable"] is True
    case = {"gravity": [0, 0, 9.81], "payload": 0.1, "wrenches": [{"xi": 0.5, "force": [0.1, 0, 0]}]}
    case["muscles"] = {"kind": "bend", "values": [1.0, -0.5]}
    (tmp_path / "loads.json").write_text(json.dumps([case, {}]))
    code, out, _ = contarm("equilibrium", "--file", "loads.json", "--json")
    two, straight = json.loads(out)
    assert two["tip"] == one["tip"]
    np.testing.assert_allclose(straight["tip"], [0, 0, 0.37], atol=1e-12)
    assert code == 0


def test_equilibrium_without_one_is_exit_code_1(contarm):
    words = ["--gravity", 0, 0, -9.81, "--mass", 1.0, "--method", "newton", "--json"]
    code, out, _ = contarm("equilibrium", *words)
    assert code == 1
    assert json.loads(out)["stable"] is False


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


@pytest.mark.parametrize("redirect", [">/dev/full", ">&-"])
def test_a_stdout_that_takes_nothing_is_no_traceback(tmp_path, redirect):
    words = f"{sys.executable} -m contarm_sim fk --bend 1 0 {redirect}"
    done = subprocess.run(words, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert "Traceback" not in done.stderr


def test_muscle_prints_and_draws_the_force_family(contarm, tmp_path):
    code, out, err = contarm("muscle", "--pressure", 350e3, 700e3, "--out", "law.svg", "--json")
    assert code == 0, err
    found = json.loads(out)
    forces = np.array(found["force_n"])
    np.testing.assert_allclose(forces[1], 2 * forces[0])
    assert forces[:, -1] == pytest.approx(0, abs=1e-9)
    assert found["blocked_force_n"] == pytest.approx(177, abs=1)
    assert (tmp_path / "law.svg").read_text().startswith("<?xml")
    assert "700 kPa [N]" in contarm("muscle")[1]


def test_compare_controllers_tells_them_apart(typed):
    done, place = typed("compare-controllers")
    (folder,) = place.glob("runs/compare-controllers-*")
    found = json.loads((folder / "summary.json").read_text())["rows"]
    failed = [row for row in found if "failed" in row]
    assert all("kPa" in row["failed"] for row in failed)
    assert done.returncode == (1 if failed else 0), done.stderr
    rows = {(row["load"], row["controller"]): row for row in found}
    assert len(rows) == 18
    assert rows["free", "paper"]["pushes"] > 0
    assert rows["free", "servo"]["pushes"] == 0
    for load in ("gravity", "payload"):
        assert rows[load, "tip"]["tip_rms_percent"] < 0.5 * rows[load, "servo"]["tip_rms_percent"]
        assert rows[load, "tip"]["along_rms_percent"] < 0.4 * rows[load, "servo"]["along_rms_percent"]
    assert os.listdir(folder) == ["summary.json"]


@pytest.mark.parametrize("bend", [(1.0472, 0.0), (0.5, 1.0)])
def test_stiffness_in_closed_form_and_by_pushing_agree(contarm, tmp_path, bend):
    code, out, err = contarm("stiffness", "--bend", *bend, "--levels", 3, "--out", "s", "--json")
    assert code == 0, err
    rows = json.loads(out)["rows"]
    for row in rows:
        np.testing.assert_allclose(row["simulated_n_per_m"], row["closed_form_n_per_m"], rtol=0.02)
        assert row["drift_percent"] < 0.2
        assert max(row["pressures_pa"]) <= 700e3 * (1 + 1e-9)
    assert rows[-1]["simulated_n_per_m"][1] > 1.3 * rows[0]["simulated_n_per_m"][1]
    assert set(os.listdir(tmp_path / "s")) == {"summary.json", "stiffness.png"}


def test_hold_prints_what_holds_a_bend_and_refuses_what_pressure_cannot(contarm):
    code, out, err = contarm("hold", "--bend", 1.5, 0.5, "--share", 0.5, "--gravity", 0, 0, 9.81, "--json")
    assert code == 0, err
    found = json.loads(out)
    assert all(90e3 <= p <= 700e3 for p in found["pressures"])
    assert found["level_range"][0] < found["level"] < found["level_range"][1]
    assert "pressure [kPa]" in contarm("hold", "--bend", 1.5, 0.5)[1]
    code, out, err = contarm("hold", "--bend", 3, 0)
    assert code == 2
    assert re.fullmatch(r"contarm: bend is one that needs 1\d\d\d kPa; allowed: .*available 90 to 700 kPa\n", err)
    code, out, err = contarm("hold", "--bend", 1, 0, "--share", 1.5)
    assert (code, err) == (2, "contarm: share is 1.5; allowed: 0 to 1\n")


def test_possibility_maps_three_loads(typed):
    done, place = typed("possibility")
    assert done.returncode == 0, done.stderr
    (folder,) = place.glob("runs/possibility-*")
    rows = json.loads((folder / "summary.json").read_text())["rows"]
    largest = {load: min(row["inflated_deg"] for row in rows if row["load"] == load) for load in ("free", "payload")}
    assert 130 < largest["free"] < 145
    assert largest["payload"] < largest["free"] - 10
    assert max(row["simulated_off_deg"] for row in rows if row["load"] == "free") < 0.3
    assert set(os.listdir(folder)) == {"summary.json", "possibility.png"}


def test_release_swings_and_checks_itself(contarm, tmp_path):
    code, out, err = contarm("release", "--duration", 0.6, "--links", 12, "--out", "r", "--json")
    assert code == 0, err
    found = json.loads(out)
    assert found["tip_error_mean_percent"] < 0.1
    assert found["tip_error_mean_percent"] <= found["step_error_mean_percent"] + found["links_error_mean_percent"]
    assert found["observed_order"] == pytest.approx(1, abs=0.15)
    assert found["small_swing"]["decay_per_s"] == pytest.approx(found["small_swing_of_beam"]["decay_per_s"], rel=0.01)
    assert len(found["time"]) == len(found["places"][0]["quaternion"]) == 61
    assert found["beam_hz"][0] == pytest.approx(found["chain_hz"][0], rel=0.02)
    assert found["largest_energy_growth_j"] <= 1e-12
    assert set(os.listdir(tmp_path / "r")) == {"summary.json", "swing.csv", "swing.png"}
    code, out, err = contarm("release", "--links", 4, "--duration", 0.6, "--out", "coarse")
    assert code == 1, err
    assert "FAIL" in out
    (tmp_path / "bad.csv").write_text("0,1,2\n")
    for words in (
        ("--timestep", 0.003), ("--duration", -1), ("--muscles", "tensions 1 2"), ("--sample-period", 0.0105),
        ("--xi", 1.5), ("--ramp-down", 0), ("--forces", "none.csv"), ("--forces", "bad.csv"), ("--links", 3),
    ):  # fmt: skip
        code, out, err = contarm("release", *words, "--out", "no")
        assert code == 2
        assert err.startswith("contarm: ")
        assert not (tmp_path / "no").exists()


def test_release_records_places_and_follows_forces(contarm, tmp_path):
    (tmp_path / "push.csv").write_text("t,fx,fy,fz\n0,0.2,0,0\n0.1,0,0.2,0\n0.2,0,0,0\n")
    code, _, err = contarm(
        "release", "--forces", "push.csv", "--forces-xi", 0.5, "--xi", 0.5, 1, "--sample-period", 0.005,
        "--duration", 0.3, "--links", 12, "--section-radius", 0.003, "--out", "pushed",
    )  # fmt: skip
    assert code == 0, err
    header, *rows = (tmp_path / "pushed" / "swing.csv").read_text().splitlines()
    assert header.startswith("time_s,energy_j,xi_0.5_x_m,")
    assert "tip_qw" in header
    assert len(rows) == 61
    assert len(rows[0].split(",")) == 2 + 2 * (7 + 3)
    code, out, err = contarm("release", "--ramp-down", 0.1, "--duration", 0.3, "--links", 12, "--out", "faded")
    assert code == 0, err
    assert "both together" in out


def test_build_writes_pneumatic_arms(contarm, tmp_path):
    code, _, err = contarm("build", "--actuation", "pressures", "--muscle.valve-time", 0.1, "--out", "b")
    assert code == 0, err
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "b" / "scene.xml"))
    assert (model.nu, model.na) == (6, 6)
    assert model.actuator_dynprm[0, 0] == 0.1


@pytest.mark.parametrize(
    "words", [("--joint-friction", 0), ("--muscle.braid-friction", -1), ("--muscle.passive-stiffness", 0),
              ("--muscle.valve-time", 0), ("--torsional-stiffness", 0), ("--bending-stiffness", -1)],
)  # fmt: skip
def test_frictions_and_stiffnesses_of_zero_or_below_are_refused(contarm, words):
    code, _, err = contarm("equilibrium", *words)
    assert code == 2
    assert re.fullmatch(r"contarm: \S+ is -?[01](\.0)?; allowed: a finite number, greater than 0.*\n", err)


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
def test_render_draws_what_a_run_left_and_refuses_the_rest(contarm, tmp_path):
    code, _, err = contarm("run", "--duration", 1, "--turns", 0.2, "--no-video", "--out", "r")
    assert code in (0, 1), err
    code, out, err = contarm("render", "r", "--size", "480p", "--fps", 5, "--out", "r.webp", "--json")
    if code == 1 and "GL" in err:
        pytest.skip("no GL library here")
    assert (code, json.loads(out)) == (0, {"file": "r.webp"}), err
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


@pytest.mark.parametrize(
    "text", ["[" * 100_000, "1" * 5000, '[{"wrenches": [{"xi": 1, "force": "123"}]}]', "[]",
             '[{}, {"muscles": {"kind": "pressures", "values": [1, 2, 3]}}]'],
    ids=["deep", "long", "words", "empty", "pressures"],
)  # fmt: skip
def test_bad_load_files_are_one_line_that_names_the_place(contarm, tmp_path, text):
    (tmp_path / "loads.json").write_text(text)
    code, _, err = contarm("equilibrium", "--file", "loads.json")
    assert code == 2
    assert err.count("\n") == 1
    assert "loads.json" in err
    assert ("case 2" in err) is ("pressures" in text)


def test_release_of_nothing_and_of_a_bent_arm(contarm):
    code, out, err = contarm("release", "--wrench", *[0] * 7, "--duration", 0.1, "--out", "none", "--json")
    assert code == 0, err
    assert json.loads(out)["observed_order"] is None
    code, out, err = contarm("release", "--muscles", "bend", 1.5, 0, "--duration", 0.1, "--out", "bent", "--json")
    assert code == 0, err
    found = json.loads(out)["arm_hz"]
    assert len(found) == 6
    assert found[1] > 1.1 * found[0]  # a bent arm swings differently in and across its plane


def test_a_straight_pose_is_rigid_along_itself(contarm):
    code, out, err = contarm("stiffness", "--bend", 0, 0, "--levels", 2, "--out", "s")
    assert code == 0, err
    assert "along rigid" in out


def test_figures_are_named_drawn_and_refused(contarm, tmp_path):
    assert "possibility" in contarm("figures", "--list")[1]
    assert len(json.loads(contarm("figures", "--list", "--json")[1])) >= 10
    code, out, err = contarm("figures", "fan", "--kind", "pdf", "--kind", "png", "--links", 6, "--out", "f", "--json")
    assert code == 0, err
    assert json.loads(out) == {"files": ["f/fan.pdf", "f/fan.png"]}
    assert (tmp_path / "f" / "fan.pdf").read_bytes().startswith(b"%PDF")
    code, _, err = contarm("figures", "fam", "--out", "g")
    assert code == 2
    assert "'fam'" in err
    assert not (tmp_path / "g").exists()


@pytest.mark.gl
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


def test_a_run_through_poses_that_have_no_rest_is_kept_and_says_so(contarm, tmp_path):
    """Muscles of 177 N cannot hold 4 kg out sideways."""
    load, path = ("--gravity", 0, 0, 9.81, "--payload", 4), ("--duration", 2, "--turns", 1, "--no-video")
    code, out, _ = contarm("run", *load, *path, "--out", "r")
    assert code in (0, 1)
    assert "motion share unavailable: a commanded pose is unstable or has no equilibrium" in out
    assert "motion: simulated tip vs at rest" not in out
    assert json.loads((tmp_path / "r" / "summary.json").read_text())["motion"] is None
    assert "Motion share unavailable" in (tmp_path / "r" / "report.html").read_text()


@pytest.mark.parametrize(("library", "command", "extra"), [("gymnasium", "envs", "gym"), ("viser", "view", "view")])
def test_without_an_optional_library_one_line_says_what_to_install(library, command, extra):
    code = f"""if True:
        import sys
        sys.modules[{library!r}] = None
        sys.argv = ["contarm", {command!r}]
        from contarm_sim.__main__ import main
        main()"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"contarm: {library} is not installed; get it with: pip install 'contarm-sim[{extra}]'\n"


def test_the_command_line_takes_every_controller_there_is():
    import click

    from contarm_sim.cli.main import cli
    from contarm_sim.control.registry import NAMES

    for name in ("run", "view"):
        taken = next(option for option in cli.commands[name].params if option.name == "controller").type
        assert isinstance(taken, click.Choice)
        assert tuple(taken.choices) == NAMES


def test_units_on_flags_and_in_files(contarm, tmp_path):
    """The same numbers with units and in SI give the same answers, to the last bit."""
    plain = contarm("fk", "--bend", "1.5707963267948966", 0, "--length", 0.25, "--muscle.max-pressure", 600e3, "--json")
    written = contarm("fk", "--bend", "90deg", "0", "--length", "250mm", "--muscle.max-pressure", "600 kPa", "--json")
    assert plain == written
    (tmp_path / "arm.toml").write_text('length = "25 cm"\n[muscle]\nmax_pressure = "6 bar"\n')
    assert contarm("fk", "--bend", "90deg", "0", "--arm", "arm.toml", "--json") == plain
    (tmp_path / "mm.csv").write_text("x [mm],y [mm],z [mm],w\n235.5,0,235.5,1\n")
    code, out, err = contarm("ik", "--file", "mm.csv", "--out", "found.csv")
    assert code == 0, err
    assert out.startswith("1 targets solved; the largest miss is")
    assert err.splitlines()[:2] == ["mm.csv: converted x from mm to m, y from mm to m, z from mm to m",
                                    "mm.csv: not read: column 'w'"]  # fmt: skip


def test_init_writes_an_arm_to_be_edited(contarm, tmp_path):
    assert contarm("init", "my.toml")[:2] == (0, "")
    assert load_arm("my.toml") == Arm()
    text = (tmp_path / "my.toml").read_text()
    for name, item in {**PARAMETERS, **MUSCLE_PARAMETERS}.items():
        assert re.search(rf"^(# )?{name} =", text, re.MULTILINE)
        assert item.metadata["help"] in text
        assert f"[{item.metadata['unit']}]" in text or item.metadata["unit"] == "-"
    assert contarm("init", "other.toml", "--length", "250mm", "--torsional-stiffness", "0.1")[0] == 0
    assert load_arm("other.toml") == Arm(length=0.25, torsional_stiffness=0.1)
    code, out, err = contarm("init", "my.toml")
    assert (code, out, "does not exist yet" in err) == (2, "", True)


def test_help_says_of_every_command_what_it_does(contarm):
    _, out, _ = contarm("--help")
    assert "..." not in out.partition("Commands:")[2]
    assert all(len(meaning) < 45 and meaning in out for meaning in SHORT.values())
    assert {command.name for command in COMMANDS} == set(SHORT)


@pytest.mark.parametrize("closing", ["2>&-", "2>/dev/full"])
def test_a_closed_stderr_leaves_stdout_one_document(tmp_path, closing):
    (tmp_path / "f.csv").write_text("x [mm],y [mm],z [mm]\n235.5,0,235.5\n")
    words = f"{sys.executable} -m contarm_sim ik --file f.csv --out o.csv --json {closing}"
    done = subprocess.run(words, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0
    assert len(json.loads(done.stdout)) == 1


def test_a_full_disk_and_a_reader_that_left_have_exit_codes_of_their_own(tmp_path):
    def call(line):
        line = line.replace("contarm", f"{sys.executable} -m contarm_sim")
        return subprocess.run(["bash", "-c", line], cwd=tmp_path, capture_output=True, text=True)

    for words in ("--help", "fk --help", "fk --bend 1 0", "muscle"):
        done = call(f"contarm {words} > /dev/full")
        assert (done.returncode, done.stderr) == (1, "contarm: cannot write: No space left on device\n"), words
        done = call(f"contarm {words} | true; exit ${{PIPESTATUS[0]}}")
        assert (done.returncode in (0, 141), done.stderr) == (True, ""), words
