"""Parameters: what is refused, and that TOML says the same thing twice."""

import math
import re

import pytest

from contarm_sim.errors import InputError
from contarm_sim.mjcf import arm_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict, arm_to_dict, arm_to_toml, load_arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.units import quantity


@pytest.mark.parametrize(
    ("name", "value"),
    [(name, value) for name in ("length", "mass", "bending_stiffness", "muscle_radius")
     for value in (0.0, -1.0, math.nan, math.inf, "1", True)]
    + [("torsional_stiffness", 0.0), ("damping_time", -0.1), ("payload", -1), ("payload", math.inf)]
    + [("links", value) for value in (0, 1, 10**6, 24.0, True, -3)]
    + [("gravity", value) for value in ((0, 0), (0, 0, math.nan), 9.81, None)]
    + [("base_orientation", value) for value in ((0, 0, 0, 0), (1, 0, 0))]
    + [("muscle_radius", 0.2), ("muscle", None)],
)  # fmt: skip
def test_unusable_parameters_are_refused_by_name(name, value):
    with pytest.raises(InputError) as caught:
        Arm(**{name: value})
    assert caught.value.name == name
    assert caught.value.allowed


@pytest.mark.parametrize(
    "given", [{"max_contraction": 0.5}, {"mount_contraction": 0.25}, {"min_tension": 0}, {"min_tension": 1e4},
              {"braid_min_diameter": 0.02}, {"servo_stiffness": -1}],
)  # fmt: skip
def test_unusable_muscles_are_refused(given):
    with pytest.raises(InputError, match=rf"muscle\.{next(iter(given))}"):
        McKibben(**given)


def test_the_papers_muscle():
    """Design values from the paper's dimensions: braid angle, passive stretch, blocked force."""
    muscle = McKibben()
    assert math.degrees(muscle.braid_angle) == pytest.approx(39.7, abs=0.05)
    assert muscle.max_stretch == pytest.approx(0.13, abs=0.005)
    assert muscle.blocked_force == pytest.approx(177, abs=1)


def test_toml_round_trip(tmp_path):
    arm = Arm(
        length=1 / 3, links=17, gravity=(0.1, -2, 9.7), torsional_stiffness=0.07, muscle=McKibben(min_tension=2.5)
    )
    file = tmp_path / "arm.toml"
    file.write_text(arm_to_toml(arm))
    assert load_arm(file) == arm
    assert arm_from_dict(arm_to_dict(Arm())) == Arm()


@pytest.mark.parametrize(
    ("text", "said"),
    [("lenght = 1", "did you mean 'length'"), ("[muscle]\nmin_tention = 1", "did you mean 'muscle.min_tension'"),
     ("length = -1", "at least 0.001"), ("length = ", "not TOML"), ("muscle = 3", "a table"),
     ("links = 24.5", "whole number")],
)  # fmt: skip
def test_bad_toml_is_one_line_that_names_the_file(tmp_path, text, said):
    file = tmp_path / "arm.toml"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load_arm(file)
    assert said in str(caught.value)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unreadable_files(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        load_arm(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    with pytest.raises(InputError, match="not text"):
        load_arm(tmp_path / "binary.toml")


@pytest.mark.parametrize(
    "given", [{"mass": 1e-9, "links": 400}, {"section_radius": 1e-7}, {"mass": 1e-6, "section_radius": 1e-4}]
)
def test_links_that_the_engine_cannot_turn_are_refused(given):
    with pytest.raises(InputError, match="links that the engine can turn") as caught:
        Arm(**given)
    least = float(re.search(r"more than (\S+) kg", str(caught.value)).group(1))
    arm_spec(Arm(**given | {"mass": 1.01 * least})).compile()


def test_quantities_have_units():
    """Text with a unit is the same number as in SI; other kinds of unit and bare numbers out of proportion are not."""
    for text, unit, value in [("250mm", "m", 0.25), ("0.15 m", "m", 0.15), ("50g", "kg", 0.05), ("700 kPa", "Pa", 7e5),
                              ("7bar", "Pa", 7e5), ("90deg", "rad", math.pi / 2), ("1e5 N mm^2", "N m^2", 0.1),
                              ("20Nmm", "N m", 0.02), ("2N/mm", "N/m", 2000.0), ("9810 mm/s^2", "m/s^2", 9.81),
                              ("25%", "-", 0.25), ("5ms", "s", 0.005), ("-5mm", "m", -0.005)]:  # fmt: skip
        assert quantity(text, unit, "x") == value
    for text, unit in [("3V", "m"), ("5kg", "m"), ("90", "rad"), ("700", "Pa"), ("370", "m"), ("1e", "m"), ("m", "m")]:
        with pytest.raises(InputError):
            quantity(text, unit, "x")
