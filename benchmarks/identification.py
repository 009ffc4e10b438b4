"""Real arms: parameters fitted to recordings, and how far the arm is off where it was not fitted.

The data are others' and are not here: give the folder that they lie in (docs/howto/real-arms.md says where they are
published). Arms and recordings to start from are in examples/arms. What is free, its priors, how samples are thinned
and whether friction is in were chosen by errors at blocks of the training files that were held out, by nothing else.

    identification.py FOLDER                                          blocks held out in turn, each arm
    identification.py FOLDER --arms tendon_v6 --friction
    identification.py FOLDER --arms tendon_v6 --test-on other.csv     fitted to the training file, then the other one

Errors are root mean square distances in mm, less each marker's mean offset, as the comparisons are; of the trunk those
of its last disk. Minutes are of the processor.
"""

import argparse
import tempfile
import time
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from contarm_sim.identify.fit import fit
from contarm_sim.identify.fit_folder import save_fit
from contarm_sim.identify.freedom import Free, freedom
from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.identify.prediction.remembering import WithMemory, rubs
from contarm_sim.identify.recordings.file import load_recording
from contarm_sim.identify.recordings.rig_file import read_toml, toml_text
from contarm_sim.model.arm_file import load_arm

ARMS = Path(__file__).parents[1] / "examples" / "arms"
RECORDINGS = Path(__file__).parents[1] / "examples" / "recordings"
SECTIONS = (1, 2, 3)

TENDON = [
    *(Free(name=f"section_{s}.bending_stiffness") for s in SECTIONS),
    *(Free(name=f"section_{s}.muscle_radius", sd=0.45e-3) for s in SECTIONS),
    *(Free(name=f"section_{s}.muscle.angle_{k}", sd=0.1) for s in SECTIONS for k in (1, 2, 3)),
    *(Free(name=f"actuation.slack_{k}", sd=1e-3) for k in range(1, 10)),
    *(Free(name=f"frame.turn_{axis}", sd=0.05) for axis in "xy"),
    *(Free(name=f"frame.{axis}", sd=2e-3) for axis in "xyz"),
    *(Free(name=f"marker.offset.{axis}", sd=1e-3) for axis in "xy"),
    Free(name="marker.offset.z", sd=1e-2),
]
"""Of the tendon arms; a turn of the frame about z is one of all angles, and stays."""

RUBBING = [
    *(Free(name=f"section_{s}.friction_moment", low=1e-5, high=0.3) for s in SECTIONS),
    *(Free(name=f"section_{s}.friction_stiffness", low=1e-4, high=1.0, mean=0.02, sd=0.02) for s in SECTIONS),
]
"""Of the tendon arms with friction in the backbone, beside the others."""

TRUNK = [
    *(Free(name=f"section_{s}.bending_stiffness", low=1e-3, high=0.3) for s in SECTIONS),
    Free(name="muscle.stiffness", sd=150.0, low=50.0, high=5e3),
    *(Free(name=f"actuation.gain_{k}", low=3e-3, high=0.1) for k in range(1, 7)),
    *(Free(name=f"actuation.slack_{k}", sd=3e-3) for k in range(1, 13)),
    *(Free(name=f"section_{s}.muscle.angle_{k}", sd=0.15) for s in SECTIONS for k in (1, 2, 3, 4)),
    *(Free(name=f"section_{s}.length", sd=4e-3) for s in SECTIONS),
    *(Free(name=f"frame.{axis}", sd=4e-3) for axis in "xyz"),
    *(Free(name=f"frame.turn_{axis}", sd=0.1) for axis in "xy"),
]
"""Of the trunk; the radii of its tendons are held: only their products with the gains are seen."""

FREE = {"tendon_v4": TENDON, "tendon_v6": TENDON, "trunk": TRUNK}
FOLDS = {
    "tendon_v4": (("*pair12*",), ("*pair13*",), ("*pair23*",), ("*same*",)),
    "tendon_v6": (("*pair12*",), ("*pair13*",), ("*pair23*",), ("*same*",)),
    "trunk": tuple((str(k), str(k + 5)) for k in range(1, 6)),
}
NOISE = {"tendon_v4": 2e-3, "tendon_v6": 2e-3, "trunk": 16e-3}
"""Of a coordinate [m]: what such an arm repeats itself by, about; of the trunk more, for the model errs by more."""

DATA = {"tendon_v4": "tendon_v4_train.csv", "tendon_v6": "tendon_v6_train.csv", "trunk": "trunk_0g.csv.gz"}
SLACK = {"tendon_v4": (-5e-4,), "tendon_v6": (-5e-4,), "trunk": (-6.8e-3, -9.7e-3, -9.4e-3)}
TRUNK_BASE = (0.098, -0.004, 0.107)
"""Where fits begin [m]: tendons are mounted under tension."""

COMPARE = {
    "tendon_v4": "asked 9; others: OpenCR-MuJoCo 12.1, constant curvature 12.5; repeats itself within 4.7",
    "tendon_v6": "asked 11; others: constant curvature 14.7; repeats itself within 5.1",
    "trunk": "asked 10 at the tip; others: quadratic regression 11.7",
}
SINGLES, THIN = 10, {"tendon_v4": 8, "tendon_v6": 5, "trunk": 40}
"""Of patterns that pull one tendon while the other eight are slack every tenth sample is kept; of the rest every ..."""


def loaded(name, arm, files):
    """Return the recording of an arm in data files, in the rig that its fit begins with."""
    own = name.replace("tendon", "tendon_arm")
    spec = read_toml(RECORDINGS / f"{own}.toml", "data = ...")
    spec["data"] = [str(Path(file).resolve()) for file in files]
    if name == "trunk":
        spec["block"] = {"seconds": 15}
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "recording.toml"
        place.write_text(toml_text(spec))
        recording = load_recording(place, arm)
    rig = recording.rig
    slack = np.repeat(SLACK[name], len(rig.actuation.channels) // len(SLACK[name])).tolist()
    position = TRUNK_BASE if name == "trunk" else rig.position
    return recording.in_rig(replace(rig, position=position, actuation=replace(rig.actuation, slack=tuple(slack))))


def thinned(name, recording):
    single = np.char.find(recording.blocks, "tendon") >= 0
    kept = ~single | (np.cumsum(single) % SINGLES == 0)
    return recording.part(kept).part(slice(None, None, THIN[name]))


def held(recording, patterns):
    return np.array([any(fnmatchcase(block, one) for one in patterns) for block in recording.blocks.tolist()])


def off(recording, predicted, rows, marker=-1):
    """Return the root mean square error of a marker at some samples [mm], without its mean."""
    error = (recording.positions - predicted)[rows, marker]
    error = error - np.nanmean(error, axis=0)
    return 1e3 * float(np.sqrt(np.nanmean((error**2).sum(axis=-1))))


def predicted(found, recording):
    predictor = WithMemory(recording) if rubs(found.arm) else AtRest(recording)
    return predictor([found.arm], [found.rig])[0]


def fitted(name, arm, recording, patterns=(), friction=False):
    """Return the fit to what is not held out; with friction it begins at the one without."""
    few = thinned(name, recording)
    out = held(few, patterns)
    found = fit(arm, few.part(~out), FREE[name], noise=NOISE[name])
    if not friction:
        return found
    begun = freedom(arm, recording.rig, FREE[name])
    free = [
        one if one.sd is None else replace(one, mean=float(value))
        for one, value in zip(begun.free, begun.values(), strict=True)
    ]
    sections = (replace(one, friction_moment=4e-3, friction_stiffness=0.02) for one in found.arm.sections)
    few = few.in_rig(found.rig)
    return fit(
        replace(found.arm, sections=tuple(sections)), few, [*free, *RUBBING], held_out=out, noise=NOISE[name],
        predictors=[WithMemory(few)],
    )  # fmt: skip


def folds(name, arm, recording, friction):
    """Hold blocks out in turn; print each and all together."""
    print(f"{'held out':14} {'samples':>7} {'held out':>9} {'fitted to':>9} {'minutes':>8}")
    squares, count = 0.0, 0
    for patterns in FOLDS[name]:
        began = time.process_time()
        found = fitted(name, arm, recording, patterns, friction)
        minutes = (time.process_time() - began) / 60
        out, where = held(recording, patterns), predicted(found, recording)
        mm, own = off(recording, where, out), off(recording, where, ~out & ~held(recording, ("*tendon*",)))
        print(f"{' '.join(patterns):14} {out.sum():7d} {mm:9.2f} {own:9.2f} {minutes:8.2f}", flush=True)
        squares, count = squares + mm**2 * out.sum(), count + out.sum()
    print(f"{'together':14} {count:7d} {np.sqrt(squares / count):9.2f}")


def tested(name, arm, recording, files, friction, folder):
    """Fit to all that is for training, and print the errors at other files."""
    found = fitted(name, arm, recording, (), friction)
    print(found)
    for one in found.parameters:
        print(f"  {one.name:28} {one.value:11.4g} {one.unit:14} {one.low:11.4g} to {one.high:11.4g} {one.status}")
    if folder:
        print("saved in", save_fit(found, folder / name))
    other = loaded(name, arm, files).in_rig(found.rig)
    where = predicted(found, other)
    every = np.ones(len(other), dtype=bool)
    for number, marker in enumerate(other.rig.markers):
        print(f"{marker.name:14} {len(other):7d} {off(other, where, every, number):9.2f}")
    for block in dict.fromkeys(other.blocks.tolist()):
        rows = other.blocks == block
        print(f"  {block:26} {rows.sum():5d} {off(other, where, rows):9.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where the recordings lie")
    parser.add_argument("--arms", nargs="+", choices=FREE, default=list(FREE))
    parser.add_argument(
        "--fit-on", nargs="+", type=Path, help="files to fit to (of one arm); default its own in FOLDER"
    )
    parser.add_argument(
        "--test-on", nargs="+", type=Path, help="files to predict (of one arm) after a fit to the others"
    )
    parser.add_argument("--friction", action="store_true", help="with friction that remembers (the tendon arms)")
    parser.add_argument("--out", type=Path, help="folder for the fitted arms, for contarm replay")
    given = parser.parse_args()
    for name in given.arms:
        arm = load_arm(ARMS / f"{name}.toml")
        recording = loaded(name, arm, given.fit_on or [given.folder / DATA[name]])
        print(f"\n{recording.name}: {len(recording)} samples, {len(FREE[name])} free parameters; {COMPARE[name]}")
        if given.test_on:
            tested(name, arm, recording, given.test_on, given.friction, given.out)
        else:
            folds(name, arm, recording, given.friction)


if __name__ == "__main__":
    main()
