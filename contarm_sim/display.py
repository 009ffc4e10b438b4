"""How results say what they are, and the one door from them up to what draws them in notebooks.

Everything else imports downwards; `drawing` is asked only when somebody wants to see something.
"""

from __future__ import annotations

from dataclasses import fields
from typing import TYPE_CHECKING, Any

from contarm_sim.brevity import brief
from contarm_sim.errors import one_line

if TYPE_CHECKING:  # what results say that their methods return
    from contarm_sim.view.notebook.films import Film as Film
    from contarm_sim.view.notebook.reports import Report as Report
    from contarm_sim.view.style import Sheet as Sheet

LONGEST = 400
"""Most characters of the text of a result."""


def drawing() -> Any:
    """Return `contarm_sim.view.notebook`, which draws results; loaded when it is first asked for."""
    from contarm_sim.view import notebook

    return notebook


class Shown:
    """A dataclass that says what it holds in a few words, and shows itself in notebooks as a small table.

    Declare it with `repr=False`, or the dataclass brings a text of its own.
    """

    def __repr__(self) -> str:
        owner: Any = self
        said = ", ".join(f"{item.name}={brief(getattr(self, item.name))}" for item in fields(owner) if item.repr)
        return one_line(f"{type(self).__name__}({said})", LONGEST)

    def _repr_html_(self) -> str:
        return str(drawing().html(self))
