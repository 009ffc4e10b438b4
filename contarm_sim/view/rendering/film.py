"""From samples to a sequence of pictures: which samples, drawn how, with which words around."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.rendering.cameras import extent
from contarm_sim.view.rendering.caption import PAPER
from contarm_sim.view.rendering.draw import ArmRenderer, Pixels
from contarm_sim.view.rendering.film_words import caption, texts
from contarm_sim.view.rendering.insets import inset_cards
from contarm_sim.view.rendering.look import Look, Scale
from contarm_sim.view.rendering.panel import EDGE, Panel

if TYPE_CHECKING:
    from contarm_sim.mjcf.framing import Frame
    from contarm_sim.results.trajectory import Trajectory

Progress = Callable[[int, int], object]
"""Called with the number of frames done and their total."""

_NARROW = 1.4
"""Width over height of a run's part of the picture below which plots have a strip of their own."""


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
    said = [texts(run.samples, run.indices, run.name, speed, look.overlays) for run in runs]
    around = caption(look, said, scale, [run.note for run in runs])
    part = replace(look, width=width)
    cards = [_cards(run.samples, part, scale) for run in runs]
    top, foot = 0, 0
    if width < _NARROW * look.height:
        top = 0 if around is None else around.height
        foot = max((card.height for each in cards for card in each.values()), default=0)
    part = replace(part, height=look.height - top - foot)
    covered = (0.0 if top or around is None else around.height / look.height, {} if foot else cards[0])
    frames = zip(_together(runs, part, scale, covered), zip(*said, strict=True), strict=True)
    for done, (pictures, words) in enumerate(frames, 1):
        image = np.full((look.height, width * len(runs), pictures[0].shape[2]), PAPER[0], np.uint8)
        for number, (run, picture) in enumerate(zip(runs, pictures, strict=True)):
            own = image[:, number * width : (number + 1) * width]
            own[top : look.height - foot] = picture
            for corner, card in cards[number].items():
                card.write(own, _course(run.samples, run.indices[done - 1]), corner)
            if number and not look.transparent:
                own[top:, : max(1, look.height // 720)] = EDGE
        if around is not None:
            around.write(image, words)
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
    drawn = look.overlays
    seen = extent(*(run.samples for run in runs), path=drawn.path or drawn.target, ghost=drawn.ghost)
    if drawn.cloud is not None:
        seen = np.vstack([seen, drawn.cloud.bones[:, :: max(1, drawn.cloud.bones.shape[1] // 60)].reshape(-1, 3)])
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
            yield renderer.frame(samples, i, look.overlays, scale.error, scale.newton)


def _cards(samples: Trajectory, look: Look, scale: Scale) -> dict[str, Panel]:
    """Return the plots of the lower corners, none where none are wanted."""
    if not look.plots or look.transparent or len(samples) < 2:
        return {}
    band = None if look.overlays.cloud is None else look.overlays.cloud.band
    return inset_cards(samples, (look.width, look.height), scale.error, scale.pressure, scale.tension, band)


def _course(samples: Trajectory, index: int) -> float:
    """Return the time of a sample [s], or the number of a pose at rest."""
    return float(samples.time[index]) if samples.time[-1] > samples.time[0] else index + 1.0
