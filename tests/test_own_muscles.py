"""Muscles at angles of their own, by laws that differ, through several sections: environments, studies and pictures."""

import json
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from contarm_sim import studies
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics import muscles
from contarm_sim.mechanics.pressures import section_pressures
from contarm_sim.mechanics.statics import balance
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_dict, arm_to_toml
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.presets import preset
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.results.summary import muscle_use
from contarm_sim.studies import needs, pressure_map
from contarm_sim.studies.at_rest import setting_of
from contarm_sim.studies.balance_at_rest import RestingBalance
from contarm_sim.studies.largest_bends import fallen_from, largest_bends
from contarm_sim.studies.muscle_curves import group_of
from contarm_sim.studies.scenarios import scenarios
from contarm_sim.view.figures import figures_of, left_out, over_time, reach
from contarm_sim.view.live.loads import Loads
from contarm_sim.view.live.panel import Panel
from contarm_sim.view.report.map import draw_possibility, no_map
from contarm_sim.view.report.study_figures import draw_muscle_law
from contarm_sim.view.report.words import available, remarks
from contarm_sim.view.sections import backbone_lines, reachable_tips
from contarm_sim.view.style import drawn

HANGING = (0.0, 0.0, 9.81)
SECTIONS = (
    Section(length=0.20, links=8, mass=0.10, bending_stiffness=0.04),
    Section(length=0.17, links=8, mass=0.06, bending_stiffness=0.02),
)
ROUTINGS = (Routing(radius=0.014), Routing(radius=0.013, offset=0.3))
PNEUMATIC = Arm(sections=SECTIONS, routings=ROUTINGS)
MIXED = replace(PNEUMATIC, laws=(McKibben(), Tendon()))
TENDONS = Arm(links=8, muscle=Tendon())
FOUR = Arm(links=8, routings=(Routing(count=4, offset=0.4),))
UNEVEN = Arm(links=8, routings=(Routing(at=(0.3, 2.2, 4.6)),))


def turned(arm, offset):
    return replace(arm, routings=(replace(arm.routings[0], offset=offset),))


# Environments


@pytest.mark.parametrize("arm", [turned(Arm(links=8), 1.0), UNEVEN, FOUR], ids=["turned", "uneven", "four"])
def test_the_loaded_arm_is_aimed_whatever_its_muscles_angles(arm):
    pytest.importorskip("gymnasium")
    from contarm_sim.envs.definition import define

    resting = define("reach", replace(arm, gravity=HANGING)).task.resting
    bends = arc.from_polar(np.radians([60.0, 90.0]), np.array([0.3, 2.0]))
    targets = resting.tips(bends)
    found = resting.bends(targets)
    assert np.linalg.norm(resting.tips(found) - targets, axis=1).max() < 1e-4


@pytest.mark.parametrize("arm", [turned(Arm(), np.pi), UNEVEN], ids=["turned", "uneven"])
def test_the_baseline_holds_whatever_the_muscles_angles(arm):
    pytest.importorskip("gymnasium")
    from contarm_sim.envs.baseline import baseline
    from contarm_sim.envs.definition import define
    from contarm_sim.envs.scores import score

    definition = define("hold", arm)
    assert score(definition, baseline(definition), 10).success.all()


def test_what_varies_follows_the_law():
    from contarm_sim.envs.variations import check, varied, varied_arm

    tendon, random = replace(TENDONS, muscle=Tendon(friction=0.1)), np.random.RandomState(0)
    found = varied_arm({"muscle.friction": 0.2, "mass": lambda first, now, _: first + now}, tendon, tendon, random)
    assert found == replace(tendon, muscle=Tendon(friction=0.2), mass=2 * tendon.mass)
    assert "muscle.friction" not in varied(Arm())
    assert "section_2.muscle.friction" in varied(MIXED)
    with pytest.raises(InputError, match=r"muscle.valve_time' is unknown"):
        check({"muscle.valve_time": 0.1}, (), tendon)
    with pytest.raises(InputError, match=r"section 2: mass is -1"):
        varied_arm({"section_2.mass": -1.0}, MIXED, MIXED, random)


# Studies


def test_shares_are_those_of_the_pressures():
    one = replace(PNEUMATIC, routings=tuple(replace(line, path="spans", start="base") for line in ROUTINGS))
    held = balance(np.random.default_rng(1).uniform(-1.5, 1.5, (200, 4)), one)
    for found, expected in zip(needs.needs(held, one), section_pressures(held, one), strict=True):
        np.testing.assert_allclose(found, (expected / 7e5).max(axis=-1), rtol=1e-12)


def test_of_an_arm_that_mixes_laws_each_muscle_has_its_own_limits():
    """A McKibben muscle that shortens loses force; the cables of the other section do not lend it theirs."""
    bends = np.random.default_rng(2).uniform(-1.2, 1.2, (300, 4))
    mixed, both = balance(bends, MIXED), balance(bends, PNEUMATIC)
    own = muscles.slices(MIXED)
    low, most = needs.limits(mixed, MIXED)
    np.testing.assert_allclose(most[:, own[0]], 7e5 * both.per_pascal[:, own[0]])
    np.testing.assert_allclose(most[:, own[1]], 200.0)
    tensions = mixed.at(mixed.level(low))
    pressures = tensions[:, own[0]] / mixed.per_pascal[:, own[0]]
    shares = np.maximum(pressures.max(axis=1) / 7e5, tensions[:, own[1]].max(axis=1) / 200.0)
    np.testing.assert_allclose(needs.needs(mixed, MIXED)[0], shares)
    assert pressures.min() >= 90e3 * (1 - 1e-9)
    # Bent alone, the McKibben section ends where it does on an arm of McKibben muscles alone.
    weak = McKibben(max_pressure=3e5)
    planes = np.radians([0.0, 70.0])
    ends = [largest_bends(replace(PNEUMATIC, laws=(weak, law)), planes)[0] for law in (weak, Tendon())]
    assert (ends[1] < 3.0).all()
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-9)
    found = studies.hold(replace(MIXED, laws=(weak, Tendon())), np.array([0.4, 0.0, 0.3, 0.2]), 1.0)
    held = balance([0.4, 0.0, 0.3, 0.2], MIXED)
    assert (found.actuator_tensions[0] / held.per_pascal[:3]).max() == pytest.approx(3e5)
    assert found.actuator_tensions[1].max() == pytest.approx(200.0)


def test_the_least_of_a_cable_is_slack():
    """One cable slack, the other two of a straight arm pull nothing."""
    assert needs.needs_of([0.0, 0.0], TENDONS)[1] == pytest.approx(0.0, abs=1e-12)
    taut, slack = needs.needs_of(arc.from_polar(1.0, np.radians([0.0, 60.0, 100.0])), TENDONS)
    moment = TENDONS.bending_stiffness / TENDONS.length
    assert taut[0] - slack[0] == pytest.approx(5.0 / 200)
    assert slack[0] == pytest.approx(moment / TENDONS.muscle_radius / 200, rel=1e-2)


def test_planes_begin_at_the_sections_first_muscle(monkeypatch):
    monkeypatch.setattr(pressure_map, "every_bend", lambda *given: 1.0)
    weak = turned(Arm(links=8, muscle=McKibben(max_pressure=2e5)), 1.0)
    straight = turned(weak, 0.0)
    found, expected = (studies.possibility(arm, 2).rows[:2] for arm in (weak, straight))
    assert [row.plane_deg for row in expected] == [0.0, 180.0]
    np.testing.assert_allclose([row.plane_deg for row in found], np.degrees([1.0, 1.0 + np.pi]))
    np.testing.assert_allclose([r.inflated_deg for r in found], [r.inflated_deg for r in expected], atol=0.1)
    asked = []

    def needed(self, bend):
        asked.append(bend)
        return 0.0, 0.0

    monkeypatch.setattr(RestingBalance, "needed", needed)
    fallen_from(weak, 0.5)
    np.testing.assert_allclose(arc.to_polar(np.array(asked))[1], 1.0)


def test_controllers_of_an_arm_without_pressures(contarm, tmp_path):
    (tmp_path / "tendons.toml").write_text(arm_to_toml(TENDONS))
    words = ("compare-controllers", "--arm", "tendons.toml", "--duration", 0.5)
    code, out, err = contarm(*words)
    assert code == 0, err
    assert "failed" not in out
    assert "more than any" not in out
    assert "pressure is left out" in out
    (last,) = [line for line in out.splitlines() if "payload" in line and " tip " in line]
    assert " - " in last


def test_pressures_of_an_arm_that_mixes_laws():
    samples = poses_at_rest(MIXED, Reference.from_bends(np.array([[0.3, 0.1, 0.2, 0.0]]), MIXED))
    use = muscle_use(samples)
    assert use.max_pressure_needed_pa == samples.pressure[:, :3].max() < 7e5
    assert muscle_use(samples, slice(3, 6)).max_pressure_needed_pa is None
    for arm in (MIXED, replace(MIXED, laws=MIXED.laws[::-1])):
        assert available({"arm": arm_to_dict(arm)}) == "90 to 700 kPa"


@pytest.mark.parametrize("arm", [Arm(), PNEUMATIC])
def test_weight_over_stiffness(arm):
    setting = setting_of(scenarios(arm)[2])
    softness = sum(section.length / section.bending_stiffness for section in arm.sections)
    assert setting.weight_over_stiffness == pytest.approx(arm.mass * 9.81 * arm.length * softness)


# Pictures


def test_a_muscle_through_two_sections_is_asked_for_the_lengths_of_both():
    long = replace(PNEUMATIC, routings=(ROUTINGS[0], replace(ROUTINGS[1], start="base")))
    group = group_of(long, 2)
    sheet = drawn(lambda sheet: draw_muscle_law(sheet, group, [2e5]))
    (span,) = (patch for patch in sheet.axes[0].patches if isinstance(patch, Rectangle))
    asked = (1 - np.array([span.get_x(), span.get_x() + span.get_width()]) / 100) * group.rest_length
    np.testing.assert_allclose(np.ptp(asked), 4 * 0.013 * arc.LARGEST_BEND)
    np.testing.assert_allclose(asked.mean(), 0.37)


def test_lengths_are_drawn_of_the_muscles_own_angles():
    """Where the muscles are turned, the broad line of the simulation still lies under the analytic one."""
    for arm in (turned(Arm(links=8), np.radians(60)), FOUR):
        for ax in drawn(lambda sheet, arm=arm: over_time.lengths(sheet, arm)).axes[:2]:
            simulated, analytic = (line.get_ydata() for line in ax.lines)
            np.testing.assert_allclose(simulated, analytic, atol=0.02 * np.abs(analytic).max())


def test_the_map_turns_with_the_muscles():
    """Of turned muscles, bends are turned and the map of lengths is the same."""
    sizes = []
    for offset in (0.0, 1.0):
        arms = {"free": turned(Arm(links=8), offset)}
        sheet = drawn(lambda sheet, arms=arms: draw_possibility(sheet, arms))
        sizes.append([path.get_extents().size for path in sheet.axes[0].collections[-1].get_paths()])
    np.testing.assert_allclose(sizes[0], sizes[1], rtol=1e-3)


def test_figures_that_an_arm_has_not_are_left_out(contarm, tmp_path):
    assert set(left_out(Arm())) == {"slices", "density", "dexterity", "elbow"}
    assert {"possibility", "lengths-on-map"} == set(left_out(FOUR)) - set(left_out(Arm()))
    assert {"possibility", "lengths-on-map", "stiffness"} == set(left_out(TENDONS)) - set(left_out(Arm()))
    assert set(figures_of(Arm()) | figures_of(preset("two"))) == {*figures_of(Arm()), *left_out(Arm())}
    assert no_map(turned(Arm(), 1.0)) is None
    (tmp_path / "t.toml").write_text(arm_to_toml(TENDONS))
    code, out, err = contarm("figures", "--arm", "t.toml", "stiffness", "--out", "f")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "'stiffness'; allowed: for muscles with pressures" in err


@pytest.mark.parametrize("arm", [FOUR, PNEUMATIC, TENDONS], ids=["four", "two", "tendons"])
def test_possibility_says_that_it_draws_no_map(arm, contarm, tmp_path, monkeypatch):
    from contarm_sim.cli import possibility

    monkeypatch.setattr(possibility, "PLANES", 1)
    monkeypatch.setattr(possibility, "PLANES_OF_SECTIONS", 1)
    monkeypatch.setattr(pressure_map, "every_bend", lambda *given: 1.0)
    monkeypatch.setattr(pressure_map, "fallen_from", lambda *given: [])
    (tmp_path / "a.toml").write_text(arm_to_toml(arm))
    code, out, err = contarm("possibility", "--arm", "a.toml", "--out", "p", "--json")
    assert code == 0, err
    assert json.loads(out)["left_out"]["possibility"].startswith("needs ")
    assert err.count("no map is drawn: it needs") == 1
    assert [path.name for path in (tmp_path / "p").iterdir()] == ["summary.json"]


def test_slices_have_no_empty_margin(monkeypatch):
    monkeypatch.setattr(reach, "CELLS", 16)
    monkeypatch.setattr(reach, "POSES", 20_000)
    for arm in (preset("two"), preset("three")):
        sheet = drawn(lambda sheet, arm=arm: reach.slices(sheet, arm))
        box = sheet.get_tightbbox()
        assert 0 <= box.y0 < 0.15
        assert sheet.get_figheight() - 0.15 < box.y1 <= sheet.get_figheight()


def test_the_live_pages_sliders_change_one_thing_each():
    laws = (McKibben(min_tension=3.0), Tendon(pretension=8.0))
    session = SimpleNamespace(arm=replace(PNEUMATIC, laws=laws))
    session.change = lambda arm: setattr(session, "arm", arm)
    panel = object.__new__(Panel)
    panel._session, panel._turn = session, lambda: None
    gui = SimpleNamespace(
        add_folder=lambda name: nullcontext(),
        add_dropdown=lambda name, options, initial_value, hint: SimpleNamespace(value=initial_value),
        add_slider=lambda name, min, max, initial_value, **_: SimpleNamespace(value=initial_value, min=min, max=max),
    )
    panel._loads = loads = Loads(gui, session.arm)
    mount, gravity, payload = loads.controls
    mount.value, gravity.value, payload.value = "hanging", 9.81, 50.0
    panel._least = SimpleNamespace(value=12.0, min=0.0, max=100.0)
    panel._load()
    assert session.arm.laws == laws
    assert (session.arm.gravity, session.arm.payload) == ((0.0, 0.0, 9.81), 0.05)
    panel._contract()
    assert [law.min_tension for law in session.arm.laws] == [12.0, 12.0]
    assert session.arm.payload == 0.05


def test_backbone_and_reachable_tips_by_section():
    points = np.arange(3.0 * 17).reshape(17, 3)
    (whole,) = backbone_lines(points, Arm(links=16))
    assert whole[0] == "backbone"
    assert whole[2] is points
    first, second = backbone_lines(points, PNEUMATIC)
    assert (first[0], second[0]) == ("section 1", "section 2")
    np.testing.assert_array_equal(first[2][-1], second[2][0])
    assert len(first[2]) == len(second[2]) == 9
    assert reachable_tips(Arm(), 5, 7, 1.0).shape == (5, 7, 3)
    np.testing.assert_allclose(reachable_tips(Arm(), 5, 7, 1.0)[-1, 0], arc.position([1.0, 0.0], Arm().length))
    tips = reachable_tips(PNEUMATIC, 9, 7)
    assert np.linalg.norm(tips, axis=-1).max() == pytest.approx(0.37, rel=1e-4)


@pytest.mark.parametrize(("arm", "said"), [(MIXED, False), (PNEUMATIC, True)])
def test_the_controller_of_pressures_is_named_where_all_muscles_have_them(arm, said):
    use = {"pushes": 0, "beyond_max_pressure": 0, "below_min_pressure": 2, "max_pressure_needed_pa": 5e5}
    summary = {"arm": arm_to_dict(arm), "motion": 0.0, "muscle": use, "pulls_only": True, "samples": 9}
    (line,) = remarks(summary)
    assert ("the controller `pressure`" in line) is said
