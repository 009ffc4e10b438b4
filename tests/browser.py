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


FAINT = """
() => {
  const linear = (c) => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
  const light = (c) => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  const parts = (s) => {
    const found = s.match(/[\\d.]+/g).map(Number);
    return found.length < 4 ? [...found, 1] : found;
  };
  const over = (top, below) => below.map((x, i) => x * (1 - top[3]) + top[i] * top[3]);
  const behind = (element) => {
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      layers.push(parts(getComputedStyle(e).backgroundColor));
      if (layers[layers.length - 1][3] >= 1) break;
    }
    return layers.reverse().reduce((below, top) => over(top, below), [255, 255, 255]);
  };
  const faint = [];
  const judge = (element, words) => {
    const box = element.getBoundingClientRect(), style = getComputedStyle(element);
    if (!box.width || !box.height || style.visibility === "hidden") return;
    const ground = behind(element), ink = over(parts(style.color), ground);
    const [a, b] = [light(ink), light(ground)];
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (contrast < 4.5) faint.push(`${words.slice(0, 40)}: ${contrast.toFixed(2)}`);
  };
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const words = texts.currentNode.textContent.trim(), element = texts.currentNode.parentElement;
    if (words && !["SCRIPT", "STYLE", "NOSCRIPT"].includes(element.tagName)) judge(element, words);
  }
  for (const box of document.querySelectorAll("input")) if (box.value) judge(box, box.value);
  return faint;
}
"""


def faint(page):
    """Return the words of a page whose contrast with what is behind them is below 4.5, with that contrast."""
    return page.evaluate(FAINT)


def box(page, label, last=False):
    """Return the box beside a label in which the live page takes a value; the first of several, or the last."""
    found = page.locator(f"xpath=//label[normalize-space()='{label}']/following::input[not(@type='hidden')][1]")
    return found.last if last else found.first
