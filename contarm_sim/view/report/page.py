"""report.html: one self-contained page of a run that opens offline, from disk or mail."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from contarm_sim.errors import EncodingError
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.results.compare import Comparison
from contarm_sim.results.summary import spread
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.sweeps.case_table import TABLES
from contarm_sim.view.report import contact_words as touch
from contarm_sim.view.report import uncertainty_words as said
from contarm_sim.view.report.filled import safe_json, write_filled
from contarm_sim.view.report.headline import headline, lead, standings
from contarm_sim.view.report.pictures import embedded, encoded, figure, unshown
from contarm_sim.view.report.space import space, telling
from contarm_sim.view.report.words import budget, explanation, muscle_words, remarks

PLOTLY = Path(__file__).parent / "vendor" / "plotly-gl3d.min.js.gz"
"""The plotting library of the interactive view, which the browser decompresses."""

CAPTIONS = {
    "path": "The path of the tip on the dome of reachable tips: targets, simulated tip, and the arm at the end.",
    "budget": "Tip error over time: parts along it, which add up to it; sizes of the parts; the orientation error.",
    "muscles": "Length changes of the muscles over time, what they differ from the arc's by, tensions, and pressures.",
}
_CAPTIONS_OF_SEVERAL = {
    "path": "The path of the tip in the hull of reachable tips: targets, simulated tip, and the sections at the end.",
    "budget": "Tip error over time: parts along it, which add up to it; sizes of the parts; what the tip moves where "
    "one section alone has a part; the orientation error.",
    "muscles": "Length changes of the muscles over time, what they differ from the arcs' by, tensions, and pressures, "
    "a column a section.",
}

UNCERTAIN = {
    "uncertainty": "Tip error over time: the nominal arm, and the band that 5 to 95 % of the sampled arms are in; "
    "below, its mean, its largest and its last value, arm by arm.",
    "uncertain_path": "Tips of sampled arms, all commanded as the nominal one, and their backbones at the end.",
    "causes": "Which uncertain parameter causes the spread: shares of the variance, with 95 % intervals.",
}

TOUCHED = {
    "contact": "Net forces of the objects on the arm over time; how far links and objects overlap; and "
    "which links touch when; darker: larger force.",
}

_DRAWN_BY = "`contarm render RUN`, where RUN is this folder, draws one."


def write_page(folder: Path, samples: Trajectory, comparison: Comparison, summary: dict[str, Any]) -> None:
    """Write report.html beside the figures and the film that a run's folder holds already."""
    arm, several, best = samples.arm, len(samples.arm.sections) > 1, telling(samples, comparison)
    gif, captions = folder / "video.gif", _CAPTIONS_OF_SEVERAL if several else CAPTIONS
    if "uncertainty" in summary:
        captions = captions | UNCERTAIN
    if "contact" in summary:
        captions = captions | TOUCHED
    video, no_video = _film(folder / "video.mp4", samples, best, summary["video"])
    write_filled(
        folder,
        "run.html.j2",
        arm,
        summary,
        title=_title(summary),
        headline=headline(summary),
        lead=lead(summary, arm),
        standings=standings(summary),
        remarks=remarks(summary),
        checks=summary["checks"],
        moment=f"{samples.time[best]:.2f} s",
        pulled=any(arm.gravity),
        several=several,
        video=video,
        gif=encoded(gif.read_bytes()) if gif.is_file() else None,
        no_video=no_video,
        space=safe_json(space(samples, comparison)),
        plotly=encoded(PLOTLY.read_bytes()),
        words=explanation(summary),
        budget=budget(summary) + (_section_rows(comparison, arm.length) if several else []),
        muscles=muscle_words(summary["muscle"], any(isinstance(group.law, PneumaticLaw) for group in arm.groups)),
        captions=captions,
        contact=_contact(summary),
        uncertain=_uncertain(summary, folder),
        figures={stem: figure(folder, stem) for stem in captions},
        unshown=unshown(folder, captions),
    )


def _uncertain(summary: dict[str, Any], folder: Path) -> dict[str, Any] | None:
    """Return what the page says of sampled arms, or None."""
    if "uncertainty" not in summary:
        return None
    found = summary["uncertainty"]
    causes = said.causes_words(found, "mean", "the tip error’s mean over time")
    return {
        "cases": said.cases_words(found),
        "errors": said.error_rows(found),
        "parameters": said.parameter_rows(found, "mean"),
        "causes": causes[0].upper() + causes[1:],
        "known": "reason" not in found["causes"]["mean"],
        "table": next((name for name in TABLES if (folder / name).is_file()), ""),
        "apart": said.apart_words(found),
    }


def _contact(summary: dict[str, Any]) -> dict[str, Any] | None:
    """Return what the page says of what the arm touches, or None where there is nothing to touch."""
    if "contact" not in summary:
        return None
    return {
        "said": touch.paragraph(summary),
        "columns": touch.columns(summary),
        "rows": touch.rows(summary),
        "legend": touch.legend(summary),
    }


def _film(film: Path, samples: Trajectory, best: int, state: str) -> tuple[dict[str, Any] | None, str]:
    """Return the film to embed, or None and why there is none; `state` is what the summary says of it."""
    if not film.is_file():
        return None, f"No film: {state.removeprefix('none: ')}. {_DRAWN_BY}"
    start, end = float(samples.time[0]), float(samples.time[-1])
    try:
        return embedded(film, end - start, float(samples.time[best]) - start), ""
    except EncodingError as error:
        return None, f"The film, {film.name}, is beside this page, which cannot show it: {error}."


def _section_rows(comparison: Comparison, length: float) -> list[tuple[str, list[float]]]:
    """Return rows of the error budget, as `budget` does: what the tip moves where one section alone has a part."""
    rows: list[tuple[str, list[float]]] = []
    for number in range(comparison.section_shape.shape[1]):
        rows.append((f"section {number + 1} alone", []))
        for name in ("discretisation", "servo", "shape"):
            found = spread(getattr(comparison, f"section_{name}")[:, number], length)
            rows.append((f"  {name}", [1e3 * found.max_m, 1e3 * found.rms_m, found.max_percent, found.rms_percent]))
    return rows


def _title(summary: dict[str, Any]) -> str:
    """Say what the run is of; how long it was to be is not always known."""
    lasting = "" if summary["duration"] is None else f"{summary['duration']:g} s, "
    return f"contarm run: {summary['path']}, {lasting}controller {summary['controller']}"
