"""The answer of `contarm trust`, in one paragraph and one figure."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import NullLocator

from contarm_sim.model.arm import Arm
from contarm_sim.studies.how_far import Trust, TrustUnderLoad
from contarm_sim.studies.trusted_bends import TrustedBend
from contarm_sim.studies.what_it_takes import Change
from contarm_sim.view.colours import LIMIT, LOADS
from contarm_sim.view.style import Sheet

_FLOOR = 1e-3
"""Least tip error that is drawn [% of length]."""

_TICKS = (1, 2, 5, 10, 20, 50, 100)
"""Bends that are named on a logarithmic axis [deg]."""


def paragraph(found: Trust) -> str:
    """Return the answer in words: how far to bend under each load, and what it would take to bend further."""
    said = [_opening(found)]
    said += [_how_far(found, each) for each in found.loads]
    said += [_what_it_takes(found, each) for each in found.loads if each.takes is not None]
    return " ".join(said)


def _opening(found: Trust) -> str:
    each = "" if len(found.arm.sections) == 1 else " of each section"
    return (
        f"The tip is within {found.within_percent:g} % of length ({_mm(found):.3g} mm) of where the constant-curvature "
        f"model puts it, whatever the bending plane, up to these bends{each}:"
    )


def _mm(found: Trust) -> float:
    return 10 * found.within_percent * found.arm.length


def _how_far(found: Trust, each: TrustUnderLoad) -> str:
    own = each.trusted.within(found.within_percent)
    return f"{each.trusted.under.meaning} {_bend(found, own)}" + ("." if each is found.loads[-1] else ",")


def _bend(found: Trust, bend: TrustedBend) -> str:
    if bend.everywhere:
        return f"{found.max_bend_deg:.0f} deg, the most that was tried"
    if bend.least_deg and bend.no_rest:
        return f"{bend.least_deg:.1f} deg, beyond which it has no pose at rest"
    return f"{bend.least_deg:.1f} deg" if bend.least_deg else "none, for it is off even when straight"


def _what_it_takes(found: Trust, each: TrustUnderLoad) -> str:
    takes, arm = each.takes, each.trusted.under.arm
    assert takes is not None
    now = "it has no rest somewhere" if takes.error_percent is None else f"now it is off by {takes.error_percent:.3g} %"
    start = f"To hold to {found.wanted_bend_deg:.0f} deg {each.trusted.under.meaning} ({now}), "
    if takes.bending_stiffness.factor is None and takes.mass.factor is None and takes.payload is None:
        return f"{start}no change of stiffness or mass helps: {takes.bending_stiffness.why_not}."
    ways = [_stiffness(takes.bending_stiffness, arm), _mass("mass", takes.mass)]
    if takes.payload is not None:
        ways.append(_mass("payload", takes.payload))
    return f"{start}it would take one of: {'; '.join(ways)}."


def _stiffness(change: Change, arm: Arm) -> str:
    if change.factor is None:
        return f"no bending stiffness ({change.why_not})"
    value = "" if change.value is None else f", {change.value:.3g} N m^2"
    return f"{change.factor:.3g} times the bending stiffness{value}{_muscles(change, arm)}"


def _muscles(change: Change, arm: Arm) -> str:
    """Say what the muscles would have to do, where they cannot."""
    if change.muscles_do:
        return ""
    if change.peak_pressure_pa is not None:
        has = min(group.law.pressure_limits[1] for group in arm.groups)
        return f" (which takes {change.peak_pressure_pa / 1e3:.0f} kPa; the muscles have {has / 1e3:.0f})"
    has = min(group.law.blocked_force for group in arm.groups)
    return f" (which takes {change.peak_tension_n:.0f} N; the muscles pull {has:.0f})"


def _mass(name: str, change: Change) -> str:
    if change.factor is None:
        return f"no {name}, however small ({change.why_not})"
    return f"{change.factor:.2g} times the {name}, {1e3 * (change.value or 0.0):.3g} g"


def draw_trust(sheet: Sheet, found: Trust) -> None:
    """Draw tip error against bend, a band over the bending planes for each load, and the largest bend by plane."""
    sheet.heading("How far to trust constant curvature: tip error at rest by bend, and the largest bend by plane")
    sheet.tall(75 if sheet.wide else 130)
    if sheet.wide:
        over, around = sheet.subplots(1, 2, width_ratios=[1.4, 1])
    else:
        over, around = sheet.subplots(2, 1, height_ratios=[1.5, 1])
    off_at_once = False
    for each in found.loads:
        (colour, dashes, _), errors = LOADS[each.trusted.under.load], each.trusted.error_percent
        shown = np.where(np.isfinite(errors) & (errors >= _FLOOR), errors, np.nan)[1:]
        rests = np.isfinite(shown).any(axis=1)
        bends, shown = found.bend_deg[1:][rests], shown[rests]
        if len(bends):
            low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
            over.fill_between(bends, low, high, color=colour, alpha=0.3, linewidth=0)
            over.plot(bends, high, color=colour, linestyle=dashes)
        own = each.trusted.within(found.within_percent)
        if own.least_deg and not own.everywhere:
            over.plot(own.least_deg, found.within_percent, "o", color=colour)
        planes, largest = np.append(found.plane_deg, 360.0), np.append(own.bend_deg, own.bend_deg[0])
        around.plot(planes, np.where(largest > 0, largest, np.nan), color=colour, linestyle=dashes)
        over.plot([], [], color=colour, linestyle=dashes, label=each.trusted.under.meaning)
        off_at_once |= not own.least_deg
    if off_at_once:
        note = "not drawn where the straight\narm is off by more already"
        around.text(180, 1.1 * found.bend_deg[1], note, ha="center", va="bottom")
    for bend in found.loads[0].trusted.bends:
        bold = bend.within_percent == found.within_percent
        over.axhline(bend.within_percent, color=LIMIT, linewidth=1.0 if bold else 0.5, zorder=0.5)
        over.annotate(f"{bend.within_percent:g} %", (found.max_bend_deg, bend.within_percent), xytext=(3, 0),
                      textcoords="offset points", ha="left", va="center", annotation_clip=False)  # fmt: skip
    over.set(xscale="log", yscale="log", xlim=(found.bend_deg[1], found.max_bend_deg), ylim=(_FLOOR, None))
    over.set(xlabel=f"bend angle{_each(found)} [deg]", ylabel="largest tip error [% of length]")
    around.set(yscale="log", xlim=(0, 360), ylim=(found.bend_deg[1], 1.15 * found.max_bend_deg))
    around.set_xticks(range(0, 361, 90))
    around.set(xlabel="bending plane [deg]", ylabel=f"largest bend within {found.within_percent:g} % [deg]")
    named = [angle for angle in _TICKS if angle <= found.max_bend_deg]
    over.set_xticks(named, [f"{angle:g}" for angle in named])
    around.set_yticks(named, [f"{angle:g}" for angle in named])
    for axis in (over.xaxis, around.yaxis):
        axis.set_minor_locator(NullLocator())
    over.yaxis.set_major_formatter("{x:g}")
    sheet.legend(*over.get_legend_handles_labels(), loc="outside lower center", ncols=4 if sheet.wide else 2)


def _each(found: Trust) -> str:
    return "" if len(found.arm.sections) == 1 else " of each section"
