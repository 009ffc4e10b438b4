"""Draws what a replay of a recording and a choice of commands look like, into docs/images.

The arm that is recorded has slack and disks a little aside, which the fit does not know of: an error of the model.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from contarm_sim import Actuation, Arm, Marker, Rig, covariance_of, excite, fit, presets, replay
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.synthetic import random_windings, recorded
from contarm_sim.model.named import with_parameters
from contarm_sim.view.rendering.look import Look
from contarm_sim.view.rendering.replayed import ReplayShot
from contarm_sim.view.report.excited import draw_gain
from contarm_sim.view.style import drawn, write

IMAGES = Path(__file__).parents[1] / "docs" / "images"

DISKS = (Marker(name="disk 1", xi=0.4), Marker(name="disk 2", xi=0.72), Marker(name="tip"))
RIG = Rig(markers=DISKS, actuation=Actuation(channels=tuple(range(9))))
FREE = ["section_1.bending_stiffness", "section_2.bending_stiffness", "section_3.bending_stiffness", "frame.x"]


def day(arm: Arm, rig: Rig, seed: int) -> Recording:
    """Return a recording of 120 samples in the rig as it is believed to be."""
    windings, patterns = random_windings(arm, 120, seed)
    made = recorded(arm, rig, windings, seed=seed, noise=0.002, blocks=patterns, name=f"day {seed}")
    return made.in_rig(RIG)


def main(images: Path = IMAGES) -> None:
    """Draw replay.png, replay_film.png and excite.png."""
    arm = presets.tendon()
    real = with_parameters(arm, {"section_1.bending_stiffness": 0.062, "section_3.bending_stiffness": 0.016})
    aside = tuple(replace(one, offset=(0.006 * k, 0.006, 0.0)) for k, one in enumerate(DISKS))
    rig = replace(RIG, markers=aside, actuation=replace(RIG.actuation, slack=(0.0008, 0, 0) * 3))
    first = day(real, rig, 1)
    found = fit(arm, first, FREE)
    seen = replay(found.arm, day(real, rig, 2).in_rig(found.rig), covariance_of(found))
    write(seen.figure("components"), images / "replay.png")
    worst = int(np.argmax(seen.shape_error))
    one = replace(seen, recording=seen.recording, held_out=np.ones(len(seen), dtype=bool))
    pictures = ReplayShot(one, Look(960, 540)).frames()
    picture = next(picture for row, picture in enumerate(pictures) if row == worst)
    Image.fromarray(picture).save(images / "replay_film.png", optimize=True)
    told = excite(found.arm, found.rig, FREE, candidates=24, count=8, noise=found.noise)
    write(drawn(lambda sheet: draw_gain(sheet, told)), images / "excite.png")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
