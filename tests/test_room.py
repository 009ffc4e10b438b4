"""What simulations change of the process is put back when the last of them is over."""

from threading import Barrier, Thread

import mujoco

from contarm_sim.engine.room import engine_room


def test_threads_that_overlap_leave_the_engine_as_it_was():
    before, barrier = mujoco.get_mju_user_warning(), Barrier(2)

    def first():
        with engine_room():
            barrier.wait()  # the second is inside
            barrier.wait()

    def second():
        barrier.wait()
        with engine_room():
            barrier.wait()  # the first leaves before

    threads = [Thread(target=first), Thread(target=second)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert mujoco.get_mju_user_warning() is before
