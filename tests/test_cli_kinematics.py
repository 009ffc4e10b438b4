"""`contarm fk`, `ik` and `build`: documents and files."""

import json
import os

import mujoco
import numpy as np
import pytest

from contarm_sim.kinematics import arc


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


def test_build_writes_pneumatic_arms(contarm, tmp_path):
    code, _, err = contarm("build", "--actuation", "pressures", "--muscle.valve-time", 0.1, "--out", "b")
    assert code == 0, err
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "b" / "scene.xml"))
    assert (model.nu, model.na) == (6, 6)
    assert model.actuator_dynprm[0, 0] == 0.1
