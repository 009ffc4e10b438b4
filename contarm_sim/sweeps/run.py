"""Run a sweep: chunks of cases by worker processes, each part kept as soon as it is there."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from contarm_sim.errors import ContarmError, InputError, MissingError
from contarm_sim.inputs import as_path
from contarm_sim.stopping import unbroken
from contarm_sim.sweeps.chunks import rows
from contarm_sim.sweeps.reading import read
from contarm_sim.sweeps.spec import Spec
from contarm_sim.sweeps.store import encoded, opened
from contarm_sim.sweeps.table import Sweep, load

Done = tuple[int, bytes]
"""The number of a chunk, and the content of its part."""

Runner = Callable[[Spec, Sequence[int]], Iterator[Done]]
"""What runs chunks somewhere, and yields them in any order as they are done, few at a time."""

MOST_PROCESSES = 4096

AHEAD = 2
"""Chunks that wait at each process."""

WATCH = 0.5
"""Time after which a worker has seen that its parent was killed [s]."""

_THREADS = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}


def sweep(
    given: str | PathLike[str] | Mapping[str, Any] | Spec,
    out: str | PathLike[str] | None = None,
    processes: int | None = 1,
    on_done: Callable[[int, int], object] | None = None,
    runner: Runner | None = None,
) -> Sweep:
    """Run the cases of a sweep that are not done yet, and return the table.

    Ctrl-C, a full disk or SIGKILL lose the chunks that are being run; the same call goes on from there. The same sweep
    gives the same table, bit for bit, however it was run and interrupted.

    Args:
        given: what `sweeps.read` takes: a TOML file, a dict, or the name of a sweep that comes with the package.
        out: its folder; default runs/sweep-NAME.
        processes: worker processes; 1: this process; None: one for each core.
        on_done: called with the number of cases that are done and of all of them, first before any is run.
        runner: what runs chunks, in place of processes here.

    Raises:
        InputError: a sweep that cannot be, or a folder that is another's.
        OSError: a part cannot be written; those that are there are whole.
        MissingError: pyarrow or loky is not installed.
    """
    spec = read(given)
    folder = default_folder(spec) if out is None else as_path("out", out, "a folder")
    run = runner or (in_this_process if processes == 1 else _local(processes))
    with opened(folder, spec) as store:
        missing = store.missing()
        done = spec.cases - sum(map(store.rows_of, missing))
        if on_done is not None:
            on_done(done, spec.cases)
        chunks = run(spec, missing)
        try:
            for chunk, content in chunks if missing else ():
                store.keep(chunk, content)
                done += store.rows_of(chunk)
                if on_done is not None:
                    on_done(done, spec.cases)
        finally:
            close = getattr(chunks, "close", None)
            if close is not None:
                close()
    return load(folder)


def default_folder(spec: Spec) -> Path:
    """Return the folder of a sweep unless another is asked for."""
    return Path("runs") / f"sweep-{spec.name}"


def work(spec: Spec, chunk: int) -> Done:
    """Run a chunk; return its number and the content of its part."""
    return chunk, encoded(spec, rows(spec, chunk))


def in_this_process(spec: Spec, chunks: Iterable[int]) -> Iterator[Done]:
    """Run chunks one after the other."""
    return (work(spec, chunk) for chunk in chunks)


def _local(processes: int | None) -> Runner:
    if processes is not None and (
        isinstance(processes, bool) or not isinstance(processes, int) or not 1 <= processes <= MOST_PROCESSES
    ):
        raise InputError("processes", processes, f"a whole number from 1 to {MOST_PROCESSES}")
    return lambda spec, chunks: by_processes(spec, chunks, processes)


def by_processes(spec: Spec, chunks: Sequence[int], processes: int | None = None) -> Iterator[Done]:
    """Run chunks in worker processes of this machine; a few wait at each, so that memory stays as it is.

    Args:
        processes: at most so many; default one for each core.

    Raises:
        ContarmError: a worker was killed.
    """
    try:
        import loky
    except ImportError:
        raise MissingError("loky", "sweep") from None
    processes = min(processes or loky.cpu_count(), len(chunks))
    if processes < 2:
        yield from in_this_process(spec, chunks)
        return
    from concurrent.futures import FIRST_COMPLETED, Future, wait

    waiting: set[Future[Done]] = set()
    left = iter(chunks)
    with unbroken():
        pool = loky.ProcessPoolExecutor(processes, initializer=_begin, initargs=(os.getpid(),), env=_THREADS)
    try:
        while True:
            while len(waiting) < AHEAD * processes and (chunk := next(left, None)) is not None:
                waiting.add(pool.submit(work, spec, chunk))
            if not waiting:
                break
            finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for each in finished:
                yield each.result()
    except loky.BrokenProcessPool as error:
        raise ContarmError("a worker process ended: killed, or out of memory; fewer --processes may help") from error
    finally:
        with unbroken():
            pool.shutdown(wait=True, kill_workers=True)


def _begin(parent: int) -> None:
    """Leave Ctrl-C to the process that keeps the parts, and end when it does: loky's workers would wait for ever."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(WATCH)
    os._exit(1)
