"""Work on threads: as many as are allowed, none where one is, and nothing begun after Ctrl-C."""

import threading
import time

import pytest
from references import along

from contarm_sim import Arm, sweeps
from contarm_sim.control import tip_plan_many
from contarm_sim.engine import threads
from contarm_sim.motion.simulate import Stepping
from contarm_sim.motion.simulate_many import simulate_many
from contarm_sim.studies import at_rest
from contarm_sim.studies.attempts import attempts
from contarm_sim.studies.progress import quietly
from contarm_sim.studies.scenarios import dome_grid, scenarios
from contarm_sim.sweeps.chunks import rows

ARM = Arm(links=4)


@pytest.fixture
def pools(monkeypatch):
    """The sizes of pools that are made on a machine of four processors, where two samples are enough for a thread."""
    made, pool = [], threads.pool

    def counted(count):
        made.append(count)
        return pool(count)

    monkeypatch.setattr(threads, "processors", lambda: 4)
    monkeypatch.setattr(threads, "pool", counted)
    monkeypatch.setattr(tip_plan_many, "BUNCH", 2)
    return made


@pytest.mark.parametrize("asked", [1, 2, 0])
def test_plans_of_motions_at_once_use_no_more_threads_than_those_are_given(asked, pools):
    circle = along(ARM, "circle", 0.4, max_bend=0.3)
    simulate_many(ARM, circle, "tip", threads=asked, stepping=Stepping(0.005))
    assert set(pools) == {1: set(), 2: {2}, 0: {4}}[asked]


def test_chunks_of_a_sweep_stay_on_one_thread(pools):
    given = {
        "run": "motion",
        "fixed": {"links": 4, "controller": "tip", "path.duration": 0.4},
        "vary": {"mass": [0.2]},
    }
    assert [row["status"] for row in rows(sweeps.read(given), 0)] == ["ok"]
    assert pools == []


def test_limits_nest_and_end():
    with threads.at_most(2), threads.at_most(5), threads.at_most(0):
        assert threads.allowed(3) == 2
        assert threads.allowed(1) == 1
    assert threads.allowed(3) == 3


def test_what_is_queued_is_left_undone_after_ctrl_c():
    begun = []

    def task(number):
        begun.append(number)
        time.sleep(0.01)
        if number == 0:
            raise KeyboardInterrupt

    def wait_for_all():
        with threads.pool(1) as pool:
            for future in [pool.submit(task, number) for number in range(50)]:
                future.result()

    with pytest.raises(KeyboardInterrupt):
        wait_for_all()
    assert len(begun) < 5


def test_speeds_of_scenarios_are_measured_while_nothing_else_runs(monkeypatch):
    running = []

    def speed(*given):
        running.append(threading.active_count())
        return 2.0

    monkeypatch.setattr(at_rest, "stepping_speed", speed)
    before = threading.active_count()
    found, _ = attempts(scenarios(ARM)[:2], dome_grid(1), quietly, lambda: None)
    assert [each.real_time_factor for each in found.values()] == [2.0, 2.0]
    assert running == [before] * 2
