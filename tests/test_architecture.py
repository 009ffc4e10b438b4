"""Imports run one way, the two derivations stay independent, and nothing heavy loads early."""

import ast
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1] / "contarm_sim"

# Each part may import itself and the parts named here.
MAY = {
    "errors": set(),
    "stopping": set(),
    "files": {"stopping"},
    "engine": set(),
    "parameters": {"errors"},
    "arm": {"errors", "parameters"},
    "arm_file": {"arm", "errors"},
    "kinematics": {"errors"},
    "load": {"errors", "parameters"},
    "paths": {"errors", "kinematics"},
    "waypoints": {"errors", "kinematics", "paths"},
    "mechanics": {"errors", "arm", "kinematics"},
    "mjcf": {"errors", "engine", "arm"},
    "simulation": {"errors", "engine", "arm", "load", "kinematics", "mechanics", "mjcf"},
    "validation": {"errors", "arm", "arm_file", "load", "kinematics", "mechanics", "paths", "simulation"},
    "rendering": {"errors", "engine", "files", "arm", "kinematics", "mjcf", "simulation"},
    "report": {"errors", "files", "stopping", "arm", "arm_file", "kinematics", "mechanics", "mjcf", "simulation",
               "validation", "rendering"},
    "figures": {"errors", "arm", "kinematics", "mechanics", "paths", "simulation", "validation", "report"},
    "live": {"errors", "arm", "kinematics", "mechanics", "mjcf", "simulation", "rendering"},
    "cli": {"errors", "files", "stopping", "arm", "arm_file", "load", "kinematics", "mechanics", "paths", "waypoints",
            "mjcf", "simulation", "validation", "rendering", "report", "figures", "live", "envs"},
    "envs": {"errors", "engine", "arm", "arm_file", "kinematics", "mechanics", "paths", "mjcf", "simulation",
             "rendering"},
}  # fmt: skip


def _imports(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_imports_run_one_way():
    for file in ROOT.rglob("*.py"):
        part = file.relative_to(ROOT).parts[0].removesuffix(".py")
        if part in ("__init__", "__main__"):
            continue
        for name in _imports(file):
            if name.startswith("contarm_sim."):
                other = name.split(".")[1]
                assert other == part or other in MAY[part], f"{file.relative_to(ROOT)} imports {name}"


def test_the_two_derivations_are_independent():
    for part, forbidden in (("kinematics", "mujoco"), ("mechanics", "mujoco"), ("mjcf", "contarm_sim.kinematics")):
        for file in (ROOT / part).glob("*.py"):
            assert not any(name.startswith(forbidden) for name in _imports(file)), file


def _loaded_after(code):
    program = f"import sys; {code}; print(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_the_command_line_and_the_package_load_nothing_heavy():
    heavy = {"numpy", "mujoco", "matplotlib", "scipy", "rich", "mediapy", "PIL"}
    assert not heavy & _loaded_after("import contarm_sim.cli.main")
    assert not heavy & _loaded_after("import contarm_sim; contarm_sim.Arm()")
    assert not {"mujoco", "matplotlib", "mediapy"} & _loaded_after("from contarm_sim import kinematics, paths")


def test_the_simulation_loads_scipy_only_where_it_needs_it():
    """Half a second of a first `contarm run` is not spent on splines that no part of it asks for."""
    parts = "run, rest, plan, release, equilibrium"
    loaded = _loaded_after(f"from contarm_sim.simulation import {parts}; import contarm_sim.validation.controllers")
    assert not [name for name in loaded if name.startswith("scipy")]
