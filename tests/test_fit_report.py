"""Reports of fits: numbers of what is left over, figures without faults, the page, and fits in notebooks."""

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from browser import browser, faint, needs_browser, open_page
from made_fit import GAP, made_fit
from text_boxes import faults

from contarm_sim.errors import InputError
from contarm_sim.identify.fitted import Combination
from contarm_sim.view.colours import BLUE, ORANGE
from contarm_sim.view.report.fits import words
from contarm_sim.view.report.fits.left_over import (
    FITTED,
    HELD_OUT,
    driven,
    gaps,
    parts,
    repeatability,
    rms,
    together,
)
from contarm_sim.view.report.fits.page import figures_of, write_fit_report
from contarm_sim.view.report.fits.parameters import draw_parameters
from contarm_sim.view.report.fits.standings import standings
from contarm_sim.view.report.outliers import outliers
from contarm_sim.view.style import drawn


@pytest.fixture(scope="module")
def fit():
    return made_fit(markers=3)


def test_errors_are_those_of_plain_numbers(fit):
    (left,) = fit.left
    error = left.recording.positions - left.predicted
    held = left.held_out
    for part, rows in ((FITTED, ~held), (HELD_OUT, held)):
        sizes = np.linalg.norm(error[rows], axis=-1)
        assert together(fit, part) == pytest.approx(np.sqrt(np.nanmean(sizes**2)))
        found = rms(left, rows, 1)
        assert found.rms == pytest.approx(np.sqrt(np.nanmean(sizes[:, 1] ** 2)))
        assert found.samples == np.isfinite(sizes[:, 1]).sum()
        own = error[rows][:, 1] - np.nanmean(error[rows][:, 1], axis=0)
        assert found.centred == pytest.approx(np.sqrt(np.nanmean((own**2).sum(axis=-1))))
    assert set(parts(replace(left, held_out=np.zeros(len(held), dtype=bool)))) == {FITTED}


def test_the_same_command_repeats_to_noise_and_half_the_gap():
    """Each command comes going up and down, apart by the gap: deviations are half of it, and noise in three axes."""
    (left,) = made_fit(count=800).left
    size, count = repeatability(left)
    there = np.linalg.norm(left.recording.commands, axis=1) > 0
    assert 0.8 * there.sum() < count
    quiet = replace(left, recording=replace(left.recording, positions=left.predicted))
    assert repeatability(quiet)[0] == pytest.approx(0, abs=1e-12)
    assert 0.6 * GAP < size < 1.2 * GAP


def test_outliers_make_neither_a_verdict_nor_what_repeats_nor_the_scale():
    (left,) = made_fit(count=800).left
    noise = np.random.default_rng(1).normal(0, 0.001, left.predicted.shape)
    positions = left.predicted + noise
    clean = replace(left, recording=replace(left.recording, positions=positions))
    far = positions.copy()
    held = np.flatnonzero(left.held_out)[::20]
    at_rest = np.flatnonzero(np.abs(left.recording.commands).sum(axis=1) == 0)[:1]
    far[np.concatenate([held, at_rest])] += 0.06
    wild = replace(clean, recording=replace(clean.recording, positions=far))
    assert outliers(np.linalg.norm(wild.error, axis=-1)).sum() == len(held) + len(at_rest)
    assert repeatability(wild)[0] == pytest.approx(repeatability(clean)[0], rel=0.05)
    fit = made_fit()
    calm, swayed = replace(fit, left=(clean,)), replace(fit, left=(wild,))
    assert together(swayed, HELD_OUT) > 5 * together(calm, HELD_OUT)
    assert [one.state for one in standings(swayed)] == [one.state for one in standings(calm)]
    assert f"{len(held)} outliers" in words.headline(swayed)
    assert "outlier" not in words.headline(calm)
    for stem in ("distribution", "over_time"):
        ends = [drawn(figures_of(one)[stem]).axes[0].axis() for one in (calm, swayed)]
        assert ends[1] == pytest.approx(ends[0], rel=0.02)
    half = outliers(np.r_[np.ones(80), np.full(20, 50.0)])
    assert not half.any()  # so many are no outliers


def test_determined_parameters_that_go_together_are_named(fit):
    alike = fit.correlation.copy()
    alike[0, 1] = alike[1, 0] = -0.99
    found = standings(replace(fit, correlation=alike))[1]
    assert found.state == "note"
    assert "2 parameters are hardly told apart" in found.title
    assert "`section_1.bending_stiffness`, `section_2.bending_stiffness`: " in found.text
    assert "0.99" in found.text


def test_hysteresis_is_found_in_size_and_sign():
    (left,) = made_fit(count=800).left
    found = gaps(left)
    assert set(found) == {1, 2, 3}
    for gap in found.values():
        assert 0.6 * GAP < gap < 1.1 * GAP
    turned = 2 * left.predicted - left.recording.positions
    other = replace(left, recording=replace(left.recording, positions=turned))
    assert all(gap < -0.6 * GAP for gap in gaps(other).values())
    quiet = np.random.default_rng(0).normal(left.predicted, 0.001)
    none = gaps(replace(left, recording=replace(left.recording, positions=quiet)))
    assert max(map(abs, none.values())) < 0.1 * GAP
    assert driven(left).unit == "mm"
    np.testing.assert_allclose(driven(left).values, 1e3 * left.recording.commands)


@pytest.mark.parametrize(
    ("width", "made"),
    [("page", {"markers": 3}), ("column", {"markers": 3}), ("column", {"kind": "motion"}), ("page", {"recordings": 2})],
)
def test_figures_have_no_faults(width, made):
    found = figures_of(made_fit(**made))
    errors = [
        "paths",
        "blocks",
        "over_time",
        "distribution",
        "by_command",
        *(["history"] if "kind" not in made else []),
    ]
    if "recordings" in made:
        errors = [f"{stem}_{k}" for k in (1, 2) for stem in errors]
        found = {stem: draw for stem, draw in found.items() if stem in ("history_2", errors[0])}
        assert len(found) == 2
    else:
        assert set(found) == {"parameters", "correlation", "singular_values", "starts", *errors}
    moving = ("paths", "over_time", "blocks")
    for stem, draw in found.items():
        if "kind" in made and stem not in moving:
            continue
        sheet = drawn(draw, width)
        assert faults(sheet) == [], stem
        assert sheet.get_suptitle()
        assert sheet.get_figheight() < 240 / 25.4
        for axes in sheet.axes:
            assert axes.get_xlabel() or axes.get_ylabel() or not axes.axison or len(sheet.axes) > 1, stem


def test_intervals_are_drawn_where_they_are_and_the_lost_have_none(fit):
    sheet = drawn(lambda sheet: draw_parameters(sheet, fit))
    names = {label.get_text() for axes in sheet.axes for label in axes.get_yticklabels()}
    assert {one.name for one in fit.parameters} <= names
    said = {label.get_text() for axes in sheet.axes for child in axes.child_axes for label in child.get_yticklabels()}
    assert {"only with others", "not seen", "2.10 ± 0.39 mm"} <= said
    one = next(one for one in fit.parameters if one.name == "section_2.bending_stiffness")
    drawn_bars: list[Any] = list(sheet.axes[0].collections)
    bars = [segment[:, 0] for bar in drawn_bars for segment in bar.get_segments()]
    ends = [one.low / one.start, one.high / one.start]
    assert any(len(x) == 2 and np.allclose(sorted(x), ends) for x in bars)
    drawn_with = [type(one).__name__ for axes in sheet.axes for one in axes.containers].count("ErrorbarContainer")
    assert drawn_with == sum(one.status in words.FOUND for one in fit.parameters) == 7


def test_what_was_held_out_has_its_colour(fit):
    from matplotlib.colors import to_hex

    sheet = drawn(figures_of(fit)["blocks"])
    patches: list[Any] = list(sheet.axes[0].patches)
    bars = [(bar.get_height(), to_hex(bar.get_facecolor())) for bar in patches]
    (left,) = fit.left
    names = list(dict.fromkeys(left.recording.blocks.tolist()))
    size = 1e3 * rms(left, left.recording.blocks == names[-1]).rms
    assert any(height == pytest.approx(size) and colour == ORANGE.lower() for height, colour in bars)
    assert [colour for _, colour in bars].count(BLUE.lower()) == 6


def test_words_say_the_verdict(fit):
    assert words.headline(fit) == "The fitted arm predicts what was held out within " + (
        f"{words.millimetres(together(fit, HELD_OUT))} mm rms; 6 of 9 parameters determined."
    )
    assert [one.state for one in standings(fit)] == ["note", "good", "good"]
    assert words.negative(fit) == ""
    alone = replace(fit, cost=(1.0, 2.0, np.inf), converged=False, message="no more steps")
    assert standings(alone)[1].state == "bad"
    assert "no more steps" in words.negative(alone)
    lost = replace(fit, parameters=tuple(replace(one, status="not seen") for one in fit.parameters))
    assert standings(lost)[0].state == "bad"
    assert "none" in words.negative(lost)
    rows = {row[0]: row for row in words.rows_of(fit)}
    assert rows["frame.turn_z"][1:5] == ["deg", "0", "2.01", "1.56 to 2.45"]
    assert rows["damping_time"][3:5] == ["-", "-"]
    assert rows["muscle.stiffness"][2] == "20000"
    assert words.digits(0.0123456, 0.0004) == "0.01235"
    assert words.digits(-3e-9, 1e-3) == "0.0000"
    assert words.digits(123456.0, 2000.0) == "1.23e+05"


def test_fits_show_themselves_in_notebooks(fit):
    html = fit._repr_html_()
    assert "section_2.bending_stiffness" in html
    assert "1.71 to 2.49" in html
    assert len(html) < 30_000
    assert fit.figure("correlation", width="column").get_figwidth() == pytest.approx(85 / 25.4)
    for given, name in ((("nothing",), "name"), (("parameters", 1), "recording"), (("paths", 0, "broad"), "width")):
        with pytest.raises(InputError, match=name):
            fit.figure(*given)
    two = made_fit(recordings=2)
    assert "recording 2" in words.error_rows(two)[-1][0]
    assert two.figure("paths", recording=1).get_suptitle()
    with pytest.raises(InputError, match=r"allowed: parameters, .*paths, .*history$"):
        two.figure("path")


def test_the_report_has_it_all_and_escapes_names(fit, tmp_path, blank_figures):
    evil = replace(fit, undetermined=(Combination(("frame.x",), (1.0,), 1.0, "<b>mass</b> is not seen"),))
    report = evil.report(tmp_path / "left")
    assert {"arm.toml", "rig.toml", "report.html", "summary.json", "fit.npz"} <= {
        file.name for file in (tmp_path / "left").iterdir()
    }
    page = (tmp_path / "left" / "report.html").read_text()
    assert report.page == page
    page = page.replace("\u00a0", " ")
    assert "&lt;b&gt;mass&lt;/b&gt; is not seen" in page
    assert "<b>mass" not in page
    assert page.count("<figure>") == 10
    assert words.headline(fit) in page
    for heading in ("Errors, fitted and held out", "Parameters", "What the recording does not determine",
                    "What is left over", "How the fit ran"):  # fmt: skip
        assert f"<h2>{heading}</h2>" in page
    assert re.search(r"<th scope=\"row\">frame.x</th><td>mm</td><td>0</td><td>2.10</td><td>1.71 to 2.49</td>", page)
    assert words.headline(fit) in repr(report)
    assert "srcdoc" in report._repr_html_()
    with pytest.raises(InputError, match="does not exist yet"):
        evil.report(tmp_path / "left")


@pytest.mark.slow
@needs_browser
def test_the_page_in_a_browser_wide_on_a_phone_and_in_the_dark(fit, tmp_path):
    write_fit_report(tmp_path, fit, {"command": "contarm fit a.toml", "versions": {"contarm_sim": "1"}})
    errors = []
    with browser() as chromium:
        for width in (1280, 390):
            page = open_page(chromium, f"file://{tmp_path}/report.html", errors, width)
            for scheme in ("light", "dark"):
                page.emulate_media(color_scheme=scheme)
                assert faint(page) == []
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.evaluate("[...document.querySelectorAll('button img')].every((one) => one.naturalWidth > 100)")
    assert errors == []


def test_the_headline_counts_what_is_determined_and_what_is_weak():
    made = made_fit()
    bound = sum(one.status == "at bound" for one in made.parameters)
    known = sum(one.status == "determined" for one in made.parameters)
    assert bound
    assert f"{known} of {len(made.parameters)} parameters determined." in words.headline(made)
    weak = tuple(replace(one, status="weakly determined") if k == 0 else one for k, one in enumerate(made.parameters))
    assert "determined, 1 of them weakly" in words.headline(replace(made, parameters=weak))


def test_samples_without_a_pose_are_told():
    made = made_fit()
    predicted = made.left[0].predicted.copy()
    predicted[:3] = np.nan
    lost = replace(made, left=(replace(made.left[0], predicted=predicted),))
    assert any("3 samples of recording 1: the fitted arm has no pose there" in one for one in words.remarks(lost))
    assert "without a pose" in [row[0] for row in words.error_rows(lost)]
    assert not any("no pose" in one for one in words.remarks(made))
