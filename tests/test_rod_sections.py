"""Loaded arms of several sections against the ideal rod; and that rod against closed forms, another solver, statics."""

from itertools import pairwise

import numpy as np
import pytest
from random_sections import random_cases
from rod import parallel_rod
from rod_sections import rod
from scipy.linalg import expm
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from contarm_sim.kinematics.muscles import directions
from contarm_sim.mechanics import pneumatics
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Wrench
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.statics.equilibrium import equilibrium

pytestmark = pytest.mark.slow  # by hand: all checks are to take less than ten minutes

UNLIKE = (
    Section(length=0.2, mass=0.1, bending_stiffness=0.12, torsional_stiffness=0.08),
    Section(length=0.15, mass=0.05, bending_stiffness=0.07),
    Section(length=0.1, mass=0.03, bending_stiffness=0.05, torsional_stiffness=0.03),
)
WRENCHES = ((0.3, (0.4, -0.2, 0.1), (0.02, 0.01, 0.03)), (1.0, (0.1, 0.3, -0.2), (0.0, 0.02, 0.05)))
LOADED = {"gravity": (1.0, -2.0, 9.0), "payload": 0.05}


def unlike(start, **world):
    """Return an arm of three unlike sections, one of them rigid against twist, with 3, 4 and 3 muscles."""
    routings = (
        Routing(radius=0.018, offset=0.3, start=start),
        Routing(radius=0.016, count=4, offset=-0.7, start=start),
        Routing(radius=0.014, offset=1.1, start=start),
    )
    laws = (McKibben(), McKibben(wall=0.0015), McKibben(mount_contraction=0.03))
    return Arm(sections=UNLIKE, routings=routings, laws=laws, **world)


@pytest.mark.parametrize("start", ["section", "base"])
def test_tensions_bend_each_section_of_the_rod_to_an_arc(start):
    """Of curvature r/EI sum T u, of what runs through: frames are products of matrix exponentials."""
    arm, pulls = unlike(start), (np.array([9.0, 2.0, 4.0]), np.array([1.0, 5.0, 3.0, 2.0]), np.array([6.0, 0.0, 2.0]))
    own = [line.radius * T @ directions(line.angles) for line, T in zip(arm.routings, pulls, strict=True)]
    frame, ends, lengths = np.eye(4), [np.zeros(3)], []
    for number, section in enumerate(UNLIKE):
        x, y = sum(own[number:] if start == "base" else own[number : number + 1]) / section.bending_stiffness
        frame = frame @ expm(section.length * np.array([[0, 0, x, 0], [0, 0, y, 0], [-x, -y, 0, 1], [0, 0, 0, 0]]))
        ends.append(frame[:3, 3])
        lengths.append(section.length * np.array([1 - line.radius * directions(line.angles) @ [x, y] for line in
                                                  arm.routings], dtype=object))  # fmt: skip
    found = rod(arm, tensions=np.concatenate(pulls))
    points, turns = found.at(np.cumsum([0.0, *(section.length for section in UNLIKE)]))
    np.testing.assert_allclose(points, ends, atol=1e-8)
    np.testing.assert_allclose(turns[-1], frame[:3, :3], atol=1e-7)
    through = [sum(part[k] for part in lengths[0 if start == "base" else k : k + 1]) for k in range(3)]
    np.testing.assert_allclose(found.lengths, np.concatenate(through), atol=1e-8)


@pytest.mark.parametrize("load", [0.5, 2.0, 8.0])
def test_a_force_across_the_tip_bends_the_rod_to_the_elastica(load):
    """Of F L^2/EI: sqrt of it is K(k) - F(k, phi), 2 k^2 sin(phi)^2 = 1; 2 k^2 = 1 + sin of the tip's turn."""
    sections = (Section(length=0.2), Section(length=0.1))
    length, EI = 0.3, sections[0].bending_stiffness
    m = brentq(lambda m: ellipk(m) - ellipkinc(np.arcsin(np.sqrt(0.5 / m)), m) - np.sqrt(load), 0.5 + 1e-12, 1 - 1e-12)
    across = 1 - 2 * (ellipe(m) - ellipeinc(np.arcsin(np.sqrt(0.5 / m)), m)) / np.sqrt(load)
    along = np.sqrt(2 * (2 * m - 1) / load)
    wrench = (1.0, load * EI / length**2 * np.array([0.6, 0.8, 0.0]), np.zeros(3))
    found = rod(
        Arm(sections=sections, routings=(Routing(count=0),) * 2), wrenches=[(0.4, (0, 0, 0), (0, 0, 0)), wrench]
    )
    points, turns = found.at([length])
    np.testing.assert_allclose(points[0], length * np.array([0.6 * across, 0.8 * across, along]), atol=3e-8)
    assert turns[0, 2, 2] == pytest.approx(np.sqrt(1 - (2 * m - 1) ** 2), abs=1e-6)


@pytest.mark.parametrize("torsion", [None, 0.05])
@pytest.mark.parametrize(
    "drive",
    [{"tensions": (20.0, 10.0, 12.0)}, {"pressures": (4e5, 1e5, 2e5)}, {"actuation_moment": (0.1, 0.2)}],
    ids=lambda drive: next(iter(drive)),
)
def test_two_equal_sections_with_muscles_from_the_base_are_the_rod_of_one(torsion, drive):
    """Which another solver finds, by collocation of the integrals of its equations."""
    half = Section(length=0.185, mass=0.15, torsional_stiffness=torsion)
    two = Arm(sections=(half, half), routings=(Routing(count=0), Routing(start="base")), **LOADED)
    more = {"wrenches": WRENCHES, "follower_moment": (0.02, -0.05, 0.03), **drive}
    found, one = rod(two, **more), parallel_rod(Arm(torsional_stiffness=torsion, **LOADED), **more)
    xi = np.linspace(0, 1, 20)
    for own, other in zip(found.at(0.37 * xi), one.at(xi), strict=True):
        np.testing.assert_allclose(own, other, atol=1e-6)
    np.testing.assert_allclose(found.lengths, one.lengths, atol=1e-8)
    np.testing.assert_allclose(found.tensions, one.tensions, atol=1e-5)


@pytest.mark.parametrize("start", ["section", "base"])
def test_rod_and_muscles_carry_together_what_is_beyond(start):
    arm = unlike(start, **LOADED)
    pressures = np.array([2.0, 1.0, 0.5, 1.0, 1.5, 0.7, 1.2, 0.4, 0.0, 1.1]) * 1e5
    found, gravity = rod(arm, pressures=pressures, wrenches=WRENCHES), np.array(arm.gravity)
    np.testing.assert_allclose(found.tensions, pneumatics.force(pressures, found.lengths, arm), atol=1e-6)
    ends, (x, weight) = np.cumsum([0.0, *(s.length for s in UNLIKE)]), np.polynomial.legendre.leggauss(16)
    edges = np.unique([*ends, 0.3 * ends[-1]])
    s = 0.5 * (edges[:-1] + edges[1:])
    for at, force, moment in zip(s, *found.moments(s), strict=True):
        here, F, M = found.at([at])[0][0], np.zeros(3), np.zeros(3)
        for xi, *dead in (*WRENCHES, (1.0, arm.payload * gravity, np.zeros(3))):
            if xi * ends[-1] > at:
                F, M = F + dead[0], M + dead[1] + np.cross(found.at([xi * ends[-1]])[0][0] - here, dead[0])
        for low, high in pairwise(edges):  # the weight of a section, in pieces
            low = max(low, at)
            if low < high:
                own = UNLIKE[np.searchsorted(ends, 0.5 * (low + high)) - 1]
                share = own.mass / own.length * 0.5 * (high - low) * weight
                points = found.at(0.5 * (low + high) + 0.5 * (high - low) * x)[0]
                F, M = F + share.sum() * gravity, M + np.cross(share @ (points - here), gravity)
        np.testing.assert_allclose(force, F, atol=2e-5)
        np.testing.assert_allclose(moment, M, atol=2e-6)


FEW = [("moments", 2, "base", True), ("tensions", 2, "section", False), ("tensions", 2, "base", True),
       ("pressures", 2, "section", False), ("pressures", 3, "base", True)]  # fmt: skip
DRIVEN = [("moments", "base"), ("tensions", "section"), ("tensions", "base"), ("pressures", "section"),
          ("pressures", "base")]  # fmt: skip


def _converges(cases):
    coarse, middle, fine = np.array([[case.error(links) for links in (12, 24, 48)] for case in cases]).T
    assert np.median(middle) <= 0.1
    assert middle.max() <= 0.4
    for ratio in (coarse / middle, middle / fine):
        assert np.median(np.log2(ratio)) == pytest.approx(2, abs=0.15)
    assert np.log2(coarse / fine).min() > 2.5  # of each, over two doublings: it depends on where on a link a load is


def test_arms_of_several_sections_converge_to_the_rod_with_second_order():
    _converges([case for few in FEW for case in random_cases(51, 1, *few)])


@pytest.mark.slow
@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize(("drive", "start"), DRIVEN)
def test_so_do_many_that_twist_or_do_not(drive, start, size):
    _converges([case for twist in (False, True) for case in random_cases(2051, 4, drive, size, start, twist)])


@pytest.mark.parametrize("few", FEW[2::2], ids=str)
def test_lengths_tensions_turns_and_compliance_are_the_rods(few):
    (case,) = random_cases(53, 1, *few)
    found, length = equilibrium(case.at(24), case.load), case.arm.length
    np.testing.assert_allclose(found.muscle_lengths, case.rod.lengths, atol=1e-4 * length)
    np.testing.assert_allclose(found.muscle_tensions, case.rod.tensions, rtol=2e-3)
    turn = Rotation.from_matrix(found.frames[-1, :3, :3].T @ case.rod.at([length])[1][0])
    assert np.degrees(turn.magnitude()) < 0.1
    push, tips = np.random.default_rng(0).normal(size=6) * ([0.01] * 3 + [0.001] * 3), []
    for sign in (1, -1):
        small = Wrench(xi=1, force=tuple(sign * push[:3]), moment=tuple(sign * push[3:]))
        tips.append(case.under(*case.load.wrenches, small).rod.at([length])[0][0])
    moved = found.tip_compliance[:3] @ push
    assert np.linalg.norm((tips[0] - tips[1]) / 2 - moved) < 0.01 * np.linalg.norm(moved)


@pytest.mark.parametrize("past", [-0.5, 0.0, 0.5])
def test_loads_about_the_end_of_a_section_are_in_their_place(past):
    """In pitches before and after it, of 12 links and 16; at half a pitch there is a joint."""
    (case,) = random_cases(54, 1, "tensions", 2, "base")
    first, second = (section.length for section in case.arm.sections)
    xi = (first + past * (first / 12 if past < 0 else second / 16)) / case.arm.length
    loaded = case.under(Wrench(xi=xi, force=(0.3, -0.5, 0.2), moment=(0.05, 0.06, -0.04)))
    coarse, middle, fine = (loaded.error((12 * times, 16 * times)) for times in (1, 2, 4))
    assert middle < 0.1
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.6)  # over two doublings
