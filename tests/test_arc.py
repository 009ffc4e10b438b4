"""The arc against closed forms, finite differences, matrix exponentials and its own inverse."""

from decimal import Decimal, localcontext
from math import factorial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sampling import bends
from scipy.linalg import expm

from contarm_sim.errors import InputError, UnreachableError
from contarm_sim.kinematics import arc, dome
from contarm_sim.kinematics.arrays import sinc_and_slope, sinc_slope

LENGTH = 0.37


@pytest.fixture(autouse=True)
def _no_floating_point_errors():
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


def test_round_trip_over_a_million_bends():
    tips = arc.position(bends(1_000_000), LENGTH)
    solved = dome.bend_from_tip(tips, LENGTH)
    assert np.linalg.norm(arc.position(solved.bend, LENGTH) - tips, axis=-1).max() <= 1e-14
    assert solved.miss.max() <= 1e-14


@pytest.mark.parametrize("xi", [0.0, 1e-9, 0.3, 1.0])
def test_pose_is_the_integral_of_its_own_tangent(xi):
    bend = bends(40, largest=3.0)
    grid = np.linspace(0, xi, 2001)
    tangents = arc.rotation(bend[:, None, :], grid)[..., 2]
    weights = np.ones(2001)
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    integral = LENGTH * (xi / 2000 / 3) * np.einsum("g,ngi->ni", weights, tangents)
    np.testing.assert_allclose(arc.position(bend, LENGTH, xi), integral, atol=1e-13)


def test_rotation_is_the_matrix_exponential_of_a_torsion_free_turn():
    for b in bends(60):
        turn = np.array([[0, 0, b[0]], [0, 0, b[1]], [-b[0], -b[1], 0]])
        np.testing.assert_allclose(arc.rotation(b), expm(turn), atol=2e-14)


@pytest.mark.parametrize("xi", [0.4, 1.0])
def test_jacobian_is_the_derivative(xi):
    bend, step = bends(4000), 1e-5
    J = arc.jacobian(bend, LENGTH, xi)
    for column, direction in enumerate(np.eye(2) * step):
        ahead = arc.position(bend + direction, LENGTH, xi)
        behind = arc.position(bend - direction, LENGTH, xi)
        np.testing.assert_allclose(J[..., column], (ahead - behind) / (2 * step), atol=1e-8)


def test_jacobian_near_straight_keeps_its_precision():
    """At |b| = 1e-4 .. 1e-9 the series gives dp_z/db = -(L/3) b (1 - b^2/10); a closed form would cancel."""
    bend = arc.from_polar(np.logspace(-9, -4, 40), 0.7)
    expected = -(LENGTH / 3) * bend * (1 - np.sum(bend**2, axis=-1, keepdims=True) / 10)
    np.testing.assert_allclose(arc.jacobian(bend, LENGTH)[:, 2], expected, rtol=1e-12)


def _exact_series(y, slope):
    """Return sin(x)/x, or (cos x - sin(x)/x)/x^2, of y = x^2 in decimal arithmetic."""
    power, total = Decimal(1), Decimal(0)
    for n in range(1 if slope else 0, 40):
        total += (-1) ** n * (2 * n if slope else 1) * power / factorial(2 * n + 1)
        power *= y
    return total


def _exact_jacobian(bend, length, xi):
    """Return dp/dbend of p = xi length ((1 - cos s)/s^2 xi bend, sin(s)/s), row by row, in decimal arithmetic."""
    x, y, xi, length = (Decimal(float(v)) for v in (*bend, xi, length))
    squared = xi**2 * (x * x + y * y)
    c, slope = _exact_series(squared / 4, False), _exact_series(squared / 4, True)
    lateral, curving = xi**2 * length * c**2 / 2, xi**4 * length * c * slope / 4
    falling = xi**3 * length * _exact_series(squared, True)
    rows = (lateral + curving * x * x, curving * x * y), (curving * x * y, lateral + curving * y * y)
    return [*rows, (falling * x, falling * y)]


@pytest.mark.parametrize("xi", [1e-3, 0.3, 1.0])
def test_jacobian_to_rounding_from_straight_to_the_rim(xi):
    """Every entry against 50 digits, relative to itself where nothing cancels, else to the largest."""
    angles = [0.0, *np.logspace(-300, -1, 60), *np.linspace(0.2, np.nextafter(np.pi, 0), 40)]
    bend = arc.from_polar(angles, np.linspace(-3, 3, len(angles)))
    for b, J in zip(bend, arc.jacobian(bend, LENGTH, xi), strict=True):
        with localcontext(prec=50):
            exact = np.array(_exact_jacobian(b, LENGTH, xi), dtype=float)
        np.testing.assert_allclose(J[2], exact[2], rtol=3e-15)
        np.testing.assert_allclose(J[:2], exact[:2], rtol=0, atol=1e-15 * np.abs(exact).max())


def test_sinc_and_its_slope_to_rounding_on_both_sides_of_where_the_series_end():
    y = np.concatenate([[0.0, 5e-324, 1e-200], np.logspace(-20, 0, 50), np.linspace(1, 9.8, 200), [2.4675, 2.46750001]])
    with localcontext(prec=50):
        exact = [[float(_exact_series(Decimal(v), slope)) for v in y.tolist()] for slope in (False, True)]
    np.testing.assert_allclose(sinc_and_slope(y), exact, rtol=1e-15, atol=1e-16)
    x = np.sqrt(y)
    np.testing.assert_allclose(sinc_slope(np.concatenate([x, -x])), 2 * exact[1], rtol=2e-15)
    for one, *pair in zip(y.tolist(), *sinc_and_slope(y), strict=True):
        assert list(sinc_and_slope(one)) == pair


@pytest.mark.parametrize("largest", [3.0, 40.0])
def test_bends_beyond_pi_are_arcs_too(largest):
    """The pose at xi of an arc is that of the whole arc of length xi, bent xi times as much."""
    bend = largest * bends(500)[:, ::-1] / np.pi
    for xi in (0.1, 0.7):
        np.testing.assert_allclose(arc.transform(bend, LENGTH, xi), arc.transform(xi * bend, xi * LENGTH), atol=1e-14)
    s = np.hypot(*bend[4:].T)
    np.testing.assert_allclose(arc.position(bend[4:], LENGTH)[:, 2], LENGTH * np.sin(s) / s, atol=1e-14)


@pytest.mark.parametrize(
    "what", [arc.position, arc.transform, arc.jacobian, lambda b, _, *a, **k: arc.rotation(b, *a, **k)]
)
def test_the_same_bits_alone_and_among_others_checked_and_unchecked(what):
    bend, xi = bends(20_000), np.random.default_rng(0).uniform(0, 1, 20_000)
    for args in ((), (xi,)):
        many = what(bend, LENGTH, *args)
        np.testing.assert_array_equal(what(bend, LENGTH, *args, check=False), many)
        np.testing.assert_array_equal(what(bend[5:1000:3], LENGTH, *(a[5:1000:3] for a in args)), many[5:1000:3])
        for i in (*range(60), 8191, 8192, 19_999):
            np.testing.assert_array_equal(what(bend[i], LENGTH, *(a[i] for a in args)), many[i])


def test_unchecked_says_nothing():
    assert np.isnan(arc.position([np.nan, 0.0], LENGTH, check=False)).all()
    assert arc.transform(np.empty((0, 2)), LENGTH).shape == (0, 4, 4)


def test_leading_axes_broadcast():
    bend = bends(24).reshape(4, 6, 2)
    xi = np.linspace(0, 1, 5)
    points = arc.position(bend[:, :, None], LENGTH, xi)
    assert points.shape == (4, 6, 5, 3)
    np.testing.assert_array_equal(points[2, 3, 4], arc.position(bend[2, 3], LENGTH))
    assert arc.transform(bend, LENGTH).shape == (4, 6, 4, 4)


def test_quarter_circle():
    np.testing.assert_allclose(
        arc.position(arc.from_polar(np.pi / 2, 0.0), LENGTH), [2 * LENGTH / np.pi, 0, 2 * LENGTH / np.pi], atol=1e-16
    )


def test_the_dome_has_the_stated_radii():
    degrees = np.array([0, 90, 180 - 1e-7])
    radii = np.linalg.norm(dome.meridian(np.radians(degrees), 1.0), axis=-1)
    np.testing.assert_allclose(radii, [1, 0.900316, 0.636620], atol=1e-6)
    angles = np.radians(np.linspace(0, 180, 180_001))
    rho = dome.meridian(angles, 1.0)[:, 0]
    assert rho.max() == pytest.approx(0.7246, abs=5e-5)
    assert np.degrees(angles[rho.argmax()]) == pytest.approx(133.6, abs=0.05)


@given(x=st.floats(-0.6, 0.6), y=st.floats(-0.6, 0.6), z=st.floats(-0.6, 0.6))
def test_nearest_is_nearest(x, y, z):
    """No point of a fine sampling of the dome is nearer than the one found, and the miss is its distance."""
    target = np.array([x, y, z])
    found = dome.bend_from_tip(target, LENGTH, "nearest")
    reached = arc.position(found.bend, LENGTH)
    assert np.linalg.norm(reached - target) == pytest.approx(float(found.miss), abs=1e-15)
    profile = dome.meridian(np.linspace(0, np.pi, 4001), LENGTH)
    offsets = profile - [np.hypot(x, y), z]
    assert found.miss <= np.hypot(*offsets.T).min() + 1e-12
    assert np.hypot(*found.bend) < np.pi


def test_nearest_leaves_the_dome_along_its_normal():
    rng = np.random.default_rng(3)
    target = arc.position(bends(500, largest=2.9), LENGTH) * rng.uniform(0.8, 1.2, (500, 1))
    found = dome.bend_from_tip(target, LENGTH, "nearest")
    offset = target - arc.position(found.bend, LENGTH)
    along = np.einsum("nij,ni->nj", arc.jacobian(found.bend, LENGTH), offset)
    assert np.abs(along).max() < 1e-14


def test_ray_keeps_the_direction():
    target = np.array([0.1, -0.05, 0.2])
    found = dome.bend_from_tip(target, LENGTH, "ray")
    reached = arc.position(found.bend, LENGTH)
    assert np.linalg.norm(np.cross(reached, target)) < 1e-16
    assert float(found.miss) == pytest.approx(abs(np.linalg.norm(target) - np.linalg.norm(reached)), abs=1e-15)


def test_a_target_off_the_dome_is_refused_with_miss_and_nearest_point():
    targets = np.array([[0, 0, LENGTH], [0.1, 0.1, 0.3]])
    with pytest.raises(UnreachableError) as caught:
        dome.bend_from_tip(targets, LENGTH)
    error = caught.value
    assert error.index == 1
    assert error.miss == pytest.approx(np.linalg.norm(error.nearest - targets[1]))
    assert error.miss < float(dome.bend_from_tip(targets[1], LENGTH, "ray").miss)
    assert dome.bend_from_tip(error.nearest, LENGTH).reachable


@pytest.mark.parametrize("target", [[0, 0, 0], [0, 0, -0.1], [0.2, 0, -0.1], [0, 0.3, 0]])
@pytest.mark.parametrize("project", ["ray", "nearest"])
def test_targets_at_and_below_the_base_give_valid_bends(target, project):
    found = dome.bend_from_tip(target, LENGTH, project)
    assert np.hypot(*found.bend) < np.pi
    reached = arc.position(found.bend, LENGTH)
    assert float(found.miss) == pytest.approx(float(np.linalg.norm(reached - target)), abs=1e-15)
    assert not found.reachable


@pytest.mark.parametrize("bad", [[np.nan, 0, 1], [np.inf, 0, 1], [0, 1], "abc", [[1, 2, 3], [1, 2, -np.inf]]])
def test_bad_targets_are_refused(bad):
    with pytest.raises(InputError), np.errstate(invalid="ignore"):
        dome.bend_from_tip(bad, LENGTH)


def test_bends_of_pi_and_more_are_refused():
    with pytest.raises(InputError):
        arc.as_bend([np.pi, 0.0])
    with pytest.raises(InputError):
        arc.from_polar(-0.1, 0.0)
    with pytest.raises(InputError):
        arc.position([0.1, 0.2], LENGTH, 1.5)
