"""`contarm fk` and `ik` for arms of several sections: round trips, choices, files, and one line for what cannot be."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contarm_sim import presets
from contarm_sim.kinematics import arc, sections
from contarm_sim.mechanics import shape

BENDS = ((1.0, 0.3), (0.8, 2.0), (0.5, -1.0))
KEYS = {"bend_angle", "plane_angle", "curvature", "muscle_deltas", "muscle_lengths", "tip", "transform", "sections"}


def words(bends, flag="--bend"):
    return [word for bend in bends for word in (flag, *bend)]


def test_fk_says_every_section_and_its_end_frame(contarm):
    found = json.loads(contarm("fk", "--preset", "three", *words(BENDS), "--json")[1])
    assert set(found) == KEYS
    arm = presets.three()
    vectors = arc.from_polar(*np.transpose(BENDS))
    frames = sections.frames(vectors, shape.backbone(arm))
    for number, section in enumerate(found["sections"]):
        assert {"bend", "muscle_deltas", "muscle_lengths", "transform"} <= set(section)
        np.testing.assert_allclose(section["bend"], vectors[number], atol=1e-15)
        np.testing.assert_allclose(section["transform"], frames[number + 1], atol=1e-14)
    np.testing.assert_allclose(found["transform"], frames[-1], atol=1e-14)
    parts = [section["muscle_deltas"] for section in found["sections"]]
    np.testing.assert_allclose(np.ravel(parts), found["muscle_deltas"])
    back = json.loads(contarm("fk", "--preset", "three", *words(parts, "--deltas"), "--json")[1])
    np.testing.assert_allclose(back["tip"], found["tip"], atol=1e-12)


def test_one_section_keeps_its_keys_and_gains_sections(contarm):
    found = json.loads(contarm("fk", "--bend", 1, 0.5, "--json")[1])
    assert set(found) == KEYS
    assert found["bend_angle"] == 1.0
    np.testing.assert_allclose(found["sections"][0]["transform"], found["transform"])


def test_fk_takes_places_along_all_sections(contarm):
    found = json.loads(contarm("fk", "--preset", "two", *words(BENDS[:2]), "--xi", 0, "0.3", 1, "--json")[1])
    b, form = arc.from_polar(*np.transpose(BENDS[:2])), shape.backbone(presets.two())
    np.testing.assert_allclose(found["transform"], sections.transform(b, form, [0, 0.3, 1]), atol=1e-14)


@pytest.mark.parametrize("choose", ["least-bend", "least-largest", "farthest", "nearest"])
def test_ik_reaches_what_fk_says_by_every_choice(contarm, choose):
    tip = json.loads(contarm("fk", "--preset", "two", *words(BENDS[:2]), "--json")[1])["tip"]
    more = words(BENDS[:2], "--from") if choose == "nearest" else []
    (found,) = json.loads(contarm("ik", "--preset", "two", "--tip", *tip, "--choose", choose, *more, "--json")[1])
    assert {"bends", "miss", "angle_miss", "reachable", "solutions"} <= set(found)
    assert (found["reachable"], found["solutions"]) == (True, -1)
    assert found["miss"] < 1e-13
    if choose == "nearest":
        np.testing.assert_allclose(found["bends"], arc.from_polar(*np.transpose(BENDS[:2])), atol=1e-9)


def test_ik_of_a_pose_finds_the_bends_that_made_it(contarm):
    T = np.array(json.loads(contarm("fk", "--preset", "three", *words(BENDS), "--json")[1])["transform"])
    w = Rotation.from_matrix(T[:3, :3]).as_quat()[[3, 0, 1, 2]]
    given = ("ik", "--preset", "three", "--tip", *T[:3, 3], "--quaternion", *w, "--choose", "all", "--json")
    found = json.loads(contarm(*given)[1])
    wanted = arc.from_polar(*np.transpose(BENDS))
    assert min(np.abs(np.array(one["bends"]) - wanted).max() for one in found) < 1e-9
    assert all(one["miss"] < 1e-12 and one["angle_miss"] < 1e-12 and one["solutions"] == len(found) for one in found)


def test_ik_lists_the_whole_family(contarm):
    found = json.loads(contarm("ik", "--preset", "two", "--tip", 0.1, 0.05, 0.3, "--choose", "all", "--json")[1])
    assert len(found) > 50
    assert max(one["miss"] for one in found) < 1e-12
    assert {one["piece"] for one in found} == {1}


def test_ik_of_a_file_with_directions_writes_solutions(contarm, tmp_path):
    b = arc.from_polar(*np.transpose([BENDS, BENDS[::-1]]).transpose(0, 2, 1))
    T = sections.transform(b, shape.backbone(presets.three()))
    rows = [",".join(f"{x:.17g}" for x in (*one[:3, 3], *one[:3, 2])) for one in T]
    (tmp_path / "t.csv").write_text("x,y,z,dx,dy,dz\n" + "\n".join(rows))
    code, out, err = contarm("ik", "--preset", "three", "--file", "t.csv", "--out", "s.csv", "--json")
    assert code == 0, err
    assert all(one["reachable"] and one["angle_miss"] < 1e-9 for one in json.loads(out))
    table = np.genfromtxt(tmp_path / "s.csv", delimiter=",", names=True)
    assert {"bend_angle_1_rad", "plane_angle_3_rad", "angle_miss_rad"} <= set(table.dtype.names)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ("fk --preset two --bend 1 0", "given 1 time; allowed: 2 times, once for each section"),
        ("fk --preset two --deltas 0 0 0", "once for each section, if all have three muscles"),
        ("fk --preset two --deltas 0.01 0 0 --deltas 0 0 0", "they sum to 0 in each section"),
        ("fk --preset two --bend 1 0 --bend 4 0", "bend_angle"),
        ("ik --preset two --tip 0.01 0 0.05", "out of reach"),
        ("ik --preset two --tip 0.1 0.05 0.3 --limit 0", "above 0, below pi rad"),
        ("ik --preset two --tip 0.1 0.05 0.3 --limit 1 --limit 1 --limit 1", "once for each section"),
        ("ik --preset two --tip 0.1 0.05 0.3 --choose nearest", "--from BEND_ANGLE PLANE_ANGLE"),
        ("ik --preset two --tip 0.1 0.05 0.3 --choose all --from 1 0 --from 1 0", "--choose nearest, or no --choose"),
        ("ik --preset two --tip 0.1 0.05 0.3 --project ray", "refuse or nearest"),
        ("ik --preset three --tip 0.1 0.05 0.3 --quaternion 0 0 0 0", "a unit quaternion"),
        ("ik --preset three --tip 0.1 0.05 0.3 --direction 0 0 0", "a vector that is not zero"),
        ("ik --preset three --tip 0.1 0.05 0.3 --direction 0 0 1 --quaternion 1 0 0 0", "one of them"),
        ("ik --preset two --file none.csv --choose all", "none.csv"),
    ],
)
def test_what_cannot_be_is_one_clear_line(contarm, given, says):
    code, out, err = contarm(*given.split())
    assert (code, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1
