"""The commands of the studies: documents, exit codes and files."""

import json
import os
import re

import numpy as np
import pytest


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
    figures = {"errors_by_bend.png", "error_maps.png", "convergence.png"}
    assert set(os.listdir(tmp_path / "v")) == {"summary.json", "samples.csv", "report.html", *figures}
    page = (tmp_path / "v/report.html").read_text()
    assert re.search(r"<h1>Constant curvature holds in \d of 5 scenarios; the largest error is [\d.]+\u00a0% of", page)
    assert re.search(r'card bad"><h2>Not every scenario is explained.</h2><p>[^<]*upright: no rest pose', page)
    assert page.count("data:image/png;base64,") == len(figures)
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
    figures = {"errors_by_bend.png", "error_maps.png"}
    assert set(os.listdir(tmp_path / "v")) == {"summary.json", "samples.csv", "report.html", *figures}
    assert '<section class="card bad"><h2>The simulation is not converged.' in (tmp_path / "v/report.html").read_text()


def test_validate_of_an_arm_that_blows_up_gives_no_real_time_factor(contarm, tmp_path):
    words = ("--muscle.servo-time", 0, "--damping-time", 0, "--mass", 0.01)
    code, out, err = contarm("validate", "--quick", *words, "--out", "v")
    assert code == 0, err
    assert "ideal, naive, gravity, payload, upright: stepping blows up" in out
    assert json.loads((tmp_path / "v/summary.json").read_text())["ideal"]["real_time_factor"] is None
    assert os.listdir(tmp_path) == ["v"]


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


@pytest.mark.parametrize(
    "words", [("--links", 12, "--duration", 4), pytest.param((), marks=pytest.mark.slow)], ids=["short", "full"]
)
def test_compare_controllers_tells_them_apart(contarm, tmp_path, words):
    code, _, err = contarm("compare-controllers", *words)
    (folder,) = tmp_path.glob("runs/compare-controllers-*")
    found = json.loads((folder / "summary.json").read_text())["rows"]
    failed = [row for row in found if "failed" in row]
    assert all(f"needs {row['needed_pressure_pa'] / 1e3:.0f} kPa" in row["failed"] for row in failed)
    assert code == (1 if failed else 0), err
    rows = {(row["load"], row["controller"]): row for row in found}
    assert len(rows) == 18
    assert rows["free", "paper"]["pushes"] > 0
    assert rows["free", "servo"]["pushes"] == 0
    for load in ("gravity", "payload"):
        assert rows[load, "tip"]["tip_rms_percent"] < 0.5 * rows[load, "servo"]["tip_rms_percent"]
        assert rows[load, "tip"]["along_rms_percent"] < 0.4 * rows[load, "servo"]["along_rms_percent"]
    assert set(os.listdir(folder)) == {"summary.json", "controllers.png"}


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
    assert re.fullmatch(
        r"contarm: bend is one that needs 1\d\d\d kPa; allowed: bends that 90 to 700 kPa can hold\n", err
    )
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
    code, out, err = contarm("figures", "fan", "--figures", "pdf,png", "--links", 6, "--out", "f", "--json")
    assert code == 0, err
    assert json.loads(out) == {"files": ["f/fan.pdf", "f/fan.png"]}
    assert (tmp_path / "f" / "fan.pdf").read_bytes().startswith(b"%PDF")
    code, _, err = contarm("figures", "fam", "--out", "g")
    assert code == 2
    assert "'fam'" in err
    assert not (tmp_path / "g").exists()
