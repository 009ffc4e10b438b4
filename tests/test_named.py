"""Parameters of arms by name, and what may be said of one in many cases."""

import numpy as np
import pytest
from scipy import stats

from contarm_sim import Arm, presets
from contarm_sim.errors import InputError
from contarm_sim.model.named import named_parameters, with_parameters
from contarm_sim.sweeps.distributions import varied_from

SHARES = (np.arange(4000) + 0.5) / 4000


@pytest.mark.parametrize("arm", [Arm(), presets.two(), presets.tendon()], ids=["paper", "two", "tendon"])
def test_every_parameter_can_be_set_to_what_it_is(arm):
    for name, one in named_parameters(arm).items():
        if len(one.owners) < 2 and not (name.endswith("muscle.count") and arm.routings[0].at is not None):
            assert with_parameters(arm, {name: one.value(arm)}) == arm, name


def test_parameters_of_sections_and_components_of_vectors():
    arm = with_parameters(presets.two(), {"section_2.mass": 0.2, "bending_stiffness": 0.3, "gravity.x": 1.0})
    assert [part.mass for part in arm.sections] == [presets.two().sections[0].mass, 0.2]
    assert [part.bending_stiffness for part in arm.sections] == [0.3, 0.3]
    assert arm.gravity == (1.0, *presets.two().gravity[1:])


def test_a_mistyped_name_and_a_bad_value_are_refused_by_name():
    with pytest.raises(InputError, match=r"'bending_stifness' is unknown.*did you mean 'bending_stiffness'"):
        with_parameters(Arm(), {"bending_stifness": 1.0})
    with pytest.raises(InputError, match=r"^section 2: mass"):
        with_parameters(presets.two(), {"section_2.mass": -1.0})


@pytest.mark.parametrize(
    ("table", "law"),
    [
        ({"distribution": "normal", "mean": "300 g", "std": "5 %"}, stats.norm(0.3, 0.015)),
        ({"distribution": "normal", "mean": 0.3, "std": 0.1, "least": 0.25}, stats.truncnorm(-0.5, np.inf, 0.3, 0.1)),
        (
            {"distribution": "normal", "mean": 0, "std": 1, "least": 5.5, "most": 9},
            stats.truncnorm(5.5, 9),
        ),
        ({"distribution": "uniform", "low": "100 g", "high": 0.4}, stats.uniform(0.1, 0.3)),
        (
            {"distribution": "lognormal", "mean": 0.3, "std": 0.06},
            stats.lognorm(np.sqrt(np.log(1.04)), scale=0.3 / np.sqrt(1.04)),
        ),
        ({"from": 0.1, "to": 10, "scale": "log"}, stats.loguniform(0.1, 10)),
    ],
    ids=["normal", "truncated", "far above the mean", "uniform", "lognormal", "log range"],
)
def test_quantiles_are_those_of_the_law(table, law):
    np.testing.assert_allclose(varied_from(table, "mass", "kg").at(SHARES), law.ppf(SHARES), rtol=1e-9)


def test_grids():
    assert varied_from({"from": 0.01, "to": 1, "count": 3, "scale": "log"}, "x", "-").grid("x") == pytest.approx(
        [0.01, 0.1, 1]
    )
    assert varied_from([0, "50 g"], "payload", "kg").grid("payload") == [0, 0.05]


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"from": 2, "to": 1}, r"mass is an empty range"),
        ({"from": 0, "to": 1, "scale": "log"}, r"mass\.from is 0"),
        ({"distribution": "normal", "std": 1}, r"mass\.mean is missing; allowed: a number \[kg\]"),
        ({"distribution": "normal", "mean": 1, "std": 0}, r"mass\.std is 0"),
        ({"distribution": "gamma", "mean": 1}, r"mass\.distribution is gamma; allowed: normal, lognormal, uniform"),
        ({"distribution": "normal", "mean": 0, "std": 1, "least": 50, "most": 51}, r"mass is cut off from 50 to 51"),
        ({"distribution": "normal", "men": 1}, r"mass\.men is unknown.*did you mean 'mean'"),
        ([], "one value or more"),
        (3, "a list of values"),
    ],
)
def test_bad_tables_are_refused(table, said):
    with pytest.raises(InputError, match=said):
        varied_from(table, "mass", "kg")


def test_a_grid_of_a_distribution_is_refused():
    with pytest.raises(InputError, match="mass is a distribution"):
        varied_from({"distribution": "normal", "mean": 1, "std": 2}, "mass", "kg").grid("mass")
