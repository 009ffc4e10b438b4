"""report.html: one file that needs nothing else, in a real browser."""

import io
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from browser import browser, drag, needs_browser, open_page
from PIL import Image
from references import along
from waiting import wait_for

from contarm_sim.model.arm import Arm
from contarm_sim.motion.simulate import simulate
from contarm_sim.view.rendering.encode import encoder, encoding
from contarm_sim.view.report.page import LARGEST_VIDEO, embedded
from contarm_sim.view.report.run import RunReport


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    arm = Arm()
    report = RunReport(simulate(arm, along(arm, "spiral", 2.0, turns=0.5)))
    report.draw(folder)
    (folder / "video.mp4").write_bytes(b"not really a film")
    given = {"path": "</script><b>", "duration": 2.0, "command": "contarm run --out '<&>'", "video": "video.mp4"}
    report.write_page(folder, report.summary | given)
    return folder / "report.html"


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
    for tag, attributes in outline.tags:
        for name in ("src", "href"):
            assert attributes.get(name, "data:").startswith("data:"), (tag, attributes)
        if tag == "img":
            assert len(attributes["alt"]) > 20
    names = [tag for tag, _ in outline.tags]
    assert names.count("img") == 3
    assert names.count("video") == 1
    assert "<b>: spiral" not in text
    assert "contarm run --out &#39;&lt;&amp;&gt;&#39;" in text
    assert "Constant curvature:</strong> " in text
    assert "Simulation: explained" in text
    assert text.index("target against simulated tip") < text.index("analytic against simulated tip")


@needs_browser
def test_a_browser_shows_it_without_an_error_and_the_view_answers_to_the_mouse(page):
    errors = []
    with browser() as chromium:
        shown = open_page(chromium, page.as_uri(), errors, 700, 500)
        view = shown.locator("#view")
        view.locator("canvas").first.wait_for()
        view.scroll_into_view_if_needed()
        shown.wait_for_function("Array.from(document.images).every(image => image.naturalWidth > 100)")
        wait_for(lambda: view.screenshot() == view.screenshot())  # it is drawn and moves no more
        before, box = view.screenshot(), view.bounding_box()
        centre = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        drag(shown, centre, (centre[0] + 120, centre[1]))
        shown.mouse.move(1, 1)  # off the view, where nothing is shown for being pointed at
        wait_for(lambda: view.screenshot() == view.screenshot())
        assert _changed(before, view.screenshot()) > 2000
    assert errors == []


def test_a_large_film_is_embedded_in_a_smaller_size(tmp_path):
    """Two seconds of noise, which no encoder can press without loss: the worst film that there is."""
    film, noise = tmp_path / "video.mp4", np.random.default_rng(0)
    with encoding(encoder(), film, (720, 1280), 15) as add:
        for _ in range(30):
            add(noise.integers(0, 256, (720, 1280, 3), np.uint8))
    assert film.stat().st_size > 5 * LARGEST_VIDEO
    found = embedded(film, 2.0)
    assert (found["width"], found["height"]) == (960, 540)
    assert len(found["data"]) < 1.5 * 4 / 3 * LARGEST_VIDEO


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
    assert "No film: none: no GL library." in text
    assert "<strong>Failed.</strong>" in text
    assert "Simulation: NOT explained: slack 1 % (limit 0): a slack muscle steers nothing" in text
    assert "Constant curvature:</strong> does not hold" in text
