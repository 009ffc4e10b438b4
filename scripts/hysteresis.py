"""Draws the loops of `examples/hysteresis.py` into docs/images."""

from __future__ import annotations

import runpy
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt

ROOT = Path(__file__).resolve().parents[1]
COLOURS = {"backbone": "#1f5fa8", "entry": "#c0392b", "along the bend": "#27863a"}
SAID = {"backbone": "in the backbone", "entry": "at the winch", "along the bend": "along the bend"}


def main() -> None:
    """Draw three panels: tension at the winch by winding, each beside the arm without friction."""
    made = runpy.run_path(str(ROOT / "examples" / "hysteresis.py"))
    found, names, wound = made["found"], list(made["rubbing"]), 1e3 * made["wound"]
    figure, panels = plt.subplots(1, 3, figsize=(6.7, 2.5), sharey=True, layout="constrained")
    for panel, name in zip(panels, names[1:], strict=True):
        loop = found.start_tensions[names.index(name), :, 0]
        panel.plot(wound, found.start_tensions[0, :, 0], color="#9aa0a6", lw=1, label="no friction")
        panel.plot(wound, loop, color=COLOURS[name], lw=1.6)
        for place in (78, 108):  # half way in, and back
            panel.annotate("", (wound[place + 2], loop[place + 2]), (wound[place], loop[place]),
                           arrowprops={"arrowstyle": "-|>", "color": COLOURS[name], "lw": 1.6})  # fmt: skip
        panel.set_title(SAID[name], fontsize=9, color=COLOURS[name])
        panel.set_xlabel("wound in [mm]", fontsize=8)
        panel.tick_params(labelsize=8)
        panel.spines[["top", "right"]].set_visible(False)
        panel.set(xlim=(0, 20.5), ylim=(0, 1.06 * found.start_tensions[..., 0].max()))
    panels[0].set_ylabel("tension at the winch [N]", fontsize=8)
    panels[0].legend(frameon=False, fontsize=8, loc="upper left")
    figure.savefig(ROOT / "docs" / "images" / "hysteresis.png", dpi=200)


if __name__ == "__main__":
    main()
