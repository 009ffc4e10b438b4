"""Fits in notebooks: a table, figures by name, the report."""

from __future__ import annotations

from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from contarm_sim.errors import InputError
from contarm_sim.identify.fit_folder import save_fit
from contarm_sim.identify.fitted import Fit
from contarm_sim.inputs import as_path
from contarm_sim.view.notebook.page import card, grid
from contarm_sim.view.notebook.places import check_switches
from contarm_sim.view.notebook.reports import ToldReport
from contarm_sim.view.prints import WIDTHS
from contarm_sim.view.report.fits import words
from contarm_sim.view.report.fits.page import figures_of, numbered, write_fit_report
from contarm_sim.view.report.fits.summary import summary_of
from contarm_sim.view.report.output import OutputFolder, check_output, to_json
from contarm_sim.view.style import Sheet, drawn


def figure(fit: Fit, name: str, recording: int, width: Any, titles: bool) -> Sheet:
    """Return a figure of a fit, see `Fit.figure`.

    Raises:
        InputError: no such figure of the fit, no such recording, or no such width.
    """
    check_switches(titles=titles)
    if not isinstance(recording, int) or not 0 <= recording < len(fit.left):
        raise InputError("recording", recording, f"a whole number from 0 to {len(fit.left) - 1}")
    if width not in WIDTHS:
        raise InputError("width", repr(width), ", ".join(WIDTHS))
    found = figures_of(fit)
    stem = numbered(name, recording, fit) if isinstance(name, str) else ""
    if stem not in found:
        known = dict.fromkeys(each for each in found if each == stem or not each[-1].isdigit())
        known |= dict.fromkeys(each[: each.rindex("_")] for each in found if each[-1].isdigit())
        raise InputError("name", repr(name), ", ".join(known))
    return drawn(found[stem], width, titles)


def report(fit: Fit, folder: str | Path | None = None) -> ToldReport:
    """Report a fit, see `Fit.report`.

    Raises:
        InputError: the folder is there already, or cannot be written to.
    """
    target = None if folder is None else as_path("folder", folder, "a folder that is not there yet")
    if target is not None:
        check_output(target)
    summary = summary_of(fit, "from Python; fit.npz holds the fit, arm.toml and rig.toml what it found")
    with TemporaryDirectory() as made:
        place = Path(made) / "fit" if target is None else target
        with OutputFolder(place) as opened:
            save_fit(fit, opened.folder)
            (opened.folder / "summary.json").write_text(to_json(summary) + "\n")
            write_fit_report(opened.folder, fit, summary)
            page = (opened.folder / "report.html").read_text(encoding="utf-8")
    return ToldReport(page, summary, None if target is None else opened.target)


def html(fit: Fit) -> str:
    """Return what a notebook shows of a fit: what became of each parameter, and the errors."""
    lost = "".join(f"<br><small>{escape(line)}</small>" for line in words.undetermined(fit))
    rows = [[row[0], row[-1], *row[1:-1]] for row in words.rows_of(fit)]
    columns = words.parameter_columns(fit)
    errors = grid(words.error_columns(), [[row[0].replace("  ", "\u2003"), *row[1:]] for row in words.error_rows(fit)])
    table = grid([columns[0], columns[-1], *columns[1:-1]], rows, texts=2)
    return card(f"Fit: {words.headline(fit)}", table, "", f"{errors}{lost}")
