"""Names of a run's numbers and sentences about them, the same on the terminal, on the page and in the film."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

_PARTS = {
    "target_error": "target against simulated tip",
    "tip_error": "analytic against simulated tip",
    "discretisation": "  discretisation: arc vs chain form",
    "servo": "  servo: commanded vs measured lengths",
    "shape": "  shape: gravity, inertia, unequal joints",
    "sag": "    of which sag (ideal rod at rest)",
    "inertia": "    of which inertia, damping (ideal rod)",
    "unexplained": "    not explained (vs ideal rod in motion)",
    "contact_error": "  contact: with objects vs without",
    "motion": "motion: simulated tip vs at rest",
    "backbone_error": "largest along the backbone",
    "miss": "miss (target vs dome)",
}
_OFF_THE_DOME = "   targets off the dome"
_SPREAD = ("max_m", "rms_m", "max_percent", "rms_percent")


def budget(summary: dict[str, Any]) -> list[tuple[str, list[float]]]:
    """Return the error budget's rows: name, and max [mm], rms [mm], max and rms [% of length].

    Rows that are not known are left out. `tip` shifts lengths on purpose.
    """
    names = dict(_PARTS)
    if "sections" in summary:
        names["miss"] = "miss (target vs reachable tips)"
    if not summary["holds_lengths"]:
        names["servo"] = "  lengths: the path's vs those shifted for the tip"
    step = summary["time_step"]
    if step["max_m"] is not None:
        names["time_step"] = f"time step: {1e3 * step['timestep_s']:.4g} ms, its own error"
    rows = [(meaning, summary[name]) for name, meaning in names.items() if summary.get(name) is not None]
    scales = (1e3, 1e3, 1.0, 1.0)
    return [(name, [s * row[key] for s, key in zip(scales, _SPREAD, strict=True)]) for name, row in rows]


def curvature_words(found: dict[str, Any]) -> str:
    """Say whether constant curvature holds, with its error and the causes, from `constant_curvature` of a summary."""
    error, limit = found["error_percent"], found["limit_percent"]
    if found["holds"]:
        return f"holds within {error:.2f} % of length (limit {limit:g} %)"
    said, causes = f"does not hold: the error is {error:.1f} % of length (limit {limit:g} %)", curvature_causes(found)
    return said + (f"; causes, each alone: {causes}" if causes else "")


def curvature_causes(found: dict[str, Any]) -> str:
    """Name what alone would cause more than a tenth of the error; empty where nothing is known to."""
    names = {"the chain of links": "discretisation", "sag": "sag", "motion": "motion", "contact": "contact"}
    known = {said: found.get(f"{name}_percent") for said, name in names.items()}
    large = 0.1 * found["error_percent"]
    return ", ".join(f"{said} {part:.1f} %" for said, part in known.items() if part is not None and part > large)


def simulation_words(summary: dict[str, Any]) -> str:
    """Say whether the simulation is explained and converged, and why not."""
    if summary["verdict"] == "not judged":
        return "not judged"
    if "reason" in summary:
        return f"{summary['verdict']}: {summary['reason']}"
    known = [(summary["explained"], "explained"), (summary["converged"], "converged")]
    words = [(good, name if good else f"NOT {name}") for good, name in known if good is not None]
    said = (" and " if len({good for good, _ in words}) == 1 else ", but ").join(name for _, name in words)
    failed = failures(summary, targets=False)
    left = summary.get("unexplained")
    if failed or left is None:
        return f"{said}: {'; '.join(failed)}" if failed else said
    return f"{said}: the tip is within {within(left['max_percent'])} % of length of an ideal rod's"


def within(percent: float) -> str:
    """Return a percentage that something is within: never 0."""
    return f"{max(percent, 1e-3):.3f}"


def failures(summary: dict[str, Any], targets: bool) -> list[str]:
    """Return what failed and why: of the checks of targets, or of all others."""
    return [why for check in summary["checks"] if (check["group"] == "targets") is targets if (why := _failed(check))]


def targets_words(summary: dict[str, Any]) -> str:
    """Say whether the targets can be reached, and why not."""
    (check,) = (check for check in summary["checks"] if check["group"] == "targets")
    where = "reachable tips" if "sections" in summary else "the dome of reachable tips"
    near = f"at most {check['value']:.2f} % of length from {where} (limit {check['limit']:g} %)"
    return _failed(check) or near


def verdict_lines(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Return what is said of a run: constant curvature, the simulation, the targets, a name and a sentence each."""
    simulation = simulation_words(summary)
    if not summary["time_step"]["compared"]:
        simulation += "; the time step was not checked"
    return [
        ("constant curvature", curvature_words(summary["constant_curvature"])),
        ("simulation", simulation),
        ("targets", targets_words(summary)),
    ]


def in_short(summary: dict[str, Any]) -> str:
    """Return the verdict in a few words, for a film's caption."""
    found = summary["constant_curvature"]
    holds = "holds within" if found["holds"] else "does not hold: largest in the run"
    holds = f"{holds} {found['error_percent']:.2f} % of length"
    left, unsure = summary["unexplained"], ", not converged" if summary["converged"] is False else ""
    near = f" within {within(left['max_percent'])} %" if not unsure and left is not None else ""
    explained = f"explained{near}{unsure}"
    known = {True: explained, False: "not explained", None: "not judged"}[summary["explained"]]
    missed = "" if summary["targets_met"] else "   targets out of reach" if "sections" in summary else _OFF_THE_DOME
    return f"constant curvature {holds}   simulation {known}{missed}"


def noted(folder: Path) -> str:
    """Return what `in_short` says of the run that a folder holds; empty where its summary.json does not tell."""
    try:
        return in_short(json.loads((folder / "summary.json").read_text()))
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return ""


def _failed(check: dict[str, Any]) -> str:
    if check["passed"]:
        return ""
    value = "is not known" if check["value"] is None else f"{check['value']:.4g} {check['unit']}".rstrip()
    reason = f": {check['reason']}" if check["reason"] else ""
    return f"{check['name']} {value} (limit {check['limit']:.4g}){reason}"


def explanation(summary: dict[str, Any]) -> str:
    """Return a sentence for each cause of the difference."""
    part = {name: 1e3 * summary[name]["max_m"] for name in ("discretisation", "servo", "shape")}
    shape = f"Gravity, inertia and unequal joint angles cause up to {part['shape']:.3f} mm, at the same muscle lengths"
    if summary["motion"] is not None:
        shape += f"; up to {1e3 * summary['motion']['max_m']:.3f} mm of this is motion, and vanishes at rest"
    lengths = f"Differences between commanded and measured muscle lengths cause up to {part['servo']:.3f} mm."
    if not summary["holds_lengths"]:
        lengths = f"The controller changes muscle lengths to bring the tip to its target: {part['servo']:.3f} mm."
    lines = [
        f"Rigid links in place of an arc cause up to {part['discretisation']:.3f} mm, which is known in closed form.",
        lengths,
        f"{shape}.",
    ]
    if summary["unexplained"] is not None:
        left = 1e3 * summary["unexplained"]["max_m"]
        rod = "The tip of an ideal rod with the same muscle lengths, weight and accelerations"
        lines.append(f"{rod} is within {left:.3f} mm of the simulated tip.")
    if "contact_error" in summary:
        moved = f"Contact moves the tip by up to {1e3 * summary['contact_error']['max_m']:.3f} mm"
        lines.append(f"{moved}: its distance from the same motion without objects. All other parts are of that motion.")
    if summary["miss"]["max_m"] > 1e-6:
        off = "out of reach" if "sections" in summary else "off the dome of reachable tips"
        lines.append(f"Targets lie up to {1e3 * summary['miss']['max_m']:.2f} mm {off}.")
    return " ".join(lines)


def muscle_words(muscle: dict[str, Any], pneumatic: bool = True) -> list[tuple[str, str]]:
    """Return ranges of tension, pressure and contraction, a name and a value each; no pressure unless `pneumatic`."""
    pressure = muscle["max_pressure_needed_pa"]
    needed = "no pressure is enough" if pressure is None else f"{pressure / 1e3:.0f} kPa"
    pushes = f"{100 * muscle['push_fraction']:.3g} % of muscle samples"
    if muscle["pushes"]:
        pushes += f", largest {muscle['largest_push_n']:.2g} N"
    return [
        ("tensions", f"{muscle['min_force_n']:.1f} to {muscle['max_force_n']:.1f} N"),
        ("pushes", pushes),
        ("slack", f"{100 * muscle['slack_fraction']:.3g} % of muscle samples"),
        *([("highest pressure needed", needed)] if pneumatic else []),
        ("contractions", f"{100 * muscle['min_contraction']:.1f} to {100 * muscle['max_contraction']:.1f} %"),
    ]


def available(summary: dict[str, Any]) -> str:
    """Return the range of pressures that the arm has, or ranges where its sections differ."""
    return " or ".join(f"{low / 1e3:.0f} to {high / 1e3:.0f} kPa" for low, high in _pressures(summary))


def _laws(summary: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the parameters of the law of each section's muscles."""
    arm = summary["arm"]
    shared, owns = arm.get("muscle", {}), [section.get("muscle", {}) for section in arm.get("section", [{}])]
    return [own if "law" in own else {**shared, **own} for own in owns]  # a law of its own takes nothing of the shared


def _pressures(summary: dict[str, Any]) -> list[tuple[float, float]]:
    """Return the lowest and the highest pressures [Pa] of sections that differ; none where no muscle has any."""
    found = [(law["min_pressure"], law["max_pressure"]) for law in _laws(summary) if _pneumatic(law)]
    return list(dict.fromkeys(found))


def _pneumatic(law: dict[str, Any]) -> bool:
    return {"min_pressure", "max_pressure"} <= set(law)


def remarks(summary: dict[str, Any]) -> list[str]:
    """Return what a reader must know besides the verdict, a line each."""
    found, muscle, pulling = [], summary["muscle"], summary["pulls_only"]
    if summary.get("contact", {}).get("contacts") and "contact_error" not in summary:
        found.append("shares of contact and of motion unavailable: they are not told apart where the base moves, nor "
                     "of a motion that was interrupted or cannot be repeated without objects")  # fmt: skip
    elif summary["motion"] is None:
        found.append("motion share unavailable: a commanded pose is unstable or has no equilibrium")
    if muscle["pushes"]:
        share, most = 100 * muscle["push_fraction"], muscle["largest_push_n"]
        why = "the damping of a slack muscle pushes" if pulling else "plain position servos can push; not judged"
        found.append(f"muscles push in {share:.2g} % of muscle samples, with up to {most:.2g} N: {why}")
    if muscle["beyond_max_pressure"]:
        most = muscle["max_pressure_needed_pa"]
        needs = "more than any pressure gives" if most is None else f"up to {most / 1e3:.0f} kPa"
        count = f"{muscle['beyond_max_pressure']} of {summary['samples']} samples exceed this"
        found.append(f"a muscle needs {needs}; available {available(summary)}: {count}")
    if muscle["below_min_pressure"] and pulling:
        least = max(low for low, _ in _pressures(summary)) / 1e3
        count = f"{muscle['below_min_pressure']} of {summary['samples']} samples"
        line = f"in {count} some muscle needs less than {least:.0f} kPa, the lowest pressure of an inflated one, "
        line += "which this controller does not know of"
        if all(map(_pneumatic, _laws(summary))):  # else that controller is not for this arm
            line += f"; the controller `pressure` stays within {available(summary)}"
        found.append(line)
    return found
