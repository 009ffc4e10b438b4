"""README: its table against fresh runs, its length, and what it leads to."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
sys.path.insert(0, str(ROOT / "scripts"))

from results import SCENARIOS, at_rest, spiral  # noqa: E402

ROWS = {
    cells[0]: (float(cells[1]), float(cells[2]), cells[3])
    for cells in re.findall(r"^\| (.+?) \| ([\d.]+) \| ([\d.]+) \| (.+?) \|$", README, re.MULTILINE)
}
"""What README's table of results says, by what was simulated."""


def _agrees(row):
    """Half of the last digit, and what another processor may round otherwise."""
    what, error, left, tensions = row
    shown = ROWS[what]
    assert error == pytest.approx(shown[0], abs=0.006)
    assert left == pytest.approx(shown[1], abs=0.0006)
    ours, theirs = (re.findall(r"-?[\d.]+", text) for text in (tensions, shown[2]))
    assert [float(x) for x in ours] == pytest.approx([float(x) for x in theirs], abs=0.11)


def test_the_spiral_is_what_the_table_says():
    _agrees(spiral())


@pytest.mark.slow
def test_poses_at_rest_are_what_the_table_says():
    rows = at_rest()
    assert len(rows) == len(SCENARIOS) == len(ROWS) - 1
    for row in rows:
        _agrees(row)


def test_the_first_command_prints_what_the_tutorial_shows_in_full():
    """Which is compared with a fresh run by test_docs."""
    shown = README.split("<!-- made by: python scripts/results.py run -->\n```text\n")[1].split("```")[0]
    whole = (ROOT / "docs" / "tutorial.md").read_text().split("$ contarm run --no-video\n```\n\n```text\n")[1]
    assert "target against simulated tip" in shown
    assert whole.startswith(shown)


def test_it_is_short_and_leads_somewhere():
    assert README.count("\n") <= 130
    targets = re.findall(r"\]\((?!https?://|#)([^)#]+)", README) + re.findall(r'src="([^"]+)"', README)
    assert len(targets) > 10
    for target in targets:
        assert (ROOT / target).is_file(), target


def test_every_command_is_in_its_table():
    from contarm_sim.cli.main import COMMANDS

    table = README.split("## Commands")[1].split("## ")[0]
    for command in COMMANDS:
        assert f"`contarm {command.name}`" in table, command.name
