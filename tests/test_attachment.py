"""The arm as a part of other models: it brings itself and nothing else, and moves there as it does alone."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from sampling import HEAVY

import contarm_sim
from contarm_sim.engine.plant import engine_room
from contarm_sim.errors import InputError
from contarm_sim.mjcf import arm_spec, spec, straight_controls
from contarm_sim.model.arm import Arm

SMALL = Arm(links=6, bending_stiffness=0.05, mass=0.2, length=0.25)
TURN = np.array([0.5, -0.5, 0.1, 0.7]) / np.linalg.norm([0.5, -0.5, 0.1, 0.7])


def _host(timestep=0.002, gravity=(0.0, 0.0, 0.0), integrator=mujoco.mjtIntegrator.mjINT_IMPLICITFAST):
    host = mujoco.MjSpec()
    host.option.timestep, host.option.gravity, host.option.integrator = timestep, gravity, integrator
    return host


def _cart(host, kind=mujoco.mjtJoint.mjJNT_SLIDE):
    """Add a box of 1 kg that slides along X, or flies; with a mount on each side."""
    cart = host.worldbody.add_body(name="cart")
    cart.add_joint(name="slide", type=kind, axis=[1, 0, 0])
    cart.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.1, 0.3, 0.02], pos=[0, 0, -0.1], mass=1.0)
    for name, y in (("left", 0.2), ("right", -0.2)):
        cart.add_site(name=name, pos=[0, y, 0])


def _fields(struct):
    """Return the numbers of a struct of the engine, those of structs inside it too."""
    found = {}
    for name in dir(struct):
        value = getattr(struct, name)
        if name.startswith("_") or callable(value):
            continue
        if isinstance(value, int | float | np.ndarray):
            found[name] = np.array(value)
        else:
            found.update({f"{name}.{inner}": number for inner, number in _fields(value).items()})
    return found


def _randomly_driven(model, seconds, seed=0):
    """Return a recording of sensors and the data at the end; controls jump between bent poses every 50 ms."""
    data, rng, rows = mujoco.MjData(model), np.random.default_rng(seed), []
    low, high = model.actuator_ctrlrange.T
    with engine_room():
        while data.time < seconds:
            if round(data.time / model.opt.timestep) % round(0.05 / model.opt.timestep) == 0:
                data.ctrl[:] = low + (high - low) * rng.uniform(0.4, 0.7, model.nu)
            mujoco.mj_step(model, data)
            rows.append(data.sensordata.copy())
    assert not data.warning.number.any()
    return np.array(rows), data


def test_it_is_a_public_name():
    assert contarm_sim.spec is spec
    with pytest.raises(InputError, match="lengths, pressures"):
        contarm_sim.spec(Arm(), "steam")


@pytest.mark.parametrize("conflict", ["WARNING", "MERGE", "ERROR"])
def test_the_host_keeps_all_that_is_its_own(conflict):
    """MuJoCo warns, merges or refuses when a part brings options; pytest makes warnings errors."""

    def host():
        made = _host(0.0031, (0, 0.1, -1.6), mujoco.mjtIntegrator.mjINT_IMPLICIT)
        made.compiler.conflict = getattr(mujoco.mjtConflict, f"mjCONFLICT_{conflict}")
        made.option.iterations, made.option.disableflags = 7, int(mujoco.mjtDisableBit.mjDSBL_WARMSTART)
        made.stat.extent, made.stat.center = 3.0, [1.0, 2.0, 3.0]
        made.visual.map.znear, made.visual.global_.offwidth = 0.2, 333
        made.default.joint.armature, made.default.geom.condim, made.default.tendon.width = 0.5, 6, 0.1
        _cart(made)
        made.add_key(name="aside", qpos=[0.4])
        return made

    alone, arm_alone = host().compile(), arm_spec(HEAVY).compile()
    both = host()
    both.attach(spec(HEAVY), site="left", prefix="arm/")
    model = both.compile()
    for part in ("opt", "stat", "vis"):
        kept = _fields(getattr(model, part))
        for name, value in _fields(getattr(alone, part)).items():
            if part != "stat" or name in ("extent", "center"):
                np.testing.assert_array_equal(kept[name], value, err_msg=f"{part}.{name}")
    assert model.nkey == 1
    assert model.key("aside").qpos[0] == 0.4
    assert model.body("cart").mass == alone.body("cart").mass
    for name in ("dof_armature", "dof_damping", "dof_frictionloss"):  # the host's defaults stay the host's
        np.testing.assert_array_equal(getattr(model, name)[1:], getattr(arm_alone, name))
    np.testing.assert_array_equal(model.tendon_width, arm_alone.tendon_width)
    np.testing.assert_array_equal(model.geom_condim[1:], arm_alone.geom_condim)


def test_every_name_gets_the_prefix():
    host = _host()
    host.attach(spec(HEAVY, "pressures"), frame=host.worldbody.add_frame(), prefix="arm/")
    host.compile()
    for kind in ("bodies", "joints", "geoms", "sites", "tendons", "actuators", "sensors", "materials"):
        names = [element.name for element in getattr(host, kind) if element.name != "world"]
        assert names, kind
        assert all(name.startswith("arm/") for name in names), names


@pytest.mark.parametrize("actuation", ["lengths", "pressures", "tensions"])
@pytest.mark.parametrize("arm", [Arm(), HEAVY], ids=["paper", "heavy"])
def test_attached_to_the_world_it_moves_as_it_does_alone(arm, actuation):
    alone, _ = _randomly_driven(arm_spec(arm, actuation).compile(), 1.0)
    host = _host(0.005, arm.gravity)
    host.attach(spec(arm, actuation), frame=host.worldbody.add_frame(), prefix="arm/")
    attached, _ = _randomly_driven(host.compile(), 1.0)
    np.testing.assert_array_equal(attached, alone)
    assert np.ptp(alone[:, 0]) > 0.01


@pytest.mark.parametrize("to", ["frame", "site"])
def test_turned_with_gravity_it_moves_the_same_in_its_base_frame(to):
    alone, _ = _randomly_driven(arm_spec(HEAVY).compile(), 0.5)
    gravity = np.zeros(3)
    mujoco.mju_rotVecQuat(gravity, np.array(HEAVY.gravity), TURN)
    host = _host(0.005, gravity)
    place = {"pos": [0.3, -1.0, 2.0], "quat": TURN}
    if to == "frame":
        host.attach(spec(HEAVY), frame=host.worldbody.add_frame(**place), prefix="arm/")
    else:
        host.attach(spec(HEAVY), site=host.worldbody.add_site(**place), prefix="arm/")
    attached, _ = _randomly_driven(host.compile(), 0.5)
    sign = np.sign(np.sum(attached[:, 3:7] * alone[:, 3:7], axis=1))
    attached[:, 3:7] *= sign[:, None]  # a quaternion and its negative are one orientation
    np.testing.assert_allclose(attached, alone, atol=1e-7)


def test_two_different_arms_on_one_moving_base():
    """One pulled by lengths, one by pressures; each has its own parts and does what it is told."""
    host = _host(0.005, (0.0, 0.0, 9.81))
    _cart(host)
    host.attach(spec(SMALL), site="left", prefix="left/")
    host.attach(spec(HEAVY, "pressures"), site="right", prefix="right/")
    model = host.compile()
    for side, arm, actuators, hinges in (("left/", SMALL, 3, 2), ("right/", HEAVY, 6, 3)):
        mine = [i for i in range(model.nbody) if model.body(i).name.startswith(side)]
        assert model.body_mass[mine].sum() == pytest.approx(arm.mass + arm.payload, rel=1e-12)
        joints = [model.joint(i) for i in range(model.njnt) if model.joint(i).name.startswith(side)]
        assert len(joints) == arm.links * hinges
        bending = [joint.stiffness[0] for joint in joints if joint.name[-1] in "xy"]
        np.testing.assert_allclose(bending, arm.bending_stiffness * arm.links / arm.length, rtol=1e-12)
        assert sum(model.actuator(i).name.startswith(side) for i in range(model.nu)) == actuators
        assert sum(model.sensor(i).name.startswith(side) for i in range(model.nsensor)) == 11 + len(joints)
        assert model.site(f"{side}base").pos[2] == 0

    data = mujoco.MjData(model)
    with engine_room():
        while data.time < 2.0:
            setpoints = np.array(straight_controls(SMALL)) + min(1.0, data.time) * np.array([-0.01, 0.005, 0.005])
            for i in range(3):
                data.actuator(f"left/muscle_{i + 1}").ctrl = setpoints[i]
                for half in ("linear", "quadratic"):
                    data.actuator(f"right/muscle_{i + 1}_{half}").ctrl = (9e4, 3e5, 3e5)[i]
            mujoco.mj_step(model, data)
    assert not data.warning.number.any()
    lengths = [data.sensor(f"left/muscle_{i}_length").data[0] for i in (1, 2, 3)]
    np.testing.assert_allclose(lengths, [-0.01, 0.005, 0.005], atol=5e-4)
    assert data.sensor("left/tip_position").data[0] > 0.05  # towards muscle 1
    assert data.sensor("right/tip_position").data[0] < -0.01  # away from it, hanging with its payload
    for side in ("left", "right"):  # in the frame of its own base, which moves
        seen = data.site(f"{side}/tip").xpos - data.site(f"{side}/base").xpos
        np.testing.assert_allclose(data.sensor(f"{side}/tip_position").data, seen, atol=1e-3)


def test_an_arm_that_swings_on_a_free_base_does_not_move_the_whole():
    """Nothing outside pushes: momentum stays zero, up to an error of first order in the time step."""

    def worst(timestep):
        host = _host(timestep)
        _cart(host, mujoco.mjtJoint.mjJNT_FREE)
        host.attach(spec(SMALL), site="left", prefix="arm/")
        model = host.compile()
        data = mujoco.MjData(model)
        whole, part = model.body("cart").id, model.body("arm/base").id
        momentum, angular, swing = 0.0, 0.0, 0.0
        with engine_room():
            while data.time < 0.5:
                bend = 0.01 * np.sin(4 * np.pi * data.time)
                data.ctrl[:] = np.array(straight_controls(SMALL)) + bend * np.array([-1.0, 0.5, 0.5])
                mujoco.mj_step(model, data)
                mujoco.mj_fwdPosition(model, data)
                mujoco.mj_subtreeVel(model, data)
                momentum = max(momentum, np.linalg.norm(data.subtree_linvel[whole]) * model.body_subtreemass[whole])
                angular = max(angular, np.linalg.norm(data.subtree_angmom[whole]))
                swing = max(swing, np.linalg.norm(data.subtree_linvel[part]) * model.body_subtreemass[part])
        return np.array([momentum, angular]), swing

    coarse, swing = worst(0.002)
    fine, _ = worst(0.0005)
    assert swing > 0.005  # kg m/s
    assert coarse[0] < 0.03 * swing
    assert np.all(fine < 0.27 * coarse)


def test_the_combination_survives_a_file():
    """The host thinks in degrees and limits by range; the arm does neither."""
    host = mujoco.MjSpec.from_string("""
        <mujoco>
          <compiler angle="degree" autolimits="true"/>
          <option integrator="implicitfast"/>
          <default><joint damping="0.7" armature="0.01"/><geom condim="4"/><site group="3"/></default>
          <worldbody>
            <body name="pole" euler="30 0 0">
              <joint name="turn" axis="1 0 0" range="-90 90"/>
              <geom size="0.05"/>
              <site name="left" euler="0 0 45"/>
              <site name="right" euler="0 90 0"/>
            </body>
          </worldbody>
        </mujoco>""")
    host.attach(spec(HEAVY), site="left", prefix="left/")
    host.attach(spec(SMALL, "pressures"), site="right", prefix="right/")
    model = host.compile()
    np.testing.assert_allclose(model.joint("turn").range, [-np.pi / 2, np.pi / 2])
    np.testing.assert_array_equal(model.jnt_limited, [True] + [False] * (model.njnt - 1))
    np.testing.assert_allclose(model.joint("left/joint_01_x").stiffness[0], 0.1 * 27)
    again = mujoco.MjModel.from_xml_string(host.to_xml())
    for name in dir(model):
        value = getattr(model, name)
        if not name.startswith("_") and isinstance(value, np.ndarray):  # the engine writes six digits
            np.testing.assert_allclose(getattr(again, name), value, rtol=2e-5, atol=2e-5, err_msg=name)


def test_length_servos_need_the_implicit_integrator_that_spec_asks_for():
    """What its docstring warns of: under Euler the arm diverges."""

    def runs(integrator, timestep):
        host = _host(timestep, integrator=integrator)
        host.attach(spec(Arm()), frame=host.worldbody.add_frame(), prefix="arm/")
        model = host.compile()
        data = mujoco.MjData(model)
        with engine_room():
            for i in range(round(0.2 / timestep)):
                data.ctrl[:] = 0.01 * np.sin(2 * np.pi * timestep * i) * np.array([-1.0, 0.5, 0.5])
                mujoco.mj_step(model, data)
        return not data.warning.number.any()

    kind = mujoco.mjtIntegrator
    for timestep in (0.0005, 0.002):
        assert not runs(kind.mjINT_EULER, timestep)
    for integrator in (kind.mjINT_IMPLICITFAST, kind.mjINT_IMPLICIT):
        assert runs(integrator, 0.005)


def test_an_arm_on_the_wrist_of_a_robot():
    """The Jaco's own defaults (damped, rubbing, limited joints, its geoms' contacts) do not reach our arm."""
    folder = Path(pytest.importorskip("dm_control", reason="it brings the robot").__file__).parent
    host = mujoco.MjSpec.from_file(str(folder / "third_party/kinova/jaco_arm.xml"))
    host.option.integrator, host.option.timestep = mujoco.mjtIntegrator.mjINT_IMPLICITFAST, 0.002
    robot = host.copy().compile()
    host.attach(spec(Arm()), site="wristsite", prefix="arm/")
    model, ours = host.compile(), arm_spec(Arm()).compile()
    assert (model.nv, model.nu) == (robot.nv + ours.nv, robot.nu + ours.nu)
    np.testing.assert_array_equal(model.opt.gravity, robot.opt.gravity)
    for name in ("dof_damping", "dof_armature", "dof_frictionloss", "jnt_limited", "jnt_stiffness"):
        expected = np.concatenate([getattr(robot, name), getattr(ours, name)])
        np.testing.assert_array_equal(getattr(model, name), expected, err_msg=name)
    assert model.body_mass.sum() == pytest.approx(robot.body_mass.sum() + 0.3)

    data = mujoco.MjData(model)
    for i in range(6):  # the middle of what each joint allows
        data.qpos[i] = robot.jnt_range[i].mean() if robot.jnt_limited[i] else 0.0
    data.ctrl[:] = straight_controls(Arm())
    with engine_room():
        while data.time < 1.0:
            mujoco.mj_step(model, data)
    assert not data.warning.number.any()
    np.testing.assert_allclose(data.xpos[model.body("arm/base").id], data.site("wristsite").xpos, atol=1e-12)
    lengths = [data.sensor(f"arm/muscle_{i}_length").data[0] for i in (1, 2, 3)]
    np.testing.assert_allclose(lengths, 0.0, atol=0.002)
