"""Inverse kinematics of any number of sections, against forward kinematics, finite differences and SciPy."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from contarm_sim.errors import InputError
from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import CHOICES, penalty
from contarm_sim.kinematics.inverse.general.free import turning
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import excess
from contarm_sim.kinematics.inverse.result import ANGLE_LENGTH
from contarm_sim.kinematics.inverse.tips import tip_axes, tips_and_jacobians

pytestmark = pytest.mark.slow  # by hand: all checks are to take less than ten minutes

LENGTHS = (0.2, 0.17, 0.15, 0.12, 0.1, 0.1)
CASES = [
    *((count, "position") for count in (3, 4, 5, 6)),
    *((count, "direction") for count in (3, 4)),
    *((count, "rotation") for count in (4, 5, 6)),
]


def arm(count, **options):
    return Backbone(lengths=LENGTHS[:count], **options)


def inside(rng, count, backbone, share=1.0):
    """Return random bends, evenly over the disks of the limits, or over a share of their radii at the rim."""
    size = (count, len(backbone))
    angle = np.sqrt(rng.uniform(max(0.0, 1 - share) ** 2, 1, size)) * np.array(backbone.limits)
    plane = rng.uniform(-np.pi, np.pi, size)
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1)


def asked(bends, backbone, what):
    """Return what to ask for: the tip's position, and its direction or rotation besides."""
    T = sections.transform(bends, backbone)
    turn = {"position": {}, "direction": {"direction": T[..., :3, 2]}, "rotation": {"rotation": T[..., :3, :3]}}
    return {"position": T[..., :3, 3], **turn[what]}


def check(answer, backbone, position, direction=None, rotation=None, least=1.0):
    """Check that bends reach the targets by forward kinematics, within the limits, and that misses are what is said."""
    assert answer.reachable.mean() >= least
    T = sections.transform(answer.bends, backbone)
    np.testing.assert_allclose(np.linalg.norm(T[..., :3, 3] - position, axis=-1), answer.miss, atol=1e-15)
    good = answer.reachable
    assert answer.miss[good].max() <= 1e-12
    if direction is not None:
        assert np.abs(T[good][:, :3, 2] - direction[good]).max() < 1e-11
    if rotation is not None:
        assert np.abs(T[good][:, :3, :3] - rotation[good]).max() < 1e-11
    assert excess(answer.bends, backbone).max() <= 0


@pytest.mark.parametrize(
    "options", [{}, {"connectors": (0.02, 0.0, 0.03)}, {"links": (12, 7, 1), "connectors": (0.0, 0.01, 0.02)}]
)
def test_lean_tips_and_jacobians_are_those_of_sections(options):
    rng, backbone = np.random.default_rng(0), arm(3, **options)
    bends = rng.normal(size=(300, 3, 2)) * rng.choice([1.0, 0.1, 1e-3, 1e-9, 0.0], size=(300, 3, 1))
    bends *= np.minimum(1, 3.1 / np.maximum(np.linalg.norm(bends, axis=-1, keepdims=True), 1e-9))
    position, rotation, jacobian = tips_and_jacobians(bends, backbone)
    T = sections.transform(bends, backbone)
    np.testing.assert_allclose(position, T[:, :3, 3], atol=1e-15)
    np.testing.assert_allclose(rotation, T[:, :3, :3], atol=1e-14)
    np.testing.assert_allclose(jacobian, sections.jacobian(bends, backbone), atol=1e-14)


@pytest.mark.parametrize("what", ["position", "direction", "rotation"])
def test_residuals_and_slopes_give_the_gradient(what):
    """The slopes times the residual are the gradient of half its square, also far from the target."""
    rng, backbone, step = np.random.default_rng(1), arm(3), 1e-6
    goals = Goals(**asked(inside(rng, 40, backbone), backbone, what))
    bends = inside(rng, 40, backbone)

    def half_square(bends):
        return 0.5 * (goals.terms(bends, backbone)[0] ** 2).sum(axis=-1)

    residual, slopes = goals.terms(bends, backbone)
    found = -(slopes.swapaxes(1, 2) @ residual[..., None])[..., 0]
    for column in range(6):
        off = np.zeros((3, 2))
        off.flat[column] = step
        expected = (half_square(bends + off) - half_square(bends - off)) / (2 * step)
        np.testing.assert_allclose(found[:, column], expected, atol=1e-8)


def test_turning_keeps_the_tip_and_turns_it_nearer():
    rng, backbone = np.random.default_rng(2), arm(2)
    bends = inside(rng, 100, backbone)
    goals = Goals(**asked(inside(rng, 100, backbone), backbone, "direction"))
    step = 1e-4 * turning(goals, backbone, bends, most=1.0)
    before, after = (goals.misses(b, backbone)[1] for b in (bends, bends + step))
    assert np.all(after <= before + 1e-12)
    tips = sections.position(bends, backbone)
    assert np.linalg.norm(sections.position(bends + step, backbone) - tips, axis=-1).max() < 1e-8


@pytest.mark.parametrize(("count", "what"), CASES)
@pytest.mark.parametrize("options", [{}, {"limits": 1.2}])
def test_reachable_targets_are_reached(count, what, options):
    backbone = arm(count, **options)
    targets = asked(inside(np.random.default_rng(3), 30, backbone), backbone, what)
    answer = inverse.solve(**targets, backbone=backbone)
    check(answer, backbone, **targets)
    assert np.all(answer.solutions == -1)


@pytest.mark.parametrize(("count", "what"), [(3, "position"), (4, "direction"), (5, "rotation"), (3, "rotation")])
def test_chains_and_connectors_are_solved_too(count, what):
    backbone = arm(count, links=(12, 9, 7, 5, 3, 1)[:count], connectors=(0.02,) * count)
    targets = asked(inside(np.random.default_rng(4), 40, backbone), backbone, what)
    check(inverse.solve(**targets, backbone=backbone), backbone, **targets)


@pytest.mark.slow
@pytest.mark.parametrize(("count", "what"), CASES)
@pytest.mark.parametrize(
    "options", [{}, {"limits": 1.2}, {"links": 12, "connectors": 0.02}], ids=["arcs", "limits", "chains"]
)
def test_all_of_2000_reachable_targets_are_reached(count, what, options):
    options = {key: (value,) * count for key, value in options.items()}
    backbone = arm(count, **options)
    for seed, share in ((5, 1.0), (6, 0.1)):
        targets = asked(inside(np.random.default_rng(seed), 2000, backbone, share), backbone, what)
        check(inverse.solve(**targets, backbone=backbone), backbone, **targets)


@pytest.mark.parametrize("what", ["position", "direction", "rotation"])
def test_straight_bends_and_bends_at_limits_are_reached(what):
    backbone = arm(4)
    bends = np.zeros((4, 4, 2))
    bends[1, :, 0] = 1e-9
    bends[2, :, 1] = backbone.limits[0]
    bends[3, 0] = 0.5, 0.0  # the rest is straight
    targets = asked(bends, backbone, what)
    answer = inverse.solve(**targets, backbone=backbone)
    assert answer.reachable.all(), (answer.miss, answer.angle_miss)
    assert excess(answer.bends, backbone).max() <= 0


@pytest.mark.parametrize("choose", CHOICES)
@pytest.mark.parametrize("what", ["position", "direction"])
def test_choices_are_near_the_best_that_scipy_finds(choose, what):
    rng, backbone = np.random.default_rng(7), arm(4)
    near = inside(rng, 2, backbone)
    targets = asked(inside(rng, 2, backbone), backbone, what)
    answer = inverse.solve(**targets, backbone=backbone, choose=choose, near=near if choose == "nearest" else None)
    check(answer, backbone, **targets)
    found = penalty(answer.bends, backbone, choose, near)
    goals = Goals(**targets)
    for i in range(2):
        goal = goals.take([i])

        def residual(x, goal=goal):
            return goal.terms(x.reshape(1, 4, 2), backbone)[0][0]

        best = np.inf
        for start in inside(rng, 4, backbone, 0.7):
            done = minimize(
                lambda x, i=i: penalty(x.reshape(4, 2), backbone, choose, near[i]),
                start.ravel(), constraints={"type": "eq", "fun": residual}, method="SLSQP", options={"maxiter": 80},
            )  # fmt: skip
            bends = done.x.reshape(4, 2)
            if np.abs(residual(done.x)).max() < 1e-7 and excess(bends, backbone) < 1e-6:
                best = min(best, done.fun)
        assert found[i] <= best + 0.25


def test_nearest_keeps_bends_that_solve():
    backbone = arm(5)
    bends = inside(np.random.default_rng(8), 20, backbone)
    answer = inverse.solve(**asked(bends, backbone, "rotation"), backbone=backbone, choose="nearest", near=bends)
    np.testing.assert_allclose(answer.bends, bends, atol=1e-12)


def test_unreachable_targets_are_said_so_and_nearest():
    rng, backbone = np.random.default_rng(9), arm(3, limits=1.0)
    target = rng.normal(size=(3, 3)) * 0.2 + np.array([0.6, 0.0, 0.5])
    answer = inverse.solve(target, backbone)
    assert not answer.reachable.any()
    assert np.all(answer.solutions == 0)
    assert excess(answer.bends, backbone).max() <= 1e-12
    for i, point in enumerate(target):
        best = min(
            minimize(
                lambda x, p=point: np.linalg.norm(sections.position(x.reshape(3, 2), backbone, check=False) - p),
                start.ravel(), method="SLSQP", options={"maxiter": 300, "ftol": 1e-12},
                constraints={"type": "ineq", "fun": lambda x: 1.0 - np.hypot(*x.reshape(3, 2).T)},
            ).fun
            for start in inside(rng, 3, backbone)
        )  # fmt: skip
        assert answer.miss[i] <= best + 1e-6


def test_one_section_gives_the_nearest_tip_and_judges_the_turn():
    backbone = Backbone(lengths=(0.3,))
    bend = np.array([[[0.7, 0.4]], [[0.0, 0.0]]])
    targets = asked(bend, backbone, "rotation")
    answer = inverse.solve(**targets, backbone=backbone)
    np.testing.assert_allclose(answer.bends, bend, atol=1e-12)
    assert answer.reachable.all()
    off = inverse.solve(targets["position"], backbone, direction=[1.0, 0.0, 0.0])
    np.testing.assert_allclose(off.bends, bend, atol=1e-12)
    T = sections.transform(bend, backbone)
    np.testing.assert_allclose(off.angle_miss, np.arccos(T[..., 0, 2]), atol=1e-12)
    assert not off.reachable.any()
    chain = Backbone(lengths=(0.3,), links=(5,), connectors=(0.05,))
    tip = sections.position(bend, chain)
    np.testing.assert_allclose(inverse.solve(tip, chain).bends, bend, atol=1e-7)


@pytest.mark.parametrize("what", ["position", "direction", "rotation"])
def test_results_do_not_depend_on_what_else_is_solved(what):
    backbone = arm(4)
    targets = asked(inside(np.random.default_rng(10), 12, backbone), backbone, what)
    many = inverse.solve(**targets, backbone=backbone)
    one = inverse.solve(**{name: value[5] for name, value in targets.items()}, backbone=backbone)
    assert one.bends.shape == (4, 2)
    assert one.miss.shape == ()
    np.testing.assert_allclose(one.bends, many.bends[5], atol=1e-6)
    shaped = inverse.solve(**{k: v.reshape(3, 4, *v.shape[1:]) for k, v in targets.items()}, backbone=backbone)
    np.testing.assert_array_equal(shaped.bends.reshape(12, 4, 2), many.bends)


def test_all_solutions_of_three_sections():
    rng, backbone = np.random.default_rng(11), arm(3)
    bends = inside(rng, 1, backbone, 0.6)[0]
    pose = asked(bends, backbone, "rotation")
    isolated = inverse.solve_all(**pose, backbone=backbone)
    assert min(np.abs(one - bends).max() for one in isolated) < 1e-9
    aimed = asked(bends, backbone, "direction")
    curves = inverse.solve_all(**aimed, backbone=backbone, points=40)
    for curve in curves:
        check(inverse.Inverse(curve, *_misses(curve, backbone, aimed)), backbone,
              aimed["position"], np.broadcast_to(aimed["direction"], (len(curve), 3)))  # fmt: skip
        assert np.linalg.norm(np.diff(curve, axis=0), axis=(-1, -2)).max() < 1.0
    # The true bends lie on one of the curves, to within its spacing.
    assert min(np.linalg.norm(curve - bends, axis=(-1, -2)).min() for curve in curves) < 0.5
    (surface,) = inverse.solve_all(pose["position"], backbone, points=25)
    assert surface.shape == (25, 3, 2)
    assert inverse.solve_all([5.0, 0.0, 0.0], backbone) == []


def _misses(bends, backbone, targets):
    goals = Goals(*(np.broadcast_to(x, (len(bends), 3)) for x in targets.values()))
    miss, angle = goals.misses(bends, backbone)
    return miss, angle, miss + ANGLE_LENGTH * angle < 1e-9, np.full(len(bends), -1)


def test_no_targets_have_no_answers():
    for count in range(1, 7):
        none = inverse.solve(np.zeros((0, 3)), arm(count), rotation=np.zeros((0, 3, 3)))
        assert none.bends.shape == (0, count, 2)
        assert none.reachable.shape == (0,)


@pytest.mark.parametrize("options", [{}, {"links": (12, 7, 1)}])
def test_axes_of_tips_are_those_of_sections(options):
    rng, backbone = np.random.default_rng(14), arm(3, **options)
    bends = inside(rng, 100, backbone) * rng.choice([1.0, 1e-6, 0.0], size=(100, 3, 1))
    np.testing.assert_allclose(tip_axes(bends), sections.transform(bends, backbone)[:, :3, 2], atol=1e-14)


def test_quaternions_are_rotations():
    rng = np.random.default_rng(13)
    quaternion = rng.normal(size=(50, 4))
    quaternion /= np.linalg.norm(quaternion, axis=-1, keepdims=True)
    expected = Rotation.from_quat(quaternion[:, [1, 2, 3, 0]]).as_matrix()
    np.testing.assert_allclose(inverse.rotation_from_quaternion(quaternion), expected, atol=1e-15)
    np.testing.assert_allclose(inverse.rotation_from_quaternion(-quaternion), expected, atol=1e-15)


P = [0.1, 0.0, 0.3]


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: inverse.solve([1.0, 2.0], arm(3)), "position"),
        (lambda: inverse.solve([np.nan, 0, 0], arm(3)), "position"),
        (lambda: inverse.solve([1e9, 0, 0], arm(3)), "position"),
        (lambda: inverse.solve("here", arm(3)), "position"),
        (lambda: inverse.solve(P, arm(3), direction=[0.0, 0.0, 0.0]), "direction"),
        (lambda: inverse.solve(np.zeros((2, 3)), arm(3), direction=np.ones((3, 3))), "direction"),
        (lambda: inverse.solve(P, arm(3), rotation=2 * np.eye(3)), "rotation"),
        (lambda: inverse.solve(P, arm(3), rotation=-np.eye(3)), "rotation"),
        (lambda: inverse.solve(P, arm(3), rotation=np.ones(3)), "rotation"),
        (lambda: inverse.solve(P, arm(3), direction=P, rotation=np.eye(3)), "direction"),
        (lambda: inverse.solve(P, arm(3), choose="best"), "choose"),
        (lambda: inverse.solve(P, arm(3), choose="nearest"), "near"),
        (lambda: inverse.solve(P, arm(3), choose="nearest", near=np.zeros((2, 2))), "near"),
        (lambda: inverse.solve(P, arm(3), choose="nearest", near=np.zeros((4, 3, 2))), "near"),
        (lambda: inverse.solve_all([P, P], arm(3)), "position"),
        (lambda: inverse.rotation_from_quaternion([0.0, 0.0, 0.0, 0.0]), "quaternion"),
        (lambda: inverse.rotation_from_quaternion([1.0, 2.0, 3.0, 4.0]), "quaternion"),
        (lambda: inverse.rotation_from_quaternion([1.0, 0.0, 0.0]), "quaternion"),
        (lambda: inverse.rotation_from_quaternion([1e300, 1e300, 0.0, 0.0]), "quaternion"),
    ],
)
def test_targets_that_are_none_are_refused_in_one_line(call, name):
    with pytest.raises(InputError) as caught:
        call()
    assert caught.value.name == name
    assert "\n" not in str(caught.value)
