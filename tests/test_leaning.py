"""Static poses that lean on objects: against the rod's boundary-value problem, the engine in motion, and themselves."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from click.testing import CliRunner
from leaning_rod import random_cases

from contarm_sim import Arm, Load, Wrench, equilibria, equilibrium
from contarm_sim.cli.main import cli
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import EquilibriumError, InputError
from contarm_sim.mechanics.shape import stations
from contarm_sim.model.load import Muscles
from contarm_sim.model.objects import Object
from contarm_sim.model.world import World
from contarm_sim.statics.leaning.leaning import Leaning
from contarm_sim.statics.leaning.surroundings import Surroundings
from contarm_sim.statics.solver import Solver

HANGING = (0.0, 0.0, 9.81)
POST = Object(name="post", shape="cylinder", radius=0.01, length=0.4, position=(0.08, 0, 0.25), axis=(0, 1, 0))
WALL = Object(name="wall", shape="plane", position=(0.13, 0, 0), axis=(-1, 0, -0.2))
BALL = Object(name="ball", shape="sphere", radius=0.02, position=(0.08, 0.01, 0.25), mass=0.1)
BOX = Object(name="box", shape="box", size=(0.1, 0.2, 0.1), position=(0.11, 0, 0.3), friction=0.0)
TO_X = Load(wrenches=(Wrench(xi=1, force=(1.0, 0, 0)),))


def test_a_rod_on_a_post_and_on_a_plane_is_where_its_boundary_value_problem_says():
    for kind in ("post", "plane"):
        for case in _cases(kind, 2, seed=5):
            tip, force = _errors(*case, links=24)
            assert tip < 0.005
            assert force < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["post", "plane"])
def test_fifty_random_rods_are_within_the_floors_and_of_the_second_order(kind):
    cases = _cases(kind, 50, seed=16)
    errors = np.array([[_errors(*case, links=links) for links in (6, 12, 24, 48)] for case in cases])
    at_24 = errors[:, 2].max(axis=0)
    assert at_24[0] < 0.005
    assert at_24[1] < 0.02
    rms = np.sqrt((errors**2).mean(axis=0))
    orders = np.log2(rms[:-1] / rms[1:])
    print(kind, "largest at 24 links", at_24, "orders", orders.tolist())
    assert orders.min() > 1.5


def _cases(kind, count, seed):
    arm = Arm()
    return random_cases(kind, count, seed, arm.length, arm.bending_stiffness, arm.mass, radius=0.026)[0]


def _errors(rod, obstacle, found, links):
    """Return errors of tip [lengths] and of contact force [1] of the arm of so many links."""
    place = (obstacle.at[0], 0.0, obstacle.at[1])
    if obstacle.radius is None:
        touched = Object(name="it", shape="plane", position=place, axis=(obstacle.normal[0], 0, obstacle.normal[1]))
    else:
        touched = Object(
            name="it", shape="cylinder", radius=obstacle.radius, length=1.0, position=place, axis=(0, 1, 0)
        )
    arm = Arm(links=links, gravity=(rod.gravity[0], 0, rod.gravity[1]), objects=(touched,))
    assert Surroundings(arm).radii == pytest.approx(rod.radius)
    tip = Wrench(xi=1, force=(rod.force[0], 0, rod.force[1]), moment=(0, rod.couple, 0))
    at_rest = equilibrium(arm, Load(wrenches=(tip,)))
    assert at_rest.stable
    assert at_rest.residual < 1e-9
    assert all(touch.force > 0 and abs(touch.gap) < 1e-6 * arm.length for touch in at_rest.contacts)
    off = np.linalg.norm(at_rest.tip[[0, 2]] - found.tip) / arm.length
    return off, abs(sum(touch.force for touch in at_rest.contacts) / found.force - 1)


@pytest.mark.parametrize("thing", [POST, WALL, BALL, BOX], ids=lambda thing: thing.shape)
def test_gaps_change_as_their_derivatives_say(thing):
    """Places slide on both bodies, which the second derivative knows."""
    arm = Arm(objects=(replace(thing, mass=None),))
    plant = Plant(arm.alone, actuation="none")
    leaning = Leaning(Solver(plant), Surroundings(arm), arm.length * stations(arm))
    rng = np.random.default_rng(2)
    bends = 0.1 * np.cos(1.8 * np.pi * np.arange(24) / 24)  # towards it and away again
    start, way = np.stack([0.2 * bends, bends], 1).ravel() + 0.002 * rng.normal(size=48), rng.normal(size=48)

    def nearest(wanted, step):
        plant.data.qpos[:] = start + step * way
        plant.pose()
        leaning.look(1.0)
        near = min((one for one in leaning.nears if wanted(one.place)), key=lambda one: one.gap)
        return near, leaning.chain.slope(near)

    for wanted in (lambda place: place.first, lambda place: place is leaning.tube.ball):  # slides; is fixed
        near, slope = nearest(wanted, 0.0)
        second = leaning.chain.second(near, leaning.surroundings)
        (low, below), (high, above) = nearest(wanted, -1e-6), nearest(wanted, 1e-6)
        assert slope @ way == pytest.approx((high.gap - low.gap) / 2e-6, rel=1e-6)
        change = (above - below) / 2e-6
        np.testing.assert_allclose(second @ way, change, atol=1e-4 * abs(change).max())


def test_the_engine_comes_to_the_same_pose_without_friction_and_within_its_range_with_it():
    for friction in (0.0, 0.6):
        arm = Arm(gravity=HANGING, objects=(replace(POST, friction=friction),))
        at_rest = equilibrium(arm, TO_X)
        plant = Plant(arm, actuation="none", in_world=True)
        plant.data.xfrc_applied[plant.index.payload, :3] = (1.0, 0, 0)
        for _ in range(1000):
            mujoco.mj_step(plant.model, plant.data)
        off = np.linalg.norm(plant.tip - at_rest.tip)
        assert off < 1e-3 * arm.length
        assert off < 1e-4 * arm.length if friction == 0 else off < at_rest.friction_range
        assert (at_rest.friction_range == 0) == (friction == 0)


@pytest.mark.parametrize(("axis", "couple"), [((-1, 0, -0.2), 0.1), ((-1, 0, -0.8), -0.1)])
def test_a_tip_pressed_on_a_plane_rests_in_the_engine_where_statics_say(axis, couple):
    """The tip is the same ball in both: an edge would be off by 4 %, the tube's end by 0.1 %."""
    wall = replace(WALL, position=(0.13, 0, 0.25), axis=axis, friction=0.0)
    arm = Arm(gravity=HANGING, objects=(wall,))
    at_rest = equilibrium(arm, Load(wrenches=(Wrench(xi=1, force=(1.0, 0, 0), moment=(0, couple, 0)),)))
    plant = Plant(arm, actuation="none", in_world=True)
    plant.data.xfrc_applied[plant.index.payload] = (1.0, 0, 0, 0, couple, 0)
    for _ in range(2000):
        mujoco.mj_step(plant.model, plant.data)
    (touch,) = at_rest.contacts
    assert touch.station == arm.links
    assert 0.5 < -touch.normal @ plant.tip_rotation[:, 2] < 0.9  # oblique
    assert np.linalg.norm(plant.tip - at_rest.tip) < 1e-4 * arm.length


@pytest.mark.parametrize("things", [(POST,), (WALL,), (BALL,), (POST, WALL)], ids=lambda things: things[0].shape)
def test_the_tip_gives_way_by_its_compliance_while_contacts_stay_closed(things):
    arm = Arm(gravity=HANGING, objects=things)
    extra = 1e-4 * np.array([0.5, 0.7, -0.3])
    tips = [equilibrium(arm, Load(wrenches=(Wrench(xi=1, force=tuple(np.array([1.0, 0.05, 0]) + side * extra)),)))
            for side in (-1, 0, 1)]  # fmt: skip
    assert tips[1].contacts
    moved = tips[1].tip_compliance[:3, :3] @ (2 * extra)
    np.testing.assert_allclose(tips[2].tip - tips[0].tip, moved, atol=1e-4 * np.linalg.norm(moved))


def test_an_arm_that_touches_nothing_has_the_bits_of_the_arm_alone():
    arm = Arm(gravity=HANGING, objects=(replace(POST, position=(0.2, 0, 0.25)),))
    for load in (TO_X, Load(muscles=Muscles(kind="bend", values=(0.8, 2.0)))):
        among, alone = equilibrium(arm, load), equilibrium(arm.alone, load)
        assert among.contacts == ()
        assert among.friction_range is None
        for name in ("qpos", "frames", "tip_compliance", "muscle_tensions", "smallest_eigenvalue"):
            np.testing.assert_array_equal(getattr(among, name), getattr(alone, name))


def test_a_wall_holds_an_arm_that_would_buckle():
    """Upright, its weight is more than it carries: it leans, and that pose is stable for the wall alone."""
    arm = Arm(
        gravity=(0.0, 0.0, -9.81),
        bending_stiffness=0.04,
        objects=(replace(WALL, position=(0.08, 0, 0), axis=(-1, 0, 0)),),
    )
    at_rest = equilibrium(arm, Load(wrenches=(Wrench(xi=1, force=(0.02, 0, 0)),)))
    assert at_rest.stable
    assert [touch.object for touch in at_rest.contacts] == ["wall"]
    assert not equilibrium(arm.alone, Load(wrenches=(Wrench(xi=1, force=(0.02, 0, 0)),))).tip[0] < 0.1


def test_an_arm_that_lies_flat_on_a_wall_leans_where_it_is_pushed_to():
    """No moment is in it between two loads: the wall bears each load where it is."""
    arm = Arm(objects=(replace(WALL, position=(0.027, 0, 0), axis=(-1, 0, 0)),))
    pushed = (0.4, 0.6, 0.8)
    at_rest = equilibrium(arm, Load(wrenches=tuple(Wrench(xi=xi, force=(2.0, 0, 0)) for xi in pushed)))
    np.testing.assert_allclose([touch.xi for touch in at_rest.contacts[1:]], pushed[1:], atol=0.01)
    np.testing.assert_allclose([touch.force for touch in at_rest.contacts[1:]], 2.0, rtol=0.02)
    assert min(touch.gap for touch in at_rest.contacts) > -1e-6 * arm.length


def test_a_free_object_is_held_against_its_weight_and_the_arm():
    at_rest = equilibrium(Arm(gravity=HANGING, objects=(BALL,)), TO_X)
    (touch,), (held,) = at_rest.contacts, at_rest.held_objects
    np.testing.assert_allclose(held.force, touch.force * touch.normal - 0.1 * np.array(HANGING), atol=1e-12)


def test_an_arm_that_starts_inside_an_object_is_brought_clear_of_it_or_says_which():
    inside = replace(BALL, position=(0.02, 0, 0.25), radius=0.03)
    (touch,) = equilibrium(Arm(objects=(inside,))).contacts
    assert abs(touch.gap) < 1e-6
    with pytest.raises(EquilibriumError, match="object 'ball' overlaps the arm's base by 24 mm"):
        equilibrium(Arm(objects=(replace(inside, position=(0.02, 0, 0.0)),)))
    within = replace(BOX, size=(0.4, 0.4, 0.2), position=(0, 0, 0.2))
    with pytest.raises(EquilibriumError, match="overlaps object 'box' by"):
        equilibrium(Arm(objects=(within,)))


def test_what_it_does_not_know_is_refused():
    with pytest.raises(InputError, match="self_contact"):
        equilibrium(Arm(world=World(self_contact=True)))
    with pytest.raises(InputError, match="objects is post"):
        equilibria(Arm(objects=(POST,)), [TO_X, TO_X])


def test_the_command_says_what_the_arm_leans_on(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text(
        '[[object]]\nname = "post"\nshape = "cylinder"\nradius = 0.01\nlength = 0.4\nposition = [0.08, 0.0, 0.25]\n'
        'axis = [0.0, 1.0, 0.0]\n[[object]]\nname = "ball"\nshape = "sphere"\nradius = 0.02\nmass = 0.1\n'
        "position = [0.2, 0.0, 0.25]\n"
    )
    given = ["equilibrium", "--arm", str(file), "--gravity", "0", "0", "9.81", "--wrench", "1", "1", *("0" * 5)]
    said = CliRunner().invoke(cli, given)
    assert said.exit_code == 0, said.output
    assert "leans on post with 0.4084 N at 71.9 % of its length, at 70.5  0.0  253.1 mm" in said.output
    assert "friction coefficient of 0.8" in said.output
    assert "ball is held where it stands, by a force of 0  0  -0.981 N, its weight included" in said.output
    assert '"friction_range": 0.019' in CliRunner().invoke(cli, [*given, "--json"]).output


def test_an_arm_on_the_very_top_of_a_ball_slides_off_it():
    """The plane that it is pushed in is one of symmetry, and its pose there a saddle."""
    small = replace(BALL, radius=0.01, position=(0.08, 0.0, 0.29))
    at_rest = equilibrium(Arm(objects=(small,)), TO_X)
    assert at_rest.stable
    assert all(touch.normal[0] > 0 for touch in at_rest.contacts)  # it has gone round to the far side
