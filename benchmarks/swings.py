"""Swings of the trunk with a payload: fitted with one, predicted with another; and how far payloads shift its tip.

The data are others' and are not here, see docs/howto/real-arms.md: trunk_0g, trunk_release_200g and trunk_release_300g
(.csv.gz). Every second release is fitted to; with "held out" the others are meant.

    swings.py FOLDER                          three fits in processes of their own, a few minutes of one processor
    swings.py FOLDER --steps 12 --every 6     longer searches, more samples of each swing

Frequency and damping are those of the damped cosine that fits the last disk best (`ringdown`), over 1.6 s from where
the fastest disk has 70 % of its peak speed: medians of the releases, measured and predicted from the same starts. rms
is the distance of each disk over that time.
"""

import argparse
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
from identification import ARMS, RECORDINGS, TRUNK, TRUNK_BASE, loaded, thinned

from contarm_sim.identify.fit import fit
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.identify.prediction.moving import InMotion
from contarm_sim.identify.prediction.swing_start import speeds, start_of
from contarm_sim.identify.prediction.swings import swings_of
from contarm_sim.identify.recordings.file import load_recording
from contarm_sim.identify.recordings.rig_file import read_toml, toml_text
from contarm_sim.identify.replays.covariance import covariance_of
from contarm_sim.identify.search import descent
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import load_arm

PAYLOADS = (200, 300)
FOLLOWED, BEFORE = 160, 30  # samples of a swing: 1.6 s, and those before while a hand holds it
LINKS = 2  # of a section that swings: three, four and six come to the same within 0.3 mm
NOISE = 6e-3  # of a coordinate [m], statics and swings alike: what such a model leaves

START = {
    "bending_stiffness": (0.06, 0.02, 0.005), "damping_time": (0.1, 0.2, 2.0), "friction_moment": (0.138, 0.12, 0.03),
    "friction_stiffness": (0.6, 0.3, 2.0), "mass": (0.115, 0.115, 0.115), "section_radius": (0.03, 0.03, 0.03),
}  # fmt: skip
BOUNDS = {
    "bending_stiffness": (5e-4, 1.0), "damping_time": (1e-3, 5.0), "friction_moment": (3e-3, 2.0),
    "friction_stiffness": (5e-3, 5.0), "mass": (0.03, 0.4),
}  # fmt: skip
MASS = {"mean": 0.115, "sd": 0.06}
OF_SECTIONS = [
    Free(name=f"section_{k}.{name}", low=low, high=high, **(MASS if name == "mass" else {}))
    for name, (low, high) in BOUNDS.items()
    for k in (1, 2, 3)
]
SWINGING = [*OF_SECTIONS, *(Free(name=f"frame.turn_{axis}", low=-0.2, high=0.2) for axis in "xy")]
TOGETHER = [
    *(replace(one, sd=None) if one.name == "muscle.stiffness" else one for one in TRUNK if "bending" not in one.name),
    *OF_SECTIONS,
]
"""With payloads forces have a scale: EA of the cords needs no prior."""


class Own:
    """Predicts one recording with the arm changed; asks once for each arm: most parameters move few things."""

    def __init__(self, inner, changed):
        self.inner, self.changed, self.recording, self.known = inner, changed, inner.recording, {}

    def __call__(self, arms, rigs):
        pairs = [(self.changed(arm), rig) for arm, rig in zip(arms, rigs, strict=True)]
        new = [one for one in dict.fromkeys(pairs) if one not in self.known]
        if new:
            self.known |= zip(new, self.inner(*zip(*new, strict=True)), strict=True)
        out = np.stack([self.known[one] for one in pairs])
        self.known = self.known if len(self.known) < 300 else {}
        return out


def hanging(arm):
    """Return the arm without what its last pose leaves: under commands all of it has settled."""
    bare = arm.without_memory
    return replace(bare, sections=tuple(replace(one, damping_time=0.05) for one in bare.sections))


def swinging(arm):
    """Return the arm with its cords off, in few links."""
    return Arm(sections=tuple(replace(one, links=LINKS) for one in arm.sections), world=arm.world)


def releases(folder, arm):
    """Return the swings of each payload, cut to what is followed."""
    spec = read_toml(RECORDINGS / "trunk_release.toml", "data = ...")
    for one in spec["data"]:
        one["file"] = str((folder / one["file"]).resolve()) + ".gz"
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "recording.toml"
        file.write_text(toml_text(spec))
        every = load_recording(file, arm)
    every = every.in_rig(replace(every.rig, position=TRUNK_BASE))
    rows = [np.flatnonzero(every.blocks == name) for name in dict.fromkeys(every.blocks.tolist())]
    fast = [speeds(every.time[own], every.positions[own]) for own in rows]
    usual = np.median([one.max() for one in fast])
    kept = {grams: [] for grams in PAYLOADS}
    for own, speed in zip(rows, fast, strict=True):
        quick = int(np.argmax(speed > 0.4 * min(usual, speed.max())))  # the first: some are touched later
        own = own[max(0, quick - BEFORE) : quick + FOLLOWED + BEFORE]
        start = start_of(every.time[own], every.positions[own], every.release)[0]
        kept[round(1e3 * every.payload[own[0]])].append(own[: start + FOLLOWED])
    return {grams: every.part(np.concatenate(own)) for grams, own in kept.items()}


def halves(recording):
    """Return the masks of every second release, and of the others."""
    even = np.isin(recording.blocks, list(dict.fromkeys(recording.blocks.tolist()))[::2])
    return even, ~even


def trunk():
    """Return the arm that fits begin with."""
    arm = load_arm(ARMS / "trunk.toml")
    sections = [replace(one, **{name: x[k] for name, x in START.items()}) for k, one in enumerate(arm.sections)]
    return replace(arm, sections=tuple(sections))


def statics(folder):
    return thinned("trunk", loaded("trunk", load_arm(ARMS / "trunk.toml"), [folder / "trunk_0g.csv.gz"]))


def fitted(payloads, statically, given):
    """Return a fit to swings with payloads [g], and to the statics or not, and its minutes."""
    began, descent.MOST = time.process_time(), given.steps
    arm, own = trunk(), releases(given.folder, load_arm(ARMS / "trunk.toml"))
    swings = [one.part(halves(one)[0]) for one in (own[grams] for grams in payloads)]
    predictors = [Own(InMotion(one, 1), swinging) for one in swings]
    out = [np.arange(len(one)) % given.every != 0 for one in swings]
    if statically:
        few = statics(given.folder)
        predictors.insert(0, Own(AtRest(few, 1), hanging))
        swings, out = [few, *swings], [np.zeros(len(few), dtype=bool), *out]
    free = TOGETHER if statically else SWINGING
    found = fit(arm, swings, free, held_out=out, noise=NOISE, threads=1, predictors=predictors)
    return found, (time.process_time() - began) / 60


def told(name, found, rig, recording, rows):
    """Print what swings come to, measured and predicted."""
    predictor = InMotion(recording.in_rig(rig).part(rows))
    where = predictor([swinging(found.arm)], [rig])[0]
    seen = swings_of(predictor.recording, where)
    numbers = [[one.measured.frequency, one.simulated.frequency, one.measured.damping, one.simulated.damping]
               for one in seen]  # fmt: skip
    f, f_own, d, d_own = np.median(numbers, axis=0)
    mm = 1e3 * np.sqrt(np.nanmean(((predictor.recording.positions - where) ** 2).sum(axis=-1), axis=0))
    print(f"{name:36} {len(seen):6d} {f:5.2f} {f_own:6.2f} {100 * (f_own / f - 1):+6.1f} {d:6.2f} {d_own:6.2f} "
          f"{100 * (d_own / d - 1):+6.1f}   {'  '.join(f'{one:4.1f}' for one in mm)}", flush=True)  # fmt: skip


def shifts(found, few):
    """Print how far payloads shift the last disk under the commands of the statics, with what the fit leaves open."""
    left = covariance_of(found)
    own, vector = left.freedom, left.freedom.vector(left.freedom.values())
    steps = 0.1 * np.sqrt(np.diag(left.matrix))
    pairs = [own.applied(own.of_vector(one)) for one in (vector, *(vector + np.diag(steps)))]
    arms, rigs = [hanging(arm) for arm, _ in pairs], [rig for _, rig in pairs]
    tips = [AtRest(replace(few, payload=np.full(len(few), kg)))(arms, rigs)[:, :, -1] for kg in (0.0, 0.1, 0.2, 0.3)]
    for grams, loaded_tips in zip((100, 200, 300), tips[1:], strict=True):
        mm = 1e3 * np.sqrt(np.nanmean(((loaded_tips - tips[0]) ** 2).sum(axis=-1), axis=1))
        slope = np.divide(mm[1:] - mm[0], steps, out=np.zeros(len(steps)), where=steps > 0)
        half = 1.96 * float(np.sqrt(slope @ left.matrix @ slope))
        print(f"last disk shifted by {grams} g: {mm[0]:5.1f} mm, 95 % from {mm[0] - half:.1f} to {mm[0] + half:.1f}")
    print("held, and counted as known:", ", ".join(left.held) or "none")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where the recordings lie")
    parser.add_argument("--steps", type=int, default=6, help="most steps of one search (default %(default)s)")
    parser.add_argument("--every", type=int, default=12, help="sample of a swing that is kept (default %(default)s)")
    given = parser.parse_args()
    print("Medians over releases of the damped cosine, 1.6 s from 70 % of peak speed; rms of disks 1, 2, 3 [mm]")
    print(f"{'fitted to -> swings of':36} swings    Hz  model      %    1/s  model      %   rms", flush=True)
    own = releases(given.folder, load_arm(ARMS / "trunk.toml"))
    every = {grams: np.ones(len(one), dtype=bool) for grams, one in own.items()}
    others = {grams: halves(one)[1] for grams, one in own.items()}
    with ProcessPoolExecutor(3) as pool:
        fits = pool.map(fitted, ((200,), (300,), PAYLOADS), (False, False, True), [given] * 3)
        for one, (found, minutes) in zip(("200 g", "300 g", "0 g, 200 g, 300 g"), fits, strict=True):
            for grams, recording in own.items():
                seen = f"{grams} g" in one
                rig = next(left.recording.rig for left in found.left if left.recording.kind == "motion")
                told(f"{one} -> {grams} g{', held out' if seen else ''}", found, rig, recording,
                     (others if seen else every)[grams])  # fmt: skip
            print(f"  {minutes:.1f} minutes of processor", flush=True)
    print(f"last disk without payload, fitted: {1e3 * found.left[0].rms(marker=2, centred=True):.1f} mm")
    shifts(found, statics(given.folder))


if __name__ == "__main__":
    main()
