"""Studies of an arm, each a function that returns a frozen dataclass: what the command line prints.

    possibility          which bends pressures hold, free, under gravity and with a payload
    stiffness            how stiff co-contraction makes the tip at one bend
    hold                 the tensions and pressures that hold a bend
    release              let a held arm go, and judge its swing
    validate             how far to trust the constant-curvature model
    compare_controllers  the spiral under every controller and load
    cases_at_rest        static poses under one load case after another
    muscle_law           the force of one muscle by contraction and pressure
    judge_run            a recorded motion beside the closed forms
    without_objects      a recorded motion again, of the arm that touches nothing
    trust                how far an arm may bend until constant curvature is off

`document(result)` turns any of their results into the plain values that `--json` prints. Each function loads the
simulation when it is first asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contarm_sim.motion.without_objects import without_objects
    from contarm_sim.results.document import document
    from contarm_sim.studies.controllers import ControllerComparison, Followed, NotFollowed, compare_controllers
    from contarm_sim.studies.held_bend import Hold, hold
    from contarm_sim.studies.how_far import Trust, TrustUnderLoad, trust
    from contarm_sim.studies.judged_run import JudgedRun, judge_run
    from contarm_sim.studies.load_cases import CaseAtRest, CaseWithoutRest, LoadCase, cases_at_rest, read_cases
    from contarm_sim.studies.muscle_curves import MuscleCurves, muscle_law
    from contarm_sim.studies.pressure_map import LargestBend, Possibility, possibility
    from contarm_sim.studies.swings import Release, SwingSettings, release
    from contarm_sim.studies.tip_stiffness import Stiffness, StiffnessLevel, stiffness
    from contarm_sim.studies.validation import Failure, Outcome, Validation, validate
else:

    def __getattr__(name: str) -> object:
        from importlib import import_module

        for home, names in _HOMES.items():
            if name in names:
                found = getattr(import_module(f"contarm_sim.{home}"), name)
                globals()[name] = found  # a module of the same name would take its place
                return found
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


_HOMES = {
    "motion.without_objects": ("without_objects",),
    "results.document": ("document",),
    "studies.controllers": ("ControllerComparison", "Followed", "NotFollowed", "compare_controllers"),
    "studies.held_bend": ("Hold", "hold"),
    "studies.judged_run": ("JudgedRun", "judge_run"),
    "studies.load_cases": ("CaseAtRest", "CaseWithoutRest", "LoadCase", "cases_at_rest", "read_cases"),
    "studies.muscle_curves": ("MuscleCurves", "muscle_law"),
    "studies.pressure_map": ("LargestBend", "Possibility", "possibility"),
    "studies.swings": ("Release", "SwingSettings", "release"),
    "studies.tip_stiffness": ("Stiffness", "StiffnessLevel", "stiffness"),
    "studies.how_far": ("Trust", "TrustUnderLoad", "trust"),
    "studies.validation": ("Failure", "Outcome", "Validation", "validate"),
}

__all__ = [
    "CaseAtRest", "CaseWithoutRest", "ControllerComparison", "Failure", "Followed", "Hold", "JudgedRun", "LargestBend",
    "LoadCase", "MuscleCurves", "NotFollowed", "Outcome", "Possibility", "Release", "Stiffness", "StiffnessLevel",
    "SwingSettings", "Trust", "TrustUnderLoad",
    "Validation", "cases_at_rest", "compare_controllers", "document", "hold", "judge_run", "muscle_law",
    "possibility", "read_cases", "release", "stiffness", "trust", "validate",
    "without_objects",
]  # fmt: skip


def __dir__() -> list[str]:
    return sorted(__all__)
