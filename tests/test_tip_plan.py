"""The plan of the tip's motion, and what motion adds: against the engine itself, left to run."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from references import moving, resting

from contarm_sim.control.tip import plan_motion, plan_rest
from contarm_sim.control.tip_plan import TipPlan
from contarm_sim.control.tip_plan_many import Asked, solve_many
from contarm_sim.engine.plant import Plant
from contarm_sim.kinematics import arc
from contarm_sim.mechanics.muscles import count
from contarm_sim.model.arm import Arm
from contarm_sim.model.presets import two
from contarm_sim.motion.lag import moved_by_motion
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import ACCURATE, simulate

HANGING = Arm(gravity=(0.0, 0.0, 9.81), payload=0.05, links=12)


TWO = Arm(sections=tuple(replace(section, links=6) for section in two().sections))


@pytest.mark.parametrize("arm", [HANGING, TWO, Arm(links=6, path="spans")], ids=["one", "two", "spans"])
def test_many_samples_have_the_bits_of_each_alone(arm):
    """Those that cannot be held, or take damped steps, are left to one alone, which says why."""
    rng, sections = np.random.default_rng(3), len(arm.sections)
    bend = rng.uniform(-0.5, 0.5, (9, 2 * sections))
    bend[4] *= 5
    alone, plant = TipPlan(arm), Plant(arm)
    qpos, target = [], []
    for one in bend:
        plant.reset(one)
        qpos.append(plant.data.qpos.copy())
        mujoco.mj_kinematics(plant.model, plant.data)
        target.append(plant.tip + 0.01 * arm.length)
    forces, least = rng.uniform(-1e-3, 1e-3, np.shape(qpos)), np.full((9, count(arm)), 12.0)
    asked = Asked(np.array(qpos), bend, np.array(target), forces, least, checked=True)
    found = solve_many(arm, asked)
    assert len(found) > 5
    for i, (setpoint, lengths, slope, q) in found.items():
        alone.plant.data.qpos[:] = qpos[i]
        expected = alone.solve(bend[i], target[i], forces[i], least[i])
        for mine, theirs in zip((setpoint, slope), expected, strict=True):
            np.testing.assert_array_equal(mine, theirs)
        np.testing.assert_array_equal(lengths, alone.plant.muscle_lengths)
        np.testing.assert_array_equal(q, alone.plant.data.qpos)


def _swung(duration, rate=100.0):
    """Return bends that rise smoothly from rest and turn, shape (T, 2)."""
    time = np.arange(0, duration + 0.5 / rate, 1 / rate)
    return arc.from_polar(1.2 * np.sin(np.pi * time / duration / 2) ** 2, 0.3 + time / duration)


def _played(arm, commands, period):
    """Step the bare engine through planned set-points, no feedback; return the tips [m], shape (T, 3)."""
    plant, tips = Plant(arm), []
    plant.model.opt.timestep = 0.001
    start = poses_at_rest(arm, resting(arm, np.zeros((1, 2))), "tip")
    plant.data.qpos[:] = start.qpos[0]
    for setpoint in commands.setpoint:
        plant.data.ctrl[:] = setpoint
        mujoco.mj_kinematics(plant.model, plant.data)
        tips.append(plant.tip.copy())
        mujoco.mj_step(plant.model, plant.data, round(period / 0.001))
    return np.array(tips)


def test_set_points_planned_for_motion_bring_the_tip_nearer_than_those_of_rest():
    """Without any feedback, inertia and damping foreseen: the distance to the resting tip falls at least twofold."""
    arm, bend = HANGING, _swung(1.0)
    reference = moving(arm, bend)
    rest = plan_rest(arm, bend, reference.target)
    aim = poses_at_rest(arm, reference, "tip").tip  # as near to the targets as lengths can bring a resting tip
    planned, unplanned = (_played(arm, commands, 0.01) for commands in (plan_motion(arm, reference), rest))
    off = [np.sqrt(np.mean(np.sum((tips - aim) ** 2, axis=1))) for tips in (planned, unplanned)]
    assert off[0] < off[1] / 2
    assert off[0] < 0.01 * arm.length


def test_a_motion_slow_enough_is_planned_as_poses_at_rest():
    bend = _swung(0.5)
    slow, rest = moving(HANGING, bend, rate=0.5), plan_rest(HANGING, bend, arc.position(bend, HANGING.length))
    plan = plan_motion(HANGING, slow)
    np.testing.assert_allclose(plan.lengths, rest.lengths, atol=2e-5)
    np.testing.assert_allclose(plan.setpoint, rest.setpoint, atol=2e-5)


def test_a_motion_of_a_few_samples_is_planned_as_poses_at_rest():
    bend = _swung(0.02)
    plan, rest = plan_motion(HANGING, moving(HANGING, bend)), plan_rest(HANGING, bend, arc.position(bend, 0.37))
    np.testing.assert_array_equal(plan.setpoint, rest.setpoint)


def test_what_motion_adds_goes_when_the_arm_has_come_to_rest():
    """Half the motion, half a wait: the part is the distance to where the arm ends up, and ends up at nothing."""
    bend = np.concatenate([_swung(0.4), np.repeat(_swung(0.4)[-1:], 400, axis=0)])
    run = simulate(HANGING, moving(HANGING, bend), stepping=ACCURATE)
    time, moved = moved_by_motion(run, poses=440)
    added = np.linalg.norm(moved, axis=1)
    np.testing.assert_array_equal(time, run.time)
    assert added[:60].max() > 0.02 * HANGING.length
    assert added[-1] < 1e-5
    still = slice(60, None)  # commanded to stand: where it would rest is where it comes to rest
    expected = np.linalg.norm(run.tip[still] - run.tip[-1], axis=1)
    np.testing.assert_allclose(added[still], expected, atol=2e-5)


@pytest.mark.parametrize("poses", [1, 7, 100])
def test_what_motion_adds_is_found_at_about_so_many_poses(poses):
    run = simulate(HANGING, moving(HANGING, _swung(0.4)), stepping=ACCURATE)
    time, moved = moved_by_motion(run, poses)
    assert moved.shape == (len(time), 3)
    assert min(poses, len(run)) <= len(time) <= max(2 * poses, poses + 1)


def test_what_motion_adds_to_an_extrapolated_run_is_of_infinitely_many_links():
    """Two chains of 16 and 8 links say nearly what one of 48 says."""
    bend = _swung(0.4)
    found = []
    for links, extrapolate in ((16, True), (16, False), (48, False)):
        arm = replace(HANGING, links=links)
        run = simulate(arm, moving(arm, bend), stepping=ACCURATE, extrapolate=extrapolate)
        found.append(np.linalg.norm(moved_by_motion(run, 10)[1], axis=1))
    assert np.abs(found[0] - found[2]).max() < 0.5 * np.abs(found[1] - found[2]).max()
