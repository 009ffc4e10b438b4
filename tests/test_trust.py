"""How far to trust constant curvature: bends against closed forms, laws of scale and symmetry, and the arm itself."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from text_boxes import faults

from contarm_sim import studies
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm
from contarm_sim.model.presets import PRESETS
from contarm_sim.paths.reference import Reference
from contarm_sim.studies.scenarios import UPRIGHT
from contarm_sim.studies.trusted_bends import first_beyond, posed
from contarm_sim.view.report.trust import draw_trust, paragraph, remedies
from contarm_sim.view.style import drawn

ARM = Arm(links=6)


@pytest.fixture(scope="module")
def found():
    return studies.trust(ARM, wanted=1.0, planes=3)


def _load(found, name):
    return next(each for each in found.loads if each.trusted.under.load == name)


def _least(found, load, within):
    return next(b.least_deg for b in _load(found, load).trusted.bends if b.within_percent == within)


def _chain_error(angle, links):
    """Return how far the tips of arc and chain are apart [% of length], by the bend [rad]."""
    half = angle / links / 2
    return 100 * (1 - half / np.tan(half)) * np.sinc(angle / 2 / np.pi)


def test_without_gravity_the_bends_are_those_of_the_closed_form_of_the_chain(found):
    for within in (0.1, 1.0):
        expected = brentq(lambda angle: _chain_error(angle, ARM.links) - within, 0.1, 2.96)  # noqa: B023
        assert _least(found, "free", within) == pytest.approx(np.degrees(expected), rel=0.03)


def test_the_error_is_at_the_bound_where_the_bend_ends(found):
    """Told by one equilibrium in each plane, beside the study's own search."""
    from contarm_sim.motion.rest import poses_at_rest

    for each in found.loads:
        for bend in each.trusted.bends:
            inner = (bend.bend_deg > 0) & (bend.bend_deg < found.max_bend_deg - 1e-6)
            for degrees, plane in zip(bend.bend_deg[inner], found.plane_deg[inner], strict=True):
                arm = each.trusted.under.arm
                pose = posed(arm, np.radians([degrees]), np.radians([plane]))
                error = 100 * poses_at_rest(arm, Reference.from_bends(pose, arm)).tip_error[0] / arm.length
                assert error == pytest.approx(bend.within_percent, rel=0.03)


def test_more_weight_and_less_error_leave_less(found):
    assert 0 < _least(found, "payload", 1.0) < _least(found, "gravity", 1.0) < _least(found, "free", 1.0)
    assert _least(found, "gravity", 0.1) < _least(found, "gravity", 1.0) < _least(found, "gravity", 5.0)


def test_only_weight_over_stiffness_counts(found):
    """Twice the mass at twice the stiffness bends as far."""
    double = replace(ARM, mass=2 * ARM.mass, bending_stiffness=2 * ARM.bending_stiffness)
    other = studies.trust(double, wanted=1.0, planes=1)
    assert _least(other, "gravity", 1.0) == pytest.approx(_least(found, "gravity", 1.0), abs=0.05)
    assert _load(other, "gravity").trusted.under.weight_over_stiffness == pytest.approx(
        _load(found, "gravity").trusted.under.weight_over_stiffness
    )


def test_planes_on_either_side_of_sideways_gravity_are_alike():
    """The arm and its muscles are their own mirror image in the plane of muscle 1 and gravity."""
    pulled = replace(ARM, gravity=(0.5, 0.0, 0.5), bending_stiffness=0.2)
    bends = _load(studies.trust(pulled, planes=6), "gravity").trusted.bends[1].bend_deg
    np.testing.assert_allclose(bends[1:3], bends[:3:-1], atol=1.0)
    assert np.ptp(bends) > 5


def test_what_it_takes_does_it(found):
    for load in ("gravity", "payload", "upright"):
        takes, arm = _load(found, load).takes, _load(found, load).trusted.under.arm
        assert takes.error_percent > 1
        factor = takes.bending_stiffness.factor
        assert takes.bending_stiffness.value == pytest.approx(factor * arm.bending_stiffness)
        strong = replace(arm.laws[0], max_pressure=100 * arm.laws[0].max_pressure)
        for share, holds in ((1.02, True), (0.95, False)):
            stiff = replace(arm, bending_stiffness=share * factor * arm.bending_stiffness, muscle=strong)
            assert bool(_worst(stiff) <= 1) is holds
    mass = _load(found, "gravity").takes.mass
    light = _load(found, "gravity").trusted.under.arm
    assert _worst(replace(light, mass=0.98 * mass.value)) <= 1 < _worst(replace(light, mass=1.05 * mass.value))
    assert mass.muscles_do
    heavy = _load(found, "payload").takes.mass
    assert heavy.factor is None
    assert "payload alone" in heavy.why_not


def _worst(arm):
    from contarm_sim.motion.rest import poses_at_rest

    bends = np.concatenate([posed(arm, np.linspace(0.1, 1.0, 6), np.full(6, plane)) for plane in (0.0, 2.1, 4.2)])
    return 100 * poses_at_rest(arm, Reference.from_bends(bends, arm)).tip_error.max() / arm.length


def test_where_links_alone_are_too_coarse_nothing_helps_but_links():
    coarse = studies.trust(Arm(links=2), wanted=2.0, planes=1)
    takes = _load(coarse, "gravity").takes
    assert takes.bending_stiffness.factor is takes.mass.factor is None
    assert "more links" in takes.bending_stiffness.why_not
    assert any("more than stiffness or mass" in line for line in remedies(coarse))


def test_a_pose_without_rest_ends_what_is_trusted():
    weak = Arm(links=6, gravity=UPRIGHT, payload=1.0)  # falls over
    found = studies.trust(weak, planes=1)
    errors = _load(found, "payload").trusted.error_percent
    assert np.isinf(errors).any()
    assert _least(found, "payload", 5.0) == 0
    assert "off even when straight" in paragraph(found)
    drawn(lambda sheet: draw_trust(sheet, found))


def test_the_first_beyond_is_found_whatever_follows():
    angles = np.linspace(0, 3, 7)
    error = lambda angle: 2.0 * np.sin(np.pi * angle)  # noqa: E731
    assert first_beyond(error, angles, error(angles), 1.0) == pytest.approx(1 / 6, abs=0.002)
    assert first_beyond(error, angles, error(angles), 3.0) == 3.0
    assert first_beyond(error, angles, error(angles) + 1.5, 1.0) == 0.0


def test_the_figure_has_no_faults_at_either_width(found):
    two = studies.trust(replace(PRESETS["two"](), gravity=(3.0, 0.0, 9.0)), planes=2)
    for answer in (found, two):
        for width in ("column", "page"):
            assert faults(drawn(lambda sheet, answer=answer: draw_trust(sheet, answer), width)) == []


def test_the_command_prints_one_paragraph_writes_one_figure_and_refuses_nonsense(contarm, tmp_path):
    code, out, err = contarm("trust", "--links", 6, "--planes", 2, "--out", "t", "--figures", "svg")
    assert code == 0, err
    assert "hanging with 0.1 kg" in out
    assert sorted(path.name for path in (tmp_path / "t").iterdir()) == ["summary.json", "trust.svg"]
    summary = json.loads((tmp_path / "t" / "summary.json").read_text())
    words = re.sub(r"\s+", " ", out)
    assert summary["in_words"] in words
    least = summary["loads"][1]["bends"][1]["least_deg"]
    assert f"hanging: {least:.1f} deg" in words
    assert all(line in words for line in summary["what_it_would_take"])
    assert (
        contarm("trust", "--links", 6, "--planes", 1, "--within", "2%", "--out", "u")[1].count("within 2 % of length")
        == 1
    )
    for flags, named in (("--within 0", "within"), ("--bend 200deg", "bend"), ("--planes 0", "planes")):
        code, out, err = contarm("trust", *flags.split())
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert named in err


def test_bad_arguments_are_refused():
    for given in ({"wanted": 4.0}, {"within": -1.0}, {"planes": 0}, {"wanted": float("nan")}):
        with pytest.raises(InputError):
            studies.trust(ARM, **given)


def test_what_muscles_cannot_hold_is_not_taken_for_an_error_of_the_model():
    stiff = Arm(links=6, bending_stiffness=0.5)
    found = studies.trust(stiff, planes=1)
    free = _load(found, "free").trusted
    (bend,) = (each for each in free.bends if each.within_percent == 5.0)
    assert 90 < bend.least_deg < 170
    assert "limit of 177 N" in bend.no_rest
    assert np.nanmax(free.error_percent[np.isfinite(free.error_percent)]) < 5.0
    assert free.bends[0].no_rest is None
    assert free.muscles_to_deg < bend.least_deg
    said = studies.trust(stiff, wanted=2.8, within=5.0, planes=1)
    assert "has no pose at rest" in paragraph(said)
    muscles = _load(said, "free").takes.muscles
    assert muscles.peak_tension_n > 177 > stiff.laws[0].blocked_force - 1
    assert "stronger muscles, for" in remedies(said)[0]
