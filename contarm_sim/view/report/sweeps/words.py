"""What a sweep found, in sentences; what its parameters may be, in words."""

from __future__ import annotations

import shlex
from typing import Any

import numpy as np

from contarm_sim.sweeps.distributions import Normal, Range, Varied
from contarm_sim.sweeps.distributions import Values as Listed
from contarm_sim.sweeps.quantities import QUANTITIES
from contarm_sim.sweeps.statuses import OK
from contarm_sim.sweeps.store import SAID
from contarm_sim.sweeps.table import LACKING
from contarm_sim.view.report.filled import MEANINGS
from contarm_sim.view.report.headline import Standing
from contarm_sim.view.report.sweeps.columns import Column, in_digits
from contarm_sim.view.report.sweeps.found import EXTREMES, Found

_LISTED = 8
"""More values are told by their ends."""

_MEANINGS = {
    "case": "one arm, in one world, at rest, under one load or along one path: a row of the table.",
    "status": "what became of a case: ok if it has a result, or why it has none.",
    "unstable": "there is a pose at rest, and the arm would not stay in it.",
    "feasible": "the muscles have the tensions and pressures that the result takes.",
    "Sobol’s index": "the share of a quantity’s variance that a parameter causes, alone (first order) or together with "
    "others too (total).",
    "controller": "paper and chain set muscle lengths by servos that push and pull at any force; servo pulls alone, no "
    "harder than the muscles can; pressure does so by pressures; tip also brings the tip to its target.",
}
"""What words mean that pages of sweeps alone have."""

_HARDLY = 0.02
"""A quantity that changes by less, over its largest value, is said to be about the same everywhere."""

_DESIGNS = {
    "grid": "a grid, all combinations",
    "latin-hypercube": "a Latin hypercube",
    "sobol": "Sobol's points",
    "sobol-indices": "points for Sobol's indices",
}


def headline(found: Found) -> str:
    """Say in one sentence what the sweep says."""
    value, known = found.value, found.known
    if len(known) == 0:
        return f"No case that is done has a value of {value.words}."
    if found.chart is not None:
        bound = found.chart.bounds[len(found.chart.bounds) // 2]
        weights = [
            (stance.meaning, found.chart.weight_within(bound, k)) for k, stance in enumerate(found.chart.stances)
        ]
        limits = " and ".join(f"{weight:.2g} ({name})" for name, weight in weights if weight is not None)
        if limits:
            return (f"Constant curvature holds within {bound:g} % of length to {found.chart.max_bend_deg:g} deg "
                    f"up to m g L^2/EI = {limits}.")  # fmt: skip
    unit = "" if value.read_unit == "-" else f" {value.read_unit}"
    name, ends = _spoken(value.words), [in_digits(each) for each in (known.min(), known.max())]
    said = f"The {name} is {' to '.join(dict.fromkeys(ends))}{unit}"
    if QUANTITIES[found.sweep.spec.run][found.quantity].kind == "truth":
        said = f"{value.words.capitalize()}: {int(known.sum()):,} of {_count(len(known))}"
    if known.max() - known.min() < _HARDLY * np.abs(known).max():
        return f"{said}: hardly anything changes it."
    return f"{said}; `{found.matters}` matters most." if found.matters else f"{said}."


def lead(found: Found) -> str:
    """Say what was run."""
    spec = found.sweep.spec
    what = {"rest": "poses at rest", "equilibrium": "a pose at rest under a load", "motion": "a motion"}[spec.run]
    names = [f"`{name}`" for name in spec.vary]
    listed = " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part)
    return f"Each case is {what} of one arm. {_count(spec.cases)} differ in {listed}: {_DESIGNS[spec.design]}."


def standings(found: Found) -> list[Standing]:
    """Say how much there is of it, and how much went well."""
    sweep = found.sweep
    done, cases = len(sweep), sweep.spec.cases
    failed = done - sweep.counts.get(OK, 0)
    if done < cases:
        share = f"{100 * done / cases:.0f} %"
        text = f"{done:,} of {cases:,} cases are done ({share}). What is below is of these, and may change."
        first = Standing("note", "The sweep is not finished.", f"{text} `contarm sweep` goes on with it.")
    else:
        first = Standing("good", "The sweep is complete.", f"{_count(cases)} are done.")
    lacking = []
    for name, count in sweep.short.items():
        said, _, why = LACKING[name].partition(": ")
        text = f"{why[:1].upper()}{why[1:]}. " if why else ""
        title = f"{count:,} of {sweep.counts[OK]:,} {said}."
        lacking.append(Standing("note", title, f"{text}They count as ok: `{name}` tells them apart."))
    if not failed:
        text = "All that are done have " + ("a result." if lacking else "what was asked for.")
        return [first, Standing("good", "No case failed.", text), *lacking]
    reasons = ", ".join(f"{count:,} {status}" for status, count in sweep.counts.items() if status != OK)
    state = "bad" if failed == done else "note"
    text = f"{reasons}. They are in the table; what is below is without them."
    return [first, Standing(state, f"{_count(failed)} failed.", text), *lacking]


def remarks(found: Found) -> list[str]:
    """Say what a figure leaves out."""
    indices, spec = found.indices, found.sweep.spec
    lines = []
    if indices is not None and indices.failed + indices.surplus:
        lines.append(
            f"Sobol's indices are from {indices.points} points; {indices.failed} are left out as a case of theirs "
            f"failed, and {indices.surplus} to have a power of two"
        )
    shown = found.known
    most = int(np.isclose(shown, shown.max(), rtol=1e-9, atol=0).sum()) if len(shown) else 0
    if most > EXTREMES and shown.min() < shown.max():
        lines.append(f"{_count(most - EXTREMES)} beside those of the table have the largest value too")
    if spec.design == "sobol-indices" and indices is None:
        lines.append(f"there are no Sobol's indices: {found.no_indices}")
    return lines


def command(found: Found) -> str:
    """Return the command that makes the table anew."""
    return shlex.join(["contarm", "sweep", str(found.sweep.folder / SAID), "--out", "FOLDER"])


def meanings(found: Found) -> dict[str, str]:
    """Return what words of the page mean."""
    common = {word: said for word, said in MEANINGS.items() if word not in ("converged", "motion", "dome")}
    return _MEANINGS | (MEANINGS if found.sweep.spec.run == "motion" else common)


def parameters(found: Found) -> list[tuple[str, str]]:
    """Return the parameters that vary, and what each may be."""
    spec = found.sweep.spec
    return [(name, _may_be(varied, spec.known[name].unit)) for name, varied in spec.vary.items()]


def fixed(found: Found) -> list[tuple[str, str]]:
    """Return what all cases share."""
    spec = found.sweep.spec
    return [(name, _said(value, spec.known[name].unit)) for name, value in spec.fixed.items()]


def cases(found: Found) -> tuple[list[str], list[list[str]]]:
    """Return the columns and rows of the table of extreme cases."""
    columns = ["", "case", found.value.label, *(column.label for column in found.columns)]
    rows = [
        [which, f"{int(found.cases[row])}", _cell(found.value, row), *(_cell(column, row) for column in found.columns)]
        for which, row in found.extremes()
    ]
    return columns, rows


def _cell(column: Column, row: int) -> str:
    return in_digits(float(column.shown[row])) if column.numeric else str(column.values[row])


def _count(number: int) -> str:
    return "one case" if number == 1 else f"{number:,} cases"


def _spoken(words: str) -> str:
    """Return the words of a quantity as a sentence has them: "largest tip error" for "tip error max"."""
    for end, before in {" max": "largest ", " min": "least ", " mean": "mean ", " rms": "root mean square "}.items():
        if words.endswith(end):
            return before + words.removesuffix(end)
    return words


def _said(value: Any, unit: str) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, tuple):
        return f"({', '.join(in_digits(each) for each in value)}){'' if unit == '-' else f' {unit}'}"
    column = Column("", unit, np.array([float(value)]))
    return in_digits(float(column.shown[0])) + ("" if column.read_unit == "-" else f" {column.read_unit}")


def _may_be(varied: Varied, unit: str) -> str:
    if isinstance(varied, Listed):
        said = [_said(value, unit) for value in varied.values]
        return ", ".join(said) if len(said) <= _LISTED else f"{len(said)} values from {said[0]} to {said[-1]}"
    if isinstance(varied, Range):
        count = "" if varied.count is None else f", {varied.count} values"
        even = ", evenly in its logarithm" if varied.log else ""
        return f"{_said(varied.low, unit)} to {_said(varied.high, unit)}{count}{even}"
    assert isinstance(varied, Normal)
    kind = "lognormal" if varied.log else "normal"
    return f"{kind}, mean {_said(varied.mean, unit)}, standard deviation {_said(varied.std, unit)}"
