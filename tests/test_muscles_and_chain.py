"""Muscle lengths of arc and chain: inverses, symmetries, and chains built link by link from rotations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sampling import bends
from scipy.spatial.transform import Rotation

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, chain, hinges, muscles, spans
from contarm_sim.model.section import GUIDE

LENGTH, RADIUS = 0.37, 0.018
angle = st.floats(0, 3.14)
plane = st.floats(-3.14, 3.14)


@given(angle, plane)
def test_deltas_round_trip_and_sum_to_zero(a, p):
    bend = arc.from_polar(a, p)
    deltas = muscles.deltas_from_bend(bend, RADIUS)
    back, residual = muscles.bend_from_deltas(deltas, RADIUS)
    np.testing.assert_allclose(back, bend, atol=1e-14)
    assert abs(residual) < 1e-16
    assert muscles.inside_possibility_map(deltas, RADIUS)


@given(angle, plane)
def test_turning_the_plane_by_120_degrees_permutes_the_muscles(a, p):
    turned = muscles.deltas_from_bend(arc.from_polar(a, p + 2 * np.pi / 3), RADIUS)
    np.testing.assert_allclose(np.roll(muscles.deltas_from_bend(arc.from_polar(a, p), RADIUS), 1), turned, atol=1e-15)
    here, there = (spans.lengths_from_bend(arc.from_polar(a, q), _guides(24)) for q in (p, p + 2 * np.pi / 3))
    np.testing.assert_allclose(np.roll(here, 1), there, atol=1e-15)


@given(angle, plane)
def test_mirroring_the_plane_swaps_muscles_2_and_3(a, p):
    here, there = (muscles.deltas_from_bend(arc.from_polar(a, q), RADIUS) for q in (p, -p))
    np.testing.assert_allclose(here[[0, 2, 1]], there, atol=1e-15)


def test_a_sum_that_is_not_zero_is_refused_and_said():
    with pytest.raises(InputError, match=r"0\.003 m"):
        muscles.bend_from_deltas([0.001, 0.001, 0.001], RADIUS, tolerance=1e-6)
    with pytest.raises(InputError, match="below pi"):
        muscles.bend_from_deltas([-0.06, 0.03, 0.03], RADIUS, tolerance=1e-6)


def test_the_ellipse_bounds_the_possibility_map():
    edge = muscles.possibility_ellipse(RADIUS)
    third = -edge.sum(axis=1, keepdims=True)
    inner, outer = (np.hstack([third, edge]) * f for f in (0.999, 1.001))
    assert muscles.inside_possibility_map(inner, RADIUS).all()
    assert not muscles.inside_possibility_map(outer, RADIUS).any()


def _link_by_link(bend, links):
    """Multiply out the chain: half link, joint, link, ..., joint, half link; stations and muscle polylines."""
    h = LENGTH / links
    joint = Rotation.from_rotvec(np.array([-bend[1], bend[0], 0]) / links).as_matrix()
    p, R = np.zeros(3), np.eye(3)
    circle = RADIUS * np.column_stack([muscles.directions(), np.zeros(3)])
    stations, pieces = [p], []
    for _ in range(links):
        p = p + R @ [0, 0, h / 2]
        below = p - R @ [0, 0, h / 2 - GUIDE * h] + circle @ R.T
        R = R @ joint
        p = p + R @ [0, 0, h / 2]
        stations.append(p)
        height = GUIDE * h if len(stations) <= links else 0.0
        pieces.append(np.linalg.norm(p + R @ [0, 0, height] + circle @ R.T - below, axis=-1))
    return np.array(stations), R, GUIDE * h + np.sum(pieces, axis=0)


@pytest.mark.parametrize("links", [2, 5, 24, 96])
def test_closed_form_chain_is_the_chain_built_link_by_link(links):
    for bend in bends(30, largest=3.0):
        stations, R, lengths = _link_by_link(bend, links)
        np.testing.assert_allclose(chain.station(bend, LENGTH, links, np.arange(links + 1)), stations, atol=1e-14)
        np.testing.assert_allclose(arc.rotation(bend), R, atol=1e-13)
        np.testing.assert_allclose(spans.lengths_from_bend(bend, _guides(links)), lengths, atol=1e-14)


@pytest.mark.parametrize("links", [4, 24])
def test_lengths_of_spans_invert_and_their_jacobian_is_the_derivative(links):
    bend, guides, step = bends(2000), _guides(links), 1e-6
    back, residual = spans.bend_from_lengths(spans.lengths_from_bend(bend, guides), guides)
    np.testing.assert_allclose(back, bend, atol=2e-13)
    assert np.abs(residual).max() < 1e-15
    for column, way in enumerate(step * np.eye(2)):
        ahead, behind = (spans.lengths_from_bend(b, guides) for b in (bend + way, bend - way))
        slope = spans.length_jacobian(bend, guides)[..., column]
        np.testing.assert_allclose(slope, (ahead - behind) / (2 * step), atol=1e-9)


def test_spans_shorten_as_between_the_disks_of_a_rod_that_bends_evenly():
    """Between disks the rod is an arc of length h and angle beta: a chord h sinc(beta/2) - 2 rho sin(beta/2)."""
    links = 24
    for bend in bends(50, largest=2.0):
        half = np.hypot(*bend) / (2 * links)
        rod = (LENGTH - RADIUS * (muscles.directions() @ bend)) * np.sinc(half / np.pi)
        softening, third = LENGTH * half**2 / 6, RADIUS * links * (2 * half) ** 3 / 12
        found = spans.lengths_from_bend(bend, _guides(links))
        np.testing.assert_allclose(found, rod, atol=0.05 * softening + 1.1 * third)


def _guides(links):
    return spans.Guides(LENGTH, RADIUS, GUIDE * LENGTH / links, links)


def test_hinge_angles_invert_and_their_slope_is_the_derivative():
    bend, links, step = bends(2000), 12, 1e-6
    total, slope = hinges.angles(bend, links)
    np.testing.assert_allclose(hinges.bend_from_angles(total, links), bend, atol=1e-14)
    for column, way in enumerate(step * np.eye(2)):
        difference = (hinges.angles(bend + way, links)[0] - hinges.angles(bend - way, links)[0]) / (2 * step)
        np.testing.assert_allclose(slope[..., column], difference, atol=1e-9)


@pytest.mark.parametrize("links", [12, 24, 48])
def test_hinge_pairs_keep_the_tip_of_ball_joints_to_third_order(links):
    bend = bends(200, largest=2.9)
    off = np.linalg.norm(hinges.tip(bend, LENGTH, links) - chain.tip(bend, LENGTH, links), axis=-1)
    assert off.max() < 1.5e-5 * (24 / links) ** 3


def test_discretisation_error_falls_with_the_square_of_the_links():
    bend = arc.from_polar(np.radians(170), 0.3)
    errors = [float(chain.discretisation_error(bend, LENGTH, n)) for n in (12, 24, 48)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.01)
    relative = errors[1] / np.linalg.norm(arc.position(bend, LENGTH))
    assert relative == pytest.approx(np.radians(170) ** 2 / (12 * 24**2), rel=2e-3)


@pytest.mark.parametrize("links", [2, 12, 24])
def test_straight_spans_are_as_long_as_the_theory_page_says(links):
    """The formula of docs/theory/chain.md, term by term; and what the arc's lengths are off by in common mode."""
    phi, plane_angle, pitch = 1.7, 0.4, LENGTH / links
    beta, g = phi / links, GUIDE * pitch
    rho = RADIUS * np.cos(np.array(muscles.PAPER) - plane_angle)

    def span(a, b):
        half = np.sin(0.5 * beta) ** 2
        return np.sqrt((a + b) ** 2 - 4 * a * b * half + 4 * rho**2 * half - 2 * rho * (a + b) * np.sin(beta))

    expected = g + (links - 1) * span(0.5 * pitch - g, 0.5 * pitch + g) + span(0.5 * pitch - g, 0.5 * pitch)
    bend = arc.from_polar(phi, plane_angle)
    lengths = spans.lengths_from_bend(bend, spans.Guides(LENGTH, RADIUS, g, links))
    np.testing.assert_allclose(lengths, expected, atol=1e-15)
    if links > 2:
        common = (lengths - LENGTH - muscles.deltas_from_bend(bend, RADIUS)).mean()
        assert common == pytest.approx(-LENGTH * phi**2 / (24 * links**2), rel=0.03)
