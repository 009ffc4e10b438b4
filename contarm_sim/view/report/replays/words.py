"""What is said of a replay: sentences for a page and a terminal, rows for tables."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from contarm_sim.identify.differences import Differences
from contarm_sim.identify.replays.bands import INSIDE, Bands
from contarm_sim.identify.replays.replay import Replay
from contarm_sim.view.report.headline import Standing, near
from contarm_sim.view.report.outliers import outliers, swaying, told, without

FEW = 0.8
"""Share of markers inside their bands below which the model errs, and not the fit."""

OFFSET = 0.7
"""Share of the rms that is left without the mean offset below which most of the error is that offset."""

COLUMNS = ["markers seen", "rms", "median", "95 %", "largest", "mean offset removed", "rms [% of length]"]
"""Of the table of errors [mm]."""

MOST_BLOCKS = 12
"""Most blocks that a table on a terminal has."""

MEANINGS = {
    "error": "measured less predicted: how far a marker was from where the arm has it.",
    "rms": "root mean square: of all markers and samples, unless a part is named.",
    "mean offset removed": "the same without the mean error vector of each marker, as after a correction of where base "
    "and marker are.",
    "bias": "that mean error vector, in the frame of the measurements.",
    "95 % band": "where a marker is with a probability of 95 % if the model is right: by the covariance of the fit’s "
    "parameters and by the noise.",
    "outlier": "an error beyond six times the median of all, where fewer than one in ten are: often a marker that was "
    "mistaken for another.",
    "block": "samples that are not independent of each other, such as one pattern of commands or one release.",
    "held out": "samples that were kept from the fit: only they say how well it predicts.",
}
"""What words of the page mean."""


def millimetres(value: float) -> str:
    """Return a length [m] in millimetres, in as many digits as tell something."""
    if math.isnan(value):
        return "–"
    told = (
        f"{1e3 * value:.2f}"
        if abs(value) < 1e-3
        else f"{1e3 * value:.3g}"
        if abs(value) < 0.1
        else f"{1e3 * value:.0f}"
    )
    return told.replace("-", "\N{MINUS SIGN}")


def named(block: str) -> str:
    """Return what a block is called in pictures; many have a bare number for a name."""
    return f"block {block}" if block.isdigit() else block


def status_words(replay: Replay, row: int) -> str:
    """Return whether a sample was held out of the fit, or is of another recording; "" where that is not known."""
    if replay.held_out is None:
        return ""
    if replay.held_out.all():
        return "predicted"
    return "held out" if replay.held_out[row] else "fitted"


def headline(replay: Replay) -> str:
    """Say in one sentence how well the arm predicts."""
    found = replay.differences()
    if not found.count:
        return "Nothing was predicted."
    name = replay.recording.name
    if far := swaying(replay.distance):
        share = near(100 * found.percentile_95 / replay.arm.length)
        return (f"The arm predicts half of the markers of {name} within {millimetres(found.median)} mm, 95 % within "
                f"{millimetres(found.percentile_95)} mm, {share} % of its length ({millimetres(found.rms)} mm rms with "
                f"{told(far)}).")  # fmt: skip
    share = near(100 * found.rms / replay.arm.length)
    return f"The arm predicts {name} within {millimetres(found.rms)} mm rms, {share} % of its length."


def lead(replay: Replay) -> str:
    """Say what else is to be known of the error."""
    found, markers = replay.differences(), len(replay.recording.rig.markers)
    if not found.count:
        return "No marker was both seen and predicted."
    samples = f"{len(replay):,} samples" if markers == 1 else f"{markers} markers in {len(replay):,} samples"
    bias = ", ".join(millimetres(part) for part in found.bias)
    return (
        f"Of {samples}, half are off by less than {millimetres(found.median)} mm, 95 % by less than "
        f"{millimetres(found.percentile_95)} mm, the worst by {millimetres(found.largest)} mm. Without the mean offset "
        f"of ({bias}) mm the rms is {millimetres(found.centred_rms)} mm."
    )


def standings(replay: Replay) -> list[Standing]:
    """Say what the error is to be compared with: held out or not, within its bands or not, all predicted or not."""
    out = [_held_out(replay)]
    if replay.bands is not None:
        out.append(_bands(replay, replay.bands))
    elif replay.held_out is not None:
        out.append(Standing("note", "No bands.", "Bands come from the covariance of a fit: `--fit FOLDER`."))
    if replay.unpredicted:
        count = replay.unpredicted
        text = f"In {count} of {len(replay)} samples the arm has no pose at rest under the commands; they are left out."
        out.append(Standing("bad", "Not everything was predicted.", text))
    return out


def _held_out(replay: Replay) -> Standing:
    held = replay.held_out
    if held is None:
        text = "contarm cannot tell whether this arm was fitted to this recording: give `--fit FOLDER`."
        return Standing(
            "note", "A fit or a prediction?", text if replay.bands else f"{text} Then there are bands, too."
        )
    if held.all():
        text = "None of these samples were used for the fit."
        return Standing("good", "This is a prediction.", text)
    if not held.any():
        text = "The arm was fitted to these very samples: others will be predicted less well."
        return Standing("note", "This is a fit, not a prediction.", text)
    kept, own = replay.differences(held), replay.differences(~held)
    text = (f"{int(held.sum()):,} of {len(replay):,} samples were held out of the fit: {millimetres(kept.rms)} mm rms "
            f"there, {millimetres(own.rms)} mm in those that it was fitted to.")  # fmt: skip
    return Standing("note", "Part of it is a prediction.", text)


def _bands(replay: Replay, bands: Bands) -> Standing:
    found, far = replay.differences(), int(outliers(replay.distance).sum())
    outside = f"; {told(far, f'{found.count:,}')}" if far else ""
    inside = f"{100 * bands.share:.0f} % of the markers are inside their {100 * INSIDE:.0f} % bands{outside}."
    low, high = (millimetres(each) for each in bands.foreseen)
    ends = " to ".join(millimetres(each) for each in bands.rms)
    held = f" Not determined by the fit’s data, and taken as known: {', '.join(bands.held)}." if bands.held else ""
    foreseen = (f"The covariance of the parameters and a noise of {millimetres(bands.noise)} mm a coordinate foresee "
                f"an rms of {low} to {high} mm; it is {millimetres(found.rms)} mm.")  # fmt: skip
    if far:
        foreseen = f"{foreseen[:-1]}, and {millimetres(without(replay.distance))} mm without outliers."
    if bands.share < FEW:
        why = " The rest is error of the model, or of parameters that the fit took as known."
        if found.centred_rms < OFFSET * found.rms:
            why += " Most of it is one offset: of where base or markers are."
        return Standing("bad", inside, f"{foreseen}{why}{held}")
    much = "" if far else f" As the parameters vary within their intervals, the rms is {ends} mm."
    if bands.share > 0.5 * (1 + INSIDE) + 0.005:
        much += " So many are inside because the fit’s noise or covariance counts more than there is here."
    whole = bands.share >= INSIDE - 0.05 and (without(replay.distance) if far else 0.0) <= bands.foreseen[1]
    return Standing("good" if whole else "note", inside, f"{foreseen}{much}{held}")


def row(name: str, found: Differences, length: float) -> list[Any]:
    """Return a row of the table of errors: lengths in mm."""
    sizes = (found.rms, found.median, found.percentile_95, found.largest, found.centred_rms)
    share = "–" if math.isnan(found.rms) else near(100 * found.rms / length)
    return [name, f"{found.count:,}", *(millimetres(size) for size in sizes), share]


def marker_rows(replay: Replay) -> list[list[Any]]:
    """Return the rows of all markers together, of each where there are several, and of what was held out and fitted."""
    rows = [row("all", replay.differences(), replay.arm.length)]
    if len(replay.recording.rig.markers) > 1:
        rows += [row(name, found, replay.arm.length) for name, found in replay.by_marker().items()]
    held = replay.held_out
    if held is not None and held.any() and not held.all():
        parts = (("held out", held), ("fitted", ~held))
        rows += [row(name, replay.differences(part), replay.arm.length) for name, part in parts]
    return rows


def block_rows(replay: Replay, most: int | None = None) -> list[list[Any]]:
    """Return the rows of the blocks in their order; at most so many, those of the largest rms."""
    found = {name: each for name, each in replay.by_block().items() if each.count}
    if most is not None and len(found) > most:
        worst = sorted(found, key=lambda name: -found[name].rms)[:most]
        found = {name: found[name] for name in found if name in worst}
    return [row(name, each, replay.arm.length) for name, each in found.items()]


SWINGS = ["frequency measured [Hz]", "simulated", "off by [%]", "damping measured [1/s]", "simulated", "off by [%]"]
"""Columns of the table of swings."""


def swing_rows(replay: Replay) -> list[list[Any]]:
    """Return a row of each release, and their medians where there are several."""
    rows = [
        [one.measured.frequency, one.simulated.frequency, one.frequency_percent, one.measured.damping,
         one.simulated.damping, one.damping_percent]
        for one in replay.swings
    ]  # fmt: skip
    names = [one.block for one in replay.swings]
    if len(rows) > 1:
        rows.append(np.median(rows, axis=0).tolist())
        names.append("median")
    shown = ("{:.3f}", "{:.3f}", "{:+.1f}", "{:.2f}", "{:.2f}", "{:+.1f}")
    minus = "\N{MINUS SIGN}"
    return [
        [name, *(form.format(value).replace("-", minus) for form, value in zip(shown, row, strict=True))]
        for name, row in zip(names, rows, strict=True)
    ]


def stretch_rows(replay: Replay) -> list[list[Any]]:
    """Return rows of the distances between neighbouring markers: mean difference, and its rms [mm]."""
    return [[name, millimetres(mean), millimetres(size)] for name, mean, size in replay.stretch()]
