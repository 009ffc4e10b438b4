"""Films of `contarm demo` for the docs: docs/images/grasp.gif, reach-around.gif and lean.gif."""

import sys
from importlib import import_module
from pathlib import Path

from contarm_sim.cli.demo import NAMES, shot
from contarm_sim.view.rendering.video import write_gif

IMAGES = Path(__file__).parents[1] / "docs" / "images"
SIZES = {"grasp": (400, 600, 1.5), "reach-around": (640, 440, 1.0), "lean": (640, 440, 1.0)}
"""Width and height [pixels], and simulated over shown time."""

LETTERS = 14.5
"""Size of the letters [pixels]: to be read on a telephone too."""

FPS = 10.0

for name in sys.argv[1:] or NAMES:
    width, height, speed = SIZES[name]
    found = import_module(f"contarm_sim.demos.{name.replace('-', '_')}").demonstrate()
    target = IMAGES / f"{name}.gif"
    target.unlink(missing_ok=True)
    write_gif(shot(found, (width, height), FPS, speed, LETTERS / height), target)
