"""Three sections and a pose: every solution, against the bends that made it and least squares from random starts."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contarm_sim.errors import InputError
from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import CHOICES
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.three import choosing, chord_length, search, solutions

LENGTHS = (0.2, 0.17, 0.15)
ARM = Backbone(lengths=LENGTHS)
SAME = 1e-6  # bends that differ by less are alike [rad]


def bends(count, low=0.0, high=0.98 * np.pi, seed=0):
    rng = np.random.default_rng(seed)
    return polar(rng.uniform(low, high, (count, 3)), rng.uniform(-np.pi, np.pi, (count, 3)))


def polar(angle, plane):
    return angle[..., None] * np.stack([np.cos(plane), np.sin(plane)], axis=-1)


def pose(b, backbone):
    T = sections.transform(b, backbone)
    return T[..., :3, 3], T[..., :3, :3]


def solve(b, backbone):
    position, rotation = pose(b, backbone)
    return solve_pose(position, rotation, backbone)


def solve_pose(position, rotation, backbone, choose="least-bend", near=None):
    return inverse.solve(position, backbone, rotation=rotation, choose=choose, near=near)


def solve_direction(position, direction, backbone, choose="least-bend", near=None):
    """Return what the closed form alone says."""
    return choosing.solve_direction(Goals(position, direction), backbone, choose, near)


def solved(b, backbone):
    """Return all solutions of the poses of bends, checked by the forward kinematics, and which have their own bends."""
    position, rotation = pose(b, backbone)
    found, count = inverse.all_poses(position, rotation, backbone)
    known = ~np.isnan(found[..., 0, 0])
    assert (known.sum(axis=-1) == count).all()
    p, R = pose(found[known], backbone)
    row = np.nonzero(known)[0]
    assert np.abs(p - position[row]).max() <= 1e-12
    assert np.abs(R - rotation[row]).max() * 0.3 * backbone.length <= 1e-12
    angle = np.hypot(found[..., 0], found[..., 1])
    assert (angle[known] <= backbone.limits).all()
    assert (np.diff(np.where(known, angle.sum(axis=-1), 99.0), axis=1) >= 0).all()
    apart = np.where(known, np.abs(found - b[:, None]).max(axis=(-1, -2)), np.inf)
    return found, count, apart.min(axis=1) < SAME


ARMS = {
    "arcs": {"lengths": LENGTHS},
    "long in the middle": {"lengths": (0.1, 0.3, 0.1)},
    "tapering": {"lengths": (0.3, 0.1, 0.05)},
    "1 to 4": {"lengths": (0.1, 0.1, 0.4)},
    "4 to 1": {"lengths": (0.4, 0.1, 0.1)},
    "chains": {"lengths": LENGTHS, "links": (6, 12, 3)},
    "single joints": {"lengths": LENGTHS, "links": (1, 1, 1)},
    "tool": {"lengths": LENGTHS, "connectors": (0, 0, 0.04)},
    "close limits": {"lengths": LENGTHS, "limits": (1.0, 2.0, 1.5)},
    "metres": {"lengths": (20.0, 17.0, 15.0)},
}


@pytest.mark.parametrize("name", ARMS)
def test_poses_within_reach_are_solved_by_the_bends_that_made_them(name):
    backbone = Backbone(**ARMS[name])
    b = bends(600)
    b *= (np.asarray(backbone.limits) / ARM.limits)[:, None]
    if name == "metres":
        backbone = replace(backbone, lengths=LENGTHS)
        metres = Backbone(**ARMS[name])
        position, rotation = pose(b, metres)
        found, _ = inverse.all_poses(position, rotation, metres)
        np.testing.assert_allclose(found, solved(b, backbone)[0], atol=1e-8)
    _, count, own = solved(b, backbone)
    assert own.all()
    assert count.min() >= 1


EASY = {
    "near limits": lambda: bends(500, 0.95 * ARM.limits[0]),
    "at limits": lambda: polar(np.full((200, 3), ARM.limits[0]), bends(200)[..., 0]),
    "coiled": lambda: polar(np.full((1, 3), ARM.limits[0]), np.zeros((1, 3))),
    "planar": lambda: polar(np.random.default_rng(1).uniform(-3, 3, (200, 3)), np.full((200, 3), 0.7)),
    "symmetric": lambda: bends(200)[:, [0, 1, 0]] * np.array([[1, 1], [1, 1], [1, -1]]),
    "first alone": lambda: bends(200) * [[1], [0], [0]],
    "middle alone": lambda: bends(200) * [[0], [1], [0]],
    "last alone": lambda: bends(200) * [[0], [0], [1]],
    "middle straight": lambda: bends(200) * [[1], [0], [1]],
    "last nearly straight": lambda: bends(200) * [[1], [1], [1e-7]],
    "bent a little": lambda: 0.1 * bends(200),
    "nearly straight": lambda: 1e-3 * bends(200),
}


@pytest.mark.parametrize("name", EASY)
def test_special_poses_are_solved_by_their_own_bends(name):
    assert solved(EASY[name](), ARM)[2].all()


@pytest.mark.parametrize("links", [None, (6, 12, 3)])
@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-9, 1e-7, 1e-5])
def test_straight_poses_are_solved_as_far_as_numbers_tell(size, links):
    b = size * bends(100)
    found, count, _ = solved(b, Backbone(lengths=LENGTHS, links=links))
    assert (count >= 1).all()
    # The height tells a bend apart from none by its square.
    assert np.nanmax(np.abs(found)) < 20 * size + 1e-7


@pytest.mark.parametrize("plane", [0.0, 1.1])
def test_poses_of_one_arc_are_solved_in_its_plane_and_said_to_be_a_continuum(plane):
    angle = np.linspace(-2.5, 2.5, 101)[:, None]
    angle = angle[np.abs(angle[:, 0]) > 0.01] * np.asarray(LENGTHS) / LENGTHS[0]
    b = polar(angle, np.full(angle.shape, plane))
    found, _, own = solved(b, ARM)
    assert own.all()
    across = found @ [-np.sin(plane), np.cos(plane)]
    assert np.nanmax(np.abs(across)) < 1e-6
    answer = solve(b, ARM)
    assert answer.reachable.all()
    assert (answer.solutions == -1).all()
    assert (solve_pose([0, 0, sum(LENGTHS)], np.eye(3), ARM).solutions == 1).all()


def test_a_shortened_straight_pose_is_solved():
    """The tip above the base, closer than the straight arm's: whatever bends solve, all planes do."""
    position = np.array([[0, 0, z] for z in np.linspace(0.36, 0.5199, 12)])
    answer = solve_pose(position, np.eye(3), ARM)
    assert answer.reachable.all()
    assert (answer.solutions == -1).all()


def least_squares(position, rotation, start, backbone, steps=300):
    """Damped least squares from many starts at once, free of limits; the Jacobian is that of the forward kinematics."""
    b, damping = start.copy(), np.full(len(start), 1e-2)

    def residual(b):
        p, R = pose(b, backbone)
        turn = Rotation.from_matrix(R @ rotation.swapaxes(-1, -2)).as_rotvec()
        return np.concatenate([(p - position) / backbone.length, 0.3 * turn], axis=-1)

    off = residual(b)
    for _ in range(steps):
        J = sections.jacobian(b, backbone) * np.repeat([1 / backbone.length, 0.3], 3)[:, None]
        JT = J.swapaxes(-1, -2)
        step = np.linalg.solve(JT @ J + damping[:, None, None] * np.eye(6), JT @ off[..., None])[..., 0]
        tried = b - step.reshape(b.shape)
        tried *= np.minimum(1, 3.14 / np.maximum(np.hypot(tried[..., 0], tried[..., 1]), 1e-9))[..., None]
        new = residual(tried)
        better = (new**2).sum(-1) < (off**2).sum(-1)
        b[better], off[better] = tried[better], new[better]
        damping = np.clip(np.where(better, 0.2 * damping, 4 * damping), 1e-14, 1e6)
    return b, np.linalg.norm(off, axis=-1)


def compare_with_random_starts(targets, starts, backbone, seed):
    """Return how many solutions random starts find, and how many of them are among ours."""
    b = bends(targets, seed=seed)
    ours, _, _ = solved(b, backbone)
    total = shared = 0
    for start in range(0, targets, 20):
        part = slice(start, start + 20)
        p, R = (np.repeat(each, starts, axis=0) for each in pose(b[part], backbone))
        ends, off = least_squares(p, R, bends(len(p), seed=seed + 1 + start), backbone, 120)
        inside = (off < 1e-11) & (np.hypot(ends[..., 0], ends[..., 1]) <= backbone.limits).all(axis=-1)
        for k, known in enumerate(ours[part]):
            distinct = []
            for end in ends[k * starts : (k + 1) * starts][inside[k * starts : (k + 1) * starts]]:
                if all(np.abs(end - other).max() > 1e-5 for other in distinct):
                    distinct.append(end)
            total += len(distinct)
            shared += sum(np.nanmin(np.abs(known - end).max(axis=(-1, -2))) < 1e-5 for end in distinct)
    return total, shared


def test_what_random_starts_find_is_among_the_solutions():
    total, shared = compare_with_random_starts(20, 40, ARM, 3)
    assert shared == total >= 25


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arcs", "long in the middle", "tapering", "chains"])
def test_what_two_hundred_random_starts_find_on_500_targets_is_among_the_solutions(name):
    total, shared = compare_with_random_starts(125, 200, Backbone(**ARMS[name]), 11)
    assert shared == total >= 150


@pytest.mark.slow
@pytest.mark.parametrize("name", ["arcs", "long in the middle", "tapering", "chains", "1 to 4"])
def test_a_hundred_thousand_poses(name):
    backbone = Backbone(**ARMS[name])
    _, count, own = solved(bends(100_000, seed=5), backbone)
    assert count.min() >= 1
    assert own.mean() >= 0.9999
    answer = solve(bends(10_000, seed=6), backbone)
    assert answer.reachable.all()
    near = bends(10_000, 0.95 * backbone.limits[0], seed=7)
    _, _, own = solved(near, backbone)
    assert own.mean() >= 0.999
    assert solve(near, backbone).reachable.all()


def test_choices_rank_the_solutions():
    b = bends(300, seed=2)
    position, rotation = pose(b, ARM)
    limits = np.array([2.9, 3.0, 3.05])
    backbone = replace(ARM, limits=tuple(limits))
    found, _ = inverse.all_poses(position, rotation, backbone)
    some = ~np.isnan(found[:, 0, 0, 0])
    angle = np.hypot(found[..., 0], found[..., 1])[some]
    best = {
        "least-bend": np.nanmin(angle.sum(-1), axis=1),
        "least-largest": np.nanmin(angle.max(-1), axis=1),
        "farthest": np.nanmin((angle - limits).max(-1), axis=1),
    }
    for choose, least in best.items():
        got = solve_pose(position[some], rotation[some], backbone, choose).bends
        size = np.hypot(got[..., 0], got[..., 1])
        value = size.sum(-1) if choose == "least-bend" else size.max(-1)
        np.testing.assert_allclose((size - limits).max(-1) if choose == "farthest" else value, least, atol=1e-12)
    near = solve_pose(position, rotation, ARM, "nearest", b + 1e-3)
    np.testing.assert_allclose(near.bends, b, atol=1e-6)


def test_shapes_follow_the_targets():
    b = bends(6).reshape(2, 3, 3, 2)
    position, rotation = pose(b, ARM)
    found, count = inverse.all_poses(position, rotation, ARM)
    assert found.shape[:2] == count.shape == (2, 3)
    one = solve_pose(position[1, 2], rotation[1, 2], ARM)
    assert one.bends.shape == (3, 2)
    assert one.miss.shape == one.angle_miss.shape == one.reachable.shape == one.solutions.shape == ()
    many = solve_pose(position, rotation, ARM)
    np.testing.assert_allclose(many.bends[1, 2], one.bends, atol=1e-9)
    none = solve_pose(np.zeros((0, 3)), np.zeros((0, 3, 3)), ARM)
    assert none.bends.shape == (0, 3, 2)
    wide = inverse.solve(position[:, :1], ARM, rotation[:1, 0, :, 2])
    assert wide.bends.shape == (2, 1, 3, 2)


def test_a_pose_out_of_reach_is_said_to_be_and_the_nearest_is_near():
    rng = np.random.default_rng(4)
    position, rotation = rng.uniform(-0.5, 0.5, (40, 3)), Rotation.random(40, random_state=4).as_matrix()
    answer = solve_pose(position, rotation, ARM)
    assert (answer.reachable == (answer.solutions != 0)).all()
    assert 0 < answer.reachable.sum() < 20
    weight = answer.miss**2 + (0.3 * ARM.length * answer.angle_miss) ** 2
    p, R = (np.repeat(each, 30, axis=0) for each in (position, rotation))
    others, _ = least_squares(p, R, bends(len(p), seed=8), ARM, 60)
    others *= np.minimum(1, ARM.limits[0] / np.hypot(others[..., 0], others[..., 1]))[..., None]
    got, R_got = pose(others, ARM)
    turn = np.linalg.norm(Rotation.from_matrix(R_got @ R.swapaxes(-1, -2)).as_rotvec(), axis=-1)
    others = (np.sum((got - p) ** 2, axis=-1) + (0.3 * ARM.length * turn) ** 2).reshape(40, 30).min(axis=1)
    assert (weight <= others * 1.02 + 1e-18).mean() >= 0.9
    far = solve_pose([0, 0, 1.0], np.eye(3), ARM)
    assert not far.reachable
    np.testing.assert_allclose(far.bends, 0, atol=1e-3)
    assert far.miss == pytest.approx(1.0 - ARM.length, abs=1e-6)


@pytest.mark.parametrize("choose", CHOICES)
def test_position_and_direction_choose_along_the_free_roll(choose):
    b = bends(16, seed=9)
    position, rotation = pose(b, ARM)
    answer = solve_direction(position, rotation[..., 2], ARM, choose, b)
    assert answer.reachable.all()
    assert answer.miss.max() < 1e-13
    assert (answer.solutions == -1).all()
    assert (np.hypot(answer.bends[..., 0], answer.bends[..., 1]) <= ARM.limits).all()

    def rank(bends):
        angle = np.hypot(bends[..., 0], bends[..., 1])
        return {"least-bend": angle.sum(-1), "nearest": ((bends - b) ** 2).sum((-1, -2))}.get(choose, angle.max(-1))

    turns = Rotation.from_rotvec(np.linspace(0, 2 * np.pi, 41)[:, None] * [0, 0, 1]).as_matrix()
    found, _ = inverse.all_poses(position[:, None], rotation[:, None] @ turns, ARM)
    brute = np.nanmin(
        np.where(np.isnan(found[..., 0, 0]), np.inf, rank(np.moveaxis(found, 0, 2)[..., :, :, :]).transpose(2, 0, 1)),
        axis=(1, 2),
    )
    assert (rank(answer.bends) <= brute + 1e-6).mean() >= 0.95


def test_a_direction_out_of_reach_is_said_to_be():
    answer = inverse.solve([[0, 0, 0.5199], [0, 0, 0.7]], ARM, [[0, 0, -1], [1, 0, 0]])
    assert not answer.reachable.any()
    assert (answer.solutions == 0).all()


def test_chords_turn_and_reach_as_sections_do():
    b = bends(200)
    T = sections.frames(b, ARM)
    w = np.diff(T[:, :, :3, 3], axis=1)
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    np.testing.assert_allclose(search.bends_of_chords(w[:, 0], w[:, 1], w[:, 2]), b, atol=1e-12)
    Q0, Qv = search.chord_product(T[:, 3, :3, :3])
    volume = np.einsum("ni,ni->n", w[:, 0], np.cross(w[:, 1], w[:, 2]))
    np.testing.assert_allclose(np.abs(Q0), np.abs(volume), atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(Qv, axis=-1), np.sqrt(1 - volume**2), atol=1e-14)


@pytest.mark.parametrize("links", [1, 2, 5, None])
def test_the_polynomial_of_chord_lengths(links):
    backbone = Backbone(lengths=LENGTHS, links=links and (links,) * 3)
    c = np.linspace(0, 1, 101)
    bend = 2 * np.arccos(c)[1:, None] * [1, 0]
    one = Backbone(lengths=(0.17,), links=links and (links,))
    reach = np.linalg.norm(sections.position(bend[:, None], one), axis=-1)
    chord = chord_length.chord_lengths(backbone, [[0], [1], [2]])[1]
    np.testing.assert_allclose(chord(c[None, 1:])[0], reach, atol=2e-8)


BAD = {
    "a reflection": (([0, 0, 0.3], np.diag([1, 1, -1]), ARM), "rotation"),
    "no rotation": (([0, 0, 0.3], 2 * np.eye(3), ARM), "rotation"),
    "a rotation of NaN": (([0, 0, 0.3], np.full((3, 3), np.nan), ARM), "rotation"),
    "a huge rotation": (([0, 0, 0.3], np.full((3, 3), 1e300), ARM), "rotation"),
    "a quaternion": (([0, 0, 0.3], [1, 0, 0, 0], ARM), "rotation"),
    "a vector": (([0, 0, 0.3], [1, 0, 0], ARM), "rotation"),
    "an endless position": (([0, 0, np.inf], np.eye(3), ARM), "position"),
    "two numbers": (([0, 0.3], np.eye(3), ARM), "position"),
    "words": (("up", np.eye(3), ARM), "position"),
    "two and three": ((np.zeros((2, 3)), np.stack([np.eye(3)] * 3), ARM), "rotation"),
    "another choice": (([0, 0, 0.3], np.eye(3), ARM, "best"), "choose"),
    "nearest to nothing": (([0, 0, 0.3], np.eye(3), ARM, "nearest"), "near"),
    "nearest to two": (([0, 0, 0.3], np.eye(3), ARM, "nearest", np.zeros((2, 3, 2))), "near"),
    "nearest to NaN": (([0, 0, 0.3], np.eye(3), ARM, "nearest", np.full((3, 2), np.nan)), "bends"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_is_refused_in_one_line(case):
    arguments, name = BAD[case]
    with pytest.raises(InputError) as error:
        solve_pose(*arguments)
    assert error.value.name == name
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("backbone", "name"),
    [(Backbone(lengths=(0.2, 0.1)), "backbone"), (replace(ARM, connectors=(0.01, 0, 0)), "connectors")],
)
def test_arms_that_the_closed_form_does_not_know_are_refused(backbone, name):
    with pytest.raises(InputError) as error:
        inverse.all_poses([0, 0, 0.3], np.eye(3), backbone)
    assert error.value.name == name


def test_rotations_are_made_orthonormal_to_rounding():
    position, rotation = pose(bends(100), ARM)
    rounded = np.round(rotation, 8)
    answer = solve_pose(position, rounded, ARM)
    assert answer.reachable.all()
    assert answer.angle_miss.max() < 1e-13
    T = sections.transform(answer.bends, ARM)
    assert np.abs(T[:, :3, :3] - rotation).max() < 2e-8


def test_a_half_turn_off_is_no_solution():
    """A turn by pi has no axis of its own to show: the tip of the straight arm, upside down."""
    for turned in ([-1, -1, 1], [1, -1, -1], [-1, 1, -1]):
        answer = solve_pose([0, 0, ARM.length], np.diag(turned).astype(float), ARM)
        assert not answer.reachable
        assert answer.solutions == 0
        assert answer.angle_miss < 2
        assert inverse.all_poses([0, 0, ARM.length], np.diag(turned), ARM)[1] == 0


@pytest.mark.parametrize("far", [1e3, 1e5])
def test_the_farthest_targets_are_out_of_reach(far):
    answer = solve_pose([0, far, far], np.eye(3), ARM)
    assert not answer.reachable
    assert answer.miss == pytest.approx(np.hypot(far, far), abs=ARM.length)
    assert not inverse.solve([far, 0, 0], ARM, [0, 0, far]).reachable


def test_folded_pairs_near_the_limits_are_both_found():
    """Poses near a fold of a curve that is hardly there: found only by what nearly exists, and beyond the fold."""
    folded = np.array([1828, 4880])
    own = [bends(10_000, 0.95 * ARM.limits[0], seed=seed)[k] for seed, k in zip((7, 27), folded, strict=True)]
    _, count, found = solved(np.array(own), ARM)
    assert found.all()
    assert (count == 2).all()


def test_solutions_lie_within_memory_in_blocks(monkeypatch):
    """Blocks change nothing but rounding."""
    position, rotation = pose(bends(50), ARM)
    whole, count = inverse.all_poses(position, rotation, ARM)
    monkeypatch.setattr(solutions, "_BLOCK", 7)
    parts, again = inverse.all_poses(position, rotation, ARM)
    np.testing.assert_array_equal(count, again)
    np.testing.assert_allclose(parts, whole, atol=1e-9)


@pytest.mark.slow
def test_directions_are_reached_wherever_some_roll_is_within_the_limits():
    """Near the limits few rolls are: 100 % of random targets, and of those whose bends are all near their limits."""
    for b in (bends(800, seed=41), bends(200, 0.95 * 3.07, seed=42)):
        position, rotation = pose(b, ARM)
        answer = solve_direction(position, rotation[..., 2], ARM)
        assert answer.reachable.all()
        angle, own = (np.hypot(each[..., 0], each[..., 1]).sum(axis=-1) for each in (answer.bends, b))
        assert (angle <= own + 1e-9).mean() >= 0.98
