"""Output folders and files, written whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.files import appearing, scratch_name
from contarm_sim.stopping import unbroken
from contarm_sim.versions import versions as versions


def default_folder(command: str) -> Path:
    """Return runs/<command>-<time>, a name not taken yet."""
    stem = Path("runs") / f"{command}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = (stem if i == 0 else stem.with_name(f"{stem.name}-{i}") for i in range(1000))
    return next(name for name in names if not name.exists())


def check_output(target: Path) -> None:
    """Refuse an output path before work starts.

    Raises:
        InputError: it exists, or its parent cannot be written.
    """
    try:
        taken = target.exists() or target.is_symlink()
    except OSError as error:  # a name too long, say
        raise InputError("out", f"{str(target)[:60]}...", f"a path that can be written ({error.strerror})") from error
    if taken:
        raise InputError("out", str(target), "a path that does not exist yet")
    parent = next(folder for folder in target.absolute().parents if folder.exists())
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise InputError("out", str(target), f"a path that can be written ({parent} cannot)")


class OutputFolder:
    """A scratch folder beside `target` that takes its name at the end; a context manager.

    On an exception, an interruption included, nothing is left. If the name was taken meanwhile (two runs in one
    second), the next free one, `target`-1, -2, ..., is taken instead: results are not thrown away for a name.

    Attributes:
        folder: the scratch folder, while open.
        target: where the results are, once closed.

    Call `check_output` before the work that fills it: here, a taken name is no reason to refuse any more.

    Raises:
        InputError: the folder cannot be made.
    """

    def __init__(self, target: Path) -> None:
        self.target, self.folder = target, scratch_name(target)
        self._made = [folder for folder in target.absolute().parents if not folder.exists()]

    def __enter__(self) -> OutputFolder:
        try:
            with unbroken():
                self.target.parent.mkdir(parents=True, exist_ok=True)
                self.folder.mkdir()
        except OSError as error:
            self._remove()
            raise InputError("out", str(self.target), f"a path that can be written ({error.strerror})") from error
        except BaseException:
            self._remove()
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        with unbroken():
            if kind is not None:
                self._remove()
                return
            try:
                self.target = self._take_name()
            except BaseException:
                self._remove()
                raise

    def _remove(self) -> None:
        with unbroken():
            shutil.rmtree(self.folder, ignore_errors=True)
            for folder in self._made:
                if folder.exists() and not any(folder.iterdir()):
                    folder.rmdir()

    def _take_name(self) -> Path:
        for i in range(1000):
            name = self.target if i == 0 else self.target.with_name(f"{self.target.name}-{i}")
            try:
                self.folder.rename(name)
            except OSError as error:
                if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
                    raise
            else:
                return name
        raise InputError("out", str(self.target), "a name that is not taken a thousand times")


@contextmanager
def output_file(target: Path) -> Iterator[Path]:
    """Yield a scratch path beside `target` that takes its name at the end; on an exception nothing is left.

    Raises:
        InputError: see `check_output`.
    """
    check_output(target)
    try:
        with appearing(target) as scratch:
            yield scratch
    except OSError as error:
        raise InputError("out", str(target), f"a path that can be written ({error.strerror})") from error


def to_json(document: Any) -> str:
    """Return strict JSON text (no NaN), arrays as lists."""
    return json.dumps(document, indent=2, default=_plain, allow_nan=False)


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{type(value).__name__} is not JSON")
