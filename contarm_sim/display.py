"""How values say what they are: short texts, and the one door from results up to what draws them in notebooks.

Everything else imports downwards; `drawing` is asked only when somebody wants to see something.
"""

from __future__ import annotations

from dataclasses import MISSING, Field, fields, is_dataclass
from typing import TYPE_CHECKING, Any

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


def brief(value: Any) -> str:
    """Return a value in a few characters: numbers with four digits, arrays and collections by their size."""
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, str):
        return repr(one_line(value, 60))
    if hasattr(value, "shape") and hasattr(value, "tolist"):
        return _array(value)
    if is_dataclass(value):
        return f"{type(value).__name__}(...)"
    if isinstance(value, dict):
        return f"{len(value)} named: {one_line(', '.join(map(str, value)), 60)}"
    if isinstance(value, (tuple, list)):
        plain = len(value) <= 6 and all(isinstance(each, (int, float, str)) for each in value)
        return f"({', '.join(map(brief, value))})" if plain else f"{len(value)} of {type(value[0]).__name__}"
    return one_line(repr(value), 60)


def _array(value: Any) -> str:
    if value.ndim == 0:
        return brief(value.item())
    if value.size <= 6:
        return "[" + ", ".join(map(brief, value.ravel().tolist())) + "]"
    return f"an array of shape {value.shape}"


def call(value: Any) -> str:
    """Return the expression that makes a dataclass again, without the arguments that are its defaults."""
    if isinstance(value, tuple):
        return f"({', '.join(map(call, value))}{',' if len(value) == 1 else ''})"
    if not is_dataclass(value) or isinstance(value, type):
        return repr(value)
    given = [f"{item.name}={call(getattr(value, item.name))}" for item in differing(value)]
    return f"{type(value).__name__}({', '.join(given)})"


def differing(value: Any) -> list[Field[Any]]:
    """Return the fields of a dataclass that are not at their defaults."""
    return [item for item in fields(value) if item.init and getattr(value, item.name) != _default(item)]


def _default(item: Field[Any]) -> Any:
    return item.default if item.default_factory is MISSING else item.default_factory()
