"""Environments for arms of two and three sections: sizes, bits, targets that the muscles hold, baselines, refusals."""

import json
from dataclasses import replace

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import contarm_sim.envs.gym  # noqa: E402, F401
from contarm_sim.envs.actions import MODES, Actions, action_names  # noqa: E402
from contarm_sim.envs.aiming import nearest_bends  # noqa: E402
from contarm_sim.envs.baseline import baseline, random_policy  # noqa: E402
from contarm_sim.envs.definition import define  # noqa: E402
from contarm_sim.envs.ellipses import around, draw_ellipses  # noqa: E402
from contarm_sim.envs.gym import ArmEnv  # noqa: E402
from contarm_sim.envs.registration import NAMES  # noqa: E402
from contarm_sim.envs.scores import score  # noqa: E402
from contarm_sim.envs.task import LIMIT  # noqa: E402
from contarm_sim.envs.vector import ArmVectorEnv  # noqa: E402
from contarm_sim.errors import InputError  # noqa: E402
from contarm_sim.kinematics import sections  # noqa: E402
from contarm_sim.mechanics import muscles, shape  # noqa: E402
from contarm_sim.mechanics.pressures import pressure_needed  # noqa: E402
from contarm_sim.model.arm import Arm  # noqa: E402
from contarm_sim.model.arm_file import arm_to_toml  # noqa: E402
from contarm_sim.model.load import Load, Muscles  # noqa: E402
from contarm_sim.model.mckibben import McKibben  # noqa: E402
from contarm_sim.model.routing import Routing  # noqa: E402
from contarm_sim.model.section import Section  # noqa: E402
from contarm_sim.statics.equilibrium import equilibrium  # noqa: E402

SECTIONS = (
    Section(length=0.2, links=8, mass=0.12),
    Section(length=0.17, links=6, mass=0.1, bending_stiffness=0.08),
    Section(length=0.12, links=4, mass=0.05, bending_stiffness=0.06),
)
TWO, THREE = Arm(sections=SECTIONS[:2]), Arm(sections=SECTIONS)
ODD = Arm(
    sections=(SECTIONS[0], replace(SECTIONS[1], torsional_stiffness=0.05)),
    routings=(Routing(count=4, radius=0.016), Routing(radius=0.015, offset=0.4, start="base")),
    laws=(McKibben(), McKibben(min_tension=2.0)),
)
ARMS = {"two": TWO, "three": THREE, "odd": ODD}
TASKS = ("reach", "track")
VARIATIONS = {
    "payload": lambda initial, current, random: random.uniform(0, 0.03),
    "section_2.bending_stiffness": lambda initial, current, random: initial * random.uniform(0.8, 1.2),
    "section_1.muscle.braid_friction": 0.1,
}
each_arm = pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
each_task = pytest.mark.parametrize("task", TASKS)


def vector(count, task="reach", arm=TWO, **given):
    return ArmVectorEnv(count, task=task, arm=arm, **given)


@each_arm
@pytest.mark.parametrize("mode", MODES)
def test_gymnasiums_own_checker_is_content(arm, mode):
    for task in TASKS if mode == "bend" else TASKS[:1]:
        env = gymnasium.make(NAMES[task], arm=arm, actions=mode, disable_env_checker=True)
        check_env(env.unwrapped, skip_render_check=True)


@each_arm
def test_sizes_follow_the_arm(arm):
    count, n = len(arm.sections), muscles.count(arm)
    dofs = sum((2 if section.torsional_stiffness is None else 3) * section.links for section in arm.sections)
    for task, extra in (("reach", 6), ("track", 12)):
        for mode in MODES:
            definition = define(task, arm, mode)
            seen = 3 * n + dofs + 3 + 4 + 3 * (count - 1) + extra + (n if mode == "pressures" else 0)
            assert definition.size == seen
            assert definition.actions.size == (2 * count if mode == "bend" else n)
            assert len(set(action_names(arm, mode))) == definition.actions.size


def test_names_and_sizes_of_one_section_are_as_they_were():
    definition = define("reach")
    assert definition.sizes == {
        "muscle_lengths": 3, "muscle_velocities": 3, "actuator_tensions": 3, "joint_angles": 48, "tip_position": 3,
        "tip_orientation": 4, "target": 3, "to_target": 3,
    }  # fmt: skip
    assert isinstance(definition.actions.middle, float)
    assert action_names(Arm(), "bend") == ["bend_x", "bend_y"]
    assert define("track").task.drawn == ("path", "max_bend", "turn")


@each_arm
def test_the_flat_observation_is_what_the_engine_says(arm):
    env = ArmEnv("reach", arm, "pressures")
    env.reset(seed=2)
    for _ in range(5):
        observation, reward, _, _, info = env.step(np.linspace(-0.5, 0.5, env.action_space.shape[0]))
    seen, data = env.definition.unflat(observation), env._physics.data
    np.testing.assert_allclose(seen["tip_position"], data.body("tip").xpos, atol=1e-12)
    ends = [data.body(f"section_{number}_tip").xpos for number in range(1, len(arm.sections))]
    np.testing.assert_allclose(seen["section_ends"], np.concatenate(ends), atol=1e-12)
    np.testing.assert_allclose(seen["joint_angles"], data.qpos, atol=1e-12)
    np.testing.assert_allclose(seen["pressures"], data.act[: muscles.count(arm)], rtol=1e-9)
    straight = muscles.each(arm, lambda group: group.length if group.routing.path == "parallel" else 0.0)
    np.testing.assert_allclose(seen["muscle_lengths"], straight + data.ten_length, atol=1e-12)
    miss = np.linalg.norm(seen["target"] - seen["tip_position"])
    assert info["error"] == pytest.approx(miss, abs=1e-12)
    assert reward == pytest.approx(0.05 * arm.length / (0.05 * arm.length + miss), abs=1e-9)


def test_section_ends_are_those_of_the_kinematics():
    """At rest under bends asked for, to what links bend otherwise than arcs."""
    env, bend = ArmEnv("reach", THREE), np.array([0.4, -0.2, -0.3, 0.5, 0.2, 0.6])
    env.reset(seed=0)
    action = env.definition.actions.asking(bend)
    for _ in range(40):
        observation = env.step(action)[0]
    seen = env.definition.unflat(observation)
    frames = sections.frames(bend.reshape(3, 2), shape.backbone(THREE))
    expected = [*frames[1:3, :3, 3].ravel(), *frames[3, :3, 3]]
    np.testing.assert_allclose([*seen["section_ends"], *seen["tip_position"]], expected, atol=0.01 * THREE.length)


@each_arm
def test_actions_mean_what_is_written(arm):
    """Each muscle has the range of its group; the engine takes no less and no more."""
    count = len(arm.sections)
    for mode in MODES:
        actions = Actions(arm, mode)
        most = np.broadcast_to(actions.middle + actions.half, actions.size)
        if mode == "bend":
            np.testing.assert_allclose(most, np.radians(170))
        for group, own in zip(arm.groups, muscles.slices(arm), strict=True):
            if mode == "lengths":
                half_turns = np.pi * group.routing.radius * (group.section - group.first + 1)
                np.testing.assert_allclose(most[own], min(group.setpoint_range[1], half_turns))
            if mode == "pressures":
                np.testing.assert_allclose(most[own], group.law.max_pressure)
            if mode == "tensions":
                assert (most[own] > 0).all()
                assert (most[own] <= group.law.blocked_force).all()
        value = np.full((1, actions.size), 0.3)
        np.testing.assert_allclose(actions.asking(actions.middle + actions.half * value), value, atol=1e-12)
        assert actions.controls(value).shape == (1, actions.size if mode != "bend" else muscles.count(arm)) or (
            mode == "pressures" and actions.controls(value).shape == (1, 2 * actions.size)
        )
    bends = Actions(arm, "bend")
    given = np.linspace(-1, 1, 2 * count)
    np.testing.assert_array_equal(bends.check(given.reshape(count, 2)), bends.check(given))
    np.testing.assert_array_equal(bends.check(given.reshape(1, count, 2), 1), bends.check(given))


@each_task
@pytest.mark.parametrize("variations", [None, VARIATIONS], ids=["plain", "varied"])
@pytest.mark.parametrize("arm", [TWO, THREE], ids=["two", "three"])
def test_a_vector_is_the_same_bits_as_single_arms(task, variations, arm):
    given = {"variations": variations, "time_limit": 0.2, "arm": arm}
    many, rng = vector(3, task, threads=2, **given), np.random.default_rng(1)
    alone = [ArmEnv(task, **given) for _ in range(3)]
    observation, _ = many.reset(seed=4)
    for i, env in enumerate(alone):
        np.testing.assert_array_equal(env.reset(seed=4 + i)[0], observation[i])
    for _ in range(4):
        action = rng.uniform(-1, 1, many.action_space.shape)
        observation, reward, *_ = many.step(action)
        for i, env in enumerate(alone):
            found = env.step(action[i])
            np.testing.assert_array_equal(found[0], observation[i])
            assert found[1] == reward[i]


@pytest.mark.parametrize("mode", MODES)
def test_targets_are_in_the_volume_that_the_muscles_hold(mode):
    """Every target has bends that are held, and they fill a volume: no surface holds them."""
    task, random = define("reach", TWO, mode).task, np.random.RandomState(0)
    targets = np.array([task.draw(random)["target"] for _ in range(40)])
    bends = nearest_bends(targets, np.zeros((40, 4)), task.actions)
    assert np.linalg.norm(shape.chain_tip(bends, TWO) - targets, axis=1).max() < 1e-6
    held = task.actions.hold(bends)
    assert held.sum() >= 39  # drawn at the edge of what is held, one may not be found
    if mode == "pressures":
        np.testing.assert_array_equal(pressure_needed(bends, TWO)[0] <= McKibben().max_pressure * (1 + 1e-9), held)
    radii = np.linalg.norm(targets, axis=1)
    assert np.ptp(radii[targets[:, 2] > 0.15]) > 0.1 * TWO.length


def test_paths_are_smooth_closed_and_held():
    task, random = define("track", THREE).task, np.random.RandomState(0)
    for _ in range(5):
        path = task.prepare(task.draw(random), THREE)["path"]
        assert path.shape == (206, 3)
        np.testing.assert_allclose(path[0], path[200], atol=1e-12)
        assert (path[200:] == path[200]).all()
        turn = np.linalg.norm(np.diff(path[:201], 2, axis=0), axis=1)
        assert turn.max() < 0.01 * THREE.length
    ellipses, share = draw_ellipses(random, 3), np.linspace(0, 1, 201)
    bends = around(2.0, ellipses, share, 3).reshape(-1, 3, 2)
    angles = np.linalg.norm(bends, axis=-1)
    assert angles.max() <= 2.0 + 1e-12
    np.testing.assert_allclose(angles.max(axis=0), 2.0, atol=2e-3)  # an ellipse's long half axis
    np.testing.assert_allclose(angles.min(axis=0), 2.0 * np.abs(2 * ellipses[:, 0] - 1), atol=0.05)


def test_loaded_targets_are_where_the_arm_rests():
    """Against the equilibrium under the same bends, and back."""
    arm = replace(TWO, gravity=(2.0, 0.0, 9.0), payload=0.02)
    resting, bend = define("reach", arm).task.resting, np.array([[0.6, 0.3, -0.5, 0.4]])
    polar = [value for own in bend.reshape(2, 2) for value in (np.hypot(*own), np.arctan2(own[1], own[0]))]
    rested = equilibrium(arm, Load(muscles=Muscles(kind="bend", values=tuple(polar))))
    tip = resting.tips(bend)
    np.testing.assert_allclose(tip[0], rested.tip, atol=1e-6)
    found = resting.bends(tip, np.zeros((1, 4)))
    np.testing.assert_allclose(resting.tips(found), tip, atol=1e-3 * arm.length)


@pytest.mark.parametrize("arm", [TWO, THREE], ids=["two", "three"])
def test_the_baseline_solves_what_chance_does_not(arm):
    for task, seeds, least in (("reach", 10, 9), ("track", 2, 1)):
        definition = define(task, arm)
        found, chance = (score(definition, make(definition), seeds) for make in (baseline, random_policy))
        assert found.success.sum() >= least
        assert not chance.success.any()
        assert found.reward.min() > chance.reward.max()


def test_variations_give_the_model_of_the_varied_arm():
    env = ArmEnv("reach", TWO, variations={**VARIATIONS, "gravity": [0.0, 1.0, 9.0], "section_1.mass": 0.2})
    env.reset(seed=0)
    arm, model = env._episodes.arms[0], env._physics._model
    stiffness = arm.sections[1].bending_stiffness
    assert 0.064 <= stiffness <= 0.096
    assert arm == replace(
        TWO,
        sections=(replace(TWO.sections[0], mass=0.2), replace(TWO.sections[1], bending_stiffness=stiffness)),
        laws=(McKibben(braid_friction=0.1), TWO.laws[1]),
        world=replace(TWO.world, gravity=(0.0, 1.0, 9.0), payload=arm.payload),
    )
    assert model.body("payload").mass[0] == arm.payload > 0
    assert model.jnt_stiffness[-1] == pytest.approx(arm.sections[1].joint_stiffness)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"task": "hold", "arm": TWO}, "arm for hold is of 2 sections and 6 muscles; allowed: an arm of one section"),
        ({"arm": TWO, "variations": {"mass": 1.0}}, "variation 'mass' is unknown; allowed: target, payload, gravity"),
        ({"arm": TWO, "variations": {"section_3.mass": 1.0}}, "variation 'section_3.mass' is unknown"),
        ({"arm": replace(TWO, routings=(Routing(), Routing(count=2)))}, "muscle.count is 2 in section 2"),
    ],
)
def test_what_cannot_be_made_is_said_in_one_line(given, said):
    with pytest.raises(InputError) as caught:
        ArmEnv(**given)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bad_values_are_refused():
    ellipses = [[0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]
    for variations, said in (
        ({"max_bend": 4.0}, "max_bend is 4"),
        ({"max_bend": "x"}, "max_bend"),
        ({"ellipses": [[0.5, 0.0, 0.0]]}, "ellipses"),
        ({"ellipses": [[1.5, 0.0, 0.0], [0.5, 0.0, 0.0]]}, "ellipses"),
        ({"section_2.mass": -1.0}, "mass is -1"),
    ):
        with pytest.raises(InputError, match=said):
            ArmEnv("track", TWO, variations=variations).reset(seed=0)
    env = ArmEnv("track", TWO, variations={"max_bend": 1.0, "ellipses": ellipses})
    env.reset(seed=0)
    for action in (np.zeros(2), np.zeros((2, 3)), [np.nan] * 4):
        with pytest.raises(InputError, match="action"):
            env.step(action)


def test_random_steps_stay_inside_their_spaces():
    """Over arms, tasks and modes; a warning is an error here."""
    for number, (arm, mode) in enumerate((arm, mode) for arm in ARMS.values() for mode in MODES):
        for task in TASKS:
            envs, rng = vector(3, task, arm, actions=mode), np.random.default_rng(number)
            observation, _ = envs.reset(seed=number)
            for _ in range(8):
                observation, reward, *_ = envs.step(rng.uniform(-1, 1, envs.action_space.shape))
                assert envs.observation_space.contains(observation)
                assert ((reward >= 0) & (reward <= 1)).all()
            assert np.abs(observation).max() < LIMIT


@pytest.mark.parametrize(("name", "arm"), [("reach", TWO), ("track", THREE), ("reach", ODD)])
def test_dm_control_gives_the_same_trajectory(name, arm):
    pytest.importorskip("dm_control", reason="dm-control cannot be installed on Python 3.13")
    from contarm_sim.envs import dm

    arm, variations = replace(arm, gravity=(0.0, 0.0, 9.81)), {"section_2.mass": 0.11}
    given = {"arm": arm, "variations": variations, "time_limit": 0.3, "actions": "pressures"}
    env, other, rng = dm.load(name, random=5, **given), ArmEnv(name, **given), np.random.default_rng(0)
    names = env.action_spec().name.split("\t")
    assert names == action_names(arm, "pressures")
    step, observation = env.reset(), other.reset(seed=5)[0]
    while True:
        seen = {key.split("/")[-1]: np.asarray(value)[None] for key, value in step.observation.items()}
        np.testing.assert_allclose(other.definition.flat(seen)[0], observation, rtol=0, atol=1e-12)
        if step.last():
            break
        action = rng.uniform(-1, 1, env.action_spec().shape)
        step, (observation, reward, *_) = env.step(action), other.step(action)
        assert step.reward == pytest.approx(reward, abs=1e-12)


@pytest.mark.gl
def test_pictures_show_the_arm_and_the_target():
    from contarm_sim.errors import RenderingError
    from contarm_sim.view.rendering.gl import choose_backend

    try:
        choose_backend()
    except RenderingError:
        pytest.skip("no GL library here")
    env = ArmEnv("reach", THREE, render_mode="rgb_array")
    env.reset(seed=0)
    one = env.render()
    env.reset()
    two = env.render()
    assert 20 < (one != two).any(axis=2).sum() < 20_000
    env.close()


def test_contarm_envs_lists_what_an_arm_of_two_sections_has(contarm, tmp_path):
    (tmp_path / "two.toml").write_text(arm_to_toml(TWO))
    code, out, err = contarm("envs", "--no-scores", "--arm", "two.toml")
    assert (code, err) == (0, "")
    assert "hold needs an arm of one section with three pneumatic muscles" in out
    found = json.loads(contarm("envs", "--seeds", 1, "--json", "--arm", "two.toml")[1])
    assert [row["task"] for row in found["tasks"]] == ["reach", "track"]
    assert found["tasks"][0]["action_size"] == 4
    assert found["tasks"][0]["observation"]["section_ends"] == 3
    assert "hold" in found["left_out"]
    assert found["tasks"][0]["scores"]["baseline"]["solved"] == 1
