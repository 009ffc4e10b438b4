"""Every figure is drawn from a computation made then, in vectors, with units; and what it shows is true."""

import os
import re
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pytest
from held_bends import E, balance
from rod import tension
from text_boxes import faults

from contarm_sim.kinematics import arc, inverse
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.model.presets import PRESETS
from contarm_sim.model.section import Section
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths import named
from contarm_sim.paths.reference import Reference
from contarm_sim.results.compare import compare
from contarm_sim.studies.scenarios import scenarios
from contarm_sim.view.figures import FIGURES, FOLLOWING, OF_SEVERAL, common, figures_of, reach, studies
from contarm_sim.view.figures import fan as fanning
from contarm_sim.view.figures import sag as sagging
from contarm_sim.view.prints import WIDTHS
from contarm_sim.view.report import map as maps
from contarm_sim.view.style import drawn, write

UNITS = r"\[(mm|deg|kPa|N|N/m|s|-|% of length)\]"
ARM = Arm(links=8)
HANGING = Arm(links=8, gravity=(0, 0, 9.81), payload=0.1)
LENGTH, RADIUS = 1e3 * ARM.length, 1e3 * ARM.muscle_radius  # [mm]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(studies, "GRID", 4)
    monkeypatch.setattr(studies, "DURATION", 3.0)
    monkeypatch.setattr(common, "DURATION", 3.0)


def _lines(ax):
    """Return the points of every labelled line of an axis, by label; those in space have three coordinates [mm]."""
    return {line.get_label(): _points(line).T for line in ax.lines}


def _points(line):
    return getattr(line, "world", np.transpose(getattr(line, "get_data_3d", line.get_data)()))


def _arc_tip(angle):
    """Return how far off the axis and how high the tip of an arc is [mm], by its bend [rad]."""
    return LENGTH * (1 - np.cos(angle)) / angle, LENGTH * np.sin(angle) / angle


def _chain_error(angle):
    """Return how far the tips of arc and chain are apart [% of length], by the bend [rad]."""
    half = angle / ARM.links / 2
    return 100 * (1 - half / np.tan(half)) * np.sinc(angle / 2 / np.pi)


def fan(axes):
    arcs = [_points(line).T for line in axes[0].lines if len(_points(line)) == 60]
    angles = np.tile(np.radians([30, 60, 90, 120, 150]), 3)
    tips = np.array([[np.hypot(*line[:2, -1]), line[2, -1]] for line in arcs])
    np.testing.assert_allclose(tips, np.transpose(_arc_tip(angles)), atol=1e-9)
    chain = _lines(axes[0])["simulated at rest"]
    assert chain.shape == (3, ARM.links + 1)
    tip = np.hypot(*chain[:2, -1]), chain[2, -1]
    np.testing.assert_allclose(tip, _arc_tip(np.pi / 6), atol=0.003 * LENGTH)


def possibility(axes):
    for ax in axes[:3]:
        two, three = ax.lines[0].get_data()
        np.testing.assert_allclose(two**2 + three**2 + two * three, 0.75 * (RADIUS * np.radians(179.9)) ** 2)
    edge = max(axes[0].collections[-1].get_paths(), key=lambda path: len(path.vertices))
    two, three = edge.vertices[:: len(edge.vertices) // 60].T
    bends = 2 / 3 * np.transpose([two + three, two, three]) @ (E * [[1], [-1], [-1]]) / RADIUS
    needed, second = [], []
    for bend in bends:
        lengths, tensions, inflated, _ = balance(ARM, bend)
        per_pascal = tension(1.0, lengths, ARM)[0]
        needed.append([((tensions + least) / per_pascal).max() for least in (-tensions.min(), inflated)])
        second.append(np.sort((tensions - tensions.min()) / per_pascal)[1])
    vented, inflated = np.transpose(needed) / ARM.pneumatics.max_pressure  # one muscle without any tension, or none
    assert (vented < 1.01).all()
    assert (inflated > 0.99).all()
    spare = (np.array(second) - ARM.pneumatics.min_pressure) / ARM.pneumatics.max_pressure
    # Between the two, only where the way with a vented muscle ends: another would be below the lowest pressure.
    assert np.abs([1 - vented, inflated - 1, spare]).min(axis=0).max() < 0.02


def spiral(axes):
    shown = _lines(axes[0])
    assert np.ptp(np.linalg.norm(shown["paper's, on its shell"], axis=0)) < 1e-9 * LENGTH
    reached = shown["nearest, analytic tip"]
    angle = 2 * np.arctan2(np.hypot(*reached[:2]), reached[2])
    np.testing.assert_allclose(np.linalg.norm(reached, axis=0), LENGTH * np.sinc(angle / 2 / np.pi), rtol=1e-9)
    assert np.linalg.norm(shown["simulated tip"] - reached, axis=0).max() < 0.15 * LENGTH  # in 3 s it lags


def path(axes):
    simulated = _lines(axes[0])["simulated tip"]
    followed = common.followed(ARM).stations[:, -1]
    np.testing.assert_allclose(simulated.T, 1e3 * followed, atol=1e-9)  # without gravity the world is the base frame


def angles(axes):
    for value, off, near in zip(axes[:2], axes[2:], (4, 8), strict=True):
        simulated, analytic = (line.get_ydata() for line in value.lines)
        assert np.nanmax(np.abs(simulated - analytic)) < near
        np.testing.assert_allclose(off.lines[0].get_ydata(), simulated - analytic, atol=1e-9)
    assert np.nanmax(axes[0].lines[1].get_ydata()) == pytest.approx(120, abs=1)
    assert np.nanmax(np.abs(np.diff(axes[1].lines[1].get_ydata()))) < 90  # no jumps of a turn


def lengths(axes):
    bend = common.followed(ARM).bend
    for value, off, muscle in zip(axes[:2], axes[2:], (1, 2), strict=True):
        simulated, analytic = (line.get_ydata() for line in value.lines)
        np.testing.assert_allclose(analytic, -RADIUS * bend @ E[muscle], atol=1e-9)
        assert 0 < np.abs(simulated - analytic).max() < 1
        np.testing.assert_allclose(off.lines[0].get_ydata(), simulated - analytic, atol=1e-9)


def lengths_on_map(axes):
    two, three = _lines(axes[0])["paper's ellipse, bends of 180°"]
    np.testing.assert_allclose(two**2 + three**2 + two * three, 0.75 * (RADIUS * np.radians(179.9)) ** 2)
    two, three = _lines(axes[0])["simulated"]
    assert (two**2 + three**2 + two * three).max() == pytest.approx(0.75 * (RADIUS * np.radians(120)) ** 2, rel=0.1)


def _examined(scenario, degrees, planes=(0.3,)):
    """Return the median of tip errors [% of length] over planes, of a scenario at rest at bends of any angles."""
    bends = arc.from_polar(np.radians(degrees)[:, None], np.asarray(planes)).reshape(-1, 2)
    rested = poses_at_rest(scenario.arm, Reference.from_bends(bends, scenario.arm), scenario.controller)
    return np.median(100 * compare(rested).tip_error.reshape(len(degrees), -1), axis=1) / ARM.length


def errors_by_bend(axes):
    """Marks are what was found; lines between them go where the arm is, at bends that were not examined."""
    last = []
    planes = np.radians(np.arange(0, 360, 30))
    for line, mark, scenario in zip(axes[0].lines[::3], axes[0].lines[1::3], scenarios(ARM), strict=False):
        angle, error = line.get_data()
        at, found = (values[1:] for values in mark.get_data())  # the straight pose has no error
        np.testing.assert_allclose(at, [42.5, 85, 127.5, 170])
        np.testing.assert_allclose(found, _examined(scenario, at, planes), rtol=1e-6)
        between = np.array([20.0, 110.0])
        np.testing.assert_allclose(np.interp(between, angle, error), _examined(scenario, between, planes), rtol=0.05)
        last.append(found[-1])
    assert axes[0].lines[-1].get_ydata()[0] == 1
    ideal, naive, gravity, payload, upright = last
    assert ideal == pytest.approx(_chain_error(np.radians(170)), rel=0.05)
    assert payload > gravity > 10 * ideal
    assert min(naive, upright) > ideal


def error_map(axes):
    """All maps have one scale; the black line is where an arm is off by 1 %."""
    maps = [ax for ax in axes if ax.name == "polar"]
    (levels,) = {tuple(ax.collections[0].levels) for ax in maps}
    given = scenarios(ARM)
    assert levels[-3] < _examined(given[3], np.linspace(120, 170, 6)).max() < levels[-1]
    for ax, scenario in zip(maps, given, strict=True):
        edge = [path.vertices for path in ax.collections[1].get_paths() if len(path.vertices)]
        at_rim = [_examined(scenario, np.array([170.0]), [plane])[0] for plane in np.radians(np.arange(0, 360, 30))]
        assert bool(edge) == (max(at_rim) > 1)
        for plane, radius in edge[0][::40] if edge else ():
            assert _examined(scenario, np.array([radius]), [plane])[0] == pytest.approx(1, rel=0.05)


def _heights(area):
    """Return where an area between two curves has corners, and its height there, negative where it is taken off."""
    corners = area.get_paths()[0].vertices
    count = (len(corners) - 3) // 2
    return corners[1 : count + 1, 0], corners[count + 2 : 2 * count + 2, 1][::-1] - corners[1 : count + 1, 1]


def budget(axes):
    """The areas above zero less those below make the error."""
    time, total = axes[0].lines[0].get_data()
    at, heights = zip(*(_heights(area) for area in axes[0].collections), strict=True)
    assert len(heights) == 4
    np.testing.assert_allclose(np.sum(heights, axis=0), np.interp(at[0], time, total), atol=1e-9 * LENGTH)
    assert total.max() > 0
    links, _, _, motion = heights
    compared = compare(common.followed(ARM))
    error = compared.simulated_tip - compared.analytic_tip
    size = np.linalg.norm(error, axis=1)
    share = ((compared.chain_tip - compared.analytic_tip) * error).sum(axis=1)[1:] / size[1:]
    np.testing.assert_allclose(links[1:], 1e3 * np.interp(at[0][1:], time[1:], share), atol=1e-9)
    assert motion.max() > 0.9 * total.max()


def convergence(axes):
    links, error = _lines(axes[0])["simulated vs arc"]
    np.testing.assert_allclose(np.diff(np.log(error)) / np.diff(np.log(links)), -2, atol=0.1)


def controllers(axes):
    names = [label.get_text() for label in axes[0].get_yticklabels()]
    for ax in axes:
        dots = [tuple(float(value[0]) for value in line.get_data()) for line in ax.lines if len(line.get_xdata())]
        whole = {round(y + 0.17): x for x, y in dots if y % 1 > 0.5}
        along = {round(y - 0.17): x for x, y in dots if y % 1 < 0.5}
        assert set(whole) == set(along)
        said = {round(text.xy[1] + 0.01): text.get_text() for text in ax.texts}
        assert set(range(len(names))) - set(whole) <= set(said)  # who is not there says why
        assert all(re.fullmatch(r"needs \d+ kPa|not run: needs\n\d+ kPa, has 700", words) for words in said.values())
        # A part is no more than the whole, but for the samples that each is taken over.
        assert all(along[place] <= 1.1 * whole[place] for place in whole)
        if ax is not axes[0]:
            assert whole[names.index("tip")] == min(whole.values())
    assert "muscles have 700 kPa" in axes[0].figure.get_suptitle()


def stiffness(axes):
    for ax in axes[:3]:
        closed, pushed = _lines(ax)["closed form"], _lines(ax)["simulated, pushed"]
        np.testing.assert_allclose(pushed, closed, rtol=0.05)
        assert (np.diff(closed[0]) > 0).all()


def sag(axes):
    for line in axes[0].lines[:3]:
        weight, moved = line.get_data()
        order = np.diff(np.log(moved)) / np.diff(np.log(weight))
        assert order[0] == pytest.approx(1, abs=0.02)  # a small weight moves the tip in proportion
    own = ARM.mass * 9.81 * ARM.length**2 / ARM.bending_stiffness
    assert axes[0].lines[3].get_xdata()[0] == pytest.approx(own)


TRUTHS = {name: globals()[name.replace("-", "_")] for name in FIGURES}


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_a_vector_drawing_with_units_that_shows_what_is_true(name, tmp_path):
    meaning, draw = FIGURES[name]
    figure = drawn(lambda sheet: draw(sheet, ARM))
    write(figure, tmp_path / "f.svg")
    text = (tmp_path / "f.svg").read_text()
    ElementTree.fromstring(text)
    assert re.findall(UNITS, text)
    assert len(meaning) > 20
    TRUTHS[name](figure.axes)


STUDIED = ("errors-by-bend", "error-map", "convergence", "controllers", "stiffness")
"""Figures of studies: `test_study_figures` does the same with them."""


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", [name for name in FIGURES if name not in STUDIED])
def test_text_is_whole_and_apart_at_both_widths(name, width):
    for arm in (HANGING, ARM if width == "column" else Arm(links=8, gravity=(9.81, 0, 0))):
        sheet = drawn(lambda sheet, arm=arm: FIGURES[name][1](sheet, arm), width)
        assert faults(sheet) == []
        assert sheet.get_figwidth() * 25.4 == pytest.approx(WIDTHS[width])
        assert sheet.get_suptitle()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("name", [name for name in OF_SEVERAL if name not in STUDIED])
def test_text_of_figures_of_several_sections_is_whole_and_apart(name, width, monkeypatch):
    monkeypatch.setattr(reach, "CELLS", 16)
    monkeypatch.setattr(reach, "POSES", 20_000)
    for preset in ("two",) if name == "elbow" else ("two", "three"):
        assert faults(drawn(lambda sheet, preset=preset: OF_SEVERAL[name][1](sheet, PRESETS[preset]()), width)) == []


def test_a_hanging_arm_is_drawn_as_it_hangs_and_sags():
    """Its base is above, and the tips at rest are those under its own weight and payload: far from the arcs."""
    ax = drawn(lambda sheet: FIGURES["fan"][1](sheet, HANGING)).axes[0]
    chains = [_points(line) for line in ax.lines if line.get_marker() == "o"]
    assert all(chain[1:, 2].max() < 0 for chain in chains)
    bends = arc.from_polar(np.radians([30, 60, 90, 120, 150]), 0.7)
    rest = 1e3 * poses_at_rest(HANGING, Reference.from_bends(bends, HANGING)).tip
    tips = np.array([chain[-1] for chain in chains])
    np.testing.assert_allclose(-tips[:, 2], rest[:, 2], atol=0.01)  # the same in every plane
    assert (tips[:, 2] + _arc_tip(np.radians([30, 60, 90, 120, 150]))[1]).max() < -0.01 * LENGTH
    assert "gravity" in {text.get_text() for text in ax.texts}
    free = drawn(lambda sheet: FIGURES["fan"][1](sheet, ARM)).axes[0]
    assert "gravity" not in {text.get_text() for text in free.texts}


def test_weight_over_stiffness_counts_the_payload():
    twice = Arm(links=8, gravity=(0, 0, 9.81), payload=ARM.mass)
    own = [sagging._moved(arm)[1] for arm in (ARM, twice)]
    assert own[1] == pytest.approx(2 * own[0])
    weights, mine, moved = sagging._moved(twice)
    reference = Reference.from_bends(arc.from_polar(np.radians([90]), 0.4), twice)
    off = np.linalg.norm(poses_at_rest(twice, reference).tip - poses_at_rest(twice.unloaded, reference).tip)
    between = np.exp(np.interp(np.log(mine), np.log(weights), np.log(moved[1])))
    assert between == pytest.approx(100 * off / twice.length, rel=0.05)


def test_own_paths_are_followed(contarm, tmp_path):
    own = common.OwnPath("the circle", Reference.from_path(named("circle", ARM.length, 2.0, max_bend=0.5), ARM))
    ax = drawn(lambda sheet: FIGURES["angles"][1](sheet, ARM, own)).axes[0]
    np.testing.assert_allclose(ax.lines[1].get_ydata(), np.degrees(0.5), atol=1e-6)
    given = ("--links", "8", "--figures", "svg", "--path", "circle", "--max-bend", "30deg", "--duration", "2")
    code, out, _ = contarm("figures", *given, "--out", "f")
    assert code == 0
    assert [line.split("/")[-1] for line in out.split()] == [f"{name}.svg" for name in FOLLOWING]
    assert "the circle" in (tmp_path / "f" / "angles.svg").read_text()
    code, out, err = contarm("figures", "angles", "--path", "square", "--out", "g")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert not (tmp_path / "g").exists()


def test_figures_that_follow_no_path_refuse_one_and_none_leaves_nothing(contarm, tmp_path):
    code, _, err = contarm("figures", "fan", "--path", "circle", "--out", "f")
    assert code == 2
    assert "'fan'" in err
    assert all(name in err for name in FOLLOWING)
    code, _, err = contarm("figures", "fan", "--figures", "none", "--out", "f")
    assert code == 2
    assert "--figures" in err
    assert not (tmp_path / "f").exists()


@pytest.mark.parametrize("width", WIDTHS)
def test_axes_in_space_have_two_ticks_each_and_say_where_the_base_is_turned(width):
    short = Arm(links=8, length=0.23)  # whose ends are just off the next round step
    for arm, frame in ((short, ""), (HANGING, "world ")):
        circle = named("circle", arm.length, 3.0, max_bend=np.pi / 3)
        own = common.OwnPath("it", Reference.from_path(circle, arm))
        sheet = drawn(lambda sheet, arm=arm, own=own: figures_of(arm)["path"][1](sheet, arm, own), width)
        texts = [text.get_text() for text in sheet.axes[0].texts]
        assert {f"{frame}{axis} [mm]" for axis in "xyz"} <= set(texts)
        assert faults(sheet) == []
        numbers = [text for text in sheet.axes[0].texts if re.fullmatch(r"\N{MINUS SIGN}?\d+", text.get_text())]
        away = {tuple(np.round(text.get_position(), 3)) for text in numbers}  # from the axis, another way for each
        assert len(away) == 3
        assert all(sum(np.allclose(text.get_position(), way, atol=1e-3) for text in numbers) > 1 for way in away)
        assert ("hanging" in sheet.get_suptitle()) is bool(frame)


def test_a_motion_is_simulated_once_for_all_figures_and_widths(monkeypatch):
    calls, real, arm = [], common.simulate, Arm(links=9)

    def counted(*given):
        calls.append(given)
        return real(*given)

    monkeypatch.setattr(common, "simulate", counted)
    for name in ("angles", "lengths", "lengths-on-map"):
        for width in WIDTHS:
            drawn(lambda sheet, name=name: FIGURES[name][1](sheet, arm), width)
    assert len(calls) == 1


@pytest.mark.parametrize(
    ("name", "module", "costly"),
    [
        ("fan", fanning, "poses_at_rest"), ("possibility", maps, "ways_to_hold"),
        ("stiffness", studies, "tip_stiffness"), ("budget", studies, "moved_by_motion"),
        ("elbow", inverse, "family"),
    ],
)  # fmt: skip
def test_what_a_figure_shows_is_computed_once_for_both_widths(monkeypatch, name, module, costly):
    calls, real = [], getattr(module, costly)

    def counted(*given):
        calls.append(given)
        return real(*given)

    monkeypatch.setattr(module, costly, counted)
    two = Arm(sections=(Section(length=0.21), Section(length=0.17)))
    arm = two if name == "elbow" else Arm(links=7, payload=0.0123)  # no other test has drawn it
    counts = [len(calls) for width in WIDTHS if drawn(lambda sheet: figures_of(arm)[name][1](sheet, arm), width)]
    assert counts[0] == counts[1] > 0


def test_a_figure_follows_the_arm(tmp_path):
    """Nothing is drawn from memory: another arm gives another picture, the same arm the same one."""
    draw = FIGURES["lengths"][1]
    for file, arm in (("a", ARM), ("b", Arm(links=8)), ("c", Arm(links=8, muscle_radius=0.02))):
        write(drawn(lambda sheet, arm=arm: draw(sheet, arm)), tmp_path / f"{file}.svg")
    a, b, c = ((tmp_path / f"{f}.svg").read_text() for f in "abc")
    assert a == b != c
    assert muscle_hex(0) not in a


def test_the_same_figure_is_the_same_bytes_in_another_process_and_at_another_time(tmp_path):
    program = (
        "import sys; from pathlib import Path; from contarm_sim.model.arm import Arm;"
        "from contarm_sim.view.figures import FIGURES; from contarm_sim.view.prints import KINDS, Prints;"
        "from contarm_sim.view.style import save; path = Path(sys.argv[1]);"
        "save(path.parent, path.name, lambda sheet: FIGURES['possibility'][1](sheet, Arm(links=8)), Prints(KINDS))"
    )
    for file, seed, threads in (("a", "1", "1"), ("b", "2", "4")):
        changed = {"PYTHONHASHSEED": seed, "OPENBLAS_NUM_THREADS": threads, "TZ": "UTC" + seed}
        subprocess.run([sys.executable, "-c", program, tmp_path / file], check=True, env=os.environ | changed)
    for end in (".png", ".pdf", ".svg"):
        assert (tmp_path / f"a{end}").read_bytes() == (tmp_path / f"b{end}").read_bytes(), end
