"""A recording of a real arm: what was commanded, and where its markers were."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.errors import InputError
from contarm_sim.identify.rig import Rig
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.parameters import as_number

Kind = Literal["static", "motion"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Shown):
    """T samples of K markers under C commands, in SI units; samples in the order of time.

    Attributes:
        kind: `static`: the arm was at rest at each sample, or slow enough; `motion`: it swings.
        time: of each sample [s], shape (T,); of a motion it grows within each block.
        positions: of the markers in the frame of the measurements [m], shape (T, K, 3); NaN where one was not seen.
        commands: of the channels, in SI units (m, rad, N, Pa), shape (T, C); C may be 0.
        rig: where base and markers are, and what the channels drive, as far as it is known.
        blocks: what each sample belongs to, such as a pattern or a trial, shape (T,): samples of one block are not
            independent; of motions each is one of its own.
        payload: that the tip carries [kg], shape (T,); None: what the arm says.
        force: that acts on the backbone at `force_xi`, in the frame of the measurements [N], shape (T, 3); None: none.
        release: share of the fastest marker's peak speed at which a hand has let go: free swings are followed from
            there, see `swing_start`.
        name: what messages and figures call it.

    Raises:
        InputError: arrays that do not fit together, time that runs backwards, or a marker that is never seen.
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

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Whether a marker was seen, shape (T, K)."""
        return np.asarray(np.isfinite(self.positions).all(axis=-1))

    def part(self, rows: Any) -> Recording:
        """Return the recording of these samples alone: a mask, numbers or a slice."""
        own: dict[str, Any] = {
            name: None if (found := getattr(self, name)) is None else found[rows]
            for name in ("time", "positions", "commands", "blocks", "payload", "force")
        }
        return replace(self, **own)

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
            array = np.array(found, dtype=float)
            wanted = (count, *shape[1:])
            if array.ndim != len(wanted) or any(w not in (None, s) for w, s in zip(wanted, array.shape, strict=True)):
                said = " x ".join("any" if w is None else str(w) for w in wanted)
                raise InputError(name, f"of shape {array.shape}", f"an array of {said} numbers", self.name)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        blocks = np.asarray(self.blocks, dtype=np.str_)
        if blocks.shape != (count,):
            raise InputError("blocks", f"of shape {blocks.shape}", f"{count}, one for each sample", self.name)
        object.__setattr__(self, "blocks", blocks)
