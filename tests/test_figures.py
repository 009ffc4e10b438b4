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

from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.view.figures import FIGURES, common, studies
from contarm_sim.view.style import drawn, write

UNITS = r"\[(mm|deg|kPa|N|N/m|s|-|% of length)\]"
ARM = Arm(links=8)
LENGTH, RADIUS = 1e3 * ARM.length, 1e3 * ARM.muscle_radius  # [mm]


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(studies, "GRID", 2)
    monkeypatch.setattr(studies, "DURATION", 3.0)
    monkeypatch.setattr(common, "DURATION", 3.0)


def _lines(ax):
    """Return the points of every labelled line of an axis, by label."""
    return {line.get_label(): np.array(getattr(line, "get_data_3d", line.get_data)()) for line in ax.lines}


def _arc_tip(angle):
    """Return how far off the axis and how high the tip of an arc is [mm], by its bend [rad]."""
    return LENGTH * (1 - np.cos(angle)) / angle, LENGTH * np.sin(angle) / angle


def _chain_error(angle):
    """Return how far the tips of arc and chain are apart [% of length], by the bend [rad]."""
    half = angle / ARM.links / 2
    return 100 * (1 - half / np.tan(half)) * np.sinc(angle / 2 / np.pi)


def fan(axes):
    arcs = [np.array(line.get_data_3d()) for line in axes[0].lines if len(line.get_data_3d()[0]) == 60]
    angles = np.tile(np.radians([30, 60, 90, 120, 150]), 6)
    tips = np.array([[np.hypot(*line[:2, -1]), line[2, -1]] for line in arcs])
    np.testing.assert_allclose(tips, np.transpose(_arc_tip(angles)), atol=1e-9)
    chain = _lines(axes[0])["simulated chain"]
    assert chain.shape == (3, ARM.links + 1)
    np.testing.assert_allclose(chain[::2, -1], _arc_tip(np.pi / 3), atol=0.003 * LENGTH)


def possibility(axes):
    for ax in axes[:3]:
        two, three = ax.lines[0].get_data()
        np.testing.assert_allclose(two**2 + three**2 + two * three, 0.75 * (RADIUS * np.radians(179.9)) ** 2)
    edge = max(axes[0].collections[1].get_paths(), key=lambda path: len(path.vertices))
    two, three = edge.vertices[:: len(edge.vertices) // 12].T
    bends = 2 / 3 * np.transpose([two + three, two, three]) @ (E * [[1], [-1], [-1]]) / RADIUS
    needed = []
    for bend in bends:
        lengths, tensions, inflated, _ = balance(ARM, bend)
        per_pascal = tension(1.0, lengths, ARM)[0]
        needed.append([((tensions + least) / per_pascal).max() for least in (-tensions.min(), inflated)])
    vented, inflated = np.transpose(needed) / ARM.pneumatics.max_pressure  # one muscle without any tension, or none
    assert (vented < 1.01).all()
    assert (inflated > 0.99).all()
    assert (
        np.minimum(1 - vented, inflated - 1) < 0.01
    ).mean() > 0.4  # between them only where one gives way to the other


def spiral(axes):
    shown = _lines(axes[0])
    assert np.ptp(np.linalg.norm(shown["the paper's, on its shell"], axis=0)) < 1e-9 * LENGTH
    reached = shown["nearest on the dome (analytic)"]
    angle = 2 * np.arctan2(np.hypot(*reached[:2]), reached[2])
    np.testing.assert_allclose(np.linalg.norm(reached, axis=0), LENGTH * np.sinc(angle / 2 / np.pi), rtol=1e-9)
    assert np.linalg.norm(shown["simulated tip"] - reached, axis=0).max() < 0.15 * LENGTH  # in 3 s it lags


def angles(axes):
    for ax, near in zip(axes, (4, 8), strict=True):
        simulated, analytic = (line.get_ydata() for line in ax.lines)
        assert np.nanmax(np.abs(simulated - analytic)) < near
    assert np.nanmax(axes[0].lines[1].get_ydata()) == pytest.approx(120, abs=1)
    assert np.nanmax(np.abs(np.diff(axes[1].lines[1].get_ydata()))) < 90  # no jumps of a turn


def lengths(axes):
    bend = common.followed(ARM).bend
    for ax, muscle in zip(axes, (1, 2), strict=False):
        simulated, analytic = (line.get_ydata() for line in ax.lines)
        np.testing.assert_allclose(analytic, -RADIUS * bend @ E[muscle], atol=1e-9)
        assert 0 < np.abs(simulated - analytic).max() < 1
        np.testing.assert_allclose(axes[2].lines[2 * muscle - 2].get_ydata(), simulated - analytic, atol=1e-9)


def lengths_on_map(axes):
    two, three = _lines(axes[0])["paper's ellipse, bends of 180°"]
    np.testing.assert_allclose(two**2 + three**2 + two * three, 0.75 * (RADIUS * np.radians(179.9)) ** 2)
    two, three = _lines(axes[0])["spiral, simulated"]
    assert (two**2 + three**2 + two * three).max() == pytest.approx(0.75 * (RADIUS * np.radians(120)) ** 2, rel=0.1)


def error_map(axes):
    largest = [ax.collections[0].levels[-1] for ax in axes if ax.name == "polar"]
    ideal, naive, gravity, payload, upright = largest
    expected = _chain_error(np.radians([85, 170])).max()
    assert ideal == pytest.approx(expected, rel=0.05)
    assert payload > gravity > 10 * ideal
    assert min(naive, upright) > ideal


def budget(axes):
    total = axes[0].lines[0].get_ydata()
    layers = [item.get_paths()[0].vertices[:, 1].max() for item in axes[0].collections]
    assert layers == sorted(layers)
    assert layers[-1] >= total.max() > 0
    assert layers[0] == pytest.approx(_chain_error(np.radians(120)) * LENGTH / 100, rel=0.1)


def convergence(axes):
    links, error = _lines(axes[0])["simulated vs arc"]
    np.testing.assert_allclose(np.diff(np.log(error)) / np.diff(np.log(links)), -2, atol=0.1)


def controllers(axes):
    for ax in axes:
        names = [label.get_text() for label in ax.get_xticklabels()]
        heights = {round(bar.get_x() + bar.get_width() / 2, 3): bar.get_height() for bar in ax.patches}
        for place in range(len(names)):
            assert (place - 0.2 in heights) is (place + 0.2 in heights)
            # A part is no more than the whole, but for the samples that each is taken over.
            assert heights.get(place + 0.2, 0) <= 1.1 * heights.get(place - 0.2, 0)
        if ax is not axes[0]:
            assert heights[names.index("tip") - 0.2] == min(whole for at, whole in heights.items() if at % 1 > 0.5)


def stiffness(axes):
    for ax in axes:
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
