"""The lowest versions that pyproject.toml allows; `scripts/lowest` runs the core tests with all of them."""

import runpy
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_every_requirement_is_pinned_at_its_lower_bound():
    lowest = runpy.run_path(str(ROOT / "scripts" / "lowest"))["lowest"]
    pinned = lowest(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"])
    assert all("==" in each and ">=" not in each for each in pinned)
    assert {"click==8.2", "mujoco==3.17", "viser==1.1", "gymnasium==1.1", "pytest==8"} <= set(pinned)
    assert "dm-control==1.0.50; python_version < '3.13'" in pinned
