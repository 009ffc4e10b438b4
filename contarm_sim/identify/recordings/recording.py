"""A recording of a real arm: what was commanded, and where its markers were."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.errors import InputError, one_line
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.parameters import as_number

Kind = Literal["static", "motion"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Shown):
    """T samples of K markers under C commands, in SI units; samples in the order of time.

    Attributes:
        kind: `static`: the arm was at rest at each sample, or slow enough; `motion`: it swings.
        time: of each sample [s], shape (T,); it does not run backwards within a block; of a motion it grows.
        positions: of the markers in the frame of the measurements [m], shape (T, K, 3); NaN where one was not seen.
        commands: of the channels, in SI units (m, rad, N, Pa), shape (T, C); C may be 0.
        rig: where base and markers are, and what the channels drive, as far as it is known.
        blocks: what each sample belongs to, such as a pattern or a trial, shape (T,): samples of one block are not
            independent; of motions each is one of its own, and its samples stand together.
        payload: that the tip carries [kg], shape (T,); None: what the arm says.
        force: that acts on the backbone at `force_xi`, in the frame of the measurements [N], shape (T, 3); None: none.
        release: share of the fastest marker's peak speed at which a hand has let go: free swings are followed from
            there, see `swing_start`.
        name: what messages and figures call it.

    Raises:
        InputError: arrays that do not fit together or are empty, numbers that are not finite (but for positions), time
            that runs backwards, fewer commands than channels, or a marker that is never seen.
    """

    kind: Kind
    time: Array
    positions: Array
    commands: Array
    rig: Rig
    blocks: NDArray[np.str_]
    payload: Array | None = None
    force: Array | None = None
    force_xi: float = 1.0
    release: float = 0.7
    name: str = "recording"

    def __len__(self) -> int:
        return len(self.time)

    def __repr__(self) -> str:
        blocks, markers, channels = len(set(self.blocks.tolist())), len(self.rig.markers), self.commands.shape[1]
        said = f"{len(self)} samples in {blocks} blocks, {markers} markers, {channels} channels"
        return f"Recording({one_line(self.name)!r}, {self.kind}: {said})"

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Whether a marker was seen, shape (T, K)."""
        return np.asarray(np.isfinite(self.positions).all(axis=-1))

    def part(self, rows: Any) -> Recording:
        """Return the recording of these samples alone: a mask, numbers or a slice; a marker may be seen in none."""
        part = copy(self)
        for name in ("time", "positions", "commands", "blocks", "payload", "force"):
            if (found := getattr(self, name)) is not None:
                own = found[rows]
                own.flags.writeable = False
                object.__setattr__(part, name, own)
        return part

    def in_rig(self, rig: Rig) -> Recording:
        """Return the same recording with other markers, frames or actuation.

        Raises:
            InputError: not as many markers.
        """
        return replace(self, rig=rig)

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError("kind", repr(self.kind), ", ".join(KINDS), self.name)
        if not 0 <= as_number(self.release) <= 1:
            raise InputError("release", self.release, "a share of the peak speed, from 0 to 1", self.name)
        markers = len(self.rig.markers)
        shapes = {"time": (None,), "positions": (None, markers, 3), "commands": (None, None), "payload": (None,),
                  "force": (None, 3)}  # fmt: skip
        count = len(self.time)
        for name, shape in shapes.items():
            if (found := getattr(self, name)) is None:
                continue
            array = self._numbers(name, found)
            wanted = (count, *shape[1:])
            if array.ndim != len(wanted) or any(w not in (None, s) for w, s in zip(wanted, array.shape, strict=True)):
                said = " x ".join("any" if w is None else str(w) for w in wanted)
                raise InputError(name, f"of shape {array.shape}", f"an array of {said} numbers", self.name)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        blocks = np.array(self.blocks, dtype=np.str_)
        if blocks.shape != (count,):
            raise InputError("blocks", f"of shape {blocks.shape}", f"{count}, one for each sample", self.name)
        blocks.flags.writeable = False
        object.__setattr__(self, "blocks", blocks)
        self._check()

    def _numbers(self, name: str, values: Any) -> Array:
        try:
            return np.array(values, dtype=float)
        except (TypeError, ValueError):
            raise InputError(name, values, "an array of numbers", self.name) from None

    def _check(self) -> None:
        if not len(self):
            raise InputError("time", "no samples", "one sample or more", self.name)
        for name in ("time", "commands", "payload", "force"):
            if (found := getattr(self, name)) is not None and not np.isfinite(found).all():
                number = int(np.argwhere(~np.isfinite(found))[0][0])
                raise InputError(f"sample {number + 1}, {name}", str(found[number]), "finite numbers", self.name)
        if np.isinf(self.positions).any():
            number = int(np.argwhere(np.isinf(self.positions))[0][0])
            raise InputError(f"sample {number + 1}, positions", "inf", "finite numbers, NaN where unseen", self.name)
        if self.payload is not None and self.payload.min() < 0:
            number = int(np.argmin(self.payload))
            raise InputError(f"sample {number + 1}, payload", float(self.payload[number]), "0 kg or more", self.name)
        if not 0 <= self.force_xi <= 1:
            raise InputError("force_xi", self.force_xi, "a number from 0 (base) to 1 (tip)", self.name)
        channels = max(self.rig.actuation.channels, default=-1) + 1
        if self.commands.shape[1] < channels:
            allowed = f"{channels}, as actuation.channels has them"
            raise InputError("commands", f"{self.commands.shape[1]} channels", allowed, self.name)
        if found := backwards(self.time, self.blocks, self.kind):
            number, allowed = found
            given = f"{self.time[number]:.9g} s"
            raise InputError(f"sample {number + 1}, time", given, allowed, self.name)
        for marker, seen in zip(self.rig.markers, self.seen.T, strict=True):
            if not seen.any():
                raise InputError(f"marker {marker.name}", "never seen", "a position in one sample or more", self.name)


def backwards(time: Array, blocks: NDArray[np.str_], kind: Kind) -> tuple[int, str] | None:
    """Return the first sample, from 0, whose time does not follow on that before in its block, and what would.

    Of motions time must grow and blocks stay together; of static recordings it must not run backwards.

    Args:
        time: of each sample [s], shape (T,).
        blocks: of each sample, shape (T,).
        kind: of the recording.
    """
    last: dict[str, float] = {}
    before = None
    for number, (now, block) in enumerate(zip(time.tolist(), blocks.tolist(), strict=True)):
        then, own = last.get(block), f" in block {block!r}" if block else ""
        if then is not None and kind == "motion" and block != before:
            return number, f"samples of one block together; block {block!r} begins again"
        if then is not None and (now < then or (now == then and kind == "motion")):
            word = "above" if kind == "motion" else "at least"
            return number, f"{word} {then:.9g} s, as of the sample before{own}: time runs forwards"
        last[block], before = now, block
    return None


OTHERS = tuple(
    item.name
    for item in fields(Recording)
    if item.name
    not in ("kind", "time", "positions", "commands", "rig", "blocks", "payload", "force", "force_xi", "name")
)
"""Fields that files of motions hold as they are, by the same names."""
