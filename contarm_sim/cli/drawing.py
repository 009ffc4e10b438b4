"""What is drawn of a run once its numbers are on disk: figures, page and film, each whole or not at all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from contarm_sim.errors import MESSAGE, ContarmError, RenderingError, one_line
from contarm_sim.view.prints import Prints

FILMS = ("video.mp4", "video.gif")
NOT_YET = "not drawn yet"

MACHINE = (RenderingError, OSError, MemoryError)
"""What fails for want of something on a machine: the rest of a run goes on. All else is a fault, and shows as one."""


def film_at_first(interrupted: bool, wanted: bool) -> str:
    """Return what `video` in summary.json says before anything is drawn; an interrupted run is not filmed."""
    return "not asked for" if not wanted else "interrupted" if interrupted else NOT_YET


def draw(
    job: Any, folder: Path, summary: dict[str, Any], prints: Prints, again: str = "contarm render {}"
) -> tuple[list[str], bool]:
    """Draw figures, page and, if it is not drawn yet, film; keep `video` of the summary, here and on disk, true.

    A page without the film comes first, so that the film costs nothing but itself. What cannot be drawn or written is
    said in a line, and the rest goes on.

    Args:
        job: the run's `RunReport`.
        folder: holds the numbers.
        prints: what figures are written.
        again: the command that films it later, with {} for the folder.

    Returns:
        the names of what an interruption left out, and whether a figure, the page or the summary cannot be written.
    """
    from contarm_sim.files import write_whole
    from contarm_sim.stopping import breakable
    from contarm_sim.view.report.output import to_json

    filming, written = summary["video"] == NOT_YET, []
    try:
        with breakable():
            for stem, figure in job.figures.items():
                written.append(_drawn(folder, stem, figure, prints))
            written.append(_tried("no report.html", lambda: job.write_page(folder, summary)))
            if filming:
                summary["video"] = _film(job, folder, again)
                loss = "report.html is as before the film" if written[-1] else "no report.html"
                written.append(_tried(loss, lambda: job.write_page(folder, summary)))
        missing = []
    except KeyboardInterrupt:
        drawn = [name for name in FILMS if (folder / name).is_file()]
        if filming:
            summary["video"] = drawn[0] if drawn else "interrupted"
        figures = [name for stem in job.figures for name in prints.all_names(stem)]
        wanted = [*figures, "report.html", *(drawn or FILMS[:1] if filming else ())]
        missing = [name for name in wanted if not (folder / name).is_file()]
    if filming:
        text = to_json(summary) + "\n"
        written.append(_tried("summary.json is as before the film", lambda: write_whole(folder / "summary.json", text)))
    return missing, not all(written)


def _drawn(folder: Path, stem: str, figure: Any, prints: Prints) -> bool:
    """Draw a figure; tell whether that went well, and say which files are missing otherwise."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.style import save

    try:
        save(folder, stem, figure, prints)
    except MACHINE as error:
        missing = [name for name in prints.all_names(stem) if not (folder / name).is_file()]
        say(f"no {', '.join(missing)}: {_reason(error)}")
        return False
    return True


def _tried(loss: str, write: Callable[[], object]) -> bool:
    """Write something; tell whether that went well, and say what is lost otherwise."""
    from contarm_sim.cli.terminal import say

    try:
        write()
    except MACHINE as error:
        say(f"{loss}: {_reason(error)}")
        return False
    return True


def _film(job: Any, folder: Path, again: str) -> str:
    """Film the run; return the file's name, or why there is none: nothing is lost for want of a film."""
    from contarm_sim.cli.terminal import progress, say
    from contarm_sim.stopping import came

    try:
        with progress("filming") as on_frame:
            name = str(job.film(folder, on_frame))
        say_backend()
    except Exception as error:
        if came() is not None:  # a library made that of the interruption
            raise KeyboardInterrupt from None
        if not isinstance(error, MACHINE):
            error.add_note(f"Numbers, figures and report.html are whole: {folder}")
            raise
        say(f"no video: {_reason(error)}; it is drawn by: {again.format(folder)}")
        return f"none: {_reason(error)}"
    if name.endswith(".gif"):
        say("there is no video encoder: an animated picture instead")
    return name


def _reason(error: Exception) -> str:
    """Return what went wrong in a line."""
    if isinstance(error, OSError) and error.strerror:
        return f"cannot write: {error.strerror}"
    said = one_line(str(error), MESSAGE)
    return said if isinstance(error, ContarmError) else f"{type(error).__name__}{': ' if said else ''}{said}"


def say_missing(missing: list[str], again: str = "") -> None:
    """Say what an interruption left out.

    Args:
        again: the command that films it later, if one does.
    """
    from contarm_sim.cli.terminal import say

    what = f"interrupted while drawing, so {', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing"
    say(f"{what}; the numbers are whole" + (f", and a film of them is drawn by: {again}" if again else ""))


def say_backend() -> None:
    """Say so where MUJOCO_GL names a library that does not draw here, and another one did."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.view.rendering.gl import choose_backend

    note = choose_backend().note
    if note:
        say(note)
