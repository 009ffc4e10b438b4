"""What README and docs tell people to type, typed; and what they say is printed, printed. The site builds."""

import importlib.util
import pkgutil
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "scripts"))

from blocks import blocks, commands, pages  # noqa: E402

SHOWN = [block for page in pages() for block in blocks(page)]
EXAMPLES = [block for block in SHOWN if block.kind == "python"]
OUTPUTS = [block for block in SHOWN if block.kind == "console"]
TABLES = [block for block in SHOWN if block.kind == "table"]

SLOW = (
    "validate",
    "trust",
    "compare-controllers",
    "envs",
    "possibility",
    "sweep soft",
    "benchmarks/",
    "scripts/results.py",
)
"""Blocks and commands that take ten seconds and more."""

CHEAPER = {
    "validate": (["--quick"], "constant curvature holds within 0.09 %"),
    "compare-controllers": (["--duration", "1", "--links", "8"], "tension [N]"),
    "trust": (["--links", "6", "--planes", "1"], "largest bends at which constant curvature holds"),
    "envs": (["--seeds", "2"], "2 of 2"),
    "sweep soft": (["--names"], "sag_max_percent"),
    "sweep soft --workers 2": (["--names"], "sag_max_percent"),
    "possibility": (["--links", "8"], "towards [deg]"),
    "figures fan sag": (["--figures", "svg", "--links", "8"], "fan.svg"),
    "run --path sphere-spiral --project nearest --duration 20 --no-video": (
        ["--figures", "none"],
        "targets off the dome cannot be reached",
    ),
    "init my_arm.toml": ([], "my_arm.toml"),
    "init my_arm_of_three.toml --preset three": ([], "my_arm_of_three.toml"),
    "build --links 48 --out my_arm": ([], "my_arm/scene.xml"),
    "build --preset two --out my_arm_of_two": ([], "my_arm_of_two/scene.xml"),
    "doctor": ([], "mujoco"),
    "fit tendon --names": ([], "section_*.bending_stiffness"),
    "equilibrium --muscles pressures 500000 200000 200000": ([], "stable"),
    "equilibrium --gravity -9.81 0 0 --wrench 1 0 0.2 0 0 0 0": ([], "softest mode 6.48 N m/rad"),
}
"""Commands whose whole output is not shown, or that take long: what to add, and what their output must contain."""

ELSEWHERE = ("compare-controllers", "possibility")
"""Commands that take long at any size, and that test_cli_studies runs."""

FINDINGS = ("run --path sphere-spiral", "compare-controllers", "doctor")
"""Commands that may find that something fails: exit code 1."""


def _slow(code):
    return any(word in code for word in SLOW)


def _name(block):
    return f"{block.page.stem}: {block.code.strip().splitlines()[0][:60]}"


def _param(block):
    return pytest.param(block, id=_name(block), marks=[pytest.mark.slow] if _slow(block.code) else [])


@pytest.mark.parametrize("block", [_param(block) for block in EXAMPLES])
def test_python_examples_print_what_they_say(block, tmp_path):
    for module in ("dm_control", "gymnasium"):
        if module in block.code and importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed")
    assert block.run(tmp_path) == block.shown


@pytest.mark.parametrize("block", [_param(block) for block in [*OUTPUTS, *TABLES]])
def test_outputs_and_tables_are_what_is_printed(block, contarm, tmp_path):
    printed = block.printed(*contarm(*block.words)) if block.kind == "console" else block.run(tmp_path)
    assert block.same(printed), printed


WHOLE = {block.code.strip().splitlines()[0].removeprefix("$ contarm ").split("  ")[0] for block in OUTPUTS}


LINES = [line for line in commands() if line not in WHOLE or _slow(line)]


@pytest.mark.parametrize(
    "line", [pytest.param(line, marks=[pytest.mark.slow] if line in ELSEWHERE else []) for line in LINES]
)
def test_commands_work(line, contarm):
    more, expected = CHEAPER[line]
    code, out, err = contarm(*shlex.split(line), *more)
    assert code in ((0, 1) if line.startswith(FINDINGS) else (0,)), err
    assert expected in out + err


def test_there_is_something_to_run():
    assert len(EXAMPLES) >= 7
    assert len(OUTPUTS) >= 10
    assert len(TABLES) >= 5
    assert not any("@" + "SETUP" in page.read_text() for page in pages())


def test_an_output_that_differs_is_noticed():
    block = next(block for block in OUTPUTS if "hold" in block.code)
    digit = re.search(r"\d(?=\.\d)", block.shown)
    changed = block.shown[: digit.start()] + str((int(digit[0]) + 1) % 10) + block.shown[digit.end() :]
    assert block.same(block.shown)
    assert not block.same(changed)


def test_every_parameter_has_its_reason():
    from parameters import parameters

    table = (ROOT / "docs" / "theory" / "assumptions.md").read_text().split("## All parameters")[0]
    names = [name.removeprefix("muscle.") for name, *_ in parameters()]
    assert len(names) > 20
    for name in names:
        assert name == "base_orientation" or f"`{name}`" in table, name


def test_every_page_is_in_the_navigation_and_every_picture_is_used():
    listed = (ROOT / "mkdocs.yml").read_text()
    texts = "".join(page.read_text() for page in pages())
    for page in (ROOT / "docs").rglob("*.md"):
        assert f"- {page.relative_to(ROOT / 'docs')}\n" in listed, page
    for picture in (ROOT / "docs" / "images").iterdir():
        assert f"images/{picture.name}" in texts, picture


def test_what_pages_name_is_there():
    package, missing = ROOT / "contarm_sim", []
    for page in pages():
        text = page.read_text()
        for name in re.findall(r"`contarm_sim((?:\.\w+)+)`", text):
            parts = name.split(".")[1:]
            try:
                pkgutil.resolve_name(f"contarm_sim.{'.'.join(parts)}")
            except (ImportError, AttributeError):
                missing.append(f"{page.name}: contarm_sim{name}")
        for name in re.findall(r"`((?:\w+/)+\w+\.(?:py|toml|md))`", text):
            if not any((root / name).is_file() for root in (ROOT, package)):
                missing.append(f"{page.name}: {name}")
    assert not missing


def test_the_drawings_can_be_made(tmp_path):
    import drawings

    drawings.frames(tmp_path)
    drawings.imports(tmp_path)
    for name in ("frames.png", "imports.png"):
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG"
        assert (ROOT / "docs" / "images" / name).is_file()


def test_the_site_builds_without_a_warning_or_a_call_elsewhere(tmp_path):
    pytest.importorskip("mkdocs")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "-d", str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    kinematics = (tmp_path / "theory" / "kinematics" / "index.html").read_text()
    assert kinematics.count("<math") > 20
    assert "arithmatex" not in kinematics
    assert "bend_from_tip" in (tmp_path / "reference" / "contarm_sim.kinematics" / "index.html").read_text()
    loaded = r'<(?:script|img|link)[^>]+(?:src|href)="https?://'
    assert not [page for page in tmp_path.rglob("*.html") if re.search(loaded, page.read_text())]


def test_the_address_is_set_in_one_place():
    import tomllib

    pytest.importorskip("hatchling")
    from readme_hook import absolute

    text = '<img src="docs/a.gif"> ![b](docs/b.png) [c](docs/c.md) [d](https://d.org) [e](#e)'
    assert absolute(text, None) == text
    assert absolute(text, "https://host/us/it") == (
        '<img src="https://host/us/it/raw/HEAD/docs/a.gif"> ![b](https://host/us/it/raw/HEAD/docs/b.png) '
        "[c](https://host/us/it/blob/HEAD/docs/c.md) [d](https://d.org) [e](#e)"
    )
    urls = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["urls"]
    if "Repository" in urls:
        assert f'repository-code: "{urls["Repository"]}"' in (ROOT / "CITATION.cff").read_text()
