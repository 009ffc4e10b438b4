"""What is said of an uncertain arm, the same on the terminal and on the page; from its document."""

from __future__ import annotations

from typing import Any

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
    told = found["causes"][quantity].get("parameters", {})
    rows = []
    for name in sorted(found["parameters"], key=lambda each: -told[each]["total"] if told else 0):
        one = found["parameters"][name]
        unit = "" if one["unit"] == "-" else f" [{one['unit']}]"
        values = [f"{one[key]:.4g}" for key in ("nominal", *PERCENTILES)]
        shares = [_share(told[name], kind) for kind in ("first", "total")] if told else ["", ""]
        rows.append((f"{name}{unit}", values + shares))
    return rows


def causes_words(found: dict[str, Any], quantity: str, words: str) -> str:
    """Say what the shares are, or why there are none."""
    causes = found["causes"][quantity]
    if "reason" in causes:
        return f"causes of {words} are unknown: {causes['reason']}"
    explained = f"{100 * causes['explained']:.4g} % of the variance of cases that it was not fitted to"
    by = f"Sobol indices of a polynomial of degree {causes['degree']}, which explains {explained}"
    return f"shares of the variance of {words}: {by}"


def apart_words(found: dict[str, Any]) -> list[str]:
    """Say which parameters of the nominal arm are not among those sampled: it is commanded as an unlikely one."""
    lines = []
    for name, one in found["parameters"].items():
        if not one["p5"] <= one["nominal"] <= one["p95"]:
            value = f"{one['nominal']:.4g}" + ("" if one["unit"] == "-" else f" {one['unit']}")
            lines.append(f"{name} of the nominal arm, {value}, is not within 5 to 95 % of what was sampled")
    return lines


def _share(told: dict[str, Any], kind: str) -> str:
    low, high = told[f"{kind}_95"]
    return f"{100 * told[kind]:.1f} ({100 * low:.1f} to {100 * high:.1f})"


def _mm(value: float | None) -> str:
    return "" if value is None else f"{1e3 * value:.3f}"


def _plain(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"
