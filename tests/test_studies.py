"""Studies return frozen values, and the command line prints these and nothing else."""

import json
import subprocess
import sys
from dataclasses import FrozenInstanceError, dataclass, field
from typing import Any

import numpy as np
import pytest

from contarm_sim import studies
from contarm_sim.errors import EquilibriumError, InputError
from contarm_sim.kinematics import arc
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.results.document import HIDDEN, INLINE, document, shown_if

SMALL = Arm(links=8)
BEND = arc.from_polar(1.0, 0.5)


@dataclass(frozen=True)
class _Inner:
    x: float
    y: np.ndarray


@dataclass(frozen=True)
class _Outer:
    inner: _Inner = field(metadata=INLINE)
    nothing: _Inner | None = field(metadata=INLINE)
    samples: np.ndarray = field(metadata=HIDDEN)
    loaded: bool
    sag: float | None = field(metadata=shown_if(lambda outer: outer.loaded))
    by_name: dict[str, _Inner]
    arm: Arm


def test_a_document_has_the_fields_in_their_order_and_is_strict_json():
    inner = _Inner(float("nan"), np.array([1.0, np.inf]))
    made = document(_Outer(inner, None, np.zeros(3), True, None, {"a": inner}, SMALL))
    assert list(made) == ["x", "y", "loaded", "sag", "by_name", "arm"]
    assert (made["x"], made["y"], made["by_name"]["a"]) == (None, [1.0, None], {"x": None, "y": [1.0, None]})
    assert made["arm"]["links"] == 8
    json.dumps(made, allow_nan=False)
    assert "sag" not in document(_Outer(inner, None, np.zeros(3), False, 1.0, {}, SMALL))
    with pytest.raises(TypeError, match="object has no plain form"):
        document({"a": object()})


LINES = {
    "hold --bend 1 0.5 --share 0.3": lambda: studies.hold(SMALL, BEND, 0.3),
    "stiffness --bend 1 0.5 --levels 2": lambda: studies.stiffness(SMALL, BEND, 2),
    "muscle --pressure 200000 650000": lambda: studies.muscle_law(SMALL, [2e5, 6.5e5]),
    "possibility": lambda: studies.possibility(SMALL),
    "validate --grid 2": lambda: studies.validate(SMALL, 2),
    "compare-controllers --duration 0.5": lambda: studies.compare_controllers(SMALL, 0.5),
    "release --duration 0.1": lambda: studies.release(SMALL, settings=studies.SwingSettings(duration=0.1)),
    "equilibrium --wrench 1 0.2 0 0 0 0 0 --xi 0.5": lambda: studies.cases_at_rest(
        [studies.LoadCase(SMALL, Load(wrenches=(Wrench(xi=1, force=(0.2, 0, 0)),)))], xi=[0.5]
    )[0],
}


def _untimed(value):
    if isinstance(value, dict):
        return {key: _untimed(each) for key, each in value.items() if key not in ("seconds", "real_time_factor")}
    return value


@pytest.mark.parametrize("line", LINES)
def test_a_command_prints_what_its_study_returns(contarm, line):
    printed = json.loads(contarm(*line.split(), "--links", 8, "--json")[1])
    found: Any = LINES[line]()
    made = _untimed(document(found))
    assert made
    assert {key: _untimed(printed[key]) for key in made} == made
    with pytest.raises(FrozenInstanceError):
        found.arm = None
    beside = set(printed) - set(document(found))
    assert beside <= {"versions", "command", "time", "energy", "places", "ideal_tip", "tip_error"}


def test_cases_that_rest_and_one_that_does_not():
    heavy = Arm(links=8, mass=1.0, gravity=(0, 0, -9.81))
    resting, falling = studies.cases_at_rest([studies.LoadCase(a, Load()) for a in (SMALL, heavy)], method="newton")
    assert isinstance(resting, studies.CaseAtRest)
    assert resting.stable
    assert not falling.stable
    wrong = studies.LoadCase(SMALL, Load(muscles=Muscles(kind="pressures", values=(1.0, 2.0, 3.0))), "file one")
    with pytest.raises(InputError, match="file one"):
        studies.cases_at_rest([wrong])


def test_an_arm_that_does_not_rest_is_not_let_go():
    with pytest.raises(EquilibriumError, match="no stable pose under this load"):
        studies.release(SMALL, Load(follower_moment=(0.0, 0.0, 0.9)))
    for wrong in ({"duration": 0.0}, {"sample_period": 0.0}, {"timestep": float("nan")}):
        with pytest.raises(InputError):
            studies.release(SMALL, settings=studies.SwingSettings(**wrong))


def test_the_package_of_studies_opens_without_the_engine_and_names_what_it_has():
    code = (
        "import sys; from contarm_sim import studies; assert not {'mujoco', 'numpy'} & set(sys.modules);"
        "assert all(callable(getattr(studies, name)) for name in studies.__all__); studies.possibilty"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "AttributeError: module 'contarm_sim.studies' has no attribute 'possibilty'" in done.stderr


def test_long_work_says_how_far_it_is_where_stderr_is_no_terminal(monkeypatch, capsys):
    from contarm_sim.cli import terminal

    assert list(terminal.track(range(3), "levels")) == [0, 1, 2]
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(terminal, "EVERY", 0.0)
    assert list(terminal.track(range(3), "levels")) == [0, 1, 2]
    with terminal.progress("simulating") as show:
        show(5, 9)
    said = ["levels: 0 of 3", "levels: 1 of 3", "levels: 2 of 3", "simulating: 5 of 9"]
    assert capsys.readouterr().err.splitlines() == said
