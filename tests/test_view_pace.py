"""The live page on a machine that is too slow for all of it: the arm's time goes first, pictures second."""

from types import SimpleNamespace

import numpy as np
import pytest

from contarm_sim.model.arm import Arm
from contarm_sim.view.live import server
from contarm_sim.view.live.pace import LEAST, MOST, Pace
from contarm_sim.view.live.plots import Plots
from contarm_sim.view.live.wishes import Wishes


class Clock:
    """A clock that goes on when something takes time."""

    def __init__(self):
        self.now = 100.0

    def perf_counter(self):
        return self.now

    def sleep(self, seconds):
        self.now += seconds


class OverError(Exception):
    """The time that a test looks at is over."""


def run(monkeypatch, tick, picture, seconds):
    """Run the loop with ticks and pictures that take so long [s]; returns simulated time [s], pictures, what is said.

    `picture` may be a function of the time since the start.
    """
    clock, said, shown = Clock(), [], []
    monkeypatch.setattr(server, "time", clock)
    session = SimpleNamespace(period=0.01, time=0.0, problem="")

    def step():
        clock.now += tick
        session.time += session.period

    def show():
        since = clock.now - 100.0
        shown.append(since)
        clock.now += picture(since) if callable(picture) else picture
        if since > seconds:
            raise OverError

    session.tick = step
    panel = SimpleNamespace(paused=False, speed=1.0, note=lambda: None)
    panel.show = lambda pace, thinning, arrows: said.append((pace, thinning))
    viewers = SimpleNamespace(get_clients=lambda: {1: 0})
    page = SimpleNamespace(
        panel=panel, wishes=Wishes(), scene=SimpleNamespace(arrows=0.0, show=show, note=lambda: None), server=viewers
    )
    with pytest.raises(OverError):
        server._loop(session, page)
    return session.time, shown, said


def test_a_quick_machine_draws_as_often_as_it_should_and_says_nothing(monkeypatch):
    simulated, shown, said = run(monkeypatch, 0.002, 0.003, 20)
    assert simulated == pytest.approx(20, abs=0.1)
    assert len(shown) > 0.8 * 20 * MOST
    assert {words for words, _ in said} == {""}
    assert {thin for _, thin in said} == {1}


@pytest.mark.parametrize("picture", [0.07, 0.15])
def test_where_pictures_take_long_there_are_fewer_and_time_is_kept(monkeypatch, picture):
    simulated, shown, said = run(monkeypatch, 0.006, picture, 60)
    late = [when for when in shown if when > 10]
    assert 0.6 * LEAST < len(late) / 50 < 0.5 * MOST
    assert simulated > 0.96 * 60
    assert all("real time, at" in words for words, _ in said[len(said) // 2 :])
    assert said[-1][1] > 1  # curves have fewer points


def test_pictures_come_back_when_there_is_room(monkeypatch):
    _, shown, said = run(monkeypatch, 0.002, lambda since: 0.15 if since < 20 else 0.002, 120)
    before = [when for when in shown if 15 < when < 20]
    after = [when for when in shown if when > 110]
    assert len(before) / 5 < 10
    assert len(after) / 10 > 0.8 * MOST
    assert said[-1] == ("", 1)


def test_a_machine_too_slow_for_the_arm_alone_is_told_apart(monkeypatch):
    simulated, _, said = run(monkeypatch, 0.02, 0.001, 30)
    assert simulated < 20
    assert "0.5 of the set speed" in said[-1][0].replace("0.50", "0.5").replace("0.49", "0.5").replace("0.48", "0.5")


def test_many_tries_that_fail_become_rare():
    pace, now, raised = Pace(0.0), 0.0, []
    for _ in range(600):
        now += 1.0
        before = pace.rate
        pace.note(now, 0.1 if pace.rate > 10 else 0.0, 0.0)
        if pace.rate > before:
            raised.append(now)
    assert raised[-1] - raised[-2] > 5 * (raised[1] - raised[0])


def test_a_curve_of_fewer_points_keeps_its_peaks_and_does_not_change_as_it_moves_on():
    pytest.importorskip("viser")
    cards = [SimpleNamespace() for _ in range(3)]
    left = iter(cards)
    plots = Plots(SimpleNamespace(add_uplot=lambda *given, **more: next(left)), Arm())
    before = {}
    for k in range(120):
        error = 9e-3 if k == 47 else 1e-3
        plots.note(SimpleNamespace(time=0.0501 * k, error=error, tensions=np.ones(3), pressures=np.ones(3)))
        plots.show(thinning=4)
        times, errors = cards[0].data
        kept = dict(zip(times.tolist(), errors.tolist(), strict=True))
        assert k < 47 or max(kept.values()) == pytest.approx(9.0)
        assert len(kept) <= k // 4 + 2
        assert all(kept.get(when) == what for when, what in before.items() if when < 0.0501 * (k - 4))
        before = kept
