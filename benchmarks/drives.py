"""Tip errors of driven arms against the ideal rod [% of length], over seeded random loads, as a table in Markdown."""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from driven import order, span_errors, tip_errors
from random_drives import random_cases

SEED = 2024
COUNT = {"parallel": 40, "spans": 16}
ROWS = [
    ("parallel", "tensions", False),
    ("parallel", "pressures", False),
    ("parallel", "tensions", True),
    ("parallel", "pressures", True),
    ("spans", "tensions", False),
    ("spans", "pressures", False),
    ("spans", "tensions", True),
    ("spans", "pressures", True),
]
LINKS = (12, 24, 48)


def _row(path: str, kind: str, twist: bool) -> str:
    measure = tip_errors if path == "parallel" else span_errors  # spans: the rod has as many disks as links
    errors = measure(random_cases(SEED, COUNT[path], kind, twist), LINKS)
    cells = [path, kind, "yes" if twist else "no"]
    cells += [f"{np.median(column):.3f}, {column.max():.3f}" for column in errors.T]
    return f"| {' | '.join(cells)} | {order(errors[:, 1], errors[:, 2]):.2f} |"


def main() -> None:
    """Print the table: median and largest error at each number of links, and the order from 24 to 48."""
    print("| muscles | driven by | twists | 12 links | 24 | 48 | order |\n|---|---|---|---|---|---|---|")
    for row in ROWS:
        print(_row(*row), flush=True)


main()
