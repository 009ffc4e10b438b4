"""Chunks of a sweep as tasks of Dask: few in flight, streamed back as they are done, run again where workers die."""

from __future__ import annotations

import math
import os
import pickle
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any

from contarm_sim.errors import ContarmError, one_line
from contarm_sim.sweeps.chunks import SECONDS, chunk_size
from contarm_sim.sweeps.made_with import CODE
from contarm_sim.sweeps.on_worker import depends, portable, python_of, refuse_other
from contarm_sim.sweeps.run import AHEAD, Done, Runner
from contarm_sim.sweeps.spec import Spec

MOST = 64
"""Most chunks of a task: few are lost where the process that keeps the parts is killed."""

LOOK = 2.0
"""Time between looks at which workers there are [s]."""

PATIENCE = 10.0
"""Time after which it is said that no worker is there [s]."""

_PAUSE = 0.02

Say = Callable[[str], object]
"""What shows a line to people."""


def on_dask(client: Any, say: Say | None = None) -> Runner:
    """Return what runs the chunks of a sweep on a cluster: `sweep(spec, runner=on_dask(client))`.

    The parts are written here alone: workers need this package, but no folder of the sweep. Where workers die, Dask
    runs their tasks again, on others or on those that join. Chunks that end all workers that run them are tried once
    more alone, when all else is done.

    Args:
        client: a `distributed.Client`; it stays open.
        say: called with what people should know, such as that no worker is there; default: nothing is said.

    Raises:
        ContarmError: by the runner: workers have other versions; the scheduler is gone; chunks end their workers.
    """
    return lambda spec, chunks: _run(_Sent(client, spec, say or (lambda line: None)), list(chunks))


def _run(sent: _Sent, left: list[int]) -> Iterator[Done]:
    left.reverse()
    suspects: list[int] = []
    lost: list[int] = []
    try:
        sent.refuse_others()
        while left or sent.in_flight:
            while left and sent.in_flight < AHEAD * max(1, sent.workers()):
                count = sent.share(len(left))
                sent.submit([left.pop() for _ in range(count)])
            yield from sent.finished(suspects)
        for chunk in sorted(suspects):
            sent.submit([chunk])
            while sent.in_flight:
                yield from sent.finished(lost)
    finally:
        sent.cancel()
    if lost:
        said = ", ".join(sent.cases(chunk, chunk) for chunk in lost[:8]) + (" and more" if len(lost) > 8 else "")
        raise ContarmError(f"cases {said} ended every worker that ran them: killed, or out of memory")


class _Sent:
    """Tasks of a sweep that a cluster has."""

    def __init__(self, client: Any, spec: Spec, say: Say) -> None:
        from distributed import as_completed

        self._client, self._spec, self._say = client, spec, say
        self._content, self._task, self._versions = pickle.dumps(replace(spec)), portable(), depends()
        self._token, self._count = os.urandom(4).hex(), 0
        self._waiting: dict[str, tuple[Any, list[int]]] = {}
        self._ready = as_completed(with_results=True, raise_errors=False, loop=client.loop)
        self._seconds = SECONDS
        self._workers, self._looked, self._seen, self._told = 0, -math.inf, time.monotonic(), False

    @property
    def in_flight(self) -> int:
        """How many tasks are not done."""
        return len(self._waiting)

    def workers(self) -> int:
        """Return how many workers there are, as it was a moment ago; says once that there is none."""
        now = time.monotonic()
        if now - self._looked > LOOK:
            self._workers, self._looked = len(self._asked(self._client.nthreads)), now
            if self._workers:
                self._seen, self._told = now, False
            elif not self._told and now - self._seen > PATIENCE:
                self._say("no worker is there; the sweep waits for one to join")
                self._told = True
        return self._workers

    def refuse_others(self) -> None:
        """Wait for a worker; refuse those whose numbers would be other ones.

        Raises:
            ContarmError: says which, and what differs.
        """
        while not self.workers():
            time.sleep(_PAUSE)
        mine = {name: version for name, version in self._versions.items() if name != CODE}  # each task looks at that
        asked = [name for name in mine if name != "python"]
        found = self._asked(lambda: self._client.get_versions(packages=asked))["workers"]
        for address, each in found.items():
            theirs = each["packages"]
            refuse_other({**theirs, "python": python_of(theirs["python"])}, mine, f"the worker at {address}")

    def share(self, left: int) -> int:
        """Return how many chunks make a task of a few seconds, as those took that are done; fewer towards the end."""
        return max(1, min(int(SECONDS / self._seconds), MOST, left // (2 * AHEAD * max(1, self._workers))))

    def submit(self, chunks: list[int]) -> None:
        """Give chunks to the cluster as a task, named by its cases."""
        self._count += 1
        said = f"{self.cases(chunks[0], chunks[-1])} of {self._spec.cases}"
        key = f"sweep {self._spec.name}-cases {said}-{self._token}{self._count:x}"
        future = self._client.submit(self._task, self._content, tuple(chunks), self._versions, key=key, pure=False)
        self._waiting[key] = future, chunks
        self._ready.add(future)

    def cases(self, chunk: int, last: int) -> str:
        """Return the cases from one chunk to another in words."""
        first, end = chunk * chunk_size(self._spec), min((last + 1) * chunk_size(self._spec), self._spec.cases) - 1
        return f"{first}" if end == first else f"{first} to {end}"

    def finished(self, dead: list[int]) -> Iterator[Done]:
        """Yield chunks of tasks that are done meanwhile; those of tasks that ended their workers go to `dead`."""
        from distributed import CancelledError, KilledWorker

        self.workers()
        if not self._ready.has_ready():
            time.sleep(_PAUSE)
        for future, result in self._ready.next_batch(block=False):
            _, chunks = self._waiting.pop(future.key)
            if isinstance(result, CancelledError) or future.status not in ("finished", "error"):
                raise _gone()
            if future.status == "finished":
                seconds, done = result
                self._seconds = max(seconds / len(chunks), 1e-4)
                yield from done
            elif isinstance(result[1], KilledWorker):
                dead += chunks
            else:
                raise _said_of(result[1])

    def cancel(self) -> None:
        """Take back what is not done."""
        if self._waiting and self._client.status == "running":
            with suppress(OSError, RuntimeError, ValueError):  # the scheduler has just ended
                self._client.cancel([future for future, _ in self._waiting.values()], force=True)
        self._ready.clear()
        self._waiting.clear()

    def _asked(self, question: Callable[[], Any]) -> Any:
        try:
            return question()
        except (OSError, ValueError, RuntimeError) as error:
            raise _gone() from error


def _gone() -> ContarmError:
    return ContarmError("the Dask scheduler has ended, or cannot be reached any more")


def _said_of(error: BaseException) -> ContarmError:
    """Return what to say of an error of a worker."""
    if isinstance(error, ContarmError):
        return error
    if isinstance(error, ModuleNotFoundError) and str(error.name).startswith("contarm_sim"):
        return ContarmError("a worker that joined has no contarm_sim, or another version of it")
    return ContarmError(f"a worker failed: {type(error).__name__}: {one_line(str(error))}")
