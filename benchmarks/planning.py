"""Poses and courses of a two-section arm that avoid: random scenes solved, clearances by brute force, processor time.

Scenes are posts, walls and windows (`tests/obstructed.py`) across poses that reach the target; those that `avoid` calls
blocked are looked through by dense sampling of the family. Paths have a post in the way of a plain course. Clearances
are those of densely sampled arcs by formulas of their own. Times are of the process, with what a new scene must be
prepared for.
"""

import sys
import time
from pathlib import Path

import numpy as np

from contarm_sim import planning
from contarm_sim.errors import BlockedError

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from obstructed import KINDS, clearances, connected, course, scene, solvable


def poses(count):
    """Print what comes of random scenes and one target in each."""
    taken, kinds = [], {kind: [0, 0, 0, 0] for kind in KINDS}
    violated, missed = [], []
    planning.avoid(*scene(10**6), margin=0.0)
    for number in range(count):
        arm, target = scene(number)
        tally = kinds[KINDS[number % 3]]
        start = time.process_time()
        try:
            found = planning.avoid(arm, target)
        except BlockedError:
            found = None
        taken.append(time.process_time() - start)
        if found is None:
            tally[2] += 1
            if solvable(arm, target, planning.default_margin(arm)):
                tally[3] += 1
                missed.append(number)
            continue
        tally[0 if found.looked == 1 else 1] += 1
        least = clearances(found.bends[None], arm, 2000)[0]
        if least < found.margin or found.miss > 1e-9 or least < found.clearance - 1e-6:
            violated.append((number, least))
    for kind, (free, solved, blocked, lost) in kinds.items():
        share = 100 * (free + solved) / max(free + solved + lost, 1)
        print(
            f"{kind:8} {free:4d} clear at once, {solved:4d} avoided, {blocked:4d} blocked, solvable {lost:3d}; "
            f"{share:.2f} % solved"
        )
    every = 1e3 * np.array(taken)
    print(f"violations {violated}; missed scenes {missed}")
    median, most = np.median(every), np.quantile(every, 0.99)
    print(f"processor time: median {median:.1f}, 99 % {most:.1f}, worst {every.max():.1f} ms")


def courses(count, margin=0.005):
    """Print what comes of random paths past a post, beside chains of clear poses by dense sampling."""
    found = least = taken = together = 0
    blocked = []
    for number in range(count):
        given = course(number)
        if given is None:
            continue
        arm, targets = given
        start = time.process_time()
        try:
            bends = planning.avoid_along(arm, targets, margin).bends
        except BlockedError:
            blocked.append((number, arm, targets))
            continue
        taken += time.process_time() - start
        found += 1
        least += clearances(bends, arm, 400).min() < margin
        together = max(together, np.linalg.norm(np.diff(bends, axis=0), axis=(-1, -2)).max())
    lost = [number for number, arm, targets in blocked if connected(arm, targets, margin)]
    print(
        f"courses: {found} found, {least} of them too near, largest step {together:.2f} rad, "
        f"{taken / found:.2f} s each; {len(blocked)} blocked, a chain by dense sampling {lost}"
    )


if __name__ == "__main__":
    poses(*map(int, sys.argv[1:2] or ["1000"]))
    courses(*map(int, sys.argv[2:3] or ["100"]))
