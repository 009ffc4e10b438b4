"""Many cases: designs of experiments over parameters, run in chunks, kept as a table; and uncertain parameters.

sweep(spec)      run what is not done yet of a sweep: a TOML file, a dict, or the name of one in the package
load(folder)     the table of a sweep, done or not
read(spec)       a sweep, checked
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contarm_sim.sweeps.reading import read
    from contarm_sim.sweeps.run import sweep
    from contarm_sim.sweeps.spec import Spec
    from contarm_sim.sweeps.table import Sweep, load
else:

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name in _HOMES:
            return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


_HOMES = {"Spec": "spec", "Sweep": "table", "load": "table", "read": "reading", "sweep": "run"}

__all__ = ["Spec", "Sweep", "load", "read", "sweep"]


def __dir__() -> list[str]:
    return sorted(__all__)
