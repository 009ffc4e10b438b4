"""Draws an arm that leans on a post, and what it touches, into docs/images."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from contarm_sim import Arm, Reference, presets, simulate
from contarm_sim.model.objects import Object
from contarm_sim.motion.time_step import Stepping
from contarm_sim.view.rendering.film import film
from contarm_sim.view.rendering.look import Look
from contarm_sim.view.style import write

IMAGES = Path(__file__).parents[1] / "docs" / "images"

OBJECTS = (
    Object(name="floor", shape="plane", position=(0, 0, 0.42), axis=(0, 0, -1)),
    Object(name="post", shape="cylinder", radius=0.02, length=0.5, position=(0.09, 0, 0.17), axis=(0, 1, 0)),
    Object(name="box", shape="box", size=(0.07, 0.09, 0.06), mass=0.3, position=(-0.16, -0.06, 0.39),
           colour=(0.25, 0.50, 0.70)),
    Object(name="ball", shape="sphere", radius=0.03, mass=0.05, position=(0.02, -0.2, 0.39), colour=(0.80, 0.27, 0.22)),
)  # fmt: skip


def lean() -> Arm:
    """Return the arm and its objects."""
    return replace(presets.two(), world=replace(presets.HANGING, objects=OBJECTS))


def main(images: Path = IMAGES) -> None:
    """Draw contact_film.png and contact_report.png."""
    arm, time = lean(), 0.01 * np.arange(301)
    rise = np.minimum(time / 2, 1)
    bend = np.stack([0.9 * rise, 0 * rise, 1.5 * rise, 0.3 * rise], axis=1)
    run = simulate(arm, Reference.from_bends(bend, arm, time), "servo", stepping=Stepping(0.00125))
    Image.fromarray(next(film(run, [250], Look(1280, 720)))).save(images / "contact_film.png", optimize=True)
    write(run.plot("contact"), images / "contact_report.png")
    print(run)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
