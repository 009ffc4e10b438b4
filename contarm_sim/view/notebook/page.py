"""Small tables as HTML: colours and letters are the notebook's own, light or dark."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

_BOX = "display:flex;flex-wrap:wrap;gap:6px 24px;align-items:center;max-width:100%;margin:4px 0"
_TABLE = "border-collapse:collapse;margin:0;font-size:13px;line-height:1.45;font-variant-numeric:tabular-nums"
_RULE = "border:0;border-top:1px solid rgba(128,128,128,.35)"
_PLAIN = f"{_RULE};background:none;vertical-align:top"
_CELL = f"{_PLAIN};padding:2px 10px 2px 0;text-align:left;max-width:34em;white-space:normal"
_NUMBER = f"{_PLAIN};padding:2px 0 2px 14px;text-align:right;white-space:nowrap"
_NAME = f"{_CELL};font-weight:400;opacity:.75"

MOST_ROWS = 40
"""Rows of a table, at most."""


def card(title: str, table: str, picture: str = "", below: str = "") -> str:
    """Return HTML under a title: a table, a picture (SVG) beside it, and what stands below both."""
    beside = f"<div>{picture}</div>" if picture else ""
    return (
        f'<div style="font-family:system-ui,sans-serif;margin:2px 0"><div style="font-weight:700">{escape(title)}</div>'
        f'<div style="{_BOX}"><div style="min-width:0">{table}</div>{beside}</div>{below}</div>'
    )


def pairs(rows: Iterable[tuple[str, str]]) -> str:
    """Return a table of names and values."""
    lines = "".join(
        f'<tr style="background:none"><th scope="row" style="{_NAME}">{escape(name)}</th>'
        f'<td style="{_CELL}">{escape(value)}</td></tr>'
        for name, value in rows
    )
    return f'<table style="{_TABLE}"><tbody>{lines}</tbody></table>'


def grid(columns: Sequence[str], rows: Sequence[Sequence[str]], texts: int = 1) -> str:
    """Return a table whose first columns are texts, and whose others are numbers, or words in their place.

    Args:
        texts: number of the first.
    """
    styles = [_CELL if i < texts else _NUMBER for i in range(len(columns))]
    head = "".join(
        f'<th scope="col" style="{style};border-top:0;font-weight:400;opacity:.75">{escape(column)}</th>'
        for column, style in zip(columns, styles, strict=True)
    )
    body = "".join(f'<tr style="background:none">{_cells(row, styles)}</tr>' for row in rows[:MOST_ROWS])
    left = len(rows) - MOST_ROWS
    more = f"<small>and {left} more</small>" if left > 0 else ""
    table = f'<table style="{_TABLE}"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div style="overflow-x:auto">{table}{more}</div>'


def _cells(row: Sequence[str], styles: Sequence[str]) -> str:
    """Return the cells of a row; the last of a shorter row takes the room of those that are missing."""
    found = [f'<td style="{style}">{escape(cell)}</td>' for cell, style in zip(row, styles, strict=False)]
    if len(row) < len(styles):
        found[-1] = (
            f'<td colspan="{len(styles) - len(row) + 1}" style="{_CELL};padding-left:14px">{escape(row[-1])}</td>'
        )
    return "".join(found)
