"""Output folders, written whole or not at all."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from contarm_sim.errors import InputError


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
    if target.exists() or target.is_symlink():
        raise InputError("out", str(target), "a path that does not exist yet")
    parent = next(folder for folder in target.absolute().parents if folder.exists())
    if not parent.is_dir() or not os.access(parent, os.W_OK | os.X_OK):
        raise InputError("out", str(target), f"a path that can be written ({parent} cannot)")


@contextmanager
def output_folder(target: Path) -> Iterator[Path]:
    """Yield a scratch folder beside `target` that takes its name at the end; on an exception nothing is left.

    Raises:
        InputError: see `check_output`.
    """
    check_output(target)
    made = _missing_parents(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    except OSError as error:
        raise InputError("out", str(target), f"a path that can be written ({error.strerror})") from error
    try:
        yield scratch
        scratch.chmod(0o777 & ~_umask())
        scratch.rename(target)
    except BaseException:
        shutil.rmtree(scratch, ignore_errors=True)
        for folder in made:
            if folder.exists() and not any(folder.iterdir()):
                folder.rmdir()
        raise


@contextmanager
def output_file(target: Path) -> Iterator[Path]:
    """Yield a scratch path beside `target` that takes its name at the end; on an exception nothing is left.

    Raises:
        InputError: see `check_output`.
    """
    check_output(target)
    scratch = target.with_name(f".{target.name}.part")
    try:
        yield scratch
        scratch.rename(target)
    except OSError as error:
        scratch.unlink(missing_ok=True)
        raise InputError("out", str(target), f"a path that can be written ({error.strerror})") from error
    except BaseException:
        scratch.unlink(missing_ok=True)
        raise


def _missing_parents(target: Path) -> list[Path]:
    return [folder for folder in target.absolute().parents if not folder.exists()]


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def to_json(document: Any) -> str:
    """Return strict JSON text (no NaN), arrays as lists."""
    return json.dumps(document, indent=2, default=_plain, allow_nan=False)


def _plain(value: Any) -> Any:
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{type(value).__name__} is not JSON")


def versions() -> dict[str, str]:
    """Return the versions that a number depends on."""
    import platform
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version(), "platform": platform.platform()}
    for package in ("contarm-sim", "mujoco", "numpy", "scipy", "matplotlib", "dm-control", "mediapy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
