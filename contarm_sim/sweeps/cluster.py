"""Where a sweep's tasks go: to a Dask scheduler that runs somewhere, or to a cluster of this machine."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import tempfile
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any

from contarm_sim.errors import ContarmError, InputError, MissingError, one_line
from contarm_sim.stopping import unbroken
from contarm_sim.sweeps.dask_tasks import Say, on_dask
from contarm_sim.sweeps.run import Done, Runner
from contarm_sim.sweeps.spec import Spec

TIMEOUT = 10.0
"""Longest time in which a scheduler answers [s]."""

DASHBOARD = 8787
"""The port of a dashboard here, if it is free."""

_ADDRESS = re.compile(r"([a-z]+://)?(\[[0-9a-fA-F:.]+\]|[^\s/:\[\]]+):\d{1,5}")

_ALLOWED = "the address of a Dask scheduler that runs, tcp://HOST:PORT, or the .json file that it wrote"

_LOUD = ("asyncio", "bokeh", "distributed", "tornado")

_IGNORE_CTRL_C = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
"""Said to workers here: Ctrl-C goes to all processes of a terminal, and the one that keeps the parts stops them."""


def on_scheduler(address: str, say: Say | None = None) -> Runner:
    """Return what runs the chunks of a sweep on the workers of a scheduler.

    Args:
        address: tcp://HOST:PORT, or the file that `dask scheduler --scheduler-file` wrote.
        say: called with the address of the dashboard, and what else people should know.

    Raises:
        InputError: no such address; by the runner: nobody answers there.
        MissingError: distributed is not installed.
    """
    _require()
    found = _in_file(Path(address)) if address.endswith(".json") else address
    if not _ADDRESS.fullmatch(found):
        raise InputError("scheduler", repr(address), _ALLOWED)
    return _runner(lambda chunks: _there(found), say)


def on_workers(count: int, say: Say | None = None) -> Runner:
    """Return what runs the chunks of a sweep on worker processes of this machine, with a dashboard.

    In a script, what calls `sweep` stands under `if __name__ == "__main__":`, for each worker reads the script again.

    Args:
        count: how many workers, if there are as many chunks.
        say: as `on_scheduler`.

    Raises:
        InputError: no such number.
        MissingError: distributed is not installed.
    """
    _require()
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= 4096:
        raise InputError("workers", count, "a whole number, at least 1")
    return _runner(lambda chunks: _cluster(min(count, chunks)), say)


def _in_file(path: Path) -> str:
    """Return the address in a scheduler's file; nothing where there is none."""
    try:
        return str(json.loads(path.read_text("utf-8"))["address"])
    except (OSError, ValueError, TypeError, KeyError):
        return ""


def _require() -> None:
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise MissingError("distributed", "cluster") from None


def _runner(opened: Callable[[int], AbstractContextManager[Any]], say: Say | None) -> Runner:
    def run(spec: Spec, chunks: Sequence[int]) -> Iterator[Done]:
        with opened(len(chunks)) as client:
            with suppress(OSError):  # it has just ended
                if say is not None and client.dashboard_link:
                    say(f"dashboard: {client.dashboard_link}")
            yield from on_dask(client, say)(spec, chunks)

    return run


@contextmanager
def _there(address: str) -> Iterator[Any]:
    """Yield a client of a scheduler, which answers in time."""
    from distributed.utils import LoopRunner

    with _quiet():
        try:
            LoopRunner().run_sync(_identity, address)
        except Exception as error:  # of a network, or of whatever else listens there
            raise InputError("scheduler", f"{address}, where no Dask scheduler answers", _ALLOWED) from error
        with _client(address) as client:
            yield client


async def _identity(address: str) -> None:
    from distributed import Security
    from distributed.core import rpc

    async with rpc(address, connection_args=Security().get_connection_args("client"), timeout=TIMEOUT) as scheduler:
        await asyncio.wait_for(scheduler.identity(), TIMEOUT)


@contextmanager
def _client(address: Any) -> Iterator[Any]:
    import dask
    from distributed import Client

    with dask.config.set({"distributed.comm.timeouts.connect": f"{TIMEOUT} s"}):
        client = Client(address, timeout=TIMEOUT, set_as_default=False, name="contarm-sweep")
        try:
            yield client
        finally:
            with unbroken():
                client.close(timeout=2)


@contextmanager
def _cluster(count: int) -> Iterator[Any]:
    import dask
    from distributed import LocalCluster

    with _quiet(), tempfile.TemporaryDirectory(prefix="contarm-", ignore_cleanup_errors=True) as folder:
        try:
            with unbroken(), dask.config.set({"temporary-directory": folder}):
                cluster = LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    host="127.0.0.1",
                    dashboard_address=f"127.0.0.1:{DASHBOARD}",
                    preload=[_IGNORE_CTRL_C],
                    silence_logs=logging.CRITICAL,
                )
        except Exception as error:
            raise ContarmError(f"no {count} workers can be started here: {one_line(str(error))}") from error
        try:
            with _client(cluster) as client:
                yield client
        finally:
            with unbroken():
                cluster.close(timeout=10)


@contextmanager
def _quiet() -> Iterator[None]:
    """Leave what is to be said to the sweep: lines in a log of a lost connection, say, and of a port that is taken."""
    names = [name for name in logging.root.manager.loggerDict if name.partition(".")[0] in _LOUD]
    loggers = [logging.getLogger(name) for name in names]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)
