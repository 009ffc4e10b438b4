"""Closed-form kinematics of the inextensible section, NumPy only.

`arc` is bend <-> pose of the constant-curvature arc, `dome` its inverse, `muscles` bend <->
muscle length changes, `chain` the same for the chain of rigid links. `sections` is the kinematics
of several sections, `inverse` its inverse.
"""

from typing import TYPE_CHECKING, Any

from contarm_sim.kinematics import arc, chain, dome, muscles, sections

if TYPE_CHECKING:
    from contarm_sim.kinematics import inverse

__all__ = ["arc", "chain", "dome", "inverse", "muscles", "sections"]


def __getattr__(name: str) -> Any:
    if name == "inverse":  # late: it takes as long to load as NumPy's parts do, and simulations do without
        from importlib import import_module

        return import_module("contarm_sim.kinematics.inverse")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
