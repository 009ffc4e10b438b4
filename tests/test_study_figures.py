"""Figures of runs and studies: readable at both widths, and what they show is what was found."""

from dataclasses import replace

import numpy as np
import pytest
from text_boxes import faults

from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.model.presets import preset
from contarm_sim.model.tendon import Tendon
from contarm_sim.motion.lag import moved_by_motion
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import compare
from contarm_sim.studies.attempts import attempt
from contarm_sim.studies.controllers import ControllerComparison, Followed, NotFollowed
from contarm_sim.studies.convergence import convergence
from contarm_sim.studies.scenarios import dome_grid, scenarios, spread_bends
from contarm_sim.studies.swings import SIDEWAYS, SwingSettings, release
from contarm_sim.studies.tip_stiffness import stiffness
from contarm_sim.studies.trusted_bends import loaded_arms
from contarm_sim.view.colours import ANALYTIC, ERROR, LIMIT, MISS, SCENARIOS, SIMULATED, TARGET, rgb
from contarm_sim.view.prints import WIDTHS
from contarm_sim.view.report.budget import along, draw_budget, draw_parts, parts_of
from contarm_sim.view.report.error_field import error_field
from contarm_sim.view.report.error_maps import draw_error_maps
from contarm_sim.view.report.errors_by_bend import FIRST, LEAST, draw_errors_by_bend
from contarm_sim.view.report.run_figures import draw_muscles, draw_path
from contarm_sim.view.report.study_figures import (
    draw_controllers,
    draw_convergence,
    draw_muscle_law,
    draw_stiffness,
)
from contarm_sim.view.report.swing import draw_swing
from contarm_sim.view.style import drawn

ARM = Arm(links=8)
ARMS = {
    "hanging": replace(ARM, gravity=(0.0, 0.0, 9.81), payload=0.1),
    "sideways": replace(ARM, gravity=(9.81, 0.0, 0.0)),
    "tendons": replace(ARM, laws=(Tendon(),)),
    "three": preset("three"),
}


def _quick(arm):
    """Return an arm of few links."""
    return replace(arm, sections=tuple(replace(section, links=6) for section in arm.sections))


@pytest.fixture(scope="module", params=ARMS)
def run(request):
    """A short motion, beside the closed forms, and what motion adds to its error."""
    arm, time = _quick(ARMS[request.param]), np.arange(121) / 100
    rise = np.radians(60) * (0.5 - 0.5 * np.cos(np.pi * time / time[-1]))
    bend = np.concatenate([arc.from_polar(rise, 2 * time + number) for number in range(len(arm.sections))], axis=-1)
    samples = simulate(arm, Reference.from_bends(bend, arm, time))
    return samples, compare(samples), moved_by_motion(samples)


@pytest.fixture(scope="module")
def outcomes():
    return [attempt(scenario, dome_grid(3)) for scenario in scenarios(ARM)]


def sheets(draw):
    """Return what a function draws, at both widths, without faults in its text."""
    out = [drawn(draw, width) for width in WIDTHS]
    for sheet in out:
        assert faults(sheet) == []
        assert sheet.get_suptitle()
        assert sheet.get_figheight() < 240 / 25.4  # it fits on a page
    return out


@pytest.mark.parametrize("draw", [draw_budget, draw_parts])
def test_what_errors_come_from_is_readable_at_both_widths(run, draw):
    samples, compared, motion = run
    sheets(lambda sheet: draw(sheet, samples, compared, motion))


def test_the_path_is_drawn_as_the_arm_hangs(run):
    samples, compared, _ = run
    for sheet in sheets(lambda sheet: draw_path(sheet, samples, compared)):
        lines = {line.get_label(): line.world for line in sheet.axes[0].lines if hasattr(line, "world")}
        np.testing.assert_allclose(
            np.linalg.norm(lines["simulated tip"], axis=1), 1e3 * np.linalg.norm(compared.simulated_tip, axis=1)
        )
        down = np.array(samples.arm.gravity)
        said = [text.get_text() for text in sheet.axes[0].texts]
        assert ("gravity" in said) is bool(down.any())
        if down.any():  # what lies along gravity in the base frame is below in the world
            fallen = 1e3 * samples.target @ down / np.linalg.norm(down)
            np.testing.assert_allclose(lines["target"][:, 2], -fallen, atol=1e-6)


def test_parts_along_the_error_add_up_to_it(run):
    samples, compared, motion = run
    error = compared.simulated_tip - compared.analytic_tip
    for given, count in ((motion, 4), (None, 3), ((samples.time[[0, -1]], np.full((2, 3), np.nan)), 3)):
        index, parts = parts_of(samples, compared, given)
        assert len(parts) == count
        found = sum(along(part.moved, error[index]) for part in parts)
        np.testing.assert_allclose(found, compared.tip_error[index], atol=1e-12)
    (moving,) = (part for part in parts_of(samples, compared, motion)[1] if part.words.startswith("motion"))
    np.testing.assert_array_equal(moving.moved, motion[1])


def test_muscles_stand_in_columns_with_their_limits_named(run):
    samples, _, _ = run
    arm, pneumatic = samples.arm, hasattr(samples.arm.groups[0].law, "max_pressure")
    for sheet in sheets(lambda sheet: draw_muscles(sheet, samples)):
        count = len(arm.groups)
        assert len(sheet.axes) == count * (4 if pneumatic else 3)
        drawn_tensions = [line.get_ydata() for line in sheet.axes[2 * count].lines[:3]]
        np.testing.assert_array_equal(np.transpose(drawn_tensions), samples.muscle_tensions[:, :3])
        off = [line.get_ydata() for line in sheet.axes[count].lines[:3]]
        assert np.abs(off).max() < 0.5  # [mm]: lengths are held
        words = [text.get_text() for ax in sheet.axes for text in ax.texts]
        assert words == (["least:\n5 N", "lowest:\n90 kPa", "highest:\n700 kPa"] if pneumatic else ["least:\n5 N"])


def test_what_no_pressure_does_is_marked():
    """Bent so far that a muscle is longer than its braid, no pressure gives what its servo pulls with."""
    samples = poses_at_rest(_quick(ARM), Reference.from_bends(np.zeros((3, 2)), _quick(ARM)))
    pressure = samples.pressure.copy()
    pressure[1:, 1] = np.inf
    samples = replace(samples, pressure=pressure, time=np.arange(3.0))
    for sheet in sheets(lambda sheet: draw_muscles(sheet, samples)):
        marks = [line for line in sheet.axes[3].lines if line.get_marker() == "^" and len(line.get_xdata())]
        assert [list(line.get_xdata()) for line in marks] == [[1, 2]]
        assert np.isfinite(sheet.axes[3].get_ylim()).all()
        assert "more than any pressure" in [text.get_text() for text in sheet.legends[0].texts]


def test_a_miss_is_drawn_where_there_is_one():
    arm, time = _quick(ARM), np.arange(31) / 30
    bend = arc.from_polar(np.radians(40) * time, 0.0)
    reference = Reference.from_bends(bend, arm, time)
    samples = simulate(arm, replace(reference, target=reference.target + np.array([0.0, 0.0, 0.01])))
    compared = compare(samples)
    for sheet in sheets(lambda sheet: draw_budget(sheet, samples, compared)):
        (miss,) = (line for line in sheet.axes[1].lines if line.get_color() == MISS)
        np.testing.assert_allclose(miss.get_ydata(), 10)
        assert "miss: target off the dome" in [text.get_text() for text in sheet.legends[0].texts]


def test_errors_at_rest_are_readable_and_keep_scenarios_without_rest(outcomes):
    weak = replace(ARM, bending_stiffness=0.02)
    fallen = [attempt(scenario, dome_grid(2)) for scenario in scenarios(weak)]
    own = replace(ARM, gravity=(9.81, 0.0, 0.0))
    for arm, found in ((ARM, outcomes), (weak, fallen), (own, [attempt(s, dome_grid(2)) for s in scenarios(own)])):
        for draw in (draw_errors_by_bend, draw_error_maps):
            for sheet in sheets(lambda sheet, draw=draw, arm=arm, found=found: draw(sheet, arm, found)):
                words = [text.get_text() for ax in sheet.axes for text in ax.texts]
                words += [text.get_text() for legend in sheet.legends for text in legend.texts]
                assert any("no rest pose" in said for said in words) is (found is fallen)


def test_errors_of_several_sections_are_those_of_the_poses():
    arm = _quick(preset("two"))
    found = [attempt(scenario, spread_bends(arm, 8, 1.5)) for scenario in scenarios(arm)]
    for sheet in sheets(lambda sheet: draw_errors_by_bend(sheet, arm, found)):
        for ax, outcome in zip(sheet.axes, found, strict=True):
            shown = np.concatenate([line.get_ydata() for line in ax.lines if line.get_linestyle() == "None"])
            expected = 100 * outcome.comparison.tip_error / arm.length
            np.testing.assert_allclose(np.sort(shown), np.sort(expected))


def test_errors_by_bend_begin_where_there_are_some_and_name_bands_that_are_seen(outcomes):
    even = [attempt(next(each for each in scenarios(ARM) if each.name == "ideal"), dome_grid(6))]
    for found, bands in ((outcomes, True), (even, False)):
        for sheet in sheets(lambda sheet, found=found: draw_errors_by_bend(sheet, ARM, found)):
            ax = sheet.axes[0]
            assert ax.get_xscale() == "log"
            assert 1 < ax.get_xlim()[0] <= FIRST
            spread = []
            for band in ax.collections:
                x, y = band.get_paths()[0].vertices.T
                spread += [y[x == at].max() / y[x == at].min() for at in np.unique(x) if y[x == at].min() > LEAST]
            assert bool(max(spread) > 1.25) is bands
            assert ("band" in sheet.get_suptitle()) is bands


def test_the_error_between_poses_goes_through_them_all(outcomes):
    for outcome in outcomes:
        angle, plane = arc.to_polar(outcome.samples.bend)
        expected = 100 * outcome.comparison.tip_error / ARM.length
        np.testing.assert_allclose(error_field(outcome, angle, plane), expected, atol=1e-9)


def test_controllers_say_what_they_need():
    followed = Followed("free", "tip", 2.0, 3.0, 0.02, 0.0, 70.0, 741e3, 0, 0.0, 75.0)
    within = replace(followed, controller="servo", peak_pressure_pa=500e3)
    rows = (followed, within, NotFollowed("free", "pressure", "too much", 765e3), NotFollowed("free", "chain", "fell"))
    found = ControllerComparison(rows, 10.0, ARM)
    for sheet in sheets(lambda sheet: draw_controllers(sheet, found)):
        assert [text.get_text() for text in sheet.axes[0].texts] == [
            "needs 741 kPa", "not run: needs\n765 kPa, has 700", "not run: failed",
        ]  # fmt: skip
        assert "700 kPa" in sheet.get_suptitle()
    tendons = ControllerComparison((replace(within, peak_pressure_pa=None),), 10.0, ARMS["tendons"])
    assert "kPa" not in sheets(lambda sheet: draw_controllers(sheet, tendons))[0].get_suptitle()


@pytest.mark.parametrize("arm", [ARM, _quick(preset("two"))], ids=["one", "two"])
def test_stiffness_convergence_and_muscles_are_readable(arm):
    bend = np.tile([0.5, 0.2], len(arm.sections))
    held = stiffness(arm, bend, 3)
    for sheet in sheets(lambda sheet: draw_stiffness(sheet, held)):
        assert len(sheet.legends) == 1
        assert sheet.axes[0].get_ylim() == sheet.axes[1].get_ylim()
    study = convergence(arm, dome_grid(1) if len(arm.sections) == 1 else spread_bends(arm, 2, 1.0))
    sheets(lambda sheet: draw_convergence(sheet, study))
    for sheet in sheets(lambda sheet: draw_muscle_law(sheet, arm.groups[-1], [1e5, 4e5, 7e5])):
        labels = [text for text in sheet.axes[0].texts if "kPa" in text.get_text()]
        edge = sheet.axes[0].get_window_extent().x0
        assert min(text.get_window_extent().x0 for text in labels) > edge + 2


def test_a_straight_arm_is_rigid_along_itself():
    held = stiffness(ARM, np.zeros(2), 2)
    for sheet in sheets(lambda sheet: draw_stiffness(sheet, held)):
        assert "rigid" in [text.get_text() for text in sheet.axes[2].texts]


def test_a_swing_is_readable():
    found = release(ARM, SIDEWAYS, SwingSettings(0.001, 0.2, 0.01, (1.0,), None))
    for sheet in sheets(lambda sheet: draw_swing(sheet, ARM, found.swing)):
        shown = sheet.axes[0].lines[0].get_ydata()
        tip = found.swing.swing.tip[:, 0]
        np.testing.assert_allclose(shown, 1e3 * (tip - tip[-1]))


def test_scenarios_differ_in_grey(outcomes):
    """Where colours are gone, marks differ; no line is too pale for white paper."""
    (sheet, _) = sheets(lambda sheet: draw_errors_by_bend(sheet, ARM, outcomes))
    marks = [line for line in sheet.axes[0].lines if line.get_marker() not in ("None", None, "")]
    assert len({line.get_marker() for line in marks}) == len(outcomes)
    for line in marks:
        red, green, blue = rgb(line.get_color())
        assert 0.2126 * red + 0.7152 * green + 0.0722 * blue < 0.75


def test_a_load_looks_the_same_in_all_figures_and_like_no_other():
    named = {scenario.name for arm in (ARM, replace(ARM, gravity=(0, 0, 0))) for scenario in scenarios(arm)}
    loads = {under.load for under in loaded_arms(replace(ARM, gravity=(0, 0, 0)))}
    assert named | loads == set(SCENARIOS)
    assert SCENARIOS["free"] == SCENARIOS["ideal"]
    looks = [look for name, look in SCENARIOS.items() if name != "ideal"]
    for each in zip(*looks, strict=True):  # colours, dashes, marks
        assert len(set(each)) == len(looks)
    assert not {look.colour for look in looks} & {SIMULATED, ANALYTIC, TARGET, ERROR, LIMIT}
    assert MISS != SIMULATED
