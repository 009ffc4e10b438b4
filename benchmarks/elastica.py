"""Tip errors against converged solutions of the ideal rod [% of length], as the README's table shows them."""

import json
import sys
from pathlib import Path

import numpy as np

from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.statics.extrapolation import extrapolated

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from test_elastica import CASES, ORDINARY, ROD, _posed

KINDS = {"act": "muscles' moment", "dead": "dead couple", "follower": "follower couple"}
DIRECTIONS = {(0, 0, 0): "none", (0, 0, 1): "hanging", (0, 0, -1): "upright", (-1, 0, 0): "level", (1, 0, 0): "level"}


def _error(tip: np.ndarray, case: dict) -> float:
    return 100 * float(np.linalg.norm(tip - case["tip"])) / ROD["length_m"]


def _row(name: str) -> tuple[list[str], list[float]]:
    case = CASES[name]
    gravity = np.array(case["gravity"])
    said = DIRECTIONS.get(tuple(int(x) for x in np.sign(np.round(gravity, 9))), json.dumps(case["gravity"]))
    errors = [_error(equilibrium(*_posed(name, links)).tip, case) for links in (24, 48, 96)]
    errors.append(_error(extrapolated(*_posed(name, 24))[0].tip, case))
    load = KINDS[case["kind"]] if any(case["moment_Nm"]) else "own weight"
    bend = f"{case['phi_deg']:g}, {case['theta_deg']:g}" if any(case["moment_Nm"]) else "-"
    return [load, bend, said], errors


def main() -> None:
    """Print the table in Markdown."""
    print(
        "| load | bend, plane [deg] | gravity | 24 links | 48 | 96 | 24, extrapolated |\n|---|---|---|---|---|---|---|"
    )
    kept = []
    for name in CASES:
        words, errors = _row(name)
        if name in ORDINARY:
            kept.append(errors)
        else:
            words[0] += ", buckled"
        print(f"| {' | '.join(words)} | {' | '.join(f'{error:.4f}' for error in errors)} |")
    for word, pick in (("median", np.median), ("largest", np.max)):
        print(f"| {word} but the last | | | {' | '.join(f'{x:.4f}' for x in pick(kept, axis=0))} |")


main()
