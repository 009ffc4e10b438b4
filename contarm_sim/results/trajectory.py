"""What a simulation found, and what it is a result of: arm, world, controller, status, versions, arrays."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from contarm_sim.errors import InputError, expect
from contarm_sim.kinematics.arrays import Array, ReadOnly
from contarm_sim.mechanics.contacts import Contacts
from contarm_sim.model.arm import Arm
from contarm_sim.model.parameters import check_count
from contarm_sim.paths.reference import Reference, section_lengths
from contarm_sim.results.arrays import require_links_of
from contarm_sim.results.showing import Showing

STEP_LIMIT = 1e-3
"""Largest error [lengths] of the tip that the time step may make."""

Status = Literal["finished", "interrupted", "at rest"]
STATUSES: tuple[Status, ...] = get_args(Status)

ARRAYS = (
    "time", "target", "bend", "setpoint", "muscle_lengths", "muscle_tensions", "pressure", "stations", "tip_rotation",
    "qpos",
)  # fmt: skip
"""The arrays of a trajectory with one row a sample."""

OPTIONAL = ("direction", "step_error", "objects", "base", "host")
"""Those that a trajectory may be without."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Trajectory(ReadOnly, Showing):
    """T sampled states of an arm with N links and n muscles, in the base frame, which may move. Arrays are read-only.

    Attributes:
        arm: the arm, and the world that it stands in.
        controller: the name of what drove it.
        actuation: what its controls are: `lengths`, `pressures` or `tensions`.
        pulls_only: whether its muscles were limited to pulling.
        holds_lengths: whether its controller means muscle lengths to be those of the bend.
        status: `finished`, `interrupted` (Ctrl-C ended it early), or `at rest` (poses, not a motion).
        time: simulated time [s], shape (T,); zeros for poses at rest.
        target: tip positions asked for [m], shape (T, 3).
        bend: commanded bends [rad], shape (T, 2 S) of S sections: x and y of section 1, of section 2, and so on.
        setpoint: the controls: length changes [m], pressures asked for [Pa] or tensions [N], shape (T, n).
        muscle_lengths: measured [m], shape (T, n).
        muscle_tensions: measured [N], pulling > 0, shape (T, n): by actuators, silicone, and damping along the muscle,
            which resists a slack muscle's shortening and so may push.
        pressure: gauge pressures of the muscles [Pa], shape (T, n); under length servos, those that McKibben muscles of
            these lengths would need for these tensions, inf where none does it.
        stations: centres of base plate, disks and tip plate [m], shape (T, N + 1, 3).
        tip_rotation: orientation of the tip, shape (T, 3, 3).
        qpos: joint angles [rad], shape (T, dofs).
        direction: directions of the tip asked for, shape (T, 3), or None.
        timestep: engine step [s]; None at rest. Where Ctrl-C came while a shorter step was tried, that of the longer.
        step_error: how far the step puts the tip off [m], estimated from another step; shape (T,), NaN where it was not
            compared. None: nowhere.
        contacts: what the arm touched; None where it can touch nothing, and for poses at rest.
        objects: where the F free objects of the world are, in its order: position [m] and quaternion w x y z, shape
            (T, F, 7); None where there are none.
        base: where the base is in its host, where that can move it: position [m] and quaternion w x y z, shape (T, 7);
            None where it stays.
        host: positions of the host's own joints, as its engine has them [m, rad, or of free ones as `base`], shape
            (T, H); None where there are none.
        extrapolated: whether the samples are those of infinitely many links, as two chains tell.
        real_time_factor: simulated over wall-clock time of the stepping loop; None at rest.
        versions: of what the numbers depend on, by name.
    """

    arm: Arm
    controller: str
    actuation: str = "lengths"
    pulls_only: bool = True
    holds_lengths: bool = True
    status: Status
    time: Array
    target: Array
    bend: Array
    setpoint: Array
    muscle_lengths: Array
    muscle_tensions: Array
    pressure: Array
    stations: Array
    tip_rotation: Array
    qpos: Array
    timestep: float | None = None
    direction: Array | None = None
    step_error: Array | None = None
    contacts: Contacts | None = None
    objects: Array | None = None
    base: Array | None = None
    host: Array | None = None
    extrapolated: bool = False
    real_time_factor: float | None = None
    versions: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in (*ARRAYS, *OPTIONAL):
            given = getattr(self, name)
            if given is not None:
                self._keep(name, given)
        expect("arm", self.arm, Arm)
        self._check_touch()
        if self.status not in STATUSES:
            raise InputError("status", self.status, ", ".join(STATUSES))
        if len(self):
            require_links_of(self.arm, self._arrays(), "trajectory")

    def _check_touch(self) -> None:
        free = len(self.arm.world.movable)
        if self.objects is not None and self.objects.shape != (len(self), free, 7):
            raise InputError("objects", f"of shape {self.objects.shape}", f"shape {(len(self), free, 7)}")
        if self.contacts is None:
            return
        expect("contacts", self.contacts, Contacts)
        if len(self.contacts) and self.contacts.sample[-1] >= len(self):
            raise InputError("contacts.sample", int(self.contacts.sample[-1]), f"below {len(self)} samples")
        if self.contacts.names != self.arm.world.partners:
            raise InputError("contacts.names", self.contacts.names, f"{self.arm.world.partners}, as the arm has them")

    def _arrays(self) -> dict[str, Array]:
        names = [*ARRAYS, *(name for name in OPTIONAL if getattr(self, name) is not None)]
        return {name: getattr(self, name) for name in names}

    def __len__(self) -> int:
        return len(self.time)

    def __eq__(self, other: object) -> bool:
        """Tell whether another trajectory is of the same arm and holds the same numbers, wall-clock times apart."""
        if not isinstance(other, Trajectory):
            return NotImplemented
        apart = {"real_time_factor", "versions"}
        return all(_equal(getattr(self, f.name), getattr(other, f.name)) for f in fields(self) if f.name not in apart)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        arm = self.arm
        span = "poses at rest" if self.status == "at rest" else f"{self.time[-1] if len(self) else 0:g} s"
        error = self.tip_error
        worst = f"{1e3 * error.max():.3g} mm ({100 * error.max() / arm.length:.3g} % of length)" if len(self) else "-"
        apart = f"largest distance from the arc's tip {worst}"
        return (
            f"Trajectory({self.status}: {len(self)} samples, {span}, controller {self.controller}\n"
            f"  arm of {arm.length:g} m, {arm.links} links; {apart}{self._touched()}{self._stepped()})"
        )

    def _stepped(self) -> str:
        """Return in a line what the time step does, where that is too much."""
        error = np.nanmax(self.step_error, initial=0.0) if self.step_error is not None else 0.0
        if error <= STEP_LIMIT * self.arm.length:
            return ""
        return f"\n  NOT converged: the time step puts the tip off by up to {1e3 * error:.3g} mm"

    def _touched(self) -> str:
        """Return in a line what was touched; "" where nothing can be."""
        if self.contacts is None:
            return ""
        found, names = self.contacts, self.contacts.names
        if not len(found):
            return f"\n  touched nothing of {', '.join(names)}"
        force, depth = found.total(len(self)).max(), 1e3 * found.depth.max()
        return f"\n  touched {', '.join(found.touched)}: contact force up to {force:.3g} N, depth up to {depth:.2g} mm"

    @property
    def tip(self) -> Array:
        """Tip positions [m], shape (T, 3)."""
        return self.stations[:, -1]

    @property
    def tip_error(self) -> Array:
        """Distances from the simulated tip to that of the constant-curvature arcs at the commanded bend [m], (T,)."""
        from contarm_sim.mechanics import shape

        return np.linalg.norm(self.tip - shape.position(self.bend, self.arm), axis=1)

    @property
    def bends(self) -> Array:
        """Commanded bends of all sections [rad], shape (T, S, 2)."""
        return self.bend.reshape(len(self), -1, 2)

    @property
    def reference(self) -> Reference:
        """What the arm was asked to do."""
        return Reference(self.time, self.target, self.bend, section_lengths(self.arm), self.direction)

    @property
    def moving(self) -> bool:
        """Whether it is a motion, not poses at rest."""
        return self.status != "at rest"

    def first(self, count: int) -> Trajectory:
        """Return the first `count` samples.

        Raises:
            InputError: not a whole number, or below 0.
        """
        check_count("count", count, 0, "samples")
        shortened: dict[str, Any] = {name: array[:count] for name, array in self._arrays().items()}
        if self.contacts is not None:
            shortened["contacts"] = self.contacts.first(count)
        return replace(self, **shortened)

    def save(self, path: str | Path) -> None:
        """Write everything to a compressed .npz: arrays under their own names, the rest as JSON under `about`.

        Raises:
            InputError: a name that does not end in .npz, or a place that cannot be written to.
        """
        from contarm_sim.results.storage import write

        write(self, path)

    @classmethod
    def load(cls, path: str | Path) -> Trajectory:
        """Read what `save` wrote.

        Raises:
            InputError: not such a file, or arrays that do not fit together or hold what is not a number.
        """
        from contarm_sim.results.storage import read

        return read(path)

    def to_dataframe(self) -> Any:
        """Return a pandas DataFrame with one row a sample; units are in the columns' names. Needs pandas.

        Raises:
            MissingError: pandas is not installed.
        """
        from contarm_sim.results.export import dataframe

        return dataframe(self)

    def to_xarray(self) -> Any:
        """Return an xarray Dataset with dimensions time, station, muscle, axis; units are attributes. Needs xarray.

        Raises:
            MissingError: xarray is not installed.
        """
        from contarm_sim.results.export import dataset

        return dataset(self)

    def check_arm(self, arm: Arm) -> None:
        """Refuse another arm than the one that this is a result of.

        Raises:
            InputError: it is another.
        """
        if arm != self.arm:
            raise InputError("trajectory", "of another arm", "one of this arm: its result knows it as trajectory.arm")


def _equal(one: Any, other: Any) -> bool:
    arrays = isinstance(one, np.ndarray), isinstance(other, np.ndarray)
    return np.array_equal(one, other, equal_nan=True) if all(arrays) else not any(arrays) and bool(one == other)
