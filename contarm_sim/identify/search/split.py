"""Which samples of recordings a fit is kept from."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError, did_you_mean
from contarm_sim.identify.recordings.recording import Recording

Mask = NDArray[np.bool_]


def held_out_of(recordings: Sequence[Recording], held_out: Any, seed: int = 0) -> tuple[Mask, ...]:
    """Return which samples of each recording are held out, shape (T,) each.

    Args:
        recordings: that the fit is of.
        held_out: names of blocks, where `*` stands for anything; a fraction from 0 to 1, taken as whole blocks that are
            drawn; or a mask of each recording's samples (of one recording, the mask itself).
        seed: of the draw.

    Raises:
        InputError: a name that no block has, a fraction that leaves nothing, a mask of another shape, or nothing left.
    """
    if isinstance(held_out, (int, float)) and not isinstance(held_out, bool):
        masks = _drawn(recordings, float(held_out), seed)
    elif isinstance(held_out, str):
        masks = _named(recordings, (held_out,))
    elif all(isinstance(one, str) for one in held_out):
        masks = _named(recordings, tuple(held_out))
    else:
        masks = _given(recordings, held_out)
    if all(mask.all() for mask in masks):
        raise InputError("held_out", "all samples", "samples left to fit to")
    return masks


def _named(recordings: Sequence[Recording], names: tuple[str, ...]) -> tuple[Mask, ...]:
    every = list(dict.fromkeys(str(block) for one in recordings for block in one.blocks))
    wanted = set()
    for name in names:
        found = [block for block in every if fnmatchcase(block, name)]
        if not found:
            raise InputError("held_out", repr(name), f"{did_you_mean(name, every)}names of blocks: {', '.join(every)}")
        wanted.update(found)
    return tuple(np.isin(one.blocks, list(wanted)) for one in recordings)


def _drawn(recordings: Sequence[Recording], fraction: float, seed: int) -> tuple[Mask, ...]:
    if not 0 <= fraction < 1:
        raise InputError("held_out", fraction, "a fraction from 0 to less than 1")
    blocks = [(k, str(name)) for k, one in enumerate(recordings) for name in dict.fromkeys(one.blocks.tolist())]
    masks = tuple(np.zeros(len(one), dtype=bool) for one in recordings)
    wanted, taken = fraction * sum(len(one) for one in recordings), 0
    if fraction and len(blocks) < 2:
        raise InputError("held_out", fraction, "names or a mask: the samples are one block, which is not divided")
    for place in np.random.default_rng(seed).permutation(len(blocks))[:-1].tolist():
        if taken >= wanted:
            break
        k, name = blocks[place]
        own = recordings[k].blocks == name
        masks[k][own] = True
        taken += int(own.sum())
    return masks


def _given(recordings: Sequence[Recording], held_out: Any) -> tuple[Mask, ...]:
    several = len(recordings) > 1 or (len(held_out) == 1 and np.ndim(held_out[0]) == 1)
    given = list(held_out) if several else [held_out]
    if len(given) != len(recordings):
        raise InputError("held_out", f"{len(given)} masks", f"{len(recordings)}, one for each recording")
    masks = []
    for one, recording in zip(given, recordings, strict=True):
        mask = np.asarray(one)
        if mask.dtype != bool or mask.shape != (len(recording),):
            said = f"an array of {mask.dtype} of shape {mask.shape}"
            raise InputError("held_out", said, f"a mask of {len(recording)} samples", recording.name)
        masks.append(mask)
    return tuple(masks)
