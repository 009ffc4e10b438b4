import signal

import pytest

from contarm_sim import libmujoco
from contarm_sim.model.arm import Arm

libmujoco.load()

# Started by nohup or in the background, tests would inherit signals that are ignored; commands leave such alone.
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)


@pytest.fixture(scope="session")
def arm() -> Arm:
    return Arm()
