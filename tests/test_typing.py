"""What a type checker tells the users of the package: mistakes in their own scripts, and nothing else."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import contarm_sim

pytest.importorskip("mypy")

ROOT = Path(__file__).parents[1]

RIGHT = """
import numpy as np
import contarm_sim
from contarm_sim import Arm, Load, Wrench, equilibrium, load_arm, paths, simulate
from contarm_sim.kinematics import arc

arm: Arm = Arm(length=0.5, links=12, gravity=(0.0, 0.0, 9.81))
tip: float = float(equilibrium(arm, Load(wrenches=(Wrench(xi=1.0, force=(0.1, 0.0, 0.0)),))).tip[0])
length: float = load_arm("arm.toml").length
position: np.ndarray = arc.position(np.zeros(2), arm.length)
version: str = contarm_sim.__version__
try:
    run = contarm_sim.simulate
except contarm_sim.ContarmError as error:
    print(error)
"""

WRONG = """
import contarm_sim
from contarm_sim import Arm, Armm, Load, equilibrium, load_arm, paths, simulate

Arm(lenght=0.5)                           # call-arg
Arm(length="0.5")                         # arg-type
Arm().lenght                              # attr-defined
contarm_sim.simulat                       # attr-defined
load_arm(3)                               # arg-type
name: str = load_arm("arm.toml").length   # assignment
load_arm("arm.toml") + 1                  # operator
equilibrium(Load())                       # arg-type
equilibrium(Arm(), Load()).tipp           # attr-defined
equilibrium(Arm(), method="newtn")        # arg-type
simulate(Arm(), no_such_word=1)           # call-arg
Load(wrenches=3)                          # arg-type
"""


def _found(script, tmp_path):
    """Return (line, error code) of every error that mypy finds in a script."""
    file = tmp_path / "script.py"
    file.write_text(script)
    words = [sys.executable, "-m", "mypy", "--config-file", "pyproject.toml", "--enable-error-code", "arg-type"]
    for code in ("assignment", "operator"):
        words += ["--enable-error-code", code]
    done = subprocess.run([*words, str(file)], cwd=ROOT, capture_output=True, text=True)
    assert not done.stderr
    lines = [line for line in done.stdout.splitlines() if ": error: " in line]
    places = [re.match(r"(.*?):(\d+): error: .*\[([a-z-]+)\]$", line) for line in lines]
    assert all(place and Path(place[1]).name == file.name for place in places), done.stdout
    return [(int(place[2]), place[3]) for place in places if place]


def test_a_type_checker_finds_a_users_mistakes_and_no_others(tmp_path):
    expected = [(number, line.split("# ")[1]) for number, line in enumerate(WRONG.splitlines(), 1) if "# " in line]
    expected.append((3, "attr-defined"))  # there is no Armm to import
    assert sorted(set(_found(WRONG, tmp_path))) == sorted(expected)


def test_a_type_checker_finds_nothing_in_a_script_that_is_right(tmp_path):
    assert _found(RIGHT, tmp_path) == []


def test_every_public_name_is_there_and_known_to_type_checkers(tmp_path):
    names = vars(contarm_sim)["__all__"]
    assert len(names) == len(set(names))
    assert set(names) == {*vars(contarm_sim)["_HOMES"], *vars(contarm_sim)["_MODULES"]}
    assert all(getattr(contarm_sim, name) is not None for name in names)
    assert set(names) <= set(dir(contarm_sim))
    assert (ROOT / "contarm_sim" / "py.typed").exists()
    script = "".join(f"from contarm_sim import {name} as {name}_\n" for name in [*names, "__version__"])
    assert _found(script, tmp_path) == []


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'Armm'"):
        _ = contarm_sim.Armm  # type: ignore[attr-defined]
