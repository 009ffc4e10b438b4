"""The environment `grasp`, and objects in the other ones: bits, forces, what is drawn, lost and refused."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from contarm_sim.demos.grasp_script import grasp_arm  # noqa: E402
from contarm_sim.envs.baseline import baseline  # noqa: E402
from contarm_sim.envs.definition import define  # noqa: E402
from contarm_sim.envs.grasp import HELD, LIFT, SMALLER, SPREAD  # noqa: E402
from contarm_sim.envs.gym import ArmEnv  # noqa: E402
from contarm_sim.envs.scores import score  # noqa: E402
from contarm_sim.envs.task import CONTROL_PERIOD  # noqa: E402
from contarm_sim.envs.vector import ArmVectorEnv  # noqa: E402
from contarm_sim.errors import InputError  # noqa: E402
from contarm_sim.model.arm import Arm  # noqa: E402
from contarm_sim.model.objects import Object  # noqa: E402
from contarm_sim.model.world import World  # noqa: E402

ARM = grasp_arm()
LOG = next(each for each in ARM.world.objects if each.free)
DROPPED = {"object_size": 0.3, "object_offset": [0.0, 0.0, 0.0]}  # so thin that it falls deep into its forks
POST = Object(name="post", shape="cylinder", radius=0.01, length=0.4, axis=(0, 1, 0), position=(0.08, 0, 0.25))
BESIDE = Arm(links=8, world=World(objects=(POST,)))
INSIDE = Arm(links=8, world=World(objects=(replace(POST, position=(0, 0, 0.25)),)))


def forces(seen, place=0):
    """Return the sum of what all sections feel of one partner."""
    return seen["touch_forces"][0].reshape(-1, 2, 3)[place].sum(axis=0)


GRIPPED = 95  # actions until the object is held


@pytest.fixture(scope="module")
def lifted():
    """An episode of the baseline; until the object is held, of the second of two arms side by side, too."""
    one, two = ArmEnv("grasp"), ArmVectorEnv(2, task="grasp", threads=2)
    alone, (many, _) = one.reset(seed=4)[0], two.reset(seed=3)
    policy, told, same = baseline(one.definition), [], [np.array_equal(alone, many[1])]
    for tick in range(one.definition.ticks):
        action = policy(many) if tick < GRIPPED else policy(np.stack([alone, alone]))
        alone, reward, lost, cut, info = one.step(action[1])
        told.append((reward, lost, cut, info["success"], one.definition.unflat(alone[None])))
        if tick >= GRIPPED:
            continue
        many, rewards, losts, cuts, infos = two.step(action)
        same.append(np.array_equal(alone, many[1]) and (reward, lost, cut) == (rewards[1], losts[1], cuts[1]))
        same.append(info["error"] == infos["error"][1] and info["success"] == infos["success"][1])
    return SimpleNamespace(env=one, same=same, told=told, rewards=np.array([each[0] for each in told]))


def test_a_vector_is_the_same_bits_as_one_arm_until_it_grips(lifted):
    assert len(lifted.same) == 1 + 2 * GRIPPED
    assert all(lifted.same)
    assert lifted.told[GRIPPED - 1][-1]["touching"][0, :2].sum() >= 3


def test_the_baseline_lifts_and_holds(lifted):
    *_, lost, cut, success, seen = lifted.told[-1]
    assert (lost, cut, success) == (False, True, True)
    assert (lifted.rewards >= 0).all()
    assert (lifted.rewards <= 1).all()
    assert lifted.rewards[-1] > 2 * lifted.rewards[0]
    rises = np.array([each[-1]["rise"][0, 0] for each in lifted.told])
    first = np.flatnonzero(rises >= LIFT)[0]
    successes = [each[3] for each in lifted.told]
    assert successes.index(True) == first + round(HELD / CONTROL_PERIOD) - 1  # a second later, this tick included
    np.testing.assert_allclose(
        seen["rise"][0, 0], LOG.position[2] + _offset(lifted.env)[2] - seen["object_positions"][0, 2]
    )


def _offset(env):
    return env._episodes.goals["start"][0] - LOG.position


def test_what_is_felt_of_the_lifted_object_is_its_weight(lifted):
    """At rest, off its forks: gravity pulls at the object along +Z, and so does the object at the arm."""
    seen = lifted.told[-1][-1]
    drawn = next(each for each in lifted.env._episodes.arms[0].world.objects if each.free)
    np.testing.assert_allclose(forces(seen), [0, 0, 9.81 * drawn.mass], atol=0.02 * 9.81 * drawn.mass)
    assert seen["touching"][0, :2].sum() >= 3
    assert not seen["touching"][0, 2:].any()
    assert np.abs(seen["object_velocities"]).max() < 1e-3


def test_the_engine_has_what_was_drawn():
    env, found = ArmEnv("grasp"), []
    for seed in range(8):
        env.reset(seed=seed)
        drawn = next(each for each in env._episodes.arms[0].world.objects if each.free)
        model, geom = env._physics._model, env._physics._model.geom("log")
        assert model.body("log").mass[0] == drawn.mass
        assert (geom.friction[0], geom.size[0]) == (drawn.friction, drawn.radius)
        np.testing.assert_array_equal(env._physics.data.body("log").xpos, drawn.position)
        found.append((drawn.mass / LOG.mass, drawn.friction / LOG.friction, drawn.radius / LOG.radius, *_offset(env)))
    mass, friction, size, *offset = np.array(found).T
    for value, low, high in (
        (mass, 1 - SPREAD, 1 + SPREAD),
        (friction, 1 - SPREAD, 1 + SPREAD),
        (size, 1 - SMALLER, 1),
    ):
        assert (value > low).all()
        assert (value < high).all()
        assert np.ptp(value) > 0.5 * (high - low)
    assert 0.5 * SPREAD * LOG.radius < np.abs(offset).max() < SPREAD * LOG.radius
    env.reset(seed=3)
    again = next(each for each in env._episodes.arms[0].world.objects if each.free)
    assert again.mass == pytest.approx(mass[3] * LOG.mass, rel=1e-12)


def test_pictures_show_the_object_where_it_is():
    """Pixels of its colour move with it to where it lies in this episode."""
    places = iter((0.0, 0.06))
    offset = {"object_offset": lambda *_: [next(places), 0.0, 0.0]}
    env = ArmEnv("grasp", variations=offset, render_mode="rgb_array", width=160, height=120)
    middles = []
    for _ in range(2):
        env.reset(seed=0)
        red, green, blue = np.moveaxis(env.render().astype(int), -1, 0)
        wood = (red > 2 * blue) & (green > 1.2 * blue)
        assert wood.sum() > 20
        middles.append(np.nonzero(wood)[1].mean())
    env.close()
    assert abs(middles[0] - middles[1]) > 5


def test_a_lost_object_ends_its_own_episode_alone():
    """As terminated, not truncated; the next step begins another, and the others go on."""
    sizes = iter((1.0, 0.3, 1.0))
    variations = {"object_size": lambda *_: next(sizes), "object_offset": [0.0, 0.0, 0.0]}
    envs = ArmVectorEnv(2, task="grasp", threads=1, variations=variations)
    observation, _ = envs.reset(seed=0)
    policy = baseline(envs.definition)
    lost, ticks = np.zeros(2, dtype=bool), 0
    while not lost.any() and ticks < 60:
        observation, reward, lost, cut, info = envs.step(policy(observation))
        ticks += 1
        assert not cut.any()
    assert lost.tolist() == [False, True]
    assert not info["success"].any()
    observation, reward, lost, cut, _ = envs.step(policy(observation))
    assert not (lost | cut).any()
    assert reward[1] == 0.0
    np.testing.assert_allclose(envs.definition.unflat(observation)["time"][:, 0], [CONTROL_PERIOD * (ticks + 1), 0.0])


def test_scores_count_a_lost_object_once():
    definition = replace(define("grasp", variations=DROPPED), ticks=6)
    found = score(definition, baseline(definition), 2)
    assert not found.success.any()
    assert (found.error > LIFT).all()
    env = ArmEnv("grasp", variations=DROPPED, time_limit=0.3)
    observation, rewards, lost = env.reset(seed=0)[0], [], False
    while not lost:
        observation, reward, lost, _, _ = env.step(baseline(definition)(observation[None])[0])
        rewards.append(reward)
    assert len(rewards) < 6
    assert found.reward[0] == pytest.approx(sum(rewards) / 6, rel=1e-12)


def test_gymnasiums_own_checker_is_content():
    env = gymnasium.make("contarm/Grasp-v0", disable_env_checker=True, time_limit=0.2)
    check_env(env.unwrapped, skip_render_check=True)


def test_dm_control_has_the_same_numbers():
    dm = pytest.importorskip("contarm_sim.envs.dm", reason="dm-control cannot be installed on Python 3.13")
    given = {"variations": DROPPED}
    env, other = dm.load("grasp", random=5, **given), ArmEnv("grasp", **given)
    step, (observation, _), lost = env.reset(), other.reset(seed=5), False
    action = np.zeros(6)
    while not lost:
        seen = {key.split("/")[-1]: np.asarray(value)[None] for key, value in step.observation.items()}
        np.testing.assert_allclose(other.definition.flat(seen)[0], observation, rtol=0, atol=1e-4)
        step, (observation, reward, lost, _, _) = env.step(action), other.step(action)
        assert step.reward == pytest.approx(reward, abs=1e-4)
        assert (step.last(), step.discount) == (lost, 0.0 if lost else 1.0)


def test_an_arm_reaches_among_objects_and_may_feel_them():
    """The post is in the way; what is seen of it is asked for."""
    action, found = np.array([0.6, 0.0]), {}
    for name, arm, contact in (("free", BESIDE.alone, None), ("blind", BESIDE, None), ("feeling", BESIDE, True)):
        env = ArmEnv("reach", arm, contact=contact)
        env.reset(seed=0)
        for _ in range(30):
            observation = env.step(action)[0]
        found[name] = env.definition.unflat(observation[None])
    assert found["blind"].keys() == found["free"].keys()
    assert found["feeling"].keys() - found["free"].keys() == {"touching", "touch_forces"}
    np.testing.assert_array_equal(found["feeling"]["tip_position"], found["blind"]["tip_position"])
    assert np.linalg.norm(found["free"]["tip_position"] - found["blind"]["tip_position"]) > 0.02
    assert found["feeling"]["touching"][0, 0] >= 1
    assert found["feeling"]["touch_forces"][0, 0] < -0.5  # pushed back
    envs = ArmVectorEnv(2, task="reach", arm=BESIDE, contact=True)
    envs.reset(seed=[0, 0])
    for _ in range(30):
        many = envs.step(np.tile(action, (2, 1)))[0]
    np.testing.assert_array_equal(many[1], observation)


def test_targets_are_drawn_where_the_arm_has_room(monkeypatch):
    """None in or behind a wall, where a third would be; the ceiling that the arm hangs from is in no target's way."""
    wall = Object(name="wall", shape="box", size=(0.02, 1, 1), position=(0.12, 0, 0.3))
    ceiling = Object(name="ceiling", shape="plane", position=(0, 0, -0.001))

    def drawn(*objects):
        task = define("reach", Arm(links=4, world=World(objects=objects))).task
        return np.array([task.draw(np.random.RandomState(seed))["target"] for seed in range(40)])

    free, walled, limit = drawn(), drawn(wall, ceiling), 0.11 - Arm().contact_radii[-1]
    assert 5 < (free[:, 0] > limit).sum() < 25
    assert (walled[:, 0] < limit).all()
    clear = free[:, 0] < 0.05
    assert (walled == free).all(axis=1)[clear].sum() > 0.5 * clear.sum()
    monkeypatch.setattr("contarm_sim.envs.reach.DRAWS", 20)
    with pytest.raises(InputError, match="leave the arm room"):
        drawn(replace(wall, position=(0, 0, 0.2), size=(1, 1, 0.1)))


@pytest.mark.parametrize(
    ("given", "message"),
    [({"task": "grasp", "arm": "two"}, "one free object"),
     ({"task": "reach", "contact": True}, "whose world has objects"),
     ({"task": "grasp", "contact": False}, "contact"), ({"task": "grasp", "actions": "pressures"}, "lengths for grasp"),
     ({"task": "grasp", "variations": {"object_masss": 1.0}}, "object_mass, object_friction"),
     ({"task": "reach", "arm": INSIDE}, "mm deep in link_.* where the episode starts")],
)  # fmt: skip
def test_what_cannot_be_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        ArmEnv(**given)


@pytest.mark.parametrize(
    ("name", "value"), [("object_offset", [0.0, 9.0, 0.0]), ("object_mass", -1.0), ("object_size", 0.0)]
)
def test_a_variation_that_cannot_be_is_refused_at_reset(name, value):
    with pytest.raises(InputError, match=r"object_offset|mass|radius"):
        ArmEnv("grasp", variations={name: value}).reset(seed=0)


@pytest.mark.slow
def test_the_baseline_lifts_in_all_of_20_seeds():
    definition = define("grasp")
    found = score(definition, baseline(definition), 20)
    assert found.success.all()
    assert not found.error.any()
