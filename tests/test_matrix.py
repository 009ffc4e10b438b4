"""What `scripts/matrix` tests with: the newest and the lowest versions that pyproject.toml allows."""

import runpy
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


@pytest.fixture(scope="module")
def matrix():
    return runpy.run_path(str(ROOT / "scripts" / "matrix"))


def test_every_requirement_is_pinned_at_its_lower_bound(matrix):
    pinned = matrix["requirements"](PROJECT, "lowest")
    assert all("==" in each and ">=" not in each for each in pinned)
    assert {"click==8.2", "mujoco==3.17", "viser==1.1", "gymnasium==1.1", "pytest==8"} <= set(pinned)
    assert "dm-control==1.0.50; python_version < '3.13'" in pinned
    assert {"click>=8.2", "mujoco>=3.17,<4"} <= set(matrix["requirements"](PROJECT, "newest"))


def test_every_python_that_is_found_is_the_one_it_is_called_and_allowed(matrix):
    for version, python in matrix["pythons"]().items():
        said = subprocess.run([python, "--version"], capture_output=True, text=True, check=True).stdout
        assert said.startswith(f"Python {version}.")
    assert PROJECT["requires-python"] == ">=3.11,<3.14"
    assert matrix["VERSIONS"] == ("3.11", "3.12", "3.13")
    assert all((ROOT / "tests" / f"test_{name}.py").exists() for name in matrix["CORE"])
