"""What an arm touched: where, with what force, and which link, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.objects import ITSELF

SHAPES = {
    "sample": ("C",), "station": ("C",), "partner": ("C",), "point": ("C", 3), "force": ("C", 3), "normal": ("C", 3),
    "depth": ("C",),
}  # fmt: skip
"""Shapes of the columns of C contacts."""

COUNTED = ("sample", "station", "partner")
"""Those that are whole numbers."""


@dataclass(frozen=True, eq=False, repr=False)
class Contacts:
    """C contacts of links with objects, sample by sample, in the base frame; all of a link with an object are one.

    Where two links touch each other, both have a contact, with forces that are opposite: each is what that link feels.

    Attributes:
        sample: of the trajectory, rising, shape (C,).
        station: whose link touches, counted from the base, 0 to N, shape (C,).
        partner: what it touches, a place in `names`, shape (C,).
        point: where, the mean of several weighted by their forces, without force that of the deepest [m], shape (C, 3).
        force: on the arm, summed [N], shape (C, 3).
        normal: of the deepest, out of the object towards the arm, shape (C, 3).
        depth: how far link and object overlap there [m], shape (C,).
        names: of what can be touched, `World.partners`: its objects, `itself`, and the bodies of a host; of a host of
            too many bodies `world`, which stands for all.
    """

    sample: NDArray[np.intp]
    station: NDArray[np.intp]
    partner: NDArray[np.intp]
    point: Array
    force: Array
    normal: Array
    depth: Array
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        count = len(np.asarray(self.sample))
        for name, shape in SHAPES.items():
            wanted: tuple[int, ...] = (count, *(3 for _ in shape[1:]))
            own = np.array(getattr(self, name), dtype=np.intp if name in COUNTED else float)
            if own.shape != wanted or not np.isfinite(own).all():
                raise InputError(f"contacts.{name}", f"of shape {own.shape}", f"finite numbers of shape {wanted}")
            own.setflags(write=False)
            object.__setattr__(self, name, own)
        if count and not (self.sample.min() >= 0 and (np.diff(self.sample) >= 0).all()):
            raise InputError("contacts.sample", "not rising", "numbers of samples that rise")
        if count and not (self.partner.min() >= 0 and self.partner.max() < len(self.names)):
            raise InputError("contacts.partner", int(self.partner.max()), f"a place among {len(self.names)} names")

    def __len__(self) -> int:
        return len(self.sample)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Contacts):
            return NotImplemented
        return all(np.array_equal(getattr(self, item.name), getattr(other, item.name)) for item in fields(self))

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        if not len(self):
            return "Contacts(none)"
        touched = ", ".join(self.touched)
        force = self.total(int(self.sample[-1]) + 1).max()
        most = f"force up to {force:.3g} N, depth up to {1e3 * self.depth.max():.2g} mm"
        return f"Contacts({len(self)} in {len(np.unique(self.sample))} samples, with {touched}; {most})"

    @property
    def touched(self) -> list[str]:
        """The names of what was touched at all."""
        return [self.names[place] for place in np.unique(self.partner)]

    @property
    def normal_force(self) -> Array:
        """Force along the normal [N], shape (C,)."""
        return np.einsum("ci,ci->c", self.force, self.normal)

    @property
    def friction_force(self) -> Array:
        """Force across the normal [N], shape (C,)."""
        return np.linalg.norm(self.force - self.normal_force[:, None] * self.normal, axis=1)

    def where(self, rows: Any) -> Contacts:
        """Return these of the contacts: a mask or numbers of rows."""
        columns: dict[str, Any] = {name: getattr(self, name)[rows] for name in SHAPES}
        return Contacts(**columns, names=self.names)

    def at(self, sample: int) -> Contacts:
        """Return the contacts of one sample."""
        low, high = np.searchsorted(self.sample, [sample, sample + 1])
        return self.where(slice(low, high))

    def first(self, count: int) -> Contacts:
        """Return the contacts of the first `count` samples."""
        return self.where(slice(0, np.searchsorted(self.sample, count)))

    @staticmethod
    def joined(parts: Sequence[Contacts], counts: Sequence[int]) -> Contacts:
        """Return the contacts of recordings that follow one another, of so many samples each."""
        starts = np.cumsum([0, *counts[:-1]])
        columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in SHAPES}
        columns["sample"] = np.concatenate([part.sample + start for part, start in zip(parts, starts, strict=True)])
        return Contacts(**columns, names=parts[0].names)

    def total(self, samples: int) -> Array:
        """Return the sum of the sizes of all contact forces of each sample [N], shape (samples,).

        The force between two links of the arm, which both feel, counts once.
        """
        sizes = np.linalg.norm(self.force, axis=1) * np.where(self._of_itself, 0.5, 1.0)
        return np.asarray(np.bincount(self.sample, sizes, minlength=samples), dtype=float)

    @property
    def _of_itself(self) -> NDArray[np.bool_]:
        """Which are contacts of the arm with itself, shape (C,)."""
        return np.array([name == ITSELF for name in self.names], dtype=bool)[self.partner]

    def deepest(self, samples: int) -> Array:
        """Return the largest depth of each sample [m], 0 where there is no contact, shape (samples,)."""
        out = np.zeros(samples)
        np.maximum.at(out, self.sample, self.depth)
        return out
