"""Tendons and ideal muscles: the engine against balances of forces written down by hand, and Coulomb's friction."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from contarm_sim.engine.plant import Plant
from contarm_sim.envs.variations import check, varied_arm
from contarm_sim.errors import InputError
from contarm_sim.kinematics.muscles import directions
from contarm_sim.mechanics.pneumatics import force, pressure_for
from contarm_sim.mjcf import arm_spec, scene_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.ideal import Ideal
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.statics.solver import Solver

CABLE = Tendon(stiffness=3000.0, pretension=4.0)
TWO = Arm(
    sections=(
        Section(length=0.2, links=6, bending_stiffness=0.1),
        Section(length=0.15, links=5, bending_stiffness=0.04),
    ),
    routings=(Routing(count=0), Routing(start="base", radius=0.015)),
    laws=(CABLE, CABLE),
)


def angles(plant, axis="y"):
    """Return the sum of the joint angles of each section [rad]."""
    own = plant.index.bending[axis]
    return [
        plant.data.qpos[own][plant.index.section_of_joint[own] == number].sum()
        for number in range(len(plant.arm.sections))
    ]


def stepped(plant, controls, seconds):
    plant.restart(np.zeros(plant.model.nq), controls)
    mujoco.mj_step(plant.model, plant.data, round(seconds / plant.model.opt.timestep))
    mujoco.mj_forward(plant.model, plant.data)
    plant.check({})
    return plant


@pytest.mark.parametrize("wound", [0.004, 0.012])
def test_a_wound_up_cable_is_in_balance_with_the_sections_that_it_crosses(wound):
    """T = p + k (l - L + wound), l - L = -r (a1 + a2), EI_j/L_j a_j = r T in both sections; the other cables slack."""
    k, r = 3000.0 / 0.35, 0.015
    compliance = 0.2 / 0.1 + 0.15 / 0.04
    tension = (4.0 + k * wound) / (1 + k * r**2 * compliance)
    plant = Plant(TWO)
    plant.reset()
    assert Solver(plant)(np.array([-wound, 0.05, 0.05])) < 1e-9
    np.testing.assert_allclose(angles(plant), [r * tension * 0.2 / 0.1, r * tension * 0.15 / 0.04], rtol=1e-9)
    np.testing.assert_allclose(plant.actuator_tensions, [tension, 0, 0], atol=1e-8)
    moving = stepped(Plant(TWO), np.array([-wound, 0.05, 0.05]), 6.0)
    np.testing.assert_allclose(moving.stations, plant.stations, atol=1e-5)


def test_a_longer_cable_is_softer():
    groups = Arm(
        sections=(Section(length=0.2), Section(length=0.3)),
        routings=(Routing(start="base"), Routing(start="base", offset=1.0)),
        laws=(CABLE, CABLE),
    ).groups
    assert [group.law.servo_gain(0.1) for group in groups] == pytest.approx([30000, 30000])
    assert [group.servo_stiffness for group in groups] == pytest.approx([15000, 6000])
    assert groups[1].servo_tension(-0.001, 0.5) == pytest.approx(4.0 + 6.0)


def test_cables_and_ideal_muscles_driven_by_tension_are_the_same_without_friction():
    """Bit for bit, bends, speeds and tensions."""
    arms = [
        replace(TWO, sections=tuple(replace(s, section_radius=0.02) for s in TWO.sections), laws=(law, law))
        for law in (Tendon(diameter=0.004), Ideal())
    ]
    runs = [stepped(Plant(arm, actuation="tensions"), np.array([9.0, 2.0, 5.0]), 1.0) for arm in arms]
    np.testing.assert_array_equal(runs[0].data.qpos, runs[1].data.qpos)
    np.testing.assert_array_equal(runs[0].data.qvel, runs[1].data.qvel)
    np.testing.assert_allclose(runs[1].actuator_tensions, [9.0, 2.0, 5.0], rtol=1e-12)


@pytest.mark.parametrize("law", [Tendon(max_tension=30.0), Ideal(max_tension=30.0)])
def test_tensions_end_at_the_highest(law):
    plant = Plant(Arm(muscle=law, links=6), actuation="tensions")
    plant.control[:] = [50.0, 29.0, -3.0]
    mujoco.mj_forward(plant.model, plant.data)
    np.testing.assert_allclose(plant.actuator_tensions, [30.0, 29.0, 0.0], atol=1e-12)


def ramped(arm, goals, least):
    """Return bends towards the first muscle, in r f L/EI, where slow ramps of its tension end: least + f goal [N]."""
    plant = Plant(arm, actuation="tensions")
    plant.restart(np.zeros(plant.model.nq), np.full(len(plant.index.tendons), least))
    friction, bends, last = arm.muscle.dry_friction, [], 0.0
    for goal in goals:
        steps = round(abs(goal - last) / plant.model.opt.timestep)  # the friction in a second
        for tension in least + friction * np.linspace(last, goal, steps + 1)[1:]:
            plant.control[0, 0] = tension
            mujoco.mj_step(plant.model, plant.data)
        last = goal
        unit = arm.muscle_radius * friction * arm.length / arm.bending_stiffness
        bends.append(angles(plant)[0] / unit)
    return bends


def test_a_cable_slips_when_its_tension_has_changed_by_its_friction():
    """Coulomb: it holds up to f, follows f behind, stays on the way back until 2 f less, and then is f ahead."""
    arm = Arm(links=4, routings=(Routing(count=1),), laws=(Tendon(friction=1.2),))
    assert ramped(arm, (0.9, 1.5, 3.0, 1.5, 0.5), 0.0) == pytest.approx([0.0, 0.5, 2.0, 2.0, 1.5], abs=0.05)


def test_friction_acts_in_every_cable_that_slips():
    """Towards the first of three, cables slip by r, r/2 and r/2: it takes twice the friction to bend the arm."""
    arm = Arm(links=4, muscle=Tendon(friction=1.0))
    assert ramped(arm, (1.8, 3.0, 4.0), 5.0) == pytest.approx([0.0, 1.0, 2.0], abs=0.08)


def test_what_a_cable_pulls_with_turns_every_section_that_it_crosses():
    """By r T L/EI in each, towards the cable; a muscle of the first section's own turns the first alone."""
    arm = replace(TWO, routings=(Routing(radius=0.01, count=2), Routing(start="base", count=2, at=(0.7, 2.0))))
    pulls = np.array([3.0, 0.0, 6.0, 1.0])
    plant = Plant(arm, actuation="tensions")
    plant.reset()
    assert Solver(plant)(pulls) < 1e-9
    through = 0.018 * pulls[2:] @ directions((0.7, 2.0))
    own = 0.01 * pulls[:2] @ directions(arm.routings[0].angles)
    ends = equilibrium(arm, Load(muscles=Muscles(kind="tensions", values=tuple(pulls)))).frames[[6, 11]]
    np.testing.assert_allclose(plant.stations[[6, 11]], ends[:, :3, 3], atol=1e-7)
    # hinges in the order xy, yx turn by more than their sum bends; compare the moments, which are exact
    moments = [section.bending_stiffness / section.length for section in arm.sections]
    turned = np.array([angles(plant, "y"), -np.array(angles(plant, "x"))]).T * np.array(moments)[:, None]
    np.testing.assert_allclose(turned, [own + through, through], atol=1e-7)


@pytest.mark.parametrize("law", [Tendon(), Ideal()])
def test_pressures_of_muscles_without_are_refused_in_one_line(law):
    arm = Arm(links=6, muscle=law)
    one, others = (
        Load(muscles=Muscles(kind="pressures", values=(1e5, 0.0, 0.0))),
        Reference.from_bends([[0.2, 0.0]], arm),
    )
    for call in (
        lambda: scene_spec(arm, "pressures"),
        lambda: arm_spec(arm, "pressures"),
        lambda: Plant(arm, actuation="pressures"),
        lambda: equilibrium(arm, one),
        lambda: poses_at_rest(arm, others, "pressure"),
        lambda: force(1e5, 0.3, arm),
        lambda: arm.pneumatics,
    ):
        with pytest.raises(InputError, match=f"'pressures' with the law {type(law).__name__}, which has none"):
            call()
    with pytest.raises(InputError, match="pressures"):
        scene_spec(Arm(sections=(Section(), Section()), laws=(McKibben(), law)), "pressures")
    assert np.isinf(pressure_for(np.full((2, 3), 5.0), 0.3, arm)).all()


@pytest.mark.parametrize("law", [Tendon(), Ideal()])
@pytest.mark.parametrize("controller", ["servo", "paper", "chain", "feedforward"])
def test_controllers_of_lengths_drive_them(law, controller):
    arm = Arm(links=8, muscle=law)
    found = poses_at_rest(arm, Reference.from_bends([[0.4, 0.2], [1.0, 0.0]], arm), controller)
    assert np.linalg.norm(found.tip - found.target, axis=1).max() < 0.03 * arm.length
    assert found.muscle_tensions.min() > -1e-6 or controller in ("paper", "chain")


def test_what_varies_must_be_a_parameter_of_the_law():
    varied = {"muscle.valve_time": 0.1}
    with pytest.raises(InputError, match=r"muscle.valve_time' is unknown"):
        check(varied, (), Arm(muscle=Tendon()))
    assert varied_arm(varied, Arm(), Arm(), np.random.RandomState(0)).pneumatics.valve_time == 0.1


@pytest.mark.parametrize(
    ("kind", "given"),
    [(Tendon, {name: value}) for name in ("stiffness", "pretension", "max_tension", "friction", "diameter")
     for value in (0.0, -1.0, np.nan, "1", True)]
    + [(Tendon, {"pretension": 300.0}), (Tendon, {"servo_time": -1.0}), (Ideal, {"min_tension": 300.0}),
       (Ideal, {"max_tension": 0.0}), (Ideal, {"servo_stiffness": 0.0})],
)  # fmt: skip
def test_unusable_laws_are_refused_by_name(kind, given):
    with pytest.raises(InputError, match=rf"muscle\.{next(iter(given))}"):
        kind(**given)


def test_another_least_tension():
    assert Tendon().with_min_tension(7.0) == Tendon(pretension=7.0)
    assert Ideal().with_min_tension(7.0) == Ideal(min_tension=7.0)
    assert McKibben().with_min_tension(7.0) == McKibben(min_tension=7.0)
