import warnings

import pytest

from contarm_sim.arm import Arm

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import mujoco  # noqa: F401  imported once here, whatever MUJOCO_GL says


@pytest.fixture(scope="session")
def arm() -> Arm:
    return Arm()
