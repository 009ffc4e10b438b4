"""report.html: one self-contained page of a run that opens offline, from disk or mail."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim.files import write_whole
from contarm_sim.model.arm_file import arm_to_toml
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.results.compare import Comparison
from contarm_sim.results.summary import spread
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.report.words import budget, explanation, muscle_words, remarks, verdict_lines
from contarm_sim.view.sections import backbone_lines, reachable_tips

LARGEST_VIDEO = 1_000_000
"""A larger film [bytes] is embedded in a smaller size: the page stays fit for mail."""

PLOTLY = Path(__file__).parent / "vendor" / "plotly-gl3d.min.js.gz"
"""The plotting library of the interactive view, which the browser decompresses."""

POINTS = 600
"""Points of a line in the interactive view, at most."""

FIGURES = {
    "path.png": "Tip path on the dome of reachable tips: targets dashed, simulated tip solid, backbone at the end",
    "budget.png": "Tip error over time and its parts, on a logarithmic scale; orientation error below",
    "muscles.png": "Length changes, tensions and pressures of the muscles over time; the arc dotted",
}
_FIGURES_OF_SEVERAL = {
    "path.png": "Tip path in the hull of reachable tips: targets dashed, simulated tip solid, the sections at the end",
    "budget.png": "Tip error over time and its parts, then what the tip moves where one section alone has a part, on "
    "logarithmic scales; orientation error below",
    "muscles.png": "Length changes, tensions and pressures of the muscles over time, a column a section; arcs dotted",
}


def write_page(folder: Path, samples: Trajectory, comparison: Comparison, summary: dict[str, Any]) -> None:
    """Write report.html beside the figures and the film that a run's folder holds already."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    page = Environment(
        loader=PackageLoader("contarm_sim.view", "report"), autoescape=True, undefined=StrictUndefined
    ).get_template("page.html.j2")
    film, several = folder / "video.mp4", len(samples.arm.sections) > 1
    text = page.render(
        title=f"contarm: {summary['path']}, {summary['duration']:g} s, controller {summary['controller']}",
        summary=summary,
        said=verdict_lines(summary),
        words=explanation(summary),
        remarks=[remark.replace("`", "") for remark in remarks(summary)],
        budget=budget(summary) + (_section_rows(comparison, samples.arm.length) if several else []),
        several=several,
        muscles=muscle_words(
            summary["muscle"], any(isinstance(group.law, PneumaticLaw) for group in samples.arm.groups)
        ),
        figures=[
            {"alt": alt, "data": _encoded((folder / name).read_bytes())}
            for name, alt in (_FIGURES_OF_SEVERAL if several else FIGURES).items()
            if (folder / name).is_file()
        ],
        video=embedded(film, float(samples.time[-1] - samples.time[0])) if film.is_file() else None,
        gif=_encoded((folder / "video.gif").read_bytes()) if (folder / "video.gif").is_file() else None,
        no_video=summary["video"],
        toml=arm_to_toml(samples.arm),
        traces=_safe_json(_traces(samples, comparison)),
        plotly=_encoded(PLOTLY.read_bytes()),
    )
    write_whole(folder / "report.html", text)


def _section_rows(comparison: Comparison, length: float) -> list[tuple[str, list[float]]]:
    """Return rows of the error budget, as `budget` does: what the tip moves where one section alone has a part."""
    rows: list[tuple[str, list[float]]] = []
    for number in range(comparison.section_shape.shape[1]):
        rows.append((f"section {number + 1} alone", []))
        for name in ("discretisation", "servo", "shape"):
            found = spread(getattr(comparison, f"section_{name}")[:, number], length)
            rows.append((f"  {name}", [1e3 * found.max_m, 1e3 * found.rms_m, found.max_percent, found.rms_percent]))
    return rows


def _encoded(content: bytes) -> str:
    return base64.b64encode(content).decode()


def _safe_json(value: Any) -> str:
    """Return JSON that may stand inside a script element."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def embedded(film: Path, seconds: float) -> dict[str, Any]:
    """Return a film of some seconds, smaller if it is large, ready to be embedded."""
    content, (width, height) = film.read_bytes(), (1280, 720)
    if len(content) > LARGEST_VIDEO:
        from contarm_sim.view.rendering.encode import shrunk

        content, (width, height) = shrunk(film, 540, LARGEST_VIDEO / seconds), (960, 540)
    return {"data": _encoded(content), "width": width, "height": height}


def _traces(samples: Trajectory, comparison: Comparison) -> dict[str, Any]:
    """Return data and layout of the interactive view; millimetres."""
    step = max(1, len(samples) // POINTS)
    arm, several = samples.arm, len(samples.arm.sections) > 1
    dome = 1e3 * reachable_tips(arm, 25, 49)
    error = 1e3 * comparison.tip_error[::step]
    hover = "%{x:.1f}, %{y:.1f}, %{z:.1f} mm"
    data = [
        {
            "type": "surface", "name": "hull of reachable tips" if several else "reachable tips", "opacity": 0.18,
            "showscale": False, "hoverinfo": "skip",
            "colorscale": [[0, "#8aa0c0"], [1, "#8aa0c0"]], "showlegend": True,
            **{axis: np.round(dome[..., i], 2).tolist() for i, axis in enumerate("xyz")},
        },
        _line("target", samples.target[::step], {"color": "#8A8F99", "width": 3, "dash": "dash"}, hover),
        _line("analytic tip", comparison.analytic_tip[::step], {"color": "#7B2CC8", "width": 3}, hover),
        _line(
            "simulated tip", comparison.simulated_tip[::step],
            {"color": np.round(error, 4).tolist(), "colorscale": "Viridis", "width": 6,
             "colorbar": {"title": {"text": "tip error [mm]"}, "len": 0.6}}, hover,
        ) | {"showlegend": False, "legendgroup": "simulated"},
        _line("simulated tip", comparison.simulated_tip[:1], {"color": "#21918c", "width": 6}, hover)
        | {"legendgroup": "simulated"},  # a line of many colours has none in the legend
        *_backbone(samples, hover),
    ]  # fmt: skip
    axes = {f"{axis}axis": {"title": {"text": f"{axis} [mm]"}, "showbackground": False} for axis in "xyz"}
    layout = {
        "scene": {**axes, "aspectmode": "data", "camera": {"eye": {"x": 1.2, "y": -1.3, "z": 0.7}}},
        "margin": {"l": 0, "r": 0, "t": 30, "b": 20}, "legend": {"x": 0, "y": 1},
        "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "rgba(0,0,0,0)",
    }  # fmt: skip
    return {"data": data, "layout": layout}


def _backbone(samples: Trajectory, hover: str) -> list[dict[str, Any]]:
    """Return the backbone of the last sample, a line a section."""
    return [
        _line(f"{name}, last sample", stations, {"color": colour, "width": 8}, hover)
        for name, colour, stations in backbone_lines(samples.stations[-1], samples.arm)
    ]


def _line(name: str, points: Any, line: dict[str, Any], hover: str) -> dict[str, Any]:
    """Return a line through points [m], shape (T, 3)."""
    places = {axis: np.round(1e3 * points[:, i], 3).tolist() for i, axis in enumerate("xyz")}
    return {"type": "scatter3d", "mode": "lines", "name": name, "line": line, "hovertemplate": hover, **places}
