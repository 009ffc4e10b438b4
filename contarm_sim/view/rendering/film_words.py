"""What is written around the pictures of a film: numbers of the moment, and what colours mean."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from contarm_sim.view.colours import ANALYTIC, CONTACT, TARGET, error_colours, rgb
from contarm_sim.view.rendering.caption import Caption, Legend
from contarm_sim.view.rendering.cloud import TIP
from contarm_sim.view.rendering.draw import ALL, Overlays
from contarm_sim.view.rendering.look import Look, Scale
from contarm_sim.view.rendering.touch import contact_words, scale_words
from contarm_sim.view.sections import bend_words

if TYPE_CHECKING:
    from contarm_sim.results.trajectory import Trajectory

AXES = [(0.86, 0.15, 0.15), (0.10, 0.62, 0.20), (0.15, 0.35, 0.90)]
"""Colours of the axes of base and tip."""


_FREE, _STILL = 2, 1e-3
"""Of so many free objects at most it is said how far they are from where they began, unless they stay there [m]."""


def texts(
    samples: Trajectory, indices: list[int], name: str, speed: float, overlays: Overlays = ALL
) -> list[list[str]]:
    """Return what is said of some samples of a run, of each a list of short texts; its name first, if it has one.

    Args:
        overlays: what is drawn: of targets and arcs that are not, nothing is said.
    """
    aims, arcs = overlays.path or overlays.trace or overlays.target or overlays.ghost, overlays.ghost
    arm, error = samples.arm, samples.tip_error
    moving = bool(samples.time[-1] > samples.time[0])
    pace = "" if speed == 1 or not moving else f", {speed:g} × speed"
    return [
        [
            *([name] if name else []),
            f"t = {samples.time[i]:.2f} s{pace}" if moving else f"pose {i + 1} of {len(samples)}, at rest",
            *([f"tip error {1e3 * error[i]:.2f} mm = {100 * error[i] / arm.length:.2f} %"] if aims else []),
            *([f"{'bend' if len(arm.sections) == 1 else 'bends'} {bend_words(samples.bend[i], arm)}"] if arcs else []),
            *_moved(samples, i),
            *([contact_words(samples.contacts.at(i))] if samples.contacts is not None else []),
        ]
        for i in indices
    ]


def _moved(samples: Trajectory, index: int) -> list[str]:
    """Return how far free objects are from where they began, and how much higher, if they are few."""
    free = [each.name for each in samples.arm.world.objects if each.free]
    if samples.objects is None or len(free) > _FREE:
        return []
    ways = 1e3 * (samples.objects[index, :, :3] - samples.objects[0, :, :3])
    pull = np.array(samples.arm.gravity)
    rises = -ways @ pull / max(float(np.linalg.norm(pull)), 1e-9)
    moves = np.ptp(samples.objects[:, :, :3], axis=0).max(axis=1) > _STILL
    return [
        f"{name} moved {np.linalg.norm(way):.0f} mm{f', {rise:.0f} mm up' if rise >= 1 else ''}"
        for name, way, rise, moved in zip(free, ways, rises, moves, strict=True)
        if moved
    ]


def caption(look: Look, said: list[list[list[str]]], scale: Scale, notes: list[str]) -> Caption | None:
    """Return what writes around the pictures, or nothing if nothing is to be written.

    Args:
        said: of each run, of each of its pictures.
        notes: of each whole run.
    """
    if look.transparent or not look.captions:
        return None
    widest = [[max(column, key=len) for column in zip(*run, strict=True)] for run in said]
    return Caption(look.width, look.height, widest, legend(look.overlays, scale), notes, look.letters)


def legend(overlays: Overlays, scale: Scale) -> Legend:
    """Return the colours of what is drawn over the arm, by what they mean."""
    tints: Legend = {}
    if overlays.path:
        tints["path"] = [rgb(TARGET)]
    if overlays.trace:
        most = 1e3 * scale.error
        tints[f"tip, error 0 to {f'{most:.2g}' if most < 99.5 else f'{most:.0f}'} mm"] = error_colours(
            np.linspace(0, 1, 24), 1.0
        )
    if overlays.target and not overlays.path:
        tints["target"] = [rgb(TARGET)]
    if overlays.ghost:
        tints["analytic"] = [rgb(ANALYTIC)]
    if overlays.cloud is not None:
        tints[f"tips of {len(overlays.cloud.bones)} sampled arms"] = [TIP[:3]]
    if overlays.contacts and scale.newton:
        tints[f"contact force, {scale_words(scale.newton)}"] = [rgb(CONTACT)]
    if overlays.frames:
        tints["x, y, z"] = AXES
    return tints
