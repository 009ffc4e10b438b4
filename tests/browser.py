"""A real browser, the system's Chromium driven by Playwright: what a person with a mouse would see and do."""

import importlib.util
import shutil
from contextlib import contextmanager

import pytest
from waiting import PATIENCE

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
MISSING = "no Chromium here" if CHROMIUM is None else "playwright is not installed"

needs_browser = pytest.mark.skipif(CHROMIUM is None or importlib.util.find_spec("playwright") is None, reason=MISSING)

# WebGL in software, and shared memory in /tmp, which small containers have more of than /dev/shm.
FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"]


@contextmanager
def browser():
    """Start a headless browser without a sandbox, which root may not have; yields it."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=FLAGS, timeout=1000 * PATIENCE)
        try:
            yield chromium
        finally:
            chromium.close()


def open_page(chromium, url, errors, width=1280, height=800):
    """Open a page in a profile of its own; what goes wrong in it is added to the list `errors`."""
    page = chromium.new_context(viewport={"width": width, "height": height}).new_page()
    page.set_default_timeout(1000 * PATIENCE)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda said: errors.append(said.text) if said.type == "error" else None)
    page.goto(url)
    return page


def drag(page, start, end, steps=12):
    """Press the left button at a point [pixels], move to another, let go; not faster than a hand."""
    page.mouse.move(*start)
    page.mouse.down()
    for i in range(1, steps + 1):
        page.mouse.move(*(a + (b - a) * i / steps for a, b in zip(start, end, strict=True)))
        page.wait_for_timeout(50)
    page.mouse.up()
