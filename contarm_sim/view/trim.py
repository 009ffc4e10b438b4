"""Sheets as tall as what is on them: panels of equal scales leave room that print does not have."""

from __future__ import annotations

from contarm_sim.view.style import INCH, Sheet

_RIM = 0.8


def trim(sheet: Sheet, most: float) -> None:
    """Make a sheet as tall as its panels need at its width, at most so tall [mm].

    Panels must hang from the top of their room (anchor "N").
    """
    sheet.tall(most)
    for _ in range(2):  # cut, texts may wrap or move a little
        sheet.draw_without_rendering()
        spare = INCH * float(sheet.get_tightbbox().y0) - _RIM
        sheet.tall(INCH * float(sheet.get_figheight()) - spare)
