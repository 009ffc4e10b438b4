"""The muscle laws by the names that TOML files choose them by: `[muscle] law = "mckibben"`."""

from __future__ import annotations

from collections.abc import Callable

from contarm_sim.model.ideal import Ideal
from contarm_sim.model.law import MuscleLaw
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.tendon import Tendon

LAWS: dict[str, Callable[[], MuscleLaw]] = {"mckibben": McKibben, "tendon": Tendon, "ideal": Ideal}
"""The first is the default, whose parameters are also flags of the command line."""


def law_name(law: MuscleLaw) -> str:
    """Return the name of a law; that of its class if it is a user's own."""
    return next((name for name, kind in LAWS.items() if type(law) is kind), type(law).__name__)
