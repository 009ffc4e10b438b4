"""The generated MJCF: what it weighs and measures, that files say the same as specs, and that it survives abuse."""

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from sampling import HEAVY

from contarm_sim.engine.plant import engine_room
from contarm_sim.mjcf import ACTUATIONS, arm_spec, exact_xml, scene_spec, write_models
from contarm_sim.model.arm import Arm
from contarm_sim.model.presets import tendon, two

MODELS = Path(__file__).parents[1] / "models"
FOLDERS = {
    "contarm": (Arm(), "lengths"), "contarm_pneumatic": (Arm(), "pressures"), "contarm_two": (two(), "lengths"),
    "contarm_tendon": (tendon(), "lengths"),
}  # fmt: skip


def _float_arrays(model):
    for name in dir(model):
        value = getattr(model, name)
        if not name.startswith("_") and isinstance(value, np.ndarray) and value.dtype == np.float64:
            yield name, value


@pytest.mark.parametrize("make", [arm_spec, scene_spec])
@pytest.mark.parametrize("arm", [Arm(), HEAVY], ids=["paper", "heavy"])
@pytest.mark.parametrize("actuation", ACTUATIONS)
def test_the_file_compiles_to_the_same_numbers_as_the_spec(make, arm, actuation):
    """MuJoCo's own writer rounds to six digits; ours must not."""
    model = make(arm, actuation).compile()
    again = mujoco.MjModel.from_xml_string(exact_xml(make(arm, actuation)))
    for name, value in _float_arrays(model):
        np.testing.assert_allclose(getattr(again, name), value, rtol=1e-14, atol=1e-15, err_msg=name)


def _words(file):
    """Split MJCF into words and numbers; the last digit of a cosine differs between machines."""
    return re.split(r'[\s"=]+', file.read_text())


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_committed_models_are_what_the_generator_makes(tmp_path, folder):
    arm, actuation = FOLDERS[folder]
    write_models(arm, tmp_path, actuation)
    for name in ("arm.xml", "scene.xml"):
        committed, made = (_words(place / name) for place in (MODELS / folder, tmp_path))
        assert len(committed) == len(made), "run scripts/models"
        for one, other in zip(committed, made, strict=True):
            assert one == other or float(one) == pytest.approx(float(other), rel=1e-12, abs=1e-15), "run scripts/models"


@pytest.mark.parametrize("name", ["arm.xml", "scene.xml"])
@pytest.mark.parametrize("folder", FOLDERS)
def test_committed_models_survive_a_second_of_random_control(folder, name):
    model = mujoco.MjModel.from_xml_path(str(MODELS / folder / name))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    rng = np.random.default_rng(0)
    low, high = model.actuator_ctrlrange.T
    with engine_room():
        while data.time < 1.0:
            data.ctrl[:] = rng.uniform(low, high)
            mujoco.mj_step(model, data)
    assert not data.warning.number.any()
    assert np.isfinite(data.qpos).all()


@pytest.mark.parametrize("arm", [Arm(), HEAVY], ids=["paper", "heavy"])
def test_mass_and_its_centre(arm):
    model = arm_spec(arm).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    total = model.body_mass.sum()
    assert total == pytest.approx(arm.mass + arm.payload, rel=1e-12)
    centre = (model.body_mass @ data.xipos)[2] / total
    assert centre == pytest.approx((arm.mass * arm.length / 2 + arm.payload * arm.length) / total, rel=1e-12)


def test_straight_keyframe_is_an_equilibrium_with_every_muscle_at_its_least_tension(arm):
    model = arm_spec(arm).compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("straight").id)
    mujoco.mj_forward(model, data)
    np.testing.assert_array_equal(data.ten_length, 0.0)  # counted from the straight arm
    np.testing.assert_array_equal(data.ctrl, 0.0)
    np.testing.assert_allclose(-data.actuator_force, arm.muscle.min_tension, rtol=1e-6)
    assert np.abs(data.qfrc_smooth).max() < 1e-12


def test_hinge_order_is_palindromic():
    axes = [joint.name[-1] for joint in arm_spec(Arm(links=8)).joints]
    assert "".join(axes) == "xyyxyxxy" * 2
    axes = [joint.name[-1] for joint in arm_spec(Arm(links=8, torsional_stiffness=0.1)).joints]
    assert "".join(axes) == "xyzzyxzyxxyz" * 2


def test_links_never_touch_each_other_but_do_touch_the_world(arm):
    model = scene_spec(arm).compile()
    data = mujoco.MjData(model)
    data.joint("joint_02_y").qpos = 2.5  # folded down to the floor
    mujoco.mj_forward(model, data)
    floor = model.geom("floor").id
    pairs = data.contact.geom[: data.ncon]
    assert len(pairs)
    assert np.all((pairs == floor).any(axis=1))


def test_every_quantity_a_user_reads_has_a_sensor(arm):
    model = arm_spec(arm).compile()
    data = mujoco.MjData(model)
    data.qpos[:] = 0.05
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.sensor("tip_position").data, data.site("tip").xpos)
    for i in (1, 2, 3):
        assert data.sensor(f"muscle_{i}_length").data[0] == data.tendon(f"muscle_{i}").length[0]
        assert data.sensor(f"muscle_{i}_force").data[0] == data.actuator(f"muscle_{i}").force[0]
        assert data.sensor(f"muscle_{i}_velocity").data[0] == 0
    assert data.sensor("joint_24_y_angle").data[0] == 0.05
    assert model.nsensor == 2 + 9 + 48


@pytest.mark.parametrize("gravity", [(0, 0, 0), (0, 0, 9.81), (0, 0, -9.81), (9.81, 0, 0), (1, 2, 3)])
def test_gravity_points_down_the_picture(gravity):
    model = scene_spec(Arm(gravity=gravity)).compile()
    size = np.linalg.norm(gravity)
    np.testing.assert_allclose(model.opt.gravity, [0, 0, -size], atol=1e-12)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    base = data.body("base").xmat.reshape(3, 3)
    np.testing.assert_allclose(base.T @ model.opt.gravity, gravity, atol=1e-12)
    assert data.geom("floor").xpos[2] < data.body("base").xpos[2]


def test_a_stated_base_orientation_is_drawn_and_gravity_stays_in_the_base_frame():
    arm = Arm(gravity=(0, 0, 9.81), base_orientation=(1, 1, 0, 0))
    model = scene_spec(arm).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.body("base").xmat.reshape(3, 3).T @ model.opt.gravity, arm.gravity, atol=1e-12)


def test_the_offscreen_buffer_holds_1080p(arm):
    model = scene_spec(arm).compile()
    assert (model.vis.global_.offwidth, model.vis.global_.offheight) == (1920, 1080)
