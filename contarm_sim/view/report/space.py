"""The interactive view of a run in three dimensions, turned as the arm stands in the world."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.mjcf.scene import base_rotation
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import hex_colour
from contarm_sim.results.compare import Comparison
from contarm_sim.results.trajectory import Trajectory
from contarm_sim.view.colours import ANALYTIC, CONTACT, DARK_PAGE, FAINT, LIMIT, SIMULATED, TARGET, error_scale
from contarm_sim.view.outlines import placed_objects, poses_at
from contarm_sim.view.rendering.touch import metres_per_newton, scale_words
from contarm_sim.view.report.contrast import lightened
from contarm_sim.view.sections import backbone_lines, base_rim, reachable_tips

POINTS = 600
"""Points of a line, at most."""

_HOVER = "%{x:.1f}, %{y:.1f}, %{z:.1f} mm"
_EYE = 1.85 * np.array([np.cos(-1.08) * 0.95, np.sin(-1.08) * 0.95, 0.31])
"""Where the view is seen from, in the world: about where a film's camera `front` is."""


def telling(samples: Trajectory, comparison: Comparison) -> int:
    """Return the sample that shows the error best: both the arm's bends and the tip error are large."""
    bent = np.hypot(samples.bend[:, ::2], samples.bend[:, 1::2]).sum(axis=1)
    return int(np.argmax(bent * comparison.tip_error))


def space(samples: Trajectory, comparison: Comparison) -> dict[str, Any]:
    """Return data and layout of the view for plotly [mm, base frame], and what changes in a dark scheme.

    `dark` has, for each trace, the attributes that are others in the dark, by their paths.
    """
    data, layout = _traces(samples, comparison), _layout(samples.arm)
    if samples.arm.world.objects:
        for axis, ends in _ranges(samples).items():
            layout["scene"][f"{axis}axis"]["range"] = ends
    return {"data": data, "layout": layout, "dark": [_in_the_dark(trace) for trace in data]}


def _traces(samples: Trajectory, comparison: Comparison) -> list[dict[str, Any]]:
    step, arm, best = max(1, len(samples) // POINTS), samples.arm, telling(samples, comparison)
    error = 1e3 * comparison.tip_error[::step]
    dome, largest = 1e3 * reachable_tips(arm, 25, 49), float(error.max())
    bar = {"title": {"text": "tip error [mm]"}, "orientation": "h", "x": 0.5, "y": 1.0, "yanchor": "bottom",
           "len": 0.6, "thickness": 12}  # fmt: skip
    coloured = {"color": np.round(error, 5).tolist(), "colorscale": error_scale(), "cmin": 0.0,
                "cmax": max(largest, 1e-6), "width": 7, "colorbar": bar}  # fmt: skip
    at = f"at {samples.time[best]:.2f} s"
    arcs = shape.position(samples.bend[best], arm, np.linspace(0, 1, 61))
    return [
        {
            "type": "surface", "name": "reachable tips", "opacity": 0.25, "showscale": False, "hoverinfo": "skip",
            "colorscale": [[0, FAINT], [1, FAINT]], "showlegend": True,
            **{axis: np.round(dome[..., i], 1).tolist() for i, axis in enumerate("xyz")},
        },
        _line("target", samples.target[::step], {"color": TARGET, "width": 4, "dash": "dash"}),
        _line("tip of the arc", comparison.analytic_tip[::step], {"color": ANALYTIC, "width": 3}),
        _line("simulated tip", comparison.simulated_tip[::step], coloured)
        | {"showlegend": False, "legendgroup": "simulated"},
        _line("simulated tip", comparison.simulated_tip[:1], {"color": SIMULATED, "width": 7})
        | {"legendgroup": "simulated"},  # a line of many colours has none in the legend
        _line(f"arc {at}", arcs, {"color": ANALYTIC, "width": 6}),
        *(
            _line(f"{'simulated arm' if name == 'backbone' else name} {at}", stations, {"color": colour, "width": 10})
            for name, colour, stations in backbone_lines(samples.stations[best], arm)
        ),
        *_objects(samples, best),
        *_contacts(samples, best, at),
        _base(arm),
        *_gravity(arm, dome),
    ]  # fmt: skip


def _ranges(samples: Trajectory) -> dict[str, list[float]]:
    """Return what the axes show [mm]: all that the arm does and can reach, and what is near it."""
    low, high = _near(samples)
    return {axis: [round(1e3 * low[i], 1), round(1e3 * high[i], 1)] for i, axis in enumerate("xyz")}


def _near(samples: Trajectory) -> tuple[Array, Array]:
    """Return corners of a box about that [m], shape (3,) each."""
    tips = reachable_tips(samples.arm, 9, 25).reshape(-1, 3)
    every = np.concatenate([tips, samples.stations.reshape(-1, 3), samples.target])
    room = 0.2 * samples.arm.length
    return every.min(axis=0) - room, every.max(axis=0) + room


def _objects(samples: Trajectory, index: int) -> list[dict[str, Any]]:
    """Return the surfaces of what the arm can touch and is near it, where a sample has them."""
    found, (low, high) = [], _near(samples)
    for each, points, faces in placed_objects(samples.arm, poses_at(samples, index)):
        if np.any(points.max(axis=0) < low) or np.any(points.min(axis=0) > high):
            continue
        smooth, flat = each.shape in ("sphere", "capsule"), each.shape == "plane"
        found.append(
            {
                "type": "mesh3d", "name": each.name, "color": hex_colour(each.colour), "showlegend": True,
                "opacity": 0.45 if flat else 1.0, "flatshading": not smooth, "hoverinfo": "name",
                **{axis: np.round(1e3 * points[:, i], 2).tolist() for i, axis in enumerate("xyz")},
                **{corner: faces[:, i].tolist() for i, corner in enumerate("ijk")},
            }
        )  # fmt: skip
    return found


def _contacts(samples: Trajectory, index: int, at: str) -> list[dict[str, Any]]:
    """Return the contact forces of a sample as lines from where they act; nothing where there are none."""
    scale = metres_per_newton(samples)
    if samples.contacts is None or not scale or not len(now := samples.contacts.at(index)):
        return []
    gap = np.full(len(now), np.nan)[:, None] + np.zeros(3)
    ends = np.stack([now.point, now.point + scale * now.force, gap], axis=1).reshape(-1, 3)
    line = _line(f"contact forces {at}, {scale_words(scale)}", ends, {"color": CONTACT, "width": 8})
    return [line | {axis: [None if np.isnan(x) else x for x in line[axis]] for axis in "xyz"}]


def _base(arm: Arm) -> dict[str, Any]:
    """Return the rim of the base plate."""
    return _line("base", base_rim(arm, 37), {"color": LIMIT, "width": 6})


def _gravity(arm: Arm, dome: Array) -> list[dict[str, Any]]:
    """Return an arrow beside the reachable tips that points where gravity does, and its name; nothing without it."""
    pull = np.array(arm.gravity)
    if not pull.any():
        return []
    length, tips = arm.length, 1e-3 * dome.reshape(-1, 3)
    towards, right = pull / np.linalg.norm(pull), _right(arm)
    ahead = tips - np.outer(tips @ towards, towards)
    start = (np.max(ahead @ right) + 0.18 * length) * right - 0.2 * length * towards
    start = start + float(np.mean([tips @ towards])) * towards
    end = start + 0.32 * length * towards
    side = np.cross(towards, right)
    turn, wide = np.linspace(0, 2 * np.pi, 25)[:, None], 0.03 * length
    rim = end - 0.1 * length * towards + wide * (np.cos(turn) * right + np.sin(turn) * side)
    cone = 1e3 * np.stack([rim, np.broadcast_to(end, rim.shape)])
    head = {
        "type": "surface", "showscale": False, "hoverinfo": "skip", "colorscale": [[0, TARGET], [1, TARGET]],
        **{axis: np.round(cone[..., i], 2).tolist() for i, axis in enumerate("xyz")},
    }  # fmt: skip
    where = 1e3 * (start - 0.06 * length * towards)
    label = {
        "type": "scatter3d", "mode": "text", "text": ["gravity"], "showlegend": False, "hoverinfo": "skip",
        "textposition": "top center", "textfont": {"size": 14, "color": TARGET},
        **{axis: [where[i]] for i, axis in enumerate("xyz")},
    }  # fmt: skip
    return [
        _line("gravity", np.stack([start, end]), {"color": TARGET, "width": 8}) | {"showlegend": False},
        head,
        label,
    ]


def _right(arm: Arm) -> Array:
    """Return the direction to the right of the picture, in the base frame."""
    return np.asarray(base_rotation(arm).T @ np.cross([0.0, 0.0, 1.0], _EYE / np.hypot(*_EYE[:2])))


def _line(name: str, points: Any, line: dict[str, Any]) -> dict[str, Any]:
    """Return a line through points [m], shape (T, 3)."""
    places = {axis: np.round(1e3 * points[:, i], 2).tolist() for i, axis in enumerate("xyz")}
    return {"type": "scatter3d", "mode": "lines", "name": name, "line": line, "hovertemplate": _HOVER, **places}


def _layout(arm: Arm) -> dict[str, Any]:
    """Return the layout: the camera is turned, not the arm, so that places are told in the base frame as elsewhere."""
    world = base_rotation(arm).T
    up, eye = world[:, 2], world @ _EYE
    axes = {
        f"{axis}axis": {"title": {"text": f"{axis} [mm]"}, "showbackground": False, "showspikes": False, "nticks": 6}
        for axis in "xyz"
    }
    places = {"up": up, "eye": eye, "center": -0.19 * up}
    camera = {name: dict(zip("xyz", place.tolist(), strict=True)) for name, place in places.items()}
    return {
        "scene": {**axes, "aspectmode": "data", "camera": camera,
                  "dragmode": "orbit" if up[2] < 0.999 else "turntable"},
        "margin": {"l": 0, "r": 0, "t": 10, "b": 0}, "uirevision": "kept", "showlegend": True,
        "legend": {"orientation": "h", "x": 0.5, "xanchor": "center", "y": -0.01, "yanchor": "top"},
        "paper_bgcolor": "rgba(0,0,0,0)", "plot_bgcolor": "rgba(0,0,0,0)",
    }  # fmt: skip


def _in_the_dark(trace: dict[str, Any]) -> dict[str, Any]:
    """Return the colours of a trace, by their paths, lightened where they would not be seen on dark paper."""
    found: dict[str, Any] = {}
    for owner, name in (("line", "color"), ("textfont", "color")):
        colour = trace.get(owner, {}).get(name)
        if isinstance(colour, str):
            found[f"{owner}.{name}"] = lightened(colour, DARK_PAGE, 4.5)
    if "colorscale" in trace.get("line", {}):
        scale = trace["line"]["colorscale"]
        found["line.colorscale"] = [[share, lightened(colour, DARK_PAGE)] for share, colour in scale]
    if trace.get("name") == "reachable tips":
        found["opacity"] = 0.14
    elif "colorscale" in trace:
        found["colorscale"] = [[share, lightened(colour, DARK_PAGE, 4.5)] for share, colour in trace["colorscale"]]
    return found
