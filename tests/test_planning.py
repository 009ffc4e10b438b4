"""Poses and courses that avoid: clear by brute force that shares no code with them, found wherever there are any."""

import json
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from obstructed import arcs, clearances, distances, scene, solvable

from contarm_sim import paths, planning, presets
from contarm_sim.errors import BlockedError, InputError, UnreachableError
from contarm_sim.kinematics import inverse
from contarm_sim.mechanics import shape
from contarm_sim.model.objects import Object

POST = Object(name="post", shape="cylinder", radius=0.012, length=0.5, position=(0.11, 0.03, 0.15))
BEHIND = (0.2, 0.08, 0.15)
CUBE = "\n".join(f"v {x} {y} {z}" for x in (-20, 20) for y in (-30, 30) for z in (-50, 50)) + "\n" + "\n".join(
    f"f {a} {b} {c}" for a, b, c in ((1, 2, 3), (2, 4, 3), (5, 7, 6), (6, 7, 8), (1, 5, 2), (2, 5, 6), (3, 4, 7),
                                     (4, 8, 7), (1, 3, 5), (3, 7, 5), (2, 6, 4), (4, 6, 8))
)  # fmt: skip
SHAPES = {
    "box": {"size": (0.04, 0.06, 0.1)},
    "sphere": {"radius": 0.03},
    "capsule": {"radius": 0.02, "length": 0.1},
    "cylinder": {"radius": 0.02, "length": 0.1},
    "plane": {},
}


def among(*objects, arm=None):
    """Return an arm of two sections with objects around it."""
    arm = presets.two() if arm is None else arm
    return replace(arm, world=replace(arm.world, objects=objects))


def random_bends(rng, arm, count):
    limits = np.array(shape.backbone(arm).limits)
    angle, plane = rng.uniform(0, limits, (count, len(limits))), rng.uniform(-np.pi, np.pi, (count, len(limits)))
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)


@pytest.mark.parametrize("kind", SHAPES)
def test_clearance_is_that_of_densely_sampled_arcs_and_never_more(kind):
    rng = np.random.default_rng(3)
    turn = {"axis": (-1, 0.2, 0.3)} if kind == "plane" else {"orientation": tuple(rng.normal(size=4))}
    arm = among(Object(name="it", shape=kind, position=(0.15, 0.08, 0.2), **SHAPES[kind], **turn))
    clearance, bends = planning.Clearance(arm), random_bends(rng, arm, 25)
    found = [clearance.nearest(each) for each in bends]
    truth = clearances(bends, arm, 1000)
    said = np.array([each.clearance for each in found])
    outside = truth > -0.02  # brute force says 0 inside of objects
    assert outside.sum() > 10
    assert np.all(said[outside] <= truth[outside] + 1e-6)
    assert np.all(said[outside] >= truth[outside] - 1.5e-4)
    for each, pose in ((found[k], bends[k]) for k in np.flatnonzero(truth > 0)):
        place = shape.position(pose.reshape(-1), arm, each.xi)
        assert np.linalg.norm(place - each.place) < 2e-4
        assert abs(distances(np.array(each.point), arm.world.objects)) < 1e-4
        assert (
            abs(np.linalg.norm(np.subtract(each.point, each.place)) - max(arm.contact_radii) - each.clearance) < 1.2e-3
        )


def test_a_mesh_is_its_hull_for_rough_and_for_exact_clearances(tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    place = {"position": (0.15, 0.08, 0.2), "axis": (1, 2, 3)}
    boxed = planning.Clearance(among(Object(name="it", shape="box", size=(0.04, 0.06, 0.1), **place)))
    file = str(tmp_path / "cube.obj")
    meshed = planning.Clearance(among(Object(name="it", shape="mesh", file=file, scale=0.001, **place)))
    bends = random_bends(np.random.default_rng(1), boxed.arm, 60)
    rough = boxed.rough(bends, 0.05)
    near = (rough > -0.02) & (rough < 0.05)
    assert near.sum() > 5
    np.testing.assert_allclose(meshed.rough(bends, 0.05)[near], rough[near], atol=2e-6)
    assert np.all(meshed.rough(bends, 0.05)[rough >= 0.05] >= 0.05)
    for pose in bends[:10]:
        assert meshed.nearest(pose).clearance == pytest.approx(boxed.nearest(pose).clearance, abs=2e-6)


def test_a_mesh_that_is_written_again_is_measured_again(tmp_path):
    """Moved nearer by 10 mm in the same words, so that the file's size stays."""
    file, words = tmp_path / "cube.obj", CUBE.replace("v -20", "v -30").replace("v 20", "v 10")
    file.write_text(CUBE)
    arm = among(Object(name="it", shape="mesh", file=str(file), scale=0.001, position=(0.2, 0, 0.2)))
    target = shape.position(np.array([0.2, 0, 0.2, 0]), arm)
    said = []
    for changed, text in ((1, CUBE), (2, words)):
        file.write_text(text)
        os.utime(file, (changed, changed))
        said.append(planning.avoid(arm, target, margin=0).clearance)
    assert said[0] - said[1] == pytest.approx(0.01, abs=2e-3)


def test_threads_that_ask_the_same_clearance_do_not_disturb_one_another():
    arm = among(Object(name="it", shape="cylinder", radius=0.02, length=0.1, position=(0.15, 0.08, 0.2)))
    clearance, bends = planning.Clearance(arm), random_bends(np.random.default_rng(5), arm, 150)
    alone, every = [clearance.nearest(each) for each in bends], sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as threads:
            assert all(found == alone for found in threads.map(lambda _: [*map(clearance.nearest, bends)], range(4)))
    finally:
        sys.setswitchinterval(every)


def test_an_arm_that_can_touch_itself_is_refused():
    arm = among(POST)
    with pytest.raises(InputError, match="self_contact"):
        planning.avoid(replace(arm, world=replace(arm.world, self_contact=True)), BEHIND)


def solve(numbers):
    """Return scenes by their numbers, what `avoid` finds in each or None, and the time of each."""
    out = []
    for number in numbers:
        arm, target = scene(number)
        start = time.process_time()
        try:
            found = planning.avoid(arm, target)
        except BlockedError:
            found = None
        out.append((arm, target, found, time.process_time() - start))
    return out


def check(solved, points, least_share):
    lost, clear = [], 0
    for arm, target, found, _ in solved:
        margin = planning.default_margin(arm)
        if found is None:
            lost += [target] if solvable(arm, target, margin, points) else []
            continue
        clear += 1
        least = clearances(found.bends[None], arm, 2000)[0]
        assert least >= margin
        assert found.clearance <= least + 1e-6
        assert np.linalg.norm(arcs(found.bends[None], arm)[0, -1] - target) < 1e-9
    assert clear >= least_share * (clear + len(lost)), lost


@pytest.fixture(scope="module")
def scenes():
    return solve(range(30))


def test_every_pose_is_clear_and_what_can_be_solved_is(scenes):
    avoided = [found for *_, found, _ in scenes if found is not None and found.looked > 1]
    assert len(avoided) >= 8
    assert sum(found is None for *_, found, _ in scenes) >= 5
    check(scenes, 250, 0.98)


@pytest.mark.slow
def test_a_thousand_scenes():
    solved = solve(range(1000))
    assert np.median([taken for *_, taken in solved]) <= 0.020
    check(solved, 1500, 0.98)


def test_without_need_the_pose_is_that_of_plain_inverse_kinematics():
    arm = among(replace(POST, position=(-0.3, 0.1, 0.1)))
    for choose in ("least-bend", "farthest"):
        found = planning.avoid(arm, BEHIND, choose=choose)
        np.testing.assert_array_equal(found.bends, inverse.solve(BEHIND, shape.backbone(arm), choose=choose).bends)
        assert found.looked == 1


def test_around_a_post_the_least_bent_of_the_clear_poses_is_chosen():
    arm = among(POST)
    found, (loop,) = planning.avoid(arm, BEHIND), planning.solutions(arm, BEHIND, points=200)
    bends, clear = loop
    total = np.linalg.norm(bends, axis=-1).sum(axis=-1)
    assert clearances(inverse.solve(BEHIND, shape.backbone(arm)).bends[None], arm)[0] < 0
    assert np.linalg.norm(found.bends, axis=-1).sum() <= total[clear >= found.margin].min() + 0.02
    near = planning.avoid(arm, BEHIND, near=bends[clear.argmax()])
    assert np.linalg.norm(near.bends - bends[clear.argmax()]) < 1e-3


def test_a_slit_between_samples_is_found():
    """Only one stretch of 2 mm of the loop, at a place between its samples, is clear: bars are set around its pose."""
    arm = presets.two()
    (loop,) = inverse.solve_all(BEHIND, shape.backbone(arm), points=700)
    pose = loop[103]
    line = arcs(pose[None], arm, 60)[0]
    along = line[61] - line[59]
    along /= np.linalg.norm(along)
    side = np.cross(along, arcs(loop[[123]], arm, 60)[0, 60] - line[60])
    side /= np.linalg.norm(side)
    across = np.cross(side, along)
    thick, gap = 0.01, max(arm.contact_radii) + 0.0103
    bars = [
        Object(name=name, shape="cylinder", radius=thick, length=0.3, axis=tuple(side),
               position=tuple(line[60] + sign * (gap + thick) * across))
        for name, sign in (("low", 1), ("high", -1))
    ]  # fmt: skip
    found = planning.avoid(among(*bars), BEHIND, margin=0.01)
    assert clearances(found.bends[None], among(*bars), 2000)[0] >= 0.01


@pytest.mark.parametrize(
    ("objects", "target", "margin", "error", "words"),
    [
        ((), BEHIND, None, InputError, "objects"),
        ((POST,), BEHIND, -0.001, InputError, "margin"),
        ((POST,), BEHIND, "wide", InputError, "margin"),
        ((POST,), (0.11, 0.035, 0.2), None, InputError, "7 mm inside of 'post'"),
        ((POST,), (0.3, 0.3, 0.3), None, UnreachableError, "out of reach"),
        ((replace(POST, position=(0.21, 0.08, 0.15)),), (0.18, 0.08, 0.15), None, BlockedError, "the target is 18 mm"),
        ((replace(POST, position=(0.03, 0, 0)),), BEHIND, None, BlockedError, "the base is 18 mm from 'post'"),
        ((replace(POST, radius=0.06),), BEHIND, None, BlockedError, "from end to end"),
    ],
)
def test_what_cannot_be_is_said_in_a_line(objects, target, margin, error, words):
    with pytest.raises(error, match=words) as caught:
        planning.avoid(among(*objects), target, margin)
    assert "\n" not in str(caught.value)
    if error is BlockedError:
        assert caught.value.object == "post"
        assert caught.value.clearance < caught.value.margin


def test_one_section_has_one_pose():
    arm, target = presets.paper(), shape.position([1.2, 0.0], presets.paper())
    assert planning.avoid(among(replace(POST, position=(0, 0.2, 0.2)), arm=arm), target).looked == 1
    with pytest.raises(BlockedError, match="the one pose that reaches"):
        planning.avoid(among(replace(POST, position=(0.06, 0, 0.2), axis=(0, 1, 0)), arm=arm), target)


def test_three_sections_avoid_with_and_without_a_direction():
    plain = presets.three()
    target, direction = (0.2, 0.1, 0.35), (1.0, 0.0, 0.3)
    for turn in (None, direction):
        bends = inverse.solve(target, shape.backbone(plain), turn).bends
        middle = shape.position(bends.reshape(-1), plain, 0.45)
        arm = among(replace(POST, position=tuple(middle), axis=(0.3, 1, 0.2), length=0.2), arm=plain)
        found = planning.avoid(arm, target, direction=turn)
        assert found.looked > 1
        assert clearances(bends[None], arm)[0] < 0 < found.margin <= clearances(found.bends[None], arm, 1000)[0]
        tip = shape.transform(found.bends.reshape(-1), arm)
        np.testing.assert_allclose(tip[:3, 3], target, atol=1e-9)
        if turn:
            np.testing.assert_allclose(tip[:3, 2], turn / np.linalg.norm(turn), atol=1e-8)


def test_a_course_follows_its_targets_clear_and_without_a_jump():
    arm = among(replace(POST, axis=(0.2, 1, 0.3), length=0.15, position=(0.08, 0.0, 0.19)))
    angle = np.linspace(0, 2 * np.pi, 101)
    target = np.stack([0.185 * np.cos(angle), 0.185 * np.sin(angle), 0.222 + 0 * angle], axis=-1)
    plain = inverse.track(target, shape.backbone(arm)).bends
    assert clearances(plain, arm).min() < 0
    course = planning.avoid_along(arm, target, margin=0.005)
    assert clearances(course.bends, arm, 600).min() >= 0.005
    assert np.all(course.clearance <= clearances(course.bends, arm, 600) + 1e-6)
    np.testing.assert_allclose(arcs(course.bends, arm)[:, -1], target, atol=1e-9)
    steps = np.linalg.norm(np.diff(course.bends, axis=0), axis=(-1, -2))
    assert steps.max() < 4 * steps.mean()
    assert steps.max() < 0.35
    assert np.array_equal(course.reference(arm, np.linspace(0, 5, 101)).bends, course.bends)
    again = planning.avoid_along(arm, target[:20], margin=0.005, start=course.bends[0] + 0.01)
    assert np.linalg.norm(again.bends[0] - course.bends[0]) < 0.05


def test_a_reference_along_a_path_keeps_clear_and_a_wall_across_it_is_named():
    path = paths.named("line", presets.two().length, duration=2)
    _, target = path.targets(20)
    arm = among(Object(name="wall", shape="plane", position=(0, 0, 0.45), axis=(0, 0, -1)))
    reference = planning.reference(path, arm, 0.01, 20)
    np.testing.assert_allclose(reference.target, target)
    assert clearances(reference.bends, arm, 400).min() >= 0.01
    middle = tuple(target[len(target) // 2] + [0, 0, 0.02])
    with pytest.raises(BlockedError, match=r"target \d+ of \d+: .*'ball'"):
        planning.reference(path, among(Object(name="ball", shape="sphere", radius=0.01, position=middle)), 0.01, 20)


TOML = """gravity = [0, 0, 9.81]
section = [{length = 0.20, links = 12, muscle_radius = 0.014}, {length = 0.17, links = 12, muscle_radius = 0.013}]
object = [{name = "post", shape = "cylinder", radius = 0.012, length = 0.5, position = [0.11, 0.03, 0.15]}]
"""


def test_the_command_says_clearance_and_draws(contarm, tmp_path):
    (tmp_path / "post.toml").write_text(TOML)
    given = ("ik", "--arm", "post.toml", "--tip", *BEHIND, "--avoid")
    (found,) = json.loads(contarm(*given, "--json")[1])
    truth = clearances(np.array([found["bends"]]), among(POST), 1000)[0]
    assert found["clearance"] == pytest.approx(truth, abs=2e-4)
    assert found["clearance"] >= found["margin"] == pytest.approx(0.025 * 0.37)
    code, out, err = contarm(*given, "--margin", "15mm", "--figure", "around.svg", "--out", "s.csv")
    assert (code, "post" in (tmp_path / "s.csv").read_text()) == (0, True), err
    assert "15 mm" in out
    drawn = (tmp_path / "around.svg").read_text()
    assert {"blocked", "clear", "chosen"} <= words_of(drawn)
    assert ">margin, 15 mm<" in drawn


def words_of(svg):
    import re

    return {word.strip() for word in re.findall(r"<!-- (.*?) -->", svg)} | set(re.findall(r">([a-z]+)</text>", svg))


@pytest.mark.parametrize(
    ("flags", "code", "words"),
    [
        ("--preset two --tip 0.2 0.08 0.15 --avoid", 2, "objects is none"),
        ("--arm post.toml --tip 0.11 0.035 0.2 --avoid", 2, "inside of 'post'"),
        ("--arm post.toml --tip 0.2 0.08 0.15 --avoid --margin -1mm", 2, "margin is -0.001"),
        ("--arm post.toml --tip 0.2 0.08 0.15 --margin 1mm", 2, "--avoid beside it"),
        ("--arm post.toml --tip 0.2 0.08 0.15 --avoid --choose all", 2, "--choose"),
        ("--arm post.toml --tip 0.2 0.08 0.15 --avoid --project nearest", 2, "--project"),
        ("--arm post.toml --tip 0.2 0.08 0.15 --avoid --figure a.bmp", 2, ".png"),
        ("--arm post.toml --tip 0.2 0.08 0.15 --avoid --margin 80mm", 1, "clear of"),
        ("--arm post.toml --tip 0.2 0.08 0.15", 0, "--avoid keeps clear of them"),
    ],
)
def test_flags_that_cannot_be_and_scenes_without_a_way(contarm, tmp_path, flags, code, words):
    (tmp_path / "post.toml").write_text(TOML)
    found, _, err = contarm("ik", *flags.split())
    assert (found, words in err, len(err.strip().splitlines())) == (code, True, 1), err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["post.toml"]
