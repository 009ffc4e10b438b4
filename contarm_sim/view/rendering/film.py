"""From samples to a sequence of pictures: which samples, drawn how, with which words around."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.colours import ANALYTIC, TARGET, error_colours, rgb
from contarm_sim.view.rendering.cameras import extent
from contarm_sim.view.rendering.caption import PAPER, Caption, Legend
from contarm_sim.view.rendering.draw import ALL, ArmRenderer, Overlays, Pixels
from contarm_sim.view.rendering.insets import inset_cards
from contarm_sim.view.rendering.panel import EDGE, Panel
from contarm_sim.view.sections import bend_words

if TYPE_CHECKING:
    from contarm_sim.mjcf.framing import Frame
    from contarm_sim.results.trajectory import Trajectory

Progress = Callable[[int, int], object]
"""Called with the number of frames done and their total."""

_NARROW = 1.4
"""Width over height of a run's part of the picture below which plots have a strip of their own."""

AXES = [(0.86, 0.15, 0.15), (0.10, 0.62, 0.20), (0.15, 0.35, 0.90)]
"""Colours of the axes of base and tip."""


@dataclass(frozen=True)
class Look:
    """How the frames of a film are drawn.

    Attributes:
        width, height: size [pixels].
        camera: where it is seen from.
        plots: whether error and pressure are plotted in the lower corners.
        note: what is said of the whole run, a line below the numbers of the moment.
        captions: whether numbers and note are written along the top, and what colours mean.
        overlays: what is drawn besides the arm.
        transparent: neither floor nor sky nor shadow, captions and plots; frames have red, green, blue and opacity.
    """

    width: int = 1280
    height: int = 720
    camera: str = "front"
    plots: bool = True
    note: str = ""
    captions: bool = True
    overlays: Overlays = ALL
    transparent: bool = False

    def plain(self) -> Look:
        """Return the look of the arm alone: without words, plots and anything drawn over it."""
        nothing = Overlays(path=False, trace=False, target=False, ghost=False, frames=False)
        return replace(self, plots=False, captions=False, overlays=nothing)


@dataclass(frozen=True)
class Scale:
    """What the colours of the trace and the plots reach to: tip error [m], pressure [Pa] and tension [N]."""

    error: float
    pressure: float
    tension: float = 0.0

    @classmethod
    def of(cls, *runs: Trajectory) -> Scale:
        """Return the scale that shows all of some runs."""
        finite = [samples.pressure[np.isfinite(samples.pressure)] for samples in runs]
        return cls(
            max(float(run.tip_error.max()) for run in runs),
            max(float(each.max(initial=0.0)) for each in finite),
            max(float(run.muscle_tensions.max(initial=0.0)) for run in runs),
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


def film(
    samples: Trajectory,
    indices: list[int],
    look: Look,
    on_frame: Progress | None = None,
    scale: Scale | None = None,
    speed: float = 1.0,
) -> Generator[Pixels, None, None]:
    """Draw samples one after the other, with a caption; one picture exists at a time.

    Args:
        scale: of colours and plots; default this run's own.
        speed: simulated over shown time, which is said where it is not 1.

    Raises:
        InputError: an unknown camera, or a size that is no positive whole number.
        RenderingError: no GL library draws here.
    """
    run = _Run(samples, indices, look.note)
    yield from _framed([run], look, scale or Scale.of(samples), speed, on_frame)


def film_beside(
    one: tuple[Trajectory, list[int]],
    other: tuple[Trajectory, list[int]],
    look: Look,
    on_frame: Progress | None = None,
    names: tuple[str, str] = ("", ""),
    notes: tuple[str, str] = ("", ""),
    speed: float = 1.0,
) -> Generator[Pixels, None, None]:
    """Draw two runs side by side, each in half the width and to one scale; the shorter one stays at its last sample.

    Args:
        names: of the two runs, which the captions begin with.
        notes: what is said of each whole run.

    Raises:
        InputError, RenderingError: as `film`.
    """
    count = max(len(one[1]), len(other[1]))
    runs = [
        _Run(samples, indices + indices[-1:] * (count - len(indices)), note, name)
        for (samples, indices), note, name in zip((one, other), notes, names, strict=True)
    ]
    yield from _framed(runs, look, Scale.of(one[0], other[0]), speed, on_frame)


@dataclass(frozen=True)
class _Run:
    """What one part of the picture shows: samples, which of them, and what is said of all."""

    samples: Trajectory
    indices: list[int]
    note: str = ""
    name: str = ""


def _framed(
    runs: list[_Run], look: Look, scale: Scale, speed: float, on_frame: Progress | None
) -> Generator[Pixels, None, None]:
    """Draw runs side by side, with words along the top and plots in the lower corners.

    Where a run's part of the picture is narrow, the plots would hide the arm: then they have a strip of their own.
    """
    count, width = len(runs[0].indices), look.width // len(runs)
    texts = [_texts(run, speed) for run in runs]
    caption = _caption(look, texts, scale, [run.note for run in runs])
    part = replace(look, width=width)
    cards = [_cards(run.samples, part, scale) for run in runs]
    top, foot = 0, 0
    if width < _NARROW * look.height:
        top = 0 if caption is None else caption.height
        foot = max((card.height for each in cards for card in each.values()), default=0)
    part = replace(part, height=look.height - top - foot)
    covered = (0.0 if top or caption is None else caption.height / look.height, {} if foot else cards[0])
    frames = zip(_together(runs, part, scale, covered), zip(*texts, strict=True), strict=True)
    for done, (pictures, words) in enumerate(frames, 1):
        image = np.full((look.height, width * len(runs), pictures[0].shape[2]), PAPER[0], np.uint8)
        for number, (run, picture) in enumerate(zip(runs, pictures, strict=True)):
            own = image[:, number * width : (number + 1) * width]
            own[top : look.height - foot] = picture
            for corner, card in cards[number].items():
                card.write(own, _course(run.samples, run.indices[done - 1]), corner)
            if number and not look.transparent:
                own[top:, : max(1, look.height // 720)] = EDGE
        if caption is not None:
            caption.write(image, words)
        yield image
        if on_frame is not None:
            on_frame(done, count)


def _together(
    runs: list[_Run], look: Look, scale: Scale, covered: tuple[float, dict[str, Panel]]
) -> Generator[tuple[Pixels, ...], None, None]:
    """Draw the pictures of some runs that are shown together; whoever draws is ended with this.

    Args:
        covered: share of the height that words take, and the plots in the lower corners: the camera leaves them free.
    """
    from contarm_sim.mjcf.framing import Frame

    top, cards = covered
    wide = max((card.width for card in cards.values()), default=0)
    high = max((card.height for card in cards.values()), default=0)
    frame = Frame(top=top, cards=(wide / look.width, high / look.height))
    seen = extent(*(run.samples for run in runs))
    with ExitStack() as stack:
        films = [
            stack.enter_context(closing(_pictures(run.samples, run.indices, look, scale, seen, frame))) for run in runs
        ]
        yield from zip(*films, strict=True)


def _pictures(
    samples: Trajectory, indices: list[int], look: Look, scale: Scale, seen: Array, frame: Frame
) -> Generator[Pixels, None, None]:
    """Draw samples one after the other, without words and plots."""
    with ArmRenderer(
        samples.arm, look.width, look.height, look.camera, seen, frame, look.transparent
    ) as renderer:  # fmt: skip
        for i in indices:
            yield renderer.frame(samples, i, look.overlays, scale.error)


def _cards(samples: Trajectory, look: Look, scale: Scale) -> dict[str, Panel]:
    """Return the plots of the lower corners, none where none are wanted."""
    if not look.plots or look.transparent or len(samples) < 2:
        return {}
    return inset_cards(samples, (look.width, look.height), scale.error, scale.pressure, scale.tension)


def _course(samples: Trajectory, index: int) -> float:
    """Return the time of a sample [s], or the number of a pose at rest."""
    return float(samples.time[index]) if samples.time[-1] > samples.time[0] else index + 1.0


def _texts(run: _Run, speed: float) -> list[list[str]]:
    """Return what is said of each sample, a list of short texts."""
    samples = run.samples
    arm, error = samples.arm, samples.tip_error
    moving = bool(samples.time[-1] > samples.time[0])
    pace = "" if speed == 1 or not moving else f", {speed:g} × speed"
    return [
        [
            *([run.name] if run.name else []),
            f"t = {samples.time[i]:.2f} s{pace}" if moving else f"pose {i + 1} of {len(samples)}, at rest",
            f"tip error {1e3 * error[i]:.2f} mm = {100 * error[i] / arm.length:.2f} %",
            f"{'bend' if len(arm.sections) == 1 else 'bends'} {bend_words(samples.bend[i], arm)}",
        ]
        for i in run.indices
    ]


def _caption(look: Look, texts: list[list[list[str]]], scale: Scale, notes: list[str]) -> Caption | None:
    """Return what writes around the pictures, or nothing if nothing is to be written."""
    if look.transparent or not look.captions:
        return None
    widest = [[max(column, key=len) for column in zip(*run, strict=True)] for run in texts]
    return Caption(look.width, look.height, widest, _legend(look.overlays, scale), notes)


def _legend(overlays: Overlays, scale: Scale) -> Legend:
    """Return the colours of what is drawn over the arm, by what they mean."""
    legend: Legend = {}
    if overlays.path:
        legend["path"] = [rgb(TARGET)]
    if overlays.trace:
        legend[f"tip, error 0 to {1e3 * scale.error:.2g} mm"] = error_colours(np.linspace(0, 1, 24), 1.0)
    if overlays.ghost:
        legend["analytic"] = [rgb(ANALYTIC)]
    if overlays.frames:
        legend["x, y, z"] = AXES
    return legend
