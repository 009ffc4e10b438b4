"""A recording predicted: where an arm in its rig says that the markers would be, beside where they were."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from contarm_sim.display import Shown, drawing
from contarm_sim.errors import InputError, expect
from contarm_sim.identify.differences import Differences, differences, root_mean_square
from contarm_sim.identify.prediction.backbones import backbones
from contarm_sim.identify.prediction.base import AtRest, Predictor
from contarm_sim.identify.prediction.choice import predictor_of
from contarm_sim.identify.prediction.swings import Swing, swings_of
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.replays.bands import Bands, banded
from contarm_sim.identify.replays.covariance import Covariance
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.display import Film, Report, Sheet


@dataclass(frozen=True, eq=False, repr=False)
class Replay(Shown):
    """A recording of T samples of K markers beside its prediction by an arm of N links.

    Attributes:
        arm: that predicts.
        recording: in the rig that predicts.
        predicted: where its markers would be, frame of the measurements [m], shape (T, K, 3); NaN where the arm has no
            pose.
        frames: of the arm's stations in the base's frame, shape (T, N + 1, 4, 4).
        bands: how far the prediction may be off, by a fit's covariance; None without one.
        held_out: whether a sample was kept from the fit, shape (T,); None: that is not known.
        swings: of releases: measured and simulated; empty of static recordings.
    """

    arm: Arm
    recording: Recording
    predicted: Array
    frames: Array
    bands: Bands | None = None
    held_out: NDArray[np.bool_] | None = None
    swings: tuple[Swing, ...] = ()

    def __len__(self) -> int:
        return len(self.recording)

    @property
    def error(self) -> Array:
        """Measured less predicted [m], shape (T, K, 3); NaN where a marker was not seen or not predicted."""
        return np.asarray(self.recording.positions - self.predicted)

    @property
    def distance(self) -> Array:
        """Its length [m], shape (T, K)."""
        return np.asarray(np.linalg.norm(self.error, axis=-1))

    @property
    def shape_error(self) -> Array:
        """Root mean square of the distances of a sample's markers [m], shape (T,); NaN where none was seen."""
        square, seen = np.nan_to_num(self.distance) ** 2, np.isfinite(self.distance)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(square.sum(axis=1) / seen.sum(axis=1)))

    @property
    def unpredicted(self) -> int:
        """Samples in which the arm has no pose; not those before a hand lets go of it."""
        lost = np.asarray(~np.isfinite(self.predicted).all(axis=(1, 2)))
        if self.recording.kind == "motion":
            for block in set(self.recording.blocks.tolist()):
                own = self.recording.blocks == block
                lost[own] &= lost[own].all()
        return int(lost.sum())

    def differences(self, rows: Any = slice(None), marker: int | None = None) -> Differences:
        """Return numbers of the error of some samples (a mask, numbers or a slice), of one marker or of all."""
        own = slice(None) if marker is None else slice(marker, marker + 1)
        return differences(self.error[rows][:, own])

    def by_marker(self) -> dict[str, Differences]:
        """Return the same of each marker, by its name; equal names are numbered."""
        names = [one.name for one in self.recording.rig.markers]
        told = [f"{name} ({k + 1})" if names.count(name) > 1 else name for k, name in enumerate(names)]
        return {name: self.differences(marker=k) for k, name in enumerate(told)}

    def by_block(self) -> dict[str, Differences]:
        """Return the same of each block, in the order of the recording."""
        blocks = self.recording.blocks
        return {name: self.differences(blocks == name) for name in dict.fromkeys(blocks.tolist())}

    def stretch(self) -> list[tuple[str, float, float]]:
        """Return how distances between neighbouring markers differ, which no error of the frame changes.

        Of each pair: their names, the mean difference, measured less predicted, and its rms [m].
        """
        markers, out = self.recording.rig.markers, []
        for k in range(len(markers) - 1):
            ends = [
                np.linalg.norm(at[:, k + 1] - at[:, k], axis=-1) for at in (self.recording.positions, self.predicted)
            ]
            off = ends[0] - ends[1]
            known = off[np.isfinite(off)]
            mean = float(known.mean()) if len(known) else float("nan")
            out.append((f"{markers[k].name} to {markers[k + 1].name}", mean, root_mean_square(off)))
        return out

    def worst(self, count: int = 6) -> list[int]:
        """Return the samples of the largest shape errors, the worst first; no two that follow each other closely."""
        error, chosen = np.nan_to_num(self.shape_error, nan=-1.0), list[int]()
        apart = max(1, len(self) // 40)
        for place in np.argsort(-error, kind="stable").tolist():
            if error[place] >= 0 and all(abs(place - other) >= apart for other in chosen):
                chosen.append(place)
            if len(chosen) == count:
                break
        return chosen

    def figure(self, figure: str = "components", width: Any = "page", titles: bool = True) -> Sheet:
        """Return a figure: `components`, `errors`, `histogram`, `paths`, `worst` or, of free swings, `swings`.

        Raises:
            InputError: there is no such figure of it, or no such width.
        """
        made: Sheet = drawing().replay_figure(self, figure, width, titles)
        return made

    def film(self, path: Any = None, **given: Any) -> Film:
        """Film it: the arm with the real markers, and lines of error between; as `Trajectory.film`."""
        made: Film = drawing().replay_film(self, path, **given)
        return made

    def report(self, folder: Any = None, *, film: bool = False) -> Report:
        """Return the page of `contarm replay`, and leave what the command leaves in a folder, if one is given."""
        made: Report = drawing().replay_report(self, folder, film=film)
        return made

    def __repr__(self) -> str:
        found = self.differences()
        said = f"rms {1e3 * found.rms:.3g} mm, {100 * found.rms / self.arm.length:.3g} % of length"
        return f"Replay({self.recording.name!r}, {len(self)} samples, {said})"


def replay(
    arm: Arm,
    recording: Recording,
    covariance: Covariance | None = None,
    *,
    predictor: Callable[[Recording], Predictor] | None = None,
    held_out: Any = None,
    threads: int = 0,
) -> Replay:
    """Predict a recording, and compare.

    Args:
        arm: that predicts; in the recording's rig.
        recording: static or of motions.
        covariance: what a fit leaves open of this arm in this rig, see `covariance_of`; default no bands.
        predictor: what predicts a recording; default as a fit does.
        held_out: whether each sample was kept from the fit, shape (T,), where that is known.
        threads: that share the work; 0: one a processor.

    Raises:
        InputError: not an arm, not a recording, or a fit of another arm or rig.
    """
    expect("arm", arm, Arm)
    arm.refuse_objects("recordings are predicted")
    expect("recording", recording, Recording)
    if covariance is not None and (covariance.freedom.arm, covariance.freedom.rig) != (arm, recording.rig):
        raise InputError("covariance", "of another arm or rig", "the covariance of the arm and the rig that predict")
    if predictor is None:
        predictor = usual_predictor(arm, threads)
    told = None if held_out is None else np.array(held_out, dtype=np.bool_)
    if told is not None and told.shape != (len(recording),):
        raise InputError("held_out", f"of shape {told.shape}", f"{len(recording)}, one for each sample")
    frames, predicted = backbones(arm, recording, predictor)
    bands = None if covariance is None else banded(covariance, recording, predicted, predictor(recording))
    return Replay(arm, recording, predicted, frames, bands, told, swings_of(recording, predicted))


def some_samples(arm: Arm, recording: Recording, count: int | None) -> Any:
    """Return which samples stand for a recording, a slice or numbers: all without a count.

    Evenly picked ones of poses that do not remember those before; else the first.
    """
    if count is None or count >= len(recording):
        return slice(None)
    if isinstance(usual_predictor(arm)(recording), AtRest):
        return np.linspace(0, len(recording) - 1, count).round().astype(int)
    return slice(0, count)


def usual_predictor(arm: Arm, threads: int = 0) -> Callable[[Recording], Predictor]:
    """Return what makes the predictor of a recording that a fit would take."""
    return lambda recording: predictor_of(recording, arm, threads=threads)
