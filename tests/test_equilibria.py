"""Static poses in bulk: the bits of one at a time, whatever stands beside a case, and however cases are shared out."""

import re
from dataclasses import fields, replace

import numpy as np
import pytest

from contarm_sim import Arm, InputError, Load, Muscles, Wrench, equilibria, equilibrium, presets
from contarm_sim.errors import EquilibriumError
from contarm_sim.statics import bunches, together
from contarm_sim.statics.equilibrium import Equilibrium

MIXED = replace(
    presets.two(), gravity=(2.0, 0.0, 3.0), routings=[replace(presets.two().routings[0], path="spans"),
                                                      presets.two().routings[1]],
)  # fmt: skip
ARMS = {
    "parallel": Arm(gravity=(0.0, 3.0, 9.0), links=12),
    "spans": Arm(path="spans", gravity=(0.0, 0.0, 9.81), payload=0.05, links=12),
    "twist": Arm(torsional_stiffness=0.05, gravity=(0.0, 9.81, 0.0), links=12),
    "two": presets.two(),
    "mixed": MIXED,
    "tendon": presets.tendon(),
}
KINDS = ("off", "bend", "tensions", "pressures")


def _load(rng, arm, kind, strength=1.0):
    count, sections = sum(group.routing.count for group in arm.groups), len(arm.sections)
    values = {
        "off": (),
        "bend": np.column_stack([rng.uniform(0, 1.6, sections), rng.uniform(-3, 3, sections)]).ravel(),
        "tensions": rng.uniform(0, 30, count),
        "pressures": rng.uniform(90e3, 500e3, count),
    }[kind]
    wrenches = [
        Wrench(
            xi=float(rng.choice([0.0, 0.5, 1.0, rng.random()])),
            force=tuple(strength * rng.normal(size=3) * 0.5),
            moment=tuple(rng.normal(size=3) * 0.03 * (rng.random() < 0.3)),
        )
        for _ in range(rng.integers(0, 3))
    ]
    return Load(
        wrenches=tuple(wrenches),
        muscles=Muscles(kind=kind, values=tuple(values)),
        follower_moment=tuple(rng.normal(size=3) * 0.02 * (rng.random() < 0.2)),
        actuation_moment=tuple(rng.normal(size=2) * 0.05 * (rng.random() < 0.3)),
    )


def _same(found, index):
    """Compare all of a case with the same solved alone; return whether it has an equilibrium."""
    arm, load = found.arms[index], found.loads[index]
    if index in found.failed:
        with pytest.raises(type(found.failed[index]), match=re.escape(str(found.failed[index]))):
            equilibrium(arm, load)
        assert np.isnan(found.tip[index]).all()
        assert not found.stable[index]
        return False
    one = equilibrium(arm, load)
    for name in ("frames", "muscle_lengths", "muscle_tensions", "qpos", "residual", "iterations", "stable", "tip",
                 "smallest_eigenvalue", "growth", "tip_compliance"):  # fmt: skip
        alone, own = np.asarray(getattr(one, name)), getattr(found, name)[index]
        within = own[tuple(slice(size) for size in alone.shape)]
        np.testing.assert_array_equal(within, alone, err_msg=f"{name} of case {index}")
        assert np.count_nonzero(~np.isnan(own)) == np.count_nonzero(~np.isnan(alone))
    assert found.held[index] == bool(one.held)
    return True


@pytest.fixture
def alone(monkeypatch):
    """The cases that were not solved together."""
    left = []

    def counted(*given):
        left.append(given)
        return equilibrium(*given)

    monkeypatch.setattr(bunches, "equilibrium", counted)
    return left


@pytest.mark.parametrize("name", ARMS)
def test_one_arm_under_many_loads_is_the_same_as_load_by_load(name, alone):
    rng, arm = np.random.default_rng(3), ARMS[name]
    kinds = KINDS if name != "tendon" else KINDS[:3]
    loads = [_load(rng, arm, kind) for kind in kinds for _ in range(5)]
    found = equilibria(arm, loads, details=True)
    for index in range(len(loads)):
        assert _same(found, index)
    assert len(alone) <= 2  # else this compares the single solver with itself


def test_arms_that_differ_are_solved_together_and_those_of_another_make_beside_them(alone):
    rng = np.random.default_rng(5)
    arms = [
        Arm(
            links=int(rng.choice([8, 12])), bending_stiffness=rng.uniform(0.02, 0.2),
            gravity=tuple(rng.normal(size=3) * 5), damping_time=rng.uniform(0.02, 0.1),
            torsional_stiffness=rng.uniform(0.03, 0.1) if twist else None,
            mass=rng.uniform(0.2, 0.4), payload=rng.uniform(0.01, 0.1),
        )
        for twist in (False, True) for _ in range(12)
    ]  # fmt: skip
    loads = [_load(rng, arm, KINDS[index % 4]) for index, arm in enumerate(arms)]
    found = equilibria(arms, loads, details=True)
    for index in range(len(arms)):
        assert _same(found, index)
    assert len(alone) <= 1


def test_cases_without_equilibrium_are_reported_in_their_place_and_leave_the_others_alone():
    rng, arm = np.random.default_rng(0), ARMS["parallel"]
    loads = [_load(rng, arm, "off") for _ in range(8)]
    loads[1] = Load(wrenches=(Wrench(xi=1.0, force=(0.0, 0.0, -3e4)),))  # folds
    loads[3] = Load(muscles=Muscles(kind="tensions", values=(1.0, 2.0)))
    loads[4] = Load(muscles=Muscles(kind="pressures", values=(1e6, 1e5, 1e5)))
    loads[6] = Load(muscles=Muscles(kind="deltas", values=(0.1, 0.1, 0.1)))
    found = equilibria(arm, loads, details=True)
    assert list(found.failed) == [1, 3, 4, 6]
    assert found.found.tolist() == [i not in (1, 3, 4, 6) for i in range(8)]
    assert isinstance(found.failed[1], EquilibriumError)
    assert isinstance(found.failed[3], InputError)
    for index in range(8):
        _same(found, index)
    with pytest.raises(EquilibriumError):
        found.case(1)


def test_an_arm_that_buckles_falls_as_it_does_alone(alone):
    """Upright past its buckling load: Newton stays up, where the arm would not."""
    arm = Arm(bending_stiffness=0.02, gravity=(0.0, 0.0, -9.81), links=12)
    found = equilibria(arm, [Load(), Load(wrenches=(Wrench(xi=1.0, force=(0.1, 0.0, 0.0)),))], details=True)
    assert _same(found, 0)
    assert _same(found, 1)
    assert found.tip[0, 0] > 0.05
    assert alone


@pytest.mark.parametrize("threads", [2, 3])
def test_threads_and_chunks_leave_the_bits_as_they_are(threads, monkeypatch):
    rng = np.random.default_rng(2)
    loads = [_load(rng, ARMS["parallel"], KINDS[index % 4]) for index in range(24)]
    one = equilibria(ARMS["parallel"], loads)
    monkeypatch.setattr("contarm_sim.statics.cases.BUNCH", 4)
    other = equilibria(ARMS["parallel"], loads, threads=threads)
    for name in ("frames", "muscle_tensions", "qpos", "residual", "iterations", "held"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("details", [False, True])
def test_a_case_tells_all_that_one_alone_does(details):
    arms = [ARMS["two"], ARMS["spans"]]  # of other numbers of links and muscles
    load = Load(wrenches=(Wrench(xi=1.0, force=(0.2, 0.1, 0.0)),))
    found, one = equilibria(arms, load, details=details), equilibrium(ARMS["spans"], load)
    case = found.case(-1)
    assert isinstance(case, Equilibrium)
    assert len(list(found)) == 2
    assert (found.smallest_eigenvalue is None) != details
    for each in fields(one):
        if each.name != "seconds":
            np.testing.assert_array_equal(getattr(case, each.name), getattr(one, each.name))
    np.testing.assert_array_equal(found.pressures_needed[1, :3], one.pressures_needed(ARMS["spans"]))


def test_a_guess_is_where_each_case_starts():
    load = Load(wrenches=(Wrench(xi=1.0, force=(0.2, 0.1, 0.0)),))
    found = equilibria(Arm(), [load, Load()])
    again = equilibria(Arm(), [load, Load()], guess=found.qpos)
    assert again.iterations.tolist() == [0, 0]
    np.testing.assert_array_equal(again.qpos, found.qpos)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((3,), "arms is 3"),
        (([Arm()] * 2, [Load()] * 3), "loads is 3; allowed: one, or as many as arms: 2"),
        ((Arm(), [1]), "loads is an int; allowed: a Load"),
        ((Arm(), None, {"guess": "x"}), "guess is 'x'"),
        ((Arm(), None, {"guess": np.zeros((3, 48))}), r"guess is of shape \(3, 48\)"),
        ((Arm(), None, {"threads": -1}), "threads is -1"),
        ((Arm(), None, {"method": "x"}), "method is 'x'"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(given, words):
    named = given[2] if len(given) > 2 else {}
    with pytest.raises(InputError, match=words):
        equilibria(*given[:2], **named)


def test_no_cases_are_no_equilibria():
    assert len(equilibria([], [])) == 0
    assert equilibria(Arm(), []).failed == {}


def test_a_singular_matrix_is_its_own_case_alone(monkeypatch):
    arms = [Arm(links=4, payload=payload, gravity=(0, 0, 9.81)) for payload in (0.0, 0.02, 0.05)]
    load = Load(wrenches=(Wrench(xi=1, force=(0.1, 0, 0)),))
    good, real = equilibria(arms, load), together.solved

    def singular_in_the_second(K, right):
        K = K.copy()
        K[1:2] = 0
        return real(K, right)

    monkeypatch.setattr(together, "solved", singular_in_the_second)
    found = equilibria(arms, load)
    np.testing.assert_array_equal(found.qpos[[0, 2]], good.qpos[[0, 2]])
    assert found.found.all()
    assert np.isnan(real(np.zeros((2, 3, 3)) + np.diag([1.0, 1.0, 0.0]), np.ones((2, 3, 1)))).all()
