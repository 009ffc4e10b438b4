"""What is said of an uncertain arm, the same on the terminal and on the page; from its document."""

from __future__ import annotations

from typing import Any

import numpy as np

from contarm_sim.view.report.sweeps.columns import Column

Row = tuple[str, list[str]]

ERRORS = {"mean": "mean over time", "max": "largest", "end": "at the end"}
"""Quantities of the tip error in words."""

PERCENTILES = ("p5", "p50", "p95")


def cases_words(found: dict[str, Any]) -> str:
    """Say how many arms were sampled, and what became of those without a result."""
    asked, run, good = found["cases"], found["run"], found["with_result"]
    said = f"{run} sampled arms, all commanded as the nominal one"
    if found["interrupted"]:
        said = f"{run} of {asked} sampled arms (interrupted), all commanded as the nominal one"
    if not found["failed"]:
        return said
    why = ", ".join(f"{count} {status}" for status, count in found["failed"].items())
    return f"{said}; {run - good} without a result ({why}), so percentiles are of the {good} others"


def error_rows(found: dict[str, Any]) -> list[Row]:
    """Return rows of the tip error [mm]: nominal, and percentiles."""
    return [
        (words, [_mm(found["tip_error"][name][f"{key}_m"]) for key in ("nominal", *PERCENTILES)])
        for name, words in ERRORS.items()
    ]


def pose_rows(found: dict[str, Any]) -> list[Row]:
    """Return rows of a pose: tip and distance from the nominal one [mm], tensions [N]; nominal, and percentiles."""
    rows = []
    for axis, name in enumerate("xyz"):
        values = (found["tip_m"][key] for key in ("nominal", *PERCENTILES))
        rows.append((f"tip {name} [mm]", [_mm(each and each[axis]) for each in values]))
    rows.append(("distance from nominal tip [mm]", ["", *(_mm(found["distance_m"][key]) for key in PERCENTILES)]))
    for number in range(len(found["tensions_n"]["nominal"])):
        values = (found["tensions_n"][key] for key in ("nominal", *PERCENTILES))
        rows.append((f"tension of muscle {number + 1} [N]", [_plain(each and each[number]) for each in values]))
    return rows


def parameter_rows(found: dict[str, Any], quantity: str) -> list[Row]:
    """Return rows of the uncertain parameters: nominal, percentiles, shares of a quantity's variance [%].

    Those that cause most come first.
    """
    indices = found["causes"][quantity].get("parameters", {})
    rows = []
    for name in sorted(found["parameters"], key=lambda each: -indices[each]["total"] if indices else 0):
        column = _column(name, found["parameters"][name])
        shares = [_share(indices[name], kind) for kind in ("first", "total")] if indices else ["", ""]
        rows.append((column.label, [f"{value:.4g}" for value in column.shown] + shares))
    return rows


def _column(name: str, one: dict[str, Any]) -> Column:
    """Return a parameter's nominal value and percentiles."""
    return Column(name, one["unit"], np.array([one[key] for key in ("nominal", *PERCENTILES)], dtype=float))


def limit_words(found: dict[str, Any]) -> list[str]:
    """Say in how many poses a length servo is at its limit, if in any; motions do not count them."""
    count, good = found.get("at_limit", 0), found["with_result"]
    at = f"in {count} of {good} arms a length servo is at its limit: it pulls with the blocked force, or cannot push"
    return [at] if count else []


def causes_words(found: dict[str, Any], quantity: str, words: str) -> str:
    """Say what the shares are, or why there are none."""
    causes = found["causes"][quantity]
    if "reason" in causes:
        return f"no Sobol indices of {words}: {causes['reason']}"
    explained = f"{100 * causes['explained']:.4g} % is explained by the fitted polynomial of degree {causes['degree']}"
    return f"Sobol indices, shares of the variance of {words}; {explained}"


def apart_words(found: dict[str, Any]) -> list[str]:
    """Say which parameters of the nominal arm are not among those sampled: it is commanded as an unlikely one."""
    lines = []
    for name, one in found["parameters"].items():
        if not one["p5"] <= one["nominal"] <= one["p95"]:
            column = _column(name, one)
            value = f"{column.shown[0]:.4g}" + ("" if column.unit == "-" else f" {column.read_unit}")
            lines.append(f"{column.words} of the nominal arm, {value}, is not within 5 to 95 % of what was sampled")
    return lines


def _share(indices: dict[str, Any], kind: str) -> str:
    low, high = indices[f"{kind}_95"]
    return f"{100 * indices[kind]:.1f} ({100 * low:.1f} to {100 * high:.1f})"


def _mm(value: float | None) -> str:
    return "" if value is None else f"{round(1e3 * value, 3) + 0.0:.3f}"


def _plain(value: float | None) -> str:
    return "" if value is None else f"{round(value, 2) + 0.0:.2f}"
