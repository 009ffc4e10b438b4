"""The paper's figures and ours, each computed when it is drawn: `figures_of` names them."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

from contarm_sim.model.arm import Arm
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.view.report.map import no_map
from contarm_sim.view.style import Sheet

Draw = Callable[[Sheet, Arm], None]


def _drawn_by(module: str, name: str) -> Draw:
    """Return a function of this package, imported when it draws."""

    def draw(fig: Sheet, arm: Arm) -> None:
        getattr(import_module(f"{__name__}.{module}"), name)(fig, arm)

    return draw


FIGURES: dict[str, tuple[str, Draw]] = {
    "fan": (
        "forward kinematics: arcs by bend and plane, simulated chains on top",
        _drawn_by("paper", "fan"),
    ),
    "possibility": (
        "lengths of muscles 2 and 3 that are possible, and the pressures that hold them",
        _drawn_by("paper", "possibility"),
    ),
    "spiral": ("the paper's spiral on its shell, and the nearest one on the dome", _drawn_by("paper", "spiral")),
    "angles": ("bend and plane angle along the spiral, over time", _drawn_by("paper", "angles")),
    "lengths": ("lengths of muscles 2 and 3 along the spiral, over time", _drawn_by("paper", "lengths")),
    "lengths-on-map": ("the same lengths over the possibility map", _drawn_by("paper", "lengths_on_map")),
    "errors-by-bend": ("tip error at rest against bend, in five scenarios", _drawn_by("studies", "errors_by_bend")),
    "error-map": ("tip error over the dome, five scenarios", _drawn_by("studies", "error_map")),
    "budget": (
        "tip error along the spiral, and parts that add up to it",
        _drawn_by("studies", "budget"),
    ),
    "convergence": ("tip error against the number of links", _drawn_by("studies", "convergence")),
    "controllers": ("tip error of every controller, free and loaded", _drawn_by("studies", "controllers")),
    "stiffness": ("tip stiffness against pressure at 60 degrees", _drawn_by("studies", "stiffness")),
    "sag": ("gravity's effect against m g L^2/EI", _drawn_by("studies", "sag")),
}
"""Name, meaning and function of every figure of an arm of one section."""

OF_SEVERAL: dict[str, tuple[str, Draw]] = {
    "slices": (
        "where the tip can be in a plane through the axis: edges, folds, convex hull",
        _drawn_by("reach", "slices"),
    ),
    "density": ("how many of all poses have their tip where", _drawn_by("reach", "density")),
    "dexterity": (
        "how well the tip does where: directions that it can have; two sections: its least motion",
        _drawn_by("reach", "dexterity"),
    ),
    "elbow": ("two sections: the poses that reach one point, and their elbows", _drawn_by("reach", "elbow")),
}
"""The same of several sections."""


def left_out(arm: Arm) -> dict[str, str]:
    """Return the figures that cannot be drawn of an arm, and what they need."""
    if len(arm.sections) > 1:
        found = dict.fromkeys(FIGURES, "an arm of one section")
        return found if len(arm.sections) == 2 else found | {"elbow": "an arm of two sections"}
    found = dict.fromkeys(OF_SEVERAL, "an arm of several sections")
    if needed := no_map(arm):
        found |= dict.fromkeys(("possibility", "lengths-on-map"), needed)
    if not isinstance(arm.laws[0], PneumaticLaw):
        found["stiffness"] = "muscles with pressures"
    return found


def figures_of(arm: Arm) -> dict[str, tuple[str, Draw]]:
    """Return the figures that can be drawn of an arm."""
    missing = left_out(arm)
    return {name: entry for name, entry in (FIGURES | OF_SEVERAL).items() if name not in missing}
