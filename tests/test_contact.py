"""Contact: the shape of links, energy, creep, the friction cone, self-contact, and that it is off otherwise."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from contarm_sim import Arm, InputError, Section
from contarm_sim.engine.plant import Plant
from contarm_sim.mjcf import arm_spec
from contarm_sim.model.objects import Object
from contarm_sim.model.presets import two

STANDING = Arm(gravity=(0.0, 0.0, -9.81))
LEANING = (-0.03, 0.015, 0.015)
FRICTION = 0.8


def wall(x, **more):
    return Object(name="wall", shape="plane", position=(x, 0, 0), axis=(-1, 0, 0), friction=FRICTION, **more)


def forces(plant):
    """Return the engine's own contact forces [N], shape (C, 3), normal first."""
    found, one = np.zeros((plant.data.ncon, 3)), np.zeros(6)
    for contact in range(plant.data.ncon):
        mujoco.mj_contactForce(plant.model, plant.data, contact, one)
        found[contact] = one[:3]
    return found


def beyond_cone(plant):
    """Return the largest friction force beyond what the normal force allows, over the largest force."""
    felt = forces(plant)
    allowed = plant.data.contact.friction[:, 0] * felt[:, 0]
    return np.max((np.hypot(felt[:, 1], felt[:, 2]) - allowed) / max(np.abs(felt).max(), 1e-9)) if len(felt) else 0.0


def run(plant, seconds, each=lambda: None):
    for _ in range(round(seconds / plant.model.opt.timestep)):
        mujoco.mj_step(plant.model, plant.data)
        each()


def test_links_touch_as_a_tube_as_thick_as_their_disks_or_their_fattest_muscles():
    arm = two()
    assert Arm().contact_radii == Arm().disk_radii  # the paper's muscles at half a turn just fill its disks
    fattest = [
        group.routing.radius + 0.5 * float(group.law.diameter_at(group.length_range[0], group.rest_length))
        for group in arm.groups
    ]
    assert arm.contact_radii == pytest.approx(fattest)
    assert all(np.array(arm.contact_radii) > np.array(arm.disk_radii))
    given = replace(arm, sections=(replace(arm.sections[0], contact_radius=0.03), arm.sections[1]))
    assert given.contact_radii == (0.03, arm.contact_radii[1])
    with pytest.raises(InputError, match="contact_radius"):
        Section(contact_radius=0.0)

    model = arm_spec(given).compile()
    ends, kind = 0.0, mujoco.mjtGeom
    for body in range(1, model.nbody - 1):  # from base to tip: each begins where the one before it ends
        geom = next(g for g in range(model.ngeom) if model.geom_bodyid[g] == body and model.geom_contype[g])
        height = sum(model.body_pos[b, 2] for b in range(1, body + 1)) + model.geom_pos[geom, 2]
        radius, half = model.geom_size[geom, :2]
        if model.geom_type[geom] == kind.mjGEOM_SPHERE:  # of the round tip, or a core within it
            assert height <= arm.length - radius
            continue
        assert height - half == pytest.approx(ends, abs=1e-12)
        ends = height + half
        if model.geom_type[geom] == kind.mjGEOM_CAPSULE:  # whose round ends stay inside of the arm
            assert 0 <= height - radius - half <= height + radius + half <= arm.length + 1e-12
        else:
            assert model.geom_type[geom] == kind.mjGEOM_CYLINDER
            assert ends < 0.05
        assert radius == pytest.approx(0.03 if body <= 13 else arm.contact_radii[1])
    assert radius == pytest.approx(arm.contact_radii[1])
    assert height + radius == pytest.approx(arm.length)
    assert arm.length - ends < 2 * radius  # the ball begins below where the tube ends


def test_contact_is_off_where_there_is_nothing_to_touch_and_free_motion_is_the_same_where_there_is():
    far = replace(two(), objects=(wall(9.0),))
    alone, near = Plant(far), Plant(far, in_world=True)
    assert alone.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
    assert not alone.model.dof_armature.any()
    assert alone.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert not near.model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT
    for step in (0.005, 0.002):
        for plant in (alone, near):
            plant.own.step_by(step)
            plant.reset(np.array([0.5, 0.2]))
            plant.data.ctrl[0] = -0.02
            mujoco.mj_step(plant.model, plant.data, 200)
        assert np.abs(alone.tip - near.tip).max() < 1e-12
        assert alone.data.qvel == pytest.approx(near.data.qvel, abs=1e-9)


@pytest.fixture(scope="module")
def leaning():
    """An arm that leans on a wall and is pulled along it, and its stations [m] once a second for ten seconds."""
    plant = Plant(replace(STANDING, objects=(wall(0.06),)), in_world=True)
    plant.reset()
    plant.data.ctrl[:] = LEANING
    run(plant, 2.0)
    plant.data.xfrc_applied[plant.model.body("tip").id, 1] = 0.7 * FRICTION * forces(plant)[:, 0].sum()
    beyond, seen, felt = [], [], []
    run(plant, 2.0, lambda: beyond.append(beyond_cone(plant)))
    for _ in range(11):
        seen.append(plant.stations)
        felt.append(forces(plant).sum(axis=0))
        run(plant, 1.0)
    return plant, np.array(seen), np.array(felt), max(beyond)


def test_a_resting_contact_does_not_creep_or_buzz(leaning):
    plant, seen, felt, _ = leaning
    assert felt[0, 0] > 5
    assert 0.6 < np.hypot(felt[0, 1], felt[0, 2]) / felt[0, 0] < FRICTION  # nearly slips
    assert np.abs(seen - seen[0]).max() < 1e-4 * plant.arm.length
    assert felt == pytest.approx(felt[[0]].repeat(len(felt), 0), abs=1e-3 * felt[0, 0])
    assert np.abs(plant.data.qvel).max() < 1e-4
    assert -1e-5 < plant.data.contact.dist.min() < 0  # it gives way by less than 0.01 mm under some 6 N


def test_friction_stays_in_its_cone(leaning):
    assert leaning[-1] < 1e-9


def test_a_held_object_does_not_slip():
    box = Object(name="box", shape="box", size=(0.04, 0.04, 0.04), position=(0.1345, 0, 0.30), mass=0.2)
    shelf = Object(name="shelf", shape="box", size=(0.04, 0.04, 0.02), position=(0.1345, 0, 0.2699), friction=0.0)
    pillar = Object(name="pillar", shape="box", size=(0.02, 0.2, 0.2), position=(0.165, 0, 0.30))
    plant = Plant(replace(STANDING, objects=(pillar, box, shelf)), in_world=True)
    plant.reset()
    body, geom = plant.data.body("box"), plant.model.geom("shelf").id

    def close():
        plant.data.ctrl[:] = 1.05 * min(1.0, plant.data.time / 1.5) * np.array(LEANING)

    run(plant, 2.5, close)
    plant.model.geom_contype[geom] = plant.model.geom_conaffinity[geom] = 0  # the shelf is taken away
    run(plant, 2.0)
    before = body.xpos.copy()
    run(plant, 10.0)
    assert before[2] > 0.29  # it has not fallen
    assert np.linalg.norm(body.xpos - before) < 1e-4 * plant.arm.length


def energy(plant):
    """Return kinetic energy, and that of gravity and springs, as the engine counts it, without its armature [J]."""
    model, data = plant.model, plant.data
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    armature = model.dof_armature @ data.qvel**2 + model.tendon_armature @ data.ten_velocity**2
    return data.energy[1] - 0.5 * armature + data.energy[0]


ONTO_A_FLOOR = replace(two(), objects=(Object(name="floor", shape="plane", position=(0, 0, 0.33), axis=(0, 0, -1)),))


@pytest.mark.parametrize(
    ("arm", "bend", "step", "most"),
    [
        (replace(STANDING, objects=(wall(0.10),)), (-2.0, 0.0), 0.005, 0.0),
        (ONTO_A_FLOOR, (0.6, 0.25), 0.001, 1e-8),  # rounding, while it rests
        # In 5 ms springs do not feel the blow that stops the arm: the error of the step comes back.
        (ONTO_A_FLOOR, (0.6, 0.25), 0.005, 1e-2),
    ],
    ids=["standing, against a wall", "hanging, onto a floor, 1 ms", "hanging, onto a floor, 5 ms"],
)
def test_a_falling_arm_loses_energy_until_it_rests(arm, bend, step, most):
    plant = Plant(arm, in_world=True, actuation="none", timestep=step)
    plant.reset(np.array(bend))
    seen, touched = [], []
    for _ in range(round(3 / step)):
        mujoco.mj_step1(plant.model, plant.data)  # positions and velocities of one moment
        seen.append(energy(plant))
        touched.append(plant.data.ncon)
        mujoco.mj_step2(plant.model, plant.data)
    total = np.array(seen)
    lost, lowest = total[0] - total[-1], np.minimum.accumulate(total)
    assert any(touched)
    assert lost > 0.03
    assert np.max(total[1:] - lowest[:-1]) <= most * lost
    assert np.max(np.diff(total[-len(total) // 4 :])) < 1e-9 * lost
    assert np.abs(plant.data.qvel).max() < 1e-2


def test_contact_forces_are_converged_where_links_wrap_around_something():
    can = Object(name="can", shape="cylinder", radius=0.03, length=0.12, position=(0.075, 0, 0.22), axis=(0, 1, 0))
    arm = replace(two(), gravity=(0.0, 0.0, 0.0), objects=(can,))
    plant, exact = Plant(arm, in_world=True), Plant(arm, in_world=True)
    exact.model.opt.tolerance, exact.model.opt.iterations, exact.model.opt.ls_iterations = 1e-15, 500, 500
    plant.reset()
    most = 0
    for step in range(800):
        plant.data.ctrl[:] = min(1.0, plant.data.time / 2) * np.array((-2.0, 1.0, 1.0, -5.4, 2.7, 2.7)) * 0.00628
        for name in ("qpos", "qvel", "ctrl", "qacc_warmstart"):
            getattr(exact.data, name)[:] = getattr(plant.data, name)
        mujoco.mj_step(plant.model, plant.data)
        if step % 20 == 0 and plant.data.ncon:
            mujoco.mj_forward(exact.model, exact.data)
            there = forces(exact)
            assert np.abs(forces(plant) - there).max() < 2e-3 * max(0.1, np.abs(there).max())
            assert beyond_cone(plant) < 1e-9
            most = max(most, plant.data.ncon)
    assert most >= 3
    assert forces(plant)[:, 0].sum() > 10
    assert plant.data.contact.dist.min() > -5e-5


@pytest.mark.parametrize("arm", [Arm(), two(), Arm(links=48)], ids=["24 links", "two sections", "48 links"])
def test_links_touch_one_another_only_where_the_arm_is_curled_up(arm):
    rng = np.random.default_rng(3)
    itself = arm.in_world(replace(arm.world, self_contact=True))
    plant = Plant(itself, in_world=True)
    mujoco.mj_forward(plant.model, plant.data)
    assert plant.data.ncon == 0
    half = np.pi / len(arm.sections)
    plant.reset(np.array([half, 0.3 * half]))
    mujoco.mj_forward(plant.model, plant.data)
    assert plant.data.ncon == 0

    tight = 0.95 * arm.sections[-1].link_pitch / max(arm.contact_radii)  # bend of a joint [rad]
    for _ in range(10):  # half a turn, nearly as tight as a tube can be bent, somewhere along the arm
        plant.reset()
        count = int(np.pi / tight)
        first = rng.integers(0, plant.model.nv // 2 - count)
        plane = rng.uniform(0, 2 * np.pi) + np.cumsum(rng.uniform(-0.2, 0.2, count))
        axes = [plant.model.joint(joint).axis @ [1, 0, 0] for joint in range(2 * first, 2 * (first + count))]
        across = np.where(np.array(axes) > 0.5, np.cos(plane).repeat(2), np.sin(plane).repeat(2))
        plant.qpos[2 * first : 2 * (first + count)] = tight * across
        mujoco.mj_forward(plant.model, plant.data)
        assert plant.data.ncon == 0

    plant.reset(np.array([2.1 * np.pi / len(arm.sections), 0.0]))
    mujoco.mj_forward(plant.model, plant.data)
    assert plant.data.ncon > 0
    assert plant.data.contact.dist.min() < -0.01


def test_a_free_log_lies_still_in_a_groove():
    # One that jumped, to a metre a second, with the damping ratio of the arm's own contact.
    friction, radius, bar = 0.9038995863238193, 0.03, 0.004
    grooved = [
        Object(
            name=f"bar{y}{side}", shape="capsule", radius=bar, length=0.1, friction=friction,
            position=(0.3 + 0.03 * side, 0.06 * (2 * y - 1), 0.33), axis=(side, 0, -1),
        )
        for y in (0, 1) for side in (-1, 1)
    ]  # fmt: skip
    log = Object(
        name="log", shape="cylinder", radius=radius, length=0.2, axis=(0, 1, 0), mass=1.4386240155192893,
        friction=friction, position=(0.3, 0, 0.33 + 0.03 - np.sqrt(2) * (radius + bar)),
    )  # fmt: skip
    plant = Plant(Arm(links=4, gravity=(0, 0, 9.81), objects=(*grooved, log)), in_world=True)
    plant.reset()
    run(plant, 1.5)
    speeds = []
    run(plant, 1.5, lambda: speeds.append(np.abs(plant.data.qvel[-6:-3]).max()))
    assert max(speeds) < 1e-4
    assert plant.data.body("log").xpos == pytest.approx(log.position, abs=1e-3)
