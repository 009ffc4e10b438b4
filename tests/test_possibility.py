"""The largest bends that pressures hold, against the ideal rod with the same muscle lengths."""

import numpy as np
import pytest
from held_bends import E, largest_bend, polar
from rod import parallel_rod, tension
from scipy.optimize import brentq

from contarm_sim.model.arm import Arm
from contarm_sim.studies.largest_bends import every_bend, held_off, largest_bends, largest_bends_at_rest

PLANES = np.radians(np.arange(0, 360, 5))


def _largest_of_rod(arm, plane):
    """Return the largest bend angle [rad] below pi that pressures hold: lengths held, the rod's tensions shared out.

    Equal tensions of all three do nothing to a rod that cannot twist; so they are free, as without gravity.
    """
    curvature = None

    def room(angle, keep=False):
        nonlocal curvature
        rod = parallel_rod(arm, lengths=arm.length - arm.muscle_radius * E @ polar(angle, plane), guess=curvature)
        curvature = rod.curvature if keep or curvature is None else curvature
        T, per_pascal = rod.tensions - rod.tensions.mean(), tension(1.0, rod.lengths, arm)[0]
        least = (np.maximum(arm.muscle.min_pressure * per_pascal, arm.muscle.min_tension) - T).max()
        return (arm.muscle.max_pressure * per_pascal - T).min() - least

    angle, step = 0.0, np.radians(15)
    while room(angle, keep=True) >= 0:
        angle += step
    return brentq(room, angle - step, angle, xtol=1e-4)


def test_without_gravity_the_map_is_the_rods_in_every_plane():
    inflated, _ = largest_bends(Arm(), PLANES)
    exact = np.array([largest_bend(Arm(), plane) for plane in PLANES])
    np.testing.assert_allclose(np.degrees(inflated), np.degrees(exact), atol=0.3)
    np.testing.assert_allclose(np.degrees(inflated[[0, 18, 3]]), [135.14, 135.50, 130.71], atol=0.1)
    assert np.degrees(every_bend(Arm())) == pytest.approx(130.6, abs=0.2)
    np.testing.assert_array_equal(largest_bends_at_rest(Arm(), PLANES), largest_bends(Arm(), PLANES))


@pytest.mark.parametrize(
    ("gravity", "payload", "uniform"),
    [((0, 0, 9.81), 0.0, 1.0), ((0, 0, 9.81), 0.1, 2.5), ((9.81, 0, 0), 0.0, 1.5), ((5, -4, 7), 0.05, 2.0),
     pytest.param((0, 0, -9.81), 0.0, 1.0, marks=pytest.mark.slow)],
)  # fmt: skip
def test_under_gravity_the_arm_at_rest_has_the_rods_limits_and_one_uniform_bend_nearly(gravity, payload, uniform):
    """Off by `uniform` degrees at most."""
    arm, planes = Arm(gravity=gravity, payload=payload), np.radians([5, 95, 215])
    exact = np.degrees([_largest_of_rod(arm, plane) for plane in planes])
    rest, _ = largest_bends_at_rest(arm, planes)
    np.testing.assert_allclose(np.degrees(rest), exact, atol=0.2)
    closed, _ = largest_bends(arm, planes)
    np.testing.assert_allclose(np.degrees(closed), exact, atol=uniform)
    assert held_off(arm, polar(0.999 * rest[0], planes[0])) < np.radians(0.01)
