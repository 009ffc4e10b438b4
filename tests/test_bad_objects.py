"""Objects that cannot be: one short line each, exit code 2; nothing starts inside of anything, nothing is left out."""

import struct
from dataclasses import fields, replace
from itertools import count

import mujoco
import numpy as np
import pytest
from bad_inputs import HUGE, LONG, WRONG, damaged_at_random, refused, short
from references import along
from test_bad_flags import contarm

from contarm_sim import (
    Arm,
    Section,
    World,
    equilibria,
    excite,
    fit,
    poses_at_rest,
    presets,
    replay,
    simulate_many,
    spec,
    studies,
)
from contarm_sim.errors import InputError
from contarm_sim.identify.recordings.synthetic import recorded
from contarm_sim.mjcf import arm_spec, scene_spec
from contarm_sim.mjcf.overlaps import MOST, overlaps
from contarm_sim.mjcf.xml import write_models
from contarm_sim.model.arm_file import load_arm, load_objects
from contarm_sim.model.named import named_parameters, with_parameters
from contarm_sim.model.objects import MAX_OBJECTS, Object
from contarm_sim.motion.simulate import simulate
from contarm_sim.motion.time_step import Stepping
from contarm_sim.sweeps.reading import read
from contarm_sim.view.figures import figures_of

ARM = Arm(links=6)
SHELF = Object(name="shelf", shape="box", size=(0.1, 0.1, 0.02), position=(0.25, 0, 0.3))
BALL = Object(name="ball", shape="sphere", radius=0.02, mass=0.05, position=(0.25, 0, 0.265))
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def _stl(corners, faces=FACES):
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(corners[face]), 0) for face in faces)
    return bytes(80) + struct.pack("<I", len(faces)) + triangles


def _right(name, value):
    if name == "name":
        return False
    if name in ("axis", "orientation", "colour", "position", "size"):
        size = 4 if name == "orientation" else 3
        return isinstance(value, (list, tuple, range, np.ndarray)) and np.shape(np.array(value, dtype=object)) == (
            size,
        )
    return False


def test_constructors_and_tables(tmp_path):
    usual = {"name": "thing", "shape": "capsule", "radius": 0.01, "length": 0.1}
    cases = []
    for item in fields(Object):
        for value in [*WRONG, [1, "a", 2], [HUGE] * 3, -1.0]:
            if not _right(item.name, value):
                label = f"Object({item.name}={short(value)})"
                cases.append((label, lambda n=item.name, v=value: Object(**{**usual, n: v})))
    for value in WRONG:
        if not (isinstance(value, (list, tuple)) and not len(value)):
            cases.append((f"World(objects={short(value)})", lambda v=value: World(objects=v)))
        if not isinstance(value, bool):
            cases.append((f"World(self_contact={short(value)})", lambda v=value: World(self_contact=v)))
    file = tmp_path / "objects.toml"

    def load(content):
        file.write_bytes(content if isinstance(content, bytes) else content.encode())
        return load_objects(file)

    texts = [
        '""',
        '"x"',
        '"1 V"',
        "true",
        "nan",
        "inf",
        "1e300",
        "[]",
        '["1"]',
        "{}",
        "1979-05-27",
        f'"{LONG}"',
        "",
        "[1]",
    ]
    lines = "".join(f"{name} = {value!r}\n" for name, value in usual.items() if name != "radius").replace("'", '"')
    cases += [(f"radius = {x[:20]}", lambda x=x: load(f"[[object]]\n{lines}radius = {x}")) for x in texts]
    cases += [(f"object = {x[:20]}", lambda x=x: load(f"object = {x}")) for x in texts if x != "[]"]
    cases += [(key, lambda k=key: load(f"{k} = 1")) for key in ("links", "self_contact", '"a\\nb"')]
    number, failed = refused(cases)
    assert not failed, "\n".join(failed)
    assert number > 300
    good = f'[[object]]\n{lines}radius = "10 mm"\naxis = [0, 1.0, 0]\n'.encode()
    _, failed = refused(damaged_at_random(good, load, 200), made_by_chance=True)
    assert not failed, "\n".join(failed)


def test_meshes(tmp_path):
    files = (tmp_path / f"cup{number}.stl" for number in count())

    def made(content, scale=1.0):
        file = next(files)
        file.write_bytes(content)
        return arm_spec(
            Arm(links=2, objects=(Object(name="cup", shape="mesh", file=str(file), scale=scale),))
        ).compile()

    whole = _stl(0.05 * CORNERS)
    bad = {
        "empty": b"", "words": b"solid cup\n" * 20, "cut": whole[:-30], "flat": _stl(0.05 * CORNERS, FACES[:1]),
        "not a number": _stl(np.nan * CORNERS), "a point": _stl(1e-9 * CORNERS), "in micrometres": _stl(5e4 * CORNERS),
    }  # fmt: skip
    _, failed = refused((name, lambda c=content: made(c)) for name, content in bad.items())
    assert not failed, "\n".join(failed)
    with pytest.raises(InputError, match=r"not a binary STL.*allowed: a mesh, binary \.stl or \.obj"):
        made(b"solid cup\nfacet normal 0 0 0\n" * 20)
    with pytest.raises(InputError, match=r"object 'cup'.*50 m large.*millimetres\? Then scale = 0\.001"):
        made(_stl(50 * CORNERS))
    model = made(_stl(50 * CORNERS), scale=0.001)
    assert np.ptp(model.mesh_vert, axis=0).max() == pytest.approx(0.05, rel=0.5)
    _, failed = refused(damaged_at_random(whole, made, 60), made_by_chance=True)
    assert not failed, "\n".join(failed)


SHORT = replace(presets.two(), sections=(Section(length=0.2, links=2), Section(length=0.17, links=2)))


@pytest.mark.parametrize("arm", [Arm(links=2, self_contact=True), SHORT], ids=["one section", "two"])
def test_any_name_is_refused_or_makes_a_model_and_its_scene(arm):
    scene = scene_spec(arm)
    kinds = ("bodies", "geoms", "sites", "joints", "tendons", "actuators", "sensors", "cameras", "lights", "excludes")
    every = {each.name for kind in kinds for each in getattr(scene, kind)} | {"world", "itself", "scene_floor"}
    usable, made = [], []
    for name in sorted(every):
        try:
            usable.append(Object(name=name, shape="sphere", radius=0.02, mass=0.1, position=(1, 0, len(usable))))
            arm_spec(replace(arm, objects=(usable[-1],)))
        except InputError:
            usable = usable[: len(made)]
        else:
            made.append(name)
    assert {"floor", "column"} <= set(made)
    assert not {"base", "tip", "link_01", "section_1_link_01", "world", "itself"} & set(made)
    for first in range(0, len(usable), 30):
        some = tuple(usable[first : first + 30])
        assert scene_spec(replace(arm, objects=some)).compile().nbody >= len(some)


def test_what_starts_inside_of_something_is_refused_with_its_depth(tmp_path):
    circle, step = along(ARM, "circle", 0.1, max_bend=0.3), Stepping()
    post = Object(name="post", shape="cylinder", radius=0.01, length=0.4, axis=(0, 1, 0), position=(0.02, 0, 0.2))
    deep = Arm(links=6, objects=(post,))
    with pytest.raises(
        InputError, match=r"object 'post': position is \(0\.02, 0, 0\.2\) m.* mm deep in link_0\d; "
    ) as at:
        simulate(deep, along(ARM, "circle", 0.1, max_bend=0.01), stepping=step)
    told = float(str(at.value).split("puts it ")[1].split(" mm")[0])
    model = arm_spec(deep).compile()
    across = model.geom("link_03_collision").size[0] + 0.01 - 0.02  # radii, less the distance of the axes
    assert told == pytest.approx(1e3 * across, abs=1)
    with pytest.raises(InputError, match=r"where the arm is straight: move it, or make it smaller \(the") as built:
        write_models(deep, tmp_path)
    assert "begin with other bends" in str(at.value)
    assert " ... " not in str(at.value) + str(built.value)
    assert not list(tmp_path.iterdir())
    below = Object(name="floor", shape="plane", position=(0, 0, 0.5))  # faces +Z, away from the arm
    with pytest.raises(InputError, match=r"object 'floor'.*turn its axis around"):
        simulate(Arm(links=6, objects=(below,)), circle, stepping=step)
    assert simulate(Arm(links=6, objects=(replace(below, axis=(0, 0, -1)),)), circle, stepping=step)
    with pytest.raises(InputError, match=r"object 'ball'.* 5 mm deep in object 'shelf'"):
        simulate(Arm(links=6, objects=(SHELF, replace(BALL, position=(0.25, 0, 0.275)))), circle, stepping=step)
    touching = Arm(links=6, objects=(SHELF, replace(BALL, position=(0.25, 0, 0.27)), replace(SHELF, name="other")))
    found = simulate_many([ARM, deep, touching], circle, stepping=step)
    assert [isinstance(each, InputError) for each in found] == [False, True, False]


@pytest.mark.parametrize("seed", range(4))
def test_overlaps_of_random_balls_are_those_of_their_distances(seed):
    """A straight arm is a cylinder, balls are points with a radius."""
    random, arm = np.random.default_rng(seed), Arm(links=8)
    places = random.uniform((-0.08, -0.08, 0.08), (0.08, 0.08, 0.3), (MAX_OBJECTS, 3))
    radii = random.uniform(0.002, 0.05, MAX_OBJECTS)
    balls = [
        Object(name=f"ball{k}", shape="sphere", radius=radius, position=tuple(place))
        for k, (place, radius) in enumerate(zip(places, radii, strict=True))
    ]
    model = arm_spec(replace(arm, objects=tuple(balls))).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    deepest = {}
    for each in overlaps(model, data):
        deepest[each.body] = max(each.depth, deepest.get(each.body, 0))
    deep = model.geom("link_04_collision").size[0] + radii - np.hypot(places[:, 0], places[:, 1])
    expected = {ball.name: depth for ball, depth in zip(balls, deep, strict=True) if depth > MOST}
    assert 5 < len(expected) < MAX_OBJECTS
    assert deepest.keys() == expected.keys()
    assert [deepest[name] for name in expected] == pytest.approx(list(expected.values()), abs=1e-5)


def test_whatever_knows_no_objects_says_so():
    arm, circle = Arm(links=6, objects=(SHELF, BALL)), along(ARM, "circle", 0.1, max_bend=0.3)
    calls = {
        "rest": lambda: poses_at_rest(arm, circle),
        "many": lambda: equilibria(arm),
        "part": lambda: spec(arm),
        "finer": lambda: simulate(arm, circle, extrapolate=True),
        "recorded": lambda: recorded(arm, None, [], seed=0),
        "fit": lambda: fit(arm, [], ["mass"]),
        "replay": lambda: replay(arm, None),
        "excite": lambda: excite(arm, None, ["mass"]),
        "figures": lambda: figures_of(arm),
        "sweep": lambda: read({"arm": {"object": [{"name": "a", "shape": "plane"}]}, "vary": {"mass": [0.1]}}),
        "validate": lambda: studies.validate(arm),
        "trust": lambda: studies.trust(arm),
        "possibility": lambda: studies.possibility(arm),
        "stiffness": lambda: studies.stiffness(arm, [1, 0]),
        "hold": lambda: studies.hold(arm, [1, 0]),
        "release": lambda: studies.release(arm),
        "controllers": lambda: studies.compare_controllers(arm),
    }
    for name, call in calls.items():
        with pytest.raises(InputError, match="without contact; leave out --objects") as at:
            call()
        assert at.value.name == "objects", name
    with pytest.raises(InputError, match=r"shelf, ball.*arm\.alone"):
        poses_at_rest(arm, circle)
    with pytest.raises(InputError, match="self_contact is on"):
        poses_at_rest(Arm(links=6, self_contact=True), circle)


def test_numbers_of_objects_have_names():
    arm = Arm(links=6, objects=(SHELF, BALL))
    for name, one in named_parameters(arm).items():
        if name.startswith("object."):
            assert with_parameters(arm, {name: one.value(arm)}) == arm, name
    found = with_parameters(arm, {"object.ball.mass": 0.1, "object.shelf.position.x": 0.3, "object.shelf.size.z": 0.01})
    assert found.world.objects[1].mass == 0.1
    assert found.world.objects[0].position == (0.3, 0, 0.3)
    assert found.world.objects[0].size == (0.1, 0.1, 0.01)
    with pytest.raises(InputError, match=r"did you mean 'object\.ball\.mass'"):
        with_parameters(arm, {"object.bal.mass": 0.1})
    with pytest.raises(InputError, match="object 'ball'"):
        with_parameters(arm, {"object.ball.mass": -1.0})
    with pytest.raises(InputError, match="allowed: shelf is fixed, and has position, size, friction"):
        with_parameters(arm, {"object.shelf.mass": 0.1})
    with pytest.raises(InputError, match="allowed: ball has position, radius, mass, friction"):
        with_parameters(arm, {"object.ball.diameter": 0.1})


def test_the_command_line_takes_objects_and_refuses_them_in_one_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cup.stl").write_bytes(_stl(0.05 * CORNERS))
    objects = {
        "set": 'shape = "mesh"\nfile = "cup.stl"\nposition = [0.2, 0, 0.1]', "bare": 'shape = "box"',
        "in": 'shape = "sphere"\nradius = 0.05\nposition = [0, 0, 0.2]',
    }  # fmt: skip
    for name, lines in objects.items():
        (tmp_path / f"{name}.toml").write_text(f'[[object]]\nname = "{name}"\n{lines}\n')
    bad = [
        ["run", "--objects", "in.toml", "--links", "4"],
        ["run", "--objects", "bare.toml"],
        ["build", "--objects", "in.toml"],
        ["trust", "--objects", "set.toml"],
        ["stiffness", "--objects", "set.toml", "--gravity", "0", "0", "9.81"],
        ["fk", "--bend", "1", "0", "--objects", "no.toml"],
    ]
    for words in bad:
        code, out, err = contarm(words)
        assert (code, out, err.count("\n")) == (2, "", 1), (words, err)
    assert not (tmp_path / "runs").exists()
    code, out, err = contarm(["fk", "--bend", "1", "0", "--objects", "set.toml"])
    assert (code, err.strip().startswith("not looked at: set")) == (0, True)
    code, *_ = contarm(["build", "--arm", "in.toml", "--objects", "set.toml", "--self-contact", "--out", "x"])
    assert code == 2
    code, out, err = contarm(["build", "--objects", "set.toml", "--self-contact", "--links", "4", "--out", "built"])
    assert code == 0, err
    (tmp_path / "cup.stl").unlink()
    (tmp_path / "built").rename(tmp_path / "moved")
    arm = load_arm(tmp_path / "moved" / "arm.toml")
    assert arm.world.self_contact
    assert [each.name for each in arm.world.objects] == ["set"]
    for name in ("arm.xml", "scene.xml"):
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "moved" / name))
        assert model.nmesh == 1 + (name == "scene.xml")  # the cap of the tip
