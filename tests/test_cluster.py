"""The same sweep on Dask: a real scheduler and real workers on loopback, some of them killed."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from contarm_sim import ContarmError, InputError, sweeps
from contarm_sim.sweeps import cluster, dask_tasks

pytestmark = pytest.mark.slow  # by hand: all checks are to take less than ten minutes

pytest.importorskip("distributed")

SPEC = {
    "run": "equilibrium",
    "ask": ["tip_x", "tip_z"],
    "fixed": {"links": 4, "gravity.z": -9.81},
    "vary": {"bending_stiffness": [0.005, 0.05, 0.5], "load.force.x": [0, 0.1, 0.2, 0.3]},
}
"""As many chunks as cases: 12."""

TOML = """
run = "equilibrium"
ask = ["tip_x", "tip_z"]
[fixed]
links = 4
gravity.z = -9.81
[vary]
bending_stiffness = [0.005, 0.05, 0.5]
load.force.x = [0, 0.1, 0.2, 0.3]
"""

KILLER = """
import os
from contarm_sim.sweeps import on_worker
if not hasattr(on_worker, "real"):
    on_worker.real = on_worker.work
    on_worker.work = lambda spec, chunk: os._exit(1) if chunk == 5 else on_worker.real(spec, chunk)
"""


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return table_of(sweeps.sweep(SPEC, tmp_path_factory.mktemp("alone") / "table").folder)


def table_of(folder):
    return {part.name: part.read_bytes() for part in (Path(folder) / "parts").iterdir()}


def times_of(folder):
    return {part.name: part.stat().st_mtime_ns for part in (Path(folder) / "parts").iterdir()}


def free_port():
    with socket.socket() as tried:
        tried.bind(("127.0.0.1", 0))
        return tried.getsockname()[1]


def answers(port):
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0


def until(holds):
    end = time.monotonic() + 120
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.1)


class Processes:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.folder, self.started = folder, []
        port = free_port()
        self.address = f"tcp://127.0.0.1:{port}"
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", str(port))
        until(lambda: answers(port))

    def start(self, what, *arguments, **extra):
        program = [sys.executable, "-m", f"distributed.cli.dask_{what}", "--no-dashboard", *arguments]
        own = {"PYTHONPATH": os.pathsep.join(filter(None, [extra.get("path"), *sys.path]))}
        own |= {"DASK_TEMPORARY_DIRECTORY": str(self.folder), "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
        with open(self.folder / f"{what}{len(self.started)}.log", "wb") as log:
            self.started.append(
                subprocess.Popen(program, stdout=log, stderr=log, cwd=self.folder, env={**os.environ, **own})
            )
        return self.started[-1]

    def worker(self, *arguments, **extra):
        return self.start("worker", self.address, "--no-nanny", "--nthreads", "1", *arguments, **extra)

    def stop(self):
        for one in self.started:
            one.kill()
        for one in self.started:
            one.wait()


@pytest.fixture(scope="module")
def processes(tmp_path_factory):
    made = Processes(tmp_path_factory.mktemp("dask"))
    try:
        yield made
    finally:
        made.stop()


def test_a_cluster_makes_the_table_of_one_process_though_a_worker_is_killed(contarm, processes, alone, tmp_path):
    (tmp_path / "s.toml").write_text(TOML)
    victim, other = processes.worker(), processes.worker()
    done = []

    def on_done(count, of):
        """Stop a worker with what it has in hand, and kill it when nothing else is left to do."""
        done.append(count)
        if count == 1:
            victim.send_signal(signal.SIGSTOP)
        if count >= of - 2 * dask_tasks.AHEAD and victim.poll() is None:
            victim.kill()
            victim.wait()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(dask_tasks, "SECONDS", 1e-9)  # a chunk a task
        runner = sweeps.on_scheduler(processes.address)
        swept = sweeps.sweep(SPEC, tmp_path / "killed", on_done=on_done, runner=runner)
    assert victim.returncode == -signal.SIGKILL
    assert done == list(range(13))
    assert table_of(swept.folder) == alone
    assert other.poll() is None
    code, _, err = contarm("sweep", "s.toml", "--scheduler", processes.address)
    assert code == 0, err
    assert "dashboard: http://127.0.0.1:" in err
    assert table_of("runs/sweep-s") == alone
    assert [entry.name for entry in tmp_path.iterdir() if "dask" in entry.name] == []
    assert list(Path().rglob("MUJOCO_LOG.TXT")) == []


def test_a_scheduler_that_ends_or_is_not_there_is_one_line_and_the_sweep_goes_on_elsewhere(
    contarm, processes, alone, tmp_path, monkeypatch
):
    (tmp_path / "s.toml").write_text(TOML)

    def on_done(count, of):
        if count == 2:
            processes.scheduler.kill()
            processes.scheduler.wait()

    monkeypatch.setattr(dask_tasks, "SECONDS", 1e-9)  # a chunk a task
    with pytest.raises(ContarmError, match="the Dask scheduler has ended"):
        sweeps.sweep("s.toml", "runs/sweep-s", on_done=on_done, runner=sweeps.on_scheduler(processes.address))
    monkeypatch.setattr(cluster, "TIMEOUT", 0.5)
    code, out, err = contarm("sweep", "s.toml", "--scheduler", processes.address)
    assert (code, out) == (2, "")
    there, said = err.splitlines()
    assert "of 12 cases are there already" in there
    assert said.startswith(f"contarm: scheduler is {processes.address}, where no Dask scheduler answers; allowed: ")
    before = times_of("runs/sweep-s")
    assert 2 <= len(before) < 12
    code, out, err = contarm("sweep", "s.toml", "--processes", 1)
    assert code == 0
    assert table_of("runs/sweep-s") == alone
    assert (
        before.items() <= {part.name: part.stat().st_mtime_ns for part in Path("runs/sweep-s/parts").iterdir()}.items()
    )


def test_what_cannot_be_a_cluster_is_refused(contarm, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "TIMEOUT", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        said = sweeps.on_scheduler(f"127.0.0.1:{silent.getsockname()[1]}")
        with pytest.raises(InputError, match="where no Dask scheduler answers"):
            sweeps.sweep(SPEC, tmp_path / "table", runner=said)
    (tmp_path / "bad.json").write_text("{}")
    for address in (str(tmp_path / "bad.json"), "tcp://127.0.0.1", "nosuch.json", "host", "", "tcp://host:port"):
        with pytest.raises(InputError, match="tcp://HOST:PORT"):
            sweeps.on_scheduler(address)
    for count in (0, -1, 2.5, True, "2"):
        with pytest.raises(InputError, match="workers is"):
            sweeps.on_workers(count)
    code, out, err = contarm("sweep", "validity", "--workers", 2, "--scheduler", "tcp://127.0.0.1:8786")
    assert (code, out) == (2, "")
    assert "--workers is given beside --scheduler" in err


def test_distributed_may_be_missing(contarm, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code, out, err = contarm("sweep", "validity", "--workers", 2)
    assert (code, out) == (1, "")
    assert err == "contarm: distributed is not installed; get it with: pip install '.[cluster]'\n"


@pytest.mark.slow
def test_workers_with_other_versions_are_refused_before_any_case_is_run(processes_anew, tmp_path):
    (tmp_path / "fake" / "mujoco-9.9.dist-info").mkdir(parents=True)
    (tmp_path / "fake" / "mujoco-9.9.dist-info" / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: mujoco\nVersion: 9.9\n"
    )
    processes_anew.worker()
    runner = sweeps.on_scheduler(processes_anew.address)
    processes_anew.worker(path=str(tmp_path / "fake"))
    workers_are(processes_anew.address, 2)
    with pytest.raises(ContarmError, match=r"the worker at tcp://\S+ has other versions, .*: mujoco 9\.9 there, 3\.17"):
        sweeps.sweep(SPEC, tmp_path / "table", runner=runner)
    assert table_of(tmp_path / "table") == {}


@pytest.mark.slow
def test_cases_that_kill_their_workers_are_said_and_all_others_are_done(processes_anew, alone, tmp_path):
    killer = tmp_path / "killer.py"
    killer.write_text(KILLER)
    processes_anew.start("worker", processes_anew.address, "--nworkers", "2", "--nthreads", "1", "--preload", killer)
    with pytest.raises(ContarmError, match=r"^cases 5 ended every worker that ran them"):
        sweeps.sweep(SPEC, tmp_path / "table", runner=sweeps.on_scheduler(processes_anew.address))
    kept = table_of(tmp_path / "table")
    assert kept == {name: part for name, part in alone.items() if name != "part-000005.parquet"}


@pytest.mark.slow
def test_a_cluster_here_has_a_dashboard_and_ctrl_c_ends_all_of_it(alone, tmp_path):
    (tmp_path / "s.toml").write_text(TOML.replace("0.3]", f"{', '.join(map(str, range(3, 3000)))}]"))
    program = [sys.executable, "-m", "contarm_sim", "sweep", "s.toml", "--workers", "2"]
    own = {"PYTHONPATH": os.pathsep.join(sys.path), "TMPDIR": str(tmp_path / "temporary")}
    (tmp_path / "temporary").mkdir()
    done = subprocess.Popen(
        program, cwd=tmp_path, env={**os.environ, **own}, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        until(lambda: len(list((tmp_path / "runs").rglob("part-*"))) >= 2)
        os.killpg(done.pid, signal.SIGINT)
        _, err = done.communicate(timeout=60)
    finally:
        done.kill()
    assert done.returncode == 130
    assert err.startswith("dashboard: http://127.0.0.1:")
    assert err.count("\n") == 2 + err.count("left\n")
    assert "the same command goes on from there: runs/sweep-s" in err
    assert list((tmp_path / "temporary").iterdir()) == []
    until(lambda: not left_of(done.pid))


@pytest.fixture
def processes_anew(tmp_path):
    (tmp_path / "dask").mkdir()
    made = Processes(tmp_path / "dask")
    try:
        yield made
    finally:
        made.stop()


def left_of(group):
    """Return what runs of a process group."""
    found = subprocess.run(["ps", "-eo", "pgid,stat,cmd"], capture_output=True, text=True, check=True).stdout
    return [line for line in found.splitlines() if line.split()[0] == str(group) and line.split()[1][0] != "Z"]


def workers_are(address, count):
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=60)
