"""Arms of two and three sections driven by lengths, tensions and pressures, against closed forms and derivatives."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from contarm_sim.errors import InputError
from contarm_sim.kinematics import sections
from contarm_sim.mechanics import compliance, routing, shape
from contarm_sim.mechanics.moments import weight_moment, wrench_moment
from contarm_sim.mechanics.pressures import holding_pressures, level_range, pressure_needed
from contarm_sim.mechanics.statics import balance, cocontraction, holding_tensions
from contarm_sim.mjcf import arm_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import compare
from contarm_sim.statics.equilibrium import driven_plant, equilibrium

SECTIONS = (
    Section(length=0.2, links=12, mass=0.12),
    Section(length=0.17, links=10, mass=0.1, bending_stiffness=0.08),
    Section(length=0.12, links=8, mass=0.05, bending_stiffness=0.06),
)
STEP = 1e-6


def arm(count=2, path="parallel", start="section", **world):
    lines = [Routing(path=path)]
    lines += [Routing(path=path, count=3 + i, offset=0.4 * i, radius=0.016, start=start) for i in range(1, count)]
    return Arm(sections=SECTIONS[:count], routings=tuple(lines), **world)


def bends(count, poses=20, largest=1.5):
    rng = np.random.default_rng(3)
    angle, plane = rng.uniform(0, largest, (poses, count)), rng.uniform(-np.pi, np.pi, (poses, count))
    return np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1).reshape(poses, -1)


PATHS = pytest.mark.parametrize("path", ["parallel", "spans"])
STARTS = pytest.mark.parametrize("start", ["section", "base"])
COUNTS = pytest.mark.parametrize("count", [2, 3])


@PATHS
@STARTS
@COUNTS
def test_lengths_of_the_chain_are_the_engines_and_invert(path, start, count):
    one, bend = arm(count, path, start), bends(count, 5)
    lengths = routing.lengths_from_bend(bend, one)
    back, residual = routing.bend_from_lengths(lengths, one)
    np.testing.assert_allclose(back, bend, atol=1e-12)
    np.testing.assert_allclose(residual, 0, atol=1e-13)
    off = []
    for b, L in zip(bend, lengths, strict=True):
        plant = driven_plant(one, Load())
        plant.reset(b)
        plant.pose()
        off.append(np.abs(plant.muscle_lengths - L).max())
    assert max(off) < (1e-15 if path == "parallel" else 3e-4)  # hinge pairs are no ball joints, to third order


@STARTS
@COUNTS
def test_straight_spans_are_distances_between_guides_of_a_chain_of_ball_joints(start, count):
    one, bend = arm(count, "spans", start), bends(count, 5)
    places = shape.stations(one)
    chained = sections.transform(shape.bends_of(bend, one)[:, None], shape.backbone(one, chained=True), places)
    first = np.concatenate([[0], np.cumsum([section.links for section in one.sections])])
    found, column = routing.lengths_from_bend(bend, one), 0
    for group in one.groups:
        for x, y in group.routing.points:
            points = [chained[:, first[group.first]] @ [x, y, 0, 1]]
            for number in range(group.first, group.section + 1):
                height = one.sections[number].guide_height
                for station in range(first[number], first[number + 1]):
                    points.append(chained[:, station] @ [x, y, height, 1])
            points.append(chained[:, first[group.section + 1]] @ [x, y, 0, 1])
            total = np.linalg.norm(np.diff(points, axis=0), axis=-1).sum(axis=0)
            np.testing.assert_allclose(found[:, column], total, atol=1e-14)
            column += 1


@PATHS
@STARTS
@COUNTS
def test_the_jacobian_is_the_derivative_of_lengths(path, start, count):
    one, bend = arm(count, path, start), bends(count)
    J = routing.length_jacobian(bend, one)
    for column in range(2 * count):
        off = np.zeros(2 * count)
        off[column] = STEP
        change = routing.lengths_from_bend(bend + off, one) - routing.lengths_from_bend(bend - off, one)
        np.testing.assert_allclose(J[..., column], change / (2 * STEP), atol=1e-9)


def test_lengths_of_arcs_are_written_out_and_invert():
    one = arm(3, start="base")
    bend = bends(3, 4)
    found = routing.arc_deltas(bend, one)
    first = 0
    for number, line in enumerate(one.routings):
        total = sum(bend[:, 2 * k : 2 * k + 2] for k in range(number + 1))
        for i, psi in enumerate(line.angles):
            expected = -line.radius * (np.cos(psi) * total[:, 0] + np.sin(psi) * total[:, 1])
            np.testing.assert_allclose(found[:, first + i], expected, atol=1e-15)
        first += line.count
    back, residual = routing.bend_from_arc_deltas(found, one)
    np.testing.assert_allclose(back, bend, atol=1e-12)
    np.testing.assert_allclose(residual, 0, atol=1e-15)
    assert np.abs(routing.bend_from_arc_deltas(found + 1e-3, one)[1] - 1e-3).max() < 1e-15


@COUNTS
def test_moments_of_weight_and_wrench_are_derivatives_of_work(count):
    one, bend = arm(count, gravity=(1.0, -2.0, 9.0), payload=0.05), bends(count)
    force, moment = np.array([0.3, -0.2, 0.4]), np.array([0.02, 0.03, -0.01])
    xi = (np.arange(4000) + 0.5) / 4000
    weights = np.interp(xi * one.length, np.cumsum([s.length for s in one.sections]), range(count), left=0)
    density = np.array([s.mass / s.length for s in one.sections])
    number = np.minimum(np.searchsorted(np.cumsum([s.length for s in one.sections]), xi * one.length), count - 1)
    assert len(weights) == len(number)

    def work(b):
        places = shape.position(b[:, None], one, xi) * (density[number] * one.length / 4000)[:, None]
        return (places.sum(axis=1) + one.payload * shape.position(b, one)) @ np.array(one.gravity)

    for column in range(2 * count):
        off = np.zeros(2 * count)
        off[column] = 1e-5
        rate = (work(bend + off) - work(bend - off)) / 2e-5
        np.testing.assert_allclose(weight_moment(bend, one)[:, column], rate, atol=5e-5)
        T, up, down = (shape.transform(b, one) for b in (bend, bend + off, bend - off))
        move = (up - down)[:, :3, 3] / 2e-5
        spin = ((up - down)[:, :3, :3] / 2e-5) @ T[:, :3, :3].swapaxes(1, 2)
        turn = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
        expected = move @ force + turn @ moment
        np.testing.assert_allclose(wrench_moment(bend, force, moment, one)[:, column], expected, atol=1e-8)


@PATHS
@STARTS
@COUNTS
def test_tensions_balance_every_section_and_co_contraction_moves_none(path, start, count):
    one, bend = arm(count, path, start, gravity=(1.0, -2.0, 9.0)), bends(count)
    held, J = balance(bend, one), routing.length_jacobian(bend, one)
    np.testing.assert_allclose(np.einsum("bij,bsi->bsj", J, held.cocontraction), 0, atol=1e-14)
    assert all((held.cocontraction[:, k, own] > 0).all() for k, own in enumerate(held.own))
    tensions = holding_tensions(bend, one)
    least = np.stack([tensions[:, own].min(axis=1) for own in held.own], axis=-1)
    np.testing.assert_allclose(least, one.muscle.min_tension, rtol=1e-9)
    work = np.einsum("bij,bi->bj", J, tensions)
    elastic = []
    for k, section in enumerate(one.sections):
        angle, turn = routing.section_angles(bend[:, 2 * k : 2 * k + 2], section, one.routings[k])
        elastic.append(section.bending_stiffness / section.length * np.einsum("bij,bi->bj", turn, angle))
    np.testing.assert_allclose(work + np.concatenate(elastic, axis=-1) - weight_moment(bend, one), 0, atol=1e-12)


@STARTS
@COUNTS
def test_closed_form_tensions_hold_the_simulated_arm_at_the_chains_pose(start, count):
    """At rest without gravity: at the chain's closed form, and at the arc's as far as links go."""
    one = arm(count, start=start)
    for bend in bends(count, 5, largest=2.0):
        found = equilibrium(one, Load(muscles=Muscles(kind="tensions", values=tuple(holding_tensions(bend, one)))))
        assert np.linalg.norm(found.tip - shape.chain_tip(bend, one)) < 1e-4 * one.length
        assert np.linalg.norm(found.tip - shape.position(bend, one)) < 1.5e-2 * one.length
        assert found.muscle_tensions.min() > 0.99 * one.muscle.min_tension


@COUNTS
def test_pressures_hold_a_bend_within_their_limits(count):
    one, bend = arm(count), bends(count, 5, largest=1.0)
    pressures = holding_pressures(bend, one, 0.3)
    assert (pressures >= one.muscle.min_pressure * (1 - 1e-9)).all()
    assert (pressures <= one.muscle.max_pressure * (1 + 1e-9)).all()
    found = equilibrium(one, Load(muscles=Muscles(kind="pressures", values=tuple(pressures[0]))))
    assert np.linalg.norm(found.tip - shape.chain_tip(bend[0], one)) < 1e-4 * one.length
    low, high = level_range(balance(bend, one), one)
    assert low.shape == high.shape == (5, count)
    inflated, vented = pressure_needed(bend, one)
    assert (vented <= inflated).all()


@STARTS
def test_the_tips_compliance_is_the_simulated_arms(start):
    one = arm(2, start=start)
    one = replace(one, sections=tuple(replace(s, links=48, torsional_stiffness=0.07) for s in one.sections))
    bend = bends(2, 1)[0]
    held = equilibrium(one, Load(muscles=Muscles(kind="pressures", values=tuple(holding_pressures(bend, one)))))
    slopes = driven_slopes(one, held)
    closed = compliance.tip_compliance(bend, held.muscle_tensions, slopes, one)
    scale = np.abs(closed).max()
    np.testing.assert_allclose(held.tip_compliance[:3, :3], closed, atol=0.01 * scale)


def driven_slopes(one, held):
    from contarm_sim.mechanics.pneumatics import force, force_slope

    per_pascal = force(1.0, held.muscle_lengths, one)
    return force_slope(held.muscle_tensions / per_pascal, held.muscle_lengths, one)


@COUNTS
@pytest.mark.parametrize("name", ["paper", "chain", "feedforward", "servo", "pressure", "tip"])
def test_every_controller_rests_where_it_should(name, count):
    one = arm(count, gravity=(0.0, 0.0, 9.81))
    reference = Reference.from_bends(bends(count, 3, largest=0.9), one)
    found = compare(poses_at_rest(one, reference, name))
    limit = {"paper": 0.15, "chain": 0.15, "tip": 1e-4}.get(name, 0.05) * one.length
    assert found.target_error.max() < limit
    if name == "servo":
        assert found.servo.max() < 1e-9
    if name == "tip":
        assert found.target_error.max() < 1e-6
    assert found.section_shape.shape == (3, count)


@pytest.mark.parametrize("name", ["paper", "servo", "pressure", "tip"])
def test_a_motion_of_two_sections_follows_its_bends(name):
    one = arm(2)
    share = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 101))
    reference = Reference.from_bends(share[:, None] * bends(2, 1, largest=1.2), one, time=np.linspace(0, 1, 101))
    found = compare(simulate(one, reference, name))
    assert found.tip_error.max() < 0.02 * one.length
    assert simulate(one, reference, name) == simulate(one, reference, name)


def test_the_parts_of_the_error_add_up_section_by_section():
    """Small parts: their sum over sections is the part of the whole, to second order."""
    one = arm(3)
    found = compare(poses_at_rest(one, Reference.from_bends(0.2 * bends(3, 4), one), "paper"))
    for part, parts in (("servo", found.section_servo), ("discretisation", found.section_discretisation)):
        whole = getattr(found, part)
        assert (parts.sum(axis=1) >= 0.99 * whole).all()
        assert (parts.max(axis=1) <= 3 * whole.max() + 1e-9).all()


def test_arms_that_cannot_be_held_say_which_section():
    missing = replace(arm(2), routings=(Routing(), Routing(count=2)))
    with pytest.raises(InputError, match=r"muscle\.count is 2 in section 2"):
        cocontraction(np.zeros(4), missing)
    with pytest.raises(InputError, match="three or more that end with each section"):
        routing.bend_from_lengths(np.zeros(5), missing)
    with pytest.raises(InputError, match="for the muscles of section 2"):
        holding_pressures(np.array([0.1, 0.0, 3.0, 0.0]), arm(2))


@pytest.mark.parametrize("actuation", ["lengths", "pressures", "tensions"])
def test_the_straight_keyframe_holds_muscles_at_given_angles(actuation):
    lines = (Routing(at=(0, 1.6, 3.6)), Routing(at=(0.4, 2.0, 4.4), start="base", radius=0.015))
    model = arm_spec(replace(arm(2), routings=lines), actuation).compile()
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("straight").id)
    mujoco.mj_step(model, data, 200)
    assert np.abs(data.qpos).max() < 1e-12


def test_muscles_are_checked_against_every_section_that_they_pass():
    short = (Section(length=0.05), Section(length=0.2))
    with pytest.raises(InputError, match="for muscles that pass through section 1"):
        Arm(sections=short, routings=(Routing(radius=0.01), Routing(radius=0.05, start="base")))
    Arm(sections=short, routings=(Routing(count=0), Routing(radius=0.02)))
