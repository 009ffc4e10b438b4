"""What values say of themselves, in text and in notebooks: short, true, and well-formed."""

import re
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from made_fit import made_fit
from references import along, resting
from text_boxes import faults

import contarm_sim
from contarm_sim import paths, studies
from contarm_sim.display import LONGEST, Shown
from contarm_sim.errors import InputError
from contarm_sim.identify.replay import Replay
from contarm_sim.kinematics import inverse
from contarm_sim.mechanics.shape import backbone
from contarm_sim.mjcf.scene import base_rotation
from contarm_sim.model import presets
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.world import World
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.motion.simulate import simulate
from contarm_sim.results.compare import compare
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.view.notebook.cards import _CARDS
from contarm_sim.view.notebook.sketch import Line, side_view

ARM = Arm(links=8)
HANGING = Arm(links=8, gravity=(0.0, 0.0, 9.81), payload=0.05)


@pytest.fixture(scope="module")
def run():
    return simulate(HANGING, along(HANGING, "circle", 1.0, max_bend=0.8), "chain")


@pytest.fixture(scope="module")
def rest():
    return poses_at_rest(ARM, resting(ARM, np.array([[0.5, 0.2], [1.0, 0.0]])))


@pytest.fixture(scope="module")
def shown(run, rest):
    two = presets.two()
    bend = np.array([1.0, 0.0])
    return [
        *(make() for make in presets.PRESETS.values()), run, rest, compare(run), run.reference, rest.reference,
        simulate(two, along(two, "circle", 0.3, max_bend=0.4), "chain"),
        inverse.solve(np.full((9, 3), (0.05, 0.0, 0.3)), backbone(two)),
        equilibrium(HANGING), studies.hold(ARM, bend), studies.stiffness(ARM, bend, levels=2),
        studies.muscle_law(ARM), studies.release(replace(ARM, links=4), settings=studies.SwingSettings(duration=0.2)),
        studies.judge_run(run, 5), studies.possibility(ARM, planes=1),
        studies.compare_controllers(replace(ARM, links=4), duration=0.5), studies.validate(ARM, grid=1),
        studies.trust(replace(ARM, links=4), planes=1),
        *studies.cases_at_rest([studies.LoadCase(ARM, Load())]), made_fit(), _replay(),
    ]  # fmt: skip


def _replay():
    left = made_fit().left[0]
    return Replay(presets.tendon(), left.recording, left.predicted, np.zeros((len(left.recording), 1, 4, 4)))


class Seen(HTMLParser):
    """The words of a page; refuses tags that do not match."""

    def __init__(self, page):
        super().__init__()
        self.open, self.words = [], []
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag, attrs):
        if tag != "br":
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_all_are_short_in_text_and_in_notebooks(shown):
    for one in shown:
        assert isinstance(one, Shown)
        page = one._repr_html_()
        assert 200 < len(page) < 30_000, type(one).__name__
        assert len(repr(one)) <= max(LONGEST, 500)
        assert "array([" not in repr(one) + page
        assert "nan" not in Seen(page).words
        assert not re.search(r"(color|background):\s*(#[0-9a-f]|black|white)", page.replace("#D55E00", ""), re.I)
        for picture in re.findall("<svg.*?</svg>", page):
            assert ET.fromstring(picture).get("aria-label")


def test_every_card_is_of_something_that_is_shown(shown):
    kinds = {kind.__name__ for one in shown for kind in type(one).__mro__}
    assert set(_CARDS) <= kinds


def test_parts_of_an_arm_and_loads_say_the_calls_that_make_them():
    assert [repr(one) for one in (McKibben(), Section(), World(), Load(), Routing(count=5))] == [
        "McKibben()", "Section()", "World()", "Load()", "Routing(count=5)",
    ]  # fmt: skip
    path = paths.named("circle", 0.37, duration=2.0, max_bend=0.5)
    assert repr(path) == "Path(circle, 2 s)"


def test_answers_are_in_the_text(shown):
    said = {type(one).__name__: repr(one) for one in shown}
    assert re.search(r"bending [\d.]+ to [\d.]+ N/m", said["Stiffness"])
    assert said["Equilibrium"].startswith("Equilibrium(stable, tip (")


def test_holds_swings_and_muscles_have_units(shown):
    pages = {type(one).__name__: " ".join(Seen(one._repr_html_()).words) for one in shown}
    hold = studies.hold(ARM, np.array([1.0, 0.0]))
    for cell in ("pressure [kPa]", f"{hold.pressures[0] / 1e3:.1f}", f"{1e3 * hold.muscle_lengths[0]:.2f}", "57.3"):
        assert cell in pages["Hold"]
    law = studies.muscle_law(ARM)
    assert "700 kPa" in pages["MuscleCurves"]
    assert f"{law.force_n[-1, 0]:.1f}" in pages["MuscleCurves"]
    (release,) = (one for one in shown if isinstance(one, studies.Release))
    assert "clamped beam [Hz]" in pages["Release"]
    assert f"{release.modes.arm_hz[0]:.3g}" in pages["Release"]


def test_an_arm_says_the_call_that_makes_it():
    assert repr(Arm()) == "Arm()"
    own = Arm(length=0.25, muscle_radius=0.015, muscle=McKibben(max_pressure=5e5), path="spans", payload=0.1)
    five = Arm(routings=(Routing(count=5, offset=0.1),))
    names = {name: getattr(contarm_sim, name) for name in contarm_sim.__all__}
    assert repr(own).startswith("Arm(length=0.25, muscle_radius=0.015, path='spans', muscle=McKibben(max_pressure")
    for arm in (own, five, *(make() for make in presets.PRESETS.values())):
        assert eval(repr(arm), names) == arm


def test_a_trajectory_shows_its_numbers(run):
    words = " ".join(Seen(run._repr_html_()).words)
    error = compare(run).tip_error.max()
    assert f"{1e3 * error:.3g} mm at most ({100 * error / HANGING.length:.3g} % of length)" in words
    assert f"{run.muscle_tensions.min():.3g} to {run.muscle_tensions.max():.3g} N" in words
    assert "payload 0.05 kg" in words
    assert "without samples" in run.first(0)._repr_html_()


def test_words_of_ones_own_are_escaped(run):
    assert "<script>" not in replace(run, controller="<script>x</script>")._repr_html_()


def _heights(picture):
    """Return the first and the last height of the first path that is no base: of the line that is drawn first."""
    lines = [path.get("d") for path in ET.fromstring(picture).iter("{http://www.w3.org/2000/svg}path")]
    line = next(d for d in lines if d.count("L") > 1)
    return [float(point.split()[1]) for point in re.split("[ML]", line)[1:]]


@pytest.mark.parametrize(
    ("world", "down"),
    [
        ({}, False), ({"gravity": (0, 0, -9.81)}, False), ({"gravity": (0, 0, 9.81)}, True),
        ({"base_orientation": (0, 1, 0, 0)}, True),
        ({"gravity": (0, 0, 9.81), "base_orientation": (1, 0, 0, 0)}, False),
    ],
)  # fmt: skip
def test_a_hanging_arm_hangs_in_its_picture(world, down):
    arm = Arm(**world)
    straight = Line(np.linspace((0, 0, 0), (0, 0, 0.4), 5))
    picture = side_view([straight], "x", arm.world)
    heights = _heights(picture)
    assert (heights[-1] > heights[0]) is down  # heights count from above
    assert ("font-style" in picture) is any(arm.gravity)
    assert ("rotate(" in picture) is (len(world) == 2)  # as stated, gravity points upwards


@pytest.mark.parametrize("seed", range(4))
def test_up_is_what_the_engine_turns_up(seed):
    random = np.random.default_rng(seed)
    for given in ({"gravity": random.normal(size=3)}, {"base_orientation": random.normal(size=4)}, {}):
        arm = Arm(**{name: tuple(values) for name, values in given.items()})
        np.testing.assert_allclose(arm.world.up, base_rotation(arm)[2], atol=1e-12)


def test_pictures_of_points_and_lines_along_gravity_are_finite():
    for points in (np.zeros((1, 3)), np.zeros((4, 3)), np.linspace((0, 0, 0), (0.3, 0, 0), 4)):
        for gravity in ((0, 0, 0), (9.81, 0, 0), (1.0, 2.0, 3.0)):
            assert "nan" not in side_view([Line(points)], "x", World(gravity=gravity))


def test_figures_are_shown_as_pictures_of_their_size(run, rest):
    for samples, figure in ((run, "overview"), (run, "path"), (run, "budget"), (rest, "overview"), (rest, "path")):
        picture, size = samples.plot(figure)._repr_png_()
        assert struct.unpack(">II", picture[16:24]) == pytest.approx((2 * size["width"], 2 * size["height"]), abs=1)
        assert size["width"] == round(170 / 25.4 * 96)
        assert len(picture) < 400_000


def test_the_overview_shows_what_was_recorded_and_its_text_fits(run, rest, shown):
    of_two = next(one for one in shown if getattr(one, "arm", None) == presets.two())
    for samples in (run, rest, of_two):
        for width in ("page", "column"):
            sheet = samples.plot(width=width)
            assert faults(sheet) == []
            top, middle, bottom = sheet.axes
            np.testing.assert_array_equal(top.lines[0].get_ydata(), 1e3 * samples.tip_error)
            muscles = samples.muscle_lengths.shape[1]
            assert [len(axes.lines) for axes in (middle, bottom)] == [muscles, muscles]
            assert bottom.get_xlabel() == ("time [s]" if samples.moving else "pose")
    assert run.plot(titles=False).get_suptitle() == ""


def test_figures_that_cannot_be_are_refused(run, rest):
    for samples, given in (
        (run, {"figure": "pth"}),
        (run, {"figure": 3}),
        (run, {"width": "wide"}),
        (run, {"titles": "no"}),
        (run.first(0), {}),
        (rest, {"figure": "budget"}),
        (rest, {"figure": "muscles"}),
    ):
        with pytest.raises(InputError):
            samples.plot(**given)


def test_what_is_shown_loads_no_engine(run, tmp_path):
    run.save(tmp_path / "t.npz")
    program = (
        f"import sys, contarm_sim; t = contarm_sim.load({str(tmp_path / 't.npz')!r}); t._repr_html_(); "
        "t.arm._repr_html_(); contarm_sim.compare(t)._repr_html_(); "
        "print([name for name in sys.modules if name.startswith(('mujoco', 'matplotlib', 'scipy'))])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
