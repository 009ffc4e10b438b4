"""Muscle lengths of arc and chain: inverses, symmetries, and chains built link by link from rotations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sampling import bends
from scipy.spatial.transform import Rotation

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, chain, muscles

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
    here, there = (chain.lengths_from_bend(arc.from_polar(a, q), LENGTH, RADIUS, 24) for q in (p, p + 2 * np.pi / 3))
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
    circle = RADIUS * np.column_stack([muscles.DIRECTIONS, np.zeros(3)])
    stations, holes = [p], [circle]
    for _ in range(links):
        p = p + R @ [0, 0, h / 2]
        R = R @ joint
        p = p + R @ [0, 0, h / 2]
        stations.append(p)
        holes.append(p + circle @ R.T)
    lengths = np.linalg.norm(np.diff(np.array(holes), axis=0), axis=-1).sum(axis=0)
    return np.array(stations), R, lengths


@pytest.mark.parametrize("links", [2, 5, 24, 96])
def test_closed_form_chain_is_the_chain_built_link_by_link(links):
    for bend in bends(30, largest=3.0):
        stations, R, lengths = _link_by_link(bend, links)
        np.testing.assert_allclose(chain.station(bend, LENGTH, links, np.arange(links + 1)), stations, atol=1e-14)
        np.testing.assert_allclose(arc.rotation(bend), R, atol=1e-13)
        np.testing.assert_allclose(chain.lengths_from_bend(bend, LENGTH, RADIUS, links), lengths, atol=1e-14)


@pytest.mark.parametrize("links", [3, 24])
def test_chain_lengths_invert(links):
    bend = bends(2000)
    back, residual = chain.bend_from_lengths(
        chain.lengths_from_bend(bend, LENGTH, RADIUS, links), LENGTH, RADIUS, links
    )
    np.testing.assert_allclose(back, bend, atol=2e-13)
    assert np.abs(residual).max() < 1e-15


def test_discretisation_error_falls_with_the_square_of_the_links():
    bend = arc.from_polar(np.radians(170), 0.3)
    errors = [float(chain.discretisation_error(bend, LENGTH, n)) for n in (12, 24, 48)]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.01)
    relative = errors[1] / np.linalg.norm(arc.position(bend, LENGTH))
    assert relative == pytest.approx(np.radians(170) ** 2 / (12 * 24**2), rel=2e-3)
