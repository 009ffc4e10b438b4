"""Every figure is drawn from a computation made then, in vectors, with units."""

import os
import re
import subprocess
import sys
from xml.etree import ElementTree

import pytest

from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.view.figures import FIGURES, common, studies

UNITS = r"\[(mm|deg|kPa|N|N/m|s|-|% of length)\]"


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(studies, "GRID", 2)
    monkeypatch.setattr(studies, "DURATION", 3.0)
    monkeypatch.setattr(common, "DURATION", 3.0)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_a_vector_drawing_with_units_on_its_axes(name, tmp_path):
    meaning, draw = FIGURES[name]
    draw(tmp_path / "f.svg", Arm(links=8))
    text = (tmp_path / "f.svg").read_text()
    ElementTree.fromstring(text)
    labels = re.findall(UNITS, text)
    assert labels, name
    assert len(text) > 8_000
    assert len(meaning) > 20


def test_a_figure_follows_the_arm(tmp_path):
    """Nothing is drawn from memory: another arm gives another picture, the same arm the same one."""
    draw = FIGURES["lengths"][1]
    for file, arm in (("a", Arm(links=8)), ("b", Arm(links=8)), ("c", Arm(links=8, muscle_radius=0.02))):
        draw(tmp_path / f"{file}.svg", arm)
    a, b, c = ((tmp_path / f"{f}.svg").read_text() for f in "abc")
    assert a == b != c
    assert muscle_hex(0) not in a


def test_the_same_figure_is_the_same_bytes_in_another_process_and_at_another_time(tmp_path):
    program = (
        "import sys; from pathlib import Path; from contarm_sim.model.arm import Arm;"
        "from contarm_sim.view.figures import FIGURES;"
        "FIGURES['possibility'][1]([Path(sys.argv[1] + end) for end in ('.png', '.pdf', '.svg')], Arm(links=8))"
    )
    for file, seed, threads in (("a", "1", "1"), ("b", "2", "4")):
        changed = {"PYTHONHASHSEED": seed, "OPENBLAS_NUM_THREADS": threads, "TZ": "UTC" + seed}
        subprocess.run([sys.executable, "-c", program, tmp_path / file], check=True, env=os.environ | changed)
    for end in (".png", ".pdf", ".svg"):
        assert (tmp_path / f"a{end}").read_bytes() == (tmp_path / f"b{end}").read_bytes(), end
