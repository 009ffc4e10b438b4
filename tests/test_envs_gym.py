"""The Gymnasium tasks: their contract, bits that agree alone and in batches, variations, mistakes in one clear line."""

import copy
import pickle
import shutil
import subprocess
import sys
from itertools import count

import numpy as np
import pytest
from waiting import PATIENCE

gymnasium = pytest.importorskip("gymnasium")

from dataclasses import replace  # noqa: E402

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode  # noqa: E402

from contarm_sim.envs.actions import MODES, Actions  # noqa: E402
from contarm_sim.envs.baseline import baseline  # noqa: E402
from contarm_sim.envs.definition import TASKS, define, plain_spec  # noqa: E402
from contarm_sim.envs.gym import ArmEnv  # noqa: E402
from contarm_sim.envs.registration import NAMES  # noqa: E402
from contarm_sim.envs.scores import score  # noqa: E402
from contarm_sim.envs.task import LIMIT  # noqa: E402
from contarm_sim.envs.vector import ArmVectorEnv  # noqa: E402
from contarm_sim.errors import DivergenceError, InputError, RenderingError  # noqa: E402
from contarm_sim.kinematics import arc, dome, muscles  # noqa: E402
from contarm_sim.mechanics import pressures  # noqa: E402
from contarm_sim.mechanics.moments import wrench_moment  # noqa: E402
from contarm_sim.model.arm import Arm  # noqa: E402

ALONE = tuple(name for name in TASKS if name != "grasp")  # which has test_envs_grasp.py
CASES = [(task, mode) for task in ALONE for mode in TASKS[task].modes]


def make(task, **given):
    return gymnasium.make(NAMES[task], disable_env_checker=True, **given)


def vector(task, count, mode="vector_entry_point", **given):
    return gymnasium.make_vec(NAMES[task], count, vectorization_mode=mode, **given)


def uniform(payload):
    return lambda initial, current, random: random.uniform(0, payload)


VARIATIONS = {
    "payload": uniform(0.05),
    "bending_stiffness": lambda initial, current, random: initial * random.uniform(0.8, 1.2),
    "joint_friction": uniform(1e-3),
    "gravity": lambda initial, current, random: random.uniform(-3, 3, 3),
    "muscle.braid_friction": 0.2,
}


def assert_same(one, two):
    if isinstance(one, dict):
        assert one.keys() == two.keys()
        one, two = zip(*((one[key], two[key]) for key in one), strict=True)
    if isinstance(one, (tuple, list)):
        for a, b in zip(one, two, strict=True):
            assert_same(a, b)
    else:
        assert np.asarray(one).dtype == np.asarray(two).dtype
        np.testing.assert_array_equal(one, two)


@pytest.mark.parametrize(("task", "mode"), CASES)
def test_gymnasiums_own_checker_is_content(task, mode):
    check_env(make(task, actions=mode).unwrapped, skip_render_check=True)  # pictures: test_envs_pictures.py


def test_names_need_no_import_when_the_module_stands_in_front():
    code = """if True:
        import gymnasium
        env = gymnasium.make("contarm_sim.envs.gym:contarm/Reach-v0")
        print(env.spec.id, env.reset(seed=0)[0].shape)"""
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "contarm/Reach-v0 (70,)\n"


def test_the_entry_point_is_declared():
    from importlib.metadata import entry_points

    from contarm_sim.envs.registration import register

    assert [point.load() for point in entry_points(group="gymnasium.envs") if point.name == "contarm"] == [register]


@pytest.mark.parametrize("task", ALONE)
@pytest.mark.parametrize("variations", [None, VARIATIONS], ids=["plain", "varied"])
def test_a_vector_is_the_same_bits_as_a_loop_over_several_episodes(task, variations):
    """Of any size and thread count, autoresets and infos included; one arm alone, too."""
    count, rng = 4, np.random.default_rng(1)
    given = {"time_limit": 0.4, "variations": variations, "reward": "shaped"}
    loop, native = vector(task, count, "sync", **given), vector(task, count, threads=3, **given)
    alone = vector(task, 1, threads=1, **given)
    assert native.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert native.single_observation_space == loop.single_observation_space
    first = native.reset(seed=5)
    assert_same(first, loop.reset(seed=5))
    assert_same(alone.reset(seed=7)[0][0], first[0][2])
    for _ in range(20):
        action = rng.uniform(-1.2, 1.2, native.action_space.shape)
        found = native.step(action)
        assert_same(found, loop.step(action))
        assert_same(alone.step(action[2:3])[0][0], found[0][2])


@pytest.mark.parametrize("task", ALONE)
def test_a_copy_goes_on_by_itself_as_the_original_would(task):
    env = make(task).unwrapped
    env.reset(seed=0)
    action = np.full(env.action_space.shape, 0.4)
    env.step(action)
    copies = copy.deepcopy(env), pickle.loads(pickle.dumps(env))
    found = [[one.step(action)[0] for _ in range(5)] for one in (env, *copies)]
    np.testing.assert_array_equal(found[0], found[1])
    np.testing.assert_array_equal(found[0], found[2])
    assert not np.array_equal(found[0][0], found[0][-1])


def test_the_spec_says_how_long_an_episode_is():
    assert make("reach").spec.max_episode_steps == 40
    assert make("track", time_limit=2.0).spec.max_episode_steps == 40
    assert vector("hold", 2, max_episode_steps=7).definition.ticks == 7
    gymnasium.wrappers.TimeAwareObservation(make("reach")).reset()


@pytest.mark.parametrize(
    ("arm", "mode"), [(Arm(), "pressures"), (Arm(length=0.15), "bend"), (Arm(length=0.1), "lengths")]
)
def test_targets_are_those_that_the_muscles_can_hold(arm, mode):
    """Also where 170 deg takes more pressure than there is, or set-points that the servos do not have."""
    task, random = define("reach", arm, mode).task, np.random.RandomState(0)
    bends = np.array([dome.bend_from_tip(task.draw(random)["target"], arm.length).bend for _ in range(50)])
    angles = np.hypot(*bends.T)
    assert np.radians(30) < angles.max() < np.radians(160)
    if mode == "pressures":
        assert (pressures.pressure_needed(bends, arm)[0] <= arm.muscle.max_pressure * (1 + 1e-9)).all()
    else:
        limits = plain_spec(arm, "lengths", 0.005).compile().actuator_ctrlrange[0]
        setpoints = task.actions.setpoints(bends)
        assert (setpoints >= limits[0] - 1e-9).all()
        assert (setpoints <= limits[1] + 1e-9).all()


def test_part_of_a_vector_can_be_reset():
    native = vector("reach", 3)
    loop = gymnasium.vector.SyncVectorEnv([lambda: make("reach")] * 3)
    mask = np.array([True, False, True])
    with pytest.raises(InputError, match="reset all arms first"):
        native.reset(options={"reset_mask": mask})
    for envs in (native, loop):
        envs.reset(seed=1)
        envs.step(np.full((3, 2), 0.5))
    assert_same(native.reset(seed=9, options={"reset_mask": mask}), loop.reset(seed=9, options={"reset_mask": mask}))
    assert_same(native.step(np.full((3, 2), -0.5)), loop.step(np.full((3, 2), -0.5)))


def test_a_seed_gives_the_same_episodes_and_another_others():
    def rollout(seed):
        env, seen = make("track", variations=VARIATIONS, time_limit=0.2), []
        seen.append(env.reset(seed=seed)[0])
        for _ in range(4):
            seen.append(env.step(np.array([0.3, -0.2]))[0])
        seen.append(env.reset()[0])  # the next episode of the same seed
        return np.array(seen)

    np.testing.assert_array_equal(rollout(3), rollout(3))
    assert not np.array_equal(rollout(3)[0], rollout(4)[0])
    assert not np.array_equal(rollout(3)[0], rollout(3)[-1])


def test_episodes_are_truncated_at_their_limit_never_terminated():
    env = make("reach")
    env.reset(seed=0)
    flags = [env.step(np.zeros(2))[2:4] for _ in range(40)]
    assert flags == [(False, False)] * 39 + [(False, True)]
    with pytest.raises(InputError, match="step is after the end of its episode; allowed: reset"):
        env.step(np.zeros(2))


def test_observations_are_the_callers():
    env = make("reach")
    one, _ = env.reset(seed=0)
    kept = one.copy()
    two = env.step(np.array([1.0, 0.0]))[0]
    np.testing.assert_array_equal(one, kept)
    two[:] = 99
    assert np.abs(env.step(np.array([1.0, 0.0]))[0]).max() < 5


@pytest.mark.parametrize("task", ALONE)
def test_the_flat_observation_is_what_the_engine_says(task):
    env = make(task)
    env.reset(seed=2)
    for _ in range(5):
        observation, reward, _, _, info = env.step(env.action_space.sample() * 0 + 0.4)
    definition, data = env.unwrapped.definition, env.unwrapped._physics.data
    seen = definition.unflat(observation)
    assert list(seen) == list(definition.sizes)
    np.testing.assert_allclose(seen["tip_position"], data.body("tip").xpos, atol=1e-12)
    np.testing.assert_allclose(seen["tip_orientation"], data.body("tip").xquat, atol=1e-12)
    np.testing.assert_allclose(seen["muscle_lengths"], 0.37 + data.ten_length, atol=1e-12)
    np.testing.assert_allclose(seen["joint_angles"], data.qpos, atol=1e-12)
    assert (seen["actuator_tensions"] >= 0).all()
    assert seen["actuator_tensions"].any()
    if task == "hold":
        np.testing.assert_allclose(data.xfrc_applied[-1], [*seen["force"], *seen["couple"]], atol=1e-12)
        assert not env.unwrapped._physics._model.body_ipos[-1].any()  # so the force acts at the tip plate's centre
    else:
        miss = np.linalg.norm(seen["target"] - seen["tip_position"])
        assert info["error"] == pytest.approx(miss, abs=1e-12)
        assert reward == pytest.approx(0.0185 / (0.0185 + miss), abs=1e-9)


@pytest.mark.parametrize("mode", MODES)
def test_actions_mean_what_is_written(mode):
    arm = Arm()
    actions, ones = Actions(arm, mode), np.ones((1, 2 if mode == "bend" else 3))
    low, high = {
        "bend": (-np.radians(170), np.radians(170)), "lengths": (-0.018 * np.pi, 0.018 * np.pi),
        "tensions": (0, actions.middle * 2), "pressures": (90e3, 700e3),
    }[mode]  # fmt: skip
    assert (actions.middle - actions.half, actions.middle + actions.half) == pytest.approx((low, high))
    controls = actions.controls(ones)
    if mode == "bend":  # shortened to 170 deg along the diagonal
        bend = arc.from_polar(np.radians(170), np.pi / 4)
        deltas = muscles.deltas_from_bend(bend, 0.018)
        np.testing.assert_allclose(controls[0], deltas, atol=2e-3)
        assert controls[0].max() == pytest.approx(deltas.max(), abs=2e-4)  # the slackest at the least tension
        assert (controls[0] < deltas + 2e-4).all()
        np.testing.assert_array_equal(actions.controls(np.zeros((1, 2))), 0.0)  # straight, at the least tension
    else:
        np.testing.assert_allclose(controls, high)
    value = np.full((1, actions.size), 0.3)
    np.testing.assert_allclose(actions.asking(actions.middle + actions.half * value), value, atol=1e-12)


@pytest.mark.parametrize("task", ALONE)
def test_a_sparse_reward_is_success_at_this_moment(task):
    definition, rewards = define(task), []
    envs, policy = vector(task, 8, reward="sparse"), baseline(definition)
    observation, _ = envs.reset(seed=0)
    for _ in range(definition.ticks - 1):
        observation, reward, _, _, info = envs.step(policy(observation))
        near = info["success"] if task == "hold" else info["error"] <= 0.01 * definition.arm.length
        np.testing.assert_array_equal(reward, near.astype(float))
        rewards.append(reward)
    assert set(np.unique(rewards)) == {0.0, 1.0}


def test_the_moment_of_a_wrench_is_its_work():
    """Against the pose's own finite differences."""
    rng, arm, step = np.random.default_rng(0), Arm(), 1e-6
    for size in (1e-7, 0.3, 2.5):
        bend = size * arc.from_polar(1.0, rng.uniform(0, 6))
        force, couple = rng.normal(size=3), rng.normal(size=3)
        found = []
        for change in step * np.eye(2):
            one, two = arc.rotation(bend + change), arc.rotation(bend - change)
            turn = one @ two.T
            axial = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
            way = arc.position(bend + change, arm.length) - arc.position(bend - change, arm.length)
            found.append((way @ force + axial @ couple) / (2 * step))
        np.testing.assert_allclose(wrench_moment(bend, force, couple, arm), found, atol=1e-7)


def test_an_arm_that_needs_it_is_stepped_in_shorter_steps():
    env = make("reach", arm=Arm(links=8, mass=0.1, damping_time=0.001))
    definition = env.unwrapped.definition
    assert definition.timestep < 0.005
    env.reset(seed=0)
    env.step(np.ones(2))
    assert env.unwrapped._physics.data.time == pytest.approx(0.05)


def test_variations_give_the_model_of_the_varied_arm():
    env = make("reach", variations={"payload": 0.03, "bending_stiffness": uniform(0.2), "target": [0.2, 0.0, 0.25]})
    env.reset(seed=0)
    arm, model = env.unwrapped._episodes.arms[0], env.unwrapped._physics._model
    assert arm == replace(Arm(), payload=0.03, bending_stiffness=arm.bending_stiffness)
    assert model.body("payload").mass[0] == 0.03
    assert model.body("tip").mass[0] == pytest.approx(0.3 / 48)
    assert model.jnt_stiffness[0] == pytest.approx(arm.bending_stiffness / arm.link_pitch)
    stiffness = arm.bending_stiffness
    env.reset()
    assert env.unwrapped._episodes.arms[0].bending_stiffness != stiffness


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"task": "reech"}, "task is 'reech'; allowed: reach, track, hold"),
        ({"actions": "forces"}, "actions is 'forces'; allowed: bend, lengths, tensions, pressures for reach"),
        ({"task": "hold", "actions": "bend"}, "actions is 'bend'; allowed: pressures for hold"),
        ({"reward": "dense"}, "reward is 'dense'; allowed: shaped, sparse"),
        ({"variations": {"paylode": 1}}, "variation 'paylode' is unknown; allowed: target, payload, gravity, mass"),
        ({"time_limit": 0.03}, "time_limit is 0.03; allowed: a multiple of 0.05 s"),
        ({"task": "track", "time_limit": 20}, "at most 10 s"),
        ({"render_mode": "ansi"}, "render_mode is 'ansi'; allowed: rgb_array, human, None"),
        ({"arm": "big"}, "arm is 'big'; allowed: an Arm, a preset (paper, two, three, tendon), or a file"),
    ],
)
def test_what_cannot_be_made_is_said_in_one_line(given, said):
    with pytest.raises(InputError) as caught:
        ArmEnv(**given)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("action", "said"),
    [([0.0, 0.0, 0.0], "shape (3,); allowed: shape (2,)"), ([np.nan, 0.0], "finite numbers in [-1, 1]"),
     (0.0, "shape ()"), ("up", "numbers in [-1, 1]"), ([[0.0, 0.0]], "shape (1, 2)")],
)  # fmt: skip
def test_bad_actions_are_refused_and_leave_the_episode_alone(action, said):
    env = make("reach")
    with pytest.raises(InputError, match="before any reset"):
        env.unwrapped.step(np.zeros(2))
    env.reset(seed=0)
    with pytest.raises(InputError) as caught:
        env.unwrapped.step(action)
    assert said in str(caught.value)
    assert env.step(np.zeros(2))[4]["error"] > 0


def test_bad_values_of_variations_are_refused():
    for variations, said in (
        ({"payload": -1.0}, "payload is -1"),
        ({"target": [1.0, np.nan, 0.0]}, "target"),
        ({"target": [9.0, 0.0, 0.0]}, "target"),
    ):
        with pytest.raises(InputError, match=said):
            make("reach", variations=variations).reset(seed=0)


def test_a_vector_that_was_refused_can_be_closed():
    """An older Gymnasium does so when it is thrown away."""
    ArmVectorEnv.__new__(ArmVectorEnv).close_extras()


def test_a_vector_refuses_what_it_cannot_do():
    for given, said in (({"threads": -1}, "threads"), ({"render_mode": "human"}, "render_mode")):
        with pytest.raises(InputError, match=said):
            vector("reach", 2, **given)
    envs = vector("reach", 2)
    with pytest.raises(InputError, match="before any reset"):
        envs.step(np.zeros((2, 2)))
    with pytest.raises(InputError, match="3 seeds; allowed: one, or 2"):
        envs.reset(seed=[1, 2, 3])
    envs.reset(seed=0)
    with pytest.raises(InputError, match=r"shape \(2,\); allowed: shape \(2, 2\)"):
        envs.step(np.zeros(2))


def _absurd_once(place):
    """Return variations that make the arm begun as number `place` so light and undamped that no step suits it."""
    turns = {name: count() for name in ("mass", "damping_time")}
    absurd = {"mass": 1e-7, "damping_time": 0.0}
    return {
        name: lambda initial, current, random, name=name: absurd[name] if next(turns[name]) == place else initial
        for name in turns
    }


@pytest.mark.parametrize("mode", ["bend", "pressures"])
def test_an_arm_that_diverges_ends_its_own_episode_and_changes_no_bit_of_the_others(mode, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given, rng = {"actions": mode, "arm": Arm(links=8), "time_limit": 0.4}, np.random.default_rng(0)
    good, mixed = vector("reach", 9, **given), vector("reach", 9, threads=2, variations=_absurd_once(2), **given)
    alone, others, found, over = ArmEnv(variations=_absurd_once(0), **given), np.arange(9) != 2, [], False
    good.reset(seed=0)
    assert not mixed.reset(seed=0)[1]["diverged"].any()
    alone.reset(seed=2)
    for _ in range(12):  # the others' episodes end, too
        action = rng.uniform(-1, 1, mixed.action_space.shape)
        expected = good.step(action)
        found.append(mixed.step(action))
        for one, other in zip(expected[:4], found[-1][:4], strict=True):
            np.testing.assert_array_equal(one[others], other[others])
        assert mixed.observation_space.contains(found[-1][0])
        single = (alone.reset()[0], 0.0, False, False) if over else alone.step(action[2])
        for one, other in zip(single, found[-1][:4], strict=False):
            np.testing.assert_array_equal(one, other[2])
        over = single[3]
        if found[-1][4]["diverged"][2]:
            assert found[-1][1][2] == 0.0
            assert over
            assert single[4]["diverged"] is True
            assert "joint_" in str(mixed.failed[2])
    diverged = np.array([info["diverged"] for *_, info in found])
    assert diverged.sum() == diverged[:, 2].sum() == 1  # it goes on, as another arm
    errors, successes = (np.array([info[name] for *_, info in found]) for name in ("error", "success"))
    assert np.isnan(errors[diverged]).all()
    assert np.isfinite(errors[~diverged]).all()
    assert not successes[diverged].any()
    assert not mixed.failed
    assert not list(tmp_path.iterdir())  # no log of the engine


def test_scores_are_not_told_of_arms_that_diverged():
    absurd = define("reach", Arm(links=8), "bend", variations={"mass": 1e-7, "damping_time": 0.0})
    with pytest.raises(DivergenceError, match=r"joint_\d\d_[xy]"):
        score(absurd, lambda seen: np.ones((3, 2)), 3)


def test_10_000_random_steps_stay_inside_their_spaces():
    """Over all tasks and modes, with half the links; a warning is an error here."""
    random_steps(10_000, Arm(links=12))


@pytest.mark.slow
def test_a_million_random_steps_stay_inside_their_spaces():
    random_steps(1_000_000, Arm())


def random_steps(count, arm):
    steps = 0
    for number, (task, mode) in enumerate(CASES):
        envs, rng = vector(task, 64, actions=mode, arm=arm), np.random.default_rng(number)
        space = envs.observation_space
        observation, _ = envs.reset(seed=1000 * number)
        for _ in range(-(-count // (64 * len(CASES)))):
            action = rng.uniform(-1, 1, envs.action_space.shape)
            observation, reward, *_ = envs.step(action)
            assert space.contains(observation)
            assert ((reward >= 0) & (reward <= 1)).all()
            steps += 64
        assert np.abs(observation).max() < LIMIT
    assert steps >= count


@pytest.mark.gl
def test_pictures_show_arm_and_target():
    from contarm_sim.view.rendering.gl import choose_backend

    try:
        choose_backend()
    except RenderingError:
        pytest.skip("no GL library here")
    env = make("reach", render_mode="rgb_array")
    env.reset(seed=0)
    one = env.render()
    assert (one.shape, one.dtype) == ((480, 640, 3), np.uint8)
    env.reset()  # another target
    two = env.render()
    assert 20 < (one != two).any(axis=2).sum() < 20_000
    env.close()
    envs = vector("reach", 2, render_mode="rgb_array")
    envs.reset(seed=0)
    np.testing.assert_array_equal(envs.render()[0], one)
    envs.close()


@pytest.mark.gl
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="no virtual display here")
def test_a_window_opens_shows_arm_and_target_and_closes():
    code = """if True:
        import gymnasium
        env = gymnasium.make("contarm_sim.envs.gym:contarm/Reach-v0", render_mode="human")
        env.reset(seed=0)
        for _ in range(5):
            env.step([0.5, 0.5])
        viewer = env.unwrapped._picture._viewer
        print(viewer.is_running(), viewer.user_scn.ngeom)
        env.close()"""
    words = ["xvfb-run", "-a", sys.executable, "-c", code]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE)
    assert (done.returncode, done.stdout) == (0, "True 1\n"), done.stderr


def test_a_window_without_a_display_is_one_clear_line(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(RenderingError, match="no display"):
        make("reach", render_mode="human").reset(seed=0)


def test_definitions_are_sized_without_being_run():
    for task, mode in CASES:
        definition = define(task, Arm(links=6, torsional_stiffness=0.1), mode)
        env = make(task, arm=definition.arm, actions=mode)
        assert env.reset(seed=0)[0].shape == (definition.size,)


def _vector(**given):
    return ArmVectorEnv(2, **given)


_WRONG_BY_NAME = {
    "task": ([], {}, 3, "", None), "reward": ([], 1, "dense", np.zeros(2)), "actions": ([], np.zeros(3), "x", 1),
    "variations": ("x", [1], {1: 2}, 3), "time_limit": ("x", 10**400, np.nan, [], True), "render_mode": ([], 1, "x"),
    "arm": ({}, 1, "", "no.toml"), "gravity": (9.81, (0, 0), (0, 0, np.nan), "x", {}),
    "payload": (-1, "x", [], True),
    "width": (0, -1, 640.0, "x", True), "height": (0, None, [1]), "camera": ("left", None, 0, []),
}  # fmt: skip
WRONG = [{name: value} for name, values in _WRONG_BY_NAME.items() for value in values]


@pytest.mark.parametrize("make", [ArmEnv, _vector])
@pytest.mark.parametrize("given", WRONG, ids=str)
def test_wrong_arguments_are_one_kind_of_error(make, given):
    with pytest.raises(InputError):
        make(**given)


def test_wrong_seeds_and_options_are_refused_and_a_closed_vector_is_closed():
    one, many = ArmEnv(), _vector()
    for env in (one, many):
        for seed in (2**32, -1, 1.5, "x", True, [1], [1, 2**32], 10**400):
            with pytest.raises(InputError, match="seed"):
                env.reset(seed=seed)
        for options in ("text", [1], 3):
            with pytest.raises(InputError, match="options"):
                env.reset(options=options)
    for steps in ("x", 0, -1, 10**400, 1.5, True, []):
        with pytest.raises(InputError):
            _vector(max_episode_steps=steps)
    with pytest.raises(TypeError, match="cannot be pickled"):
        pickle.dumps(many)
    many.reset(seed=[0, 1])
    many.close()
    for call in (many.reset, lambda: many.step(np.zeros((2, 2)))):
        with pytest.raises(InputError, match="after close"):
            call()


@pytest.mark.parametrize(
    ("module", "missing", "extra"),
    [("gym", "gymnasium", "gym"), ("vector", "gymnasium", "gym"), ("sb3", "stable_baselines3", "train")],
)
def test_without_its_library_it_says_what_to_install(module, missing, extra):
    code = f"""if True:
        import sys
        sys.modules[{missing!r}] = None
        try:
            import contarm_sim.envs.{module}
        except ImportError as error:
            print(error)"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.endswith(f"is not installed; get it with: pip install '.[{extra}]'\n")
