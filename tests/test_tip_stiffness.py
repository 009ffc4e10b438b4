"""The tip's stiffness under co-contraction: closed form and simulated arm against the ideal rod."""

import numpy as np
import pytest
from held_bends import held, polar, stiffness

from contarm_sim import studies
from contarm_sim.mechanics.compliance import tip_compliance
from contarm_sim.mechanics.pneumatics import force_slope
from contarm_sim.mechanics.pressures import holding_pressures
from contarm_sim.model.arm import Arm

RATIOS = [1.4426, 1.5597, 1.0000]
"""Most over least co-contraction at 60 degrees towards a muscle: in bending, sideways and along."""


def test_cocontraction_stiffens_the_arm_as_it_does_the_rod():
    bend = polar(np.pi / 3, 0.0)
    rows = studies.stiffness(Arm(), bend, 2).rows
    exact = np.array([stiffness(Arm(), bend, share) for share in (0.0, 1.0)])
    for kind, tolerance in (("closed_form_n_per_m", 1e-4), ("simulated_n_per_m", 1e-2)):
        found = np.array([getattr(row, kind) for row in rows])
        np.testing.assert_allclose(found, exact, rtol=tolerance)
        np.testing.assert_allclose(found[1] / found[0], RATIOS, rtol=1e-3)
    assert rows[1].drift_percent < 1e-6


BENDS = [(5, 2.0), (60, 0.5), (100, 1.0), (130, 0.3)]
"""Bend angle [deg] and plane [rad]."""


@pytest.mark.parametrize("torsional_stiffness", [None, 0.1, 0.03])
@pytest.mark.parametrize(("degrees", "plane"), BENDS)
def test_the_closed_form_is_the_rods(degrees, plane, torsional_stiffness):
    arm, bend = Arm(torsional_stiffness=torsional_stiffness), polar(np.radians(degrees), plane)
    for share in (0.0, 1.0):
        rod, pressures = held(arm, bend, share)
        slopes = force_slope(pressures, rod.lengths, arm)
        closed = tip_compliance(bend, rod.tensions, slopes, arm)
        np.testing.assert_allclose(closed, rod.compliance[:3, :3], atol=1e-9 * closed.max())
        np.testing.assert_allclose(holding_pressures(bend, arm, share), pressures, rtol=2e-3)  # of links, of the rod


@pytest.mark.parametrize("torsional_stiffness", [None, 0.03])
@pytest.mark.parametrize(("degrees", "plane"), BENDS)
def test_the_pushed_arm_is_as_stiff_as_the_rod_within_one_percent(degrees, plane, torsional_stiffness):
    arm, bend = Arm(torsional_stiffness=torsional_stiffness), polar(np.radians(degrees), plane)
    rows = studies.stiffness(arm, bend, 2).rows
    for row, share in zip(rows, (0.0, 1.0), strict=True):
        exact = stiffness(arm, bend, share)
        np.testing.assert_allclose(row.closed_form_n_per_m, exact, rtol=3e-4)
        np.testing.assert_allclose(row.simulated_n_per_m, exact, rtol=1e-2)
