"""Prints what README shows of fresh runs, in Markdown: the table of results, or with `run` the spiral's first lines."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]

Row = tuple[str, float, float, str]
"""What was simulated; largest tip error and what an ideal rod leaves of it [% of length]; the tensions [N]."""

SCENARIOS = {
    "ideal": "poses at rest, bends to 170 degrees, no gravity",
    "gravity": "the same, hanging",
    "payload": "the same, hanging with 100 g",
    "upright": "the same, upright",
}


def contarm(*words: str) -> Any:
    """Return the JSON document that a command prints.

    Raises:
        subprocess.CalledProcessError: it ended with an error.
    """
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "contarm_sim", *words, "--json", "--out", str(Path(folder) / "out")]
        done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def _row(what: str, summary: dict[str, Any]) -> Row:
    left = summary["unexplained"] or summary["shape"]
    force = summary["muscle"]
    tensions = f"{force['min_force_n']:.1f} to {force['max_force_n']:.1f}"
    return what, summary["tip_error"]["max_percent"], left["max_percent"], tensions


def spiral() -> Row:
    """Simulate the default spiral; takes two seconds."""
    return _row("spiral in 10 s, bends to 120 degrees, no gravity", contarm("run", "--no-video"))


def at_rest() -> list[Row]:
    """Simulate poses at rest over the whole dome; takes ten seconds."""
    summary = contarm("validate")
    return [_row(what, summary[name]) for name, what in SCENARIOS.items()]


def line(row: Row) -> str:
    """Return a row of the table."""
    what, error, left, tensions = row
    return f"| {what} | {error:.2f} | {left:.3f} | {tensions} |"


def head(lines: int = 11) -> str:
    """Return the first lines that `contarm run` prints, fenced."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "contarm_sim", "run", "--no-video", "--out", str(Path(folder) / "out")]
        done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    shown = [text.rstrip() for text in done.stdout.splitlines()[:lines]]
    return "\n".join(["```text", *shown, "```"])


def main() -> None:
    """Print the table, or the spiral's first lines."""
    if sys.argv[1:] == ["run"]:
        print(head())
        return
    columns = "largest tip error against the arc [% of length] | distance from a rod model [% of length]"
    print(f"| simulated | {columns} | tensions [N] |")
    print("|---|---|---|---|")
    print("\n".join(line(row) for row in [spiral(), *at_rest()]))


if __name__ == "__main__":
    main()
