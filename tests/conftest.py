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


@pytest.fixture(scope="session")
def gl():
    """Return the library that draws here; without one the test is skipped."""
    from contarm_sim.errors import RenderingError
    from contarm_sim.view.rendering.gl import choose_backend

    try:
        return choose_backend()
    except RenderingError as error:
        pytest.skip(str(error))


@pytest.fixture
def contarm(monkeypatch, capsys, tmp_path):
    """Run `contarm` in this process in a folder of its own; returns exit code, stdout and stderr."""
    from contarm_sim.cli.main import main

    monkeypatch.chdir(tmp_path)

    def call(*words):
        monkeypatch.setattr(sys, "argv", ["contarm", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            main()
        printed = capsys.readouterr()
        return ended.value.code, printed.out, printed.err

    return call


def pytest_collection_modifyitems(items):
    """Begin with the file whose single test takes longest, so that no worker is left alone with it at the end."""
    items.sort(key=lambda item: item.path.name != "test_view.py")
