"""The folder of a sweep: what was asked, and a table in parts, one for each chunk of cases.

    sweep.toml                 the sweep as it is run, in full, and what it is made with
    parts/part-000012.parquet  the rows of one chunk: written whole, renamed into place, the same bytes whenever made

`pyarrow.dataset.dataset(folder / "parts")` is the table. Nothing in it depends on who ran what, or when.
"""

from __future__ import annotations

import fcntl
import io
import os
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from contarm_sim.errors import ContarmError, InputError, MissingError
from contarm_sim.files import appearing, remove_leftovers, write_whole
from contarm_sim.inputs import read_text
from contarm_sim.stopping import unbroken
from contarm_sim.sweeps.chunks import Row, chunk_count, chunk_size
from contarm_sim.sweeps.made_with import changed, device_of, made_with
from contarm_sim.sweeps.names import Parameter
from contarm_sim.sweeps.quantities import QUANTITIES
from contarm_sim.sweeps.reading import MADE, read
from contarm_sim.sweeps.spec import Spec
from contarm_sim.sweeps.written import as_toml

SAID = "sweep.toml"
"""The file that says what a sweep is."""

_LOCK = ".lock"

_DEVICE = b"device"
"""Metadata of parts whose numbers depend on the device that motions were stepped on."""


def require_pyarrow() -> None:
    """Refuse to go on without pyarrow.

    Raises:
        MissingError: says how to get it.
    """
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        raise MissingError("pyarrow", "sweep") from None


def schema(spec: Spec) -> Any:
    """Return the schema of a sweep's table; units and meanings are metadata of its fields."""
    import pyarrow as pa

    kinds = {"number": pa.float64(), "whole": pa.int64(), "text": pa.string(), "truth": pa.bool_()}

    def of_parameter(parameter: Parameter) -> Any:
        vector = parameter.kind == "vector"
        kind = pa.list_(pa.float64(), parameter.size) if vector else kinds[parameter.kind]
        return pa.field(parameter.name, kind, metadata={"role": "parameter", "unit": parameter.unit})

    fields = [pa.field("case", pa.int64(), nullable=False)]
    if spec.design == "sobol-indices":
        fields += [pa.field("point", pa.int64(), nullable=False), pa.field("matrix", pa.string(), nullable=False)]
    fields += map(of_parameter, spec.parameters())
    for name in spec.ask:
        one = QUANTITIES[spec.run][name]
        fields.append(
            pa.field(name, kinds[one.kind], metadata={"role": "quantity", "unit": one.unit, "meaning": one.meaning})
        )
    fields += [pa.field("status", pa.string(), nullable=False), pa.field("error", pa.string())]
    return pa.schema(fields, metadata={"sweep": spec.key})


def encoded(spec: Spec, rows: list[Row]) -> bytes:
    """Return the rows of a chunk as the content of a Parquet file."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    form, device, file = schema(spec), device_of(spec), io.BytesIO()
    if device:
        form = form.with_metadata({**form.metadata, _DEVICE: device})
    pq.write_table(pa.Table.from_pylist(rows, form), file, compression="zstd")
    return file.getvalue()


class Store:
    """A sweep's folder that this process alone writes into. `opened` makes one.

    Attributes:
        folder: where it is.
        spec: the sweep.
    """

    def __init__(self, folder: Path, spec: Spec) -> None:
        self.folder, self.spec = folder, spec
        self._size = chunk_size(spec)
        self._device: bytes | None = None

    def missing(self) -> list[int]:
        """Return the numbers of chunks that are not there yet, or not in full."""
        return [chunk for chunk in range(chunk_count(self.spec)) if not self._whole(chunk)]

    def keep(self, chunk: int, content: bytes) -> None:
        """Write the part of a chunk: it is there in full or not at all, whatever happens.

        Raises:
            OSError: it cannot be written.
            ContarmError: it was made on another device than parts that are there.
        """
        import pyarrow.parquet as pq

        device = pq.read_metadata(io.BytesIO(content)).metadata.get(_DEVICE)
        if device != (self._device or device):
            one, other = (each.decode() if each else "unknown" for each in (self._device, device))
            raise ContarmError(f"the table is made by {one}, and a part by {other}: their numbers differ")
        self._device = device
        with unbroken(), appearing(part_of(self.folder, chunk)) as scratch, open(scratch, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())

    def rows_of(self, chunk: int) -> int:
        """Return how many cases a chunk has."""
        return min(self._size, self.spec.cases - chunk * self._size)

    def _whole(self, chunk: int) -> bool:
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = part_of(self.folder, chunk)
        if not path.exists():
            return False
        try:
            found = pq.read_metadata(path)
            said, cases = found.metadata or {}, found.row_group(0).column(0).statistics
        except (pa.ArrowException, OSError, IndexError):  # a disk that lost what it was given
            return False
        first, count = chunk * self._size, self.rows_of(chunk)
        own = said.get(b"sweep") == self.spec.key.encode() and found.num_rows == count
        if not own or cases is None or (cases.min, cases.max) != (first, first + count - 1):
            return False
        self._device = said.get(_DEVICE)
        return True


def part_of(folder: Path, chunk: int) -> Path:
    """Return the file of a chunk."""
    return folder / "parts" / f"part-{chunk:06d}.parquet"


def parts_of(folder: Path) -> list[Path]:
    """Return the files of all chunks that are there, in order."""
    return sorted((folder / "parts").glob("part-*.parquet"))


@contextmanager
def opened(folder: Path, spec: Spec) -> Iterator[Store]:
    """Yield the folder of a sweep, new or begun before by the same sweep; nobody else may write into it meanwhile.

    Raises:
        InputError: another sweep is there, or something else; or somebody is writing into it.
        OSError: it cannot be written.
    """
    require_pyarrow()
    said, parts = folder / SAID, folder / "parts"
    if folder.exists() and not said.exists() and any(not entry.name.startswith(".") for entry in _entries(folder)):
        raise InputError("out", repr(str(folder)), "a new folder, or that of this sweep; it holds something else")
    made = _folders(folder)
    with _locked(folder):
        if said.exists() and _any_part(parts):
            _same(folder, spec)
        else:
            write_whole(said, _said(spec))
        parts.mkdir(exist_ok=True)
        remove_leftovers(folder)
        remove_leftovers(parts)
        try:
            yield Store(folder, spec)
        finally:
            if not _any_part(parts):
                _remove(folder, made)


def _folders(folder: Path) -> list[Path]:
    """Make a folder, and return what was made of it and of those above, innermost first."""
    made = [each for each in (folder, *folder.parents) if not os.path.lexists(each)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except (NotADirectoryError, FileExistsError):
        raise InputError("out", repr(str(folder)), "a folder; a file stands in its place") from None
    return made


def _any_part(parts: Path) -> bool:
    return any(parts.glob("part-*.parquet"))


def _remove(folder: Path, made: list[Path]) -> None:
    """Remove a sweep without any part, and the folders that were made for it."""
    with suppress(OSError):  # somebody put something there
        for each in (folder / SAID, folder / _LOCK):
            each.unlink(missing_ok=True)
        for each in (folder / "parts", *made):
            each.rmdir()


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        return list(os.scandir(folder))
    except OSError as error:
        raise InputError("out", repr(str(folder)), f"a folder that can be read ({error.strerror})") from error


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    descriptor = os.open(folder / _LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError("out", repr(str(folder)), "a folder that no other sweep is writing into") from None
        except OSError:  # a file system without locks
            pass
        yield
    finally:
        os.close(descriptor)


def kept(folder: Path) -> tuple[Spec, dict[str, str]]:
    """Return the sweep of a folder, and the versions that it is made with.

    Raises:
        InputError: there is none.
    """
    path = folder / SAID
    table = tomllib.loads(read_text(path, "the sweep.toml of a sweep's folder", 2**24))
    made = {key: str(value) for key, value in table.get(MADE, {}).items()}
    return read(table), made


def _said(spec: Spec) -> str:
    made = {"name": spec.name, "sweep": spec.key, "cases": spec.cases, "chunk": chunk_size(spec)}
    head = "# A sweep of contarm_sim: `contarm sweep` goes on with it, `contarm sweep-report` draws it.\n"
    return head + as_toml(spec, made | made_with())


def _same(folder: Path, spec: Spec) -> None:
    """Refuse a folder of another sweep, or of the same one made with other versions."""
    other, made = kept(folder)
    allowed = "another --out, or the folder without what is in it, or"
    if made.get("sweep") != spec.key:
        differs = list(_differing(spec.to_dict(), other.to_dict())) or ["how it is kept"]
        held = f"it holds the sweep {other.name!r} ({other.cases:,} cases of {other.run})"
        said = f"; what differs: {', '.join(differs)}" if len(differs) < 4 else ""
        raise InputError("out", repr(str(folder)), f"{allowed} the same sweep; {held}{said}")
    differing = changed(made, {**made_with(), "chunk": str(chunk_size(spec))})
    if differing:
        raise InputError("out", repr(str(folder)), f"{allowed} the versions it was begun with: {', '.join(differing)}")


def _differing(mine: Mapping[str, Any], theirs: Mapping[str, Any], front: str = "") -> Iterator[str]:
    """Yield the names of what differs."""
    for name in {**mine, **theirs}:
        one, other = mine.get(name), theirs.get(name)
        if isinstance(one, dict) and isinstance(other, dict) and front == "":
            yield from _differing(one, other, f"{name}.")
            if name == "vary" and list(one) != list(other) and one == other:
                yield "the order of [vary]"
        elif one != other:
            yield f"{front}{name}"
