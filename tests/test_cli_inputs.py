"""What is wrong on the command line: one clear line, exit code 2, nothing left behind; help, units, streams."""

import json
import re
import subprocess
import sys

import pytest

from contarm_sim.cli.main import COMMANDS, SHORT
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import load_arm
from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS

WRONG = {
    "fk --bend nan 0": "bend_angle",
    "fk --bend 3.1416 0": "bend_angle",
    "fk --bend -1 0": "bend_angle",
    "fk --bend 1 inf": "plane_angle",
    "fk --bend 1": "2 arguments",
    "fk --bend a b": "'a'; allowed: a number [rad], or with its unit, such as 90deg",
    "fk --bend 1.57 90": "in degrees? write 90deg",
    "fk --bend 1 0 --length 370": "in millimetres? write 370mm",
    "fk --bend 1 0 --length 0.37 --length 1": "--length is given 2 times",
    "ik --tip 5 0 235.5": "in millimetres?",
    "ik --file mm.csv": "(in millimetres?)",
    "run --payload 50": "in grams? write 50g",
    "run --links 3 --max-bend 170deg --muscle.path spans": "a smaller --max-bend",
    "run --timestep 1e-6 --duration 3600": "at most 100,000,000 steps",
    "run --duration 3600 --links 400": "GiB of memory",
    "fk --bend 1 0 --json=1": "write its name alone",
    "equilibrium --muscles pressures 500 0 0": "in kPa? write 500kPa",
    "fk": "neither --deltas nor --bend",
    "fk --bend 1 0 --deltas 0 0 0": "both --deltas and --bend",
    "fk --deltas 0.001 0.001 0.001": "sum is 0.003 m",
    "fk --deltas nan 0 0": "finite",
    "fk --deltas -0.06 0.03 0.03": "below pi",
    "fk --bend 1 0 --xi 2": "xi",
    "fk --bend 1 0 --length 0": "at least 0.001",
    "fk --bend 1 0 --length -0.37": "at least 0.001",
    "fk --bend 1 0 --mass nan": "finite",
    "fk --bend 1 0 --links 0": "2 to 400",
    "fk --bend 1 0 --links 1": "2 to 400",
    "fk --bend 1 0 --links 1000000": "2 to 400",
    "fk --bend 1 0 --links 2.5": "not a valid integer",
    "fk --bend 1 0 --gravity 0 0 inf": "gravity",
    "fk --bend 1 0 --arm missing.toml": "No such file",
    "fk --bend 1 0 --arm typo.toml": "did you mean 'length'",
    "fk --bend 1 0 --lenght 1": "did you mean",
    "ik --tip 0.1 0.1 0.3": "26.17 mm off the dome",
    "ik --tip 0 0 0": "off the dome",
    "ik --tip nan 0 0": "finite",
    "ik --file missing.csv": "No such file",
    "ik --file cell.csv": "row 3, column y is 'two'",
    "ik --file off.csv": "off.csv, row 3",
    "ik --file empty.csv": "empty",
    "ik --file binary.csv": "not text",
    "ik --file column.csv": "missing: z",
    "ik --tip 0 0 0.37 --project sideways": "sideways",
    "run --duration 0": "duration",
    "run --duration -1": "duration",
    "run --path nowhere": "figure-eight",
    "run --path sphere-spiral": "mm off the dome",
    "run --path off.csv": "off.csv",
    "run --path column.csv": "missing: z",
    "run --max-bend 4": "max_bend",
    "run --out taken": "does not exist yet",
    "run --out /proc/none": "can be written",
    "run --controller pid": "pid",
    "run --links 3 --max-bend 2.9 --muscle.path spans": "more links",
    "validate --grid 1": "grid",
    "validate --out taken": "does not exist yet",
    "validate --links 3 --muscle.path spans": "more links",
    "build --out taken": "does not exist yet",
    "equilibrium --muscles on": "off, deltas, setpoints, tensions, pressures, bend",
    "equilibrium --muscles tensions 1 2": "3 finite numbers",
    "equilibrium --muscles tensions -1 2 3": "pull",
    "equilibrium --muscles pressures 50000 0 0": "0, or 90000 to 700000 Pa",
    "equilibrium --muscles pressures 800000 0 0": "0, or 90000 to 700000 Pa",
    "equilibrium --muscles bend 4 0": "bend_angle",
    "equilibrium --wrench 2 0 0 0 0 0 0": "0 (base) to 1 (tip)",
    "equilibrium --wrench 1 0 0": "7 arguments",
    "equilibrium --wrench 1 nan 0 0 0 0 0": "finite",
    "equilibrium --xi 1.5": "xi",
    "equilibrium --file missing.json": "No such file",
    "equilibrium --file binary.csv": "not text",
    "equilibrium --file empty.csv": "not JSON",
    "equilibrium --file empty.csv --muscles bend 1 0": "either --file, or flags",
    "stiffness --bend 2.9 0": "kPa",
    "stiffness --bend 4 0": "bend_angle",
    "stiffness --levels 1": "levels",
    "muscle --pressure 800000": "0 to 700000 Pa",
    "muscle --pressure nan": "0 to 700000 Pa",
    "muscle --out picture.txt": ".png, .pdf or .svg",
    "muscle --muscle.max-contraction 0.5": "below 0.42",
    "dance": "No such command",
}


@pytest.mark.parametrize("line", WRONG)
def test_wrong_input_is_one_clear_line_and_exit_2_and_nothing_is_written(contarm, tmp_path, line):
    (tmp_path / "typo.toml").write_text("lenght = 1\n")
    (tmp_path / "cell.csv").write_text("x,y,z\n0,0,0.37\n0,two,0\n")
    (tmp_path / "mm.csv").write_text("x,y,z\n235.5,0,235.5\n")
    (tmp_path / "off.csv").write_text("x,y,z\n0,0,0.37\n0.1,0.1,0.3\n")
    (tmp_path / "column.csv").write_text("x,y\n0,0\n")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "binary.csv").write_bytes(bytes(range(256)))
    (tmp_path / "taken").mkdir()
    before = sorted(tmp_path.rglob("*"))
    code, out, err = contarm(*line.split())
    assert (code, out) == (2, "")
    assert WRONG[line].lower() in err.lower()
    assert err.startswith("contarm: ")
    assert err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_help_teaches(contarm):
    for command in (
        "fk",
        "ik",
        "build",
        "run",
        "validate",
        "doctor",
        "equilibrium",
        "muscle",
        "compare-controllers",
        "stiffness",
    ):
        code, out, _ = contarm(command, "--help")
        assert code == 0
        assert "--json" in out
    _, out, _ = contarm("run", "--help")
    assert "Arm (SI units):" in out
    assert "--muscle.max-pressure" in out
    assert "[N m^2]" in out


@pytest.mark.parametrize("redirect", [">/dev/full", ">&-"])
def test_a_stdout_that_takes_nothing_is_no_traceback(tmp_path, redirect):
    words = f"{sys.executable} -m contarm_sim fk --bend 1 0 {redirect}"
    done = subprocess.run(words, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "words", [("--joint-friction", 0), ("--muscle.braid-friction", -1), ("--muscle.passive-stiffness", 0),
              ("--muscle.valve-time", 0), ("--torsional-stiffness", 0), ("--bending-stiffness", -1)],
)  # fmt: skip
def test_frictions_and_stiffnesses_of_zero_or_below_are_refused(contarm, words):
    code, _, err = contarm("equilibrium", *words)
    assert code == 2
    assert re.fullmatch(r"contarm: \S+ is -?[01](\.0)?; allowed: a finite number, greater than 0.*\n", err)


@pytest.mark.parametrize(("library", "command", "extra"), [("gymnasium", "envs", "gym"), ("viser", "view", "view")])
def test_without_an_optional_library_one_line_says_what_to_install(library, command, extra):
    code = f"""if True:
        import sys
        sys.modules[{library!r}] = None
        sys.argv = ["contarm", {command!r}]
        from contarm_sim.__main__ import main
        main()"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"contarm: {library} is not installed; get it with: pip install '.[{extra}]'\n"


def test_the_command_line_takes_every_controller_there_is():
    import click

    from contarm_sim.cli.main import cli
    from contarm_sim.control.registry import NAMES

    for name in ("run", "view"):
        taken = next(option for option in cli.commands[name].params if option.name == "controller").type
        assert isinstance(taken, click.Choice)
        assert tuple(taken.choices) == NAMES


def test_units_on_flags_and_in_files(contarm, tmp_path):
    """The same numbers with units and in SI give the same answers, to the last bit."""
    plain = contarm("fk", "--bend", "1.5707963267948966", 0, "--length", 0.25, "--muscle.max-pressure", 600e3, "--json")
    written = contarm("fk", "--bend", "90deg", "0", "--length", "250mm", "--muscle.max-pressure", "600 kPa", "--json")
    assert plain == written
    (tmp_path / "arm.toml").write_text('length = "25 cm"\n[muscle]\nmax_pressure = "6 bar"\n')
    assert contarm("fk", "--bend", "90deg", "0", "--arm", "arm.toml", "--json") == plain
    (tmp_path / "mm.csv").write_text("x [mm],y [mm],z [mm],w\n235.5,0,235.5,1\n")
    code, out, err = contarm("ik", "--file", "mm.csv", "--out", "found.csv")
    assert code == 0, err
    assert out.startswith("1 target solved; the largest miss is")
    assert err.splitlines()[:2] == ["mm.csv: converted x from mm to m, y from mm to m, z from mm to m",
                                    "mm.csv: not read: column 'w'"]  # fmt: skip


def test_init_writes_an_arm_to_be_edited(contarm, tmp_path):
    assert contarm("init", "my.toml")[:2] == (0, "")
    assert load_arm("my.toml") == Arm()
    text = (tmp_path / "my.toml").read_text()
    for name, item in {**PARAMETERS, **MUSCLE_PARAMETERS}.items():
        assert re.search(rf"^(# )?{name} =", text, re.MULTILINE)
        assert item.metadata["help"] in text
        assert f"[{item.metadata['unit']}]" in text or item.metadata["unit"] == "-"
    assert contarm("init", "other.toml", "--length", "250mm", "--torsional-stiffness", "0.1")[0] == 0
    assert load_arm("other.toml") == Arm(length=0.25, torsional_stiffness=0.1)
    code, out, err = contarm("init", "my.toml")
    assert (code, out, "does not exist yet" in err) == (2, "", True)


def test_help_says_of_every_command_what_it_does(contarm):
    _, out, _ = contarm("--help")
    assert "..." not in out.partition("Commands:")[2]
    assert all(len(meaning) < 45 and meaning in out for meaning in SHORT.values())
    assert {command.name for command in COMMANDS} == set(SHORT)


@pytest.mark.parametrize("closing", ["2>&-", "2>/dev/full"])
def test_a_closed_stderr_leaves_stdout_one_document(tmp_path, closing):
    (tmp_path / "f.csv").write_text("x [mm],y [mm],z [mm]\n235.5,0,235.5\n")
    words = f"{sys.executable} -m contarm_sim ik --file f.csv --out o.csv --json {closing}"
    done = subprocess.run(words, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0
    assert len(json.loads(done.stdout)) == 1


def test_a_full_disk_and_a_reader_that_left_have_exit_codes_of_their_own(tmp_path):
    def call(line):
        line = line.replace("contarm", f"{sys.executable} -m contarm_sim")
        return subprocess.run(["bash", "-c", line], cwd=tmp_path, capture_output=True, text=True)

    for words in ("--help", "fk --help", "fk --bend 1 0", "muscle"):
        done = call(f"contarm {words} > /dev/full")
        assert (done.returncode, done.stderr) == (1, "contarm: cannot write: No space left on device\n"), words
        done = call(f"contarm {words} | true; exit ${{PIPESTATUS[0]}}")
        assert (done.returncode in (0, 141), done.stderr) == (True, ""), words
