import pytest

from contarm_sim import libmujoco
from contarm_sim.model.arm import Arm

libmujoco.load()


@pytest.fixture(scope="session")
def arm() -> Arm:
    return Arm()
