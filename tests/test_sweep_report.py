"""Reports of sweeps: the validity chart beside validate and trust, Sobol's indices beside a closed form, pages."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from text_boxes import faults

from contarm_sim import sweeps
from contarm_sim.model.arm import Arm
from contarm_sim.model.mckibben import McKibben
from contarm_sim.paths.reference import Reference
from contarm_sim.studies.attempts import attempt
from contarm_sim.studies.scenarios import HANGING, UPRIGHT, dome_grid, scenarios, weight_over_stiffness
from contarm_sim.studies.trusted_bends import LoadedArm, trusted
from contarm_sim.sweeps.effects import SURE, effect
from contarm_sim.sweeps.sensitivity import sobol
from contarm_sim.sweeps.validity import chart_of
from contarm_sim.view.colours import TRUSTED
from contarm_sim.view.report.sweeps.columns import Column
from contarm_sim.view.report.sweeps.failures import draw_failures
from contarm_sim.view.report.sweeps.heat_maps import draw_heat_map, slices
from contarm_sim.view.report.sweeps.indices import draw_indices
from contarm_sim.view.report.sweeps.marginals import draw_marginals
from contarm_sim.view.report.sweeps.matched import matched
from contarm_sim.view.report.sweeps.ticks import round_numbers
from contarm_sim.view.report.sweeps.validity import draw_validity
from contarm_sim.view.style import drawn

pytest.importorskip("pyarrow")

SMALL = {
    "run": "rest",
    "design": "grid",
    "ask": ["tip_error_max_percent", "bend_within_0.1_percent", "bend_within_1_percent", "bend_within_5_percent"],
    "fixed": {"grid": 2, "max_bend": "120 deg", "muscle.max_pressure": 1e9},
    "vary": {
        "gravity.z": [9.81, -9.81], "links": [4, 6], "payload": [0, 0.3], "bending_stiffness": [3.0, 0.1, 0.01],
    },
}  # fmt: skip
"""A sweep like `validity`, of coarse arms; the softest of them buckle."""


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return sweeps.sweep(SMALL, tmp_path_factory.mktemp("sweep") / "small")


@pytest.fixture(scope="module")
def chart(table):
    return chart_of(table)


def test_the_chart_has_the_numbers_of_validate_to_the_digit(chart):
    """At the paper's bending stiffness, with the muscles that it has."""
    arm, weight = Arm(links=6), int(np.abs(chart.weight - chart.example).argmin())
    assert chart.weight[weight] == pytest.approx(weight_over_stiffness(replace(arm, gravity=HANGING)))
    assert chart.payload == pytest.approx([0, 1])
    for scenario in scenarios(arm):
        if scenario.name in ("gravity", "upright"):
            stance = chart.stances[scenario.name == "upright"]
            largest = attempt(scenario, dome_grid(2, np.radians(120))).errors.tip_error.max_percent
            assert stance.error_percent[weight, 0, 1] == largest


def test_the_chart_has_the_bends_of_trust(chart):
    arm, weight = Arm(links=6, gravity=UPRIGHT), int(np.abs(chart.weight - chart.example).argmin())
    angles, planes = np.radians([0, 25, 50, 100, 120]), 2 * np.pi * np.arange(6) / 6
    found = trusted(LoadedArm("upright", "", arm, 0.0), angles, planes)
    bends = chart.stances[1].bend_deg[weight, 0, 1]
    np.testing.assert_allclose(bends, [bend.least_deg for bend in found.bends], atol=0.06)
    assert 0 < bends[0] < bends[1] < bends[2] < 120


def test_the_chart_holds_for_arms_of_other_sizes(chart):
    """Only m g L^2/EI, payload over mass, and links count: the claim that the chart makes."""
    from contarm_sim.motion.rest import poses_at_rest

    weight = int(np.abs(chart.weight - chart.example).argmin())
    length, mass, radius = 0.9, 1.7, 0.045
    stiffness = mass * 9.81 * length**2 / chart.weight[weight]
    arm = Arm(length=length, mass=mass, muscle_radius=radius, bending_stiffness=stiffness, links=4, payload=mass,
              gravity=HANGING, laws=(McKibben(max_pressure=1e9),))  # fmt: skip
    found = poses_at_rest(arm, Reference.from_bends(dome_grid(2, np.radians(120)), arm))
    error = 100 * found.tip_error.max() / length
    assert chart.stances[0].error_percent[weight, 1, 0] == pytest.approx(error, rel=1e-5)


def test_soft_arms_buckle_and_sags_grow_with_weight_and_payload(chart):
    hanging, upright = (stance.error_percent for stance in chart.stances)
    assert np.isfinite(hanging).all()
    assert np.isinf(upright[-1]).all()
    assert (np.diff(hanging, axis=0) > 0).all()
    assert (np.diff(hanging, axis=1) > 0).all()
    within = chart.weight_within(5.0)
    assert chart.weight[0] < within < chart.weight[1]
    assert chart.weight_within(1e-9) is None


def test_other_sweeps_have_no_chart(tmp_path):
    for change in ({"grid": 2, "controller": "paper"}, {"bend.angle": 1.0}):
        vary = {"payload": [0, 0.1], "links": [4, 6], "bending_stiffness": [0.1, 1.0], "gravity.z": [9.81]}
        spec = SMALL | {"fixed": change, "vary": vary, "ask": SMALL["ask"][:1]}
        assert chart_of(sweeps.sweep(spec, tmp_path / f"{len(change)}")) is None


def test_indices_are_those_of_a_closed_form_and_their_intervals_hold_it(monkeypatch):
    """Ishigami's function; its indices are known. What failed is left out, and the same table has the same numbers."""
    monkeypatch.setattr("contarm_sim.sweeps.sensitivity.RESAMPLED", 200)
    rng, names, n = np.random.default_rng(1), ("one", "two", "three"), 512
    a, b = rng.uniform(-np.pi, np.pi, (2, n, 3))
    f = lambda x: np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])  # noqa: E731
    mixed = []
    for k in range(3):
        each = a.copy()
        each[:, k] = b[:, k]
        mixed.append(f(each))
    values = f(a)
    found, again = (sobol(names, values, f(b), np.array(mixed)) for _ in range(2))
    exact = np.array([0.3139, 0.4424, 0.0]), np.array([0.5576, 0.4424, 0.2437])
    for index, interval, truth in zip((found.first, found.total), (found.first_interval, found.total_interval), exact,
                                      strict=True):  # fmt: skip
        np.testing.assert_allclose(index, truth, atol=0.12)
        assert (interval[0] <= index).all()
        assert (index <= interval[1]).all()
        assert (np.abs(index - truth) <= 1.2 * np.ptp(interval, axis=0)).all()
    assert (found.total_interval == again.total_interval).all()
    values[:10] = np.nan
    fewer = sobol(names, values, f(b), np.array(mixed))
    assert (fewer.points, fewer.failed, fewer.surplus) == (256, 10, 246)
    values[:60] = np.nan
    with pytest.raises(ValueError, match="60 of 512 with a failed case; allowed: at most 10 %"):
        sobol(names, values, f(b), np.array(mixed))
    values[:10] = 0.0
    with pytest.raises(ValueError, match="at least 8"):
        sobol(names, values[:7], f(b)[:7], np.array(mixed)[:, :7])


def test_indices_of_a_sum_are_shares_of_its_variance(monkeypatch):
    """On Saltelli's design of Sobol points, as sweeps have it, within 1 %."""
    from scipy.stats import qmc

    monkeypatch.setattr("contarm_sim.sweeps.sensitivity.RESAMPLED", 20)
    points = qmc.Sobol(6, rng=0).random(1024)
    a, b, weights = points[:, :3], points[:, 3:], np.array([3.0, 2.0, 0.5])
    mixed = a @ weights + weights[:, None] * (b - a).T
    found = sobol(("one", "two", "three"), a @ weights, b @ weights, mixed)
    exact = weights**2 / (weights**2).sum()
    np.testing.assert_allclose(found.first, exact, atol=0.01)
    np.testing.assert_allclose(found.total, exact, atol=0.01)


def test_effects_are_shares_without_what_chance_adds():
    """A parameter with many levels explains no more of pure noise than one with two, and a real one what it causes."""
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((200, 120))
    for levels in (2, 24, 120):
        found = [effect(np.arange(120) % levels, values) for values in noise]
        assert np.mean([each.share for each in found]) < 0.04
        assert np.mean([each.chance < 0.05 for each in found]) == pytest.approx(0.05, abs=0.04)
    real = [effect(np.array(["low", "high"])[np.arange(120) % 2], values + np.arange(120) % 2 * 2) for values in noise]
    assert np.mean([each.share for each in real]) == pytest.approx(0.5, abs=0.02)
    assert max(each.chance for each in real) < SURE


def test_bends_of_an_arm_without_rest_in_some_poses_are_those_of_trust(tmp_path):
    """Stiff, with muscles too weak for 120 deg: how far it may bend is known, and the chart says why no farther."""
    asked = ["tip_error_max_percent", "bend_within_0.1_percent", "bend_within_1_percent", "bend_within_5_percent"]
    vary = {"payload": [0, 0.3], "links": [6, 8], "bending_stiffness": [10.0, 0.1], "gravity.z": [9.81]}
    fixed = {"grid": 2, "max_bend": "120 deg"}
    found = sweeps.sweep(SMALL | {"ask": asked, "fixed": fixed, "vary": vary}, tmp_path / "weak")
    assert set(found.counts) == {"ok", "no equilibrium"}
    first = {name: found.column(name)[0] for name in ("status", *asked)}
    assert first["status"] == "no equilibrium"
    assert np.isnan(first["tip_error_max_percent"])
    arm = Arm(links=6, gravity=HANGING, bending_stiffness=10.0)
    trust = trusted(LoadedArm("", "", arm, 0.0), np.radians([0, 5, 60, 120]), 2 * np.pi * np.arange(6) / 6)
    bends = np.degrees([first[name] for name in asked[1:]])
    np.testing.assert_allclose(bends, [bend.least_deg for bend in trust.bends], atol=0.06)
    assert bends[-1] > 4
    chart = chart_of(found)
    assert chart is not None
    assert chart.no_rest == ("muscles are too weak",)
    assert chart.stances[0].bend_deg[0, 0, 0] == pytest.approx(bends)
    sheet = drawn(lambda sheet: draw_validity(sheet, chart), "page")
    assert faults(sheet) == []
    assert "muscles are too weak" in sheet.legends[0].get_texts()[-1].get_text()
    unknown = replace(chart.stances[0], bend_deg=np.full_like(chart.stances[0].bend_deg, np.nan))
    sheet = drawn(lambda sheet: draw_validity(sheet, replace(chart, stances=(unknown,))), "page")
    assert not any(np.isfinite(line.get_ydata()).any() for line in sheet.axes[1].lines if len(line.get_xdata()) > 2)


@pytest.mark.slow
def test_the_chart_of_the_readme_is_of_today(tmp_path):
    """What docs/images/validity.png says of the example, and docs/howto/validity.md of 1 %."""
    spec = sweeps.read("validity")
    vary = {"gravity.z": [9.81, -9.81], "links": [24, 48], "payload": [0, 0.3], "bending_stiffness": [0.1, 1.0]}
    chart = chart_of(sweeps.sweep(spec.to_dict() | {"vary": vary}, tmp_path / "some"))
    for stance, percent, degrees in zip(chart.stances, (9.1, 12), (10, 6.8), strict=True):
        example = int(np.abs(chart.weight - chart.example).argmin())
        assert f"{stance.error_percent[example, 0, 0]:.2g}" == f"{percent:g}"
        assert f"{stance.bend_deg[example, 0, 0, 1]:.2g}" == f"{degrees:g}"
    assert chart.stances[0].error_percent[0, 0, 0] == pytest.approx(1.0, rel=0.1)


def _columns(count, rng):
    """Return eight parameters of random cases: one with a long name, one of texts."""
    names = ["bending_stiffness", "section_2.muscle.max_pressure", "mass", "load.force.x", "length", "damping_time",
             "muscle.wall"]  # fmt: skip
    units = ["N m^2", "Pa", "kg", "N", "m", "s", "m"]
    scale = [1, 1e6, 1, 1, 1, 1, 1e-3]
    columns = [Column(name, unit, size * rng.uniform(0.1, 1, count), False)
               for name, unit, size in zip(names, units, scale, strict=True)]  # fmt: skip
    return [*columns, Column("controller", "-", np.resize(np.array(["servo", "pressure"], dtype=object), count))]


def test_figures_have_no_faults_with_one_parameter_and_with_eight(chart, monkeypatch):
    rng = np.random.default_rng(2)
    columns = _columns(320, rng)
    values = columns[0].values / columns[1].values * 1e6
    status = np.where(values > 3, "no equilibrium", np.where(rng.random(320) < 0.05, "diverged", "ok")).astype(object)
    value = Column("tip_error_max_percent", "%", np.where(status == "ok", values, np.nan))
    one = [Column("payload", "kg", np.linspace(0, 0.1, 320))]
    names = tuple(column.name for column in columns)
    f_a, f_b, f_ab = values[:32], values[32:64], values[64:320].reshape(8, 32)
    monkeypatch.setattr("contarm_sim.sweeps.sensitivity.RESAMPLED", 50)
    indices = sobol(names, f_a, f_b, f_ab)
    draws = {
        "page": [lambda sheet: draw_marginals(sheet, columns, value, False)],
        "column": [
            lambda sheet: draw_heat_map(sheet, columns, value, status != "ok", False),
            lambda sheet: draw_failures(sheet, columns, status),
            lambda sheet: draw_marginals(sheet, one, value, False),
            lambda sheet: draw_indices(sheet, indices, value),
            lambda sheet: draw_validity(sheet, chart),
        ],
    }
    for width, all_of in draws.items():
        for draw in all_of:
            sheet = drawn(draw, width)
            assert faults(sheet) == []
            assert sheet.get_suptitle()
            assert sheet.get_figheight() < 240 / 25.4


def _soft():
    """Return the parameters and errors of a grid like `soft`: servo is better everywhere, and fails in stiff arms."""
    stiffness, controller, path = (each.ravel() for each in np.meshgrid(
        np.geomspace(0.05, 2, 7), ["servo", "paper"], ["spans", "parallel", "bent"], indexing="ij"))  # fmt: skip
    errors = np.where(controller == "servo", 0.9, 1.0) / stiffness
    errors[(controller == "servo") & (stiffness > 0.3) | (path == "parallel") & (stiffness > 0.06)] = np.nan
    columns = [Column("bending_stiffness", "N m^2", stiffness, True), Column("controller", "-", controller),
               Column("muscle.path", "-", path)]  # fmt: skip
    return columns, Column("tip_error_max_percent", "%", errors)


def test_failures_do_not_turn_a_comparison_round():
    columns, value = _soft()
    known = np.isfinite(value.values)
    servo = columns[1].values == "servo"
    assert np.median(value.values[known & servo]) > np.median(value.values[known & ~servo])  # of what survived
    found = matched(columns[1], [columns[0], columns[2]], known)
    assert (found.settings, found.tried) == (7, 21)
    np.testing.assert_allclose(value.values[found.rows & servo], 0.9 * value.values[found.rows & ~servo])
    sheet = drawn(lambda sheet: draw_marginals(sheet, columns, value, True), "page")
    assert faults(sheet) == []
    panel = next(ax for ax in sheet.axes if ax.get_xlabel() == "controller")
    assert panel.get_title() == "7 of 21 settings"
    paper, servo = (path.vertices[0, 1] for path in panel.collections[0].get_paths())
    assert servo == pytest.approx(0.9 * paper)


def test_maps_show_the_level_that_has_most_results():
    columns, value = _soft()
    parts = slices([columns[1], columns[2]], value.values, True)
    assert [part.title for part in parts] == [
        "controller paper, muscle path spans",
        "controller servo, muscle path spans",
    ]


def test_axes_name_round_numbers_in_their_places():
    columns, value = _soft()
    sheet = drawn(lambda sheet: draw_heat_map(sheet, columns[:2], value, np.isnan(value.values), True), "page")
    assert faults(sheet) == []
    axis = sheet.axes[0].xaxis
    named = {label.get_text(): place for label, place in zip(axis.get_ticklabels(), axis.get_ticklocs(), strict=True)}
    assert list(named) == ["0.05", "0.1", "0.2", "0.5", "1", "2"]
    assert (named["0.05"], named["2"]) == (0, 6)
    assert named["1"] == pytest.approx(6 * np.log(1 / 0.05) / np.log(2 / 0.05))
    assert round_numbers(-0.495, 0.498, False, 6) == pytest.approx([-0.4, -0.2, 0, 0.2, 0.4])
    assert round_numbers(0.022, 0.9, True, 3) == pytest.approx([0.03, 0.1, 0.3])


def test_failures_show_all_parameters_in_a_column_and_reasons_differ_in_grey():
    columns = _columns(64, np.random.default_rng(3))[-5:]
    status = np.resize(np.array(["ok", "diverged", "unstable", "no equilibrium"], dtype=object), 64)
    sheet = drawn(lambda sheet: draw_failures(sheet, columns, status), "column")
    assert faults(sheet) == []
    assert len([ax for ax in sheet.axes if ax.containers]) == 5
    assert sheet.get_figheight() < 190 / 25.4
    assert len({patch.get_hatch() for patch in sheet.legends[0].get_patches()}) == 3


def test_the_chart_names_its_bounds_and_marks_the_example(chart):
    from matplotlib.colors import to_hex

    sheet = drawn(lambda sheet: draw_validity(sheet, chart), "page")
    assert faults(sheet) == []
    assert [axes.get_title() for axes in sheet.axes[:2]] == ["hanging", "standing up"]
    texts = {text.get_text() for axes in sheet.axes for text in axes.texts}
    assert {"1 %", "5 %"} <= texts
    for axes in sheet.axes:
        assert any(np.allclose(line.get_xdata(), chart.example) for line in axes.lines)
        assert to_hex(axes.get_facecolor()) == TRUSTED[-1].lower()
    sizes = [text.get_text() for text in sheet.legends[0].get_texts()]
    assert "some bend has no pose at rest:\nthe arm buckles" in sizes
    assert "tip within 1 % of length" in sizes


def test_the_command_reports_a_sweep_that_is_not_finished(contarm, tmp_path, table):
    import shutil

    shutil.copytree(table.folder, tmp_path / "part")
    parts = sorted((tmp_path / "part" / "parts").iterdir())
    for part in parts[len(parts) // 2 :]:
        part.unlink()
    code, out, err = contarm("sweep-report", "part", "--out", "r", "--json", "--figures", "svg")
    assert code == 0, err
    summary, page = json.loads(out), (tmp_path / "r" / "report.html").read_text()
    done = sweeps.load(tmp_path / "part")
    assert (summary["done"], summary["cases"]) == (len(done), 24)
    assert 0 < len(done) < 24
    errors = done.column("tip_error_max_percent")
    largest = summary["extremes"][0]
    assert largest["tip_error_max_percent"] == np.nanmax(errors) == summary["quantity"]["largest"]
    assert largest["bending_stiffness"] == done.column("bending_stiffness")[np.nanargmax(errors)]
    assert "validity" not in summary
    assert "The sweep is not finished." in page
    assert re.search(rf"{len(done)} of 24 cases are done", page)
    assert page.count("<figure>") == 2
    code, _, err = contarm("sweep-report", "part", "--quantity", "tip_error_max_percnt")
    assert code == 2
    assert "did you mean 'tip_error_max_percent'" in err
    for part in parts[: len(parts) // 2]:
        part.unlink()
    for folder in ("part", "."):
        code, out, err = contarm("sweep-report", folder)
        assert (code, out, err.count("\n")) == (2, "", 1), err


def test_the_command_says_up_to_where_constant_curvature_holds_and_why_cases_failed(contarm, tmp_path, table, chart):
    code, out, err = contarm("sweep-report", table.folder, "--out", "r", "--figures", "none")
    assert code == 0, err
    assert f"{chart.weight_within(1.0):.2g} (hanging)" in re.sub(r"\s+", " ", out)
    summary = json.loads((tmp_path / "r" / "summary.json").read_text())
    within = summary["validity"]["largest_weights"]
    assert {each["stance"] for each in within} == {"hanging", "standing up"}
    assert within[1]["own_weight_over_stiffness"] == chart.weight_within(1.0)
    page = (tmp_path / "r" / "report.html").read_text()
    lost = sum(count for status, count in table.counts.items() if status != "ok")
    assert f"{lost} cases failed." in page
    assert "buckles" in page
    assert "were not drawn" in page
