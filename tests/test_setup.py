"""scripts/setup: what it does at once, without a network: nothing when all is ready, one clear line when it cannot."""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture
def place(tmp_path):
    """Return a copy of what the script needs of the repository."""
    (tmp_path / "scripts").mkdir()
    shutil.copy(ROOT / "scripts" / "setup", tmp_path / "scripts")
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def _key(place):
    """Return what the script takes a .venv to depend on, as it writes it down."""
    version = f"({sys.version_info[0]}, {sys.version_info[1]})\n"
    text = (place / "pyproject.toml").read_bytes() + f"{place}\n{version}".encode()
    return hashlib.sha256(text).hexdigest() + "  -"


def _ready(place, extra=""):
    """Make the .venv of a set-up that has been done."""
    (place / ".venv" / "bin").mkdir(parents=True)
    (place / ".venv" / "bin" / "python").symlink_to(sys.executable)
    (place / ".venv" / "contarm-setup").write_text(f"{_key(place)}{extra}\n")


def _setup(place, *words, **environment):
    command = ["/bin/bash", str(place / "scripts" / "setup"), *words]
    return subprocess.run(command, capture_output=True, text=True, env=os.environ | environment, cwd="/")


def _tools(place, *names):
    """Return a PATH with these programs alone."""
    folder = place / "tools"
    folder.mkdir()
    for name in names:
        (folder / name).symlink_to(shutil.which(name))
    return str(folder)


CORE = ("cat", "dirname", "id", "readlink", "rm", "sha256sum")


@pytest.mark.parametrize(("made", "asked"), [("", ()), (" dev", ()), (" dev", ("dev",))])
def test_what_is_ready_is_left_alone_without_a_word(place, made, asked):
    _ready(place, made)
    before = sorted(place.rglob("*"))
    done = _setup(place, *asked)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize("change", ["dependencies", "half made", "dev"])
def test_what_is_not_ready_is_made_again_and_without_python_it_says_what_to_install(place, change):
    _ready(place)
    if change == "dependencies":
        with (place / "pyproject.toml").open("a") as file:
            file.write("# changed\n")
    elif change == "half made":
        (place / ".venv" / "contarm-setup").unlink()
    done = _setup(place, *(["dev"] if change == "dev" else []), PATH=_tools(place, *CORE))
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == "scripts/setup: no Python 3.11, 3.12 or 3.13 found; install one\n"
    assert not (place / ".venv" / "contarm-setup").exists()  # nothing half made counts as ready


def test_an_installation_that_fails_is_exit_code_1_and_not_ready(place):
    tools = _tools(place, *CORE)
    fake = Path(tools) / "python3"
    fake.write_text('#!/bin/bash\n[ "$1" = -c ] && exit 0\necho "no space left" >&2\nexit 1\n')
    fake.chmod(0o755)
    done = _setup(place, PATH=tools)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.splitlines()[-2:] == ["no space left", "scripts/setup: the installation failed"]
    assert not (place / ".venv" / "contarm-setup").exists()
