"""A fit made by hand: an arm, a recording with gaps, outliers and hysteresis, and parameters of every status."""

from dataclasses import replace

import numpy as np

from contarm_sim.identify.fitted import Combination, Fit, Left, Parameter
from contarm_sim.identify.freedom import Free, free_names, freedom
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.rig import Actuation, Marker, Rig
from contarm_sim.model.presets import preset

NAN = float("nan")
GAP = 0.006
"""What the hysteresis of the first channel is [m]."""


def left_over(count=240, seed=0, kind="static", markers=1):
    """Return what is left over of a made recording: of a static one commands go up and down in eight blocks."""
    rng = np.random.default_rng(seed)
    block = np.arange(count) // (count // 8)
    phase = np.arange(count) % (count // 8) / (count // 8)
    up = 1 - np.abs(2 * phase - 1)
    towards = 2 * np.pi * block / 8
    commands = 0.02 * up[:, None] * np.stack([np.cos(towards - 2 * np.pi * k / 3) for k in range(3)], axis=1)
    places = np.linspace(1, 0, markers, endpoint=False)[::-1]
    out = 9 * np.stack([commands[:, 0], (commands[:, 1] - commands[:, 2]) / np.sqrt(3)], axis=1)
    tip = np.concatenate([out, np.sqrt(np.maximum(0.45**2 - (out**2).sum(axis=1, keepdims=True), 0))], axis=1)
    predicted = places[None, :, None] * tip[:, None]
    along = out / np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    lag = 0.5 * GAP * np.where(phase < 0.5, 1, -1)[:, None] * along
    positions = predicted + rng.normal(0, 0.001, predicted.shape)
    positions[:, :, :2] += lag[:, None]
    positions[5::40] = NAN
    positions[17::90, -1] += [0.02, -0.015, 0.01]
    drive = Actuation(channels=tuple(range(3)) * 3) if count else Actuation()
    rig = Rig(markers=tuple(Marker(name=f"disk {k + 1}", xi=float(x)) for k, x in enumerate(places)), actuation=drive)
    time = np.arange(count) * (0.01 if kind == "motion" else 1.0)
    recording = Recording(kind, time, positions, commands, rig, np.array([f"pattern {b + 1}" for b in block]))
    return Left(recording, predicted, block >= 6)


_PARAMETERS = (
    ("section_1.bending_stiffness", 1.31, 0.04, "determined"),
    ("section_2.bending_stiffness", 0.83, 0.05, "determined"),
    ("section_3.bending_stiffness", 2.4, 0.5, "determined"),
    ("muscle.stiffness", NAN, NAN, "only with others"),
    ("damping_time", NAN, NAN, "not seen"),
    ("frame.x", 0.0021, 0.0002, "determined"),
    ("frame.turn_z", 0.035, 0.004, "determined"),
    ("actuation.slack", -0.0012, 0.0004, "determined"),
    ("marker.offset.z", 0.02, 0.0001, "at bound"),
)


def made_fit(kind="static", markers=1, recordings=1, count=240):
    """Return the fit: positive parameters are told by what their start is multiplied by."""
    arm = preset("tendon")
    left = tuple(left_over(count, k, kind, markers) for k in range(recordings))
    left = tuple(replace(one, recording=replace(one.recording, name=f"recording {k + 1}"))
                 for k, one in enumerate(left))  # fmt: skip
    rig = left[0].recording.rig
    known = free_names(arm, rig)
    names = [name for name, *_ in _PARAMETERS if name in known]
    start = dict(zip(names, freedom(arm, rig, names).values().tolist(), strict=True))
    made = []
    for name, value, sd, status in _PARAMETERS:
        if name not in known:
            continue
        factor = start[name] if start[name] and not name.startswith(("frame", "marker", "act")) else 1.0
        value, sd = value * factor, sd * factor
        free = Free(name=name, mean=start[name] or 0.001, sd=0.2 * start[name] or 0.002)
        free = free if name.endswith(("2.bending_stiffness", "frame.x")) else Free(name=name)
        ends = (value - 1.96 * sd, value + 1.96 * sd, value - 2.2 * sd, value + 2.3 * sd)
        made.append(Parameter(free, known[name], start[name], value, sd, *ends, status, "upper bound, 20 mm"
                              if status == "at bound" else ""))  # fmt: skip
    count = len(made)
    correlation = 0.9 ** np.abs(np.subtract.outer(np.arange(count), np.arange(count))) * np.where(
        np.add.outer(np.arange(count), np.arange(count)) % 2, -1, 1
    )
    lost = [k for k, one in enumerate(made) if np.isnan(one.value)]
    correlation[lost] = correlation[:, lost] = NAN
    undetermined = (
        Combination(("damping_time",), (1.0,), float("inf"), "damping_time has no effect on the recording"),
        Combination(("muscle.stiffness", "section_3.bending_stiffness"), (0.97, 0.24), 4.0,
                    "muscle.stiffness and section_3.bending_stiffness may grow together by any factor"),
    )  # fmt: skip
    values = np.concatenate([np.geomspace(900, 8, count - 2), [0.2, 1e-7]])
    return Fit(arm, tuple(one.recording.rig for one in left), tuple(made), undetermined, correlation, values, left,
               0.0012, (210.4, 210.4, 260.1, 811.0), True, 412, 35.2, "least-squares", "converged")  # fmt: skip
