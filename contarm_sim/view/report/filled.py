"""What all pages have in common: where templates are, how text is made safe, what words mean."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from contarm_sim.files import write_whole
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_to_toml

MEANINGS = {
    "constant curvature": "the model: each section bends as an arc of a circle. The arc is the one that the commanded "
    "muscle lengths stand for.",
    "% of length": "distances as a share of the backbone’s length, so that arms of different sizes compare.",
    "discretisation": "the simulated arm is a chain of rigid links; this is how far a chain’s tip is from the arc’s, "
    "known in closed form.",
    "servo": "the muscles do not quite have the lengths that were commanded.",
    "shape": "what is left at the same muscle lengths: the arm is no arc, for weight and inertia bend it.",
    "sag": "the part of the shape that weight causes, at rest.",
    "motion": "how far the moving arm is from where it would come to rest.",
    "explained": "an ideal rod, computed by other means than the simulation, has the same tip under the same loads: "
    "the difference from the arc is physics, not a fault of the simulation.",
    "converged": "of a run: a smaller time step would not change the result. Of a validation: the error of the links "
    "falls with the square of their number.",
    "dome": "the surface of all tips that one arc can have; targets off it cannot be reached.",
}
"""What words of the pages mean."""

OF_OBJECTS = {
    "contact": "how far the tip is from where it would be without objects, by the same controller on the same path; "
    "the other parts are those without objects."
}
"""What more words mean where the arm can touch something."""


def write_filled(folder: Path, template: str, arm: Arm, summary: dict[str, Any], **given: Any) -> None:
    """Write report.html into a folder: a template with what all templates have, and what it is given."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    loader = PackageLoader("contarm_sim.view", "report/pages")
    pages = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    pages.filters["ticked"] = ticked
    common = {"about": arm_words(arm), "toml": arm_to_toml(arm), "command": summary["command"],
              "versions": summary["versions"],
              "meanings": MEANINGS | (OF_OBJECTS if arm.world.touchable else {})}  # fmt: skip
    text = pages.get_template(template).render(common | given)
    write_whole(folder / "report.html", text)


def ticked(text: str) -> Any:
    """Return text, safe to stand in a page, with `what stands so` as code and numbers on one line with their units."""
    from markupsafe import Markup, escape

    code = re.sub("`([^`]+)`", r"<code>\1</code>", str(escape(text)).replace("^2", "²"))
    return Markup(re.sub(r"(?<=\d) (?=(?:%|mm|ms|m|s|g|kg|N|kPa|deg)(?!\w))", "\u00a0", code))


def safe_json(value: Any) -> str:
    """Return JSON that may stand inside a script element."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")


def arm_words(arm: Arm, but: Iterable[str] = ()) -> str:
    """Describe an arm in a line: size, weight, what pulls; but for parameters of these names."""
    count, pull = len(arm.sections), ", ".join(f"{part:g}" for part in arm.gravity)
    parts = {
        "sections": "" if count == 1 else f"{count} sections",
        "length": f"{1e3 * arm.length:.4g} mm long",
        "mass": f"{1e3 * arm.mass:.4g} g",
        "links": f"{arm.links} links",
        "payload": f"payload {1e3 * arm.payload:.4g} g" if arm.payload else "",
        "gravity": f"gravity ({pull}) m/s² in the base frame" if any(arm.gravity) else "no gravity",
    }
    left_out = {part for name in but for part in name.split(".")}
    return ", ".join(said for name, said in parts.items() if said and name not in left_out)
