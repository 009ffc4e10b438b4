"""What a run leaves behind: numbers, samples and model first, then figures, page and film."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contarm_sim.control.base import Controller
from contarm_sim.errors import EncodingError
from contarm_sim.results.document import document
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.studies.judged_run import judge_run
from contarm_sim.versions import versions
from contarm_sim.view.prints import PLAIN, Prints
from contarm_sim.view.report.budget import draw_budget
from contarm_sim.view.report.contact_figure import draw_contact
from contarm_sim.view.report.run_figures import draw_muscles, draw_path
from contarm_sim.view.report.run_files import write_run
from contarm_sim.view.report.samples_csv import write_samples
from contarm_sim.view.report.words import in_short
from contarm_sim.view.style import Draw, save

if TYPE_CHECKING:
    from contarm_sim.sweeps.spread_of_motion import UncertainMotion
    from contarm_sim.view.rendering.cloud import Cloud


class RunReport:
    """A run beside the closed forms.

    Attributes:
        summary: every number shown, plain values, SI units but where the name says otherwise. `constant_curvature`
            says whether it holds; `verdict` whether the simulation is explained and converged and targets are met, with
            `checks`. `motion` is None where some commanded pose has no rest or contact is not known, `sag` without
            gravity, `unexplained` where no ideal rod is found. With `spread`, the same motion of sampled arms, there is
            `uncertainty`.
    """

    def __init__(
        self, run: Trajectory, poses: int = 100, controller: Controller | None = None,
        spread: UncertainMotion | None = None,
    ) -> None:  # fmt: skip
        self._samples, self._pressures, self._spread = run, run.actuation == "pressures", spread
        judged = judge_run(run, poses, controller)
        self._comparison, self._motion = judged.comparison, judged.swing
        self.summary: dict[str, Any] = document(judged) | {"versions": versions()}
        if spread is not None:
            self.summary["uncertainty"] = spread.document()

    def told(
        self, path: str, *, command: str, video: str = "not asked for", duration: float | None = None,
        parameters: dict[str, Any] | None = None, project: str = "refuse", direction: Any = None,
    ) -> dict[str, Any]:  # fmt: skip
        """Return the summary with what was asked for, as summary.json and report.html have it.

        Args:
            path: its name.
            command: how to do it again, in words.
            video: the name of the film, or why there is none.
            duration: of the whole path [s]; default that of the run.
            parameters: of the path.
            project: what was done with targets off the dome.
            direction: of the tip on the whole way, or None.
        """
        time = self._samples.time
        asked = {
            "path": path,
            "duration": float(time[-1]) if duration is None else duration,
            "path_parameters": parameters or {},
            "project": project,
        }
        if direction is not None:
            asked["direction"] = direction
        rate = (len(time) - 1) / float(time[-1] - time[0])
        asked |= {"timestep": self._samples.timestep, "rate": round(rate, 6), "command": command, "video": video}
        return self.summary | asked

    def write(self, folder: Path) -> None:
        """Write trajectory.npz, samples.csv, contacts.csv, arm.xml and arm.toml; of sampled arms a table and more."""
        samples, comparison = self._samples, self._comparison
        write_run(folder, samples)
        asked = "pressure_asked_pa" if self._pressures else "setpoint_m"
        write_samples(folder / "samples.csv", {"run": (samples, comparison)}, asked)
        if self._spread is not None:
            from contarm_sim.sweeps.case_table import write_cases

            write_cases(folder, self._spread)
            if (cloud := self._cloud()) is not None:
                cloud.save(folder)

    def _cloud(self) -> Cloud | None:
        """Return sampled arms as a film shows them, if there are any."""
        from contarm_sim.view.rendering.cloud import Cloud

        found = self._spread
        return Cloud(found.bones, found.band) if found is not None and len(found.bones) else None

    @property
    def figures(self) -> dict[str, Draw]:
        """What draws the figures, by name: `path`, `budget`, `muscles`, `contact`, and those of sampled arms."""
        given, spread = (self._samples, self._comparison), self._spread
        figures: dict[str, Draw] = {
            "path": lambda sheet: draw_path(sheet, *given),
            "budget": lambda sheet: draw_budget(sheet, *given, self._motion),
            "muscles": lambda sheet: draw_muscles(sheet, self._samples),
        }
        if self._samples.contacts is not None:
            figures["contact"] = lambda sheet: draw_contact(sheet, self._samples)
        if spread is not None:
            from contarm_sim.view.report.uncertainty import figures_of_motion

            figures |= figures_of_motion(spread)
        return figures

    def draw(self, folder: Path, prints: Prints = PLAIN) -> None:
        """Draw all figures, each file whole or not at all."""
        for stem, draw in self.figures.items():
            save(folder, stem, draw, prints)

    def write_page(self, folder: Path, summary: dict[str, Any]) -> None:
        """Write report.html around the figures and the film that are there; `summary` has more than the report's."""
        from contarm_sim.view.report.page import write_page

        write_page(folder, self._samples, self._comparison, summary)

    def film(self, folder: Path, on_frame: Callable[[int, int], object]) -> str:
        """Write video.mp4 and return its name; where there is no encoder, video.gif, smaller and slower.

        Raises:
            RenderingError: nothing draws here, or the encoder failed.
        """
        from contarm_sim.view.rendering.encode import encoder
        from contarm_sim.view.rendering.formats import SMALL, usual_fps
        from contarm_sim.view.rendering.look import Look
        from contarm_sim.view.rendering.video import Shot, write_gif, write_video

        look, cloud = Look(note=in_short(self.summary)), self._cloud()
        if cloud is not None:
            look = replace(look, overlays=replace(look.overlays, cloud=cloud))
        try:
            encoder()
        except EncodingError:
            small, fps = replace(look, width=SMALL[0], height=SMALL[1]), usual_fps(".gif", True, small=True)
            write_gif(Shot(self._samples, small, fps), folder / "video.gif", on_frame)
            return "video.gif"
        write_video(Shot(self._samples, look), folder / "video.mp4", on_frame)
        return "video.mp4"
