"""The dm_control tasks: their contract, the entity in other arenas, and the same numbers as the Gymnasium tasks."""

import os
import shutil
import subprocess
import sys
import warnings

import numpy as np
import pytest
from waiting import PATIENCE

pytest.importorskip("dm_control", reason="dm-control cannot be installed on Python 3.13")
pytest.importorskip("gymnasium")

from dataclasses import replace

import dm_env
import mujoco

from contarm_sim.envs import dm
from contarm_sim.envs.actions import MODES
from contarm_sim.envs.definition import plain_spec
from contarm_sim.envs.dm_entity import composer
from contarm_sim.envs.gym import ArmEnv
from contarm_sim.errors import DivergenceError, InputError
from contarm_sim.model.arm import Arm

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    from dm_control import mjcf
    from dm_control.composer.variation import distributions

HANGING = replace(Arm(), gravity=(3.0, 0.0, 9.0), payload=0.02, links=12)
UNIFORM = {
    "payload": distributions.Uniform(0.0, 0.05),
    "bending_stiffness": distributions.Uniform(0.08, 0.12),
    "gravity": 9.81 * distributions.UniformPointOnSphere(single_sample=True),
    "muscle.valve_time": distributions.Uniform(0.04, 0.06),
}


SHORT = {"time_limit": 0.5}


def conforms(env, step):
    env.reward_spec().validate(step.reward if step.reward is not None else 0.0)
    assert list(step.observation) == list(env.observation_spec())
    for name, spec in env.observation_spec().items():
        spec.validate(np.asarray(step.observation[name]))
        assert np.isfinite(step.observation[name]).all()


@pytest.mark.parametrize("name", [name for name in dm.ALL if name != "grasp"])  # which has test_envs_grasp.py
def test_steps_follow_dm_envs_conventions(name):
    env = dm.load(name, random=0, time_limit=0.25)
    assert isinstance(env, dm_env.Environment)
    spec = env.action_spec()
    assert (spec.minimum, spec.maximum) == (-1, 1)
    action = np.full(spec.shape, 0.3)
    spec.validate(action)
    for episode in range(2):
        first = env.reset() if episode else env.step(action)  # the first step of all begins an episode too
        assert first.first()
        assert (first.reward, first.discount) == (None, None)
        conforms(env, first)
        steps = [env.step(action) for _ in range(5)]
        assert [step.step_type for step in steps] == [dm_env.StepType.MID] * 4 + [dm_env.StepType.LAST]
        for step in steps:
            assert step.discount == 1.0
            env.discount_spec().validate(step.discount)
            conforms(env, step)
    assert env.step(action).first()  # after the last


@pytest.mark.parametrize(
    ("name", "given"),
    [("reach", {}), ("track", {"time_limit": 1.0}), ("hold", SHORT), ("reach", {"actions": "tensions", **SHORT}),
     ("track", {"actions": "lengths", **SHORT}), ("reach", {"arm": Arm(links=8, gravity=(0, 0, -9.81)), **SHORT}),
     ("reach", {"arm": HANGING, "reward": "sparse"}), ("hold", {"arm": HANGING, **SHORT}),
     ("reach", {"variations": UNIFORM, **SHORT})],
)  # fmt: skip
def test_both_front_ends_give_the_same_trajectory(name, given):
    """An episode and a second's beginning; also where the arm hangs in dm_control's world, its base turned over."""
    env, other, rng = dm.load(name, random=5, **given), ArmEnv(name, **given), np.random.default_rng(0)
    definition = other.definition

    def agree(step, observation):
        seen = {key.split("/")[-1]: np.asarray(value)[None] for key, value in step.observation.items()}
        np.testing.assert_allclose(definition.flat(seen)[0], observation, rtol=0, atol=1e-12)

    for episode in range(2):
        agree(env.reset(), other.reset(seed=None if episode else 5)[0])
        for _ in range(5 if episode else definition.ticks):
            action = rng.uniform(-1, 1, env.action_spec().shape)
            step, (observation, reward, _, truncated, info) = env.step(action), other.step(action)
            agree(step, observation)
            assert step.reward == pytest.approx(reward, abs=1e-12)
            assert step.last() == truncated
            assert env.task.info["success"] == info["success"]
            if truncated:
                break


def test_a_seed_gives_the_same_episodes():
    def rollout(seed):
        env = dm.load("track", random=seed, variations=UNIFORM, time_limit=0.1)
        return [env.step([0.2, 0.1]).observation["contarm/tip_position"] for _ in range(4)]

    np.testing.assert_array_equal(rollout(1), rollout(1))
    assert not np.array_equal(rollout(1), rollout(2))


def test_observations_are_not_internal_buffers():
    env = dm.load("hold", random=0)
    first = env.reset().observation
    kept = {name: np.copy(value) for name, value in first.items()}
    second = env.step(np.full(3, 0.5)).observation
    for name, value in first.items():
        np.testing.assert_array_equal(value, kept[name], err_msg=name)
    for value in second.values():
        value[...] = 1e6
    for name, value in env.step(np.full(3, 0.5)).observation.items():
        assert np.abs(value).max() < 1e6, name


@pytest.mark.parametrize("actions", MODES)
def test_the_varied_model_is_that_of_the_varied_arm(actions):
    variations = {**UNIFORM, "joint_friction": 1e-3, "muscle.braid_friction": 0.3, "muscle.passive_stiffness": 200.0}
    env = dm.load("reach", random=0, actions=actions, variations=variations)
    env.reset()
    env.reset()
    arm, model = env.task._episodes.arms[0], env.physics.model
    wanted = plain_spec(arm, env.task.arm._actions.actuation, 0.005).compile()
    assert arm.payload != Arm().payload
    for field in ("body_mass", "body_inertia"):
        np.testing.assert_allclose(getattr(model, field)[-wanted.nbody + 1 :], getattr(wanted, field)[1:], rtol=1e-12)
    for field in ("jnt_stiffness", "dof_damping", "dof_frictionloss", "tendon_frictionloss", "tendon_stiffness",
                  "tendon_lengthspring", "tendon_damping", "actuator_gainprm", "actuator_biasprm", "actuator_dynprm",
                  "actuator_ctrlrange", "actuator_forcerange"):  # fmt: skip
        np.testing.assert_allclose(getattr(model, field), getattr(wanted, field), rtol=1e-12, err_msg=field)
    gravity = np.array(env.physics.data.body("contarm/base").xmat).reshape(3, 3).T @ model.opt.gravity
    np.testing.assert_allclose(gravity, arm.gravity, atol=1e-12)


def test_the_arm_attaches_to_another_arena_and_carries_another_entity():
    class Ball(composer.Entity):
        def _build(self):
            self._root = mjcf.RootElement(model="ball")
            self._root.worldbody.add("geom", type="sphere", size=[0.02], mass=0.05)

        @property
        def mjcf_model(self):
            return self._root

    arena, arm = composer.Arena(), dm.ContinuumArm()
    frame = arena.attach(arm)
    frame.pos, frame.quat = [0.1, 0.2, 1.5], [0.0, 1.0, 0.0, 0.0]  # hanging
    arm.attach(Ball())
    arena.mjcf_model.option.timestep = 0.005
    env = composer.Environment(composer.NullTask(arena))
    env.reset()
    physics = env.physics
    assert physics.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    with physics.reset_context():
        arm.straighten(physics)
    arm.apply_action(physics, [0.5, 0.0], None)
    for _ in range(400):
        physics.step()
    seen = {name: one(physics) for name, one in arm.observables.as_dict(fully_qualified=False).items()}
    assert all(value.shape == (0 if name == "pressures" else len(value),) for name, value in seen.items())
    world = physics.bind(arm.tip).xpos
    np.testing.assert_allclose(seen["tip_position"] * [1, -1, -1] + [0.1, 0.2, 1.5], world, atol=1e-9)
    np.testing.assert_allclose(physics.bind(arm.payload).xipos, world, atol=1e-12)  # where a wrench acts
    assert seen["tip_position"][0] > 0.1
    assert arm.attachment_site.parent is arm.tip


def test_the_viewers_ways_in():
    """A loader, specs, and a physics that draws from its cameras."""
    from contarm_sim.errors import RenderingError
    from contarm_sim.view.rendering.gl import choose_backend

    env = dm.load("reach", random=0)
    env.reset()
    assert env.physics.model.ncam == 3
    assert env.control_timestep() == 0.05
    target = env.physics.named.data.site_xpos["target"]
    observed = env.step([0.0, 0.0]).observation["target"]
    np.testing.assert_allclose(target, observed + np.array([0.0, 0.0, 0.15 * 0.37 + 0.026]), atol=1e-9)
    try:
        choose_backend()
    except RenderingError:
        pytest.skip("no GL library here")
    renderer = mujoco.Renderer(env.physics.model.ptr, 60, 80)
    renderer.update_scene(env.physics.data.ptr, "front")
    assert np.ptp(renderer.render()) > 50
    renderer.close()


@pytest.mark.gl
@pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="no virtual display here")
def test_dm_controls_viewer_opens_and_runs_a_policy():
    code = """if True:
        import glfw
        from contarm_sim.envs import dm
        from dm_control.viewer import application
        app, seen = application.Application(width=320, height=240), []
        tick, app._pause_subject.value = app._tick, False
        def counted():
            tick()
            seen.append(app._environment.physics.data.time)
            glfw.set_window_should_close(app._window._context.window, max(seen) > 0 or len(seen) > 1000)
        app._tick = counted
        app.launch(lambda: dm.load("reach", random=0), policy=lambda step: [0.5, 0.1])
        print(max(seen) > 0)"""
    words = ["xvfb-run", "-a", sys.executable, "-c", code]
    done = subprocess.run(
        words, capture_output=True, text=True, timeout=PATIENCE, env={**os.environ, "MUJOCO_GL": "glfw"}
    )
    assert done.stdout == "True\n", done.stderr


def test_mistakes_are_said_in_one_line():
    for call, said in (
        (lambda: dm.load("reech"), "task is 'reech'; allowed: reach, track, hold"),
        (lambda: dm.load("reach", variations={"paylod": 1}), "variation 'paylod' is unknown"),
        (lambda: dm.load("reach", actions="push"), "actions is 'push'"),
        (lambda: dm.ContinuumArm(actions="push"), "actions is 'push'"),
    ):
        with pytest.raises(InputError, match=said):
            call()
    env = dm.load("reach", random=0)
    env.reset()
    for action, said in (([0.0] * 3, r"shape \(3,\); allowed: shape \(2,\)"), ([np.nan, 0], "finite numbers")):
        with pytest.raises(InputError, match=said):
            env.step(action)
    assert env.step([0.0, 0.0]).mid()


def test_divergence_names_the_task_and_logs_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    env = dm.load("reach", random=0)
    env.reset()
    env.physics.data.qvel[:] = 1e9
    with pytest.raises(DivergenceError, match="task reach"):
        env.step([0.0, 0.0])
    assert not list(tmp_path.iterdir())


def test_without_dm_control_one_line_says_so_and_nothing_else_breaks():
    code = """if True:
        import sys
        sys.modules["dm_control"] = None
        import contarm_sim.envs.gym
        try:
            import contarm_sim.envs.dm
        except ImportError as error:
            print(error)"""
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert "needs dm-control 1.0.50" in done.stdout
    assert "pip install dm-control==1.0.50" in done.stdout
    assert done.stdout.count("\n") == 1
