"""Loaded arms of two and three unlike sections against the ideal rod: errors along the backbone [% of length].

Random gravity, payload, wrenches in the middle and at the tip, and drives; half of the arms twist. Minutes.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from random_sections import random_cases

LINKS = (12, 24, 48)
EACH = 5
DRIVES = [("moments", "base"), ("tensions", "section"), ("tensions", "base"), ("pressures", "section"),
          ("pressures", "base")]  # fmt: skip
FROM = {"section": "their section", "base": "the arm's base"}


def main() -> None:
    """Print the table in Markdown."""
    print(
        "| sections | driven by | muscles from | 12 links a section | 24 | 48 | order |\n|---|---|---|---|---|---|---|"
    )
    rows, kept = [(size, *driven) for size in (2, 3) for driven in DRIVES], []
    for size, drive, start in rows:
        cases = [case for twist in (False, True) for case in random_cases(15, EACH, drive, size, start, twist)]
        errors = np.array([[case.error(links) for links in LINKS] for case in cases])
        kept.append(errors)
        _print([str(size), drive, "-" if drive == "moments" else FROM[start]], errors)
    _print([f"all {len(rows) * 2 * EACH} cases", "", ""], np.concatenate(kept))


def _print(words: list[str], errors: np.ndarray) -> None:
    middle, largest = np.median(errors, axis=0), errors.max(axis=0)
    order = np.median(np.log2(errors[:, 1] / errors[:, 2]))
    cells = [f"{a:.3f}, {b:.3f}" for a, b in zip(middle, largest, strict=True)]
    print(f"| {' | '.join([*words, *cells])} | {order:.2f} |", flush=True)


main()
