"""Figures for print: sizes, kinds of files, headings, and a check of their text that can fail."""

import re
import struct

import pytest
from text_boxes import faults

from contarm_sim.errors import InputError
from contarm_sim.view.prints import Prints
from contarm_sim.view.style import LETTERS, drawn, save


def plot(sheet):
    ax = sheet.subplots()
    ax.plot([0, 1], [0, 1], label="a line")
    ax.set_xlabel("time [s]")
    ax.legend()
    sheet.heading("What a figure shows, in words that are so long that they take more than one line of a column")


def _size(png):
    return struct.unpack(">II", png[16:24])


def test_a_figure_is_as_wide_as_a_column_or_a_page_in_every_kind_of_file(tmp_path):
    files = save(tmp_path, "f", plot, Prints(("png", "pdf", "svg"), ("page", "column")))
    assert [file.name for file in files] == Prints(("png", "pdf", "svg"), ("page", "column")).all_names("f")
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(file.name for file in files)
    for stem, width in (("f", 170), ("f-column", 85)):
        assert _size((tmp_path / f"{stem}.png").read_bytes())[0] == pytest.approx(width / 25.4 * 200, abs=1)
        box = re.search(rb"/MediaBox \[([\d. ]+)\]", (tmp_path / f"{stem}.pdf").read_bytes())
        assert float(box.group(1).split()[2]) == pytest.approx(width / 25.4 * 72, abs=0.1)
        assert f'width="{width / 25.4 * 72:.3f}'[:10] in (tmp_path / f"{stem}.svg").read_text()


def test_without_titles_there_is_no_heading_and_without_kinds_no_figure(tmp_path):
    assert drawn(plot, titles=False).get_suptitle() == ""
    assert len(drawn(plot, "column").get_suptitle().split("\n")) > 1
    assert save(tmp_path, "f", plot, Prints(())) == []


@pytest.mark.parametrize("given", [{"kinds": ("gif",)}, {"kinds": "png"}, {"widths": ("a4",)}, {"kinds": ("png",) * 2}])
def test_unknown_kinds_and_widths_are_refused(given):
    with pytest.raises(InputError, match="each once"):
        Prints(**given)


@pytest.mark.parametrize("width", ["column", "page"])
def test_the_check_of_text_finds_what_is_wrong(width):
    assert faults(drawn(plot, width)) == []

    def bad(sheet):
        plot(sheet)
        ax = sheet.axes[0]
        ax.text(0.5, 0.5, "one")
        ax.text(0.5, 0.5, "other", fontsize=LETTERS - 2)
        sheet.text(0.99, 0.5, "far out")

    found = faults(drawn(bad, width))
    assert set(found) == {"cut off: 'far out'", "6 pt: 'other'", "over each other: 'one' and 'other'"}
