import pytest

from contarm_sim import engine
from contarm_sim.arm import Arm

engine.load()


@pytest.fixture(scope="session")
def arm() -> Arm:
    return Arm()
