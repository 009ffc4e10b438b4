"""The answer of `contarm trust`, in one paragraph and one figure."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import NullLocator

from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.studies.how_far import Trust, TrustUnderLoad
from contarm_sim.studies.what_it_takes import Change
from contarm_sim.view.colours import LIMIT, SCENARIOS
from contarm_sim.view.style import Sheet

_FLOOR = 1e-3
"""Least tip error that is drawn [% of length]."""

_TICKS = (1, 2, 5, 10, 20, 50, 100)
"""Bends that are named on a logarithmic axis [deg]."""


def paragraph(found: Trust) -> str:
    """Return the answer in words: how far to bend under each load, and how far it is off at the wanted bend."""
    length = f"{found.within_percent:g} % of length ({10 * found.within_percent * found.arm.length:.3g} mm)"
    each = "" if len(found.arm.sections) == 1 else " of each section"
    bends = "; ".join(f"{load.trusted.under.meaning}: {_bend(found, load)}" for load in found.loads)
    said = f"At rest, constant curvature is within {length} of this arm's tip up to these bends{each}. {bends}. "
    wanted = f"At {found.wanted_bend_deg:g} deg"
    beyond = [load for load in found.loads if load.takes is not None]
    if not beyond:
        return f"{said}{wanted} it holds under each of these loads."
    upto, errors, restless = f"p to {found.wanted_bend_deg:g} deg", [], []
    for load in beyond:
        assert load.takes is not None
        error, meaning = load.takes.error_percent, load.trusted.under.meaning
        if error is None:
            restless.append(meaning)
        else:
            errors.append(f"{meaning} {error:.3g} %")
    sentences = [f"U{upto}, the tip is off by at most this: {', '.join(errors)}."] if errors else []
    if restless:
        sentences.append(f"Not every bend u{upto} has a pose at rest under {', '.join(restless)}.")
    return said + " ".join(sentences)


def _bend(found: Trust, load: TrustUnderLoad) -> str:
    bend = load.trusted.within(found.within_percent)
    if bend.everywhere:
        return f"all that were tried, to {found.max_bend_deg:.0f} deg"
    if not bend.least_deg:
        return "none, for it is off even when straight"
    return f"{bend.least_deg:.1f} deg" + (", beyond which it has no pose at rest" if bend.no_rest else "")


def remedies(found: Trust) -> list[str]:
    """Return a line for each load under which the wanted bend is too far: what it would take."""
    return [_what_it_takes(load) for load in found.loads if load.takes is not None]


def _what_it_takes(load: TrustUnderLoad) -> str:
    takes, arm = load.takes, load.trusted.under.arm
    assert takes is not None
    if takes.muscles is not None:
        return f"{load.trusted.under.meaning}: stronger muscles{_muscles(takes.muscles, arm, ', for')}"
    ways = [_stiffness(takes.bending_stiffness, arm)] if takes.bending_stiffness.factor is not None else []
    changes = {"mass": takes.mass} | ({"payload": takes.payload} if takes.payload is not None else {})
    ways += [_mass(name, change) for name, change in changes.items() if change.factor is not None]
    if not ways:
        return f"{load.trusted.under.meaning}: more than stiffness or mass, for {takes.bending_stiffness.why_not}"
    missing = " or ".join(f"less {name}" for name, change in changes.items() if change.factor is None)
    return f"{load.trusted.under.meaning}: {', or '.join(ways)}" + (f"; {missing} alone is not enough" * bool(missing))


def _stiffness(change: Change, arm: Arm) -> str:
    value = "" if change.value is None else f" ({change.value:.4g} N m^2)"
    return f"{change.factor:.3g} times the bending stiffness{value}{_muscles(change, arm)}"


def _muscles(change: Change, arm: Arm, how: str = ", which takes") -> str:
    """Say what the muscles would have to do, where they cannot."""
    if change.muscles_do:
        return ""
    if change.peak_pressure_pa is not None:
        has = min(group.law.pressure_limits[1] for group in arm.groups)
        return f"{how} {change.peak_pressure_pa / 1e3:.0f} kPa (the muscles have {has / 1e3:.0f})"
    has = min(group.law.blocked_force for group in arm.groups)
    return f"{how} {change.peak_tension_n:.0f} N (the muscles pull {has:.0f})"


def _mass(name: str, change: Change) -> str:
    return f"{change.factor:.3g} times the {name} ({1e3 * (change.value or 0.0):.4g} g)"


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
        (colour, dashes, mark), errors = SCENARIOS[each.trusted.under.load], each.trusted.error_percent
        shown = np.where(np.isfinite(errors) & (errors >= _FLOOR), errors, np.nan)[1:]
        rests = np.isfinite(shown).any(axis=1)
        bends, shown = found.bend_deg[1:][rests], shown[rests]
        if len(bends):
            low, high = np.nanmin(shown, axis=1), np.nanmax(shown, axis=1)
            over.fill_between(bends, low, high, color=colour, alpha=0.3, linewidth=0)
            over.plot(bends, high, color=colour, linestyle=dashes)
        own = each.trusted.within(found.within_percent)
        if own.least_deg and not own.everywhere and not own.no_rest:
            over.plot(own.least_deg, found.within_percent, mark, color=colour)
        planes, largest = np.append(found.plane_deg, 360.0), np.append(own.bend_deg, own.bend_deg[0])
        around.plot(planes, np.where(largest > 0, largest, np.nan), color=colour, linestyle=dashes)
        over.plot([], [], color=colour, linestyle=dashes, marker=mark, label=each.trusted.under.meaning)
        off_at_once |= not own.least_deg
    if off_at_once:
        note = "not drawn where the straight\narm is off by more already"
        around.text(180, 1.1 * found.bend_deg[1], note, ha="center", va="bottom")
    for bend in found.loads[0].trusted.bends:
        bold = bend.within_percent == found.within_percent
        over.axhline(bend.within_percent, color=LIMIT, linewidth=1.2 if bold else 0.8, zorder=1.5,
                     linestyle="-" if bold else ":")  # fmt: skip
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
    if any(_spread(each.trusted.error_percent) > 0.02 for each in found.loads):
        over.fill_between([], [], [], color="#999999", alpha=0.5, linewidth=0, label="by bending plane")
    sheet.legend(*over.get_legend_handles_labels(), loc="outside lower center", ncols=4 if sheet.wide else 2)


def _spread(errors: Array) -> float:
    """Return the largest share by which errors differ between planes."""
    known = errors[np.isfinite(errors).all(axis=1) & (errors.max(axis=1) > _FLOOR)]
    return float(np.max(1 - known.min(axis=1) / known.max(axis=1), initial=0.0))


def _each(found: Trust) -> str:
    return "" if len(found.arm.sections) == 1 else " of each section"
