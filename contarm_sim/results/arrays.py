"""Recorded arrays, read from an .npz and checked once: what they are, their shapes, their numbers, and whose they are.

Shapes and kinds stand in the headers of the arrays: they are checked before the arrays themselves are read, so that a
damaged or made-up file cannot ask for more memory than a recording has.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.inputs import read_bytes
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import count
from contarm_sim.model.arm import Arm
from contarm_sim.model.section import MAX_LINKS

RECORDING = "a trajectory.npz of contarm run"

MOST_BYTES = 8 * 2**30
"""Largest file that is read [bytes]; the longest recording of the longest arm has 6 GB."""

MOST_SAMPLES = 10**6

_BROKEN = (OSError, EOFError, ValueError, TypeError, RuntimeError, MemoryError, KeyError, SyntaxError, IndexError,
           NotImplementedError, OverflowError, zipfile.BadZipFile, zlib.error, struct.error)  # fmt: skip
"""What a file that is no .npz, or a damaged one, makes zipfile and NumPy raise; ValueError also: it holds a pickle."""

Shape = tuple[int | str, ...]
"""A shape whose words are sizes that all arrays share, ("T", 3)."""

SHAPES: dict[str, Shape] = {
    "time": ("T",), "target": ("T", 3), "bend": ("T", "B"), "setpoint": ("T", "M"), "muscle_lengths": ("T", "M"),
    "muscle_tensions": ("T", "M"), "pressure": ("T", "M"), "stations": ("T", "S", 3), "tip_rotation": ("T", 3, 3),
    "qpos": ("T", "D"), "direction": ("T", 3), "step_error": ("T",), "objects": ("T", "F", 7),
    "base": ("T", 7), "host": ("T", "H"),
}  # fmt: skip
"""Shapes of the arrays: T samples, B bend coordinates, M muscles, S stations, D joint angles, F free objects,
H positions of a host."""

_MOST = {"T": MOST_SAMPLES, "B": 12, "S": MAX_LINKS + 1, "D": 3 * MAX_LINKS, "M": 100, "F": 32, "C": 10**8, "H": 10**4}
"""Largest sizes: samples T, bend coordinates B, stations S, degrees of freedom D, muscles M, free objects F,
contacts C, positions H of a host."""

_KNOWN = {"pressure": "or inf", "step_error": "inf or nan"}
"""What arrays may hold besides finite numbers."""


def read_arrays(
    path: str | Path, shapes: Mapping[str, Shape], optional: tuple[str, ...] = (), words: str = "about"
) -> tuple[dict[str, Array], str | None]:
    """Return (arrays of an .npz by name, as floats; the text that it holds beside them, or None).

    Args:
        shapes: the arrays that there must be, and their shapes.
        optional: names of arrays that there need not be.
        words: the name of the text.

    Raises:
        InputError: not such a file; a missing array, one of another shape, not of real numbers, or not finite: names
            the file and the array.
    """
    where = str(path)
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(path, RECORDING, MOST_BYTES))) as archive:
            stored = {name.removesuffix(".npy"): name for name in archive.namelist()}
            for name in stored:
                if name not in (*shapes, words):
                    raise InputError("file", f"one with an unknown array {name!r}", RECORDING, where)
            wanted = [name for name in shapes if name in stored or name not in optional]
            for name in wanted:
                if name not in stored:
                    raise InputError("file", f"one without the array {name!r}", RECORDING, where)
            check_shapes({name: _header(archive, stored[name], name, where) for name in wanted}, shapes, where)
            arrays = {name: _array(archive, stored[name]).astype(float) for name in wanted}
            text = str(_array(archive, stored[words])) if words in stored else None
    except InputError:
        raise
    except _BROKEN as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise InputError("file", f"unreadable ({said})", RECORDING, where) from error
    for name, array in arrays.items():
        _refuse_bad_numbers(name, array, where)
    return arrays, text


def _array(archive: zipfile.ZipFile, member: str) -> Array:
    if archive.getinfo(member).file_size > MOST_BYTES:
        raise ValueError(f"{member} is larger than any recording")
    with archive.open(member) as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _header(archive: zipfile.ZipFile, member: str, name: str, where: str) -> tuple[int, ...]:
    """Return the shape of a stored array.

    Raises:
        InputError: it does not hold real numbers.
    """
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        if version not in ((1, 0), (2, 0)):
            raise ValueError(f"{name} is stored in version {version} of the format")
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, kind = read(file)
    if kind.kind not in "fiu":
        raise InputError(name, f"an array of {kind}", "an array of real numbers", where)
    return tuple(shape)


def check_shapes(found: Mapping[str, tuple[int, ...]], shapes: Mapping[str, Shape], where: str) -> None:
    """Refuse arrays of other shapes, or whose sizes do not fit together.

    Raises:
        InputError: names the array.
    """
    sizes: dict[str, tuple[int, str]] = {}
    for name, shape in found.items():
        wanted = shapes[name]
        said = f"({', '.join(map(str, wanted))}{',' if len(wanted) == 1 else ''})"
        if len(shape) != len(wanted) or any(isinstance(w, int) and w != n for w, n in zip(wanted, shape, strict=True)):
            raise InputError(name, f"of shape {shape}", f"an array of shape {said}", where)
        for word, size in zip(wanted, shape, strict=True):
            if isinstance(word, int):
                continue
            known, first = sizes.setdefault(word, (size, name))
            if size != known:
                raise InputError(
                    name, f"of shape {shape}", f"shape {said} with {word} = {known}, as {first} has", where
                )
            if not (word != "C") <= size <= _MOST.get(word, MOST_SAMPLES):
                raise InputError(name, f"of shape {shape}", f"1 to {_MOST.get(word, MOST_SAMPLES)} {word}", where)


def _refuse_bad_numbers(name: str, array: Array, where: str) -> None:
    also = _KNOWN.get(name)
    fine = np.isfinite(array) | ((array == np.inf) & (also is not None)) | (np.isnan(array) & (also == "inf or nan"))
    if not fine.all():
        place = tuple(int(i) for i in np.argwhere(~fine)[0])
        allowed = "finite numbers" + (f", {also}" if also else "")
        raise InputError(name, f"{array[place]} in sample {place[0]}", allowed, where)


def require_arms_own(arm: Arm, arrays: Mapping[str, Array], where: str) -> None:
    """Refuse arrays that another arm recorded: another number of links, or links of another length.

    Args:
        arrays: `time`, `stations`, `qpos` and `tip_rotation`, as `Trajectory` describes them.

    Raises:
        InputError: names the array; also where times do not rise, or orientations are none.
    """
    time, stations, qpos = arrays["time"], arrays["stations"], arrays["qpos"]
    if time.any() and not (time[0] >= 0 and (np.diff(time) > 0).all()):
        raise InputError("time", "not rising", "times that rise from 0, or zeros for poses at rest", where)
    require_sizes_of(arm, arrays, where)
    turned = np.abs(np.einsum("tji,tjk->tik", *[arrays["tip_rotation"]] * 2) - np.eye(3)).max(axis=(1, 2)) > 1e-6
    if turned.any():
        raise InputError("tip_rotation", f"no rotation in sample {int(turned.argmax())}", "rotation matrices", where)
    found, wanted, slack = _pitches(arm, stations, qpos)
    off = np.abs(found - wanted) > wanted * slack
    if off.any():
        sample, link = (int(i) for i in np.argwhere(off)[0])
        given = f"of links of {found[sample, link]:.6g} m in sample {sample}"
        raise InputError("stations", given, f"links of {wanted[link]:.6g} m, as its arm has them", where)


def _hinges(arm: Arm) -> NDArray[np.intp]:
    """Return the number of hinges of each joint, shape (links,)."""
    each = [2 if section.torsional_stiffness is None else 3 for section in arm.sections]
    return np.repeat(each, [section.links for section in arm.sections])


def _pitches(arm: Arm, stations: Array, qpos: Array) -> tuple[Array, Array, Array]:
    """Return link pitches [m], shape (T, links), as recorded; those of the arm, (links,); and what they may be off.

    Neighbouring stations lie h cos(theta/2) apart; theta is what the joint between them bends, of its hinges a and b.
    """
    hinges = _hinges(arm)
    first = np.cumsum(hinges) - hinges
    order = np.concatenate([np.arange(s.links) % 4 for s in arm.sections])  # three hinges: xyz, zyx, zyx, xyz
    one = first + np.where((hinges == 3) & np.isin(order, (1, 2)), 2, 0)
    cosine = np.cos(qpos[:, one]) * np.cos(qpos[:, first + 1])
    square = np.square(np.arccos(np.clip(cosine, -1, 1)))
    found = np.linalg.norm(np.diff(stations, axis=1), axis=-1) / np.cos(0.5 * np.sqrt(square))
    wanted = np.repeat([s.link_pitch for s in arm.sections], [s.links for s in arm.sections])
    return found, wanted, 1e-5 + square.max(axis=1, keepdims=True) / 6  # extrapolated ones are off by a twelfth of it


def require_sizes_of(arm: Arm, arrays: Mapping[str, Array], where: str) -> None:
    """Refuse arrays of other shapes, or of another number of links, joint angles or muscles than an arm has.

    Raises:
        InputError: names the array.
    """
    check_shapes({name: array.shape for name, array in arrays.items() if name in SHAPES}, SHAPES, where)
    wanted = {
        "stations": (arm.links, "links", 1), "qpos": (int(_hinges(arm).sum()), "joint angles", 0),
        "setpoint": (count(arm), "muscles", 0),
        "bend": (2 * len(arm.sections), "bend coordinates", 0),
    }  # fmt: skip
    for name, (size, what, more) in wanted.items():
        found = arrays[name].shape[1] - more
        if found != size:
            raise InputError(name, f"of {found} {what}", f"those of {size} {what}, as its arm has", where)


def require_links_of(arm: Arm, arrays: Mapping[str, Array], where: str) -> None:
    """Refuse arrays that cannot be of an arm: of other sizes, or of links of another length in the first sample.

    Raises:
        InputError: names the array.
    """
    require_sizes_of(arm, arrays, where)
    for name, array in arrays.items():
        _refuse_bad_numbers(name, array, where)
    found, wanted, slack = _pitches(arm, arrays["stations"][:1], arrays["qpos"][:1])
    ratio = float(np.median(found / wanted))
    if abs(ratio - 1) > 1e-3 + slack[0, 0]:
        given = f"of links {ratio:.3g} times as long as the arm's"
        raise InputError("stations", given, f"those of this arm, of {arm.length:g} m", where)
