"""What is drawn of a run once its numbers are on disk: figures, page and film, each whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contarm_sim.errors import RenderingError
from contarm_sim.view.prints import Prints

FIGURES = ("path", "budget", "muscles")
FILMS = ("video.mp4", "video.gif")
NOT_YET = "not drawn yet"


def film_at_first(interrupted: bool, wanted: bool) -> str:
    """Return what `video` in summary.json says before anything is drawn; an interrupted run is not filmed."""
    return "not asked for" if not wanted else "interrupted" if interrupted else NOT_YET


def draw(job: Any, folder: Path, summary: dict[str, Any], prints: Prints) -> list[str]:
    """Draw figures, page and, if it is not drawn yet, film; keep `video` of the summary, here and on disk, true.

    A page without the film comes first, so that the film costs nothing but itself.

    Args:
        job: the run's `RunReport`.
        folder: holds the numbers.
        prints: what figures are written.

    Returns:
        the names of what an interruption left out.
    """
    from contarm_sim.files import write_whole
    from contarm_sim.stopping import breakable
    from contarm_sim.view.report.output import to_json

    filming = summary["video"] == NOT_YET
    try:
        with breakable():
            job.draw(folder, prints)
            job.write_page(folder, summary)
            if filming:
                summary["video"] = _film(job, folder)
                job.write_page(folder, summary)
        missing = []
    except KeyboardInterrupt:
        drawn = [name for name in FILMS if (folder / name).is_file()]
        if filming:
            summary["video"] = drawn[0] if drawn else "interrupted"
        figures = [name for stem in FIGURES for name in prints.all_names(stem)]
        wanted = [*figures, "report.html", *(drawn or FILMS[:1] if filming else ())]
        missing = [name for name in wanted if not (folder / name).is_file()]
    if filming:
        write_whole(folder / "summary.json", to_json(summary) + "\n")
    return missing


def _film(job: Any, folder: Path) -> str:
    """Film the run; return the file's name, or why there is none: numbers are never lost for want of a picture."""
    from contarm_sim.cli.terminal import progress, say
    from contarm_sim.stopping import came

    try:
        with progress("filming") as on_frame:
            name = str(job.film(folder, on_frame))
        say_backend()
    except RenderingError as error:
        if came() is not None:  # a library made that of the interruption
            raise KeyboardInterrupt from None
        say(f"no video: {error}")
        return f"none: {error}"
    if name.endswith(".gif"):
        say("no video encoder works here: an animated picture instead")
    return name


def say_backend() -> None:
    """Say so where MUJOCO_GL names a library that does not draw here, and another one did."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.rendering.gl import choose_backend

    note = choose_backend().note
    if note:
        say(note)
