"""Figures, films and reports of a recorded motion, as methods; `contarm_sim.view.notebook` makes them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from contarm_sim.display import Shown, drawing

if TYPE_CHECKING:
    from contarm_sim.display import Film, Report, Sheet

Figure = Literal["overview", "path", "budget", "muscles", "contact"]


class Showing(Shown):
    """The methods of a trajectory that show it."""

    def plot(
        self, figure: Figure = "overview", width: Literal["page", "column"] = "page", titles: bool = True
    ) -> Sheet:
        """Return a figure, a matplotlib Figure in the style of all figures, which notebooks show.

        Args:
            figure: `overview` (tip error, lengths and tensions of the muscles), or one of those that `contarm run`
                draws: `path`, `budget`, `muscles`, and `contact` of an arm that can touch something.
            width: 170 mm or 85 mm.
            titles: whether it has a heading.

        Raises:
            InputError: another figure or width, no samples, or a figure over time of poses at rest.
        """
        sheet: Sheet = drawing().plot(self, figure, width, titles)
        return sheet

    def film(
        self, path: str | Path | None = None, *, camera: str = "front", size: tuple[int, int] | None = None,
        fps: float | None = None, speed: float = 1.0, plots: bool = True, captions: bool = True, plain: bool = False,
        transparent: bool = False, on_frame: Callable[[int, int], object] | None = None,
    ) -> Film:  # fmt: skip
        """Film the motion and return the film, which notebooks play.

        Args:
            path: a .mp4, .mov, .webm, .gif or .webp to write it to, in place of what is there; default nowhere.
            camera: front, side, top, orbit or tip.
            size: width and height [pixels]; default 640 x 360, in a file 1280 x 720.
            fps: frames per second; default 20, in a file 30, of .gif and .webp 15, of poses at rest 2.
            speed: simulated over shown time.
            plots: of error and pressure, in the lower corners of larger films.
            captions: the words along the top.
            plain: the arm alone, without words, plots and anything drawn over it.
            transparent: neither floor nor sky nor shadow, words and plots; for .mov, .webm and .webp.
            on_frame: called with the number of frames drawn and their total; default a line on a terminal or in a
                notebook.

        Raises:
            InputError: a value that cannot be used, or a place that cannot be written to.
            RenderingError: no GL library draws here, or there is no encoder; a .gif needs none.
        """
        given = {
            "camera": camera, "size": size, "fps": fps, "speed": speed, "plots": plots, "captions": captions,
            "plain": plain, "transparent": transparent, "on_frame": on_frame,
        }  # fmt: skip
        film: Film = drawing().film(self, path, **given)
        return film

    def report(
        self, folder: str | Path | None = None, *, name: str = "motion", film: bool = False, controller: Any = None,
        on_frame: Callable[[int, int], object] | None = None,
    ) -> Report:  # fmt: skip
        """Judge the motion and return the report of `contarm run`, which notebooks show.

        Args:
            folder: to write to what `contarm run` leaves, for `contarm_sim.load` and `contarm render`; default nowhere.
                A folder that a run left is filled anew.
            name: of the motion, for the title.
            film: whether the motion is filmed too.
            controller: what drove the arm, if it was of your own, or a name.
            on_frame: as of `film`.

        Raises:
            InputError: poses at rest, fewer than two samples, or a folder that holds something else.
            RenderingError: the film cannot be made.
        """
        given = {"name": name, "film": film, "controller": controller, "on_frame": on_frame}
        report: Report = drawing().report(self, folder, **given)
        return report
