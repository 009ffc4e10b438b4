"""Two sections and a tip position: against forward kinematics, brute force, dense samples, and symmetry."""

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize
from scipy.spatial import cKDTree
from two_targets import BACKBONES, KINDS, poses

from contarm_sim.errors import InputError
from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import Backbone

ARCS = BACKBONES["arcs"]
names = pytest.mark.parametrize("name", BACKBONES)


def angles(bends):
    return np.hypot(bends[..., 0], bends[..., 1])


def measures(backbone):
    """Return what each choice makes small."""
    return {
        "least-bend": lambda b: angles(b).sum(axis=-1),
        "least-largest": lambda b: angles(b).max(axis=-1),
        "farthest": lambda b: -(np.array(backbone.limits) - angles(b)).min(axis=-1),
    }


def check_reached(found, targets, backbone):
    miss = np.linalg.norm(sections.position(found.bends, backbone) - targets, axis=-1)
    assert miss.max() <= 1e-13
    np.testing.assert_allclose(found.miss, miss, atol=1e-15)
    assert found.reachable.all()
    assert np.all(found.solutions != 0)
    assert np.all(angles(found.bends) <= np.array(backbone.limits) + 1e-14)


def check_every_choice(backbone, kind, count):
    given = poses(backbone, kind, count)
    targets = sections.position(given, backbone)
    for choose, measure in measures(backbone).items():
        found = inverse.solve(targets, backbone, choose=choose)
        check_reached(found, targets, backbone)
        assert np.all(measure(found.bends) <= measure(given) + 5e-7)  # straight ones: bends to the root of rounding
    found = inverse.solve(targets, backbone, choose="nearest", near=given)
    check_reached(found, targets, backbone)
    np.testing.assert_allclose(found.bends, given, atol=5e-7)
    found = inverse.solve(targets, backbone, sections.transform(given, backbone)[:, :3, 2])
    check_reached_position(found, targets, backbone)
    assert found.angle_miss.max() < 1e-6


def check_reached_position(found, targets, backbone):
    assert np.linalg.norm(sections.position(found.bends, backbone) - targets, axis=-1).max() <= 1e-13
    assert np.all(angles(found.bends) <= np.array(backbone.limits) + 1e-14)


@names
@pytest.mark.parametrize("kind", KINDS)
def test_targets_that_poses_reach_are_reached_by_no_worse_poses(name, kind):
    check_every_choice(BACKBONES[name], kind, 150)


@pytest.mark.slow
@names
@pytest.mark.parametrize("kind", KINDS)
def test_the_floor_of_targets_that_are_reached(name, kind):
    check_every_choice(BACKBONES[name], kind, 100_000 if kind == "random" else 10_000)


def brute_force(target, backbone, starts, rng):
    """Return the solutions within the limits that least squares find from random bends."""
    found = []
    for start in rng.uniform(-0.6, 0.6, (starts, 4)) * np.repeat(backbone.limits, 2):
        solved = least_squares(
            lambda b: sections.position(b.reshape(2, 2), backbone, check=False) - target,
            start,
            jac=lambda b: sections.jacobian(b.reshape(2, 2), backbone, check=False)[:3],
            xtol=1e-15, ftol=1e-15, gtol=1e-15,
        )  # fmt: skip
        bends = solved.x.reshape(2, 2)
        if np.abs(solved.fun).max() < 1e-10 and np.all(angles(bends) <= backbone.limits):
            found.append(bends)
    return found


def damped_steps(targets, backbone, starts, rng):
    """Return the solutions within the limits of each target that damped Newton steps find from random bends: a list."""
    bends = rng.uniform(-0.7, 0.7, (len(targets), starts, 2, 2)) * np.array(backbone.limits)[:, None]
    for _ in range(40):
        off = sections.position(bends, backbone, check=False) - targets[:, None]
        J = sections.jacobian(bends, backbone, check=False)[..., :3, :]
        damping = (off * off).sum(axis=-1)[..., None, None] * np.eye(3)
        step = J.swapaxes(-1, -2) @ np.linalg.solve(
            J @ J.swapaxes(-1, -2) + damping + 1e-16 * np.eye(3), off[..., None]
        )
        bends = bends - step[..., 0].reshape(bends.shape)
    off = sections.position(bends, backbone, check=False) - targets[:, None]
    good = (np.abs(off).max(axis=-1) < 1e-11) & np.all(angles(bends) <= backbone.limits, axis=-1)
    return [b[g] for b, g in zip(bends, good, strict=True)]


def check_brute_force(name, targets, solutions):
    """Check that solutions that were found lie on the family and are no better than the choices; return how many."""
    backbone, count = BACKBONES[name], 0
    best = {choose: inverse.solve(targets, backbone, choose=choose) for choose in measures(backbone)}
    for i, target in enumerate(targets):
        family = inverse.family(target, backbone)
        for bends in solutions[i]:
            count += 1
            assert family.contains(bends, 1e-7)
            for choose, measure in measures(backbone).items():
                assert measure(best[choose].bends[i]) <= measure(bends) + 1e-7
    return count


def test_solutions_that_least_squares_finds_lie_on_the_family_and_are_no_better():
    rng, count = np.random.default_rng(1), 0
    for name in ("arcs", "chains, connectors"):
        targets = sections.position(poses(BACKBONES[name], "random", 3, 2), BACKBONES[name])
        count += check_brute_force(name, targets, [brute_force(x, BACKBONES[name], 3, rng) for x in targets])
    assert count > 5


@names
def test_solutions_that_damped_steps_find_lie_on_the_family_and_are_no_better(name):
    targets = sections.position(poses(BACKBONES[name], "random", 10, 2), BACKBONES[name])
    assert check_brute_force(name, targets, damped_steps(targets, BACKBONES[name], 20, np.random.default_rng(1))) > 50


@pytest.mark.slow
@names
def test_the_floor_of_solutions_that_brute_force_finds(name):
    targets = sections.position(poses(BACKBONES[name], "random", 200, 2), BACKBONES[name])
    assert (
        check_brute_force(name, targets, damped_steps(targets, BACKBONES[name], 200, np.random.default_rng(1))) > 5000
    )


@names
def test_choices_are_the_best_of_dense_samples_of_the_family(name):
    backbone, rng = BACKBONES[name], np.random.default_rng(3)
    points = sections.position(poses(backbone, "random", 40, 3), backbone)
    near, directions = poses(backbone, "random", 40, 4), rng.normal(size=(40, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    nearest = inverse.solve(points, backbone, choose="nearest", near=near).bends
    directed = inverse.solve(points, backbone, directions)
    found = {choose: inverse.solve(points, backbone, choose=choose).bends for choose in measures(backbone)}
    for i, target in enumerate(points):
        samples = np.concatenate(inverse.family(target, backbone).curve(400))
        assert np.linalg.norm(sections.position(samples, backbone) - target, axis=-1).max() < 1e-13
        for choose, measure in measures(backbone).items():
            assert measure(found[choose][i]) <= measure(samples).min() + 1e-8
        distance = np.linalg.norm(samples - near[i], axis=(1, 2)).min()
        assert np.linalg.norm(nearest[i] - near[i]) <= distance + 1e-8
        axes = sections.transform(samples, backbone)[:, :3, 2]
        angle = 2 * np.arcsin(np.minimum(np.linalg.norm(axes - directions[i], axis=-1) / 2, 1)).min()
        assert directed.angle_miss[i] <= angle + 1e-8
        axis = sections.transform(directed.bends[i], backbone)[:3, 2]
        np.testing.assert_allclose(np.cos(directed.angle_miss[i]), axis @ directions[i], atol=1e-13)


def test_one_target_gives_what_many_give_in_any_shape():
    points = sections.position(poses(ARCS, "random", 600), ARCS).reshape(2, 300, 3)
    many = inverse.solve(points, ARCS)
    assert many.bends.shape == (2, 300, 2, 2)
    assert many.miss.shape == many.angle_miss.shape == many.reachable.shape == many.solutions.shape == (2, 300)
    one = inverse.solve(points[1, 7], ARCS)
    assert one.bends.shape == (2, 2)
    assert one.miss.shape == ()
    np.testing.assert_allclose(one.bends, many.bends[1, 7], atol=1e-9)
    assert inverse.solve(np.empty((0, 3)), ARCS).bends.shape == (0, 2, 2)


def test_a_turned_target_turns_the_pose():
    points = sections.position(poses(ARCS, "random", 50), ARCS)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    turned = points.copy()
    turned[:, :2] = points[:, :2] @ turn.T
    for choose in measures(ARCS):
        one, other = (inverse.solve(x, ARCS, choose=choose).bends for x in (points, turned))
        np.testing.assert_allclose(one @ turn.T, other, atol=1e-7)


def check_curves(family):
    curves = family.curve(60)
    assert len(curves) == sum(2 if piece.shape == "two arcs" else 1 for piece in family.pieces)
    for bends in curves:
        steps = np.linalg.norm(np.diff(bends, axis=0), axis=(1, 2))
        assert steps.max() < 0.1 * steps.sum() + 1e-6  # no jump from branch to branch


def check_ends(family, backbone, piece):
    for end, kind in ((piece.low, piece.low_end), (piece.high, piece.high_end)):
        one, other = family.bends(end, 1), family.bends(end, -1)
        if kind == "planar":
            assert abs(np.linalg.det(one)) < 1e-4
            assert np.abs(one - other).max() < 1e-4
        else:
            assert np.any(angles(one) > np.array(backbone.limits) - 1e-7)


def check_mirrored(family, piece):
    """The branches are mirror images in the plane of the target and the axis."""
    middle = 0.5 * (piece.low + piece.high)
    one, other = family.bends([middle] * 2)[0], family.bends(middle, -1)
    along = family.target[:2] / np.linalg.norm(family.target[:2])
    across = np.array([-along[1], along[0]])
    np.testing.assert_allclose(one @ along, other @ along, atol=1e-12)
    np.testing.assert_allclose(one @ across, -(other @ across), atol=1e-12)


def test_a_family_is_curves_that_end_as_it_says():
    shapes = set()
    for name, least in (("arcs", 0.0), ("low limits", 0.0), ("arcs", 0.95)):
        backbone = BACKBONES[name]
        given = poses(backbone, "random", 20)
        given *= (least + (1 - least) * angles(given) / backbone.limits)[..., None] * np.array(backbone.limits)[:, None]
        given /= np.maximum(angles(poses(backbone, "random", 20)), 1e-300)[..., None]
        for bends, target in zip(given, sections.position(given, backbone), strict=True):
            family = inverse.family(target, backbone)
            assert family.contains(bends)
            assert not family.contains(bends + np.array([[0.01, 0], [0, 0]]))
            check_curves(family)
            for piece in family.pieces:
                shapes.add(piece.shape)
                check_ends(family, backbone, piece)
                check_mirrored(family, piece)
    assert shapes == {"loop", "arc", "two arcs"}


def dense(backbone, counts):
    """Return bends of all shapes up to a turn about the axis, and their tips in the meridian plane."""
    one, two = (np.linspace(0, limit, n) for limit, n in zip(backbone.limits, counts[:2], strict=True))
    one, two, twist = (x.ravel() for x in np.meshgrid(one, two, np.linspace(0, np.pi, counts[2]), indexing="ij"))
    bends = np.stack([one, 0 * one, two * np.cos(twist), two * np.sin(twist)], axis=-1).reshape(-1, 2, 2)
    tips = sections.position(bends, backbone)
    return np.stack([one, two, twist], axis=-1), np.stack([np.hypot(tips[:, 0], tips[:, 1]), tips[:, 2]], axis=-1)


def check_unreachable(name, count, polished, counts=(41, 41, 21)):
    backbone, rng = BACKBONES[name], np.random.default_rng(5)
    points = rng.uniform(-1.1, 1.1, (count, 3)) * backbone.length
    found = inverse.solve(points, backbone)
    miss = np.linalg.norm(sections.position(found.bends, backbone) - points, axis=-1)
    np.testing.assert_allclose(found.miss, miss, atol=1e-15)
    assert np.all(found.reachable == (miss <= 1e-9 * backbone.length))
    assert np.all((found.solutions == 0) == ~found.reachable)
    assert np.all(angles(found.bends) <= np.array(backbone.limits) + 1e-14)
    shapes, tips = dense(backbone, counts)
    tree = cKDTree(tips)
    meridian = np.stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]], axis=-1)
    assert np.all(miss <= tree.query(meridian)[0] + 1e-12)  # no sampled pose comes nearer
    for i in rng.permutation(np.flatnonzero(~found.reachable))[:polished]:

        def distance(x, i=i):
            bends = np.array([[x[0], 0], [x[1] * np.cos(x[2]), x[1] * np.sin(x[2])]])
            tip = sections.position(bends, backbone, check=False)
            return np.hypot(np.hypot(tip[0], tip[1]) - meridian[i, 0], tip[2] - meridian[i, 1])

        bounds = [(0, backbone.limits[0]), (0, backbone.limits[1]), (0, np.pi)]
        starts = shapes[tree.query(meridian[i], 40)[1][::13]]
        best = min(minimize(distance, x, bounds=bounds, options={"ftol": 1e-15, "gtol": 1e-9}).fun for x in starts)
        assert abs(miss[i] - best) < 1e-8
    return int((~found.reachable).sum())


@pytest.mark.parametrize("name", ["arcs", "chains, connectors", "low limits"])
def test_no_sampled_pose_comes_nearer_to_what_is_out_of_reach(name):
    assert check_unreachable(name, 1000, 2) > 400


@pytest.mark.slow
@names
def test_the_floor_of_what_is_out_of_reach(name):
    assert check_unreachable(name, 20_000, 20, (91, 91, 46)) > 5000


def test_the_cavity_is_out_of_reach():
    found = inverse.solve([[0.05, 0, 0.02], [0.1, 0.05, 0.3]], ARCS)
    assert found.reachable.tolist() == [False, True]
    assert not inverse.family([0.05, 0, 0.02], ARCS).reachable
    assert inverse.family([0.05, 0, 0.02], ARCS).curve() == []


def test_targets_just_inside_and_outside_of_the_boundary():
    """Between 1e-13 and 1e-3 off the outer boundary, and off poses with both bends at their limits."""
    directions = np.random.default_rng(0).normal(size=(40, 3))
    outer = sections.position(inverse.solve(directions, ARCS).bends, ARCS)
    rolled_up = sections.position(poses(ARCS, "both limits", 40), ARCS)
    for size in (1e-13, 1e-10, 1e-6, 1e-3):
        for points, way in ((outer, -1), (outer, 1), (rolled_up, -1), (rolled_up, 1)):
            inside = points is outer and way < 0
            targets = points * (1 + way * size)
            found = inverse.solve(targets, ARCS)
            miss = np.linalg.norm(sections.position(found.bends, ARCS) - targets, axis=-1)
            off = np.linalg.norm(targets - points, axis=-1)
            assert np.all(miss <= (1e-13 if inside else off * 1.0001 + 1e-11))  # the boundary is no farther
            assert np.all(found.reachable == (miss <= 1e-9 * ARCS.length))


def test_on_the_axis_a_circle_of_poses_solves():
    target = [0, 0, 0.3]
    found = inverse.solve(target, ARCS)
    assert found.solutions == -1
    assert found.miss < 1e-15
    family = inverse.family(target, ARCS)
    assert all(piece.circle for piece in family.pieces)
    (curve,) = family.curve(50)
    np.testing.assert_allclose(sections.position(curve, ARCS), np.tile(target, (99, 1)), atol=1e-15)
    np.testing.assert_allclose(angles(curve), np.tile(angles(found.bends), (99, 1)), atol=1e-9)
    for turn in np.linspace(0, 6, 7):
        c, s = np.cos(turn), np.sin(turn)
        near = found.bends @ np.array([[c, s], [-s, c]])
        np.testing.assert_allclose(inverse.solve(target, ARCS, choose="nearest", near=near).bends, near, atol=1e-9)
    for off in (1e-15, 1e-12, 1e-9, 1e-8, 1e-6, 1e-4):
        check_reached(inverse.solve([off, -off, 0.3], ARCS), np.array([off, -off, 0.3]), ARCS)


def test_straight_and_folded_poses():
    straight = inverse.solve([0, 0, 0.37], ARCS)
    assert angles(straight.bends).max() < 1e-7
    assert straight.reachable
    assert straight.solutions == 1
    one = np.array([[1.2, 0.4], [0.0, 0.0]])  # a straight second section, a straight first one
    for given in (one, one[::-1]):
        target = sections.position(given, ARCS)
        found = inverse.solve(target, ARCS, choose="nearest", near=given)
        np.testing.assert_allclose(found.bends, given, atol=1e-7)
    limit = ARCS.limits[0]
    folded = np.array([[limit, 0.0], [limit, 0.0]])  # rolled up
    check_reached(inverse.solve(sections.position(folded, ARCS), ARCS), sections.position(folded, ARCS), ARCS)


def test_a_mirrored_tip_leaves_the_second_bend_constant():
    """Where P = r2 and z = -b2, every bend angle of section 1 asks for the same one of section 2."""
    backbone = Backbone(lengths=(0.2, 0.25), connectors=(0.0, 0.15))
    second = np.array([2.9, 0.0])
    tip = sections.position(second[None], Backbone(lengths=(0.25,), connectors=(0.15,)))
    target = tip * [1, 1, -1]
    assert target[2] > 0
    found = inverse.solve(target, backbone)
    check_reached(found, target, backbone)
    np.testing.assert_allclose(angles(found.bends)[1], 2.9, atol=1e-9)


def test_far_targets_are_answered_without_warnings():
    points = np.array([[3e5, 0, 0], [3e5, -3e5, 1e5], [0, 0, -1e3]])
    found = inverse.solve(points, ARCS)
    assert not found.reachable.any()
    np.testing.assert_allclose(found.miss, np.linalg.norm(points, axis=-1), rtol=1e-3)
    assert not inverse.family(points[1], ARCS).reachable
    assert inverse.solve([0.1, 0, 0.3], ARCS, [1e200, 0, -1e-200]).miss < 1e-13


@pytest.mark.parametrize("limit", [1e-6, 1e-3, 3.1415])
@pytest.mark.parametrize("links", [None, (1, 2)])
def test_limits_next_to_nothing_and_next_to_half_a_turn(limit, links):
    backbone = Backbone(lengths=(0.2, 0.17), limits=(limit,), links=links)
    for kind in KINDS:
        given = poses(backbone, kind, 100)
        given *= np.minimum(limit / angles(given), 1)[..., None]
        targets = sections.position(given, backbone)
        check_reached(inverse.solve(targets, backbone), targets, backbone)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: inverse.solve([0, 0, np.nan], ARCS), "position"),
        (lambda: inverse.solve([0, 0], ARCS), "position"),
        (lambda: inverse.family([0, 0, 0.3], Backbone(lengths=(0.2,))), "backbone"),
        (lambda: inverse.solve([0, 0, 0.3], ARCS, choose="best"), "choose"),
        (lambda: inverse.solve([0, 0, 0.3], ARCS, choose="nearest"), "near"),
        (lambda: inverse.solve([0, 0, 0.3], ARCS, choose="nearest", near=np.zeros((3, 2, 2))), "near"),
        (lambda: inverse.solve([0, 0, 0.3], ARCS, choose="nearest", near=np.full((2, 2), 3.0)), "bend_angle"),
        (lambda: inverse.solve([0, 0, 0.3], ARCS, [0, 0, 0]), "direction"),
        (lambda: inverse.solve(np.zeros((2, 3)), ARCS, np.ones((4, 3))), "direction"),
        (lambda: inverse.family(np.zeros((2, 3)), ARCS), "position"),
        (lambda: inverse.family([0.1, 0, 0.3], ARCS).bends(3.0), "parameter"),
        (lambda: inverse.family([0.05, 0, 0.02], ARCS).bends(1.0), "parameter"),
        (lambda: inverse.family([0.1, 0, 0.3], ARCS).bends(1.0, 0), "branch"),
    ],
)
def test_what_cannot_be_is_refused_by_name(call, name):
    with pytest.raises(InputError, match=name):
        call()
