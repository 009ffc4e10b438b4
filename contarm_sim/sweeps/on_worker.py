"""What a Dask worker does for a sweep, and which workers may."""

from __future__ import annotations

import pickle
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from threading import Lock

from contarm_sim.errors import ContarmError, one_line
from contarm_sim.sweeps.made_with import changed, made_with
from contarm_sim.sweeps.run import Done, work
from contarm_sim.sweeps.spec import Spec

Versions = Mapping[str, str | None]

Task = Callable[[bytes, tuple[int, ...], Versions], tuple[float, list[Done]]]


def depends() -> dict[str, str]:
    """Return the versions that workers must have, by name: those that numbers depend on, and Python's."""
    made = {name: version for name, version in made_with().items() if name != "format"}
    return {"python": python_of(".".join(map(str, sys.version_info))), **made}


def python_of(version: str) -> str:
    """Return major and minor version of Python; tasks are understood by the same alone."""
    return ".".join(version.split(".")[:2])


def refuse_other(theirs: Versions, mine: Versions, who: str) -> None:
    """Refuse a worker whose numbers would be other ones.

    Raises:
        ContarmError: says what differs.
    """
    differing = changed(theirs, mine)
    if differing:
        raise ContarmError(f"{who} has other versions, so its numbers may differ: {', '.join(differing)}")


def portable() -> Task:
    """Return the function of tasks, sent by value: where this package is missing a task fails, and not the worker."""

    def task(content: bytes, chunks: tuple[int, ...], versions: Versions) -> tuple[float, list[Done]]:
        from contarm_sim.sweeps.on_worker import _run

        return _run(content, chunks, versions)

    return task


_one = Lock()
"""A worker runs one task at a time, whatever its threads."""


def _run(content: bytes, chunks: Iterable[int], versions: Versions) -> tuple[float, list[Done]]:
    """Run chunks; return the time that they took [s], and them."""
    refuse_other(depends(), versions, "a worker that joined")
    try:
        with _one:
            began = time.perf_counter()
            done = [work(_spec(content), chunk) for chunk in chunks]
            return time.perf_counter() - began, done
    except Exception as error:  # as one that survives the way back
        said = str(error) if isinstance(error, ContarmError) else f"{type(error).__name__}: {error}"
        raise ContarmError(f"a worker failed: {one_line(said)}") from None


@lru_cache(maxsize=2)
def _spec(content: bytes) -> Spec:
    """Return a sweep that came; what it found out about itself is kept from one task to the next."""
    found = pickle.loads(content)
    assert isinstance(found, Spec)
    return found
