"""Arms of several sections with straight muscles, against the ideal rod with disks at their stations, and without."""

import numpy as np
import pytest
from random_sections import random_cases
from rod import spans_rod
from rod_spans import spans_of_sections

from contarm_sim.model.arm import Arm
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section

WRENCHES = ((0.3, (0.4, -0.2, 0.1), (0.02, 0.01, 0.03)), (1.0, (0.1, 0.3, -0.2), (0.0, 0.02, 0.05)))
LOADED = {"gravity": (1.0, -2.0, 9.0), "payload": 0.05}


@pytest.mark.parametrize("torsion", [None, 0.05])
@pytest.mark.parametrize("drive", [{"tensions": (6.0, 1.0, 2.0)}, {"pressures": (4e5, 1e5, 2e5)}], ids=str)
def test_two_equal_sections_with_muscles_from_the_base_are_the_rod_of_one(torsion, drive):
    half = Section(length=0.185, links=4, mass=0.15, torsional_stiffness=torsion)
    two = Arm(sections=(half, half), routings=(Routing(count=0), Routing(start="base")), **LOADED)
    found = spans_of_sections(two, wrenches=WRENCHES, **drive)
    one = spans_rod(Arm(torsional_stiffness=torsion, **LOADED), 8, wrenches=WRENCHES, **drive)
    np.testing.assert_allclose(found.tip, one.tip, atol=1e-6)
    np.testing.assert_allclose(found.lengths, one.lengths, atol=1e-7)
    np.testing.assert_allclose(found.compliance, one.compliance, atol=1e-5)


def _converges(cases):
    coarse, fine = np.array([[case.span_error(links) for links in (12, 24)] for case in cases]).T
    assert np.median(fine) <= 0.1
    assert fine.max() <= 0.4
    assert np.median(np.log2(coarse / fine)) > 1.9


@pytest.mark.parametrize("drive", ["tensions", "pressures"])
def test_straight_spans_are_those_between_the_disks_of_a_rod(drive):
    _converges(random_cases(15, 1, drive, start="base"))


@pytest.mark.slow
@pytest.mark.parametrize("drive", ["tensions", "pressures"])
@pytest.mark.parametrize("start", ["section", "base"])
def test_so_are_many(drive, start):
    _converges(random_cases(15, 4, drive, start=start))


@pytest.mark.parametrize("start", ["section", "base"])
@pytest.mark.parametrize(("size", "drive"), [(2, "tensions"), (3, "pressures")])
def test_straight_spans_come_to_the_rod_too_as_their_disks_become_many(size, drive, start):
    """Between few disks they pull another way: up to 3 % of length off at 24 links a section."""
    (case,) = random_cases(52, 1, drive, size, start)
    coarse, fine = (case.error(links, "spans") for links in (24, 48))
    assert coarse < 5
    assert np.log2(coarse / fine) == pytest.approx(2, abs=0.1)
