"""Where solutions are a continuum, the one that is chosen is an optimum: against SciPy's SLSQP from that solution."""

import numpy as np
import pytest
from scipy.optimize import minimize

from contarm_sim.kinematics import inverse, sections
from contarm_sim.kinematics.backbone import Backbone
from contarm_sim.kinematics.inverse.choices import penalty
from contarm_sim.kinematics.inverse.general import smooth
from contarm_sim.kinematics.inverse.goals import Goals
from contarm_sim.kinematics.inverse.limits import angles_of, excess


def asked(count, what, number, seed=3):
    """Return an arm of so many sections, and random goals that it reaches."""
    rng, backbone = np.random.default_rng(seed), Backbone(lengths=tuple(np.linspace(0.2, 0.12, count)))
    angle = rng.uniform(0, 0.95 * np.pi, (number, count))
    plane = rng.uniform(0, 2 * np.pi, (number, count))
    T = sections.transform(np.stack([angle * np.cos(plane), angle * np.sin(plane)], axis=-1), backbone)
    return backbone, Goals(T[:, :3, 3], None, T[:, :3, :3] if what == "pose" else None)


def least(goal, backbone, bends, choose):
    """Return the least penalty that SLSQP finds from bends, with the largest bend as one more unknown."""
    shape, limits = bends.shape, np.array(backbone.limits)
    below = limits if choose == "farthest" else np.zeros(len(backbone))

    def angles(x):
        return angles_of(x[:-1].reshape(shape))

    def off(x):
        return goal.terms(x[:-1].reshape(1, *shape), backbone)[0][0]

    def slopes(x):
        J = goal.terms(x[:-1].reshape(1, *shape), backbone)[1][0]
        return np.hstack([-J, np.zeros((len(J), 1))])

    constraints = [
        {"type": "eq", "fun": off, "jac": slopes},
        {"type": "ineq", "fun": lambda x: limits - angles(x)},
    ]
    if choose != "least-bend":
        constraints.append({"type": "ineq", "fun": lambda x: x[-1] + below - angles(x)})
    done = minimize(
        (lambda x: np.sqrt(angles(x) ** 2 + 1e-14).sum()) if choose == "least-bend" else (lambda x: x[-1]),
        np.append(bends, (angles_of(bends) - below).max()),
        constraints=constraints, method="SLSQP", options={"maxiter": 300, "ftol": 1e-12},
    )  # fmt: skip
    good = np.abs(off(done.x)).max() < 1e-7 and (angles(done.x) <= limits + 1e-7).all()
    return float(penalty(done.x[:-1].reshape(shape), backbone, choose)) if good else np.inf


def excesses(count, what, number, choose):
    """Return how much more than SLSQP's least penalty the solutions chosen have [deg]."""
    backbone, goals = asked(count, what, number)
    answer = inverse.solve(goals.position, backbone, rotation=goals.rotation, choose=choose)
    assert answer.reachable.all()
    assert excess(answer.bends, backbone).max() <= 0
    own = penalty(answer.bends, backbone, choose)
    other = [least(goals.take([i]), backbone, answer.bends[i], choose) for i in range(number)]
    return np.degrees(own - np.minimum(own, other))


@pytest.mark.parametrize("choose", ["least-bend", "least-largest", "farthest"])
@pytest.mark.parametrize(("count", "what"), [(3, "position"), (4, "pose")])
def test_slsqp_finds_hardly_less(count, what, choose):
    assert np.median(excesses(count, what, 6, choose)) < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("choose", ["least-bend", "least-largest", "farthest"])
@pytest.mark.parametrize(("count", "what"), [(3, "position"), (4, "position"), (4, "pose"), (5, "position"),
                                             (6, "position")])  # fmt: skip
def test_slsqp_finds_hardly_less_of_50_targets(count, what, choose):
    found = excesses(count, what, 50, choose)
    assert np.median(found) < 0.03
    assert np.quantile(found, 0.9) < (1e-4 if choose == "least-bend" else 0.6)


def test_sections_that_should_be_straight_are():
    """The least sum of bend angles leaves most sections straight: their bends are nothing, not a little."""
    backbone, goals = asked(5, "position", 40)
    angles = np.sort(angles_of(inverse.solve(goals.position, backbone).bends), axis=-1)
    assert np.quantile(angles[:, :3], 0.9) < 1e-7


@pytest.mark.parametrize("choose", ["nearest", "least-bend", "least-largest", "farthest"])
def test_slopes_of_what_is_made_least_are_those_of_its_value(choose):
    rng, backbone = np.random.default_rng(0), Backbone(lengths=(0.2, 0.15, 0.1), limits=(1.5, 2.0, 2.5))
    bends, near, step = rng.normal(size=(20, 3, 2)), rng.normal(size=(20, 3, 2)), 1e-6
    width = np.full(20, 0.2)
    slope = smooth.slopes(bends, backbone, choose, near, width)
    dual = bends / np.hypot(angles_of(bends), width[:, None])[..., None]  # then the curvature is exact
    if choose == "least-bend":
        bends = bends * np.minimum(1.0, 1.4 / angles_of(bends))[..., None]
        slope, dual = (smooth.slopes(bends, backbone, choose, near, width) for _ in range(2))
    curved = smooth.curvature(bends, backbone, choose, width, dual)
    for k in range(3):
        for axis in range(2):
            move = np.zeros((3, 2))
            move[k, axis] = step
            ends = [smooth.value(bends + sign * move, backbone, choose, near, width) for sign in (1, -1)]
            np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), slope[:, k, axis], atol=1e-8)
            ends = [smooth.slopes(bends + sign * move, backbone, choose, near, width) for sign in (1, -1)]
            np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), curved[:, k, axis], atol=1e-6)
