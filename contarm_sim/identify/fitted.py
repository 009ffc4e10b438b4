"""What a fit comes to: the arm, its parameters with intervals, what data do not determine, and what is left over."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown
from contarm_sim.identify.differences import Differences, differences
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Rig
from contarm_sim.identify.showing import ShowingFit
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.results.document import document

_TOLD = ("singular_values", "noise", "cost", "converged", "evaluations", "seconds", "method", "message")
_OF_PARAMETER = ("unit", "start", "value", "sd", "low", "high", "boot_low", "boot_high", "status", "said")

Status = Literal["determined", "weakly determined", "at bound", "stopped early", "only with others", "not seen"]
"""Of a parameter: found, within a wide interval, at one of its bounds, or as it was when the search was stopped; seen
only with others, or of no or too little effect.

Of the last two no value is returned. One that is not seen keeps its start. Of those seen only with others as many are
held at their start (`said` names them) as the others need to be found: the arm has one of many sets that fit.
"""
FOUND: tuple[Status, ...] = ("determined", "weakly determined", "at bound", "stopped early")
"""Statuses of parameters that have a value."""


@dataclass(frozen=True, repr=False)
class Parameter(Shown):
    """A free parameter and what became of it; SI units.

    Attributes:
        free: its name, bounds and prior.
        unit: of its values.
        start: value that it started from.
        value: found; NaN where the data do not determine it.
        sd: standard deviation; of a parameter with a logarithm in the vector, of value times the logarithm's.
        low, high: 95 % interval, from the Jacobian; NaN where not determined.
        boot_low, boot_high: the same from a bootstrap over blocks; NaN where none was asked for.
        status: see `Status`.
        said: in a few words, what else is to be known: the combination that is determined, the bound.
    """

    free: Free
    unit: str
    start: float
    value: float
    sd: float
    low: float
    high: float
    boot_low: float
    boot_high: float
    status: Status
    said: str = ""

    @property
    def name(self) -> str:
        """Of the parameter."""
        return self.free.name

    @property
    def determined(self) -> bool:
        """Whether the data tell it, though perhaps not well; not so at a bound, or of a search that was stopped."""
        return self.status in ("determined", "weakly determined")


@dataclass(frozen=True, repr=False)
class Combination(Shown):
    """A direction of the parameters that the data do not determine.

    Attributes:
        names: parameters that take part, the largest part first.
        weights: parts of each, in steps of what it may plausibly be wrong by (`identifiability.plausible`: a factor e
            of a positive parameter), of length 1 together.
        sd: what the data leave along it, in such steps; inf where they see nothing.
        said: in words, such as "bending_stiffness and muscle.stiffness may grow together by any factor".
    """

    names: tuple[str, ...]
    weights: tuple[float, ...]
    sd: float
    said: str


@dataclass(frozen=True, eq=False, repr=False)
class Left(Shown):
    """What is left over of one recording: measured less predicted, T samples of K markers, frame of the measurements.

    Attributes:
        recording: in its fitted rig.
        predicted: where the markers were predicted [m], shape (T, K, 3).
        held_out: whether a sample was kept from the fit, shape (T,).
    """

    recording: Recording
    predicted: Array
    held_out: NDArray[np.bool_]

    @property
    def error(self) -> Array:
        """Measured less predicted [m], shape (T, K, 3); NaN where nothing was seen."""
        return self.recording.positions - self.predicted

    @property
    def unpredicted(self) -> int:
        """Samples in which a marker was seen, and none is predicted: they weigh in the fit, and are in no error."""
        return int((self.recording.seen & ~np.isfinite(self.predicted).all(axis=-1)).any(axis=-1).sum())

    def numbers(self) -> dict[str, Any]:
        """Return what a summary says: samples, and errors [m], fitted and held out; NaN where there are none."""
        recording, out = self.recording, self.held_out
        seen = recording.seen
        told: dict[str, Any] = {"name": recording.name, "kind": recording.kind, "samples": len(recording)}
        told |= {"held_out": int(out.sum()), "markers_seen": int(seen.sum())}
        told["markers_without_prediction"] = int((seen & ~np.isfinite(self.predicted).all(axis=-1)).sum())
        for name, rows in (("fitted", ~out), ("held_out", out)):
            found = self.differences(rows)
            told |= {f"rms_{name}_m": found.rms, f"rms_{name}_centred_m": found.centred_rms}
        return told

    def differences(self, rows: NDArray[np.bool_] | None = None, marker: int | None = None) -> Differences:
        """Return the numbers of how far markers were measured from where they were predicted [m].

        Args:
            rows: mask of samples, shape (T,); default all.
            marker: of one alone; default all.
        """
        error = self.error if rows is None else self.error[rows]
        return differences(error if marker is None else error[:, [marker]])

    def rms(self, rows: NDArray[np.bool_] | None = None, marker: int | None = None, centred: bool = False) -> float:
        """Return the root mean square distance [m] of what was measured from what was predicted.

        Args:
            rows, marker: as of `differences`.
            centred: without the mean offset of each marker.

        Returns:
            NaN where there is nothing to compare.
        """
        found = self.differences(rows, marker)
        return found.centred_rms if centred else found.rms


@dataclass(frozen=True, eq=False, repr=False)
class Fit(ShowingFit):
    """What a fit of P parameters to recordings came to.

    Attributes:
        arm: fitted.
        rigs: fitted, one for each recording.
        parameters: what became of the free ones.
        undetermined: combinations that the data do not determine, the worst first.
        correlation: of the parameters' errors, shape (P, P); NaN where one is not determined.
        singular_values: of the Jacobian by scaled parameters, over the noise, shape (P,), the largest first; NaN after
            a search that was stopped.
        left: what is left over, of each recording.
        noise: of one coordinate [m], as it was found or given.
        cost: weighted, at the end and from each start, the best first.
        converged: whether the search ended by itself.
        evaluations: predictions of all recordings.
        seconds: that it took.
        method: `least-squares` or `cma`.
        message: of the solver.
    """

    arm: Arm
    rigs: tuple[Rig, ...]
    parameters: tuple[Parameter, ...]
    undetermined: tuple[Combination, ...]
    correlation: Array
    singular_values: Array
    left: tuple[Left, ...]
    noise: float
    cost: tuple[float, ...]
    converged: bool
    evaluations: int
    seconds: float
    method: str
    message: str

    @property
    def rig(self) -> Rig:
        """The rig of the first recording."""
        return self.rigs[0]

    def to_dict(self) -> dict[str, Any]:
        """Return the fit as plain values, as summary.json has it: SI units, None where nothing is known."""
        told = document({name: getattr(self, name) for name in _TOLD})
        parameters = [document({"name": one.name} | {name: getattr(one, name) for name in _OF_PARAMETER})
                      for one in self.parameters]  # fmt: skip
        for one, about in zip(self.parameters, parameters, strict=True):
            about |= {"lower_bound": one.free.low, "upper_bound": one.free.high}
            about |= {"prior_mean": one.free.mean, "prior_sd": one.free.sd}
        recordings = [document(one.numbers()) for one in self.left]
        return {"recordings": recordings, "parameters": parameters, "undetermined": document(self.undetermined),
                "correlation": document(self.correlation), **told, "arm": document(self.arm)}  # fmt: skip

    def __repr__(self) -> str:
        known = sum(one.determined for one in self.parameters)
        return f"Fit({known} of {len(self.parameters)} parameters, rms {1e3 * self.left[0].rms():.3g} mm)"
