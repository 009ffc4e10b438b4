"""Arms of two sections and of four muscles, against one section, closed forms, and the engine's own forces."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from contarm_sim.engine.index import ArmIndex
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.kinematics import hinges
from contarm_sim.kinematics.muscles import directions
from contarm_sim.mechanics import routing
from contarm_sim.mechanics.statics import balance, cocontraction
from contarm_sim.mjcf import exact_xml, names, scene_spec
from contarm_sim.mjcf.stability import tendon_jacobian
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.statics.equilibrium import driven_plant, equilibrium
from contarm_sim.statics.holding import Holder
from contarm_sim.statics.loads import AppliedLoad
from contarm_sim.statics.solver import Solver
from contarm_sim.statics.stiffness import TangentStiffness
from contarm_sim.studies.load_cases import LoadCase, cases_at_rest

HALF = Section(length=0.185, links=12, mass=0.15)
WRENCH = Wrench(xi=0.3, force=(0.4, -0.2, 0.1), moment=(0.02, 0.01, 0.0))
HANGING = {"gravity": (1.0, -2.0, 9.0), "payload": 0.05}


def halves(path="parallel", first=0, torsion=None, start="base", **world):
    """Return the paper's arm as two equal sections, the second one's muscles from the base or from their section."""
    section = replace(HALF, torsional_stiffness=torsion)
    own = Routing(path=path, count=first, offset=0.4)
    return Arm(sections=(section, section), routings=(own, Routing(path=path, start=start)), **world)


def mixed(path, torsion):
    """Return an arm of two unlike sections with three and four muscles."""
    return Arm(
        sections=(
            Section(length=0.15, links=5, mass=0.2, bending_stiffness=0.2, torsional_stiffness=torsion),
            Section(length=0.25, links=6, mass=0.1, bending_stiffness=0.07, torsional_stiffness=torsion),
        ),
        routings=(Routing(path=path, radius=0.02), Routing(path="spans", start="base", count=4, offset=0.5)),
        **HANGING,
    )


@pytest.mark.parametrize("path", ["parallel", "spans"])
@pytest.mark.parametrize("torsion", [None, 0.05])
@pytest.mark.parametrize(
    "muscles",
    [Muscles(), Muscles(kind="tensions", values=(6.0, 1.0, 2.0)), Muscles(kind="pressures", values=(2e5, 0.0, 1e5))],
    ids=lambda muscles: muscles.kind,
)
def test_two_equal_sections_with_muscles_from_the_base_are_one(path, torsion, muscles):
    load = Load(muscles=muscles, wrenches=(WRENCH,))
    one = equilibrium(Arm(path=path, torsional_stiffness=torsion, **HANGING), load)
    two = equilibrium(halves(path, torsion=torsion, **HANGING), load)
    np.testing.assert_allclose(two.frames, one.frames, atol=1e-9)
    np.testing.assert_allclose(two.muscle_lengths, one.muscle_lengths, atol=1e-10)
    np.testing.assert_allclose(two.muscle_tensions, one.muscle_tensions, atol=1e-6)
    np.testing.assert_allclose(two.tip_compliance, one.tip_compliance, atol=1e-7)


@pytest.mark.parametrize("path", ["parallel", "spans"])
def test_slack_muscles_of_the_first_section_change_nothing(path):
    three = Load(muscles=Muscles(kind="tensions", values=(6.0, 1.0, 2.0)))
    six = Load(muscles=Muscles(kind="tensions", values=(0.0, 0.0, 0.0, 6.0, 1.0, 2.0)))
    one, two = equilibrium(Arm(path=path, **HANGING), three), equilibrium(halves(path, first=3, **HANGING), six)
    np.testing.assert_allclose(two.frames, one.frames, atol=1e-9)
    assert two.muscle_lengths.shape == (6,)


@pytest.mark.parametrize("start", ["section", "base"])
def test_each_section_bends_by_the_tensions_that_run_through_it(start):
    """Parallel muscles turn every joint of a section alike, by r/EI sum T u: the pose is a product of closed forms."""
    sections = (Section(length=0.15, links=8, bending_stiffness=0.2), Section(length=0.25, links=12))
    radii, offsets, pulls = (0.02, 0.015), (0.3, -0.7), (np.array([9.0, 2.0, 4.0]), np.array([1.0, 5.0, 3.0, 2.0]))
    arm = Arm(
        sections=sections,
        routings=(
            Routing(radius=radii[0], offset=offsets[0]),
            Routing(radius=radii[1], offset=offsets[1], count=4, start=start),
        ),
    )
    moments = [
        radius * pull @ directions(line.angles) for radius, pull, line in zip(radii, pulls, arm.routings, strict=True)
    ]
    moments[0] = moments[0] + (moments[1] if start == "base" else 0.0)
    frame, places = np.eye(4), [np.eye(4)]
    for section, moment in zip(sections, moments, strict=True):
        bend = hinges.bend_from_angles(moment * section.length / section.bending_stiffness, section.links)
        own = frame @ hinges.frames(bend, section.length, section.links)
        places, frame = [*places, *own[1:]], own[-1]
    found = equilibrium(arm, Load(muscles=Muscles(kind="tensions", values=(*pulls[0], *pulls[1]))))
    np.testing.assert_allclose(found.frames, np.array(places), atol=1e-8)


@pytest.mark.parametrize("path", ["parallel", "spans"])
@pytest.mark.parametrize("actuation", ["lengths", "pressures", "tensions"])
@pytest.mark.parametrize("torsion", [None, 0.05])
def test_forces_and_stiffness_of_two_unlike_sections_are_the_engines(path, actuation, torsion):
    plant = Plant(mixed(path, torsion), actuation=actuation)
    data, rng = plant.data, np.random.default_rng(1)
    plant.reset(np.array([0.8, 0.4]))
    data.qpos += 0.02 * rng.normal(size=plant.model.nq)
    plant.control[:] = {"lengths": -0.005, "pressures": 2e5, "tensions": 7.0}[actuation] * rng.uniform(0.5, 1, 7)
    plant.pressure[:] = plant.control[0]
    mujoco.mj_forward(plant.model, data)
    stiffness = TangentStiffness(plant, AppliedLoad(plant, Load()))
    if plant.twisted is None:  # the engine's fixed tendons do not feel twist
        plant.stiffen_twist()
        mujoco.mj_forward(plant.model, data)
    plant.tighten(plant.muscle_tensions)
    Q = stiffness.forces(plant.muscle_tensions)
    if plant.twisted is None:
        np.testing.assert_allclose(Q, data.qfrc_smooth, atol=1e-9 * np.abs(Q).max() + 1e-12)
    K = stiffness.matrix(plant.muscle_tensions, plant.muscle_slopes)
    np.testing.assert_allclose(K, _differenced(plant, stiffness), atol=2e-6 * np.abs(K).max())


def _differenced(plant, stiffness):
    def forces():
        plant.pose()
        if plant.twisted is not None:
            plant.tighten(plant.muscle_tensions)
        return stiffness.forces(plant.muscle_tensions)

    start, columns, step = plant.data.qpos.copy(), [], 1e-6
    for dof in range(len(start)):
        ends = []
        for sign in (1, -1):
            plant.data.qpos[:] = start
            plant.data.qpos[dof] += sign * step
            ends.append(forces())
        columns.append((ends[1] - ends[0]) / (2 * step))
    plant.data.qpos[:] = start
    return np.array(columns).T


def test_an_arm_of_two_sections_swings_out_to_its_static_pose():
    arm = replace(mixed("parallel", None), gravity=(2.0, 0.0, 3.0))
    controls = np.array([-0.004, 0.001, 0.003, 0.006, -0.004, -0.005, 0.003])
    solved, stepped = Plant(arm), Plant(arm)
    solved.reset()
    assert Solver(solved)(controls) < 1e-9
    stepped.restart(np.zeros(stepped.model.nq), controls)
    mujoco.mj_step(stepped.model, stepped.data, 1600)
    mujoco.mj_forward(stepped.model, stepped.data)
    stepped.check({})
    np.testing.assert_allclose(stepped.stations, solved.stations, atol=1e-6)
    assert np.linalg.norm(solved.tip - [0, 0, arm.length]) > 0.01


def test_mass_is_where_the_sections_have_it():
    arm = mixed("parallel", None)
    plant = Plant(arm)
    mujoco.mj_forward(plant.model, plant.data)
    base = plant.index.base
    assert plant.model.body_subtreemass[base] == pytest.approx(0.3 + arm.payload)
    middle = (0.2 * 0.075 + 0.1 * 0.275 + arm.payload * 0.4) / (0.3 + arm.payload)
    np.testing.assert_allclose(plant.data.subtree_com[base], [0, 0, middle], atol=1e-12)
    whole, parts = Plant(Arm()), Plant(halves())
    np.testing.assert_allclose(parts.model.body_inertia, whole.model.body_inertia, rtol=1e-12, atol=1e-18)


@pytest.mark.parametrize("path", ["parallel", "spans"])
def test_four_muscles_hold_the_bend_that_three_hold(path):
    bend = Load(muscles=Muscles(kind="bend", values=(1.1, 0.4)))
    three, four = Arm(path=path), Arm(routings=(Routing(path=path, count=4, offset=0.2),))
    tips = [equilibrium(arm, bend) for arm in (three, four)]
    np.testing.assert_allclose(tips[1].tip, tips[0].tip, atol=1e-8 if path == "parallel" else 1e-4)
    assert tips[1].muscle_lengths.shape == (4,)
    one = Load(muscles=Muscles(kind="tensions", values=(5.0, 0.0, 0.0)))
    same = Load(muscles=Muscles(kind="tensions", values=(5.0, 0.0, 0.0, 0.0)))
    alike = [equilibrium(three, one), equilibrium(replace(four, routings=(Routing(path=path, count=4),)), same)]
    np.testing.assert_allclose(alike[1].frames, alike[0].frames, atol=1e-9)


@pytest.mark.parametrize("count", [4, 5])
def test_lengths_of_many_muscles_are_held_by_the_least_tensions(count):
    arm = Arm(routings=(Routing(count=count, offset=0.2),), gravity=(3.0, 0.0, 5.0))
    bend, plant = np.array([1.0, -0.5]), Plant(arm)
    plant.reset(bend)
    holder, lengths = Holder(Solver(plant)), routing.lengths_from_bend(bend, arm)
    holder(lengths)
    np.testing.assert_allclose(plant.muscle_lengths, lengths, atol=1e-9)
    assert holder.tensions.min() == pytest.approx(arm.muscle.min_tension, abs=1e-9)
    plant.control[:] = holder.setpoints()
    holder.check()
    gained = directions(arm.routing.angles).T @ holder.tensions  # two of the tensions' n dimensions bend the arm
    alike = directions(arm.routing.angles) @ gained * 2 / count
    np.testing.assert_allclose(holder.tensions, alike + holder.tensions.mean(), atol=1e-9)


@pytest.mark.parametrize("count", [3, 4, 6])
@pytest.mark.parametrize("path", ["parallel", "spans"])
def test_closed_forms_of_many_muscles(count, path):
    arm = Arm(routings=(Routing(path=path, count=count, offset=0.3),))
    bend = np.array([[0.0, 0.0], [0.7, -0.4], [-1.5, 1.2]])
    lengths, J = routing.lengths_from_bend(bend, arm), routing.length_jacobian(bend, arm)
    np.testing.assert_allclose(routing.bend_from_lengths(lengths, arm)[0], bend, atol=1e-12)
    held = balance(bend, arm)
    np.testing.assert_allclose(np.einsum("bij,bi->bj", J, held.cocontraction[:, 0]), 0, atol=1e-15)
    free = np.linalg.svd(J)[0][
        ..., 2:
    ]  # J^T's null space: of all in it, what co-contracts is the nearest to (1, ..., 1)
    nearest = (free @ free.swapaxes(-1, -2)).sum(axis=-1)
    np.testing.assert_allclose(held.cocontraction[:, 0], nearest / nearest.mean(axis=-1, keepdims=True), rtol=1e-12)
    elastic, turn = routing.section_angles(bend, arm.section, arm.routing)
    moment = (arm.bending_stiffness / arm.length) * np.einsum("bij,bi->bj", turn, elastic)
    np.testing.assert_allclose(-np.einsum("bij,bi->bj", J, held.at(np.full((3, 1), 7.0))), moment, atol=1e-12)
    assert (held.cocontraction > 0).all()


def test_three_muscles_co_contract_along_the_cross_product(arm):
    bend = np.random.default_rng(0).normal(size=(50, 2))
    J = routing.length_jacobian(bend, replace(arm, path="spans"))
    cross = np.cross(J[..., 0], J[..., 1])
    wanted = cross / cross.mean(axis=-1, keepdims=True)
    np.testing.assert_allclose(cocontraction(bend, replace(arm, path="spans"))[:, 0], wanted, rtol=1e-12)


def test_the_index_finds_what_the_names_mean():
    arm = mixed("spans", 0.1)
    plant = Plant(replace(arm, routings=(Routing(), Routing(start="base", count=4, offset=0.5))), actuation="pressures")
    model, index = plant.model, plant.index
    mujoco.mj_forward(model, plant.data)
    np.testing.assert_allclose(tendon_jacobian(model, plant.data), index.by_angle, atol=1e-16)
    assert model.body(index.tip).name == "tip"
    assert model.sensor_adr[model.sensor("section_2_muscle_4_velocity").id] == index.velocities[-1]
    assert [model.actuator(i).name for i in index.actuators[:, 3]] == [
        "section_2_muscle_1_linear", "section_2_muscle_1_quadratic",
    ]  # fmt: skip
    assert [model.body(b).name for b in range(model.nbody)][index.stations][5] == "section_1_tip"
    assert index.twisted.shape == (11, 3)
    scene = scene_spec(arm).compile()
    assert scene.body(ArmIndex.of(scene, arm).tip).name == "tip"
    reloaded = mujoco.MjModel.from_xml_string(exact_xml(scene_spec(arm)))
    np.testing.assert_array_equal(reloaded.body_mass, scene.body_mass)


def test_arms_of_one_section_keep_their_plain_names():
    assert names.stations(Arm(links=3)) == ["base", "link_01", "link_02", "tip"]
    assert names.muscles(Arm()) == ["muscle_1", "muscle_2", "muscle_3"]


def test_closed_forms_refuse_what_does_not_fit_the_sections():
    arm = halves(first=3)
    for call in (
        lambda: routing.lengths_from_bend(np.zeros(2), arm),
        lambda: balance(np.zeros(2), arm),
        lambda: driven_plant(arm, Load(muscles=Muscles(kind="bend", values=(1.0, 0.0)))),
    ):
        with pytest.raises(InputError, match=r"shape \(\.\.\., 4\)|4 finite numbers"):
            call()
    with pytest.raises(InputError, match="6 finite numbers"):
        equilibrium(arm, Load(muscles=Muscles(kind="tensions", values=(1.0, 2.0, 3.0))))
    with pytest.raises(InputError, match="three muscles"):
        balance(np.zeros(2), Arm(routings=(Routing(count=2),)))


def test_properties_of_several_sections_add_up_agree_or_are_refused():
    arm = Arm(sections=(Section(length=0.2, mass=0.1), Section(length=0.1, links=6)), payload=0.2)
    assert (arm.length, arm.links, arm.mass, arm.payload) == (pytest.approx(0.3), 30, pytest.approx(0.4), 0.2)
    assert arm.bending_stiffness == 0.1
    assert arm == Arm(sections=(Section(length=0.2, mass=0.1), Section(length=0.1, links=6)), payload=0.2)
    assert len({arm, replace(arm, payload=0.2), replace(arm, payload=0.3), arm.unloaded}) == 3
    with pytest.raises(InputError, match="agree"):
        replace(arm, sections=(Section(), Section(bending_stiffness=0.2))).bending_stiffness  # noqa: B018
    with pytest.raises(InputError, match="change its sections"):
        replace(arm, links=12)
    for given in ({"sections": ()}, {"laws": (1,)}, {"routings": (Routing(),) * 3}, {"world": 3}):
        with pytest.raises(InputError) as caught:
            replace(arm, **given)
        assert caught.value.name == next(iter(given))
    assert replace(Arm(links=7), gravity=(0, 0, 1)) == Arm(links=7, gravity=(0, 0, 1))


UNEVEN = Arm(sections=(Section(length=0.1, links=8), Section(length=0.3, links=4)))
PASSIVE = Arm(sections=(HALF, HALF), routings=(Routing(), Routing(count=0)), laws=(McKibben(), McKibben(wall=0.002)))
TWO_LAWS = Arm(sections=(HALF, HALF), laws=(McKibben(), McKibben(wall=0.002, max_pressure=4e5)))
BARE = Arm(links=8, routings=(Routing(count=0),))


def pressurised(*pressures):
    return Load(muscles=Muscles(kind="pressures", values=pressures))


def test_places_of_sections_of_unequal_pitch_are_at_their_arc_lengths():
    (found,) = cases_at_rest([LoadCase(UNEVEN, Load())], xi=[0.25, 0.5, 0.75])
    np.testing.assert_allclose(found.places.poses[:, :3, 3], [[0, 0, 0.1], [0, 0, 0.2], [0, 0, 0.3]], atol=1e-12)


def test_each_law_has_its_own_pressures():
    for arm, load in ((PASSIVE, pressurised(6e5, 0, 0)), (TWO_LAWS, pressurised(6e5, 0, 0, 3e5, 0, 0))):
        (found,) = cases_at_rest([LoadCase(arm, load)])
        assert found.beyond == ""
        assert found.muscle_pressures == pytest.approx(load.muscles.values, abs=1.0)
    with pytest.raises(InputError, match=r"muscles pressures .* 400000 Pa for muscles of section 2"):
        equilibrium(TWO_LAWS, pressurised(6e5, 0, 0, 6e5, 0, 0))
    (found,) = cases_at_rest(
        [LoadCase(TWO_LAWS, Load(muscles=Muscles(kind="tensions", values=(0, 0, 0, 9e3, 9e3, 9e3))))]
    )
    assert f"{TWO_LAWS.laws[1].blocked_force:.0f} N" in found.beyond
    assert PASSIVE.muscle == PASSIVE.laws[0]


def test_an_arm_without_muscles_rests_and_is_not_driven():
    found = equilibrium(BARE, Load(wrenches=(WRENCH,)))
    assert found.pressures_needed(BARE).shape == found.muscle_tensions.shape == (0,)
    same = equilibrium(Arm(links=8), Load(wrenches=(WRENCH,)))
    np.testing.assert_allclose(found.tip, same.tip, atol=1e-9)
    (listed,) = cases_at_rest([LoadCase(BARE, Load())])
    assert listed.beyond == ""
    for name in ("paper", "chain", "feedforward", "servo", "pressure", "tip"):
        with pytest.raises(InputError, match=r"with(out)? muscles|muscle.count is 0"):
            poses_at_rest(BARE, Reference.from_bends([[0.2, 0.0]], BARE), name)
    with pytest.raises(InputError, match="0 finite numbers"):
        equilibrium(BARE, pressurised(1e5))


@pytest.mark.parametrize("count", [3, 4, 5])
def test_the_paper_controller_drives_any_number_of_muscles(count):
    arm = Arm(links=8, routings=(Routing(count=count, offset=0.2),))
    bend = np.array([[0.5, 0.3]])
    reached = poses_at_rest(arm, Reference.from_bends(bend, arm), "paper")
    np.testing.assert_allclose(
        reached.muscle_lengths - arm.length, -0.018 * bend @ directions(arm.routing.angles).T, atol=1e-4
    )


def test_extrapolation_names_the_section_with_an_odd_number_of_links():
    odd = replace(UNEVEN, sections=(UNEVEN.sections[0], replace(UNEVEN.sections[1], links=7)))
    with pytest.raises(InputError, match="links is 7 of section 2; allowed: a multiple of 2"):
        cases_at_rest([LoadCase(odd, Load())], extrapolate=True)
