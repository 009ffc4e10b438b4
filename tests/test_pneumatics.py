"""Pneumatic muscles in the engine: against the law, and what valves, silicone and friction do."""

from dataclasses import replace

import mujoco
import mujoco.batch
import numpy as np
import pytest
from sampling import bends, differenced_stiffness

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, chain
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.moments import weight_moment
from contarm_sim.mechanics.pneumatics import force, force_slope, passive_tension, pressure_for
from contarm_sim.mechanics.pressures import holding_pressures, level_range, pressure_needed
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import balance, holding_tensions
from contarm_sim.mjcf import arm_spec, exact_xml
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.model.mckibben import McKibben
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.stiffness import TangentStiffness
from contarm_sim.studies.largest_bends import held_off, largest_bends

HANGING = {"gravity": (0.0, 0.0, 9.81), "payload": 0.1}


def _pressurised(arm, pressures):
    plant = Plant(arm, actuation="pressures")
    plant.reset(np.zeros(2))
    plant.control[:] = plant.pressure[:] = pressures
    return plant


@pytest.mark.parametrize(
    "muscle", [McKibben(), McKibben(max_contraction=0.4, mount_contraction=0.2)], ids=["paper", "long"]
)
def test_native_actuators_are_the_mckibben_law_over_all_lengths_and_pressures(muscle):
    """Asked for is 1 % of the blocked force; the line and the parabola are exact, slack muscles included."""
    arm = Arm(muscle=muscle)
    plant = Plant(arm, actuation="pressures")
    model, data = plant.model, plant.data
    for length in np.linspace(0.55, 1.3, 40) * arm.muscle_rest_length:
        for pressure in (0.0, muscle.min_pressure, 4e5, muscle.max_pressure):
            plant.pressure[:] = pressure
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            data.actuator_length[:] = length - arm.length  # counted from the straight arm
            data.actuator_velocity[:] = 0.5  # the law is static
            mujoco.mj_fwdActuation(model, data)
            np.testing.assert_allclose(
                plant.actuator_tensions, force(pressure, length, arm), atol=1e-12 * muscle.blocked_force, rtol=1e-12
            )


def test_pressure_follows_its_command_with_the_valves_lag(arm):
    plant = _pressurised(arm, 1e5)
    plant.control[:] = 3e5
    mujoco.mj_step(plant.model, plant.data, 20)
    expected = 3e5 - 2e5 * np.exp(-plant.data.time / arm.muscle.valve_time)
    np.testing.assert_allclose(plant.pressure, expected, rtol=1e-12)


def test_a_batch_and_the_file_step_as_the_plant_does(arm):
    """No callback and no Python between steps: the engine's own threads and any viewer simulate the muscles too."""
    plant = _pressurised(arm, np.array([4e5, 2e5, 1e5]))
    batch = mujoco.batch.Batch(
        mujoco.MjModel.from_xml_string(exact_xml(arm_spec(arm, "pressures"))), 3, persistent=True
    )
    batch.reset(keyframe=0)
    batch.bind("ctrl")[:], batch.bind("act")[:] = plant.data.ctrl, plant.data.act
    batch.step(nstep=40)
    mujoco.mj_step(plant.model, plant.data, 40)
    assert np.abs(plant.data.qpos).max() > 1e-3
    for qpos in batch.bind("qpos"):
        np.testing.assert_allclose(qpos, plant.data.qpos, atol=1e-9)


def test_stretched_silicone_pulls_beyond_the_rest_length_only():
    arm = Arm(muscle=McKibben(passive_stiffness=300.0))
    plant = _pressurised(arm, 0.0)
    for angle in (0.5, 2.5):
        plant.reset(arc.from_polar(angle, np.pi))
        plant.pressure[:] = 0.0
        mujoco.mj_forward(plant.model, plant.data)
        expected = np.maximum(0, 300.0 * (plant.muscle_lengths - arm.muscle_rest_length))
        np.testing.assert_allclose(plant.muscle_tensions, expected, atol=1e-12)
        springs = plant.data.qfrc_passive + plant.model.jnt_stiffness * plant.data.qpos
        J = np.zeros((3, plant.model.nv))
        mujoco.mju_sparse2dense(
            J, plant.data.ten_J, plant.model.ten_J_rownnz, plant.model.ten_J_rowadr, plant.model.ten_J_colind
        )
        np.testing.assert_allclose(springs, -J.T @ expected, atol=1e-10)
        assert (expected.max() > 1) == (angle > 1)


@pytest.mark.parametrize("passive", [None, 300.0])
def test_tangent_stiffness_under_pressure_is_the_derivative_of_the_forces(passive):
    arm = Arm(links=8, **HANGING, muscle=McKibben(passive_stiffness=passive))
    plant = _pressurised(arm, np.array([6e5, 2e5, 1e5]))
    model, data = plant.model, plant.data
    data.qpos[:] = np.random.default_rng(1).normal(0.15, 0.05, model.nq)
    mujoco.mj_forward(model, data)
    K = TangentStiffness(plant, AppliedLoad(plant, Load()))()
    np.testing.assert_allclose(K, differenced_stiffness(plant), atol=1e-7 * np.abs(K).max())


def _cycle(arm):
    """Raise and lower the pressure of muscle 1 over 12 s; return bends towards it [rad], up, down, and lengths [m]."""
    plant = _pressurised(arm, 1e5)
    up = np.linspace(1e5, 4e5, 1200)
    lengths = []
    for pressure in np.concatenate([up, up[::-1]]):
        plant.control[:, 0] = pressure
        mujoco.mj_step(plant.model, plant.data)
        lengths.append(plant.muscle_lengths)
    lengths = np.array(lengths)
    bend = routing.bend_from_lengths(lengths, arm)[0][:, 0]
    return bend[:1200], bend[1200:][::-1], lengths[:1200]


def test_braid_friction_makes_the_hysteresis_that_the_statics_say():
    """Friction F in each muscle takes a moment 2 r F from the bend each way, which stiffness turns into bend."""
    friction = 1.0
    arm = Arm(links=8)
    up, down, lengths = _cycle(arm)
    lag = down - up
    up, down, _ = _cycle(replace(arm, muscle=McKibben(braid_friction=friction)))
    index = 500
    pressures = np.array([1e5 + 3e5 * index / 1199, 1e5, 1e5])
    springs = length_jacobian([up[index], 0.0], arm)[:, 0] ** 2 @ force_slope(pressures, lengths[index], arm)
    expected = 2 * 2 * arm.muscle_radius * friction / (arm.bending_stiffness / arm.length + springs)
    assert (down - up - lag)[index] == pytest.approx(expected, rel=0.3)
    assert lag[index] < 0.5 * expected


def test_joint_friction_slows_a_pushed_arm():
    """The engine's dry friction is soft: it creeps under a steady load, but it takes energy out of any motion."""
    moved = []
    for friction in (None, 0.01):
        plant = Plant(Arm(joint_friction=friction, links=12), actuation="none")
        plant.data.xfrc_applied[plant.model.body("tip").id, 0] = 0.02
        mujoco.mj_step(plant.model, plant.data, 60)
        moved.append(plant.tip[0])
    assert moved[0] > 3e-3
    assert moved[1] < 0.5 * moved[0]


def test_the_weights_moment_is_the_derivative_of_its_potential():
    arm = Arm(gravity=(1.0, -3.0, 9.0), payload=0.07)
    xi = (np.arange(4000) + 0.5) / 4000

    def potential(bend):
        centre = arc.position(bend[:, None], arm.length, xi).mean(axis=1)
        return -(arm.mass * centre + arm.payload * arc.position(bend, arm.length)) @ arm.gravity

    bend, step = bends(50, largest=3.0), 1e-5
    for column, direction in enumerate(np.eye(2) * step):
        slope = (potential(bend + direction) - potential(bend - direction)) / (2 * step)
        np.testing.assert_allclose(weight_moment(bend, arm)[:, column], -slope, atol=1e-6)


def test_pressures_hold_bends_within_the_limits_and_the_extremes_touch_them(arm):
    bend = bends(100, largest=2.2)
    low, high = (holding_pressures(bend, arm, share) for share in (0.0, 1.0))
    muscle = arm.muscle
    for pressures in (low, high):
        assert pressures.min() > muscle.min_pressure * (1 - 1e-9)
        assert pressures.max() < muscle.max_pressure * (1 + 1e-9)
    np.testing.assert_allclose(low.min(axis=1), muscle.min_pressure, rtol=1e-9)
    np.testing.assert_allclose(high.max(axis=1), muscle.max_pressure, rtol=1e-9)
    lengths = routing.lengths_from_bend(bend, arm)
    differences = [force(p, lengths, arm) - holding_tensions(bend, arm) for p in (low, high)]
    for difference in differences:  # co-contraction alone
        null = balance(bend, arm).cocontraction[..., 0, :]
        np.testing.assert_allclose(np.cross(difference, null), 0, atol=1e-9)


def test_a_bend_that_no_pressure_holds_is_refused_with_the_pressure_it_would_need(arm):
    bend = arc.from_polar(2.9, 0.0)
    inflated, _ = pressure_needed(bend, arm)
    assert inflated > arm.muscle.max_pressure
    with pytest.raises(InputError, match=f"needs {inflated / 1e3:.0f} kPa"):
        holding_pressures(bend, arm)
    low, high = level_range(balance(bend, arm), arm)
    assert low > high


def test_the_possibility_map_is_where_the_simulated_arm_agrees():
    """Without gravity to a quarter of a degree, at the very limit of pressure; symmetric by thirds of a turn."""
    planes = np.radians([0, 30, 120, 240])
    inflated, vented = largest_bends(Arm(), planes)
    np.testing.assert_allclose(inflated[[0, 2]], inflated[[2, 3]], rtol=5e-4)  # but for what hinge pairs turn more
    assert np.all(vented >= inflated)
    assert vented[1] > inflated[1] + 0.3  # a vented antagonist need not be fought
    assert held_off(Arm(), arc.from_polar(0.999 * inflated[0], planes[0])) < np.radians(0.01)
    loaded = Arm(**HANGING)
    heavy, _ = largest_bends(loaded, planes)
    assert np.all(heavy < inflated)
    assert held_off(loaded, arc.from_polar(0.999 * heavy[0], planes[0])) < np.radians(0.01)


def test_a_vented_muscle_is_without_tension_where_the_map_says_so(arm):
    bend = arc.from_polar(2.7, np.radians(30))
    inflated, vented = pressure_needed(bend, arm)
    assert vented < arm.muscle.max_pressure < inflated
    held = balance(bend, arm)
    level = (-held.tensions / held.cocontraction[0]).max(keepdims=True)
    tensions = held.at(level)
    slack = int(tensions.argmin())
    lengths = routing.lengths_from_bend(bend, arm)
    pressures = pressure_for(np.maximum(tensions, 0.0), lengths, arm)
    assert pressures[slack] == pytest.approx(0, abs=1e-3)
    pressures[slack] = 0.0
    assert pressures.max() == pytest.approx(vented, rel=1e-9)
    found = equilibrium(arm, Load(muscles=Muscles(kind="pressures", values=tuple(pressures))))
    assert np.linalg.norm(found.tip - arc.position(bend, arm.length)) < 0.01 * arm.length


def test_silicone_takes_its_share_of_the_holding_tensions():
    arm = Arm(muscle=McKibben(passive_stiffness=300.0))
    bend = arc.from_polar(1.8, np.pi / 3)
    lengths = routing.lengths_from_bend(bend, arm)
    passive = passive_tension(lengths, arm)
    assert passive.max() > 1
    total = holding_tensions(bend, arm) + passive
    np.testing.assert_allclose(
        np.cross(total - holding_tensions(bend, Arm()), balance(bend, arm).cocontraction[0]), 0, atol=1e-9
    )
    found = equilibrium(arm, Load(muscles=Muscles(kind="pressures", values=tuple(holding_pressures(bend, arm)))))
    np.testing.assert_allclose(found.tip, chain.tip(bend, arm.length, arm.links), atol=2e-4)


def test_continuation_raises_pressures_too():
    """Newton from straight does not reach this pose; raising everything together does, and it is stable."""
    arm = replace(Arm(**HANGING), gravity=(9.81, 0.0, -9.81))
    muscles = Muscles(kind="pressures", values=(7e5, 9e4, 9e4))
    wrench = Wrench(xi=1, force=(0.0, 1.5, -1.0))
    found = equilibrium(arm, Load(muscles=muscles, wrenches=(wrench,)))
    assert found.stable
    assert found.residual <= 1e-9
