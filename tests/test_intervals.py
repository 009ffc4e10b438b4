"""Intervals of fits: against closed forms, against fits repeated, and what is said of what data do not determine."""

import numpy as np
import pytest
from scipy.stats import t

from contarm_sim.errors import InputError
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.judgement.bootstrap import groups, one_step, widening
from contarm_sim.identify.judgement.intervals import noise_of, rows, spread
from contarm_sim.identify.judgement.judge import judge

NOISE = 5e-4
UNITS = {"bending_stiffness": "N m^2", "muscle.stiffness": "N", "mass": "kg", "frame.x": "m", "marker.offset.x": "m"}


def judged(jacobian, names, *, at=0.0, start=0.0, low=-np.inf, high=np.inf, seed=0, free=None, blocks=None, **more):
    """Return what is said of residuals of pure noise at an optimum."""
    count, size = jacobian.shape
    residual = np.random.default_rng(seed).normal(0, NOISE, count)
    residual -= jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    free = [Free(name=name) for name in names] if free is None else free
    bounds = np.broadcast_to(low, size).astype(float), np.broadcast_to(high, size).astype(float)
    blocks = np.arange(count) // 60 if blocks is None else blocks
    vector, start = (np.broadcast_to(x, size).astype(float).copy() for x in (at, start))
    units, logs = [UNITS[name] for name in names], [UNITS[name] != "m" for name in names]
    more.setdefault("noise", NOISE)
    return judge(free, units, logs, start, bounds, vector, residual, jacobian, blocks, **more)


def columns(count, size, seed=1):
    return np.random.default_rng(seed).normal(0, 0.05, (count, size))


def test_plain_intervals_are_those_of_linear_least_squares():
    jacobian = columns(60, 2)
    found = judged(jacobian, ["bending_stiffness", "frame.x"], at=[np.log(0.01), 0.002], blocks=np.zeros(60))
    residual = np.random.default_rng(0).normal(0, NOISE, 60)
    rss = np.linalg.lstsq(jacobian, residual, rcond=None)[1][0]
    sd = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)) * rss / 58)
    half = sd * t.ppf(0.975, 58)
    stiffness, x = found.parameters
    assert found.how == "plain"
    np.testing.assert_allclose([x.low, x.high], [0.002 - half[1], 0.002 + half[1]], rtol=1e-9)
    np.testing.assert_allclose([stiffness.low, stiffness.high], 0.01 * np.exp([-half[0], half[0]]), rtol=1e-9)
    np.testing.assert_allclose([stiffness.sd, x.sd], [0.01 * sd[0], sd[1]], rtol=1e-9)
    assert {stiffness.status, x.status} == {"determined"}


def test_clustered_covariance_is_the_jackknife_of_blocks():
    random = np.random.default_rng(2)
    blocks = np.repeat(np.arange(8), [20, 30, 40, 25, 35, 15, 30, 20])
    jacobian = random.normal(size=(len(blocks), 3)) + random.normal(size=(8, 3))[blocks]
    measured = random.normal(size=len(blocks)) + random.normal(size=8)[blocks]
    best = np.linalg.lstsq(jacobian, measured, rcond=None)[0]
    told = rows(jacobian @ best - measured, jacobian)
    without = [np.linalg.lstsq(jacobian[blocks != k], measured[blocks != k], rcond=None)[0] - best for k in range(8)]
    np.testing.assert_allclose(spread(told, blocks, np.zeros(3)).covariance, np.transpose(without) @ without, rtol=1e-9)


def test_a_mean_of_equal_blocks_has_one_degree_of_freedom_less_than_blocks():
    told = rows(np.random.default_rng(0).normal(size=120), np.ones((120, 1)))
    np.testing.assert_allclose(spread(told, np.arange(120) // 12, np.zeros(1)).degrees, 9)


def test_clustered_intervals_hold_where_blocks_have_an_offset_and_plain_ones_fail():
    random, blocks, inside = np.random.default_rng(3), np.repeat(np.arange(10), 24), []
    for _ in range(200):
        jacobian = random.normal(size=(240, 2)) + random.normal(size=(10, 2))[blocks]
        measured = random.normal(size=240) + random.normal(size=10)[blocks]
        best = np.linalg.lstsq(jacobian, measured, rcond=None)[0]
        told = rows(jacobian @ best - measured, jacobian)
        sd = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)) * (told.psi**2).sum() / 238)
        half = spread(told, blocks, np.zeros(2)).half_width()
        inside.append([np.abs(best) <= half, np.abs(best) <= 1.97 * sd])
    clustered, alone = np.mean(inside, axis=(0, 2))
    assert clustered >= 0.93
    assert alone < 0.7


@pytest.mark.parametrize("loss", ["soft_l1", "huber"])
def test_robust_intervals_are_as_wide_as_repeated_fits_scatter(loss):
    random, size = np.random.default_rng(4), []
    for _ in range(120):
        jacobian, measured = random.normal(size=(70, 2)), random.normal(size=70)
        measured[random.random(70) < 0.1] += 30
        best = np.zeros(2)
        for _ in range(40):
            told = rows(jacobian @ best - measured, jacobian, loss, 1.345)
            best -= np.linalg.solve(jacobian.T @ (told.weight[:, None] * jacobian), jacobian.T @ told.psi)
        size.append(best / spread(told, np.zeros(70, dtype=int), np.zeros(2)).sd)
    assert 0.75 < np.mean(np.square(size)) < 1.3


def test_a_ratio_is_told_and_neither_value():
    jacobian = columns(600, 4)
    jacobian[:, 1] = -jacobian[:, 0] * (1 + 1e-6)
    names = ["bending_stiffness", "muscle.stiffness", "mass", "frame.x"]
    found = judged(jacobian, names, at=[0.3, 0.1, 0.0, 0.0], boot=50)
    first, second, mass, x = found.parameters
    assert [one.status for one in (first, second, mass, x)] == ["only with others"] * 2 + ["determined"] * 2
    for one in (first, second):
        assert np.isnan([one.value, one.sd, one.low, one.high, one.boot_low, one.boot_high]).all()
    assert found.hold == (1,)
    np.testing.assert_allclose(found.vector, [0.2, 0, 0, 0], atol=1e-4)  # moved along, the ratio as it was
    [one] = found.undetermined
    assert (
        one.said
        == "bending_stiffness and muscle.stiffness may grow together by any factor: only their ratio is determined"
    )
    np.testing.assert_allclose(np.abs(one.weights), np.sqrt(0.5), atol=1e-3)
    middle, low, high = (
        float(x.strip("()")) for x in first.said.replace("to", "").split("=")[1].replace("(95 %:", "").split()
    )
    sd = NOISE / np.linalg.norm(jacobian[:, 0])
    assert middle == pytest.approx(np.exp(0.2), rel=1e-3)
    assert low < middle < high < middle * np.exp(5 * sd)
    assert first.said.startswith("bending_stiffness / muscle.stiffness = ")
    again = judged(jacobian, names, at=found.vector, held=found.hold)
    assert [one.status for one in again.parameters] == [one.status for one in found.parameters]
    np.testing.assert_allclose(again.vector, found.vector)
    assert np.isnan(found.correlation[:2]).all()
    assert found.correlation[2, 2] == pytest.approx(1)


def test_what_is_said_of_sums_powers_and_what_is_not_seen():
    jacobian = columns(600, 5)
    jacobian[:, 1] = 2 * jacobian[:, 0]  # B may fall by a factor where A grows by its square
    jacobian[:, 3] = jacobian[:, 4]
    jacobian[:, 2] = 0
    found = judged(jacobian, ["bending_stiffness", "muscle.stiffness", "mass", "frame.x", "marker.offset.x"])
    said = " ".join(one.said for one in found.undetermined)
    assert "mass changes nothing that was measured" in said
    assert "frame.x falls by as much: only their sum is determined" in said
    assert "muscle.stiffness * bending_stiffness^0.5" in said
    assert [one.status for one in found.parameters] == ["only with others"] * 2 + ["not seen"] + [
        "only with others"
    ] * 2


def test_three_sections_and_their_tendons_have_ratios():
    jacobian = columns(600, 4)
    jacobian[:, 3] = -jacobian[:, :3].sum(axis=1)
    found = judged(jacobian, ["bending_stiffness", "mass", "muscle.stiffness", "muscle.stiffness"])
    [one] = found.undetermined
    assert one.said.endswith("may grow together by any factor: only their ratios are determined")
    assert len(one.names) == 4
    assert np.isinf(one.sd)


def test_rounding_of_derivatives_is_not_taken_for_information():
    """Many samples make a small error of a derivative as large as the noise."""
    jacobian = columns(600, 2) * 2000
    jacobian[:, 1] = -jacobian[:, 0] + np.random.default_rng(5).normal(0, 1e-3, 600)
    names = ["bending_stiffness", "muscle.stiffness"]
    assert judged(jacobian, names, rounding=1e-8).hold == ()
    assert judged(jacobian, names, rounding=1e-4).hold == (1,)


def test_a_prior_determines_what_data_do_not():
    jacobian = columns(600, 2)
    jacobian[:, 1] = -jacobian[:, 0]
    free = [Free(name="bending_stiffness"), Free(name="muscle.stiffness", mean=2e3, sd=100)]
    found = judged(jacobian, ["bending_stiffness", "muscle.stiffness"], free=free, at=np.log([0.01, 2e3]))
    stiffness, tendon = found.parameters
    assert found.hold == ()
    assert tendon.sd == pytest.approx(100, rel=0.01)
    assert tendon.said == "its prior alone: the recording adds nothing"
    assert stiffness.sd == pytest.approx(0.05 * 0.01, rel=0.02)


def test_a_small_part_of_what_is_unknown_widens_an_interval():
    jacobian = columns(600, 2)
    jacobian[:, 1] = 0.05 * jacobian[:, 0]
    found = judged(jacobian, ["bending_stiffness", "muscle.stiffness"])
    assert [one.status for one in found.parameters] == ["determined", "only with others"]
    assert found.parameters[0].sd == pytest.approx(0.05, rel=0.02)  # of a factor e of the other


def test_at_a_bound_the_interval_goes_inwards_alone():
    found = judged(columns(600, 2), ["frame.x", "marker.offset.x"], low=[-0.01, -0.01], at=[-0.01, 0.0])
    x, other = found.parameters
    assert (x.status, other.status) == ("at bound", "determined")
    assert x.low == -0.01 < x.high
    assert x.said == "at its lower bound"


def test_the_bootstrap_agrees_with_the_jacobian_and_with_fits_anew():
    random, blocks = np.random.default_rng(6), np.repeat(np.arange(40), 20)
    jacobian = random.normal(size=(800, 3))
    measured = random.normal(size=800) + random.normal(size=40)[blocks]
    best = np.linalg.lstsq(jacobian, measured, rcond=None)[0]

    def fit(often):
        root = np.sqrt(often)
        return np.linalg.lstsq(root[:, None] * jacobian, root * measured, rcond=None)[0]

    told = rows(jacobian @ best - measured, jacobian)
    steps = one_step(told, blocks, np.zeros(3), 1000)
    half = np.percentile(steps, 97.5, axis=0) - np.percentile(steps, 2.5, axis=0)
    np.testing.assert_allclose(half, 2 * spread(told, blocks, np.zeros(3)).half_width(), rtol=0.15)
    drawn = np.random.default_rng(0).multinomial(40, np.full(40, 1 / 40), size=20).astype(float)
    again = np.array([fit(often[groups(blocks)]) - best for often in drawn]) * widening(40)
    np.testing.assert_allclose(one_step(told, blocks, np.zeros(3), 20), again, atol=1e-9)


def test_an_unknown_loss_is_refused():
    with pytest.raises(InputError, match="soft_l1"):
        rows(np.zeros(3), np.zeros((3, 1)), "soft")


def test_a_parameter_that_blocks_leave_open_is_not_returned():
    """Samples alone would determine it; what blocks have in common does not let them."""
    blocks = np.repeat(np.arange(8), 75)
    jacobian = np.stack([np.full(600, 1e-4), columns(600, 1)[:, 0]], axis=1)
    residual = np.random.default_rng(7).normal(0, NOISE, 600) + np.random.default_rng(8).normal(0, 5e-4, 8)[blocks]
    inf, names = np.full(2, np.inf), [Free(name="bending_stiffness"), Free(name="frame.x")]
    own = (names, ["N m^2", "m"], [True, False], np.zeros(2), (-inf, inf), np.zeros(2), residual, jacobian)
    for held in ((), (0,)):
        open_one, x = judge(*own, blocks, noise=NOISE, held=held).parameters
        assert (open_one.status, x.status) == ("not seen", "determined")
        assert "too little of what was measured: it may be off by a factor" in open_one.said
    assert judge(*own, np.arange(600), noise=NOISE).parameters[0].status == "determined"


def test_small_parts_of_two_combinations_are_told_by_the_larger():
    alike = np.array([[1, 1, 0, 0, 0.09], [0, 0, 1, 1, 0.08]])  # directions that change nothing
    jacobian = columns(600, 3) @ np.linalg.svd(alike)[2][2:]
    names = ["bending_stiffness", "muscle.stiffness", "mass", "bending_stiffness", "mass"]
    last = judged(jacobian, names).parameters[-1]
    assert last.status == "only with others"
    assert "muscle.stiffness" in last.said


def test_what_a_bound_pulls_is_no_part_of_the_spread():
    """Of blocks of one design the same is pulled from each."""
    random, blocks = np.random.default_rng(9), np.repeat(np.arange(8), 20)
    jacobian, residual = np.tile(random.normal(size=(20, 3)), (8, 1)), random.normal(size=160)
    residual -= jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    free, bound = (rows(residual + pull * jacobian[:, 0], jacobian) for pull in (0.0, 3.0))
    expected = spread(free, blocks, np.zeros(3)).covariance
    np.testing.assert_allclose(spread(bound, blocks, np.zeros(3)).covariance, expected, rtol=1e-9)


def test_a_prior_is_as_wide_in_the_intervals_as_in_the_search_and_may_contradict_the_data():
    """Of a positive parameter it is about the mean, sd / mean wide in the logarithm, wherever the fit ends."""
    jacobian, free = columns(600, 1) * 1e-4, [Free(name="bending_stiffness", mean=0.02, sd=0.004)]
    found = judged(jacobian, ["bending_stiffness"], free=free, at=np.log(0.01), start=np.log(0.03)).parameters[0]
    assert found.sd == pytest.approx(0.2 * found.value, rel=1e-2)
    assert "contradict each other: it is 3.5 standard deviations off" in found.said


def test_a_wide_interval_is_called_weak():
    jacobian = columns(600, 2) * [0.0007, 1]
    found = judged(jacobian, ["bending_stiffness", "frame.x"]).parameters
    assert [one.status for one in found] == ["weakly determined", "determined"]
    assert found[0].determined
    assert found[0].high / found[0].low > 9


def test_outliers_leave_the_noise_as_it_is():
    residual = np.random.default_rng(10).normal(0, NOISE, 20000)
    assert noise_of(residual, 0, "huber") == pytest.approx(NOISE, rel=0.02)
    residual[::10] += 0.02
    assert noise_of(residual, 0, "huber") == pytest.approx(NOISE, rel=0.03)
