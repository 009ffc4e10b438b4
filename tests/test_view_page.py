"""The live page as people see it: light, dark, on a phone; arms that change while it is open."""

import json
import os
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from browser import box, browser, faint, needs_browser
from waiting import PATIENCE, wait_for

from contarm_sim.view.live.keeping import Keeper
from contarm_sim.view.live.page import page as page_of
from contarm_sim.view.live.presets import ARMS
from contarm_sim.view.live.session import Session

LOOKS = {"light": (1280, 800), "dark": (1280, 800), "phone": (390, 844)}


@pytest.fixture(scope="module")
def url():
    """Serve a page; yields its address."""
    process = subprocess.Popen(
        [sys.executable, "-m", "contarm_sim", "view", "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        text=True, env=dict(os.environ),
    )  # fmt: skip
    try:
        said = ""
        while not said.endswith("}\n"):
            said += process.stdout.readline()
        yield json.loads(said)["url"]
    finally:
        process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def chromium():
    with browser() as chromium:
        yield chromium


@pytest.fixture(params=LOOKS)
def page(request, url, chromium):
    """Open the page in one of its looks."""
    width, height = LOOKS[request.param]
    touch = request.param == "phone"
    scheme = "dark" if request.param == "dark" else "light"
    context = chromium.new_context(
        viewport={"width": width, "height": height}, color_scheme=scheme, has_touch=touch, is_mobile=touch
    )
    page = context.new_page()
    page.set_default_timeout(1000 * PATIENCE)
    page.goto(url)
    wait_for(lambda: "t = " in page.inner_text("body"))
    yield page
    context.close()


def choose(page, name):
    """Take another arm; returns when its controls have taken the place of those before."""
    box(page, "arm").evaluate("element => { element.dataset.before = 'yes'; }")
    box(page, "arm").click()
    page.get_by_role("option", name=name, exact=True).click()
    wait_for(lambda: box(page, "arm").get_attribute("data-before") is None)


@needs_browser
def test_all_words_can_be_read_and_nothing_is_cut_off(page):
    assert page.title().startswith("contarm")
    wait_for(lambda: not page.get_by_text("Software WebGL").count())
    assert faint(page) == []
    words = page.inner_text("body")
    assert "Drag the ring" in words
    assert "as given" not in words
    width = page.viewport_size["width"]
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    wide = page.evaluate(
        "[...document.querySelectorAll('button, label, legend, p')].filter(e => e.scrollWidth > e.clientWidth + 1 && "
        "e.clientWidth > 0 && getComputedStyle(e).display !== 'inline').map(e => e.innerText)"
    )
    assert not [text for text in wide if text.strip()]


@needs_browser
def test_the_scene_is_beside_the_controls_never_under_them(page):
    canvas = page.locator("canvas[data-engine]")

    def apart():
        box, button = canvas.bounding_box(), page.get_by_role("button", name="Record").bounding_box()
        return button["y"] >= box["y"] + box["height"] or button["x"] >= box["x"] + box["width"]

    wait_for(apart)
    box = canvas.bounding_box()
    assert min(box["width"], box["height"]) > 300
    if page.viewport_size["width"] < 500:
        assert page.get_by_role("button", name="Record").bounding_box()["width"] > 300
    else:
        for name in ("muscle 1", "muscle 2", "muscle 3"):
            assert page.get_by_text(name, exact=True).count() == 2  # legends of tensions and pressures


@needs_browser
@pytest.mark.parametrize("page", ["light"], indirect=True)
@pytest.mark.slow  # half a minute where a browser draws in software
def test_another_arm_takes_the_place_of_the_one_before(page):
    for name in ("two sections", "three, nine tendons", "paper's, hanging, 100 g", "paper's arm"):
        choose(page, name)
        sections = len(ARMS[name]().sections)
        wait_for(lambda sections=sections: ("Section 2" in page.inner_text("body")) == (sections > 1))
        box(page, "bend angle [deg]", last=True).fill("25")
        wait_for(lambda: "25.0°" in page.inner_text("body"))
        loaded = "100 g" in name
        wait_for(lambda loaded=loaded: box(page, "payload [g]").input_value() == ("100" if loaded else "0"))


@needs_browser
@pytest.mark.parametrize("page", ["light"], indirect=True)
def test_a_picture_is_drawn_once_however_often_one_asks(page):
    frames = page.evaluate(
        "() => new Promise(done => { const seen = []; const again = now => { seen.push(now); "
        "seen.length < 20 ? requestAnimationFrame(again) : done(seen); }; requestAnimationFrame(again); })"
    )
    assert min(after - before for before, after in pairwise(frames)) > 10  # ms, of two pictures of one chain


def test_the_trace_is_smooth_however_seldom_the_page_is_drawn(arm):
    session = Session(arm)
    with page_of(session, None, Keeper(print)) as shown:
        session.aim(np.array([0.9, 0.5]))
        for _ in range(100):
            session.tick()
            shown.scene.note()
        times = [reading.time for reading in shown.scene.trace]
        assert len(times) > 30
        assert np.diff(times).max() < 0.035
        session.reset()
        shown.scene.note()
        assert [reading.time for reading in shown.scene.trace] == [0.0]
