"""report.html: one file that needs nothing else, in a real browser."""

import io
from dataclasses import replace
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pytest
from browser import browser, drag, needs_browser, open_page
from PIL import Image
from references import along
from waiting import wait_for

from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.view.prints import Prints
from contarm_sim.view.rendering.encode import encoder, encoding
from contarm_sim.view.report.pictures import LARGEST_VIDEO, embedded, still
from contarm_sim.view.report.run import RunReport


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    arm = Arm()
    report = RunReport(simulate(arm, along(arm, "spiral", 2.0, turns=0.5)))
    report.draw(folder)
    _film(folder / "video.mp4", 15, 30)
    given = {
        "path": "</script><b>",
        "duration": 2.0,
        "rate": 100.0,
        "command": "contarm run --out '<&>'",
        "video": "video.mp4",
    }
    report.write_page(folder, report.summary | given)
    return folder / "report.html"


def _film(path, fps, frames, draw=lambda i: np.full((720, 1280, 3), 8 * i, np.uint8)):
    with encoding(encoder(), path, (720, 1280), fps) as add:
        for i in range(frames):
            add(draw(i))


class _Outline(HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags = []

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))


def test_the_page_needs_nothing_else_and_says_everything_in_words(page):
    text = page.read_text()
    assert len(text) + 4 / 3 * LARGEST_VIDEO < 3e6
    outline = _Outline()
    outline.feed(text)
    ranks = [int(tag[1]) for tag, _ in outline.tags if tag in ("h1", "h2", "h3")]
    assert ranks[0] == 1
    assert ranks.count(1) == 1
    assert all(below - above <= 1 for above, below in pairwise(ranks))
    for tag, attributes in outline.tags:
        for name in ("src", "href"):
            assert attributes.get(name, "data:").startswith("data:"), (tag, attributes)
        if tag == "img":
            assert len(attributes["alt"]) > 20
    names = [tag for tag, _ in outline.tags]
    assert names.count("button") == 4  # three figures, and one to close what is enlarged
    assert "`" not in text[: text.index('<script id="plotly"')].split("<script>")[0]
    assert names.count("img") == 3
    assert names.count("video") == 1
    assert "<b>: spiral" not in text
    assert "contarm run --out &#39;&lt;&amp;&gt;&#39;" in text
    order = [
        "<h1>Constant curvature",
        "The simulation is explained",
        "All targets are within reach",
        "<video",
        "budget",
    ]
    places = [text.index(words) for words in order]
    assert places == sorted(places)
    assert text.index("target against simulated tip") < text.index("analytic against simulated tip")


@needs_browser
def test_a_browser_shows_it_without_an_error_and_the_view_answers_to_the_mouse(page):
    errors = []
    with browser() as chromium:
        shown = open_page(chromium, page.as_uri(), errors, 700, 500)
        view = shown.locator("#view")
        view.locator("canvas").first.wait_for()
        view.scroll_into_view_if_needed()
        shown.wait_for_function("[...document.querySelectorAll('button img')].every(image => image.naturalWidth > 100)")
        wait_for(lambda: view.screenshot() == view.screenshot())  # it is drawn and moves no more
        before, box = view.screenshot(), view.bounding_box()
        centre = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        drag(shown, centre, (centre[0] + 120, centre[1]))
        shown.mouse.move(1, 1)  # off the view, where nothing is shown for being pointed at
        wait_for(lambda: view.screenshot() == view.screenshot())
        assert _changed(before, view.screenshot()) > 2000
    assert errors == []


@needs_browser
def test_it_fits_a_telephone_and_its_figures_are_large_and_open_by_keyboard(page):
    with browser() as chromium:
        for width in (400, 1280):
            shown = open_page(chromium, page.as_uri(), [], width, 800)
            assert shown.evaluate("document.documentElement.scrollWidth") <= width
            for image in shown.locator("button.sheet img").all():
                assert image.bounding_box()["width"] > 0.75 * width
        button = shown.locator("button.sheet").nth(1)
        button.focus()
        shown.keyboard.press("Enter")
        large = shown.locator("dialog img")
        wait_for(lambda: large.is_visible() and large.evaluate("image => image.naturalWidth") > 1000)
        assert large.get_attribute("src") == button.locator("img").get_attribute("src")
        shown.keyboard.press("Escape")
        wait_for(lambda: not large.is_visible())


def test_a_large_film_is_embedded_in_a_smaller_size(tmp_path):
    """Two seconds of noise, which no encoder can press without loss: the worst film that there is."""
    film, noise = tmp_path / "video.mp4", np.random.default_rng(0)
    _film(film, 15, 30, lambda i: noise.integers(0, 256, (720, 1280, 3), np.uint8))
    assert film.stat().st_size > 5 * LARGEST_VIDEO
    found = embedded(film, 2.0, 1.0)
    assert (found["width"], found["height"]) == (960, 540)
    assert len(found["data"]) < 1.5 * 4 / 3 * LARGEST_VIDEO


def test_the_still_of_a_film_is_that_of_its_moment_and_of_the_last_frame_after_the_end(tmp_path):
    film = tmp_path / "video.mp4"
    _film(film, 10, 20)
    for moment, frame in ((0.0, 0), (0.7, 7), (1.9, 19), (7.0, 19)):
        picture = np.asarray(Image.open(io.BytesIO(still(film, moment))).convert("L"))
        assert picture.mean() == pytest.approx(8 * frame, abs=4), moment


def _changed(one, two):
    """Return how many pixels differ between two PNGs."""
    one, two = (np.asarray(Image.open(io.BytesIO(each)).convert("RGB")).astype(int) for each in (one, two))
    return int((np.abs(one - two).sum(2) > 60).sum())


def test_a_failed_run_and_a_missing_film_are_said_so(tmp_path):
    arm = replace(Arm(), gravity=(0.0, 0.0, 9.81))
    report = RunReport(simulate(arm, along(arm, "circle", 1.0)))
    assert np.isfinite(report.summary["tip_error"]["max_m"])
    given = {"path": "circle", "duration": 1.0, "command": "contarm run", "video": "none: no GL library"}
    check = {"name": "slack", "value": 1.0, "limit": 0.0, "unit": "%", "passed": False}
    check |= {"reason": "a slack muscle steers nothing", "group": "explained"}
    checks = [check, report.summary["checks"][-1]]
    report.write_page(
        tmp_path, report.summary | given | {"verdict": "fail", "explained": False, "converged": None, "checks": checks}
    )
    text = (tmp_path / "report.html").read_text()
    assert "No film: no GL library. <code>contarm render RUN</code>" in text
    assert '<section class="card bad"><h2>The simulation is NOT explained.' in text
    assert "Slack 1\u00a0% (limit 0): a slack muscle steers nothing" in text
    assert "<h1>Constant curvature does not hold: " in text


def test_an_interrupted_run_says_so_first_and_how_much_there_is(tmp_path):
    arm = Arm()
    report = RunReport(simulate(arm, along(arm, "circle", 1.0)), poses=2)
    given = {"path": "circle", "duration": 4.0, "command": "contarm run", "video": "interrupted", "rate": 100.0}
    report.write_page(tmp_path, report.summary | given | {"interrupted": True, "verdict": "interrupted"})
    text = (tmp_path / "report.html").read_text()
    assert text.index("This run was interrupted.") < text.index("The simulation is")
    assert "It was stopped at 1.00\u00a0s of 4\u00a0s" in text
    assert "No film: interrupted. <code>contarm render RUN</code>, where RUN is this folder, draws one." in text


def test_a_film_that_cannot_be_embedded_is_said_to_be_there_and_why(tmp_path):
    arm = Arm()
    report = RunReport(simulate(arm, along(arm, "circle", 0.3)), poses=2)
    (tmp_path / "video.mp4").write_bytes(b"no film at all")
    given = {"path": "circle", "duration": 0.3, "command": "contarm run", "video": "video.mp4"}
    report.write_page(tmp_path, report.summary | given)
    text = (tmp_path / "report.html").read_text()
    assert "The film, video.mp4, is beside this page, which cannot show it: the video encoder failed: " in text
    assert "No film" not in text


def test_figures_are_embedded_in_the_kind_that_is_there(tmp_path):
    arm = Arm()
    report = RunReport(simulate(arm, along(arm, "circle", 0.3)), poses=2)
    report.draw(tmp_path, Prints(kinds=("svg", "pdf")))
    given = {"path": "circle", "duration": 0.3, "command": "contarm run", "video": "not asked for"}
    report.write_page(tmp_path, report.summary | given)
    text = (tmp_path / "report.html").read_text()
    assert text.count("data:image/svg+xml;base64,") == 3
    assert "data:image/png" not in text
    assert "--figures" not in text


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (("pdf",), "path.pdf, budget.pdf and muscles.pdf in this folder are figures that no page can show"),
        ((), "The figures path, budget and muscles were not drawn; <code>--figures png</code> draws them."),
    ],
)
def test_a_page_without_figures_says_why(tmp_path, kinds, said):
    arm = Arm()
    report = RunReport(simulate(arm, along(arm, "circle", 0.3)), poses=2)
    report.draw(tmp_path, Prints(kinds=kinds))
    given = {"path": "circle", "duration": 0.3, "command": "contarm run", "video": "not asked for"}
    report.write_page(tmp_path, report.summary | given)
    text = (tmp_path / "report.html").read_text()
    assert text.count(said) == 1
    assert "<figure>" not in text


def test_what_a_run_was_asked_is_told_with_its_own_rate_and_duration():
    arm = Arm()
    run = simulate(arm, along(arm, "circle", 0.3))
    report = RunReport(run, poses=2)
    told = report.told("circle", command="contarm run")
    assert told.items() >= report.summary.items()
    assert {key: told[key] for key in told.keys() - report.summary.keys()} == {
        "path": "circle",
        "duration": pytest.approx(0.3),
        "path_parameters": {},
        "project": "refuse",
        "timestep": run.timestep,
        "rate": 100.0,
        "command": "contarm run",
        "video": "not asked for",
    }
    asked = report.told("x", command="", duration=2.0, direction=(0, 0, 1), video="video.mp4")
    assert (asked["duration"], asked["direction"], asked["video"]) == (2.0, (0, 0, 1), "video.mp4")
