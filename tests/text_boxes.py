"""What is wrong with the text of a figure: cut off, over other text, or smaller than print allows."""

from itertools import combinations

from matplotlib.text import Annotation, Text

from contarm_sim.view.style import LETTERS

TOLERANCE = 1.0
"""Boxes may share a rim of so many pixels (at 100 to the inch): letters do not fill their boxes."""


def _texts(sheet):
    """Return every text that is seen, with its words and its box in pixels."""
    renderer, hidden, found = sheet.canvas.get_renderer(), _hidden(sheet), []
    for text in sheet.findobj(Text):
        words = text.get_text().strip()
        if words and text.get_visible() and id(text) not in hidden:
            box = (Text if isinstance(text, Annotation) else type(text)).get_window_extent(text, renderer)
            if box.width > 0 and box.height > 0:
                found.append((text, words, box))
    return found


def _hidden(sheet):
    """Return the texts of axes that are off, and of ticks outside of what an axis shows."""
    out = set()
    for axes in sheet.findobj(lambda artist: hasattr(artist, "_axis_map")):  # those on an edge of others, too
        if not axes.get_visible():
            out |= {id(text) for text in axes.findobj(Text)}
        for axis in axes._axis_map.values():
            if not axes.axison or not axis.get_visible():
                out |= {id(text) for text in axis.findobj(Text)}
                continue
            shown = {id(label) for tick in axis._update_ticks() for label in (tick.label1, tick.label2)}
            every = {id(each) for tick in (*axis.majorTicks, *axis.minorTicks) for each in (tick.label1, tick.label2)}
            out |= every - shown
    return out


def faults(sheet):
    """Return a line for every text that is cut off, overlaps another, or is too small."""
    sheet.draw_without_rendering()
    texts, found = _texts(sheet), []
    width, height = sheet.get_size_inches() * sheet.dpi
    rim = TOLERANCE * sheet.dpi / 100
    for text, words, box in texts:
        if box.x0 < -rim or box.y0 < -rim or box.x1 > width + rim or box.y1 > height + rim:
            found.append(f"cut off: {words!r}")
        if text.get_fontsize() < LETTERS - 0.01:
            found.append(f"{text.get_fontsize():g} pt: {words!r}")
    for (_, one, a), (_, other, b) in combinations(texts, 2):
        if min(a.x1, b.x1) - max(a.x0, b.x0) > rim and min(a.y1, b.y1) - max(a.y0, b.y0) > rim:
            found.append(f"over each other: {one!r} and {other!r}")
    return found
