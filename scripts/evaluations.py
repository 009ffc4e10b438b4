"""Learning watched: how fast, how long still, a score and a checkpoint now and then, and an end on a signal."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from learning import Point, draw_curve, read_points, write_points
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn
from stable_baselines3.common.callbacks import BaseCallback

from contarm_sim import stopping
from contarm_sim.files import appearing


class Evaluations(BaseCallback):
    """Scores a policy every so many steps, and keeps policy, table and curve in a folder.

    Args:
        folder: that has them.
        told: the settings of the run: task, steps, seeds, length of the arm, scores of others.
        score: returns the summary of the policy's score.
        count: scores along the way.
    """

    def __init__(self, folder: Path, told: dict[str, Any], score: Callable[[], dict[str, Any]], count: int) -> None:
        super().__init__()
        self._folder, self._told, self._score = folder, told, score
        self._every = told["steps"] / count
        self._spent = 0.0
        self.points: list[Point] = []
        self._bar = Progress(
            TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(), console=Console(stderr=True), transient=True,
            disable=not Console(stderr=True).is_terminal,
        )  # fmt: skip

    def _on_training_start(self) -> None:
        table, done = self._folder / "curve.csv", self.model.num_timesteps
        self.points = [point for point in (read_points(table) if table.exists() else []) if point.steps <= done]
        self._spent, self._first = self.points[-1].seconds if self.points else 0.0, done
        self._began = time.monotonic()
        self._task = self._bar.add_task(self._told["task"], total=self._told["steps"], completed=done, rate="")
        self._bar.start()

    def _on_step(self) -> bool:
        self._bar.update(self._task, completed=self.num_timesteps, rate=f"{self._rate:,.0f} steps/s")
        return stopping.came() is None

    def _on_rollout_start(self) -> None:
        if stopping.came() is None and (not self.points or self.num_timesteps >= self.points[-1].steps + self._every):
            self.keep()

    def _on_training_end(self) -> None:
        self._bar.stop()
        if stopping.came() is None and self.points[-1].steps < self.num_timesteps:
            self.keep()
        else:
            self._save()

    @property
    def _rate(self) -> float:
        return (self.num_timesteps - self._first) / max(time.monotonic() - self._began, 1e-9)

    def keep(self) -> None:
        """Score the policy as it is, say so, and write all that there is."""
        start = time.monotonic()
        found = self._score()
        self.points.append(Point(self.num_timesteps, self._spent + start - self._began, **found))
        self._save()
        write_points(self._folder / "curve.csv", self.points)
        draw_curve(self._folder, "curve", self.points, self._told["scores"], self._told)
        self._say(self.points[-1])
        self._began += time.monotonic() - start  # scores are no learning

    def _save(self) -> None:
        with appearing(self._folder / "policy.zip") as scratch:
            self.model.save(scratch)

    def _say(self, point: Point) -> None:
        told, left = self._told, self._told["steps"] - point.steps
        words = (
            f"{point.steps:9,} of {told['steps']:,}   reward {point.reward_mean:.3f}"
            f" (baseline {told['scores']['baseline']['reward_mean']:.3f})"
            f"   solved {point.solved} of {told['seeds']}   error {1e3 * point.error_mean_m:.2f} mm"
        )
        if self.num_timesteps > self._first:
            rate = (point.steps - self._first) / max(point.seconds - self._spent, 1e-9)
            words += f"   {rate:,.0f} steps/s"
            words += f", {max(left, 0) / rate:.0f} s left" if left > 0 else ""
        if not self._bar.disable:
            self._bar.console.print(words, highlight=False)
        else:
            print(words, flush=True)
