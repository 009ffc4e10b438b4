"""Studies of arms of two and three sections: against closed forms, a minimised energy, brute force and known beams."""

from dataclasses import replace

import numpy as np
import pytest
from rod_sections import rod
from scipy.optimize import brentq, minimize
from scipy.stats import qmc

from contarm_sim import studies
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import shape
from contarm_sim.mechanics.pressures import holding_pressures, pressure_needed
from contarm_sim.mechanics.rod import SEGMENTS, rod_tips
from contarm_sim.mechanics.routing import bend_from_arc_deltas
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Wrench
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.presets import preset
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.motion import stepped_beam
from contarm_sim.motion.modes import bare, beam_frequencies, natural_frequencies, small_swing, swing_modes
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.paths.waypoints import Waypoints, from_waypoints
from contarm_sim.results.compare import compare
from contarm_sim.results.document import document
from contarm_sim.results.summary import muscle_use, summarise
from contarm_sim.studies import pressure_map
from contarm_sim.studies.at_rest import examine
from contarm_sim.studies.controllers import Followed, _reachable, _row, _spiral
from contarm_sim.studies.largest_bends import every_bend, largest_bends, largest_bends_at_rest, posed
from contarm_sim.studies.muscle_curves import group_of
from contarm_sim.studies.scenarios import EXTREMES, scenarios, spread_bends
from contarm_sim.studies.tip_stiffness import directions_of

SECTIONS = (
    Section(length=0.20, links=8, mass=0.10, bending_stiffness=0.04),
    Section(length=0.17, links=8, mass=0.06, bending_stiffness=0.02),
    Section(length=0.15, links=8, mass=0.04, bending_stiffness=0.01),
)


def arm(count=2, start="section", **world):
    lines = tuple(Routing(radius=0.014 - 0.001 * k, offset=0.3 * k, start=start) for k in range(count))
    return Arm(sections=SECTIONS[:count], routings=lines, **world)


def linked(one, links):
    return replace(one, sections=tuple(replace(section, links=links) for section in one.sections))


def bends(count, poses=4, largest=1.2):
    rng = np.random.default_rng(5)
    return arc.from_polar(rng.uniform(0, largest, (poses, count)), rng.uniform(-np.pi, np.pi, (poses, count)))


def minimised(one, bend, pieces=30):
    """Return the tip [m] of planar rods of least energy whose sections turn by given angles [rad]: x towards z."""
    h = np.repeat([s.length / pieces for s in one.sections], pieces)
    EI = np.repeat([s.bending_stiffness for s in one.sections], pieces)
    weights = np.repeat([s.mass / pieces for s in one.sections], pieces)
    gravity = np.array(one.gravity)[[0, 2]]

    def shaped(turn):
        heading = np.cumsum(turn) - 0.5 * turn
        step = (h * np.sinc(0.5 * turn / np.pi))[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=-1)
        ends = np.cumsum(step, axis=0)
        return ends - 0.5 * step, ends[-1]

    def energy(turn):
        middles, tip = shaped(turn)
        return np.sum(EI * turn**2 / h) / 2 - weights @ (middles @ gravity) - one.payload * tip @ gravity

    alike = np.repeat(bend / pieces, pieces)
    sums = {"type": "eq", "fun": lambda turn: turn.reshape(-1, pieces).sum(axis=1) - bend}
    found = minimize(energy, alike, constraints=[sums], method="SLSQP", options={"maxiter": 500, "ftol": 1e-14})
    return shaped(found.x)[1]


@pytest.mark.parametrize("gravity", [(0, 0, 9.81), (9.81, 0, 0)])
def test_the_rod_of_two_sections_has_the_least_energy(gravity):
    one = arm(gravity=gravity, payload=0.02)
    angles = np.array([[0.9, -0.6], [1.4, 0.8], [0.0, 0.0]])
    bend = np.stack([angles[:, 0], 0 * angles[:, 0], angles[:, 1], 0 * angles[:, 0]], axis=-1)
    weight = np.tile(gravity, (len(bend), 1)).astype(float)
    density = [np.repeat(s.mass / s.length * weight[:, None], SEGMENTS, axis=1) for s in one.sections]
    tips = rod_tips(one, bend, np.concatenate(density, axis=1), one.payload * weight)
    assert np.abs(tips[:, 1]).max() < 1e-9
    for angle, tip in zip(angles, tips, strict=True):
        np.testing.assert_allclose(tip[[0, 2]], minimised(one, angle), atol=5e-4 * one.length)
    assert np.linalg.norm(tips - shape.position(bend, one), axis=1).max() > 0.01 * one.length  # it sags


@pytest.mark.parametrize("start", ["section", "base"])
@pytest.mark.parametrize("twist", [None, 0.02])
def test_the_rod_of_three_sections_is_the_collocated_one_with_the_same_lengths(start, twist):
    """Two solvers that share nothing: that one finds the lengths that tensions give, this one the tip of lengths."""
    one = arm(3, start, gravity=(2.0, -3.0, 8.0), payload=0.02)
    one = replace(one, sections=tuple(replace(section, torsional_stiffness=twist) for section in one.sections))
    true = rod(one, tensions=np.array([9.0, 2.0, 4.0, 1.0, 5.0, 3.0, 4.0, 1.0, 2.0]))
    straight = np.repeat([group.length for group in one.groups], 3)
    bend, _ = bend_from_arc_deltas(true.lengths - straight, one)
    weight = np.array([one.gravity])
    density = [np.repeat(s.mass / s.length * weight[:, None], SEGMENTS, axis=1) for s in one.sections]
    sums = true.tensions.reshape(3, 3).sum(axis=1)[None]
    (tip,) = rod_tips(one, bend[None], np.concatenate(density, axis=1), one.payload * weight, tension=sums)
    np.testing.assert_allclose(tip, true.at([one.length])[0][0], atol=5e-4 * one.length)
    assert np.linalg.norm(shape.position(bend, one) - tip) > 0.01 * one.length


@pytest.mark.parametrize("twist", [None, 0.03])
def test_the_rod_explains_the_simulated_arm_of_three_sections_ever_better(twist):
    one = arm(3, gravity=(2.0, -3.0, 8.0))
    one = replace(one, sections=tuple(replace(s, torsional_stiffness=twist) for s in one.sections))
    left = []
    for links in (8, 16):
        finer = linked(one, links)
        samples = poses_at_rest(finer, Reference.from_bends(bends(3), finer))
        compared = compare(samples)
        left.append(studies.judge_run(samples).rod.unexplained.max_percent)
        assert 100 * compared.shape.max() / one.length > 1.0
    assert left[1] < 0.5 * left[0]
    assert left[1] < 0.15


def test_poses_fill_the_bends_evenly_and_go_to_the_largest():
    one = arm(3)
    found = spread_bends(one, 60, 2.0).reshape(-1, 3, 2)
    angle, plane = arc.to_polar(found)
    assert len(found) == 64 + EXTREMES
    assert not found[0].any()
    assert angle.max() == pytest.approx(2.0)
    np.testing.assert_allclose(angle[-EXTREMES:], 2.0)
    unit = np.concatenate([(angle[1:-EXTREMES] / 2) ** 2, np.mod(plane[1:-EXTREMES] / (2 * np.pi), 1)], axis=1)
    random = np.random.default_rng(1).random((20, *unit.shape))
    assert qmc.discrepancy(unit) < 0.5 * min(qmc.discrepancy(each) for each in random)


def test_validation_of_two_sections_passes_with_second_order_and_errors_by_section():
    found = studies.validate(arm(), 2, max_bend=1.6)
    assert found.verdict == "pass"
    assert found.bends.shape == (16 + EXTREMES, 4)
    assert found.convergence.links == [16, 32, 64]
    assert found.convergence.observed_orders[-1] == pytest.approx(2, abs=0.05)
    ideal, pulled = found.outcomes["ideal"], found.outcomes["gravity"]
    parts = ideal.comparison.section_discretisation
    assert (parts.sum(axis=1) >= (1 - 1e-3) * ideal.comparison.discretisation).all()
    assert [own.section for own in pulled.errors.sections] == [1, 2]
    assert pulled.errors.sections[0].shape.max_m == pulled.comparison.section_shape[:, 0].max()
    assert pulled.rod.unexplained.max_percent < 0.3 < pulled.errors.tip_error.max_percent
    made = document(pulled)
    assert [own["section"] for own in made["sections"]] == [1, 2]
    assert set(made["sections"][0]) == {"section", "discretisation", "servo", "shape", "muscle"}
    assert "sections" not in document(studies.validate(Arm(links=6), 1).outcomes["ideal"])


def test_muscles_of_sections_that_differ_are_told_apart():
    weak = McKibben(max_pressure=1e5, mount_contraction=0.1)
    one = replace(arm(), laws=(McKibben(), weak))
    samples = poses_at_rest(one, Reference.from_bends(bends(2), one))
    whole, own = muscle_use(samples), [s.muscle for s in summarise(samples, compare(samples)).sections]
    assert own[0].max_pressure_needed_pa == samples.pressure[:, :3].max()
    assert whole.max_pressure_needed_pa == max(each.max_pressure_needed_pa or 0.0 for each in own)
    assert own[1].beyond_max_pressure == np.count_nonzero((samples.pressure[:, 3:] > 1e5).any(axis=1)) > 0
    assert own[0].beyond_max_pressure == 0
    for use, group, lengths in zip(own, one.groups, np.split(samples.muscle_lengths, 2, axis=1), strict=True):
        assert use.max_contraction == pytest.approx(1 - lengths.min() / group.rest_length)
    assert whole.min_contraction == min(each.min_contraction for each in own)


@pytest.mark.parametrize(("scale", "said"), [(1000.0, True), (10.0, False), (1.0, False)])
def test_targets_in_millimetres_are_known_by_the_reach(scale, said):
    one = arm()
    reference = Reference.from_bends(bends(2), one)
    samples = poses_at_rest(one, replace(reference, target=scale * reference.target))
    assert summarise(samples, compare(samples)).targets_in_millimetres is said


def test_the_angle_to_a_direction_asked_for_is_told():
    one, bend = arm(3), bends(3)
    turned = shape.rotation(bend.reshape(len(bend), -1), one)
    lean = np.radians(3.0)
    asked = np.cos(lean) * turned[..., 2] + np.sin(lean) * turned[..., 0]
    samples = poses_at_rest(one, replace(Reference.from_bends(bend, one), direction=asked))
    errors = summarise(samples, compare(samples))
    assert errors.direction_error_deg == pytest.approx(3.0, abs=errors.orientation_error_deg + 1e-6)
    samples = poses_at_rest(one, Reference.from_bends(bend, one))
    assert "direction_error_deg" not in document(summarise(samples, compare(samples)))


@pytest.mark.parametrize("start", ["section", "base"])
def test_largest_bends_without_gravity_are_those_that_brute_force_finds(start):
    one, plane, others = arm(start=start), np.radians([0.0, 70.0]), np.array([0.3, 0.2, -0.4, 0.1])
    for section in range(2):
        found = largest_bends(one, plane, section, others)[0]
        for towards, largest in zip(plane, found, strict=True):

            def room(angle, towards=towards, section=section):
                needed = pressure_needed(posed(one, angle, towards, section, others), one)[0]
                return 7e5 - min(needed, 1e9)

            top = 3.1
            if room(top) >= 0:
                assert largest > 3.1
                continue
            assert largest == pytest.approx(brentq(room, 0.5, top), abs=np.radians(0.3))


def test_possibility_of_two_sections_holds_what_it_says(monkeypatch):
    monkeypatch.setattr(pressure_map, "every_bend", lambda *_: 1.0)  # the slow ones below
    monkeypatch.setattr(pressure_map, "fallen_from", lambda *_: [])
    found = studies.possibility(arm(), 1)
    assert [(row.load, row.section) for row in found.rows] == [
        (load, section) for load in ("free", "gravity", "payload") for section in (1, 2)
    ]
    assert all(row.simulated_off_deg < 0.05 for row in found.rows)
    free, pulled, loaded = (row.inflated_deg for row in found.rows if row.section == 1)
    assert loaded < pulled < free  # muscles of section 1 carry what is beyond
    assert len(found.every_bend_to_deg["free"]) == 2
    made = document(found)
    assert made["rows"][0]["section"] == 1
    assert made["others"] == [[0, 0], [0, 0]]
    assert "section" not in document(studies.possibility(Arm(links=6), 1))["rows"][0]


@pytest.mark.slow
def test_every_bend_of_a_section_is_held_up_to_the_least_of_the_largest():
    found = studies.possibility(arm(), 3)
    for load, least in found.every_bend_to_deg.items():
        for section in (1, 2):
            largest = [r.inflated_deg for r in found.rows if (r.load, r.section) == (load, section)]
            assert 0 < least[section - 1] <= min(largest) + 0.01
        assert found.smaller_bends_not_held_deg[load] == [[], []]


@pytest.mark.slow
def test_every_bend_is_found_at_rest_where_one_uniform_bend_sees_no_limit():
    one = replace(arm(3, "base", gravity=(0.0, 0.0, 9.81), payload=0.1), laws=(Tendon(),) * 3)
    planes = np.radians([0.0, 90.0])
    assert (largest_bends(one, planes)[0] > 3.1).all()
    rest = largest_bends_at_rest(one, planes)[0]
    assert (rest < 2.5).all()
    assert every_bend(one) <= rest.min() + 1e-3


def test_tendons_hold_bends_up_to_their_highest_tension():
    one = replace(arm(start="base"), laws=(Tendon(max_tension=25.0),) * 2)
    (largest,), (slack,) = largest_bends(one, np.array([0.5]), 1, np.array([0.2, 0.1, 0.0, 0.0]))

    def room(angle, least):
        return 25.0 - holding_tensions(posed(one, angle, 0.5, 1, np.array([0.2, 0.1, 0.0, 0.0])), one, least).max()

    assert largest == pytest.approx(brentq(room, 0.01, 3.1, args=(5.0,)), abs=np.radians(0.3))
    assert slack == pytest.approx(min(brentq(room, 0.01, 3.14, args=(0.0,)), np.pi), abs=np.radians(0.3))
    rest = largest_bends_at_rest(replace(one, gravity=(0.0, 0.0, 9.81)), np.array([0.5]), 1)[0]
    assert 0.2 < rest[0] < largest
    held = studies.hold(one, bends(2)[0], 0.5)
    assert held.pressures is None
    assert held.simulated_off < 1e-3
    with pytest.raises(InputError, match=r"needs \d+(\.\d+)? N; allowed: at most 6 N for the muscles of section"):
        studies.hold(replace(one, laws=(Tendon(max_tension=6.0),) * 2), np.array([2.0, 0, 1.0, 0]))


@pytest.mark.parametrize("start", ["section", "base"])
def test_stiffness_of_two_sections_in_closed_form_and_by_pushing_agree(start):
    one = linked(arm(start=start), 24)
    found = studies.stiffness(one, bends(2)[1], 2)
    for row in found.rows:
        np.testing.assert_allclose(row.simulated_n_per_m, row.closed_form_n_per_m, rtol=0.02)
        assert row.drift_percent < 0.2
    assert (found.rows[1].simulated_n_per_m > found.rows[0].simulated_n_per_m).all()
    assert found.bend.shape == (2, 2)


def test_directions_are_at_right_angles_wherever_the_tip_goes():
    opposed = np.array([1.0, 0.0, -1.0, 0.0])
    for bend in (np.zeros(4), opposed, *bends(2).reshape(-1, 4)):
        found = directions_of(bend, arm())
        np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
    planar = directions_of(np.array([0.5, 0.0, 0.5, 0.0]), arm())
    np.testing.assert_allclose(planar[1], [0, 1, 0], atol=1e-12)


def test_hold_has_a_list_for_each_section_and_wants_a_bend_for_each():
    one, bend = arm(3), bends(3)[0]
    found = studies.hold(one, bend, 0.4)
    made = document(found)
    pressures = holding_pressures(bend.reshape(-1), one, 0.4)
    assert np.ravel(made["pressures"]).tolist() == pressures.tolist()
    assert [len(own) for own in made["muscle_lengths"]] == [3, 3, 3]
    assert np.shape(made["level_range"]) == (3, 2)
    assert np.shape(made["cocontraction"]) == (3, 9)
    assert found.simulated_off < 1e-6
    for wrong in (bend[0], bend[:2], bend[None], "bent", None, np.full((3, 2), np.nan)):
        with pytest.raises(InputError, match="bend"):
            studies.hold(one, wrong)


def test_a_beam_of_equal_sections_is_one_beam_and_its_energy_is_that_of_its_mode():
    whole = Arm(payload=0.05)
    half = Section(length=0.185, links=12, mass=0.15)
    halves = Arm(sections=(half, half), payload=0.05)
    np.testing.assert_allclose(beam_frequencies(halves, 3), beam_frequencies(whole, 3), rtol=1e-9)
    thin = replace(half, section_radius=1e-6)
    shares = stepped_beam.energy_shares(Arm(sections=(thin, thin)), beam_frequencies(Arm(section_radius=1e-6), 1)[0])
    k, x = 1.8751040687119611, (np.arange(2000) + 0.5) / 2000
    ratio = (np.cosh(k) + np.cos(k)) / (np.sinh(k) + np.sin(k))
    curvature = np.cosh(k * x) + np.cos(k * x) - ratio * (np.sinh(k * x) + np.sin(k * x))
    assert shares[0] == pytest.approx(np.sum(curvature[:1000] ** 2) / np.sum(curvature**2), abs=1e-6)


def test_the_chain_of_unlike_sections_swings_as_the_stepped_beam():
    one = linked(arm(3, payload=0.02), 16)
    one = replace(one, sections=tuple(replace(s, damping_time=0.06 / (1 + k)) for k, s in enumerate(one.sections)))
    np.testing.assert_allclose(natural_frequencies(bare(one), Load(), 6)[::2], beam_frequencies(one), rtol=4e-3)
    modes = swing_modes(linked(one, 8), Load())
    assert modes.small_swing.decay_per_s == pytest.approx(modes.small_swing_of_beam.decay_per_s, rel=0.01)
    assert small_swing(replace(one, sections=tuple(replace(s, damping_time=2.0) for s in one.sections))) is None


def test_a_released_arm_of_two_sections_passes():
    load = Load(wrenches=(Wrench(xi=1.0, force=(0.1, 0.0, 0.0)),))
    found = studies.release(linked(arm(), 16), load, studies.SwingSettings(duration=0.2))
    assert found.verdict == "pass", found.reasons
    assert found.observed_order == pytest.approx(1, abs=0.15)
    assert found.largest_energy_growth_j <= 1e-12


def test_a_motion_of_two_sections_is_explained_and_its_sections_are_told_apart():
    one = linked(arm(gravity=(0.0, 0.0, 9.81)), 12)
    share = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, 101))
    reference = Reference.from_bends(share[:, None] * bends(2)[0].reshape(-1), one, time=np.linspace(0, 1, 101))
    judged = studies.judge_run(simulate(one, reference, check_step=True), 20)
    assert judged.judged.explained, judged.judged.checks
    assert judged.rod.unexplained.max_percent < 0.25
    assert judged.rod.inertia.max_percent > 0
    names = [check.name for check in judged.judged.checks]
    assert {"stretch in section 1", "stretch in section 2"} <= set(names)


def test_the_spiral_of_two_sections_is_followed_as_one_arc():
    one = arm(gravity=(0.0, 0.0, 9.81))
    spiral = _spiral(one, 2.0)
    row = _row("gravity", "servo", spiral, simulate(one, spiral), _reachable(one, spiral))
    assert isinstance(row, Followed)
    assert row.tip_rms_percent < 8
    assert row.along_rms_percent == pytest.approx(row.tip_rms_percent, rel=0.1)  # a tip that reaches a volume
    assert row.pushes == 0


@pytest.mark.slow
def test_every_controller_of_two_sections_is_compared():
    found = studies.compare_controllers(arm(), 1.0)
    assert len(found.rows) == 18


def test_a_muscle_of_one_section_has_its_own_law_and_length():
    one = arm(3, start="base")
    found = studies.muscle_law(one, (2e5,), section=2)
    assert found.rest_length_m == pytest.approx(one.groups[1].rest_length)
    assert group_of(one, 3).length == pytest.approx(one.groups[2].length)
    same = Arm(sections=(SECTIONS[0], replace(SECTIONS[0], mass=0.05)))
    assert studies.muscle_law(same).rest_length_m == pytest.approx(same.groups[0].rest_length)
    for section, said in ((None, "not given, and they differ"), (0, "is 0"), (4, "is 4")):
        with pytest.raises(InputError, match=said):
            studies.muscle_law(one, section=section)


def _at_rest(one, poses):
    """Return the ideal scenario of an arm of 24 links a section over random bends to 120 deg."""
    (ideal, *_), rng = scenarios(linked(one, 24)), np.random.default_rng(12)
    count = len(one.sections)
    angles = np.radians(120) * np.sqrt(rng.random((poses, count)))
    return examine(ideal, arc.from_polar(angles, rng.uniform(-np.pi, np.pi, (poses, count))).reshape(poses, -1))


def _check_at_rest(found):
    assert found.verdict == "pass", found.judged.checks
    assert found.chain_error.max_percent <= 0.01
    assert found.errors.tip_error.max_percent <= 0.15
    assert found.errors.muscle.min_force_n > 0
    print(f"chain {found.chain_error.max_percent:.2e} %, arc {found.errors.tip_error.max_percent:.4f} %")


@pytest.mark.parametrize("name", ["two", "three", "tendon"])
def test_at_rest_the_simulated_arm_is_the_chain_and_nearly_the_arcs(name):
    _check_at_rest(_at_rest(preset(name), 20))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two", "three", "tendon"])
def test_at_rest_a_thousand_poses_are_the_chain_and_nearly_the_arcs(name):
    _check_at_rest(_at_rest(preset(name), 1000))


@pytest.mark.parametrize("start", ["section", "base"])
def test_at_rest_straight_spans_are_nearly_the_chain_of_ball_joints(start):
    one = arm(start=start)
    one = replace(one, routings=tuple(replace(routing, path="spans") for routing in one.routings))
    _check_at_rest(_at_rest(one, 20))


def test_waypoints_below_the_base_are_joined_as_they_are():
    places = np.array([[0.1, 0.0, -0.1], [0.0, 0.0, -0.15], [0.0, 0.1, 0.2]])
    path = from_waypoints(Waypoints(places, None, ["a", "b", "c"]), 0.37, 1.0, on_dome=False)
    _, found = path.targets(200.0)
    assert np.isfinite(found).all()
    assert all(np.linalg.norm(found - place, axis=1).min() < 2e-3 for place in places)
