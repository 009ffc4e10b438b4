"""What a run's numbers are called, and what is said of them: the same on the terminal and on the page."""

from __future__ import annotations

from typing import Any

from contarm_sim.simulation.control import pulls_only
from contarm_sim.validation.verdict import MODEL_LIMIT

_PARTS = {
    "tip_error": "tip error (simulated vs analytic)",
    "discretisation": "  discretisation: arc vs chain form",
    "servo": "  servo: commanded vs measured lengths",
    "shape": "  shape: inertia, gravity, unequal joints",
    "motion": "    of which motion (vs at rest)",
    "backbone_error": "largest along the backbone",
    "miss": "miss (target vs dome)",
}


def parts(controller: str) -> dict[str, str]:
    """Return the error budget's parts and what they are called; `tip` shifts lengths on purpose."""
    if controller == "tip":
        return _PARTS | {"servo": "  lengths: the path's vs those shifted for the tip"}
    return _PARTS


def explanation(summary: dict[str, Any]) -> str:
    """Say in a sentence each where the difference comes from."""
    part = {name: 1e3 * summary[name]["max_m"] for name in ("discretisation", "servo", "shape")}
    shape = f"What lengths cannot see, sag, inertia and unequal joints, accounts for {part['shape']:.3f} mm"
    if summary["motion"] is not None:
        shape += f"; {1e3 * summary['motion']['max_m']:.3f} mm of it are motion, for at rest they are gone"
    lengths = f"Muscle lengths that are not as commanded account for {part['servo']:.3f} mm."
    if summary["controller"] == "tip":
        lengths = (
            f"Muscle lengths shifted on purpose, to bring the tip to its target, account for {part['servo']:.3f} mm."
        )
    lines = [
        f"Rigid links instead of an arc account for {part['discretisation']:.3f} mm, known in closed form.",
        lengths,
        f"{shape}.",
    ]
    if summary["miss"]["max_m"] > 1e-6:
        lines.append(f"Targets lie up to {1e3 * summary['miss']['max_m']:.2f} mm off the dome of reachable tips.")
    return " ".join(lines)


def remarks(summary: dict[str, Any]) -> list[str]:
    """Return what a reader must know beside the verdict, a line each."""
    found, muscle, pressures = [], summary["muscle"], summary["arm"]["muscle"]
    error, limit = summary["tip_error"]["max_percent"], summary["checks"][0]["limit"]
    if MODEL_LIMIT < error <= limit:
        found.append(
            f"the load explains it (limit {limit:.0f} % of length, for sag), but constant curvature does not hold: "
            f"{error:.1f} % is more than {MODEL_LIMIT:g} %"
        )
    if summary["motion"] is None:
        found.append(
            "some commanded pose has no rest, the loaded arm gives way there: the share of motion is not known"
        )
    if muscle["below_min_pressure"] and pulls_only(summary["controller"]):
        found.append(
            f"in {muscle['below_min_pressure']} samples a slack muscle would take less than the lowest pressure, "
            f"{pressures['min_pressure'] / 1e3:.0f} kPa; the controller `pressure` keeps to it"
        )
    if muscle["beyond_max_pressure"]:
        highest = pressures["max_pressure"] / 1e3
        found.append(f"{muscle['beyond_max_pressure']} samples would take real muscles more than {highest:.0f} kPa")
    return found
