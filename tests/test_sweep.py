"""Sweeps: the cases that a design says, what they tell, and a table that nothing makes another one."""

import errno
import hashlib
import json
import os
import subprocess
import sys
import tomllib
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from contarm_sim import Arm, InputError, Load, Reference, Wrench, compare, equilibrium, paths, simulate, studies, sweeps
from contarm_sim.cli import pace
from contarm_sim.errors import ContarmError
from contarm_sim.motion.time_step import Stepping
from contarm_sim.sweeps import chunks, run, store, together
from contarm_sim.sweeps.store import opened
from contarm_sim.sweeps.written import as_toml

SPEC = {
    "run": "equilibrium",
    "fixed": {"links": 4, "gravity.z": -9.81},
    "vary": {
        "bending_stiffness": {"from": 0.005, "to": 0.5, "count": 3, "scale": "log"},
        "load.force.x": [0, "0.1 N", 0.2, 0.3],
    },
}
"""Standing up; too soft an arm falls."""

TOML = """
run = "equilibrium"
[fixed]
links = 4
gravity.z = -9.81
[vary]
bending_stiffness = { from = 0.005, to = 0.5, count = 3, scale = "log" }
load.force.x = [0, "0.1 N", 0.2, 0.3]
"""


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    return sweeps.sweep(SPEC, tmp_path_factory.mktemp("sweep") / "alone")


def table_of(folder):
    """Return a hash of all parts, and their names."""
    parts = sorted((Path(folder) / "parts").iterdir())
    return hashlib.sha256(b"".join(part.read_bytes() for part in parts)).hexdigest(), [part.name for part in parts]


def test_every_case_is_what_it_would_be_alone(swept):
    assert len(swept) == swept.spec.cases == 12
    cases = list(product((0.005, 0.05, 0.5), (0.0, 0.1, 0.2, 0.3)))
    assert swept.column("bending_stiffness") == pytest.approx([case[0] for case in cases], rel=1e-12)
    tips, status = np.stack([swept.column(f"tip_{axis}") for axis in "xyz"], axis=-1), swept.column("status")
    for number, (stiffness, force) in enumerate(cases):
        arm = Arm(links=4, gravity=(0, 0, -9.81), bending_stiffness=float(swept.column("bending_stiffness")[number]))
        if status[number] == "ok":
            load = Load(wrenches=(Wrench(xi=1, force=(force, 0, 0)),) if force else ())
            assert (tips[number] == equilibrium(arm, load).tip).all(), (stiffness, force)
    assert (status == "ok").sum() >= 8
    assert status[0] == "no equilibrium"
    assert np.isnan(tips[0]).all()
    assert "no pose at rest" in swept.column("error")[0]
    known = 0.3 * 9.81 * 0.37**2 / 0.005  # of an arm without a pose too
    assert swept.column("own_weight_over_stiffness")[0] == pytest.approx(known)
    assert swept.unit("tip_x") == "m"
    assert swept.unit("load.force.x") == "N"


def test_workers_and_their_order_change_no_byte(swept, tmp_path):
    sweeps.sweep(SPEC, tmp_path / "workers", processes=2)
    backwards = sweeps.sweep(SPEC, tmp_path / "back", runner=lambda spec, chunks: map(_of(spec), reversed(chunks)))
    assert table_of(tmp_path / "workers") == table_of(tmp_path / "back") == table_of(swept.folder)
    assert backwards.counts == swept.counts


def _of(spec):
    return lambda chunk: run.work(spec, chunk)


DIES = """
import os, signal, sys
from contarm_sim import sweeps
count, sync = 0, os.fsync
def dies(descriptor):
    global count
    count += 1
    if count == 5:
        os.ftruncate(descriptor, 100)
        os.kill(os.getpid(), signal.SIGKILL)
    sync(descriptor)
os.fsync = dies
sweeps.sweep(sys.argv[1], sys.argv[2])
"""


def test_a_killed_sweep_goes_on_and_repeats_nothing(swept, tmp_path):
    spec, folder = tmp_path / "s.toml", tmp_path / "killed"
    spec.write_text(TOML)
    assert subprocess.run([sys.executable, "-c", DIES, spec, folder]).returncode == -9
    left = [entry for entry in (folder / "parts").iterdir() if entry.name.startswith(".")]
    assert len(left) == 1
    assert left[0].stat().st_size == 100
    os.utime(left[0], (1, 1))
    before = {part.name: part.stat().st_mtime_ns for part in (folder / "parts").glob("part-*")}
    seen = []
    sweeps.sweep(spec, folder, on_done=lambda done, of: seen.append(done))
    assert len(before) == 4
    assert seen == list(range(4, 13))
    assert before.items() <= {part.name: part.stat().st_mtime_ns for part in (folder / "parts").iterdir()}.items()
    assert table_of(folder) == table_of(swept.folder)


def test_a_part_that_a_disk_lost_is_made_again(swept, tmp_path):
    folder = sweeps.sweep(SPEC, tmp_path / "lost").folder
    (folder / "parts" / "part-000003.parquet").write_bytes(b"")
    sweeps.sweep(SPEC, folder)
    assert table_of(folder) == table_of(swept.folder)


def test_a_full_disk_and_ctrl_c_are_one_line_and_leave_nothing_half_written(contarm, tmp_path, monkeypatch, swept):
    (tmp_path / "s.toml").write_text(TOML)
    real, count, kind = os.fsync, 0, None

    def fails_at_the_third(descriptor):
        nonlocal count
        count += 1
        if count % 3 == 0:
            raise kind
        real(descriptor)

    monkeypatch.setattr(os, "fsync", fails_at_the_third)
    said = "2 of 12 cases are done; the same command goes on from there: runs/sweep-s\n"
    kind = OSError(errno.ENOSPC, "No space left on device")
    code, out, err = contarm("sweep", "s.toml", "--processes", 1)
    assert (code, out) == (1, "")
    assert err == f"contarm: cannot write: No space left on device; {said}"
    assert not list(Path("runs/sweep-s/parts").glob(".*"))
    kind = KeyboardInterrupt()
    code, out, err = contarm("sweep", "s.toml", "--processes", 1)
    assert code == 130
    assert err.endswith(f"contarm: interrupted; {said.replace('2', '4', 1)}")
    assert err.count("\n") == 2
    assert not list(Path("runs/sweep-s/parts").glob(".*"))
    monkeypatch.setattr(os, "fsync", real)
    code, out, err = contarm("sweep", "s.toml", "--processes", 1)
    assert code == 0
    assert "tip_x" in out
    assert f"{swept.counts['ok']} ok" in out
    assert table_of("runs/sweep-s") == table_of(swept.folder)


def test_a_folder_has_one_sweep_and_one_writer(tmp_path, swept):
    spec, other = sweeps.read(SPEC), sweeps.read(SPEC | {"fixed": {"links": 4, "gravity.z": 9.81}})
    with opened(tmp_path / "one", spec), pytest.raises(InputError, match="no other sweep is writing"):
        sweeps.sweep(spec, tmp_path / "one")
    assert not (tmp_path / "one").exists()  # nothing was done there
    with opened(tmp_path / "one", spec) as store:
        store.keep(*run.work(spec, 0))
    with pytest.raises(InputError, match=r"sweep 'sweep' \(12 cases of equilibrium\); what differs: fixed\.gravity\.z"):
        sweeps.sweep(other, tmp_path / "one")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="a file stands in its place"):
        sweeps.sweep(spec, tmp_path / "mine" / "letter.txt" / "x")
    with pytest.raises(InputError, match="holds something else"):
        sweeps.sweep(spec, tmp_path / "mine")
    said = (swept.folder / "sweep.toml").read_text()
    (tmp_path / "one" / "sweep.toml").write_text(said.replace('mujoco = "', 'mujoco = "2.'))
    with pytest.raises(InputError, match=r"the versions it was begun with: mujoco 2\."):
        sweeps.sweep(spec, tmp_path / "one")


VARY = {"vary": {"payload": [0, 0.1]}}
DRAWN = {"bending_stiffness": {"from": 0.1, "to": 1, "scale": "log"}, "links": {"from": 2, "to": 9}}
MANY = {name: {"from": 0.1, "to": 1, "count": 1000} for name in ("mass", "payload", "length", "bending_stiffness")}
NORMAL = {"distribution": "normal", "mean": "10 g", "std": "20 g"}
REFUSED = [
    ({"vary": {"bending_stifness": [1]}}, "did you mean 'bending_stiffness'"),
    ({"vary": {"load.force.x": [1]}}, "parameter 'load.force.x' is unknown"),
    ({"arm": "two", "vary": {"section_3.mass": [1]}}, "did you mean 'section_2.mass'"),
    ({"ask": ["tip_eror_max"], **VARY}, "did you mean 'tip_error_max'"),
    ({"vary": {}}, "empty or missing"),
    ({"vary": {"payload": {"from": 1, "to": 1, "count": 3}}}, "an empty range"),
    ({"vary": {"payload": {"from": 0, "to": 1}}}, "a range without count"),
    ({"design": "sobol", "vary": {"mass": {"distribution": "normal", "std": 0.1}}}, "mass.mean is missing"),
    ({"vary": {"mass": {"distribution": "normal", "mean": 1, "std": 0.1}}}, "mass is a distribution"),
    ({"fixed": {"payload": 0.1}, **VARY}, r"both in \[fixed\] and in \[vary\]"),
    ({"vary": {"gravity": [[0, 0, 1]], "gravity.z": [1]}}, "beside the vector"),
    ({"vary": MANY}, "number of cases is 1,000,000,000,000"),
    ({"design": "sobol", "cases": 10**12, **VARY}, "at most|from 1 to 10,000,000"),
    ({"design": "sobol-indices", "points": 100, **VARY}, "a power of two"),
    ({"cases": 5, **VARY}, "a grid has as many as its values make"),
    ({"vary": {"mass": [-1, 1]}}, "mass is -1"),
    ({"vary": {"links": [2.5]}}, "a whole number"),
    ({"vary": {"controller": ["srvo"]}}, "paper, chain"),
    ({"fixed": {"payload": "50 mm"}, "vary": {"mass": [1]}}, "payload is '50 mm'"),
    ({"fixed": {"grid": 2}, "vary": {"bend.angle": [1]}}, "beside one bend"),
    ({"run": "equilibrium", "fixed": {"load.tensions.1": 9}, "vary": {"bend.angle": [1]}}, "driven by bend and by"),
    ({"run": "motion", "vary": {"path.duration": [-1]}}, "duration is -1"),
    ({"rn": "rest", **VARY}, "did you mean 'run'"),
    ({"backend": "gpu", **VARY}, "cpu"),
    ({"vary": {"payload": {"from": 0, "to": 1, "count": 1}}}, "payload.count is 1"),
    ({"arm": "two", "ask": ["bend_within_1_percent"], **VARY}, "known of arms of one section"),
    ({"arm": "tendon", "ask": ["pressure_max"], **VARY}, "known of muscles that have pressure"),
    ({"run": "equilibrium", "ask": ["tip_error"], **VARY}, "known where a bend is asked for"),
    ({"design": "sobol-indices", "points": 2**23, **VARY}, "fewer points"),
    ({"vary": {"section_2.mass": [1]}}, "did you mean 'mass'. The arm has one section"),
    ({"vary": {"muscle.braid_friction": [1]}}, "without effect where nothing moves"),
    ({"arm": "tendon", "vary": {"muscle.friction_coefficient": [0.1]}}, "without effect where nothing moves"),
    ({"run": "motion", "vary": {"friction_moment": [0.1]}}, "unknown to simulated motions"),
    ({"run": "equilibrium", "arm": "tendon", "vary": {"load.pressures.1": [1e5]}}, "of muscles that have no pressure"),
    ({"design": "sobol", "vary": {"payload": NORMAL}}, "payload is -.*least and most cut a distribution off"),
    ({"design": "sobol", "vary": {"payload": NORMAL | {"mean": 0, "std": "5 %"}}}, "a number: the mean is 0"),
    ({"design": "sobol", "vary": {"payload": {"mean": 1, "std": "5 %"}}}, "payload.distribution is missing"),
    ("nosuch", "a TOML file, or one of soft, validity"),
]


@pytest.mark.parametrize(("spec", "said"), REFUSED, ids=[said for _, said in REFUSED])
def test_what_makes_no_sense_is_refused_before_anything_runs(spec, said):
    with pytest.raises(InputError, match=said) as refused:
        sweeps.read(spec)
    assert "\n" not in str(refused.value)


def test_designs_are_the_same_in_any_pieces():
    for design, count in (("sobol", 64), ("latin-hypercube", 64), ("sobol-indices", 16)):
        drawn = {"points" if design == "sobol-indices" else "cases": count}
        spec = sweeps.read({"design": design, "seed": 3, "vary": DRAWN, **drawn})
        assert spec.cases == 64
        whole = spec.values(0, 64)
        assert whole == [case for first in (0, 5, 37) for case in spec.values(first, {0: 5, 5: 37, 37: 64}[first])]
        assert sweeps.read(spec.to_dict()).values(0, 64) == whole
        assert {type(case["links"]) for case in whole} == {int}
        shares = np.log10([case["bending_stiffness"] for case in whole]) + 1
        if design == "latin-hypercube":  # one in each of 64 strata
            assert sorted((64 * shares).astype(int)) == list(range(64))
    for a, b, one, other in zip(*(whole[k::4] for k in range(4)), strict=True):
        assert one == a | {"bending_stiffness": b["bending_stiffness"]}
        assert other == a | {"links": b["links"]}


def test_a_kept_sweep_reads_back_in_full(swept, tmp_path):
    (tmp_path / "s.toml").write_text(TOML)
    asked, kept = sweeps.read(tmp_path / "s.toml"), sweeps.read(swept.folder / "sweep.toml")
    assert asked.key == kept.key == swept.spec.key == sweeps.load(swept.folder).spec.key
    assert asked.key != sweeps.read(SPEC | {"ask": ["tip_x"]}).key
    for arm in ("two", "three", "tendon"):
        spec = sweeps.read({"arm": arm, "vary": {"section_2.mass": [0.1], "gravity": [[0, 0, 1], [1, 0, 0]]}})
        assert sweeps.read(tomllib.loads(as_toml(spec, {}))).key == spec.key
    assert sweeps.read("validity").cases > 100


def test_help_shows_a_sweep_that_can_be_pasted(contarm, tmp_path):
    _, help_text, _ = contarm("sweep", "--help")
    first, last = help_text.index('run = "rest"'), help_text.index("# mass = ")
    (tmp_path / "pasted.toml").write_text(help_text[first:last])
    assert sweeps.read(tmp_path / "pasted.toml").key == sweeps.read("soft").key
    code, out, _ = contarm("sweep", "pasted.toml", "--names", "--json")
    assert code == 0
    told = json.loads(out)
    assert told["parameters"]["muscle.wall"]["unit"] == "m"
    assert "damping_time" not in told["parameters"]
    assert "sag_max_percent" in told["quantities"]
    code, out, _ = contarm("sweep", "pasted.toml", "--names")
    assert code == 0
    assert {"muscle.wall", "controller", "sag_max_percent"} <= set(out.split())


def test_poses_at_rest_agree_with_validate(tmp_path):
    spec = {"fixed": {"links": 4, "grid": 2, "gravity.z": 9.81, "bending_stiffness": 0.3}, "vary": {"payload": [0.05]}}
    found = sweeps.sweep(spec, tmp_path / "rest")
    arm = Arm(links=4, bending_stiffness=0.3, gravity=(0, 0, 9.81), payload=0.05)
    outcome = studies.validate(arm, 2, max_bend=np.radians(120)).outcomes["payload"]
    for name in ("tip_error", "discretisation", "servo", "shape"):
        assert found.column(f"{name}_max_percent") == [getattr(outcome.errors, name).max_percent]
    assert found.column("sag_max") == [outcome.rod.sag.max_m]
    assert found.column("weight_over_stiffness") == [outcome.setting.weight_over_stiffness]
    assert found.column("tension_max") == [outcome.errors.muscle.max_force_n]


@pytest.fixture
def in_one_chunk(monkeypatch):
    monkeypatch.setattr(chunks, "AT_LEAST", 1)


MOTION = {"links": 3, "path.name": "circle", "path.duration": 0.3, "path.max_bend": 0.4, "timestep": 0.01}


def test_a_motion_tells_what_a_run_does_to_the_bit(tmp_path, in_one_chunk):
    spec = sweeps.read({"run": "motion", "fixed": MOTION, "vary": {"payload": [0, 0.02, 0.05]}})
    assert chunks.chunk_size(spec) == 3
    found = sweeps.sweep(spec, tmp_path / "m")
    assert found.counts == {"ok": 3}
    for row, payload in enumerate((0, 0.02, 0.05)):
        arm = Arm(links=3, payload=payload)
        path = paths.named("circle", arm.length, duration=0.3, max_bend=0.4)
        alone = simulate(arm, Reference.from_path(path, arm), "servo", stepping=Stepping(0.01))
        assert found.column("tip_error_max")[row] == compare(alone).tip_error.max()
        assert found.column("target_error_max")[row] == compare(alone).target_error.max()
        assert found.column("tension_max")[row] == alone.muscle_tensions.max()
        assert found.column("explained")[row] == studies.judge_run(alone).judged.explained
    assert not found.column("explained").any()
    assert found.short["explained"] == 3
    assert len(set(found.column("tip_error_max"))) == 3


ENDS = {
    "unstable": ("equilibrium", {"links": 4}, {"load.follower_moment.z": [2]}),
    "not converged": ("equilibrium", {"links": 4, "gravity.z": 9.81}, {"load.follower_moment.z": [8]}),
    "diverged": ("motion", MOTION, {"mass": [1e-9]}),
    "too much pressure": ("rest", {"links": 3, "controller": "pressure"}, {"bend.angle": [2.9]}),
}


def test_each_way_to_end_has_its_word():
    for status, (kind, fixed, vary) in ENDS.items():
        (row,) = chunks.rows(sweeps.read({"run": kind, "fixed": fixed, "vary": vary}), 0)
        assert row["status"] == status
        assert row["error"]
        if status == "unstable":  # it has its pose, and a report leaves it out
            assert (row["tip_z"], row["stable"]) == (pytest.approx(0.37), False)
        else:
            assert row.get("tip_z") is None


def test_poses_that_would_not_stay_are_in_the_table_and_in_no_statistics(tmp_path):
    ask = ["tip_z", "stable", "payload_over_mass"]
    spec = {"run": "equilibrium", "ask": ask, "fixed": {"links": 4}, "vary": {"load.follower_moment.z": [0, 2]}}
    found = sweeps.sweep(spec, tmp_path / "u")
    assert found.counts == {"ok": 1, "unstable": 1}
    assert np.isfinite(found.column("tip_z")).all()
    assert np.isfinite(found.values("tip_z")).tolist() == [True, False]
    assert found.values("stable").tolist() == [1, 0]
    assert found.middle("payload_over_mass")[0] == 2


def test_what_fails_as_a_whole_is_said_of_its_own_case(in_one_chunk, monkeypatch, contarm, tmp_path):
    spec = sweeps.read({"run": "motion", "fixed": MOTION, "vary": {"payload": [0, 0.02, 0.05]}})
    good, real, fault = chunks.rows(spec, 0), together.simulate_many, np.linalg.LinAlgError("Singular matrix")

    def fails_with_the_second(arms, *given, **options):
        if any(arm.payload == 0.02 for arm in arms):
            raise fault
        return real(arms, *given, **options)

    monkeypatch.setattr(together, "simulate_many", fails_with_the_second)
    first, second, third = chunks.rows(spec, 0)
    assert (first, third) == (good[0], good[2])
    assert (second["status"], second["error"]) == ("failed", "LinAlgError: Singular matrix")
    (tmp_path / "s.toml").write_text(as_toml(spec, {}))
    for fault in (MemoryError("full"), OSError(errno.EIO, "lost"), TypeError("a mistake")):
        code, _, err = contarm("sweep", "s.toml", "--processes", 1)
        assert (code, err.count("\n")) == (1, 1)
        assert err.startswith(f"contarm: case 1: {type(fault).__name__}: ")
    assert not list(Path("runs").rglob("*.parquet"))


def test_a_part_of_another_chunk_or_sweep_is_made_again_and_other_chunks_and_code_are_refused(swept, tmp_path):
    folder = sweeps.sweep(SPEC, tmp_path / "mixed").folder
    parts = folder / "parts"
    (parts / "part-000003.parquet").write_bytes((parts / "part-000004.parquet").read_bytes())
    other = sweeps.sweep(SPEC | {"fixed": {"links": 4, "gravity.z": 9.81}}, tmp_path / "other").folder
    (parts / "part-000005.parquet").write_bytes((other / "parts" / "part-000005.parquet").read_bytes())
    assert len(sweeps.load(folder)) == 12
    done = []
    sweeps.sweep(SPEC, folder, on_done=lambda count, of: done.append(count))
    assert done == [10, 11, 12]
    assert table_of(folder) == table_of(swept.folder)
    said = (folder / "sweep.toml").read_text()
    for line, changed, why in (
        ("chunk = 1\n", "chunk = 2\n", "chunk 2 there, 1 here"),
        ('code = "', 'code = "x', "the code of contarm-sim has changed"),
    ):
        assert line in said
        (folder / "sweep.toml").write_text(said.replace(line, changed))
        with pytest.raises(InputError, match=f"the versions it was begun with: {why}$"):
            sweeps.sweep(SPEC, folder)


def test_parts_of_another_device_are_refused(tmp_path, monkeypatch):
    spec, device = sweeps.read({"run": "motion", "backend": "warp", "fixed": MOTION, "vary": {"payload": [0]}}), "one"
    row = {"case": 0, "payload": 0.0, "status": "ok"}
    monkeypatch.setattr(store, "device_of", lambda spec: device)
    with opened(tmp_path / "w", spec) as kept:
        kept.keep(0, store.encoded(spec, [row]))
    with opened(tmp_path / "w", spec) as kept:
        assert kept.missing() == []
        device = "another"
        with pytest.raises(ContarmError, match="the table is made by one, and a part by another"):
            kept.keep(0, store.encoded(spec, [row]))


def test_the_time_left_is_told_when_models_are_made(monkeypatch):
    now = 0.0
    monkeypatch.setattr(pace.time, "monotonic", lambda: now)
    said = pace._Said()
    assert said(40, 100) == "40 of 100 cases"
    now = 20.0  # the first chunk makes the models
    assert said(50, 100) == "50 of 100 cases"
    now = 25.0
    assert said(60, 100) == "60 of 100 cases, 2 a second, 20 s left"
