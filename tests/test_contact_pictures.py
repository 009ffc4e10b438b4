"""What people see of objects and contact: pictures, films, figures, the page of a run, the live page."""

import struct
from dataclasses import replace
from unittest.mock import MagicMock

import mujoco
import numpy as np
import pytest

from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.mjcf import scene_spec
from contarm_sim.mjcf.scene import base_position, base_rotation
from contarm_sim.mjcf.surfaces import surface, turned
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Wrench
from contarm_sim.model.objects import Object
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.view.colours import CONTACT, rgb
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.things import Things
from contarm_sim.view.notebook.cards import html
from contarm_sim.view.rendering.cameras import extent
from contarm_sim.view.rendering.draw import ArmRenderer, Overlays
from contarm_sim.view.rendering.film_words import caption, legend, texts
from contarm_sim.view.rendering.look import Look, Scale
from contarm_sim.view.rendering.near import with_objects
from contarm_sim.view.rendering.touch import arrow_scale, scale_words
from contarm_sim.view.report.contact_figure import draw_contact
from contarm_sim.view.style import drawn

BARE = Overlays(path=False, trace=False, target=False, ghost=False, frames=False, contacts=False)
TOUCHING = replace(BARE, contacts=True)
POST = Object(
    name="post", shape="cylinder", radius=0.02, length=0.3, position=(0.12, 0, 0.28), axis=(0, 1, 0), colour=(0, 0.6, 0)
)
BALL = Object(name="ball", shape="sphere", radius=0.03, mass=0.1, position=(-0.15, 0, 0.40), colour=(0.9, 0.8, 0))
TABLE = Object(name="table", shape="plane", position=(0, 0, 0.43), axis=(0, 0, -1))


def hanging(*objects):
    return Arm(links=10, gravity=(0, 0, 9.81), objects=objects)


@pytest.fixture(scope="module")
def run():
    """Return a motion that presses against a post, beside a ball that rests on a table."""
    arm = hanging(POST, BALL, TABLE)
    bend = np.stack([np.linspace(0, 1.4, 81), np.zeros(81)], axis=1)
    found = simulate(arm, Reference.from_bends(bend, arm, 0.01 * np.arange(81)), "servo")
    assert len(found.contacts.at(80))
    return found


def tetrahedron(path, corners):
    """Write the STL of a tetrahedron whose corners, shape (4, 3), turn to the right."""
    faces = [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]
    parts = [struct.pack("<12fH", 0, 0, 0, *corners[list(face)].ravel(), 0) for face in faces]
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + b"".join(parts))
    return str(path)


def volume(vertices, faces):
    """Return the volume within triangles that face outwards, and its middle."""
    a, b, c = vertices[faces].swapaxes(0, 1)
    parts = np.einsum("fi,fi->f", a, np.cross(b, c)) / 6
    return parts.sum(), (parts[:, None] * (a + b + c)).sum(axis=0) / 4 / parts.sum()


def test_surfaces_face_outwards_and_enclose_what_the_shapes_do(tmp_path):
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]]) * 10 + [50, 20, 0]
    stone = Object(name="stone", shape="mesh", file=tetrahedron(tmp_path / "a.stl", corners), scale=1e-3)
    for each, size, middle in (
        (Object(name="a", shape="box", size=(0.1, 0.2, 0.3)), 0.006, 0),
        (Object(name="a", shape="sphere", radius=0.1), 4 / 3 * np.pi * 1e-3, 0),
        (Object(name="a", shape="cylinder", radius=0.1, length=0.4), np.pi * 4e-3, 0),
        (Object(name="a", shape="capsule", radius=0.1, length=0.4), np.pi * (4e-3 + 4 / 3 * 1e-3), 0),
        (stone, 8 / 3 * 1e-6, [0.05, 0.02, 0]),
    ):
        found, place = volume(*surface(each))
        assert found == pytest.approx(size, rel=0.03)
        np.testing.assert_allclose(place, np.zeros(3) + middle, atol=1e-6)


def test_a_level_plane_is_the_floor_and_a_wall_stands_on_it():
    wall = Object(name="wall", shape="plane", position=(-0.3, 0.1, 0), axis=(1, 0, 0))
    arm = hanging(TABLE, wall)
    model = scene_spec(arm).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert base_position(arm)[2] == pytest.approx(0.43)
    assert data.geom("table").xpos[2] == pytest.approx(data.geom("floor").xpos[2])
    assert model.geom("table").rgba[3] == 0
    assert model.geom("floor").contype == 0
    own, turn = data.geom("wall"), base_rotation(arm)
    np.testing.assert_allclose(own.xmat.reshape(3, 3)[:, 2], turn @ [1, 0, 0], atol=1e-12)
    assert (own.xpos - base_position(arm)) @ turn @ [1, 0, 0] == pytest.approx(-0.3)
    lowest = own.xpos[2] - model.geom("wall").size[1] * abs(own.xmat.reshape(3, 3)[2, 1])
    assert lowest == pytest.approx(0, abs=1e-9)


def test_a_tip_that_is_pressed_on_a_wall_obliquely_is_drawn_outside_it():
    """Its plate would be inside the wall by 0.4 of its radius; only what touches is within 0.1 mm of it."""
    wall = Object(name="wall", shape="plane", position=(0.13, 0, 0.25), axis=(-1, 0, -0.8), friction=0.0)
    arm = hanging(wall)
    at_rest = equilibrium(arm, Load(wrenches=(Wrench(xi=1, force=(1.0, 0, 0)),)))
    assert [touch.station for touch in at_rest.contacts] == [arm.links]
    model = scene_spec(arm).compile()
    data = mujoco.MjData(model)
    data.qpos[:] = at_rest.qpos
    mujoco.mj_forward(model, data)

    def gaps(points):
        return ((points - base_position(arm)) @ base_rotation(arm) - wall.position) @ turned(wall)[:, 2]

    for geom in range(model.ngeom):
        own, middle, turn = model.geom(geom), data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
        if model.geom_bodyid[geom] == 0 or own.group == 3 or own.name == wall.name:
            continue
        first, count = model.mesh_vertadr[own.dataid[0]], model.mesh_vertnum[own.dataid[0]]
        points = model.mesh_vert[first : first + count] if own.dataid[0] >= 0 else _outside(own)
        least = gaps(middle + points @ turn.T).min()
        assert least > (-1e-5 if own.name == "nose" else 0)
        assert own.name != "nose" or least < 1e-4
    with ArmRenderer(arm, 64, 48) as renderer:
        renderer.pose(at_rest.qpos)
        seen = renderer._renderer.scene.skinvert.reshape(-1, 3)
    assert gaps(seen[seen.any(axis=1)]).min() > 0


def _outside(geom):
    """Return points of the outside of a capsule or cylinder, in its frame, shape (P, 3)."""
    turn = np.linspace(0, 2 * np.pi, 48)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1) * geom.size[0]
    ends = [ring + np.array([0, 0, side * geom.size[1]]) for side in (-1, 1)]
    if geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE:
        tilted = ring[:, [0, 2, 1]]
        ends += [tilted + np.array([0, 0, side * geom.size[1]]) for side in (-1, 1)]
    return np.concatenate(ends)


def test_arms_without_objects_keep_their_plate():
    assert scene_spec(hanging()).geom("nose") is None
    assert not scene_spec(hanging()).meshes


def test_objects_below_the_reach_stand_on_the_floor_and_names_of_the_scene_are_free():
    low = Object(name="floor", shape="box", size=(0.1, 0.1, 0.1), position=(0.3, 0, 0.5))
    arm = hanging(low, replace(BALL, name="column"), replace(POST, name="shadow"))
    assert base_position(arm)[2] == pytest.approx(0.55)
    assert scene_spec(arm).compile().geom("scene/floor").contype == 0
    with ArmRenderer(arm, 64, 48, "top") as renderer:
        assert renderer.pose(np.zeros(20)).shape == (48, 64, 3)
    assert base_position(hanging())[2] == base_position(hanging(replace(low, position=(0, 0, 5))))[2]


def test_a_camera_shows_objects_near_the_arm_but_none_far_off(run):
    bare = extent(replace(run, arm=hanging(TABLE), contacts=None, objects=None))
    seen = extent(run)
    assert seen[:, 1].max() == pytest.approx(0.25 * run.arm.length, rel=1e-3)  # some of the post
    assert seen[:, 0].min() == pytest.approx(-0.18, abs=1e-3)  # all of the ball
    far = hanging(replace(POST, position=(3, 0, 0)), replace(POST, name="long", length=9.0))
    room = 0.25 * far.length
    assert np.all(np.ptp(with_objects(bare, far), axis=0) <= np.ptp(bare, axis=0) + 2 * room + 1e-9)


def pink(image):
    """Return which pixels have about the colour of contact, in whatever light."""
    red, green, blue = np.moveaxis(image, 2, 0)
    return (red > 150) & (green < 0.5 * red) & (blue > 0.45 * red) & (blue < red)


@pytest.fixture(scope="module")
def pictures(run):
    """Return pictures of the last sample, with and without contact, and of the ball elsewhere; and where it touches."""
    objects = run.objects.copy()
    objects[80, 0, :3] += [0.1, 0, -0.2]
    with ArmRenderer(run.arm, 240, 180, seen=extent(run)) as renderer:
        plain, touching = (renderer.frame(run, 80, overlays).astype(int) for overlays in (BARE, TOUCHING))
        eye, other = renderer._renderer.scene.camera
        point = renderer.to_world(run.contacts.at(80).point[0]) - 0.5 * (eye.pos + other.pos)
        right = np.cross(eye.forward, eye.up)
        half = eye.frustum_top / eye.frustum_near
        place = np.array([point @ right, -(point @ eye.up)]) / (point @ eye.forward) / half * 90 + [120, 90]
        moved = renderer.frame(replace(run, objects=objects), 80, BARE).astype(int)
    return plain, touching, moved, place


def test_links_that_touch_are_lit_and_forces_begin_where_they_act(pictures):
    plain, touching, _, place = pictures
    assert pink(255 * np.array(rgb(CONTACT))[None, None])
    changed = np.abs(touching - plain).max(axis=2) > 60
    assert np.count_nonzero(pink(touching) & changed) > 25
    rows, columns = np.nonzero(changed)
    assert np.hypot(columns - place[0], rows - place[1]).min() < 2
    assert changed.sum() < 0.02 * changed.size


def test_objects_are_drawn_and_free_ones_move(pictures):
    plain, _, moved, _ = pictures
    yellow = [np.argwhere((p[..., 0] > 140) & (p[..., 1] > 110) & (p[..., 2] < 70)) for p in (plain, moved)]
    assert min(map(len, yellow)) > 60
    before, after = (found.mean(axis=0) for found in yellow)
    assert after[1] > before[1] + 8  # to the right
    assert after[0] < before[0] - 20  # and up
    assert np.count_nonzero((plain[..., 1] > 90) & (plain[..., 0] < 60) & (plain[..., 2] < 60)) > 200  # the post


def test_captions_tell_of_contact_where_something_can_be_touched(run):
    scale = Scale.of(run)
    said = texts(run, [0, 80], "", 1.0)
    assert "no contact" in said[0]
    found = run.contacts.at(80)
    net = np.linalg.norm(found.force.sum(axis=0))
    words = next(text for text in said[1] if text.startswith("contact: "))
    assert f"net {net:.1f} N, {1e3 * found.depth.max():.2f} mm deep" in words
    assert f"contact force, {scale_words(scale.newton)}" in legend(Overlays(), scale)
    assert caption(Look(), [said], scale, [""]).height > 0
    bare = replace(run, arm=hanging(), contacts=None, objects=None)
    assert Scale.of(bare).newton == 0
    assert not any("contact" in text for text in texts(bare, [80], "", 1.0)[0])


@pytest.mark.parametrize(("force", "words"), [(6.0, "1 N = 10 mm"), (80.0, "1 N = 1 mm"), (2e4, "1000 N = 5 mm")])
def test_arrows_have_a_round_scale(force, words):
    assert scale_words(arrow_scale(force, 0.37)) == words


def test_the_figure_of_contact_has_each_object_and_each_link(run):
    sheet = drawn(lambda sheet: draw_contact(sheet, run))
    force, depth, links, _ = sheet.axes
    assert [line.get_label() for line in force.lines] == ["post"]
    np.testing.assert_allclose(force.lines[0].get_ydata()[80], np.linalg.norm(run.contacts.at(80).force.sum(axis=0)))
    assert depth.lines[0].get_ydata().max() == pytest.approx(1e3 * run.contacts.depth.max())
    drawn_map = links.collections[0].get_array()
    touched = np.flatnonzero(~np.ma.getmaskarray(drawn_map).all(axis=1))
    assert touched.tolist() == np.unique(run.contacts.station).tolist()
    assert "post" in html(run)


def test_the_live_arm_touches_things_moves_them_and_puts_them_back():
    table, ball = replace(TABLE, position=(0, 0, 0.39)), replace(BALL, position=(0.065, 0, 0.36))
    session = Session(hanging(table, ball, POST))
    server = MagicMock()
    for add in ("add_batched_meshes_simple", "add_icosphere"):
        getattr(server.scene, add).side_effect = lambda *_, **given: MagicMock(**given)
    things = Things(server, session.arm, "/arm")
    begun = session.poses.copy()
    session.record()
    session.aim(np.array([1.4, 0.0]))
    most = 0.0
    for _ in range(90):
        session.tick()
        most = max(most, session.reading.contact)
    things.show(session.poses, session.contacts)
    arrows, points = things._marks
    assert np.count_nonzero(points.batched_scales[:, 0] > 1e-6) == len(session.contacts)
    np.testing.assert_allclose(
        np.sort(arrows.batched_scales[:, 2])[-len(session.contacts) :],
        np.sort(things.scale * np.linalg.norm(session.contacts.force, axis=1)), rtol=1e-5,
    )  # fmt: skip
    np.testing.assert_allclose(things._free[0].position, session.poses[0, :3])
    recorded = session.recording.trajectory()
    assert recorded.contacts.total(len(recorded)).max() == pytest.approx(most)
    assert np.linalg.norm(session.poses[0, :3] - begun[0, :3]) > 0.005
    session.reset()
    np.testing.assert_allclose(session.poses, begun, atol=1e-9)
    assert Session(hanging()).contacts is None


def test_recordings_that_follow_one_another_join(run):
    parts = [run.contacts.first(30), run.contacts.where(run.contacts.sample >= 30)]
    later = replace(parts[1], sample=parts[1].sample - 30)
    assert Contacts.joined([parts[0], later], [30, 51]) == run.contacts
