import os
import shlex
import signal
import subprocess
import sys

import pytest

for library in (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
):  # matrices are small, and idle threads spin: see engine_room
    os.environ.setdefault(library, "1")

from contarm_sim import libmujoco  # noqa: E402
from contarm_sim.model.arm import Arm  # noqa: E402

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
def blank_figures(monkeypatch):
    """Draw figures as ever, but write a blank picture for each: where tests ask which files there are, not for more."""
    from PIL import Image

    from contarm_sim.view import style

    monkeypatch.setattr(style, "write", lambda sheet, path: Image.new("L", (8, 8), 255).save(path, path.suffix[1:]))


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


LONG = (
    "test_view.py", "test_rendering.py", "test_docs.py", "test_trust.py", "test_figures.py", "test_envs_pictures.py",
    "test_envs_sections.py", "test_determinism.py", "test_study_figures.py", "test_typing.py", "test_view_record.py",
    "test_report.py", "test_cli_run.py", "test_cli_studies.py", "test_view_sections.py", "test_view_page.py",
    "test_stopping.py", "test_envs_dm.py", "test_examples.py", "test_studies.py", "test_rod_sections.py",
)  # fmt: skip
"""Files that take longest, about in that order: begun early, no worker is left alone with one at the end."""


def pytest_configure(config):
    if hasattr(config.option, "loadscopereorder"):  # xdist would begin with the files of the most tests
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items):
    places = {name: place for place, name in enumerate(LONG)}
    items.sort(key=lambda item: places.get(item.path.name, len(LONG)))
