"""What can be asked of a case: quantities by name, with unit and meaning."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Any, Literal

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.studies.trusted_bends import WITHIN
from contarm_sim.sweeps.names import Run

Kind = Literal["number", "whole", "truth"]


@dataclass(frozen=True)
class Quantity:
    """Something that a case tells.

    Attributes:
        name, unit, meaning: what it is.
        of: its value, of what a case tells (`sweeps.told`); None where there is none.
        kind: what its values are.
        costly: whether it takes simulations of its own, and is found where it is asked for by name alone; then it is
            also found where some pose at rest is missing.
        of_arm: whether the arm alone tells it, also where the case fails.
    """

    name: str
    unit: str
    meaning: str
    of: Callable[[Any], Any]
    kind: Kind = "number"
    costly: bool = False
    of_arm: bool = False


_DISTANCES = {
    "tip_error": "distance from the tip to that of the constant-curvature arcs",
    "discretisation": "part of the tip error, by rigid links in place of arcs",
    "servo": "part of the tip error, by muscle lengths that are not met",
    "shape": "part of the tip error, by another shape at the same muscle lengths (sag, inertia, torsion)",
    "backbone_error": "distance from the backbone to that of the arcs, anywhere along it",
}

_ROD = {
    "sag": "part of the shape that weight and payload explain, by an ideal rod",
    "unexplained": "part of the shape that an ideal rod leaves unexplained",
}


def _both(name: str, meaning: str, of: Callable[[Any], float | None]) -> Iterator[Quantity]:
    """Yield a distance in metres and in percent of length."""
    yield Quantity(name, "m", meaning, of)

    def percent(told: Any) -> float | None:
        found = of(told)
        return None if found is None else 100 * found / float(told.arm.length)

    yield Quantity(f"{name}_percent", "%", f"{meaning}, in % of length", percent)


def _largest(part: str) -> Callable[[Any], float | None]:
    return lambda told: told.largest(part)


def _rod(part: str) -> Callable[[Any], float | None]:
    return lambda told: told.rod_part(part)


def _contact(told: Any) -> float | None:
    moved = told.comparison.contact
    return None if moved is None else float(moved.max())


def _tip(place: int) -> Callable[[Any], float]:
    return lambda told: float(told.of("tip")[place])


def _of_any() -> Iterator[Quantity]:
    for name, meaning in {
        "weight_over_stiffness": "(m + payload) g L^2/EI; of several sections, L/EI is the sum of theirs",
        "own_weight_over_stiffness": "m g L^2/EI, without payload",
        "payload_over_mass": "payload over the mass of the arm",
    }.items():
        yield Quantity(name, "-", meaning, attrgetter(name), of_arm=True)


def _of_samples(motion: bool) -> Iterator[Quantity]:
    for name, meaning in _DISTANCES.items():
        yield from _both(f"{name}_max", f"largest {meaning}", _largest(name))
        if name == "tip_error":
            yield from _both("tip_error_rms", f"root mean square {meaning}", _rms)
            yield from _both("tip_error_mean", f"mean {meaning}", _mean)
    rod = _ROD | ({"inertia": "part of the shape that inertia and damping explain, by an ideal rod"} if motion else {})
    for name, meaning in rod.items():
        yield from _both(f"{name}_max", f"largest {meaning}", _rod(name))
    yield Quantity("orientation_error_max", "rad", "largest angle between the tip and that of the arcs", _turned)
    yield Quantity("worst_bend_angle", "rad", "bend angle at the largest tip error; of several sections the first",
                   lambda told: float(arc.to_polar(told.worst_bend[:2])[0]))  # fmt: skip
    yield Quantity("worst_bend_plane", "rad", "bending plane at the largest tip error; of several sections the first",
                   lambda told: float(arc.to_polar(told.worst_bend[:2])[1]))  # fmt: skip
    yield Quantity("tension_min", "N", "least tension of any muscle", lambda t: _least(t.samples.muscle_tensions))
    yield Quantity("tension_max", "N", "largest tension of any muscle", lambda t: _most(t.samples.muscle_tensions))
    if motion:
        yield from _both("target_error_max", "largest distance from the tip to the target", _largest("target_error"))
        yield from _both("tip_error_end", "distance from the tip to that of the arcs, at the end",
                         lambda told: float(told.comparison.tip_error[-1]))  # fmt: skip
        yield Quantity("timestep", "s", "time step of the engine", lambda told: told.step.timestep_s)
        yield from _both("step_error_max", "largest distance that the time step moves the tip by, an estimate",
                         lambda told: told.step.max_m)  # fmt: skip
        yield from _both("contact_max", "largest way that what the arm touches moves the tip", _contact)
        yield Quantity("contact_force_max", "N", "largest sum of the sizes of all contact forces of a moment",
                       lambda told: float(told.samples.contacts.total(len(told.samples)).max()))  # fmt: skip
        yield Quantity("contact_depth_max", "m", "how far a link and an object overlap at most",
                       lambda told: float(told.samples.contacts.deepest(len(told.samples)).max()))  # fmt: skip
        yield Quantity("explained", "-", "whether the motion is explained, as contarm run has it",
                       attrgetter("explained"), "truth")  # fmt: skip


def _of_bends() -> Iterator[Quantity]:
    for percent in WITHIN:
        meaning = f"largest bend, up to max_bend, at which the tip error stays within {percent:g} % of length"
        yield Quantity(f"bend_within_{percent:g}_percent", "rad", meaning,
                       _bend_within(percent), costly=True)  # fmt: skip


def _bend_within(percent: float) -> Callable[[Any], float | None]:
    return lambda told: told.bend_within(percent)


def _of_rest() -> Iterator[Quantity]:
    for place, axis in enumerate("xyz"):
        yield Quantity(f"tip_{axis}", "m", f"tip, along {axis} of the base", _tip(place))
    yield from _both("tip_error", "distance from the tip to that of the arcs asked for", lambda told: told.tip_error)
    yield from _both(
        "shape_error", "distance from the tip to that of arcs with these muscle lengths", lambda t: t.shape_error
    )
    yield Quantity("tension_min", "N", "least tension of any muscle", lambda t: _least(t.tensions))
    yield Quantity("tension_max", "N", "largest tension of any muscle", lambda t: _most(t.tensions))
    yield Quantity("tip_compliance", "m/N", "how far the tip gives way at most to a force", lambda t: t.compliance)
    yield Quantity("tip_stiffness", "N/m", "least stiffness of the tip against a force", lambda t: 1 / t.compliance)
    yield Quantity("smallest_eigenvalue", "N m/rad", "stiffness of the softest mode",
                   lambda told: float(told.of("smallest_eigenvalue")))  # fmt: skip
    yield Quantity("stable", "-", "whether disturbances die out", lambda told: told.stable, "truth")
    yield Quantity("held", "-", "whether no length servo is at its limit", lambda told: told.held, "truth")
    yield Quantity("residual", "N m", "largest generalised force left", lambda told: float(told.of("residual")))
    yield Quantity("iterations", "-", "of Newton's method", lambda told: int(told.of("iterations")), "whole")


def _of_muscles() -> Iterator[Quantity]:
    yield Quantity("pressure_max", "Pa", "highest pressure that any muscle needs", lambda told: told.pressure)
    yield Quantity("feasible", "-", "whether muscles have these tensions and pressures", lambda t: t.feasible, "truth")


def _least(values: Any) -> float | None:
    return float(values.min()) if values.size else None


def _most(values: Any) -> float | None:
    return float(values.max()) if values.size else None


def _rms(told: Any) -> float:
    return float(np.sqrt(np.mean(told.comparison.tip_error**2)))


def _mean(told: Any) -> float:
    return float(told.comparison.tip_error.mean())


def _turned(told: Any) -> float:
    return float(told.comparison.orientation_error.max())


def _named(*parts: Iterator[Quantity]) -> dict[str, Quantity]:
    return {quantity.name: quantity for part in parts for quantity in part}


DETAILS = ("tip_compliance", "tip_stiffness", "smallest_eigenvalue")
"""Quantities of an equilibrium that take longer than the pose."""

QUANTITIES: dict[Run, dict[str, Quantity]] = {
    "rest": _named(_of_samples(motion=False), _of_muscles(), _of_any(), _of_bends()),
    "equilibrium": _named(_of_rest(), _of_muscles(), _of_any()),
    "motion": _named(_of_samples(motion=True), _of_muscles(), _of_any()),
}
"""All that a run tells, by name."""
