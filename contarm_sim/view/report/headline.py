"""What a page of a run says first, in whole sentences: the answer, then how far it can be relied on."""

from __future__ import annotations

from typing import Any, NamedTuple

from contarm_sim.model.arm import Arm
from contarm_sim.view.report.contact_words import what_it_touches
from contarm_sim.view.report.words import curvature_causes, failures, within

State = str
"""`good`, `bad` or `note`."""


class Standing(NamedTuple):
    """One thing that a page says of a run: whether it is well, in a few words and in a sentence or two."""

    state: State
    title: str
    text: str


def headline(summary: dict[str, Any]) -> str:
    """Say in one sentence whether constant curvature holds, and within what."""
    found, touching = summary["constant_curvature"], what_it_touches(summary)
    if found["holds"]:
        also = f", though {touching}" if touching else ""
        return f"Constant curvature holds within {near(found['error_percent'])} % of the arm’s length{also}."
    also = f", and {touching}" if touching else ""
    off = f"the tip is up to {near(found['error_percent'])} % of length off its arc"
    return f"Constant curvature does not hold: {off}{also}."


def near(percent: float) -> str:
    """Return a percentage in as many digits as tell something."""
    if percent >= 10:
        return f"{percent:.1f}"
    return f"{percent:.2f}" if percent >= 0.1 else f"{max(percent, 1e-3):.1g}"


def lead(summary: dict[str, Any], arm: Arm) -> str:
    """Say what the headline's number is, what would be enough, and what causes it."""
    found, most = summary["constant_curvature"], 1e3 * summary["tip_error"]["max_m"]
    said = f"The simulated tip is at most {most:.3g} mm from the tip of the arc that the model of constant curvature "
    said += f"has in its place. The arm is {1e3 * arm.length:.4g} mm long; up to {found['limit_percent']:g} % of that, "
    said += f"{10 * found['limit_percent'] * arm.length:.3g} mm, counts as holding."
    causes = curvature_causes(found)
    return said if found["holds"] or not causes else f"{said} Causes, each alone: {causes}."


def standings(summary: dict[str, Any]) -> list[Standing]:
    """Say whether the run is whole, the simulation explained and converged, and the targets within reach."""
    return [*_cut_short(summary), _simulation(summary), _targets(summary)]


def _cut_short(summary: dict[str, Any]) -> list[Standing]:
    if not summary["interrupted"]:
        return []
    end, whole = (summary["samples"] - 1) / summary["rate"], summary["duration"]
    if whole is not None and end >= whole - 0.5 / summary["rate"]:
        text = "The motion is whole; not all of its checks are."
    else:
        of_whole = "" if whole is None else f" of {whole:g} s"
        text = f"It was stopped at {end:.2f} s{of_whole}; all numbers are about that part."
    return [Standing("note", "This run was interrupted.", text)]


def _simulation(summary: dict[str, Any]) -> Standing:
    explained, converged, left = summary["explained"], summary["converged"], summary["unexplained"]
    good = bool(explained) and converged is not False
    known = [(well, name if well else f"NOT {name}")
             for well, name in ((explained, "explained"), (converged, "converged")) if well is not None]  # fmt: skip
    joint = " and " if len({well for well, _ in known}) == 1 else ", but "
    title = f"The simulation is {joint.join(name for _, name in known)}."
    said = [f"{why[0].upper()}{why[1:]}." for why in failures(summary, targets=False)]
    if said:
        said.append("So the number above says little about constant curvature.")
    elif left is not None:
        said.append("An ideal rod of the same stiffness, with the same muscle lengths, weight and accelerations, has "
                    f"its tip within {within(left['max_percent'])} % of length of the simulated one.")  # fmt: skip
    step = summary["time_step"]
    if not step["compared"]:
        said.append("The time step was not checked.")
    elif converged and step["max_m"] is not None:
        said.append(f"The time step of {1e3 * step['timestep_s']:.3g} ms moves the tip by at most "
                    f"{within(step['max_percent'])} % of length.")  # fmt: skip
    return Standing("good" if good else "bad", title, " ".join(said))


def _targets(summary: dict[str, Any]) -> Standing:
    failed = failures(summary, targets=True)
    if failed:
        return Standing("bad", "Targets are out of reach.", f"{failed[0][0].upper()}{failed[0][1:]}.")
    (check,) = (check for check in summary["checks"] if check["group"] == "targets")
    off = f"They lie at most {check['value']:.2f} % of length off" if check["value"] >= 0.005 else "They lie on"
    if "sections" in summary:
        off = off.replace("They lie on", "They lie within")
    where = "what the tip can reach" if "sections" in summary else "the dome of tips that one arc can reach"
    return Standing("good", "All targets are within reach.", f"{off} {where}.")
