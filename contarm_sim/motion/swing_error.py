"""How far a simulated swing is from the ideal arm's: what its step and its links leave, and a swing without either."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from contarm_sim.kinematics.arrays import Array
from contarm_sim.kinematics.chain import richardson
from contarm_sim.mechanics.shape import halved
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load
from contarm_sim.motion.release import DEFAULT, Swing, SwingSettings, release
from contarm_sim.statics.equilibrium import equilibrium


@dataclass(frozen=True)
class SwingError:
    """A swing, and an estimate of its error from runs of finer steps and fewer links.

    Attributes:
        swing: as it was asked for.
        tip: of the swing with neither step nor links, by extrapolation [m], shape (T, 3).
        positions: of the places, extrapolated likewise [m], shape (T, K, 3).
        step: of the tip, what finite steps leave [m], shape (T,).
        links: what the finite number of links leaves [m], shape (T,).
        total: both together, distance of the swing's tip from `tip` [m], shape (T,).
        order: at which the error falls with the step; None where nothing moves.
    """

    swing: Swing
    tip: Array
    positions: Array
    step: Array
    links: Array
    total: Array
    order: float | None


def judged_release(
    arm: Arm,
    load: Load,
    settings: SwingSettings = DEFAULT,
    track: Callable[[Iterable[int]], Iterable[int]] = iter,
) -> SwingError:
    """Hold an arm by a load, let go, and estimate the error of the swing; arguments as of `release`.

    Three steps, h, h/2 and h/4, give x(0) = (8 x(h/4) - 6 x(h/2) + x(h))/3 whatever there is of first and of second
    order; N and half as many links, at the same step, the part of second order in 1/N. Costs 7.4 runs.

    Args:
        track: is handed the numbers of the four runs and yields them, to show progress.

    Raises:
        EquilibriumError: no pose to let go from.
        InputError: as `release`, or fewer than 4 links.
        DivergenceError: the engine met a bad state.
    """
    fewer = halved(arm, fewest=4)
    half_step, quarter_step = (replace(settings, timestep=settings.timestep / share) for share in (2, 4))
    runs = [(arm, settings), (arm, half_step), (arm, quarter_step), (fewer, settings)]
    swings = []
    for i in track(range(len(runs))):
        made, stepped = runs[i]
        swings.append(release(made, equilibrium(made, load).qpos, load, stepped))
    # The tip is one more place, the last.
    full, half, quarter, coarse = (np.concatenate([x.positions, x.tip[:, None]], axis=1) for x in swings)
    by_step = full - (8 * quarter - 6 * half + full) / 3
    by_links = richardson(arm.links, fewer.links) * (coarse - full)
    ideal = full - by_step - by_links
    differences = [float(np.linalg.norm((x - y)[:, -1], axis=1).mean()) for x, y in ((full, half), (half, quarter))]
    return SwingError(
        swing=swings[0],
        tip=ideal[:, -1],
        positions=ideal[:, :-1],
        step=np.linalg.norm(by_step[:, -1], axis=1),
        links=np.linalg.norm(by_links[:, -1], axis=1),
        total=np.linalg.norm((by_step + by_links)[:, -1], axis=1),
        order=math.log2(differences[0] / differences[1]) if differences[1] > 1e-12 * arm.length else None,
    )
