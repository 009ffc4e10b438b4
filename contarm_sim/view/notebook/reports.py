"""The report of a motion that notebooks show, and the folder of `contarm run` around it."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contarm_sim.control.base import Controller
from contarm_sim.control.registry import controller as resolved
from contarm_sim.errors import InputError, expect
from contarm_sim.files import appearing
from contarm_sim.inputs import as_path, quoted
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.notebook.places import check_progress, check_switches, not_written, told
from contarm_sim.view.rendering.film import Progress
from contarm_sim.view.report.output import OutputFolder, check_output, to_json
from contarm_sim.view.report.run import RunReport
from contarm_sim.view.report.words import in_short, verdict_lines

HEIGHT = 640
"""Height of the report in a notebook [pixels]."""

_ALLOWED = "a folder that is new, empty, or left by a run"

_FILMS = ("video.mp4", "video.gif")


@dataclass(frozen=True, repr=False, eq=False)
class Report:
    """A report; notebooks show it in a frame.

    Attributes:
        page: the HTML of report.html, which needs no other file.
        summary: every number in it, as in summary.json.
        folder: the folder that it was written to, or None.
    """

    page: str
    summary: dict[str, Any]
    folder: Path | None

    def save(self, path: str | Path) -> None:
        """Write the page alone to a .html, in place of what is there.

        Raises:
            InputError: a name that does not end in .html, or a place that cannot be written to.
        """
        allowed = "a name that ends in .html, in an existing folder"
        target = as_path("path", path, allowed)
        if target.suffix != ".html" or not target.parent.is_dir():
            raise InputError("path", quoted(target), allowed)
        try:
            with appearing(target) as scratch:
                scratch.write_text(self.page, encoding="utf-8")
        except OSError as error:
            raise not_written(target, error) from error

    def __repr__(self) -> str:
        said = [f"{name}: {words}" for name, words in verdict_lines(self.summary)]
        if self.summary["interrupted"]:
            said.insert(0, f"interrupted at {(self.summary['samples'] - 1) / self.summary['rate']:.2f} s")
        return "\n  ".join([f"Report({'not written' if self.folder is None else self.folder}", *said]) + ")"

    @property
    def _title(self) -> str:
        return in_short(self.summary)

    def _repr_html_(self) -> str:
        frame = f'<iframe title="{escape(self._title)}" sandbox="allow-scripts" srcdoc="{escape(self.page)}"'
        return f'{frame} style="width:100%;height:{HEIGHT}px;border:1px solid rgba(128,128,128,.4)"></iframe>'


class ToldReport(Report):
    """A report whose summary says in words what it comes to."""

    def __repr__(self) -> str:
        where = "not written" if self.folder is None else self.folder
        return f"Report({where}\n  {self.summary['in_words']})"

    @property
    def _title(self) -> str:
        return str(self.summary["in_words"])


def report(
    samples: Trajectory, folder: str | Path | None = None, *, name: str = "motion", film: bool = False,
    controller: str | Controller | None = None, on_frame: Progress | None = None,
) -> Report:  # fmt: skip
    """Judge a motion and report it, see `Trajectory.report`."""
    expect("name", name, str)
    check_switches(film=film)
    check_progress(on_frame)
    if not samples.moving or len(samples) < 2:
        what = "poses at rest" if not samples.moving else f"{len(samples)} samples"
        raise InputError("trajectory", what, "a motion of two samples or more")
    target = None if folder is None else _target(as_path("folder", folder, _ALLOWED))
    job = RunReport(samples, controller=None if controller is None else resolved(controller))
    summary = job.told(name, command="from Python; trajectory.npz holds the arm, its targets and its samples")
    if samples.status == "interrupted":
        summary["duration"] = None  # a recording does not know how long it was to be
    with TemporaryDirectory() as made:
        place = Path(made)
        job.write(place)
        job.draw(place)
        if film:
            summary["video"] = job.film(place, told(on_frame))
        (place / "summary.json").write_text(to_json(summary) + "\n")
        job.write_page(place, summary)
        page = (place / "report.html").read_text(encoding="utf-8")
        if target is not None:
            target = _fill(target, place)
    return Report(page, summary, target)


def _target(folder: Path) -> Path:
    """Return a folder that may be filled.

    Raises:
        InputError: it is a file, or holds what no run left, or nothing can be written there.
    """
    try:
        if folder.is_dir() and (not any(folder.iterdir()) or (folder / "trajectory.npz").is_file()):
            return folder
        check_output(folder)
    except InputError as error:
        raise InputError("folder", error.given, _ALLOWED) from None
    except OSError as error:
        raise InputError("folder", f"{folder} ({error.strerror})", "a folder that can be read and written") from error
    return folder


def _fill(target: Path, made: Path) -> Path:
    """Put files into a folder, and return it; what a run left there is replaced, each file whole or not at all."""
    if not target.exists():
        with OutputFolder(target) as opened:
            shutil.copytree(made, opened.folder, dirs_exist_ok=True)
        return opened.target
    try:
        for name in _FILMS:
            (target / name).unlink(missing_ok=True)
        for file in made.iterdir():
            with appearing(target / file.name) as scratch:
                shutil.copyfile(file, scratch)
    except OSError as error:
        raise InputError("folder", f"{target} ({error.strerror})", "a folder that can be written") from error
    return target
