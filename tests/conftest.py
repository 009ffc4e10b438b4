import shlex
import signal
import subprocess
import sys

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


@pytest.fixture(scope="session")
def typed(tmp_path_factory):
    """Type a `contarm` command in a folder of its own, once for all tests; returns what it did, and the folder."""
    done = {}

    def once(line):
        if line not in done:
            folder, words = tmp_path_factory.mktemp("typed"), shlex.split(line)
            command = [sys.executable, "-m", "contarm_sim", *words]
            done[line] = subprocess.run(command, cwd=folder, capture_output=True, text=True), folder
        return done[line]

    return once
