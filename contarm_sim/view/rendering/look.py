"""How films look, what their colours reach to, and which samples they show."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.view.rendering.caption import LARGEST
from contarm_sim.view.rendering.draw import ALL, Overlays
from contarm_sim.view.rendering.formats import SIZES, USUAL
from contarm_sim.view.rendering.touch import metres_per_newton

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory


@dataclass(frozen=True)
class Look:
    """How the frames of a film are drawn.

    Attributes:
        width, height: size [pixels].
        camera: where it is seen from: a name, or azimuth and elevation [deg].
        plots: whether error and pressure are plotted in the lower corners.
        note: what is said of the whole run, a line below the numbers of the moment.
        captions: whether numbers and note are written along the top, and what colours mean.
        overlays: what is drawn besides the arm.
        transparent: neither floor nor sky nor shadow, captions and plots; frames have red, green, blue and opacity.
        letters: size of the caption's letters, in heights of the picture, at most.
    """

    width: int = SIZES[USUAL][0]
    height: int = SIZES[USUAL][1]
    camera: str | tuple[float, float] = "front"
    plots: bool = True
    note: str = ""
    captions: bool = True
    overlays: Overlays = ALL
    transparent: bool = False
    letters: float = LARGEST

    def plain(self) -> Look:
        """Return the look of the arm alone: without words, plots and anything drawn over it."""
        nothing = Overlays(path=False, trace=False, target=False, ghost=False, frames=False, contacts=False)
        return replace(self, plots=False, captions=False, overlays=nothing)


@dataclass(frozen=True)
class Scale:
    """What the colours of the trace and the plots reach to: tip error [m], pressure [Pa] and tension [N].

    And how long the arrow of a contact force is [m/N], 0 where nothing is touched.
    """

    error: float
    pressure: float
    tension: float = 0.0
    newton: float = 0.0

    @classmethod
    def of(cls, *runs: Trajectory) -> Scale:
        """Return the scale that shows all of some runs."""
        finite = [samples.pressure[np.isfinite(samples.pressure)] for samples in runs]
        return cls(
            max(float(run.tip_error.max()) for run in runs),
            max(float(each.max(initial=0.0)) for each in finite),
            max(float(run.muscle_tensions.max(initial=0.0)) for run in runs),
            metres_per_newton(*runs),
        )


def frame_indices(samples: Trajectory, fps: float, speed: float = 1.0) -> list[int]:
    """Return the sample nearest to each frame's time, the first at the first sample, none beyond the last.

    A frame lasts speed/fps of simulated time. Poses at rest have no time: each is one frame, at any `fps`.

    Raises:
        InputError: no samples, or fps or speed not a positive number.
    """
    if len(samples) == 0:
        raise InputError("samples", "empty", "at least one sample")
    for name, value in (("fps", fps), ("speed", speed)):
        if not (math.isfinite(value) and value > 0):
            raise InputError(name, value, "a positive number")
    span = float(samples.time[-1] - samples.time[0])
    if span == 0:
        return list(range(len(samples)))
    frames = math.floor(span * fps / speed + 1e-6) + 1
    places = np.arange(frames) * (speed / fps) * (len(samples) - 1) / span
    return [int(i) for i in np.minimum(np.floor(places + 0.5), len(samples) - 1)]
