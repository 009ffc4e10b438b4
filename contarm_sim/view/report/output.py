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
from contarm_sim.files import appearing, claim, remove_leftovers, scratch_name
from contarm_sim.stopping import unbroken


def default_folder(command: str) -> Path:
    """Return runs/<command>-<time>, a name not taken yet."""
    stem = Path("runs") / f"{command}-{time.strftime('%Y%m%d-%H%M%S')}"
    names = (stem if i == 0 else stem.with_name(f"{stem.name}-{i}") for i in range(1000))
    return next(name for name in names if not name.exists())


def check_output(target: Path) -> None:
    """Refuse an output path before work starts, and remove what killed processes left beside it.

    Raises:
        InputError: it exists, or nothing can be written there: this is tried.
    """
    try:
        taken = not target.name or target.exists() or target.is_symlink()
        parent = next((folder for folder in target.absolute().parents if folder.exists()), target)
        os.fsencode(target.name).decode()
    except (OSError, ValueError) as error:  # a name too long, say, or one that is not UTF-8
        reason = getattr(error, "strerror", None) or "a name that is not UTF-8, or has a null character"
        raise InputError("out", repr(str(target)), f"a path that can be written ({reason})") from error
    if taken:
        raise InputError("out", str(target) or "empty", "a path that does not exist yet")
    remove_leftovers(parent)
    trial = scratch_name(parent / "trial")
    try:
        with unbroken():
            trial.mkdir()
            trial.rmdir()
    except OSError as error:
        reason = f"{parent} cannot: {error.strerror}"
        raise InputError("out", str(target), f"a path that can be written ({reason})") from error


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
        self._claim = -1

    def __enter__(self) -> OutputFolder:
        try:
            with unbroken():
                self.target.parent.mkdir(parents=True, exist_ok=True)
                self.folder.mkdir()
                self._claim = os.open(self.folder, os.O_RDONLY | os.O_CLOEXEC)
                claim(self._claim)
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
                os.close(self._claim)
            except BaseException:
                self._remove()
                raise

    def _remove(self) -> None:
        with unbroken():
            if self._claim >= 0:
                os.close(self._claim)
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
        InputError: see `check_output`; another process has taken the name meanwhile.
        OSError: it cannot be written to the end: no space is left, say.
    """
    check_output(target)
    if not target.absolute().parent.is_dir():
        raise InputError("out", str(target), "a file in an existing folder")
    try:
        with appearing(target, new=True) as scratch:
            yield scratch
    except FileExistsError as error:
        allowed = "a path that does not exist yet: another process has written it meanwhile"
        raise InputError("out", str(target), allowed) from error


def to_json(document: Any) -> str:
    """Return strict JSON text (no NaN), arrays as lists."""
    return json.dumps(document, indent=2, default=_plain, allow_nan=False)


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{type(value).__name__} is not JSON")
