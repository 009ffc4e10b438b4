"""What the README tells people to type, typed; and what it says is printed, printed."""

import importlib.util
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

README = (Path(__file__).parents[1] / "README.md").read_text()
COMMANDS = re.findall(r"^\$ contarm (?!view)(.*?)(?:\s{2,}#.*)?$", README, re.MULTILINE)  # it runs until Ctrl-C
EXAMPLES = re.findall(r"```python\n(.*?)```\s*```text\n(.*?)```", README, re.DOTALL)


@pytest.mark.parametrize(("code", "printed"), EXAMPLES, ids=range(len(EXAMPLES)))
def test_the_python_examples_print_what_they_say(code, printed):
    for module in ("dm_control", "gymnasium"):
        if module in code and importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed")
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == printed


FINDINGS = {
    "run --path sphere-spiral --project nearest --duration 20": "targets off the dome cannot be reached",
    "compare-controllers": "failed: bend is one that needs",
}
"""Commands that work and find something that fails: exit code 1, and why."""


@pytest.mark.parametrize("line", COMMANDS)
def test_commands_work(line, tmp_path):
    words = shlex.split(line)
    if words[0] == "run":
        words.append("--no-video")  # filming is tested elsewhere
    if words[0] == "envs":
        words += ["--seeds", "5"]
    done = subprocess.run([sys.executable, "-m", "contarm_sim", *words], cwd=tmp_path, capture_output=True, text=True)
    found = FINDINGS.get(line)
    assert done.returncode == (0 if found is None else 1) or words[0] == "doctor", done.stderr
    assert found is None or found in done.stdout
    assert "Traceback" not in done.stderr


def test_there_are_commands_and_no_gaps_left():
    assert len(COMMANDS) >= 7
    assert len(EXAMPLES) == 5
    assert not re.search(r"@[A-Z]+@", README)


def test_every_parameter_has_its_reason():
    from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS

    table = README.split("## Assumptions")[1].split("## ")[0]
    for name in [*PARAMETERS, *MUSCLE_PARAMETERS]:
        assert name == "base_orientation" or f"`{name}`" in table, name
