"""What summary.json says of a fit: every number that is shown."""

from __future__ import annotations

from typing import Any

from contarm_sim.identify.fitted import Fit
from contarm_sim.results.document import document
from contarm_sim.versions import versions
from contarm_sim.view.report.fits.left_over import Rms, blocks, gaps, parts, repeatability, rms
from contarm_sim.view.report.fits.words import headline


def summary_of(fit: Fit, command: str) -> dict[str, Any]:
    """Return the summary of a fit, SI units; None where nothing is known.

    Args:
        fit: what was found.
        command: as it was typed, or where the fit comes from.
    """
    made: dict[str, Any] = document(fit.to_dict() | told(fit))
    return made | {"in_words": headline(fit), "versions": versions(), "command": command}


def told(fit: Fit) -> dict[str, Any]:
    """Return what a summary says beside what the fit says itself: errors by part and marker, what limits them."""
    rows = []
    for left in fit.left:
        markers = [None, *range(len(left.recording.rig.markers))]
        sizes = [
            {"part": part, "marker": None if k is None else left.recording.rig.markers[k].name} | _sizes(found)
            for part, chosen in parts(left).items() for k in markers if (found := rms(left, chosen, k)) is not None
        ]  # fmt: skip
        every = [(name, rms(left, chosen), held) for name, chosen, held in blocks(left)]
        limit = repeatability(left)
        rows.append({
            "name": left.recording.name,
            "errors": sizes,
            "blocks": [{"block": name, "held_out": held, "rms_m": size.rms} for name, size, held in every if size],
            "same_command_repeats_to_m": None if limit is None else limit[0],
            "hysteresis_m": {f"channel {channel}": gap for channel, gap in gaps(left).items()},
        })  # fmt: skip
    return {"left_over": rows}


def _sizes(found: Rms) -> dict[str, Any]:
    return {
        "samples": found.samples, "rms_m": found.rms, "rms_centred_m": found.centred, "median_m": found.median,
        "percentile_95_m": found.most,
    }  # fmt: skip
