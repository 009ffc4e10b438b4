"""The presets: their muscles hold them, the engine steps them, and files say the same."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest
from section_balance import inflated_pressures, random_bends, tensions

import contarm_sim
from contarm_sim.engine.plant import engine_room
from contarm_sim.errors import InputError
from contarm_sim.mjcf import TIMESTEP, scene_spec
from contarm_sim.model import presets
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict, arm_to_dict, load_arm
from contarm_sim.model.template import arm_template
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference

SEVERAL = ("two", "three", "tendon")


def test_their_names():
    assert contarm_sim.presets is presets
    assert presets.preset("paper") == Arm()
    assert [len(make().sections) for make in presets.PRESETS.values()] == [1, 2, 3, 3]
    with pytest.raises(InputError, match="paper, two, three, tendon"):
        presets.preset("four")


@pytest.mark.parametrize("name", ["two", "three"])
@pytest.mark.parametrize("hanging", [False, True])
def test_pressures_hold_every_bend_to_a_quarter_turn_a_section(name, hanging):
    """By virtual work: all muscles inflated, by pressures and at lengths that there are."""
    arm = presets.preset(name) if hanging else presets.preset(name).unloaded
    bends = random_bends(np.random.default_rng(0), 2000, arm)
    pressures, lengths = inflated_pressures(bends, arm), tensions(bends, arm)[1]
    assert pressures.min() > 0.999 * 90e3
    assert pressures.max() < 700e3
    each = np.split(lengths, len(arm.groups), axis=-1)
    for group, own in zip(arm.groups, each, strict=True):
        assert group.length_range[0] < own.min()
        assert own.max() < group.length_range[1]


@pytest.mark.parametrize("name", ["two", "three"])
def test_pressures_hold_bends_in_the_engine(name):
    arm = presets.preset(name)
    bends = random_bends(np.random.default_rng(1), 4, arm).reshape(4, -1)
    found = poses_at_rest(arm, Reference.from_bends(bends, arm), "pressure")
    assert found.pressure.min() > 0.999 * 90e3
    assert found.pressure.max() < 700e3


def test_tendons_hold_every_bend_to_a_quarter_turn_a_section():
    arm = presets.tendon()
    pulls, lengths = tensions(random_bends(np.random.default_rng(0), 2000, arm), arm)
    assert pulls.min() > 0
    assert pulls.max() < 0.5 * arm.muscle.blocked_force
    assert lengths.min() > 0


def _controls(arm, kind, rng):
    """Return one control a muscle, from nothing to moderate ones: 12 mm, 30 N, 400 kPa."""
    count = sum(group.routing.count for group in arm.groups)
    return {"lengths": 0.012 * rng.uniform(-1, 1, count), "tensions": rng.uniform(5, 30, count),
            "pressures": rng.uniform(0, 4e5, count)}[kind]  # fmt: skip


@pytest.mark.parametrize("actuation", ["lengths", "tensions", "pressures"])
@pytest.mark.parametrize("name", list(presets.PRESETS))
def test_two_seconds_at_the_default_step_are_calm(name, actuation):
    arm = presets.preset(name)
    if name == "tendon" and actuation == "pressures":
        return
    model = scene_spec(arm, actuation).compile()
    assert model.opt.timestep == TIMESTEP
    rng = np.random.default_rng(0)
    for controls in (np.zeros(model.ntendon), _controls(arm, actuation, rng), _controls(arm, actuation, rng)):
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.ctrl[:] = np.tile(controls, model.nu // model.ntendon)
        with engine_room():
            mujoco.mj_step(model, data, round(2 / TIMESTEP))
        assert not data.warning.number.any()
        assert np.abs(data.qvel).max() < 1.0


@pytest.mark.parametrize("name", list(presets.PRESETS))
def test_files_say_the_same(name, tmp_path):
    arm = presets.preset(name)
    assert arm_from_dict(arm_to_dict(arm)) == arm
    (tmp_path / "arm.toml").write_text(arm_template(arm))
    assert load_arm(tmp_path / "arm.toml") == arm


@pytest.fixture
def contarm(tmp_path):
    def run(*words):
        command = [sys.executable, "-m", "contarm_sim", *words]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)

    return run


def test_the_command_line_begins_with_them(contarm, tmp_path):
    assert contarm("build", "--preset", "two", "--payload", "20g", "--out", "made").returncode == 0
    made = load_arm(tmp_path / "made" / "arm.toml")
    assert (made.payload, made.unloaded) == (0.02, presets.two().unloaded)
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "made" / "scene.xml")).nu == 6
    assert contarm("init", "own.toml", "--preset", "tendon").returncode == 0
    assert load_arm(tmp_path / "own.toml") == presets.tendon()
    for words, said in (
        (("--arm", "own.toml", "--preset", "two"), "either --preset or --arm"),
        (("--preset", "two", "--length", "0.3"), "length is 0.3; allowed: an arm of one section; this one has 2"),
        (("--preset", "two", "--muscle.wall", "1mm"), "muscle.wall is 0.001; allowed: an arm of one section"),
        (("--preset", "tendon", "--actuation", "pressures"), "'pressures' with the law Tendon, which has none"),
        (("--preset", "four"), "'four' is not one of"),
    ):
        failed = contarm("build", *words, "--out", "other")
        assert failed.returncode == 2
        assert said in failed.stderr
        assert failed.stderr.count("\n") == 1
    assert not (tmp_path / "other").exists()
