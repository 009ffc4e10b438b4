"""What a fit found, in sentences and rows of tables; numbers in units that people read."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contarm_sim.identify.fitted import FOUND, Fit, Parameter
from contarm_sim.identify.search.seeing import explains_little
from contarm_sim.view.report.fits.left_over import (
    FITTED,
    HELD_OUT,
    gaps,
    parts,
    pooled,
    rms,
    together,
)
from contarm_sim.view.report.outliers import swaying, without
from contarm_sim.view.report.outliers import told as counted
from contarm_sim.view.report.sweeps.columns import READ

MEANINGS = {
    "recording": "what was commanded, and where markers were measured to be, sample by sample.",
    "error": "the distance of where a marker was measured from where it is predicted.",
    "held out": "samples that were kept from the fit: their errors say how well the arm predicts.",
    "mean offset removed": "the same errors without what is the same in all samples: a marker or a frame that is "
    "not quite where it is said to be.",
    "95 % interval": "where the parameter is with a probability of 95 %, if the arm is right but for its parameters. "
    "Errors of the model itself are not in it; a bootstrap over blocks has more of them.",
    "bootstrap": "the middle 95 % of estimates from blocks that are drawn anew. Of few blocks, pieces of them are "
    "drawn, in which errors that last for a whole block count too low: the wider 95 % interval is the one to "
    "go by. It is missing where too few blocks see the parameter.",
    "determined": "the recording tells the parameter apart from all others, if only just: see correlations.",
    "at bound": "the best value is at a bound that was given, or that an arm has: what is beyond is not known.",
    "weakly determined": "the 95 % interval is wide: a factor of 3 or more either way, or about 10 mm, 30 degrees.",
    "stopped early": "where the search was when it was stopped: not the best value, and how far off is not known.",
    "only with others": "the recording sees the parameter, but other parameters do the same: only the combination that "
    "is named is determined. The arm has one of many sets of values that fit: what is said to be held keeps its start.",
    "not seen": "the parameter changes nothing in the recording. The arm keeps the start.",
    "outlier": "an error beyond six times the median of all, where fewer than one in ten are: often a marker that was "
    "mistaken for another.",
    "block": "samples that are not independent: a pattern, a trial.",
    "repeatability": "how far samples of the same command are from their median, rms without outliers: what a model "
    "without memory cannot predict.",
}
"""What words of the page mean."""


def unit_of(one: Parameter) -> tuple[float, str]:
    """Return the factor and the unit in which people read a parameter; "" for none."""
    factor, unit = READ.get(one.unit, (1.0, one.unit))
    if one.unit.endswith("/command"):
        factor, unit = 1.0, one.unit
    return factor, "" if unit == "-" else unit.replace("^2", "²").replace("^3", "³").replace("^4", "⁴")


def digits(number: float, spread: float) -> str:
    """Return a number in as many digits as its spread leaves it: two of the spread."""
    if not math.isfinite(number):
        return "-"
    if not math.isfinite(spread) or spread <= 0:
        return plain(number)
    places = 1 - math.floor(math.log10(spread))
    rounded = round(number, places) + 0.0
    if abs(rounded) >= 1e5 or 0 < max(abs(number), spread) < 1e-4 or places > 7:
        known = max(1, min(1 + math.floor(math.log10(max(abs(number), spread) / spread)) + 1, 8))
        return f"{number:.{known}g}"
    return f"{rounded:.{max(places, 0)}f}"


def plain(number: float) -> str:
    """Return a number in four digits, without an exponent where it is of a usual size."""
    return f"{float(f'{number:.4g}'):g}"


def parameter_rows(fit: Fit) -> list[list[str]]:
    """Return a row of each parameter: name, unit, start, value, 95 % interval, that of the bootstrap, status."""
    return [_row(one) for one in fit.parameters]


def parameter_columns(fit: Fit) -> list[str]:
    """Return the columns of `parameter_rows`; without the bootstrap where there was none."""
    return ["parameter", "unit", "start", "value", "95 % interval", *(["bootstrap"] if booted(fit) else []), "status"]


def booted(fit: Fit) -> bool:
    """Tell whether there are intervals from a bootstrap."""
    return any(math.isfinite(one.boot_low) for one in fit.parameters)


def rows_of(fit: Fit) -> list[list[str]]:
    """Return the rows for `parameter_columns`."""
    rows = parameter_rows(fit)
    return rows if booted(fit) else [[*row[:5], row[6]] for row in rows]


def _row(one: Parameter) -> list[str]:
    factor, unit = unit_of(one)
    value, low, high = (factor * x for x in (one.value, one.low, one.high))
    spread = 0.5 * (high - low)
    found = digits(value, spread) if one.status in FOUND else "-"
    between, boot = (
        f"{digits(a, spread)} to {digits(b, spread)}" if math.isfinite(a) and math.isfinite(b) else "-"
        for a, b in ((low, high), (factor * one.boot_low, factor * one.boot_high))
    )  # fmt: skip
    return [one.name, unit or "-", plain(factor * one.start), found, between, boot, one.status]


def notes(fit: Fit) -> list[str]:
    """Say what else is known of single parameters."""
    return [f"{one.name}: {one.said}" for one in fit.parameters if one.said]


def undetermined(fit: Fit) -> list[str]:
    """Say what the data do not determine, a sentence each."""
    said = [each.said for each in fit.undetermined]
    named = {name for each in fit.undetermined for name in each.names}
    said += [f"{one.name} is {one.status}" for one in fit.parameters
             if one.status not in FOUND and one.name not in named]  # fmt: skip
    return [text.rstrip(".") for text in said if text]


def error_columns() -> list[str]:
    """Return the columns of `error_rows`."""
    return ["errors [mm]", "samples", "rms", "mean offset removed", "median", "95 % below"]


def error_rows(fit: Fit) -> list[list[str]]:
    """Return a row of each recording, of what was fitted and held out, and of each marker where there are several."""
    rows = []
    for left in fit.left:
        before = f"{left.recording.name}, " if len(fit.left) > 1 else ""
        markers = left.recording.rig.markers
        for part, chosen in parts(left).items():
            rows.append(_sizes(f"{before}{part}", rms(left, chosen)))
            if len(markers) > 1:
                rows += [_sizes(f"  {marker.name}", rms(left, chosen, k)) for k, marker in enumerate(markers)]
        if left.unpredicted:
            rows.append([f"{before}without a pose", f"{left.unpredicted:,}", "-", "-", "-", "-"])
    return rows


def _sizes(name: str, found: Any) -> list[str]:
    if found is None:
        return [name, "0", "-", "-", "-", "-"]
    sizes = found.rms, found.centred, found.median, found.most
    return [name, f"{found.samples:,}", *(millimetres(size) for size in sizes)]


def millimetres(metres: float) -> str:
    """Return a distance in mm, in three digits or so."""
    if not math.isfinite(metres):
        return "-"
    size = 1e3 * metres
    return f"{size:.1f}" if size >= 10 else f"{size:.2f}" if size >= 0.1 else f"{size:.2g}"


def headline(fit: Fit) -> str:
    """Say in one sentence what the fit comes to."""
    known, count = sum(one.determined for one in fit.parameters), len(fit.parameters)
    weak = sum(one.status == "weakly determined" for one in fit.parameters)
    held, own = together(fit, HELD_OUT), together(fit, FITTED)
    weakly = f", {weak} of them weakly" if weak else ""
    of = f"{known} of {count} parameters determined{weakly}" if count > 1 else f"{fit.parameters[0].name}: " + (
        "determined" if known else "not determined")  # fmt: skip
    sizes = pooled(fit, HELD_OUT if math.isfinite(held) else FITTED)
    if far := swaying(sizes):
        middle, most, all_of = (millimetres(x) for x in (np.median(sizes), np.percentile(sizes, 95), held))
        what = "held-out markers" if math.isfinite(held) else "markers"
        all_of = all_of if math.isfinite(held) else millimetres(own)
        return (f"The fitted arm predicts half of the {what} within {middle} mm, 95 % within {most} mm "
                f"({all_of} mm rms with {counted(far)}); {of}.")  # fmt: skip
    if math.isfinite(held):
        return f"The fitted arm predicts what was held out within {millimetres(held)} mm rms; {of}."
    return f"The fitted arm is within {millimetres(own)} mm rms of the recording; {of}."


def lead(fit: Fit) -> str:
    """Say what was fitted to what."""
    samples = sum(len(left.recording) for left in fit.left)
    blocks = sum(len(set(left.recording.blocks.tolist())) for left in fit.left)
    markers = max(len(left.recording.rig.markers) for left in fit.left)
    kinds = {left.recording.kind for left in fit.left}
    what = "poses at rest" if kinds == {"static"} else "samples of motions" if kinds == {"motion"} else "samples"
    named = fit.left[0].recording.name if len(fit.left) == 1 else f"{len(fit.left)} recordings"
    held = together(fit, HELD_OUT)
    said = f"{how_many(len(fit.parameters), 'free parameter')}, {samples:,} {what} in {how_many(blocks, 'block')}, "
    said += f"{how_many(markers, 'marker')} ({named}). The error of what was fitted is {_sized(fit, FITTED)}"
    if not math.isfinite(held):
        return f"{said}; nothing was held out, so how well the arm predicts is not known."
    return f"{said}; of what was held out {_sized(fit, HELD_OUT)}."


def _sized(fit: Fit, part: str) -> str:
    """Return how large errors are: their rms, and what it is without outliers, if there are any."""
    sizes = pooled(fit, part)
    far = swaying(sizes)
    said = f"{millimetres(together(fit, part))} mm rms"
    return f"{said} ({millimetres(without(sizes))} mm without {counted(far)})" if far else said


def negative(fit: Fit) -> str:
    """Return why the verdict is negative, "" where it is not."""
    if not any(one.status in FOUND for one in fit.parameters):
        return "the recording determines none of the free parameters"
    return "" if fit.converged else f"the search did not converge ({fit.message})"


def remarks(fit: Fit) -> list[str]:
    """Say what the errors of each recording tell: what is not explained, samples without a pose, hysteresis."""
    little = explains_little(fit)
    said = [little] if little else []
    for left in fit.left:
        if left.unpredicted:
            said.append(f"{how_many(left.unpredicted, 'sample')} of {left.recording.name}: the fitted arm has no pose "
                        "there; errors and intervals are without them")  # fmt: skip
        own = gaps(left)
        channel = max(own, key=lambda name: abs(own[name]), default=0)
        if own and abs(own[channel]) > fit.noise:
            of = f" of {left.recording.name}" if len(fit.left) > 1 else ""
            said.append(f"errors{of} depend on which way a command went: most with channel {channel}, by "
                        f"{millimetres(abs(own[channel]))} mm between growing and falling")  # fmt: skip
    return said


def how_many(number: int, what: str) -> str:
    """Return a number of things in words: `one block`, `12 blocks`."""
    return f"one {what}" if number == 1 else f"{number:,} {what}s"


def sentence(text: str) -> str:
    """Return a text as a sentence: a capital letter, a full stop."""
    return f"{text[:1].upper()}{text[1:]}".rstrip(".") + "." if text else ""


def _ended(fit: Fit) -> str:
    """Say how the search ended, without the words of its solver, and which starts led nowhere."""
    lost = sum(not math.isfinite(cost) for cost in fit.cost)
    said = "Converged." if fit.converged else f"Not converged: {fit.message.rstrip('.')}."
    return f"{said} {sentence(how_many(lost, 'start'))[:-1]} led to an arm without a pose." if lost else said


def how(fit: Fit) -> list[tuple[str, str]]:
    """Say how the fit ran: rows of names and values."""
    costs = ", ".join(f"{cost:.6g}" for cost in fit.cost if math.isfinite(cost)) or "-"
    return [
        ("method", fit.method),
        ("ended", _ended(fit)),
        ("noise of a coordinate", f"{millimetres(fit.noise)} mm"),
        ("cost, best start first", costs),
        ("evaluations", f"{fit.evaluations:,}"),
        ("time", f"{fit.seconds:.3g} s"),
    ]
