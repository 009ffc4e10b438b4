"""What the page says in words."""

from __future__ import annotations

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import each
from contarm_sim.mechanics.shape import bends_of
from contarm_sim.model.arm import Arm
from contarm_sim.view.colours import ANALYTIC, CONTACT, TARGET
from contarm_sim.view.live.keeping import Keeper, line_of
from contarm_sim.view.live.session import Session
from contarm_sim.view.rendering.touch import contact_words, scale_words

_CHIP = "display:inline-block;width:0.8em;height:0.8em;border-radius:50%;margin-right:0.4em;vertical-align:-0.05em"

_LEGEND = (
    '<div class="contarm-legend" style="font-size:0.8em;line-height:1.5;padding:0.3em 0.8em 0">'
    f'<div><span style="{_CHIP};background:{ANALYTIC};opacity:0.7"></span>arm of constant curvature (analytic)</div>'
    f'<div><span style="{_CHIP};background:#545a64;border-radius:0"></span>simulated arm: disks and muscles</div>'
    f'<div><span style="{_CHIP};box-sizing:border-box;border:0.2em solid {TARGET}"></span>target of the tip</div></div>'
)
_TOUCHED = f'<div><span style="{_CHIP};background:{CONTACT}"></span>links that touch, and the forces on them</div>'


def legend(arm: Arm) -> str:
    """Return what is drawn in the scene, for beside it."""
    return _LEGEND.removesuffix("</div>") + (_TOUCHED if arm.world.touchable else "") + "</div>"


DRAG = "**Drag the ring** at the tip, or set the bend here:"


def readings(session: Session, pace: str, keeper: Keeper, arrows: float = 0.0) -> str:
    """Return what the page reads, as markdown: error, bends, contact, time, and whatever is not as it should be.

    Args:
        arrows: how long those of contact forces are [m/N].
    """
    reading, arm = session.reading, session.arm
    lines = [
        f"**Tip error {1e3 * reading.error:.2f} mm** ({100 * reading.error / arm.length:.2f} % of length)",
        *bend_lines(reading.bend, arm),
        f"t = {reading.time:.1f} s, {pace}",
    ]
    contacts = session.contacts
    if contacts is not None:
        scale = f" (arrows: {scale_words(arrows)})" if arrows and len(contacts) else ""
        lines.insert(1, contact_words(contacts) + scale)
    highest = each(arm, lambda group: group.law.pressure_limits[1])
    beyond = highest[reading.pressures > 1.001 * highest]
    if beyond.size:
        lines.append(f"**needs more than {1e-3 * beyond.min():.0f} kPa**")
    if session.recording is not None:
        lines.append(f"**recording, {session.recording.duration:.1f} s**")
    elif kept := line_of(keeper):
        lines.append(kept)
    if session.trouble:
        lines.append(f"**Not done:** {session.trouble}")
    if session.problem:
        lines.append(f"**Goal not followed:** {session.problem}")
    return "  \n".join(lines)


def bend_lines(bend: Array, arm: Arm) -> list[str]:
    """Return a bend [rad], shape (2 S,), in words, a line a section."""
    lines = []
    for number, own in enumerate(bends_of(bend, arm)):
        angle, plane = (np.degrees(x) for x in arc.to_polar(own))
        of_section = "" if len(arm.sections) == 1 else f" {number + 1}"
        lines.append(f"bend{of_section} {angle:.1f}° towards {plane:.0f}°")
    return lines
