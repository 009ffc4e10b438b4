"""Many cases: designs of experiments over parameters, run in chunks, kept as a table; and uncertain parameters.

sweep(spec)      run what is not done yet of a sweep: a TOML file, a dict, or the name of one in the package
load(folder)     the table of a sweep, done or not
read(spec)       a sweep, checked

on_workers(count), on_scheduler(address), on_dask(client)    sweep(spec, runner=...): on a Dask cluster

uncertain_motion(run, file)       a motion of arms whose parameters are uncertain: tip error as a distribution
uncertain_pose(arm, load, file)   a static pose of such arms
read_uncertain(file, arm)         uncertain parameters, checked
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contarm_sim.sweeps.cluster import on_scheduler, on_workers
    from contarm_sim.sweeps.dask_tasks import on_dask
    from contarm_sim.sweeps.reading import read
    from contarm_sim.sweeps.run import sweep
    from contarm_sim.sweeps.spec import Spec
    from contarm_sim.sweeps.spread_of_motion import UncertainMotion, uncertain_motion
    from contarm_sim.sweeps.spread_of_pose import UncertainPose, uncertain_pose
    from contarm_sim.sweeps.table import Sweep, load
    from contarm_sim.sweeps.uncertain import Uncertain, read_uncertain
else:

    def __getattr__(name: str) -> object:
        from importlib import import_module

        if name in _HOMES:
            return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


_HOMES = {
    "Spec": "spec", "Sweep": "table", "Uncertain": "uncertain", "UncertainMotion": "spread_of_motion",
    "UncertainPose": "spread_of_pose", "load": "table", "on_dask": "dask_tasks",
    "on_scheduler": "cluster", "on_workers": "cluster", "read": "reading", "read_uncertain": "uncertain",
    "sweep": "run", "uncertain_motion": "spread_of_motion", "uncertain_pose": "spread_of_pose",
}  # fmt: skip

__all__ = [
    "Spec", "Sweep", "Uncertain", "UncertainMotion", "UncertainPose", "load", "on_dask", "on_scheduler",
    "on_workers", "read", "read_uncertain", "sweep", "uncertain_motion", "uncertain_pose",
]  # fmt: skip


def __dir__() -> list[str]:
    return sorted(__all__)
