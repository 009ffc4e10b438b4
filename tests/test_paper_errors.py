"""The eight errors of the paper (Nazari, Castro, Godage 2019): each printed form fails here, and ours holds."""

import numpy as np
import pytest
from sampling import bends

from contarm_sim.errors import UnreachableError
from contarm_sim.kinematics import arc, dome, muscles
from contarm_sim.model.arm import Arm

L0, R = 0.37, 0.018


def _planes(bend_angle, count=24):
    """Poses in every bending plane but those where a printed form divides by zero."""
    return arc.from_polar(bend_angle, np.linspace(-np.pi, np.pi, count, endpoint=False) + 0.05)


def _tip(bend_angle, plane_angle):
    """Paper eq. 16 as printed."""
    lam = L0 / bend_angle
    along = lam * (1 - np.cos(bend_angle))
    return np.stack([along * np.cos(plane_angle), along * np.sin(plane_angle), lam * np.sin(bend_angle)], axis=-1)


def _phi_q(l2, l3):
    return (2 / R) * np.sqrt((l2**2 + l3**2 + l2 * l3) / 3)


def test_1_theta_of_q_with_atan_picks_the_wrong_half_plane():
    bend = _planes(2.3)
    tips = arc.position(bend, L0)
    _, l2, l3 = muscles.deltas_from_bend(bend, R).T
    printed = np.arctan((l3 - l2) / (np.sqrt(3) * (l2 + l3)))
    errors = np.linalg.norm(_tip(_phi_q(l2, l3), printed) - tips, axis=-1)
    assert np.mean(errors > 1e-9) == 0.5
    assert errors.max() == pytest.approx(1.45 * L0, rel=0.01)
    ours, _ = muscles.bend_from_deltas(muscles.deltas_from_bend(bend, R), R)
    np.testing.assert_allclose(arc.position(ours, L0), tips, atol=1e-15)


def test_2_theta_ik_with_atan_makes_bend_angles_negative():
    tips = arc.position(_planes(1.2), L0)
    x, y, z = tips.T
    f1 = L0 * np.sin(np.arctan(y / x))
    printed = 2 * y / (f1 * (z**2 / L0**2 + y**2 / f1**2))
    assert np.mean(printed < 0) == 0.5
    ours, _ = arc.to_polar(dome.bend_from_tip(tips, L0).bend)
    np.testing.assert_allclose(ours, 1.2, atol=1e-14)


def test_3_phi_ik_is_zero_over_zero_on_the_whole_plane_of_muscle_1():
    for plane in (0.0, np.pi):
        x, y, z = arc.position(arc.from_polar(1.2, plane), L0)
        y = 0.0 * y
        f1 = L0 * np.sin(np.arctan(y / x))
        with np.errstate(invalid="ignore", divide="ignore"):
            printed = 2 * y / (f1 * (z**2 / L0**2 + np.divide(y**2, f1**2)))
        assert np.isnan(printed)
        assert arc.to_polar(dome.bend_from_tip([x, y, z], L0).bend)[0] == pytest.approx(1.2, abs=1e-15)


def test_4_lambda_is_infinite_when_straight_and_cancels_nearby():
    with np.errstate(divide="ignore"):
        assert np.isinf(0.5 * R * L0 * np.sqrt(3 / np.array(0.0)))
    small = 1e-6
    exact = L0 * small / 2  # to a relative 1e-13
    printed = _tip(small, 0.0)[0]
    assert abs(printed / exact - 1) > 5e-5
    assert arc.position([small, 0.0], L0)[0] == pytest.approx(exact, rel=1e-12)
    np.testing.assert_array_equal(arc.position([0.0, 0.0], L0), [0, 0, L0])


def test_5_the_last_factor_of_the_transform_turns_the_wrong_way():
    def turn(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        return (
            np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
            if axis == "z"
            else np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        )

    bend_angle, plane = 1.1, 0.8
    head = turn("z", plane) @ turn("y", bend_angle)
    elements = np.sin(plane) ** 2 * np.cos(bend_angle) + np.cos(plane) ** 2  # the paper's [R]_22
    printed, ours = head @ turn("z", -plane).T, arc.rotation(arc.from_polar(bend_angle, plane))
    assert abs(printed[1, 1] - elements) > 0.4
    assert ours[1, 1] == pytest.approx(elements, abs=1e-15)
    np.testing.assert_allclose(ours, head @ turn("z", -plane), atol=1e-15)


def test_6_the_reachable_set_is_no_sphere_and_the_printed_inverse_misses_silently():
    radii = np.linalg.norm(arc.position(bends(1000), L0), axis=-1)
    assert np.ptp(radii) > 0.35 * L0
    target = L0 * np.array([np.sin(np.pi / 4), 0, np.cos(np.pi / 4)])
    printed = dome.bend_from_tip(target, L0, "paper")
    assert float(printed.miss) == pytest.approx(0.041, abs=0.001)
    with pytest.raises(UnreachableError):
        dome.bend_from_tip(target, L0)
    assert dome.bend_from_tip(target, L0, "nearest").miss < printed.miss


def test_6b_the_paper_projection_is_the_printed_formula():
    rng = np.random.default_rng(1)
    x, y, z = rng.uniform(0.05, 0.3, (3, 200))
    f1 = L0 * np.sin(np.arctan(y / x))
    printed = 2 * y / (f1 * (z**2 / L0**2 + y**2 / f1**2))
    valid = printed < np.pi
    ours = dome.bend_from_tip(np.stack([x, y, z], axis=-1)[valid], L0, "paper").bend
    np.testing.assert_allclose(arc.to_polar(ours)[0], printed[valid], rtol=1e-12)


def test_7_being_inside_the_ellipse_says_only_that_the_bend_is_below_pi():
    """Lengths no arc can have (sum not zero) and bends beyond any braid are "possible" too."""
    bend = bends(1000)
    _, l2, l3 = muscles.deltas_from_bend(bend, R).T
    identity = 0.75 * (R * arc.to_polar(bend)[0]) ** 2
    np.testing.assert_allclose(l2**2 + l3**2 + l2 * l3, identity, atol=1e-17)
    assert muscles.inside_possibility_map([1.0, 0.001, 0.001], R)
    arm = Arm()
    longest = arm.length + np.max(muscles.deltas_from_bend(arc.from_polar(3.1, np.pi), R))
    assert muscles.inside_possibility_map(muscles.deltas_from_bend(arc.from_polar(3.1, np.pi), R), R)
    assert longest > arm.length * (1 + arm.muscle.max_stretch)


def test_8_some_muscle_always_lengthens_which_contracting_muscles_cannot_do_by_pushing():
    deltas = muscles.deltas_from_bend(bends(3000)[3:], R)
    assert np.all(deltas.max(axis=-1) > 0)
    assert np.pi * R == pytest.approx(0.0565, abs=1e-4)
    assert np.pi * R / L0 == pytest.approx(0.153, abs=1e-3)
    shortest, longest = Arm().muscle_length_range
    largest = R * np.radians(170)
    assert shortest < L0 - largest  # mounted pre-contracted, the whole dome to 170 deg is within reach
    assert L0 + largest < longest
