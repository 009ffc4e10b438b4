"""The reference rod against solutions that others found, closed forms, its own equations, and perturbations."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from held_bends import balance, held, largest_bend, polar, stiffness
from random_drives import random_cases
from rod import ANGLES, NoEquilibriumError, parallel_rod, spans_rod
from scipy.integrate import solve_ivp

from contarm_sim.kinematics import arc
from contarm_sim.mechanics.pneumatics import force, force_slope
from contarm_sim.model.arm import Arm

DATA = Path(__file__).parent / "data"
DRIVES = json.loads((DATA / "drives.json").read_text())["cases"]
ELASTICA = json.loads((DATA / "elastica.json").read_text())


@pytest.mark.parametrize("case", DRIVES)
def test_driven_rods_are_those_another_solver_found(case):
    arm = Arm(gravity=tuple(case["gravity"]), payload=case["payload"])
    found = parallel_rod(arm, force=case["force"], moment=case["moment"], **{case["kind"]: case["values"]})
    np.testing.assert_allclose(found.tip, case["tip"], atol=1e-10)
    np.testing.assert_allclose(found.R, case["R"], atol=1e-10)
    np.testing.assert_allclose(found.lengths, case["lengths"], atol=1e-11)
    np.testing.assert_allclose(found.tensions, case["tensions"], atol=1e-8)


@pytest.mark.parametrize("case", ELASTICA["cases"], ids=lambda case: case["name"])
def test_elastica_are_those_two_other_solvers_found(case):
    size = ELASTICA["parameters"]
    arm = Arm(
        length=size["length_m"], bending_stiffness=size["bending_stiffness_Nm2"], mass=size["mass_kg_uniform"],
        gravity=tuple(case["gravity"]), payload=case["payload"],
    )  # fmt: skip
    name = {"act": "actuation_moment", "follower": "follower_moment"}.get(case["kind"], "moment")
    couple = {name: case["moment_Nm"][:2] if case["kind"] == "act" else case["moment_Nm"]}
    if "buckled" in case["name"]:
        couple["guess"] = parallel_rod(replace(arm, gravity=(0, 0, 0)), actuation_moment=(0, 0.3)).curvature
    found = parallel_rod(arm, force=case["tip_force"], **couple)
    np.testing.assert_allclose(found.tip, case["tip"], atol=1e-10)
    np.testing.assert_allclose(found.R, case["R_tip"], atol=1e-10)
    points, _ = found.at(np.linspace(0, 1, 25))
    np.testing.assert_allclose(points, case["centreline"], atol=1e-8)


def _loaded(**changes):
    arm = Arm(gravity=(3.0, -7.0, 5.0), payload=0.05, **changes)
    loads = {"force": (0.2, -0.1, 0.15), "moment": (0.02, 0.01, -0.03)}
    return arm, loads | {"wrenches": ((0.4, (0.3, 0.2, -0.1), (0.01, -0.02, 0.03)),)}


@pytest.mark.parametrize("torsional_stiffness", [None, 0.05])
def test_the_rod_obeys_its_differential_equations_as_rucker_and_webster_write_them(torsional_stiffness):
    """Integrated from the tip down by another method, muscles as forces T t at r: they end at the clamp."""
    arm, loads = _loaded(torsional_stiffness=torsional_stiffness)
    found = parallel_rod(arm, tensions=(30, 12, 22), **loads)
    assert (abs(found.curvature[:, 2]).max() > 0.1) == (torsional_stiffness is not None)
    K = np.array([arm.bending_stiffness, arm.bending_stiffness, torsional_stiffness or 1e9])
    holes = arm.muscle_radius * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES], axis=1)
    chord = K + np.array([0, 0, arm.muscle_radius**2 * found.tensions.sum()])
    ((xi, mid_force, mid_moment),) = loads["wrenches"]

    def curvature(moment):
        u = moment / chord
        for _ in range(50):
            along = np.array([0, 0, 1]) + np.cross(u, holes)
            pulls = found.tensions[:, None] * along / np.linalg.norm(along, axis=1, keepdims=True)
            change = (moment - K * u - np.cross(holes, pulls).sum(axis=0)) / chord
            u = u + change
            if abs(change).max() < 1e-12:
                return u
        raise AssertionError("no curvature balances the moment")

    def down(force):
        def slopes(s, y):
            R = y[3:12].reshape(3, 3)
            beyond = force + ((arm.length - s) * arm.mass / arm.length + arm.payload) * np.array(arm.gravity)
            turn = np.cross(np.eye(3), curvature(R.T @ y[12:]))
            return np.concatenate([R[:, 2], (R @ turn).ravel(), -np.cross(R[:, 2], beyond)])

        return slopes

    upper = down(np.array(loads["force"]))
    lower = down(np.add(loads["force"], mid_force))
    y = np.concatenate([found.tip, found.R.ravel(), loads["moment"]])
    y = solve_ivp(upper, (arm.length, xi * arm.length), y, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    y[12:] += mid_moment
    y = solve_ivp(lower, (xi * arm.length, 0), y, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(y[:3], 0, atol=1e-9)
    np.testing.assert_allclose(y[3:12].reshape(3, 3), np.eye(3), atol=1e-8)


@pytest.mark.parametrize("torsional_stiffness", [None, 0.05])
@pytest.mark.parametrize("disks", [None, 7])
def test_no_bending_changes_the_potential_at_first_order(disks, torsional_stiffness):
    """Elastic energy, weights and dead force, and T dL with lengths measured anew on perturbed shapes."""
    arm, loads = _loaded(torsional_stiffness=torsional_stiffness)
    loads["moment"] = (0, 0, 0)
    loads["wrenches"] = ((0.4, (0.3, 0.2, -0.1), (0, 0, 0)),)
    solve = parallel_rod if disks is None else partial(spans_rod, disks=disks)
    found = solve(arm, tensions=(30, 12, 22), **loads, order=8)
    grid, gravity = found.grid, np.array(arm.gravity)
    K = np.array([arm.bending_stiffness, arm.bending_stiffness, torsional_stiffness or 0])
    holes = arm.muscle_radius * np.stack([np.cos(ANGLES), np.sin(ANGLES), 0 * ANGLES], axis=1)
    xi = np.concatenate([grid.nodes / arm.length, [1.0, 0.4], np.arange((disks or 0) + 1) / (disks or 1)])

    def potential(u):
        points, frames = replace(found, curvature=u).at(xi)
        count = len(grid.nodes)
        energy = grid.weights @ (K * u**2).sum(axis=1) / 2
        energy -= arm.mass / arm.length * grid.weights @ points[:count] @ gravity
        energy -= points[count] @ (arm.payload * gravity + loads["force"])
        energy -= points[count + 1] @ loads["wrenches"][0][1]
        if disks is None:
            lengths = grid.weights @ np.linalg.norm(np.cross(u[:, None], holes) + np.array([0, 0, 1]), axis=-1)
        else:
            ends = points[count + 2 :, None] + np.einsum("kab,ib->kia", frames[count + 2 :], holes)
            lengths = np.linalg.norm(np.diff(ends, axis=0), axis=-1).sum(axis=0)
        np.testing.assert_allclose(lengths, found.lengths, atol=0.01)
        return energy + found.tensions @ lengths

    for seed in range(2):
        wave = np.polynomial.legendre.legval(
            2 * grid.nodes / arm.length - 1, np.random.default_rng(seed).normal(size=4)
        )
        for axis in range(2 if torsional_stiffness is None else 3):
            change = 1e-3 * wave[:, None] * np.eye(3)[axis]
            slope = (potential(found.curvature + change) - potential(found.curvature - change)) / 2
            bend = (potential(found.curvature + change) + potential(found.curvature - change)) / 2
            assert abs(slope) < 1e-9 * np.abs(wave).max()
            assert bend > potential(found.curvature)  # a minimum


def test_uniform_bends_are_the_closed_form():
    arm = Arm()
    for bend in (polar(1.2, 0.4), polar(2.5, 2.0), polar(1e-7, 1.0), polar(0.0, 0.0)):
        for share in (0.0, 0.7):
            rod, pressures = held(arm, bend, share)
            lengths, tensions, least, most = balance(arm, bend)
            np.testing.assert_allclose(rod.lengths, lengths, atol=1e-13)
            np.testing.assert_allclose(rod.tensions, tensions + least + share * (most - least), rtol=1e-11)
            np.testing.assert_allclose(rod.tip, arc.position(bend, arm.length), atol=1e-12)
            np.testing.assert_allclose(
                rod.curvature[:, :2], np.tile([-bend[1], bend[0]], (48, 1)) / arm.length, atol=1e-9
            )
            np.testing.assert_allclose(force(pressures, lengths, arm), rod.tensions, rtol=1e-11)


def test_held_lengths_give_back_the_pose_and_the_differences_of_the_tensions():
    arm, loads = _loaded()
    pulled = parallel_rod(arm, tensions=(30, 12, 22), **loads)
    found = parallel_rod(arm, lengths=pulled.lengths, **loads)
    np.testing.assert_allclose(found.tip, pulled.tip, atol=2e-8)
    np.testing.assert_allclose(found.tensions - found.tensions.mean(), pulled.tensions - 64 / 3, atol=1e-4)


def test_compliances_of_the_straight_arm_are_closed_forms():
    """L^3/(12 EI) + (L/2)^2/(EI/L + 1.5 r^2 dF/dL), and in torsion L/(GJ + r^2 sum T)."""
    arm = Arm(torsional_stiffness=0.05)
    L, EI, r = arm.length, arm.bending_stiffness, arm.muscle_radius
    found = parallel_rod(arm, pressures=(400e3,) * 3)
    lateral = L**3 / (12 * EI) + (L / 2) ** 2 / (EI / L + 1.5 * r**2 * force_slope(400e3, L, arm))
    expected = np.diag([lateral, lateral, 0.0])
    np.testing.assert_allclose(found.compliance[:3, :3], expected, atol=1e-11)
    assert found.compliance[5, 5] == pytest.approx(L / (0.05 + r**2 * found.tensions.sum()), rel=1e-10)


@pytest.mark.parametrize("disks", [None, 6])
def test_compliance_is_what_small_forces_and_couples_do(disks):
    arm, loads = _loaded(torsional_stiffness=0.08)
    loads |= {"pressures": (300e3, 150e3, 220e3), "follower_moment": (0.01, 0.02, -0.01)}
    solve = parallel_rod if disks is None else partial(spans_rod, disks=disks)
    found = solve(arm, **loads)
    for column in range(6):
        moved = []
        for sign in (1, -1):
            probe = sign * 1e-3 * np.eye(6)[column]
            pushed = loads | {"force": loads["force"] + probe[:3], "moment": loads["moment"] + probe[3:] / 10}
            moved.append(solve(arm, **pushed, guess=found.curvature))
        spin = (moved[0].R - moved[1].R) @ found.R.T
        change = np.concatenate([moved[0].tip - moved[1].tip, [spin[2, 1], spin[0, 2], spin[1, 0]]])
        step = 2e-3 if column < 3 else 2e-4
        np.testing.assert_allclose(change / step, found.compliance[:, column], atol=2e-6)


@pytest.mark.parametrize("torsional_stiffness", [None, 0.05])
def test_spans_converge_to_sheaths_with_second_order(torsional_stiffness):
    arm, loads = _loaded(torsional_stiffness=torsional_stiffness)
    limit = parallel_rod(arm, tensions=(30, 12, 22), **loads)
    spans = [spans_rod(arm, disks, tensions=(30, 12, 22), **loads) for disks in (10, 20, 40)]
    errors = [np.linalg.norm(rod.tip - limit.tip) / arm.length for rod in spans]
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.15)
    coarse, fine = (spans[i + 1].tip + (spans[i + 1].tip - spans[i].tip) / 3 for i in (0, 1))
    assert np.linalg.norm(fine + (fine - coarse) / 15 - limit.tip) / arm.length < 3e-6


@pytest.mark.parametrize("kind", ["tensions", "pressures"])
def test_random_cases_are_the_same_again_and_do_not_hang_on_the_grid_or_the_path(kind):
    cases = random_cases(3, 5, kind, twist=True)
    assert [case.rod.tip.tolist() for case in random_cases(3, 2, kind, twist=True)] == [
        case.rod.tip.tolist() for case in cases[:2]
    ]
    for case in cases:
        options = {"force": case.force, "moment": case.moment, kind: case.values}
        finer = parallel_rod(case.arm, **options, panels=10, steps=9)
        np.testing.assert_allclose(finer.tip, case.rod.tip, atol=1e-9)


def test_an_arm_that_buckles_is_refused():
    """Upright under its own weight: m g L^2/EI = 7.84."""
    for load, stands in ((7.8, True), (7.9, False)):
        arm = Arm()
        weight = load * arm.bending_stiffness / (arm.mass * arm.length**2)
        if stands:
            np.testing.assert_allclose(parallel_rod(replace(arm, gravity=(0, 0, -weight))).tip, [0, 0, 0.37])
        else:
            with pytest.raises(NoEquilibriumError, match=r"99\.[0-9] %"):
                parallel_rod(replace(arm, gravity=(0, 0, -weight)))


def test_what_cocontraction_and_pressures_of_the_default_arm_can_do():
    """At 60 degrees; and the largest bends, towards a muscle, square to one, away from one, least."""
    arm, bend = Arm(), polar(np.pi / 3, 0.0)
    ratio = stiffness(arm, bend, 1.0) / stiffness(arm, bend, 0.0)
    np.testing.assert_allclose(ratio, [1.4426, 1.5597, 1.0], atol=1e-4)
    largest = np.degrees([largest_bend(arm, plane) for plane in np.radians([0, 90, 60, 15])])
    np.testing.assert_allclose(largest, [135.14, 135.50, 180.0, 130.71], atol=0.01)
    rod, pressures = held(arm, polar(largest_bend(arm, 0.0), 0.0), 0.0)
    np.testing.assert_allclose(pressures, [700e3, 90e3, 90e3], rtol=1e-6)
    assert rod.margin > 0.09
