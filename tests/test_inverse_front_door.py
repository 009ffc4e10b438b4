"""The front door of inverse kinematics: straight arms, poses on the axis, limits to the last bit, what it refuses."""

import numpy as np
import pytest

from contarm_sim.errors import InputError
from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.limits import clamped, excess
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import Section

TWO, THREE, FOUR = (Backbone(lengths=(0.2, 0.17, 0.15, 0.12)[:count]) for count in (2, 3, 4))
P = [0.1, 0.05, 0.25]


@pytest.mark.parametrize("size", [0.0, 1e-8, 3e-8, 1e-7, 1e-6, 1e-4, 1e-2])
def test_two_sections_reach_directions_nearly_straight(size):
    bends = size * np.random.default_rng(1).uniform(-1, 1, (50, 2, 2))
    T = sections.transform(bends, TWO)
    answer = inverse.solve(T[:, :3, 3], TWO, direction=T[:, :3, 2])
    assert answer.reachable.all()
    assert answer.miss.max() < 1e-13
    assert answer.angle_miss.max() < 1e-12
    assert np.abs(answer.bends - bends).max() < 1e-9 + 1e-2 * size


@pytest.mark.parametrize("backbone", [TWO, THREE, FOUR])
@pytest.mark.parametrize("turn", [{}, {"direction": [0, 0, 1]}, {"rotation": np.eye(3)}])
def test_the_straight_arm_is_exactly_straight(backbone, turn):
    answer = inverse.solve([0, 0, backbone.length], backbone, **turn)
    assert answer.reachable
    assert np.all(answer.bends == 0)
    assert answer.solutions == 1
    (only,) = inverse.solve_all([0, 0, backbone.length], backbone, **turn)
    assert only.shape == (1, len(backbone), 2)


def test_bends_at_limits_do_not_exceed_them_by_a_bit():
    rng = np.random.default_rng(2)
    plane = rng.uniform(0, 2 * np.pi, (2000, 2))
    out = clamped(3.0 * np.stack([np.cos(plane), np.sin(plane)], axis=-1), Backbone(lengths=(0.2, 0.17), limits=2.9))
    assert excess(out, Backbone(lengths=(0.2, 0.17), limits=2.9)).max() <= 0
    limited = Backbone(lengths=(0.2, 0.17), limits=1.3)
    bends = 1.3 * np.stack([np.cos(plane), np.sin(plane)], axis=-1)
    bends[:, 0] *= rng.uniform(0.2, 1, (2000, 1))
    for choose in ("least-bend", "least-largest", "farthest"):
        answer = inverse.solve(sections.position(bends, limited), limited, choose=choose)
        assert excess(answer.bends, limited).max() <= 0
    for curve in inverse.solve_all(sections.position(bends[0], limited), limited):
        assert excess(curve, limited).max() <= 0


def test_near_alone_means_nearest():
    near = np.array([[0.5, -0.5], [1.0, 0.2], [0.1, 0.8]])
    plain, said = inverse.solve(P, THREE, near=near), inverse.solve(P, THREE, near=near, choose="nearest")
    np.testing.assert_array_equal(plain.bends, said.bends)
    least = inverse.solve(P, THREE).bends
    assert np.linalg.norm(plain.bends - near) < np.linalg.norm(least - near) - 0.1


def test_a_pose_on_the_axis_is_turned_to_what_it_is_to_be_near():
    """Three sections of three equal bends in planes 120 degrees apart, and tips that are not turned."""
    rng = np.random.default_rng(4)
    position, rotation = np.tile([0.0, 0.0, 0.45], (20, 1)), np.tile(np.eye(3), (20, 1, 1))
    near = rng.uniform(-2, 2, (20, 3, 2))
    answer = inverse.solve(position, THREE, rotation=rotation, near=near)
    assert answer.reachable.all()
    assert (answer.solutions == -1).all()
    far = np.sqrt(((answer.bends - near) ** 2).sum((-1, -2)))
    for turn in np.linspace(0, 2 * np.pi, 721):
        c, s = np.cos(turn), np.sin(turn)
        turned = answer.bends @ np.array([[c, s], [-s, c]])
        assert (far <= np.sqrt(((turned - near) ** 2).sum((-1, -2))) + 1e-9).all()


def test_a_track_that_stays_out_of_reach_stays_at_the_nearest_pose():
    target = [0.1, 0, 0.2]
    backbone = Backbone(lengths=(0.2, 0.17), limits=0.8)
    single = inverse.solve(target, backbone)
    followed = inverse.track([target] * 5, backbone)
    assert not single.reachable
    np.testing.assert_allclose(followed.miss, single.miss, rtol=1e-6)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_samples_of_families_are_as_many_as_asked_for_and_distinct(count):
    backbone = (TWO, THREE, FOUR)[count - 2]
    for points in (2, 7, 100):
        pieces = inverse.solve_all(P, backbone, points=points)
        assert pieces
        for piece in pieces:
            assert 2 <= len(piece) <= (2 * points - 1 if count == 2 else points)
            np.testing.assert_allclose(sections.position(piece, backbone), np.broadcast_to(P, (len(piece), 3)),
                                       atol=1e-8)  # fmt: skip
            if count > 2:
                sums = np.hypot(piece[..., 0], piece[..., 1]).sum(-1)
                assert (np.diff(sums) >= 0).all()


ARM = Arm(sections=(Section(length=0.2, links=12, mass=0.12), Section(length=0.17, links=10, mass=0.1)))
REFUSED = {
    "arm to solve": (lambda: inverse.solve(P, ARM), "backbone", "mechanics.shape.backbone"),
    "arm to solve_all": (lambda: inverse.solve_all(P, ARM), "backbone", "mechanics.shape.backbone"),
    "arm to track": (lambda: inverse.track([P, P], ARM), "backbone", "mechanics.shape.backbone"),
    "arm to family": (lambda: inverse.family(P, ARM), "backbone", "mechanics.shape.backbone"),
    "arm to all_poses": (lambda: inverse.all_poses(P, np.eye(3), ARM), "backbone", "mechanics.shape.backbone"),
    "arm to position": (lambda: sections.position(np.zeros((2, 2)), ARM), "backbone", "mechanics.shape.backbone"),
    "arm to frames": (lambda: sections.frames(np.zeros((2, 2)), ARM), "backbone", "mechanics.shape.backbone"),
    "arm to jacobian": (lambda: sections.jacobian(np.zeros((2, 2)), ARM), "backbone", "mechanics.shape.backbone"),
    "near and another": (lambda: inverse.solve(P, TWO, near=np.zeros((2, 2)), choose="least-bend"), "near", "nearest"),
    "near of a wrong shape": (lambda: inverse.solve(P, TWO, near=np.zeros((3, 2))), "near", "shape (..., 2, 2)"),
    "near in a row": (lambda: inverse.solve(P, TWO, near=np.zeros(4)), "near", "shape (..., 2, 2)"),
    "bends in a row": (lambda: sections.position([1, 0, 0, 0], TWO), "bends", "shape (..., 2, 2)"),
    "bends in words": (lambda: sections.position("up", TWO), "bends", "shape (..., 2, 2)"),
    "quaternion": (lambda: inverse.solve(P, TWO, rotation=[1, 0, 0, 0]), "rotation", "rotation_from_quaternion"),
    "both": (lambda: inverse.solve(P, TWO, [0, 0, 1], np.eye(3)), "direction", "given with rotation"),
    "no points": (lambda: inverse.solve_all(P, TWO, points=0), "points", "2 or more"),
    "one point": (lambda: inverse.solve_all(P, FOUR, points=1), "points", "2 or more"),
    "half a point": (lambda: inverse.solve_all(P, TWO, points=2.5), "points", "2 or more"),
    "start": (lambda: inverse.track([P, P], TWO, start=np.zeros(4)), "start", "2, 2)"),
}


@pytest.mark.parametrize(("call", "name", "says"), REFUSED.values(), ids=REFUSED.keys())
def test_what_cannot_be_is_refused_in_one_line(call, name, says):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.name == name
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)
