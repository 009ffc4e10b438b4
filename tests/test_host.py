"""An arm in a user's own MJCF: it moves there as it does alone, and leaves the rest of that world as it is."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from contarm_sim import Arm, Load, Muscles, arm_spec, equilibrium, scene_spec, simulate, simulate_many
from contarm_sim.cli.main import main
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.model.arm_file import arm_to_toml, load_arm
from contarm_sim.model.host import MOST_PARTNERS, Host
from contarm_sim.model.objects import Object
from contarm_sim.model.template import arm_template
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.statics.leaning.surroundings import Surroundings

CELL = """<mujoco model="cell">
  <compiler meshdir="meshes"/>
  <option timestep="0.0025" {option}/>
  <default><joint armature="0.3"/><default class="visual"><geom contype="0" conaffinity="0" group="4"/></default>
  </default>
  <asset><mesh name="wedge" file="wedge.obj"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="2 2 .1" condim="4" friction="0.7"/>
    <body name="cart" pos="0 0 0.8">
      <joint name="rail" type="slide" axis="1 0 0"/>
      <geom type="box" size=".1 .1 .02" pos="0 0 0.06" mass="1e5" conaffinity="0"/>
      <geom type="mesh" mesh="wedge" class="visual"/>
      <site name="mount" pos="0 0.1 0.02" euler="180 0 30"/>
      <body pos="0 0 0.2"><joint type="ball"/><geom size="0.01" contype="0" conaffinity="0"/></body>
    </body>
    <body name="box" pos="0.5 0.5 0.03"><freejoint/><geom type="box" size=".03 .03 .03"/></body>
    <body name="wall" pos="0 -3 1" euler="20 50 0"><site name="shelf" euler="0 10 70"/></body>
    {more}
  </worldbody>
  <actuator>
    <motor name="push" joint="rail" ctrlrange="-1e6 1e6"/>
    <general name="slow" joint="rail" dyntype="filter" dynprm="1" gainprm="0"/>
  </actuator>
  <sensor><jointpos name="where" joint="rail"/></sensor>
  <keyframe><key name="go" ctrl="{push} 0.5" qpos="0.25 1 0 0 0 0.5 0.5 0.03 1 0 0 0"/></keyframe>
</mujoco>"""
POST = '<body name="post" pos="-0.12 -3 .6"><geom size=".02 .4" type="cylinder"/></body>'
WEDGE = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
IMPLICIT = 'integrator="implicitfast"'


def _written(folder, name="cell", option="", more="", push=0.0):
    (folder / "meshes").mkdir(exist_ok=True)
    (folder / "meshes" / "wedge.obj").write_text(WEDGE)
    path = folder / f"{name}.xml"
    path.write_text(CELL.format(option=option, more=more, push=push))
    return str(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("host")


@pytest.fixture(scope="module")
def cell(folder):
    return _written(folder)


def _typed(monkeypatch, *words):
    """Return the exit code of a command."""
    monkeypatch.setattr("sys.argv", ["contarm", *words])
    with pytest.raises(SystemExit) as left:
        main()
    return left.value.code


def _swing(arm, seconds=0.5):
    time = np.arange(0, seconds, 0.01)
    return Reference.from_bends(np.stack([0.8 * np.sin(4 * time), 1 - np.cos(4 * time)], axis=1), arm, time=time)


def _still(arm, seconds):
    time = np.arange(0, seconds, 0.01)
    return Reference.from_bends(np.tile([0.4, 0.2], (len(time), 1)), arm, time=time)


@pytest.mark.parametrize("option", ["", IMPLICIT, "/><option><flag eulerdamp='disable'/></option><option"])
@pytest.mark.parametrize("controller", ["servo", "pressure"])
def test_an_arm_in_a_host_that_does_not_move_it_moves_as_it_does_alone(folder, option, controller):
    """Whatever the host's integrator and however it turns the base; its joints and actuators come before the arm's."""
    file = _written(folder, "still", option)
    arm = Arm(links=8, host=Host(file=file, site="shelf"))
    assert np.linalg.norm(arm.gravity) == pytest.approx(9.81)
    assert min(np.abs(arm.gravity)) > 0.1
    alone = Arm(links=8, gravity=arm.gravity)
    hosted, free = (simulate(each, _swing(each), controller, stepping=Stepping(0.001)) for each in (arm, alone))
    assert np.abs(hosted.stations - free.stations).max() < 1e-12
    assert np.abs(hosted.tip_rotation - free.tip_rotation).max() < 1e-11
    assert np.abs(hosted.muscle_tensions - free.muscle_tensions).max() < 1e-9
    assert np.allclose(hosted.setpoint, free.setpoint, rtol=1e-12)
    assert hosted.base is None


def test_a_base_on_a_cart_that_speeds_up_sags_as_under_tilted_gravity(folder):
    """In the frame of a base that accelerates by a, gravity is g - a: an equilibrium of the arm alone."""
    acceleration, seconds = 3.0, 1.5
    file = _written(folder, "pushed", IMPLICIT, push=acceleration * (1e5 + 0.3))
    arm = Arm(links=8, mass=0.3, damping_time=0.3, host=Host(file=file, site="mount"))
    moved = simulate(arm, _still(arm, seconds), "chain", stepping=Stepping(0.0025))
    way = moved.base[:, 0] - moved.base[0, 0]
    assert np.allclose(way, 0.5 * acceleration * moved.time**2, rtol=1e-4, atol=0.0025 * acceleration)
    assert moved.host.shape == (len(moved), 1 + 4 + 7)
    assert np.allclose(moved.host[:, 0], moved.base[:, 0])
    assert moved.host[0, 0] == 0.25  # the host's first keyframe
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, moved.base[0, 3:])
    gravity = turn.reshape(3, 3).T @ [-acceleration, 0.0, -9.81]
    held = Load(muscles=Muscles(kind="setpoints", values=tuple(moved.setpoint[-1])))
    tilted, upright = (equilibrium(Arm(links=8, mass=0.3, gravity=g), held) for g in (gravity, arm.gravity))
    sag = np.linalg.norm(tilted.tip - upright.tip)
    assert sag > 1e-3
    assert np.linalg.norm(moved.stations[-1] - tilted.frames[:, :3, 3], axis=-1).max() < 0.01 * sag
    assert np.linalg.norm(moved.stations[0] - upright.frames[:, :3, 3], axis=-1).max() < 1e-6


def test_bodies_options_actuators_and_what_they_are_set_to_stay_as_they_are(cell):
    arm = Arm(links=5, host=Host(file=cell, site="mount"), objects=(
        Object(name="ball", shape="sphere", radius=0.02, mass=0.1, position=(0, 0, 0.4)),
    ))  # fmt: skip
    before, after = mujoco.MjModel.from_xml_path(cell), arm_spec(arm, "pressures").compile()
    for name in ("gravity", "integrator", "cone", "solver", "disableflags", "impratio", "timestep"):
        assert np.array_equal(getattr(before.opt, name), getattr(after.opt, name)), name
    for kind, words in (
        ("body", "mass inertia pos quat"), ("joint", "damping armature axis"), ("geom", "friction condim size contype"),
        ("actuator", "gainprm ctrlrange dynprm"), ("sensor", "type"), ("key", "ctrl"),
    ):  # fmt: skip
        count = getattr(before, {"joint": "njnt", "actuator": "nu"}.get(kind, f"n{kind}"))
        for name in filter(None, (getattr(before, kind)(i).name for i in range(count))):
            for word in words.split():
                old, new = (getattr(getattr(each, kind)(name), word) for each in (before, after))
                assert np.array_equal(old, new[: len(old)]), (kind, name, word)
    plant = Plant(arm, actuation="pressures", in_world=True)
    control = np.linspace(1e5, 1.2e5, 3)
    plant.restart(np.full(10, 0.01), control)
    data, model = plant.data, plant.model
    assert data.joint("rail").qpos == 0.25
    assert data.ctrl[model.actuator("slow").id] == 0.5
    assert np.array_equal(plant.qpos, np.full(10, 0.01))
    assert np.array_equal(plant.pressure, [control, control])
    assert data.act[model.actuator("slow").actadr[0]] == 0.0
    assert np.allclose(plant.muscle_lengths, Plant(arm.alone, actuation="pressures").muscle_lengths, atol=1e-2)
    seen = data.sensordata[plant.index.poses].ravel()
    assert np.allclose(seen[:3], [0, 0, 0.4], atol=1e-12)  # objects are in the base frame at the start
    assert len(scene_spec(arm).cameras) == 3
    assert len(scene_spec(arm).lights) > 0


def test_what_it_touches_of_a_host_is_told_in_the_base_frame(folder):
    file = _written(
        folder, "post", more='<body name="post" pos="-0.12 -3 .6"><geom size=".02 .4" type="cylinder"/></body>'
    )
    host = Host(file=file, position=(0, -3, 1), orientation=(0, 1, 0, 0))
    arm = Arm(links=8, host=host)
    time = np.arange(0, 0.8, 0.01)
    bends = np.stack([-1.2 * np.minimum(time / 0.5, 1), 0 * time], axis=1)
    many = simulate_many([arm] * 4, Reference.from_bends(bends, arm, time=time), stepping=Stepping(0.0025))
    one = simulate(arm, Reference.from_bends(bends, arm, time=time), stepping=Stepping(0.0025))
    assert all(each == one for each in many)
    assert one.contacts.names == host.partners == ("world", "box", "post")
    assert len(one.contacts)
    assert set(one.contacts.partner.tolist()) == {2}
    assert np.all(one.contacts.normal[:, 0] > 0.9)
    assert np.all(one.contacts.force[:, 0] > 0)
    off = np.hypot(one.contacts.point[:, 0] + 0.12, one.contacts.point[:, 1]) - 0.02
    assert np.abs(off).max() < 2e-3
    one.save(folder / "one.npz")
    assert Trajectory.load(folder / "one.npz") == one


def test_an_arm_at_rest_leans_on_bodies_of_a_host_as_on_objects(folder):
    file = _written(folder, "leant", more=POST)
    post = Object(name="post", shape="cylinder", radius=0.02, length=0.8, position=(-0.12, 0, 0.4), friction=1.0)
    hosted = Arm(links=8, host=Host(file=file, position=(0, -3, 1), orientation=(0, 1, 0, 0)))
    pulled = Load(muscles=Muscles(kind="tensions", values=(5, 30, 30)))
    found, known = (equilibrium(arm, pulled) for arm in (hosted, Arm(links=8, gravity=hosted.gravity, objects=(post,))))
    assert np.allclose(found.tip, known.tip, atol=1e-9)
    assert known.contacts
    assert [touch.object for touch in found.contacts] == [touch.object for touch in known.contacts]
    forces = [[touch.force for touch in each.contacts] for each in (found, known)]
    assert np.allclose(*forces, rtol=1e-6)


@pytest.mark.parametrize(("geom", "friction"), [("friction='.2 .1 .1'", 1.0), ("friction='.2 .1 .1' priority='1'", 0.2),
                                                ("priority='1' condim='1'", 0.0)])  # fmt: skip
def test_friction_with_bodies_of_a_host_is_mixed_as_in_motion(folder, geom, friction):
    post = POST.replace('type="cylinder"', f'type="cylinder" {geom}')
    file = _written(folder, "rubbed", more=post)
    arm = Arm(links=8, host=Host(file=file, position=(0, -3, 1), orientation=(0, 1, 0, 0)))
    assert {each.friction for each in Surroundings(arm).objects if each.name == "post"} == {friction}
    assert not arm.world.host.read.holds


def test_the_body_that_holds_the_base_is_not_in_the_way_of_the_first_links(folder):
    """A plate at the base: capsules of the first links have round ends that reach into it."""
    box, site = '<geom type="box" size=".2 .2 .01" pos="0 0 .01"/>', '<site name="at" euler="180 0 0"/>'
    plate = f'<body name="plate" pos="0 -3 1">{box}{site}</body>'
    arm = Arm(links=24, host=Host(file=_written(folder, "plate", more=plate), site="at"))
    found = simulate(arm, _swing(arm, 0.1), stepping=Stepping(0.0025))
    assert not len(found.contacts)
    assert equilibrium(arm).contacts == ()


def test_environments_refuse_a_host(cell):
    from contarm_sim.envs.arms import as_arm

    with pytest.raises(InputError, match="world"):
        as_arm(Arm(host=Host(file=cell, site="mount")))


def test_a_host_of_many_bodies_is_one_partner(folder):
    more = "".join(f'<body name="b{i}" pos="{i} 9 1"><geom size=".1"/></body>' for i in range(MOST_PARTNERS))
    near = '<body name="near" pos="-0.12 -3 .6"><geom size=".02 .4" type="cylinder"/></body>'
    arm = Arm(links=8, host=Host(file=_written(folder, "many", more=more + near), position=(0, -3, 1),
                                 orientation=(0, 1, 0, 0)))  # fmt: skip
    time = np.arange(0, 0.5, 0.01)
    bends = np.stack([-2.4 * np.minimum(time, 0.5), 0 * time], axis=1)
    found = simulate(arm, Reference.from_bends(bends, arm, time=time), stepping=Stepping(0.0025)).contacts
    assert found.names == ("world",)
    assert len(found)
    assert np.all(found.force[:, 0] > 0)


def test_a_pose_in_a_body_is_where_a_site_would_be(folder):
    pose = 'pos="0.1 0.2 0.3" quat="0.6 0 0.8 0"'
    file = _written(
        folder, "posed", more=f'<body name="arm" euler="0 30 0" pos="1 2 3"><site name="here" {pose}/></body>'
    )
    by_site = Arm(links=4, host=Host(file=file, site="here"))
    by_pose = Arm(links=4, host=Host(file=file, body="arm", position=(0.1, 0.2, 0.3), orientation=(0.6, 0, 0.8, 0)))
    assert np.allclose(by_site.gravity, by_pose.gravity, atol=1e-9)
    tips = [Plant(arm, in_world=True) for arm in (by_site, by_pose)]
    alone = Plant(by_site.alone)
    alone.restart(np.full(8, 0.1), np.zeros(3))
    for plant, arm in zip(tips, (by_site, by_pose), strict=True):
        plant.restart(np.full(8, 0.1), np.zeros(3))
        assert np.allclose(plant.data.body("base").xpos, arm.world.host.base.position, atol=1e-12)
        for name in ("stations", "tip", "rotations", "muscle_paths"):  # in the base frame
            assert np.allclose(getattr(plant, name), getattr(alone, name), atol=1e-12, equal_nan=True), name


def test_arms_in_hosts_are_written_and_read(cell, folder):
    (folder / "arm.toml").write_text(
        'links = 5\n[world]\nfile = "cell.xml"\nbody = "cart"\nposition = ["1 cm", 0, 0]\n'
    )
    arm = load_arm(folder / "arm.toml")
    assert arm.world.host == Host(file=cell, body="cart", position=(0.01, 0, 0))
    for text in (arm_to_toml(arm), arm_template(arm)):
        (folder / "again.toml").write_text(text)
        assert load_arm(folder / "again.toml") == arm
    assert eval(repr(arm), {"Arm": Arm, "Host": Host}) == arm
    assert arm.alone == Arm(links=5, gravity=arm.gravity, base_orientation=arm.base_orientation)
    assert not any(arm.unloaded.gravity)
    with pytest.raises(InputError, match="gravity"):
        replace(arm, gravity=(0.0, 0.0, 9.81))


def _refusals(folder):
    cell = _written(folder)
    (folder / "bad.xml").write_text("<mujoco><worldbody><boddy/></worldbody></mujoco>")
    (folder / "text.xml").write_text("no MJCF")
    base = '<body name="base"><geom name="payload" size="1"/></body>'
    rescaled = _written(folder, "rescaled", '/><compiler settotalmass="3"/><option')
    return {
        "a site that it lacks": (["--world", cell, "--mount", "mout"], ["'mout'", "'mount'", "shelf"]),
        "no file": (["--world", str(folder / "none.xml")], ["not there"]),
        "no MJCF": (["--world", str(folder / "text.xml")], ["text.xml", "MuJoCo does not take"]),
        "not compiling": (["--world", str(folder / "bad.xml")], ["boddy"]),
        "names": (["--world", _written(folder, "taken", more=base), "--payload", "0.1"], ["body base", "geom payload"]),
        "integrator": (["--world", _written(folder, "rk4", 'integrator="RK4"')], ["RK4", "implicitfast"]),
        "gravity": (["--world", cell, "--gravity", "0", "0", "9.81"], ["gravity", "0 0 -9.81"]),
        "a mount without": (["--mount", "mount"], ["--world"]),
        "masses": (["--world", rescaled], ["settotalmass"]),
    }


@pytest.mark.parametrize("what", [
    "a site that it lacks", "no file", "no MJCF", "not compiling", "names", "integrator", "gravity", "a mount without",
    "masses",
])  # fmt: skip
def test_a_world_that_cannot_be_is_refused_in_one_line(what, folder, capsys, monkeypatch):
    monkeypatch.chdir(folder)
    words, said = _refusals(folder)[what]
    before = set(folder.iterdir())
    command = ["run", "--no-video", "--duration", "0.1"] if what == "masses" else ["build"]
    assert _typed(monkeypatch, *command, *words) == 2
    told = capsys.readouterr()
    assert not told.out
    assert told.err.count("\n") == 1
    assert all(word in told.err for word in said), told.err
    assert set(folder.iterdir()) == before


def test_build_writes_the_arm_in_its_world(folder, cell, capfd, monkeypatch, recwarn):
    monkeypatch.chdir(folder)
    assert _typed(monkeypatch, "build", "--world", cell, "--mount", "mount", "--out", "built") == 0
    arm = load_arm(folder / "built" / "arm.toml")
    for file, spec in (("arm.xml", arm_spec), ("scene.xml", scene_spec)):
        read, made = mujoco.MjModel.from_xml_path(str(folder / "built" / file)), spec(arm).compile()
        assert (read.nq, read.nu, read.nkey, read.nmesh) == (made.nq, made.nu, made.nkey, 1 + (file == "scene.xml"))
        for name in (
            "qpos0", "key_ctrl", "key_qpos", "body_mass", "dof_damping", "geom_contype", "geom_conaffinity",
            "geom_group", "actuator_biasprm", "tendon_damping", "tendon_armature", "geom_friction",
        ):  # fmt: skip
            assert np.allclose(getattr(read, name), getattr(made, name), rtol=1e-9), name
    assert not recwarn.list
    assert "prefix" not in capfd.readouterr().err
    assert not (folder / "MUJOCO_LOG.TXT").exists()
