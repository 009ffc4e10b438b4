"""The nearest point of the dome against brute force: a dense sampling of the profile, then a scalar minimiser."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from contarm_sim.kinematics import arc, dome, nearest, search
from contarm_sim.kinematics.arrays import polynomial

LENGTH = 0.37
GRID = np.linspace(0, np.pi, 4001)
PROFILE = dome.meridian(GRID, 1.0)
RIM_CENTRE = 0.1893037, 0.2847702  # of the profile's curvature at the rim, in lengths


@pytest.fixture(autouse=True)
def _no_floating_point_errors():
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


def _plane_targets(count=3000, seed=0):
    """Targets (rho, z) in lengths by kind, hard ones among them."""
    rng = np.random.default_rng(seed)

    def tiny(low=-14.0, high=-1.0):
        return 10.0 ** rng.uniform(low, high, count)

    on = dome.meridian(rng.uniform(0, np.pi, count), 1.0)
    rim = dome.meridian(np.pi, 1.0)
    polar = rng.uniform(0, np.pi, count)
    sign = rng.choice([-1, 1], count)
    kinds = {
        "anywhere": np.stack([rng.uniform(0, 2, count), rng.uniform(-2, 2, count)], -1),
        "on the dome": on,
        "near the dome": on * rng.uniform(0.9, 1.1, (count, 1)),
        "inside": on * rng.uniform(0, 1, (count, 1)),
        "two minima": np.stack([rng.uniform(0, 0.19, count), rng.uniform(0.25, 0.405, count)], -1),
        "near the axis": np.stack([tiny(-300), rng.uniform(-1, 2, count)], -1),
        "near the apex' centre of curvature": np.stack([tiny(), 0.25 + sign * tiny()], -1),
        "near the rim's centre of curvature": RIM_CENTRE + sign[:, None] * np.stack([tiny(), tiny()], -1),
        "near the rim": rim + sign[:, None] * np.stack([tiny(), tiny()], -1),
        "far away": (10 ** rng.uniform(1, 5.9, count))[:, None] * np.stack([np.sin(polar), np.cos(polar)], -1),
    }
    return {name: np.stack([np.abs(targets[:, 0]), targets[:, 1]], -1) for name, targets in kinds.items()}


def _in_space(targets, plane=0.7):
    """Turn (rho, z) in lengths into positions [m]."""
    return LENGTH * np.stack([targets[:, 0] * np.cos(plane), targets[:, 0] * np.sin(plane), targets[:, 1]], axis=-1)


def _sampled_distance(targets):
    blocks = np.array_split(targets, max(1, len(targets) // 500))
    return np.concatenate([np.hypot(b[:, :1] - PROFILE[:, 0], b[:, 1:] - PROFILE[:, 1]).min(axis=1) for b in blocks])


@pytest.mark.parametrize("kind", _plane_targets(1))
def test_no_sample_of_the_dome_is_nearer(kind):
    targets = _plane_targets()[kind]
    found = dome.bend_from_tip(_in_space(targets), LENGTH, "nearest")
    scale = 1 + np.hypot(*targets.T)
    assert np.all(found.miss / LENGTH <= _sampled_distance(targets) + 2e-15 * scale)
    offset = arc.position(found.bend, LENGTH) - _in_space(targets)
    np.testing.assert_allclose(np.linalg.norm(offset, axis=-1), found.miss, rtol=1e-15, atol=4e-16)
    assert np.hypot(*found.bend.T).max() < np.pi


@pytest.mark.parametrize("kind", _plane_targets(1))
def test_a_scalar_minimiser_finds_no_nearer_point(kind):
    """Each basin of the sampling is refined on its own, the ends of the profile included."""

    def distance(angle):
        return float(np.hypot(*(dome.meridian(angle, 1.0) - target)))

    targets = _plane_targets(25, seed=1)[kind]
    found = dome.bend_from_tip(_in_space(targets), LENGTH, "nearest").miss / LENGTH
    for target, miss in zip(targets, found, strict=True):
        samples = np.hypot(PROFILE[:, 0] - target[0], PROFILE[:, 1] - target[1])
        lowest = np.flatnonzero(samples <= np.minimum(np.append(samples[1:], np.inf), np.append(np.inf, samples[:-1])))
        best = samples.min()
        for i in lowest:
            around = GRID[max(i - 1, 0)], GRID[min(i + 1, len(GRID) - 1)]
            best = min(best, minimize_scalar(distance, bounds=around, method="bounded", options={"xatol": 1e-11}).fun)
        assert miss <= best + 2e-15 * (1 + np.hypot(*target))


def test_the_offset_is_normal_to_the_dome_or_points_past_its_rim():
    for kind, targets in _plane_targets().items():
        tips = _in_space(targets)
        found = dome.bend_from_tip(tips, LENGTH, "nearest")
        angle = np.hypot(*found.bend.T)
        offset = tips - arc.position(found.bend, LENGTH)
        along = np.einsum("nij,ni->nj", arc.jacobian(found.bend, LENGTH), offset)
        outwards = np.einsum("nj,nj->n", along, [[np.cos(0.7), np.sin(0.7)]])
        rim = angle > np.pi - 1e-14
        scale = LENGTH * (np.linalg.norm(offset, axis=-1) + LENGTH)
        assert np.abs(outwards[~rim] / scale[~rim]).max(initial=0) < 4e-15, kind
        assert np.all(outwards[rim] / scale[rim] > -1e-14), kind


def test_equidistant_feet_and_rims_are_told_apart():
    """Across the surface where foot and rim are equally far, the choice changes and the distance does not jump."""
    for rho in np.linspace(0.02, 0.18, 9):
        low, high = 0.25, 0.41
        for _ in range(60):
            middle = 0.5 * (low + high)
            bend = dome.bend_from_tip([rho, 0, middle], 1.0, "nearest").bend
            low, high = (middle, high) if np.hypot(*bend) > np.pi - 1e-9 else (low, middle)
        rim, foot = (dome.bend_from_tip([rho, 0, z], 1.0, "nearest") for z in (low, high))
        assert np.hypot(*rim.bend) - np.hypot(*foot.bend) > 0.1
        assert float(rim.miss) == pytest.approx(float(foot.miss), abs=1e-15)


def test_the_fits_and_the_box_of_two_minima_are_those_of_the_profile():
    """Normal, radius and centre of curvature by finite differences of the profile's exact derivative."""
    h = np.linspace(1e-3, 0.5 * np.pi - 1e-3, 500)
    step = 1e-5
    jacobian = [arc.jacobian(np.stack([2 * x, 0 * x], -1), 1.0)[:, ::2, 0] for x in (h - step, h, h + step)]
    normals = [np.arctan2(-rate[:, 1], rate[:, 0]) for rate in jacobian]
    p, radius = normals[1], 2 * np.linalg.norm(jacobian[1], axis=-1) * 2 * step / (normals[2] - normals[0])
    centre = dome.meridian(2 * h, 1.0) - radius[:, None] * np.stack([np.sin(p), np.cos(p)], axis=-1)
    assert np.all(np.diff(radius) < 0)  # what all else rests on
    np.testing.assert_allclose(p * polynomial(nearest._HALF, p * p), h, atol=3e-9)
    np.testing.assert_allclose(p * polynomial(nearest._CENTRE_RHO, p * p), centre[:, 0], atol=1e-6)
    np.testing.assert_allclose(polynomial(nearest._CENTRE_Z, p * p), centre[:, 1], atol=1e-6)
    rim = dome.meridian(np.pi, 1.0)
    largest_rho, low, high = nearest._TWO_MINIMA
    assert centre[-1, 0] < largest_rho
    assert low < 0.25
    assert np.tan(nearest._RIM_NORMAL) == pytest.approx(np.pi / -2, rel=1e-12)  # m' at the rim is along (-2/pi, -1)
    assert rim[1] - rim[0] / np.tan(nearest._RIM_NORMAL) == pytest.approx(high, abs=1e-4)
    assert rim[1] - rim[0] / np.tan(nearest._RIM_NORMAL) < high


def test_the_few_steps_and_the_search_agree():
    """They are two methods: where both answer they must give one point."""
    for kind, targets in _plane_targets().items():
        half, distance = nearest.step_to_nearest(*targets.T)
        sure, searched = search.search_nearest(*targets.T)
        settled = ~np.isnan(distance)
        np.testing.assert_allclose(distance[settled], searched[settled], rtol=2e-15, atol=2e-15, err_msg=kind)
        np.testing.assert_allclose(half[settled], sure[settled], rtol=1e-13, atol=1e-13, err_msg=kind)
    assert np.isnan(nearest.step_to_nearest(*_plane_targets()["anywhere"].T)[1]).mean() < 0.02


def test_on_the_axis_the_apex_or_the_ring_of_the_rim_is_nearest_towards_muscle_1():
    """1 - z = hypot(2/pi, z) where they are equally far."""
    equal = 0.5 * (1 - (2 / np.pi) ** 2)
    above = dome.bend_from_tip([[0, 0, z] for z in (3.0, 1.0, 0.6, equal + 1e-12)], 1.0, "nearest").bend
    np.testing.assert_array_equal(above, 0.0)
    targets = [[0, 0, equal - 1e-12], [0, 0, 0.25], [-0.0, 0, 0.1], [0, -0.0, -3], [0, 0, 0]]
    below = dome.bend_from_tip(targets, 1.0, "nearest").bend
    np.testing.assert_allclose(below, [[np.pi, 0]] * 5, rtol=2e-15)


@pytest.mark.parametrize("size", [1e-20, 1e-160, 1e-300, 1e-310])
def test_close_to_the_axis_the_direction_is_kept_down_to_the_smallest_numbers(size):
    """Near the apex bend = 2 rho/(1 - 4/3 (1 - z)): the curvature there is 4/3."""
    low, high = dome.bend_from_tip([[3 * size, -4 * size, 0.0], [3 * size, -4 * size, 0.8]], 1.0, "nearest").bend
    np.testing.assert_allclose(low / np.pi, [0.6, -0.8], rtol=1e-12)
    np.testing.assert_allclose(high / size, np.array([6, -8]) / (1 - 0.8 / 3), rtol=1e-12)
    np.testing.assert_allclose(dome.bend_from_tip([size, -size, 1.0], 1.0).bend / size, [2, -2], rtol=1e-12)


def test_a_target_gives_the_same_bits_alone_and_among_others():
    targets = np.concatenate([_in_space(t[:30]) for t in _plane_targets().values()])
    many = np.concatenate([targets, _in_space(_plane_targets(9000, seed=2)["anywhere"])])
    for project in ("ray", "nearest"):
        together = dome.bend_from_tip(many, LENGTH, project)
        for i, target in enumerate(targets):
            alone = dome.bend_from_tip(target, LENGTH, project)
            np.testing.assert_array_equal(alone.bend, together.bend[i])
            assert alone.miss == together.miss[i]
