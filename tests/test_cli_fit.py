"""`contarm fit` on a recording that the simulator made: what it finds, says, writes and refuses."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from contarm_sim import load_recording, save_recording
from contarm_sim.cli.fit import show
from contarm_sim.identify.asked import held_out_from
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.identify.recordings.synthetic import random_windings, recorded
from contarm_sim.identify.search.descent import METHODS
from contarm_sim.identify.search.losses import LOSSES
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_toml, load_arm
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.model.world import World

TRUTH = {"bending_stiffness": 0.022, "frame.x": 0.003}
FREE = ("bending_stiffness", "damping_time", "frame.*")
"""One that a pose shows, one that it does not, and a place."""


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return an arm's file, and a recording's of a softer arm that stands 3 mm aside: two patterns of sixteen poses."""
    folder = tmp_path_factory.mktemp("arm")
    arm = _arm(0.03)
    rig = Rig(markers=(Marker(),), actuation=Actuation(channels=(0, 1, 2)))
    commands, blocks = random_windings(arm, 32, seed=1, samples=16)
    shifted = Rig(markers=rig.markers, actuation=rig.actuation, position=(TRUTH["frame.x"], 0.0, 0.0))
    made = recorded(_arm(TRUTH["bending_stiffness"]), shifted, commands, seed=2, noise=0.0003, blocks=blocks)
    (folder / "arm.toml").write_text(arm_to_toml(arm))
    return folder / "arm.toml", save_recording(made.in_rig(rig), folder / "recording")


def _arm(stiffness):
    section = Section(length=0.2, links=5, mass=0.1, bending_stiffness=stiffness)
    hanging = World(gravity=(0.0, 0.0, 9.81))
    return Arm(sections=(section,), routings=(Routing(radius=0.015),), laws=(Tendon(),), world=hanging)


@pytest.fixture(scope="module")
def fitted(files, tmp_path_factory):
    """Return what the command says of it as JSON, and its folder."""
    import contextlib
    import io
    import sys

    from contarm_sim.cli.main import main

    folder, out = tmp_path_factory.mktemp("fit") / "f", io.StringIO()
    words = [*files, "--free", *FREE, "--hold-out", "2_*", "--prior", "frame.*", "0mm", "5mm", "--out", folder]
    with pytest.MonkeyPatch.context() as patch, contextlib.redirect_stdout(out), contextlib.suppress(SystemExit):
        patch.setattr(sys, "argv", ["contarm", "fit", *map(str, words), "--figures", "none", "--json"])
        main()
    return json.loads(out.getvalue()), folder


def test_what_is_known_is_found_and_what_is_not_keeps_its_start(fitted, files):
    told, folder = fitted
    found = {one["name"]: one for one in told["parameters"]}
    assert list(found) == ["bending_stiffness", "damping_time", "frame.x", "frame.y", "frame.z"]
    for name, truth in TRUTH.items():
        one = found[name]
        assert one["status"] == "determined"
        assert one["low"] < truth < one["high"]
        assert one["high"] - one["low"] < max(0.4 * truth, 0.001)
    assert found["damping_time"]["status"] == "not seen"
    assert found["damping_time"]["value"] is None
    assert found["frame.x"]["prior_sd"] == pytest.approx(0.005)
    arm = load_arm(folder / "arm.toml")
    assert arm.sections[0].bending_stiffness == found["bending_stiffness"]["value"]
    assert arm.sections[0].damping_time == pytest.approx(load_arm(files[0]).sections[0].damping_time)
    (errors,) = told["left_over"]
    assert {one["block"] for one in errors["blocks"] if one["held_out"]} == {"2_all"}
    whole = {one["part"]: one["rms_m"] for one in errors["errors"]}
    assert 0.0003 < whole["held out"] < 0.0008


def test_the_folder_is_whole_and_says_what_was_printed(fitted):
    told, folder = fitted
    names = {file.name for file in folder.iterdir()}
    assert names == {"arm.toml", "rig.toml", "summary.json", "parameters.csv", "residuals.csv", "fit.npz",
                     "report.html"}  # fmt: skip
    assert json.loads((folder / "summary.json").read_text()) == told
    with (folder / "residuals.csv").open() as file:
        rows = list(csv.DictReader(file))
    distances = [float(row["distance_m"]) for row in rows if row["held_out"] == "1"]
    size = next(one for one in told["left_over"][0]["errors"] if one["part"] == "held out")
    assert np.sqrt(np.mean(np.square(distances))) == pytest.approx(size["rms_m"], rel=1e-9)
    page = (folder / "report.html").read_text().replace("\u00a0", " ")
    assert told["in_words"] in page
    assert "damping_time" in page


def test_people_are_told_the_same(fitted, capsys):
    from contarm_sim.identify.fit_folder import load_fit

    show(load_fit(fitted[1]))
    printed = capsys.readouterr().out
    found = {one["name"]: one for one in fitted[0]["parameters"]}
    row = next(line for line in printed.splitlines() if line.strip().startswith("frame.x"))
    assert row.split()[1] == "mm"
    assert float(row.split()[3]) == pytest.approx(1e3 * found["frame.x"]["value"], abs=0.006)
    assert "an arm at rest does not show its damping" in printed.replace("\n  ", " ")
    assert printed.count("- damping_time") == 1
    assert "held out" in printed
    assert fitted[0]["in_words"] in printed


def test_names_lists_units_values_and_stars(contarm, files):
    code, out, err = contarm("fit", *files, "--names")
    assert (code, err) == (0, "")
    rows = {line.split()[0]: line.split()[1:] for line in out.splitlines() if line.startswith("  ")}
    assert rows["bending_stiffness"] == ["0.03", "N", "m^2"]
    assert rows["actuation.slack_3"] == ["0", "m"]
    assert rows["actuation.slack_*"][0] == "3"
    assert rows["frame.*"][:3] == ["3", "of", "them:"]
    code, out, _ = contarm("fit", "tendon", "--names", "--json")
    told = json.loads(out)
    assert told["parameters"]["section_2.bending_stiffness"] == {"unit": "N m^2", "value": 0.03}
    assert told["together"]["section_*.mass"] == ["section_1.mass", "section_2.mass", "section_3.mass"]
    assert not any(name.startswith("actuation") for name in told["parameters"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--free", "bending_stifness"], "did you mean 'bending_stiffness'"),
        (["--free", "section_*.masss"], "did you mean"),
        ([], "--free is missing"),
        (["--free", "mass", "--bounds", "frame.x", "0", "1"], "not free; allowed: mass"),
        (["--free", "mass", "--prior", "mass", "50mm", "1g"], "'50mm'; allowed: a number [kg]"),
        (["--free", "mass", "--bounds", "mass", "90", "100g"], "in grams? write 90g"),
        (["--free", "mass", "--bounds", "mass", "2", "3"], "a start within its bounds"),
        (["--free", "damping_time"], "does not show its damping"),
        (["--free", "mass", "--hold-out", "3_*"], "1_all, 2_all"),
        (["--free", "mass", "--hold-out", "120%"], "a fraction"),
        (["--free", "mass", "--hold-out", "0"], "above 0 and below 1 (25%), or blocks: 1_all, 2_all"),
        (["--free", "mass", "--bounds", "mass", "2", "--starts", "3"], "--bounds is"),
        (["--free", "mass", "--noise", "0"], "a length above 0"),
        (["--free", "mass", "--rig", "nothing.toml"], "nothing.toml"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(contarm, files, tmp_path, words, said):
    code, out, err = contarm("fit", *files, *words, "--out", "f")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert said in err
    assert not list(tmp_path.iterdir())


def test_blocks_come_before_shares(files):
    recording = load_recording(files[1])
    assert held_out_from("0.2", [recording]) == 0.2
    numbered = replace(recording, blocks=[block[0] for block in recording.blocks])
    assert held_out_from("2", [numbered]) == ("2",)
    assert held_out_from("1, 2", [numbered]) == ("1", "2")
    assert held_out_from("25%", [numbered]) == 0.25


def test_choices_are_those_of_the_fit():
    from contarm_sim.cli import fit

    assert set(fit._LOSSES) == set(LOSSES)
    assert set(fit._METHODS) == set(METHODS)


def test_files_may_come_after_the_names(contarm, files):
    code, _, err = contarm("fit", "--free", "mass", "mas", *files)
    assert code == 2
    assert "parameter 'mas'" in err


def test_a_fit_that_is_stopped_is_kept_and_one_without_a_finding_says_so(contarm, files, fitted, monkeypatch, tmp_path):
    from contarm_sim import stopping
    from contarm_sim.identify import fit as fits
    from contarm_sim.identify.fit_folder import load_fit

    done = load_fit(fitted[1])
    lost = tuple(replace(one, status="not seen", value=float("nan")) for one in done.parameters)
    for change, number, code, said in (
        (
            {"converged": False, "message": "stopped early"},
            stopping.signal.SIGINT,
            130,
            "what was found so far is kept",
        ),
        ({"converged": False, "message": "too many steps"}, None, 1, "did not converge (too many steps)"),
        ({"parameters": lost}, None, 1, "determines none of the free parameters"),
    ):
        found = replace(done, **change)

        def stopped(*_, found=found, number=number, **__):
            stopping._state.number = number
            return found

        monkeypatch.setattr(fits, "fit", stopped)
        ended, out, err = contarm("fit", *files, "--free", "mass", "--out", said[:4].strip(), "--figures", "none")
        assert (ended, said in err) == (code, True), err
        assert "frame.x" in out
        assert (tmp_path / said[:4].strip() / "report.html").is_file()


def test_the_report_is_made_again_and_elsewhere(contarm, fitted, tmp_path, blank_figures):
    import shutil

    told, folder = fitted
    shutil.copytree(folder, tmp_path / "f")
    (tmp_path / "f" / "report.html").unlink()
    code, out, err = contarm("fit-report", "f")
    assert code == 0, err
    assert told["in_words"] in out
    assert {"report.html", "parameters.png", "paths.png", "history.png"} <= {p.name for p in (tmp_path / "f").iterdir()}
    code, out, err = contarm("fit-report", "f", "--out", "g", "--figures", "none", "--json")
    assert (code, json.loads(out)) == (0, told)
    assert {p.name for p in (tmp_path / "g").iterdir()} == {"report.html", "summary.json"}
    (tmp_path / "f" / "summary.json").unlink()
    assert contarm("fit-report", "f", "--figures", "none")[0] == 0
    again = json.loads((tmp_path / "f" / "summary.json").read_text())
    assert again["parameters"] == told["parameters"]
    (tmp_path / "f" / "fit.npz").write_bytes(b"PK")
    for given, said in (("f", "damaged"), ("g", "has no arm.toml"), ("h", "has no arm.toml")):
        code, out, err = contarm("fit-report", given)
        assert (code, out, err.count("\n")) == (2, "", 1), err
        assert said in err
