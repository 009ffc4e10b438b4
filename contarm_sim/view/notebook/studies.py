"""Results of studies as HTML."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from contarm_sim.display import brief
from contarm_sim.results.document import document
from contarm_sim.view.notebook.page import card, grid, pairs
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
    title = f"Judged run: {found.judged.verdict}"
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
    rows = [(f"every bend is held, {load}", f"to {brief(to)}°") for load, to in found.every_bend_to_deg.items()]
    columns = ["load", "towards [°]", "all inflated, to [°]", "one vented, to [°]"]
    table = [[r.load, f"{r.plane_deg:.0f}", f"{r.inflated_deg:.1f}", f"{r.vented_deg:.1f}"] for r in found.rows]
    return card("Bends that pressures hold", pairs(rows), "", grid(columns, table))


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
    title = f"Bends{each_of} [°] up to which constant curvature holds, by the tip error that is let"
    return card(title, grid(["load", *(f"{within:g} % of length" for within in bounds)], rows))


CARDS: dict[str, Callable[[Any], str]] = {
    "Validation": _validation, "JudgedRun": _judged, "ControllerComparison": _controllers, "Possibility": _possibility,
    "Stiffness": _stiffness, "Trust": _trust,
}  # fmt: skip
