"""Fits of synthetic recordings: how often the truth lies within the 95 % intervals, and what is said of the unseen.

A three-section arm of 24 links and nine tendons from its base, weightless: nothing known acts on it, so that stiffness
of backbone and tendons are determined by their ratios alone. 72 poses of 12 patterns, two markers, noise 0.5 mm, gaps,
outliers of 30 mm; each repeat has its own commands, noise, gaps and outliers. Minutes for each 100 repeats.

    python benchmarks/coverage.py [--repeats 100] [--first 0] [--case noise|offsets|both-stiffnesses]
"""

import argparse
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context

import numpy as np
from scipy.stats import binom

from contarm_sim.identify.fit import fit
from contarm_sim.identify.fitted import Fit, Parameter
from contarm_sim.identify.judge import judge
from contarm_sim.identify.losses import THRESHOLD
from contarm_sim.identify.predict import AtRest
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.residuals import Problem
from contarm_sim.identify.rig import Actuation, Marker, Rig
from contarm_sim.identify.shared import shared
from contarm_sim.identify.synthetic import random_windings, recorded
from contarm_sim.model.arm import Arm
from contarm_sim.model.named import with_parameters
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.model.world import World

ARM = Arm(
    sections=tuple(Section(length=0.065, links=8, mass=0.01, bending_stiffness=ei) for ei in (0.006, 0.005, 0.004)),
    routings=tuple(Routing(radius=0.0045, offset=offset, start="base") for offset in (0.0, 0.7, 1.4)),
    laws=(Tendon(stiffness=2e3, pretension=1e-3, max_tension=500.0),) * 3,
    world=World(gravity=(0.0, 0.0, 0.0)),
)
RIG = Rig(
    markers=(Marker(name="middle", xi=0.5), Marker(name="tip", offset=(0.0, 0.0, 0.008))),
    actuation=Actuation(channels=tuple(range(9)), slack=(0.0003, *(0.0,) * 8)),
    turn=(0.0, 0.0, 0.05),
)
FREE = ("section_*.bending_stiffness", "actuation.slack_1", "marker_2.offset.z", "frame.turn_z",
        "section_2.muscle.offset")  # fmt: skip
TRUTH = {
    "section_1.bending_stiffness": 0.006, "section_2.bending_stiffness": 0.005, "section_3.bending_stiffness": 0.004,
    "actuation.slack_1": 0.0003, "marker_2.offset.z": 0.008, "frame.turn_z": 0.05, "section_2.muscle.offset": 0.7,
}  # fmt: skip
START = with_parameters(ARM, {
    "section_1.bending_stiffness": 0.0075, "section_2.bending_stiffness": 0.004, "section_3.bending_stiffness": 0.005,
    "section_2.muscle.offset": 0.6,
})  # fmt: skip
START_RIG = replace(
    RIG,
    turn=(0.0, 0.0, 0.0),
    markers=(RIG.markers[0], Marker(name="tip")),
    actuation=Actuation(channels=tuple(range(9))),
)
OFFSET = 0.001
"""Of each marker's coordinates in one pattern, all samples alike [m], where residuals of a block go together."""


def made(seed: int, offset: float) -> Recording:
    """Return a recording, in the rig that a fit starts from."""
    windings, names = random_windings(ARM, 72, seed, samples=6, taut=0.001)
    found = recorded(
        ARM, RIG, windings, seed=10_000 + seed, noise=0.0005, gaps=0.05, outliers=0.03, blocks=names,
        predictor=partial(AtRest, threads=1),
    )  # fmt: skip
    number = np.unique(names, return_inverse=True)[1]
    away = np.random.default_rng(20_000 + seed).normal(0.0, 1.0, (number.max() + 1, 2, 3)) * offset
    return replace(found, positions=found.positions + away[number], rig=START_RIG)


def within(seed: int, offset: float) -> tuple[list[list[float]], float]:
    """Return of each parameter whether intervals hold the truth, how wide they are, and processor time [s].

    By blocks, by their bootstrap, and with each sample as a block of its own; the width by blocks over that. NaN where
    the parameter was said not to be determined.
    """
    recording, began = made(seed, offset), os.times()
    found = fit(START, recording, FREE, bootstrap=500, threads=1)
    spent = os.times()
    rows = []
    for one, other in zip(found.parameters, _by_samples(found, recording), strict=True):
        ends = ((one.low, one.high), (one.boot_low, one.boot_high), (other.low, other.high))
        inside = [float(low <= TRUTH[one.name] <= high) if np.isfinite(low) else np.nan for low, high in ends]
        rows.append([*inside, (one.high - one.low) / (other.high - other.low)])
    return rows, spent.user - began.user


def _by_samples(found: Fit, recording: Recording) -> tuple[Parameter, ...]:
    """Return the parameters with intervals of samples that are independent, at the same optimum."""
    own, every = recording.in_rig(found.rig), shared(found.arm, [recording.in_rig(found.rig)], FREE)
    problem = Problem(every, [own], [np.zeros(len(own), dtype=bool)], [AtRest(own, threads=1)], "soft_l1")
    errors, slopes = problem.errors(every.start[None])[0], problem.slopes(every.start, central=True)
    sample = np.broadcast_to(np.arange(len(own))[:, None, None], own.positions.shape)[np.isfinite(own.positions)]
    return judge(every.free, every.units, every.logarithmic, every.start, (every.low, every.high), every.start, errors,
                 slopes, sample, noise=found.noise, loss="soft_l1", loss_scale=THRESHOLD).parameters  # fmt: skip


def named(seed: int, offset: float) -> list[tuple[str, bool]]:
    """Return the status of each parameter and whether it has a value, where tendons' stiffness is free too."""
    found = fit(START, made(seed, offset), [*FREE, "muscle.stiffness"], threads=1)
    return [(one.status, bool(np.isfinite(one.value))) for one in found.parameters]


def main() -> None:
    """Print the tables in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first repeat")
    parser.add_argument("--case", choices=("noise", "offsets", "both-stiffnesses"), help="one alone")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.repeats)
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        if given.case in (None, "noise"):
            _table("independent noise", list(pool.map(partial(within, offset=0.0), seeds)))
        if given.case in (None, "offsets"):
            _table(
                f"an offset of {1e3 * OFFSET:g} mm for each pattern",
                list(pool.map(partial(within, offset=OFFSET), seeds)),
            )
        if given.case in (None, "both-stiffnesses"):
            both = list(pool.map(partial(named, offset=0.0), seeds))
            right = sum(all(one[k] == ("only with others", False) for k in (0, 1, 2, 7))
                        and all(one[k] == ("determined", True) for k in (3, 4, 5, 6)) for one in both)  # fmt: skip
            print(f"bending_stiffness and muscle.stiffness both free: named, not returned, and all others returned: "
                  f"{right} of {len(both)}")  # fmt: skip


def _table(title: str, found: list[tuple[list[list[float]], float]]) -> None:
    rows, count = np.array([rows for rows, _ in found], dtype=float), len(found)
    floor = round(0.93 * count)
    chance = binom.cdf(floor - 1, count, 0.95)
    spent = np.median([spent for _, spent in found])
    print(f"{title}: fits with the truth inside, of those that returned the parameter; {floor} of {count} wanted.")
    print(f"An interval of exactly 95 % misses that in {100 * chance:.0f} % of cases. One fit: {spent:.1f} s.\n")
    print("| parameter | by blocks | bootstrap | every sample a block | width, first over last |")
    print("|---|---|---|---|---|")
    for place, name in enumerate(TRUTH):
        own = rows[:, place]
        counts = " | ".join(f"{np.nansum(one):.0f} of {np.isfinite(one).sum()}" for one in own[:, :3].T)
        print(f"| `{name}` | {counts} | {np.nanmedian(own[:, 3]):.2f} |")
    print(flush=True)


if __name__ == "__main__":
    main()
