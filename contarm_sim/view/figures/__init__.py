"""The paper's figures and ours, each computed when it is drawn: `figures_of` names them."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Protocol

from contarm_sim.model.arm import Arm
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.view.report.map import no_map
from contarm_sim.view.style import Sheet

if TYPE_CHECKING:
    from contarm_sim.view.figures.common import OwnPath


class Draw(Protocol):
    """What draws a figure of an arm; those that follow a path take another one than the spiral."""

    def __call__(self, sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
        """Draw it on a sheet."""


def _drawn_by(module: str, name: str, follows: bool = False) -> Draw:
    """Return a function of this package, imported when it draws."""

    def draw(sheet: Sheet, arm: Arm, own: OwnPath | None = None) -> None:
        function = getattr(import_module(f"{__name__}.{module}"), name)
        function(sheet, arm, own) if follows else function(sheet, arm)

    return draw


FOLLOWING = ("path", "angles", "lengths", "lengths-on-map", "budget")
"""Figures of a motion along a path: the paper's spiral, or one's own."""

_PATH = ("the path in space: what is asked for, what the tip does", _drawn_by("path", "path", follows=True))
_ANGLES = ("bend and plane angle along the path, over time", _drawn_by("over_time", "angles", follows=True))

FIGURES: dict[str, tuple[str, Draw]] = {
    "fan": ("forward kinematics: arcs by bend and plane, the arm at rest beside them", _drawn_by("fan", "fan")),
    "possibility": (
        "lengths of muscles 2 and 3 that are possible, and the pressures that hold them",
        _drawn_by("lengths_on_map", "possibility"),
    ),
    "spiral": ("the paper's spiral on its shell, and the nearest one on the dome", _drawn_by("spiral", "spiral")),
    "path": _PATH,
    "angles": _ANGLES,
    "lengths": (
        "lengths of muscles 2 and 3 along the path, over time",
        _drawn_by("over_time", "lengths", follows=True),
    ),
    "lengths-on-map": (
        "the same lengths over the possibility map",
        _drawn_by("lengths_on_map", "lengths_on_map", follows=True),
    ),
    "errors-by-bend": ("tip error at rest against bend, in five scenarios", _drawn_by("studies", "errors_by_bend")),
    "error-map": ("tip error over the dome, five scenarios", _drawn_by("studies", "error_map")),
    "budget": (
        "tip error along the path, and parts that add up to it",
        _drawn_by("studies", "budget", follows=True),
    ),
    "convergence": ("tip error against the number of links", _drawn_by("studies", "convergence")),
    "controllers": ("tip error of every controller, free and loaded", _drawn_by("studies", "controllers")),
    "stiffness": ("tip stiffness against pressure at 60 degrees", _drawn_by("studies", "stiffness")),
    "sag": ("how far weight moves the tip, against weight over stiffness", _drawn_by("sag", "sag")),
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
    "elbow": ("two sections: the poses that reach one point, and their elbows", _drawn_by("elbow", "elbow")),
    "path": _PATH,
    "angles": _ANGLES,
}
"""The same of several sections."""


def left_out(arm: Arm) -> dict[str, str]:
    """Return the figures that cannot be drawn of an arm, and what they need."""
    if len(arm.sections) > 1:
        found = dict.fromkeys((name for name in FIGURES if name not in OF_SEVERAL), "an arm of one section")
        return found if len(arm.sections) == 2 else found | {"elbow": "an arm of two sections"}
    found = dict.fromkeys((name for name in OF_SEVERAL if name not in FIGURES), "an arm of several sections")
    if needed := no_map(arm):
        found |= dict.fromkeys(("possibility", "lengths-on-map"), needed)
    if not isinstance(arm.laws[0], PneumaticLaw):
        found["stiffness"] = "muscles with pressures"
    return found


def figures_of(arm: Arm) -> dict[str, tuple[str, Draw]]:
    """Return the figures that can be drawn of an arm.

    Raises:
        InputError: it can touch something.
    """
    arm.refuse_objects("figures are drawn")
    missing = left_out(arm)
    every = FIGURES if len(arm.sections) == 1 else OF_SEVERAL
    return {name: entry for name, entry in every.items() if name not in missing}
