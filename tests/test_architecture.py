"""Imports run one way, the two derivations stay independent, and nothing heavy loads early."""

import ast
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1] / "contarm_sim"

# Each part may import itself and the parts named here.
MAY = {
    "errors": set(),
    "brevity": {"errors"},
    "display": {"brevity", "errors"},
    "stopping": set(),
    "libmujoco": set(),
    "versions": set(),
    "processors": set(),
    "files": {"stopping"},
    "inputs": {"errors"},
    "model": {"brevity", "display", "errors", "inputs", "libmujoco"},
    "kinematics": {"display", "errors"},
    "mechanics": {"errors", "model", "kinematics"},
    "mjcf": {"errors", "libmujoco", "model"},
    "paths": {"display", "errors", "inputs", "model", "kinematics", "mechanics"},
    "results": {"display", "errors", "inputs", "model", "kinematics", "mechanics", "paths"},
    "engine": {"errors", "libmujoco", "processors", "model", "kinematics", "mechanics", "mjcf"},
    "statics": {"brevity", "display", "errors", "libmujoco", "model", "kinematics", "mechanics", "mjcf", "engine"},
    "planning": {"display", "errors", "libmujoco", "model", "kinematics", "mechanics", "mjcf", "paths"},
    "control": {"errors", "model", "kinematics", "mechanics", "paths", "engine", "statics"},
    "motion": {"errors", "libmujoco", "versions", "model", "kinematics", "mechanics", "mjcf", "paths", "results",
               "engine", "statics", "control"},
    "studies": {"display", "errors", "inputs", "model", "kinematics", "mechanics", "paths", "results", "engine",
                "statics", "control", "motion"},
    "identify": {"brevity", "display", "errors", "stopping", "files", "inputs", "versions", "model", "kinematics",
                 "mechanics", "paths", "results", "engine", "statics", "control", "motion"},
    "sweeps": {"display", "errors", "stopping", "files", "inputs", "versions", "model", "kinematics", "mechanics",
               "paths", "results", "engine", "statics", "control", "motion", "studies"},
    "view": {"brevity", "display", "errors", "stopping", "libmujoco", "files", "inputs", "versions", "model",
             "kinematics", "mechanics", "mjcf", "paths", "results", "engine", "statics", "planning", "control",
             "motion", "studies", "identify", "sweeps"},
    "demos": {"inputs", "model", "kinematics", "mechanics", "paths", "results", "engine", "planning", "control",
              "motion"},
    "envs": {"errors", "libmujoco", "model", "kinematics", "mechanics", "mjcf", "paths", "engine", "statics",
             "planning", "control", "demos", "view"},
    "cli": {"errors", "stopping", "files", "inputs", "versions", "processors", "model", "kinematics", "mechanics",
            "mjcf", "paths", "results", "statics", "planning", "control", "motion", "studies", "identify", "sweeps",
            "view", "envs"},
}  # fmt: skip

# The one door upwards: results show themselves in notebooks, see display.py; only where they are asked to.
DOORS = {
    "display.py": {
        "contarm_sim.view.notebook",
        "contarm_sim.view.notebook.films.Film",
        "contarm_sim.view.notebook.reports.Report",
        "contarm_sim.view.style.Sheet",
    }
}


def _imports(file):
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file.name}: relative imports would escape these tests"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def test_imports_run_one_way():
    for file in ROOT.rglob("*.py"):
        part = file.relative_to(ROOT).parts[0].removesuffix(".py")
        if part in ("__init__", "__main__"):
            continue
        for name in _imports(file):
            if name.startswith("contarm_sim."):
                other = name.split(".")[1]
                if name in DOORS.get(str(file.relative_to(ROOT)), ()):
                    continue
                assert other == part or other in MAY[part], f"{file.relative_to(ROOT)} imports {name}"


def test_the_two_derivations_are_independent():
    for part, forbidden in (("kinematics", "mujoco"), ("mechanics", "mujoco"), ("mjcf", "contarm_sim.kinematics")):
        for file in (ROOT / part).rglob("*.py"):
            assert not any(name.startswith(forbidden) for name in _imports(file)), file


def _loaded_after(code):
    program = f"import sys; {code}; print(' '.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_the_command_line_and_the_package_load_nothing_heavy():
    heavy = {"numpy", "mujoco", "matplotlib", "scipy", "rich", "PIL"}
    assert not heavy & _loaded_after("import contarm_sim.cli.main")
    assert not heavy & _loaded_after("import contarm_sim; contarm_sim.Arm()")
    assert not {"mujoco", "matplotlib"} & _loaded_after("from contarm_sim import kinematics, paths")


def test_the_simulation_loads_scipy_and_inverse_kinematics_only_where_it_needs_them():
    """Half a second of a first `contarm run` is not spent on splines and inverses that no part of it asks for."""
    motion = "from contarm_sim.motion import release, rest, simulate"
    loaded = _loaded_after(f"{motion}; import contarm_sim.statics.equilibrium, contarm_sim.studies.controllers")
    assert not [name for name in loaded if name.startswith(("scipy", "contarm_sim.kinematics.inverse"))]
