"""The closed-form baseline: the dome, the loaded arm's surface, every task over seeds; what `contarm envs` says."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from contarm_sim.envs.baseline import baseline, random_policy
from contarm_sim.envs.definition import TASKS, define
from contarm_sim.envs.scores import score
from contarm_sim.envs.vector import ArmVectorEnv
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.model.arm import Arm

pytestmark = pytest.mark.slow  # by hand: all checks are to take less than ten minutes

HANGING = replace(Arm(), gravity=(0.0, 0.0, 9.81))
LENGTH = Arm().length


def tips_reached(arm, targets):
    """Return where the baseline's tips are after the 2 s of `reach`, an arm a target."""
    waiting = iter(targets)
    given = {"arm": arm, "variations": {"target": lambda initial, current, random: next(waiting)}}
    envs = ArmVectorEnv(len(targets), **given)
    policy = baseline(envs.definition)
    observation, _ = envs.reset(seed=0)
    for _ in range(envs.definition.ticks):
        observation, *_ = envs.step(policy(observation))
    return envs.definition.unflat(observation)["tip_position"]


def dome_targets(largest):
    angle, plane = np.meshgrid(np.linspace(0, largest, 6), np.radians(np.arange(0, 360, 60)))
    return arc.position(arc.from_polar(angle.ravel(), plane.ravel()), LENGTH)


def test_every_target_on_the_dome_is_reached_within_a_millimetre():
    targets = dome_targets(LARGEST_BEND)
    assert np.linalg.norm(tips_reached(Arm(), targets) - targets, axis=1).max() < 1e-3


def test_with_gravity_only_what_lies_across_the_reachable_surface_is_missed():
    """Within 1 % of length along the surface; the dome itself is farther off in places, and nothing can change that."""
    task = define("reach", HANGING).task
    targets = dome_targets(np.radians(150))
    reached = tips_reached(HANGING, targets)
    nearest = task.resting.tips(task.resting.bends(targets))
    assert np.linalg.norm(reached - nearest, axis=1).max() < 0.01 * LENGTH
    missed = np.linalg.norm(reached - targets, axis=1)
    assert 0.01 * LENGTH < missed.max() < 0.06 * LENGTH
    np.testing.assert_allclose(missed, np.linalg.norm(nearest - targets, axis=1), atol=2e-3)


@pytest.mark.parametrize("arm", [Arm(), HANGING], ids=["free", "hanging"])
def test_reach_is_solved_in_100_of_100_seeds(arm):
    definition = define("reach", arm)
    found = score(definition, baseline(definition), 100)
    assert found.success.all()
    assert found.error.max() < (1e-3 if arm == Arm() else 0.01 * LENGTH)


@pytest.mark.parametrize("task", ["track", "hold"])
def test_the_other_tasks_are_solved_and_chance_solves_none(task):
    definition = define(task)
    found, chance = (score(definition, make(definition), 12) for make in (baseline, random_policy))
    assert found.success.all()
    assert not chance.success.any()
    assert found.reward.min() > chance.reward.max()


@pytest.mark.parametrize("mode", ["lengths", "tensions", "pressures"])
def test_the_baseline_speaks_every_mode(mode):
    definition = define("reach", actions=mode)
    found = score(definition, baseline(definition), 20)
    assert np.median(found.error) < 0.01 * LENGTH


def test_tips_and_bends_at_rest_invert_each_other():
    resting = define("reach", HANGING).task.resting
    bends = arc.from_polar(np.array([0.3, 1.2, 2.4]), np.array([0.0, 2.0, 4.0]))
    np.testing.assert_allclose(resting.bends(resting.tips(bends)), bends, atol=2e-3)


def contarm(*words):
    return subprocess.run([sys.executable, "-m", "contarm_sim", "envs", *words], capture_output=True, text=True)


def test_contarm_envs_lists_and_scores():
    done = contarm("--seeds", "2", "--links", "8", "--json")
    assert done.returncode == 0, done.stderr
    tasks = {row["task"]: row for row in json.loads(done.stdout)["tasks"]}
    assert list(tasks) == [name for name in TASKS if name != "grasp"]  # whose arm has something to lift
    assert tasks["hold"]["actions"] == ["pressures"]
    assert sum(tasks["reach"]["observation"].values()) == tasks["reach"]["observation_size"] == 6 + 9 + 16 + 7
    assert tasks["reach"]["scores"]["baseline"]["reward_mean"] > tasks["reach"]["scores"]["random"]["reward_mean"]
    done = contarm("--no-scores")
    assert (done.returncode, done.stderr) == (0, "")
    assert "contarm/Track-v0" in done.stdout
    assert "contarm/Grasp-v0" in done.stdout
