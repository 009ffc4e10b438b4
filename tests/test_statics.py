"""Holding tensions against virtual work by finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from sampling import bends

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.compliance import tip_compliance
from contarm_sim.mechanics.pneumatics import force, force_slope, pressure_for
from contarm_sim.mechanics.pressures import holding_pressures
from contarm_sim.mechanics.routing import length_jacobian
from contarm_sim.mechanics.statics import cocontraction, holding_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.mckibben import McKibben
from contarm_sim.statics.equilibrium import equilibrium

STEP = 1e-6


def _lengths(bend, arm):
    return routing.lengths_from_bend(bend, arm)


def test_length_jacobian_is_the_derivative(arm):
    bend = bends(300, largest=3.0)
    for column, direction in enumerate(np.eye(2) * STEP):
        difference = (_lengths(bend + direction, arm) - _lengths(bend - direction, arm)) / (2 * STEP)
        np.testing.assert_allclose(length_jacobian(bend, arm)[..., column], difference, atol=1e-9)


@pytest.mark.parametrize("path", ["parallel", "spans"])
@pytest.mark.parametrize("links", [8, 24, 96])
def test_tensions_do_as_much_virtual_work_as_the_bending_energy(links, path):
    arm = Arm(links=links, path=path)
    bend = bends(200, largest=2.9)
    tensions = holding_tensions(bend, arm)
    joint = arm.bending_stiffness / arm.link_pitch
    np.testing.assert_allclose(tensions.min(axis=-1), arm.muscle.min_tension, rtol=1e-9)
    for direction in np.eye(2) * STEP:

        def energy(b):
            total = routing.section_angles(b, arm.section, arm.routing)[0]
            return 0.5 * joint / arm.links * (total**2).sum(axis=-1)

        work = np.sum(tensions * (_lengths(bend + direction, arm) - _lengths(bend - direction, arm)), axis=-1)
        gained = energy(bend + direction) - energy(bend - direction)
        np.testing.assert_allclose(work + gained, 0, atol=1e-8 * STEP)


@pytest.mark.parametrize("path", ["parallel", "spans"])
def test_cocontraction_moves_nothing_and_is_near_equal_tensions(path):
    arm, bend = Arm(path=path), bends(200, largest=2.9)
    null = cocontraction(bend, arm)[:, 0]
    assert np.abs(np.einsum("nij,ni->nj", length_jacobian(bend, arm), null)).max() < 1e-16
    assert np.abs(null - 1).max() < (1e-12 if path == "parallel" else 0.03)


def test_damping_is_carried_along_the_motion(arm):
    bend, rate = np.array([[0.8, 0.3]]), np.array([[1.0, -2.0]])
    moving = holding_tensions(bend, arm, rate=rate)
    extra = replace(arm, bending_stiffness=arm.bending_stiffness * arm.damping_time)
    by_rate = -np.einsum("nij,ni->nj", length_jacobian(bend, arm), moving - holding_tensions(bend, arm))
    turn = routing.section_angles(bend, arm.section, arm.routing)[1][0]
    np.testing.assert_allclose(by_rate, extra.bending_stiffness / arm.length * rate @ turn @ turn, rtol=1e-10)
    np.testing.assert_allclose(turn, np.eye(2), atol=1e-3)


def test_servos_keep_pulling_beside_the_damping_of_lengthening_muscles(arm):
    bend, rate = np.array([[0.8, 0.3]]), np.array([[4.0, -3.0]])
    speeds = (length_jacobian(bend, arm) @ rate[..., None])[..., 0]
    tensions = holding_tensions(bend, arm, rate=rate)
    by_servo = tensions - arm.servo_stiffness * arm.servo_time * speeds
    assert speeds.max() > 0.02
    assert by_servo.min() == pytest.approx(0.2 * arm.muscle.min_tension)
    assert tensions.min() >= arm.muscle.min_tension


def test_too_few_links_cannot_be_held_by_pulling():
    with pytest.raises(InputError, match="more links"):
        holding_tensions(arc.from_polar(2.9, 0.1), Arm(links=2, path="spans"))


def test_mckibben_force_and_its_inverse(arm):
    """Blocked force at rest length, nothing at full contraction, and pressure_for undoes force."""
    rest = arm.muscle_rest_length
    assert force(arm.muscle.max_pressure, rest, arm) == pytest.approx(arm.muscle.blocked_force)
    assert force(arm.muscle.max_pressure, rest * (1 - arm.muscle.max_contraction), arm) == pytest.approx(0, abs=1e-9)
    assert force(7e5, rest * 0.7, arm) == 0
    lengths = np.linspace(0.76, 1.1, 50) * rest
    np.testing.assert_allclose(pressure_for(force(3e5, lengths, arm), lengths, arm), 3e5, rtol=1e-12)
    assert pressure_for(1.0, rest * 0.7, arm) == np.inf


def test_700_kpa_holds_bends_to_about_155_degrees(arm):
    angle = np.radians(np.arange(100, 171))
    bend = arc.from_polar(angle, 0.0)
    pressure = pressure_for(holding_tensions(bend, arm), _lengths(bend, arm), arm).max(axis=-1)
    assert np.degrees(angle[np.argmax(pressure > 7e5)]) == pytest.approx(155, abs=4)


def test_force_slope_is_the_derivative(arm):
    lengths = np.linspace(0.78, 1.1, 30) * arm.muscle_rest_length
    slope = (force(4e5, lengths + 1e-7, arm) - force(4e5, lengths - 1e-7, arm)) / 2e-7
    np.testing.assert_allclose(force_slope(4e5, lengths, arm), slope, rtol=1e-6)


def test_tip_compliance_of_a_straight_arm_is_the_beam_formula(arm):
    """L^3/(12 EI) + (L/2)^2/(EI/L + k_m) sideways with equal springs, L^3/(3 EI) without, nothing along the axis."""
    L, B, zero = arm.length, arm.bending_stiffness, np.zeros(3)
    free = tip_compliance([0.0, 0.0], zero, zero, arm)
    np.testing.assert_allclose(free, np.diag([L**3 / (3 * B), L**3 / (3 * B), 0]), atol=1e-12)
    k_m = 1.5 * arm.muscle_radius**2 * 700.0
    held = tip_compliance([0.0, 0.0], zero, np.full(3, 700.0), arm)[0, 0]
    assert held == pytest.approx(L**3 / (12 * B) + (L / 2) ** 2 / (B / L + k_m), rel=1e-12)
    rigid = tip_compliance([0.0, 0.0], zero, np.full(3, 1e12), arm)[0, 0]
    assert free[0, 0] / rigid == pytest.approx(4, rel=1e-6)


def test_tensions_that_buckle_the_chain_between_disks_are_refused(arm):
    spans = replace(arm, path="spans")
    limit = 12 * arm.bending_stiffness / arm.link_pitch**2
    with pytest.raises(InputError, match="buckles"):
        tip_compliance([0.0, 0.0], np.full(3, 1.01 * limit / 3), np.zeros(3), spans)
    soft = tip_compliance([0.0, 0.0], np.full(3, 0.5 * limit / 3), np.zeros(3), spans)[0, 0]
    straight = tip_compliance([0.0, 0.0], np.full(3, 0.5 * limit / 3), np.zeros(3), arm)[0, 0]
    assert soft == pytest.approx(2 * straight)  # parallel muscles soften nothing


def test_torsion_adds_to_the_tips_compliance_less_what_muscles_pull_back():
    """Straight, twist moves nothing; bent, it softens sideways, and the muscles' r^2 sum(T L/L_i) stiffens it."""
    soft = Arm(torsional_stiffness=0.05)
    bend, zero = arc.from_polar(1.0, 0.0), np.zeros(3)
    np.testing.assert_allclose(
        tip_compliance([0.0, 0.0], zero, zero, soft), tip_compliance([0.0, 0.0], zero, zero, Arm()), atol=1e-15
    )
    extra = [
        (tip_compliance(bend, t, zero, soft) - tip_compliance(bend, t, zero, Arm()))[1, 1] for t in (zero, zero + 50)
    ]
    assert extra[0] > 0.01
    shorter = (soft.length / routing.lengths_from_bend(bend, soft)).sum()
    assert extra[0] / extra[1] == pytest.approx(1 + soft.muscle_radius**2 * 50 * shorter / 0.05, rel=1e-6)


def test_lengths_that_a_braid_cannot_take_and_chains_that_would_buckle_are_refused():
    tight = Arm(muscle=McKibben(mount_contraction=0.0))
    with pytest.raises(InputError, match="length it cannot take"):
        holding_pressures(arc.from_polar(3.0, np.pi), tight)
    with pytest.raises(InputError, match="buckle"):
        holding_pressures(arc.from_polar(1.0, 0.0), Arm(bending_stiffness=0.0003, path="spans"))
    coarse = Arm(links=8, path="spans")
    tensions = holding_pressures(arc.from_polar(1.0, 0.0), coarse, share=1.0)
    held = equilibrium(coarse, Load(muscles=Muscles(kind="pressures", values=tuple(tensions))))
    assert held.stable
