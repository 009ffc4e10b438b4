"""What an arm can touch: declared, checked, written and read, and stepped in the engine."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from contarm_sim import Arm, simulate, simulate_many
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.mjcf import arm_spec, scene_spec
from contarm_sim.mjcf.scene import base_rotation
from contarm_sim.model.arm_file import arm_to_toml, load_arm
from contarm_sim.model.objects import MAX_OBJECTS, Object
from contarm_sim.model.presets import two
from contarm_sim.model.template import arm_template
from contarm_sim.model.world import World
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory

POST = Object(name="post", shape="cylinder", radius=0.01, length=0.4, axis=(0, 1, 0), position=(0.12, 0, 0.3))
BALL = Object(name="ball", shape="sphere", radius=0.02, mass=0.05, position=(0.1, 0.3, 0.3))


def _bending(most: float, seconds: float = 1.0) -> Reference:
    time = np.arange(0, seconds, 0.01)
    bend = np.stack([most * np.minimum(time / (0.6 * seconds), 1), 0 * time], axis=1)
    return Reference(time, shape.position(bend, Arm()), bend, (Arm().length,))


@pytest.fixture(scope="module")
def pressed() -> Trajectory:
    return simulate(Arm(objects=(POST, BALL)), _bending(1.0), stepping=Stepping())


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"shape": "box"}, "size"), ({"shape": "blob"}, "shape"), ({"shape": "sphere"}, "radius"),
        ({"shape": "sphere", "radius": 0.0}, "radius"), ({"shape": "capsule", "radius": 0.1}, "length"),
        ({"shape": "sphere", "radius": 0.1, "size": (1, 1, 1)}, "size"), ({"shape": "plane", "mass": 1.0}, "mass"),
        ({"shape": "box", "size": (1, 1, -1)}, "size"), ({"shape": "plane", "axis": (0, 0, 0)}, "axis"),
        ({"shape": "plane", "axis": (0, 0, 1), "orientation": (1, 0, 0, 0)}, "axis"),
        ({"shape": "sphere", "radius": 0.1, "friction": -1}, "friction"),
        ({"shape": "sphere", "radius": 0.1, "colour": (2, 0, 0)}, "colour"),
        ({"shape": "mesh", "file": "nothing.stl"}, "file"), ({"shape": "mesh", "file": "nothing.txt"}, "file"),
        ({"shape": "sphere", "radius": 0.1, "name": "two words"}, "name"),
        ({"shape": "sphere", "radius": 0.1, "scale": 2.0}, "scale"),
    ],
)  # fmt: skip
def test_an_object_that_cannot_be_is_refused_by_name(given, name):
    with pytest.raises(InputError) as refused:
        Object(**{"name": "thing", **given})
    assert refused.value.name == name
    assert "object" in str(refused.value)


def test_objects_of_one_name_too_many_or_with_a_name_of_the_arm_are_refused():
    with pytest.raises(InputError, match="object 'post'"):
        World(objects=(POST, replace(POST, radius=0.02)))
    with pytest.raises(InputError, match=f"at most {MAX_OBJECTS}"):
        World(objects=tuple(replace(BALL, name=f"ball{i}") for i in range(MAX_OBJECTS + 1)))
    with pytest.raises(InputError, match="parts of the arm"):
        arm_spec(Arm(objects=(replace(BALL, name="tip"),)))


@pytest.mark.parametrize("of", [Arm(), two()], ids=["one section", "two"])
def test_toml_and_template_give_the_same_world_back(of, tmp_path):
    arm = of.in_world(replace(of.world, objects=(POST, BALL), self_contact=True))
    for text in (arm_to_toml(arm), arm_template(arm)):
        (tmp_path / "arm.toml").write_text(text)
        assert load_arm(tmp_path / "arm.toml") == arm


def test_objects_are_given_with_units_and_errors_name_file_and_object(tmp_path):
    file = tmp_path / "arm.toml"
    file.write_text('[[object]]\nname = "post"\nshape = "sphere"\nradius = "20 mm"\nmass = "50 g"\n')
    (found,) = load_arm(file).world.objects
    assert (found.radius, found.mass) == pytest.approx((0.02, 0.05))
    file.write_text('[[object]]\nname = "post"\nshape = "sphere"\nradios = 1\n')
    with pytest.raises(InputError, match=r"arm\.toml: object 'post': key 'radios'.*radius"):
        load_arm(file)


def test_the_axis_of_an_object_is_its_own_z():
    for axis in [(0, 1, 0), (1, 2, 3), (0, 0, -1), (0, 0, 1)]:
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, np.array(replace(POST, axis=axis).quaternion))
        assert matrix.reshape(3, 3)[:, 2] == pytest.approx(np.array(axis) / np.linalg.norm(axis), abs=1e-12)


def test_a_scene_turns_objects_with_the_base():
    arm = Arm(gravity=(0, 0, 9.81), objects=(POST,))
    model = scene_spec(arm).compile()
    base, post = model.body("base").pos, model.body("post").pos
    assert post - base == pytest.approx(base_rotation(arm) @ np.array(POST.position), abs=1e-12)


def test_an_arm_with_a_far_object_moves_like_the_arm_alone():
    path, stepping = _bending(1.0, 0.3), Stepping()
    far = replace(POST, position=(5.0, 0, 0))
    near, alone = simulate(Arm(objects=(far,)), path, stepping=stepping), simulate(Arm(), path, stepping=stepping)
    assert near.stations == pytest.approx(alone.stations, abs=1e-13)  # another step of the same equation
    assert len(near.contacts) == 0
    assert alone.contacts is None


def test_contacts_are_the_engines_own_forces_and_push_the_arm_out(pressed):
    contacts = pressed.contacts.where(pressed.contacts.partner == 0)
    last = contacts.at(len(pressed) - 1)
    assert len(last)
    assert (last.normal_force > 0).all()
    plant = Plant(pressed.arm, in_world=True)
    plant.qpos[:] = pressed.qpos[-1]
    mujoco.mj_forward(plant.model, plant.data)
    seen = {plant.index.tip - 24 + int(station): depth for station, depth in zip(last.station, last.depth, strict=True)}
    post = plant.model.body("post").id
    bodies, depths = plant.model.geom_bodyid, {}
    for contact in plant.data.contact:
        pair = sorted((int(bodies[contact.geom1]), int(bodies[contact.geom2])))
        if post in pair:
            depths[next(body for body in pair if body != post)] = -contact.dist
    assert depths == pytest.approx(seen, abs=1e-12)
    away = last.point - np.array(POST.position)
    away[:, 1] = 0  # the post runs along Y
    assert (np.einsum("ci,ci->c", away, last.normal) > 0).all()


def test_contacts_are_where_the_link_is_also_without_force(pressed):
    contacts = pressed.contacts
    assert not contacts.force.any(axis=1).all()  # a link that leaves, or whose neighbour bears all
    away = np.linalg.norm(contacts.point - pressed.stations[contacts.sample, contacts.station], axis=1)
    assert away.max() < 1.5 * pressed.arm.contact_radii[0]


def test_the_sum_of_contact_forces_is_what_holds_a_free_object():
    shelf = Object(name="shelf", shape="box", size=(0.1, 0.1, 0.02), position=(0.2, 0, 0.3))
    cube = Object(name="cube", shape="box", size=(0.03, 0.03, 0.03), mass=0.04, position=(0.2, 0, 0.274))
    arm = Arm(gravity=(0, 0, 9.81), objects=(shelf, cube))
    run = simulate(arm, _bending(0.0, 0.5), stepping=Stepping())
    assert run.objects.shape == (50, 1, 7)
    assert run.objects[-1, 0, :3] == pytest.approx((0.2, 0, 0.275), abs=5e-4)  # it fell by a millimetre
    assert run.objects[-1, 0, 3:] == pytest.approx((1, 0, 0, 0), abs=1e-3)


def test_many_arms_have_the_contacts_of_each_alone(pressed):
    arm = pressed.arm
    many = list(simulate_many([arm] * 4, [pressed.reference] * 4, stepping=Stepping()))
    assert all(one == pressed for one in many)
    assert len(pressed.contacts)


def test_a_file_gives_contacts_and_objects_back(pressed, tmp_path):
    pressed.save(tmp_path / "run.npz")
    back = Trajectory.load(tmp_path / "run.npz")
    assert back == pressed
    assert back.contacts == pressed.contacts
    half = pressed.first(80)
    assert len(half.objects) == 80
    assert half.contacts == pressed.contacts.where(pressed.contacts.sample < 80)


def test_contacts_that_do_not_fit_are_refused(pressed):
    contacts = pressed.contacts
    with pytest.raises(InputError, match=r"contacts\.sample"):
        replace(contacts, sample=contacts.sample[::-1])
    with pytest.raises(InputError, match=r"contacts\.names"):
        replace(pressed, contacts=replace(contacts, names=("other", "thing")))
    with pytest.raises(InputError, match=r"contacts\.force"):
        Contacts(*([0],) * 3, point=[[0, 0, 0]], force=[[np.nan, 0, 0]], normal=[[0, 0, 1]], depth=[0], names=("a",))


def test_poses_at_rest_are_of_the_arm_alone_and_statics_refuse_objects_by_name():
    with pytest.raises(InputError, match="objects"):
        Arm(objects=(POST,)).refuse_objects("this is computed")
    assert Arm(objects=(POST,)).alone == Arm()
    Arm().refuse_objects("nothing")
