"""What a learner reached and when: kept as a table, drawn beside the baseline and chance."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from contarm_sim.envs.task import TOLERANCE
from contarm_sim.files import write_whole
from contarm_sim.view.colours import ANALYTIC, LIMIT, SIMULATED
from contarm_sim.view.style import Sheet, save

NAMES = {"baseline": ("closed-form baseline", ANALYTIC, "--"), "random": ("chance", LIMIT, ":")}
"""What a learner is compared with: in words, its colour and line."""


@dataclass(frozen=True)
class Point:
    """Scores after some steps.

    Attributes:
        steps: actions learned from, of all arms together.
        seconds: of learning until then, evaluations left out [s].
        reward_mean: mean reward of an action.
        solved: episodes solved.
        error_mean_m, error_largest_m: by which they are judged [m].
    """

    steps: int
    seconds: float
    reward_mean: float
    solved: int
    error_mean_m: float
    error_largest_m: float


def write_points(path: Path, points: list[Point]) -> None:
    """Write a table (.csv), whole or not at all."""
    text = io.StringIO()
    table = csv.DictWriter(text, [field.name for field in fields(Point)], lineterminator="\n")
    table.writeheader()
    table.writerows(asdict(point) for point in points)
    write_whole(path, text.getvalue())


def read_points(path: Path) -> list[Point]:
    """Read what `write_points` wrote."""
    kinds = {"steps": int, "solved": int}
    with path.open(newline="") as file:
        return [Point(**{k: kinds.get(k, float)(v) for k, v in row.items()}) for row in csv.DictReader(file)]


def draw_curve(folder: Path, stem: str, points: list[Point], others: dict[str, Any], told: dict[str, Any]) -> None:
    """Draw reward and error by steps (.png), those of other policies as level lines.

    Args:
        others: summaries of scores, by the names of `NAMES`.
        told: the task, its number of `seeds` and the arm's `length` [m].
    """
    save(folder, stem, _curve(points, others, told))


def _curve(points: list[Point], others: dict[str, Any], told: dict[str, Any]) -> Callable[[Sheet], None]:
    def draw(sheet: Sheet) -> None:
        sheet.tall(72 if sheet.wide else 120)
        sheet.heading(f"{told['task']}: what was learned, scored over {told['seeds']} episodes")
        axes = sheet.subplots(*((1, 2) if sheet.wide else (2, 1)))
        steps = [point.steps / 1000 for point in points]
        for axis, name, scale in zip(axes, ("reward_mean", "error_mean_m"), (1.0, 1e3), strict=True):
            values = [scale * getattr(point, name) for point in points]
            axis.plot(steps, values, color=SIMULATED, marker="o", label="learned", clip_on=False, zorder=3)
            for other, (words, colour, line) in NAMES.items():
                axis.axhline(scale * others[other][name], color=colour, linestyle=line, label=words)
            axis.set_xlabel("actions learned from [thousands]")
            axis.set_xlim(0, max(1.02 * max(steps), 0.001))
        axes[0].set_ylabel("mean reward of an action")
        axes[0].set_ylim(0, 1)
        axes[1].set_ylabel("mean error [mm]")
        axes[1].set_yscale("log")
        axes[1].yaxis.set_major_formatter("{x:g}")
        low, high = axes[1].get_ylim()
        axes[1].axhspan(
            low, 1e3 * TOLERANCE * told["length"], color=LIMIT, alpha=0.15, lw=0, label="within 1 % of length"
        )
        axes[1].set_ylim(low, high)
        handles, words = axes[1].get_legend_handles_labels()
        sheet.legend(handles, words, loc="outside lower center", ncols=4 if sheet.wide else 2)

    return draw
