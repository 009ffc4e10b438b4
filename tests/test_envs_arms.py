"""Whose environment it is: arms by value, preset and file, and what loads them, alike in every front end."""

import importlib.util

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

import contarm_sim.envs.gym  # noqa: E402, F401
from contarm_sim.envs.definition import define  # noqa: E402
from contarm_sim.envs.registration import NAMES  # noqa: E402
from contarm_sim.errors import InputError  # noqa: E402
from contarm_sim.model.arm import Arm  # noqa: E402
from contarm_sim.model.arm_file import arm_to_toml  # noqa: E402
from contarm_sim.model.presets import PRESETS, preset  # noqa: E402


def front_ends(task, **given):
    """Yield the definition that each front end works with."""
    yield gymnasium.make(NAMES[task], **given).unwrapped.definition
    yield gymnasium.make_vec(NAMES[task], 2, **given).unwrapped.definition
    if importlib.util.find_spec("dm_control") is not None:
        from contarm_sim.envs import dm

        yield dm.load(task, random=0, **given).task.definition


def test_an_arm_may_be_a_value_a_preset_or_a_file(tmp_path):
    own = Arm(length=0.25, links=12, mass=0.2)
    file = tmp_path / "own.toml"
    file.write_text(arm_to_toml(own))
    for given in (own, file, str(file)):
        assert [found.arm for found in front_ends("reach", arm=given)].count(own) >= 2
    for name in PRESETS:
        assert define("reach", name).arm == preset(name)
    assert all(found.arm == preset("two") for found in front_ends("track", arm="two"))


def test_units_of_a_file_are_read(tmp_path):
    (tmp_path / "own.toml").write_text('length = "250 mm"\nmass = "200 g"\n')
    assert define("reach", tmp_path / "own.toml").arm == Arm(length=0.25, mass=0.2)


def test_gravity_and_payload_take_the_place_of_the_arms_own():
    for found in front_ends("reach", arm="two", gravity=(0, 0, -9.81), payload=0.02):
        assert (found.arm.gravity, found.arm.payload) == ((0.0, 0.0, -9.81), 0.02)
        assert found.arm.sections == preset("two").sections
    assert define("reach", "two", payload=0.02).arm.gravity == (0.0, 0.0, 9.81)
    assert define("reach", "two", gravity=(0, 0, 0)).arm.gravity == (0.0, 0.0, 0.0)


def test_a_loaded_arm_falls_the_way_that_gravity_points():
    arm, tips = Arm(bending_stiffness=0.05, links=12), []
    for gravity in ((0, 0, 0), (9.81, 0, 0), (-9.81, 0, 0)):
        env = gymnasium.make(NAMES["reach"], arm=arm, gravity=gravity)
        env.reset(seed=0)
        for _ in range(20):
            observation = env.step(np.zeros(2))[0]
        tips.append(env.unwrapped.definition.unflat(observation)["tip_position"][0])
    assert tips[0] == pytest.approx(0, abs=1e-6)
    assert tips[1] > 0.002
    assert tips[2] == pytest.approx(-tips[1], rel=1e-3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"arm": "tow"}, "arm is 'tow'; allowed: an Arm, a preset (paper, two, three, tendon), or a file"),
        ({"arm": "missing.toml"}, "missing.toml: file is unreadable"),
        ({"gravity": 9.81}, "gravity is 9.81; allowed: 3 finite numbers"),
        ({"payload": -1}, "payload is -1; allowed: a finite number, at least 0"),
    ],
)
def test_what_is_no_arm_is_said_in_one_line(given, said):
    with pytest.raises(InputError) as caught:
        gymnasium.make(NAMES["reach"], **given)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
