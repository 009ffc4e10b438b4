"""What figures a command writes: --figures, --figure-width and --no-titles, the same everywhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from contarm_sim.errors import InputError
from contarm_sim.view.prints import KINDS, WIDTHS, Prints

NONE = "none"
BOTH = "both"


def figure_options(default: str = "png") -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Add the three options; the function receives them as `prints`, a `Prints`."""

    def decorate(function: Callable[..., Any]) -> Callable[..., Any]:
        def wrapped(figures: str, figure_width: str, no_titles: bool, **given: Any) -> Any:
            widths = tuple(WIDTHS)[::-1] if figure_width == BOTH else (figure_width,)
            return function(prints=Prints(_kinds(figures), widths, not no_titles), **given)  # type: ignore[arg-type]

        wrapped.__doc__, wrapped.__name__ = function.__doc__, function.__name__
        wrapped.__click_params__ = getattr(function, "__click_params__", [])  # type: ignore[attr-defined]
        for option in reversed(_options(default)):
            wrapped = option(wrapped)
        return wrapped

    return decorate


def _options(default: str) -> list[Callable[[Any], Any]]:
    sizes = ", ".join(f"{name} {size:g} mm" for name, size in WIDTHS.items())
    return [
        click.option(
            "--figures", default=default, show_default=True, metavar="KIND,...",
            help=f"Kinds of files that figures are written as: {', '.join(KINDS)}, or {NONE}.",
        ),
        click.option(
            "--figure-width", default="page", show_default=True, type=click.Choice([*WIDTHS, BOTH]),
            help=f"Width in print, letters of 8 pt: {sizes}.",
        ),
        click.option("--no-titles", is_flag=True, help="Figures without headings, for a paper that has captions."),
    ]  # fmt: skip


def _kinds(text: str) -> Any:
    """Return the kinds of files that --figures names.

    Raises:
        InputError: an unknown one, or one named twice.
    """
    kinds = tuple(word.strip() for word in text.split(","))
    if kinds == (NONE,):
        return ()
    if any(kind not in KINDS for kind in kinds) or len(set(kinds)) < len(kinds):
        raise InputError("--figures", repr(text), f"{', '.join(KINDS)}, each once, with commas between; or {NONE}")
    return kinds
