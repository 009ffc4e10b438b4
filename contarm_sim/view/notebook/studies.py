"""Results of studies as HTML."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from contarm_sim.kinematics.arc import to_polar
from contarm_sim.model.arm import Arm
from contarm_sim.results.document import document
from contarm_sim.view.notebook.page import card, grid, pairs
from contarm_sim.view.notebook.sketch import curve
from contarm_sim.view.report.words import budget, verdict_lines


def _validation(found: Any) -> str:
    columns = ["scenario", "largest tip error [% of length]", "constant curvature", "simulation"]
    rows = []
    for name, outcome in found.outcomes.items():
        said = f"{name}: {outcome.setting.meaning}"
        if hasattr(outcome, "constant_curvature"):
            held = outcome.constant_curvature
            holds = "holds" if held.holds else "does not hold"
            rows.append([said, f"{held.error_percent:.3g}", holds, outcome.verdict])
        else:
            rows.append([said, "-", "-", outcome.verdict])
    orders = getattr(found.convergence, "observed_orders", ())
    last = f"order {orders[-1]:.3g} in the number of links" if orders else "not known"
    rows.append([f"convergence: {last}", "", "", found.convergence.verdict])
    return card(f"Validation: {found.verdict}", grid(columns, rows))


def _judged(found: Any) -> str:
    plain = document(found)
    columns = ["part", "max [mm]", "rms [mm]", "max [% of length]", "rms [% of length]"]
    rows = [[name.replace("  ", "\u2003"), *(f"{x:.4f}" for x in numbers)] for name, numbers in budget(plain)]
    title = f"Simulation and targets: {found.judged.verdict}"
    return card(title, pairs(verdict_lines(plain)), "", grid(columns, rows))


def _controllers(found: Any) -> str:
    columns = ["load", "controller", "tip error, rms [%]", "largest [%]", "tension to [N]", "pressure to [kPa]"]
    rows = []
    for row in found.rows:
        if hasattr(row, "failed"):
            rows.append([row.load, row.controller, row.failed])
            continue
        peak = "-" if row.peak_pressure_pa is None else f"{row.peak_pressure_pa / 1e3:.0f}"
        sizes = (f"{row.tip_rms_percent:.3f}", f"{row.tip_max_percent:.3f}", f"{row.peak_tension_n:.1f}")
        rows.append([row.load, row.controller, *sizes, peak])
    return card(f"Controllers on the spiral in {found.duration:g} s", grid(columns, rows, texts=2))


def _possibility(found: Any) -> str:
    from contarm_sim.studies.scenarios import under_loads

    loads = {name: _load(arm) for name, arm in under_loads(found.arm).items()}
    several = len(found.arm.sections) > 1
    held = "every bend of every section" if several else "every bend in every plane"
    rows = [
        (loads[load], f"{held} is held up to {' and '.join(f'{x:.1f}' for x in (to if several else [to]))}°")
        for load, to in found.every_bend_to_deg.items()
    ]
    columns = ["load", *(["section"] if several else []), "towards [°]", "all inflated, to [°]", "one vented, to [°]"]
    table = [
        [loads[r.load], *([str(r.section)] if several else []), f"{r.plane_deg:.0f}", *map(_degrees, _ends(r))]
        for r in found.rows
    ]
    return card(f"Bends that pressures hold, of an arm of {found.arm.mass:g} kg", pairs(rows), "", grid(columns, table))


def _ends(row: Any) -> tuple[float, float]:
    return row.inflated_deg, row.vented_deg


def _degrees(angle: float) -> str:
    return f"{angle:.1f}" if angle > 0 else "none"


def _load(arm: Arm) -> str:
    """Return what loads an arm: gravity in the base frame, and payload."""
    if not any(arm.gravity):
        return "no gravity"
    size, (x, y, z) = math.hypot(*arm.gravity), arm.gravity
    way = "hanging" if z > 0.999 * size else "upright" if z < -0.999 * size else f"along ({x:.3g}, {y:.3g}, {z:.3g})"
    return f"{size:.3g} m/s², {way}" + (f", payload {arm.payload:g} kg" if arm.payload else "")


def _stiffness(found: Any) -> str:
    columns = ["mean pressure [kPa]", *(f"{name} [N/m]" for name in found.directions)]
    rows = [[f"{r.mean_pressure_pa / 1e3:.0f}", *(f"{x:.3g}" for x in r.simulated_n_per_m)] for r in found.rows]
    return card("Tip stiffness by co-contraction", grid(columns, rows))


def _trust(found: Any) -> str:
    bounds = [bend.within_percent for bend in found.loads[0].trusted.bends]
    rows = []
    for each in found.loads:
        bends = (f"all, to {b.least_deg:.0f}" if b.everywhere else f"{b.least_deg:.1f}" for b in each.trusted.bends)
        rows.append([each.trusted.under.meaning, *bends])
    each_of = "" if len(found.arm.sections) == 1 else " of each section"
    title = f"Bends{each_of} [°] up to which constant curvature holds, by allowed tip error"
    return card(title, grid(["load", *(f"{within:g} % of length" for within in bounds)], rows))


def _hold(found: Any) -> str:
    several = found.bend.ndim == 2
    bends = [to_polar(bend) for bend in found.bend.reshape(-1, 2)]
    said = ", ".join(f"{math.degrees(angle):.1f}° towards {math.degrees(plane):.0f}°" for angle, plane in bends)
    levels, ranges = (found.level, found.level_range) if several else ((found.level,), (found.level_range,))
    between = ", ".join(
        f"{at:.1f} N of {low:.1f} to {high:.1f} N" for at, (low, high) in zip(levels, ranges, strict=True)
    )
    off = found.simulated_off
    rests = "does not stay near it" if off is None else f"rests {math.degrees(off):.2f}° from it"
    moment = ", ".join(f"({1e3 * x:.3g}, {1e3 * y:.3g})" for x, y in found.weight_moment.reshape(-1, 2))
    rows = [
        ("bend", said),
        ("simulated arm", rests),
        ("co-contraction", between),
        ("moment of weight", f"{moment} mN m"),
    ]
    numbers: list[Any] = [found.muscle_lengths, found.actuator_tensions]
    columns = ["muscle", "length [mm]", "tension [N]"]
    if found.pressures is not None:
        numbers.append(found.pressures)
        columns.append("pressure [kPa]")
    scales, table = ((1e3, 2), (1.0, 2), (1e-3, 1)), []
    for section, group in enumerate(zip(*numbers, strict=True) if several else [numbers], 1):
        for i, own in enumerate(zip(*group, strict=True), 1):
            cells = [f"{scale * x:.{digits}f}" for x, (scale, digits) in zip(own, scales, strict=False)]
            table.append([f"section {section}, {i}" if several else str(i), *cells])
    return card("What holds the bends" if several else "What holds the bend", pairs(rows), "", grid(columns, table))


def _release(found: Any) -> str:
    swing, modes, settings = found.swing.swing, found.modes, found.settings
    moved = 1e3 * np.linalg.norm(swing.tip - swing.tip[0], axis=1)
    rows = [("swing", f"{settings.duration:g} s at steps of {1e3 * settings.timestep:g} ms")]
    rows += [("tip goes", f"up to {moved.max():.3g} mm from where it was held")]
    error = (found.tip_error_mean_percent, found.step_error_mean_percent, found.links_error_mean_percent)
    rows += [("mean tip error", "{:.3g} % of length (step {:.3g} %, links {:.3g} %)".format(*error))]
    if found.energy_lost_j is not None:
        rows += [("energy lost", f"{found.energy_lost_j:.3g} J")]
    own = ", ".join(dict.fromkeys(f"{hz:.3g}" for hz in modes.arm_hz))
    rows += [("frequencies", f"{own} Hz, where it comes to rest")]
    rows += [("not believed", reason) for reason in found.reasons]
    columns = ["mode, without gravity", *(str(i + 1) for i in range(len(modes.beam_hz)))]
    table = [["clamped beam [Hz]", *(f"{hz:.3g}" for hz in modes.beam_hz)]]
    table += [["chain [Hz]", *(f"{hz:.3g}" for hz in modes.chain_hz[: len(modes.beam_hz)])]]
    said = "tip, from where it was held, over time"
    picture = f"{curve(moved, said)}<br><small>{said}</small>"
    return card(f"Swing of an arm that is let go: {found.verdict}", pairs(rows), picture, grid(columns, table))


def _curves(found: Any) -> str:
    picked = np.unique(np.linspace(0, len(found.contraction) - 1, 7).astype(int))
    rows = [("length at rest", f"{1e3 * found.rest_length_m:.4g} mm"),
            ("braid angle at rest", f"{math.degrees(found.braid_angle_rad):.3g}°"),
            ("blocked force", f"{found.blocked_force_n:.3g} N at rest length under the highest pressure"),
            ("stretches by", f"{100 * found.max_stretch:.3g} % at most")]  # fmt: skip
    columns = ["force [N] at contraction [%]", *(f"{100 * found.contraction[i]:.3g}" for i in picked)]
    table = [
        [f"{p / 1e3:g} kPa", *(f"{forces[i]:.1f}" for i in picked)]
        for p, forces in zip(found.pressure_pa, found.force_n, strict=True)
    ]
    return card("Force of one muscle", pairs(rows), "", grid(columns, table))


CARDS: dict[str, Callable[[Any], str]] = {
    "Validation": _validation, "JudgedRun": _judged, "ControllerComparison": _controllers, "Possibility": _possibility,
    "Stiffness": _stiffness, "Trust": _trust, "Hold": _hold, "Release": _release, "MuscleCurves": _curves,
}  # fmt: skip
