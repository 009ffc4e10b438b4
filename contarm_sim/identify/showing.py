"""Figures and the report of a fit, as methods; `contarm_sim.view.notebook` makes them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from contarm_sim.display import Shown, drawing

if TYPE_CHECKING:
    from contarm_sim.display import Report, Sheet

Figure = Literal[
    "parameters", "correlation", "singular_values", "starts", "paths", "blocks", "over_time", "distribution",
    "by_command", "history",
]  # fmt: skip


class ShowingFit(Shown):
    """The methods of a fit that show it."""

    def figure(
        self, name: Figure = "parameters", recording: int = 0, width: Literal["page", "column"] = "page",
        titles: bool = True,
    ) -> Sheet:  # fmt: skip
        """Return a figure, a matplotlib Figure in the style of all figures, which notebooks show.

        Args:
            name: of the figure, as files of a report have them: `parameters` with intervals; `correlation` of their
                errors; `singular_values`; costs of the `starts`; of a recording `paths` measured and predicted, errors
                by `blocks`, `over_time`, their `distribution`, `by_command`, and by `history`: which way commands went.
            recording: that errors are of, from 0.
            width: 170 mm or 85 mm.
            titles: whether it has a heading.

        Raises:
            InputError: another figure, recording or width, or one that this fit has not: of one start, say.
        """
        sheet: Sheet = drawing().fit_figure(self, name, recording, width, titles)
        return sheet

    def report(self, folder: str | Path | None = None) -> Report:
        """Return the report of `contarm fit`, which notebooks show.

        Args:
            folder: new, to write to what `contarm fit` leaves; default nowhere.

        Raises:
            InputError: a folder that is there already, or cannot be written.
        """
        report: Report = drawing().fit_report(self, folder)
        return report
