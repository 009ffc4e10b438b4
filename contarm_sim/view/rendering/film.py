"""From samples to a sequence of pictures: which samples, drawn how."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.view.colours import ANALYTIC, error_colours, rgb
from contarm_sim.view.rendering.cameras import extent
from contarm_sim.view.rendering.caption import Caption
from contarm_sim.view.rendering.draw import PATH, ArmRenderer, Pixels
from contarm_sim.view.rendering.panel import Curve, Panel
from contarm_sim.view.sections import bend_words, muscle_hexes, pressure_limits, section_hex

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

Progress = Callable[[int, int], object]
"""Called with the number of frames done and their total."""


@dataclass(frozen=True)
class Look:
    """How the frames of a film are drawn: size [pixels], camera, plots in the lower corners or not.

    And what is said of the whole run, a line below the numbers of the moment.
    """

    width: int = 1280
    height: int = 720
    camera: str = "front"
    plots: bool = True
    note: str = ""


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
    name: str = "",
) -> Generator[Pixels, None, None]:
    """Draw samples one after the other, with a caption; one picture exists at a time.

    Args:
        scale: of colours and plots; default this run's own.
        name: what the caption begins with.

    Raises:
        InputError: an unknown camera or quality, or a size that is no positive whole number.
        RenderingError: no GL library draws here.
    """
    arm, error, scale = samples.arm, samples.tip_error, scale or Scale.of(samples)
    moving = bool(samples.time[-1] > samples.time[0])
    texts = [
        (name + "   " if name else "")
        + (f"t = {samples.time[i]:.2f} s" if moving else f"pose {i + 1} of {len(samples)}, at rest")
        + f"   tip error {1e3 * error[i]:.2f} mm = {100 * error[i] / arm.length:.2f} %"
        + f"   {'bend' if len(arm.sections) == 1 else 'bends'} {bend_words(samples.bend[i], arm)}"
        for i in indices
    ]
    from contarm_sim.mjcf.framing import Frame

    panels = _panels(samples, look, scale) if moving and look.plots else {}
    with ArmRenderer(
        arm,
        look.width,
        look.height,
        look.camera,
        extent(samples),
        Frame(top=0.085, cards=(0.29, 0.285) if panels else (0.0, 0.0)),
    ) as renderer:
        colours = error_colours(np.linspace(0, 1, 24), 1.0)
        legend = {"path": [PATH], f"tip, by error to {1e3 * scale.error:.2g} mm": colours, "analytic": [rgb(ANALYTIC)]}
        caption = Caption(look.width, look.height, max(texts, key=len), legend, look.note)
        for done, (i, text) in enumerate(zip(indices, texts, strict=True), 1):
            image = renderer.frame(samples, i, largest=scale.error)
            caption.write(image, text)
            for corner, panel in panels.items():
                panel.write(image, float(samples.time[i]), corner)
            yield image
            if on_frame is not None:
                on_frame(done, len(indices))


def film_beside(
    one: tuple[Trajectory, list[int]],
    other: tuple[Trajectory, list[int]],
    look: Look,
    on_frame: Progress | None = None,
    names: tuple[str, str] = ("", ""),
) -> Generator[Pixels, None, None]:
    """Draw two runs side by side, each in half the width and to one scale; the shorter one stays at its last sample.

    Raises:
        InputError, RenderingError: as `film`.
    """
    count = max(len(one[1]), len(other[1]))
    half = replace(look, width=look.width // 2, note="")
    scale = Scale.of(one[0], other[0])
    films = [
        film(samples, indices + indices[-1:] * (count - len(indices)), half, None, scale, name)
        for (samples, indices), name in zip((one, other), names, strict=True)
    ]
    for done, pictures in enumerate(zip(*films, strict=True), 1):
        yield np.concatenate(pictures, axis=1)
        if on_frame is not None:
            on_frame(done, count)


def _panels(samples: Trajectory, look: Look, scale: Scale) -> dict[str, Panel]:
    """Return the plots of the lower corners: tip error, and muscle pressures (those needed, under length servos)."""
    size = (round(0.27 * look.width), round(0.25 * look.height))
    if size[0] < 160 or size[1] < 90:
        return {}
    red = Curve(1e3 * samples.tip_error, "#C0392B")
    error = Panel(size, samples.time, [red], "tip error [mm]", 1e3 * scale.error)
    arm = samples.arm
    if len(arm.sections) == 1:
        colours, names = muscle_hexes(arm), {}
    else:  # what the muscles of one section do differs less than what the sections do
        colours = [section_hex(group.section) for group in arm.groups for _ in range(group.routing.count)]
        names = {f"{group.section + 1}": section_hex(group.section) for group in arm.groups}
    highest = 1e-3 * float(pressure_limits(arm)[:, 1].min(initial=np.inf))
    if math.isfinite(highest):
        limit = highest if scale.pressure > 600 * highest else None
        title, values, top = "pressure needed [kPa]", 1e-3 * samples.pressure, 1e-3 * scale.pressure
    else:  # some muscles that no pressure drives
        limit, title, values, top = None, "tension [N]", samples.muscle_tensions, scale.tension
    curves = [Curve(values[:, i], colour) for i, colour in enumerate(colours)]
    needed = Panel(size, samples.time, curves, title, top, limit, names)
    return {"left": error, "right": needed}
