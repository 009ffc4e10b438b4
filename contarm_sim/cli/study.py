"""What the commands that run a study have in common: where results go, and how they are printed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click


def output_for(out: str | None, command: str) -> Path:
    """Return the folder that results go to, before the work starts.

    Raises:
        InputError: it exists, or cannot be written.
    """
    from contarm_sim.view.report.output import check_output, default_folder

    target = Path(out) if out is not None else default_folder(command)
    check_output(target)
    return target


def signed(result: Any) -> dict[str, Any]:
    """Return a study's result as a document, with the versions and the command that it comes from."""
    from contarm_sim.cli.terminal import command_line
    from contarm_sim.results.document import document
    from contarm_sim.versions import versions

    made: dict[str, Any] = document(result)
    return made | {"versions": versions(), "command": command_line()}


def deliver(
    target: Path,
    summary: dict[str, Any],
    as_json: bool,
    show: Callable[[], object],
    draw: Callable[[Path], object] = lambda folder: None,
    samples: dict[str, Any] | None = None,
) -> None:
    """Write summary.json and what `draw` draws, whole or not at all, then print the document or `show` it.

    Args:
        samples: what the printed document has beside the summary.
    """
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.report.output import OutputFolder, to_json

    with OutputFolder(target) as opened:
        (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
        draw(opened.folder)
    if as_json:
        click.echo(to_json(summary | (samples or {})))
    else:
        show()
    say(f"written: {opened.target}")
