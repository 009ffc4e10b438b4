"""The kinematics of several sections, against matrix exponentials, finite differences, and the single section's."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, chain, sections
from contarm_sim.kinematics.backbone import MOST_SECTIONS, Backbone
from contarm_sim.mechanics.muscles import each
from contarm_sim.mechanics.routing import arc_deltas
from contarm_sim.model.arm import Arm
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import MAX_SECTIONS, Section

ARM = {"lengths": (0.2, 0.17, 0.1)}
CONNECTED = {"connectors": (0.02, 0.0, 0.03)}


def bends(count=50, size=3):
    rng = np.random.default_rng(0)
    return 0.6 * rng.normal(size=(count, size, 2)) * rng.choice([1.5, 0.5, 1e-3, 1e-9, 0.0], size=(count, size, 1))


def _twist(turn, move):
    x, y, z = turn
    return np.array([[0, -z, y, move[0]], [z, 0, -x, move[1]], [-y, x, 0, move[2]], [0, 0, 0, 0]])


@pytest.mark.parametrize("connectors", [{}, CONNECTED])
def test_frames_of_arcs_are_products_of_exponentials(connectors):
    backbone = Backbone(**ARM, **connectors)
    for b in bends():
        expected = np.eye(4)
        for (x, y), length, straight in zip(b, backbone.lengths, backbone.connectors, strict=True):
            expected = expected @ expm(_twist((-y, x, 0), (0, 0, length))) @ expm(_twist((0, 0, 0), (0, 0, straight)))
        np.testing.assert_allclose(sections.transform(b, backbone), expected, atol=1e-14)


@pytest.mark.parametrize("links", [None, (12, 7, 9)])
@pytest.mark.parametrize("connectors", [{}, CONNECTED])
@pytest.mark.parametrize("xi", [1.0, 0.83, 0.3])
def test_the_jacobian_is_the_derivative(links, connectors, xi):
    backbone, step = Backbone(**ARM, **connectors, links=links), 1e-6
    b = bends()
    found, T = sections.jacobian(b, backbone, xi), sections.transform(b, backbone, xi)
    for column in range(6):
        off = np.zeros((3, 2))
        off.flat[column] = step
        rate = (sections.transform(b + off, backbone, xi) - sections.transform(b - off, backbone, xi)) / (2 * step)
        turn = rate[:, :3, :3] @ T[:, :3, :3].swapaxes(1, 2)
        np.testing.assert_allclose(found[:, :3, column], rate[:, :3, 3], atol=1e-9)
        spin = np.stack([turn[:, 2, 1], turn[:, 0, 2], turn[:, 1, 0]], axis=-1)
        np.testing.assert_allclose(found[:, 3:, column], spin, atol=1e-9)


def test_one_section_is_the_arc_and_the_chain():
    b = bends(size=1)
    np.testing.assert_allclose(sections.transform(b, Backbone(lengths=(0.2,))), arc.transform(b[:, 0], 0.2), atol=1e-16)
    tips = sections.position(b, Backbone(lengths=(0.2,), links=(9,)))
    np.testing.assert_allclose(tips, chain.tip(b[:, 0], 0.2, 9), atol=1e-16)


def test_frames_lie_at_the_ends_of_sections_and_places_run_through_all():
    backbone = Backbone(**ARM, **CONNECTED)
    b, ends = bends(), np.cumsum([0.2, 0.02, 0.17, 0.1, 0.03]) / 0.52
    found = sections.frames(b, backbone)
    for index, xi in ((1, ends[0]), (2, ends[2]), (3, ends[3])):
        np.testing.assert_allclose(found[:, index], sections.transform(b, backbone, xi), atol=1e-14)
    xi = np.linspace(0, 1, 2001)
    places = sections.position(b[:, None], backbone, xi)
    np.testing.assert_allclose(np.linalg.norm(np.diff(places, axis=1), axis=-1), 0.52 / 2000, rtol=1e-5)


@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"lengths": ()}, "lengths"),
        ({"lengths": (0.2, -1)}, "lengths"),
        ({"lengths": (0.1,) * 7}, "lengths"),
        ({"lengths": "short"}, "lengths"),
        ({"lengths": (0.2, 0.1), "limits": (0.0, 1.0)}, "limits"),
        ({"lengths": (0.2, 0.1), "limits": (1.0, 1.0, 1.0)}, "limits"),
        ({"lengths": (0.2,), "links": (2.5,)}, "links"),
        ({"lengths": (0.2,), "connectors": (-0.1,)}, "connectors"),
    ],
)
def test_a_backbone_that_cannot_be_is_refused_by_name(wrong, name):
    with pytest.raises(InputError, match=name):
        Backbone(**wrong)


@pytest.mark.parametrize("wrong", [np.zeros(2), np.zeros((3, 2)), np.full((2, 2), np.nan), np.full((2, 2), 3.0)])
def test_bends_that_cannot_be_are_refused(wrong):
    with pytest.raises(InputError, match="bend"):
        sections.position(wrong, Backbone(lengths=(0.2, 0.1)))


def test_frames_and_muscle_lengths_are_those_of_an_integration_along_the_backbone():
    """R' = R k^, p' = R e3, and muscles at an offset, |p' + R (k x offset)| long a metre; nothing in closed form."""
    arm = Arm(
        sections=tuple(Section(length=length) for length in (0.2, 0.17, 0.1)),
        routings=(Routing(), Routing(count=4, offset=0.7, start="base"), Routing(radius=0.012, offset=-0.4)),
    )
    backbone = Backbone(**ARM)
    points = [[(*point, 0.0) for point in line.points] for line in arm.routings]
    for b in bends(12):
        frame, lengths = np.concatenate([np.eye(3).ravel(), np.zeros(3)]), [np.zeros(len(line)) for line in points]
        for number, (x, y) in enumerate(b):
            curvature = np.array([-y, x, 0.0]) / backbone.lengths[number]
            passing = {line for line, own in enumerate(arm.routings) if own.start == "base" and line > number}
            through = sorted(passing | {number})
            offsets = np.array([point for line in through for point in points[line]])

            def along(_, state, curvature=curvature, offsets=offsets):
                R = state[:9].reshape(3, 3)
                moved = R[:, 2] + np.cross(curvature, offsets) @ R.T
                turned = (R @ np.cross(curvature, np.eye(3)).T).ravel()
                return np.concatenate([turned, R[:, 2], np.linalg.norm(moved, axis=1)])

            start = np.concatenate([frame, np.zeros(len(offsets))])
            end = solve_ivp(along, (0, backbone.lengths[number]), start, "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
            frame, first = end[:12], 12
            for line in through:
                lengths[line] += end[first : first + len(points[line])]
                first += len(points[line])
        T = sections.transform(b, backbone)
        np.testing.assert_allclose(T[:3, :3], frame[:9].reshape(3, 3), atol=1e-12)
        np.testing.assert_allclose(T[:3, 3], frame[9:], atol=1e-12)
        straight = each(arm, lambda group: group.length)
        np.testing.assert_allclose(arc_deltas(b.ravel(), arm), np.concatenate(lengths) - straight, atol=1e-12)


def test_kinematics_and_model_agree_on_how_many_sections_there_may_be():
    assert MOST_SECTIONS == MAX_SECTIONS
