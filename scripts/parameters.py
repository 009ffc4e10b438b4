"""Prints every parameter of an arm with its flag, default and meaning as a table in Markdown, from the command line."""

from __future__ import annotations

import re

from contarm_sim.cli.options import ArmOption
from contarm_sim.cli.run import run

HELP = re.compile(r"(?P<meaning>.*?)(?: \[(?P<unit>[^\]]+)\])?; default (?P<default>.*)\.$")


def parameters() -> list[tuple[str, str, str, str]]:
    """Return (name in TOML, default, unit, meaning) of every parameter that has a flag."""
    rows = []
    for option in run.params:
        found = HELP.match(getattr(option, "help", None) or "") if isinstance(option, ArmOption) else None
        if found:
            name = option.opts[0].removeprefix("--").replace("-", "_")
            rows.append((name, found["default"], found["unit"] or "", found["meaning"]))
    return rows


def main() -> None:
    """Print the table."""
    print("| parameter | default | unit | meaning |\n|---|---|---|---|")
    for name, default, unit, meaning in parameters():
        print(f"| `{name}` | {default} | {unit} | {meaning} |")


if __name__ == "__main__":
    main()
