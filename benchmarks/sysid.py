"""A fit beside `mujoco.sysid`, the engine's own identification: the same synthetic recordings and free parameters.

motion   the tip of an arm whose muscles pull with known tensions, 6 s at 100 Hz: `mujoco.sysid` with its rollouts of
         the arm's MJCF, its optimiser and its intervals, from the same start and at the same time step as `fit` (1 ms;
         at 2 ms both are off by more than their intervals).
rest     poses of a two-section tendon arm. `mujoco.sysid` has no statics: its optimiser gets residuals of our
         equilibria; what rollouts until the arm rests would cost is measured for a few poses.

Residuals are those of positions, with losses of squares. An interval that does not hold the true value has a `!`.
Times are of this process's processors, all in one run. Needs `pip install 'mujoco[sysid]'`.
"""

import contextlib
import os
import time

import mujoco
import numpy as np

from contarm_sim.identify.fit import fit
from contarm_sim.identify.freedom import Free
from contarm_sim.identify.moving import InMotion
from contarm_sim.identify.predict import AtRest
from contarm_sim.identify.recording import Recording
from contarm_sim.identify.rig import Actuation, Rig
from contarm_sim.identify.synthetic import random_windings, recorded
from contarm_sim.mjcf.build import arm_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.named import with_parameters
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import Section
from contarm_sim.model.tendon import Tendon

try:
    from mujoco.sysid import (
        ModelSequences,
        Parameter,
        ParameterDict,
        TimeSeries,
        build_residual_fn,
        calculate_intervals,
        create_initial_state,
        optimize,
    )
except ImportError:
    raise SystemExit("mujoco.sysid is not installed; get it with: pip install 'mujoco[sysid]'") from None

NOISE, SEED, RATE, DURATION, STEP = 0.0005, 4, 100, 6.0, 0.001
ARM = Arm(links=12, length=0.3, mass=0.1, gravity=(0.0, 0.0, 9.81), laws=(Tendon(stiffness=2000.0, pretension=1e-3),))
IN_MOTION = ({"bending_stiffness": 0.06, "damping_time": 0.04, "mass": 0.1},
             {"bending_stiffness": 0.04, "damping_time": 0.07, "mass": 0.07})  # fmt: skip
AT_REST = ({"section_1.bending_stiffness": 0.034, "section_2.bending_stiffness": 0.013, "muscle_radius": 0.0106},
           {"section_1.bending_stiffness": 0.02, "section_2.bending_stiffness": 0.02,
            "muscle_radius": 0.01})  # fmt: skip


def tensions(times):
    """Return tensions of three muscles [N], shape (T, 3), that begin at 0."""
    phases = 2 * np.pi * np.arange(3) / 3
    rising = np.minimum(times / 0.5, 1.0)[:, None]
    return 2.0 * rising * (1 + np.sin(2 * np.pi * (0.7 + 0.15 * times[:, None]) * times[:, None] + phases))


def moving():
    """Return an arm to start from and a recording of the true one, stepped five times finer than fits step it."""
    true, start = IN_MOTION
    arm, step = with_parameters(ARM, true), 0.0002
    model = arm_spec(arm, "tensions", step).compile()
    data, times = mujoco.MjData(model), np.arange(0, DURATION + step / 2, step)
    pulls, tips = tensions(times), []
    for each in pulls:
        data.ctrl = each
        mujoco.mj_forward(model, data)
        tips.append(data.sensor("tip_position").data.copy())
        mujoco.mj_step(model, data)
    every = round(1 / RATE / step)
    seen = np.array(tips)[::every] + np.random.default_rng(SEED).normal(0, NOISE, (len(times[::every]), 3))
    rig = Rig(actuation=Actuation(drive="tensions", channels=(0, 1, 2)))
    recording = Recording("motion", times[::every], seen[:, None], pulls[::every], rig, np.full(len(seen), "all"))
    return with_parameters(ARM, start), recording


def resting(count=200):
    """Return a two-section arm to start from and a recording of the true one at rest."""
    section = Section(length=0.1, links=12, mass=0.03, bending_stiffness=0.02)
    law = Tendon(stiffness=2000.0, pretension=1e-3, max_tension=1e6)
    routings = tuple(Routing(radius=0.01, start="base", offset=0.4 * k) for k in range(2))
    arm = Arm(sections=(section,) * 2, routings=routings, laws=(law,) * 2)
    true, start = AT_REST
    rig = Rig(actuation=Actuation(channels=tuple(range(6))))
    commands, blocks = random_windings(arm, count, SEED, samples=10)
    made = recorded(with_parameters(arm, true), rig, commands, seed=SEED, noise=NOISE, blocks=blocks)
    return with_parameters(arm, start), made


def motion_residuals(arm, recording, step):
    """Return the residual function of `mujoco.sysid` for a motion, as its examples make it."""

    def built(parameters, spec=None):
        values = {name: float(one.value[0]) for name, one in parameters.items()}
        return arm_spec(with_parameters(arm, values), "tensions", step).compile()

    spec = arm_spec(arm, "tensions", step)
    model = spec.compile()
    sequence = ModelSequences(
        "arm", spec, "motion", create_initial_state(model, np.zeros(model.nq)),
        TimeSeries.from_control_names(recording.time, recording.commands, model),
        TimeSeries.from_names(recording.time, recording.positions[:, 0], model, ["tip_position"]),
        allow_missing_sensors=True,
    )  # fmt: skip
    return build_residual_fn(models_sequences=[sequence], build_model=built)


def rest_residuals(arm, recording):
    """Return residuals for `mujoco.sysid` by our equilibria."""
    predictor = AtRest(recording, threads=1)

    def rows(x, parameters):
        names, columns = list(parameters.keys()), x.reshape(len(x), -1).T
        arms = [with_parameters(arm, dict(zip(names, own.tolist(), strict=True))) for own in columns]
        off = recording.positions - predictor(arms, [recording.rig] * len(arms))
        off = off.reshape(len(arms), -1).T
        return [off[:, 0] if x.ndim == 1 else off], None, None

    return rows


def by_sysid(residuals, truth, start, optimizer):
    """Return values, half widths of 95 % intervals, predictions and processor time [s] of `mujoco.sysid`."""
    given, count = ParameterDict(), [0]
    for name, value in start.items():
        given.add(Parameter(name, value, value / 10, value * 10))

    def rows(x, parameters):
        count[0] += 1 if x.ndim == 1 else x.shape[1]
        return residuals(x, parameters)

    began = time.process_time()
    options = {"verbose": False} if optimizer == "mujoco" else {"x_scale": "jac"}
    with open(os.devnull, "w") as nowhere, contextlib.redirect_stdout(nowhere):
        best, found = optimize(given, rows, optimizer=optimizer, **options)
    values = best.as_vector()
    half = calculate_intervals(residuals(values, best)[0], np.asarray(found.jac))[1]
    return values, values - half, values + half, count[0], time.process_time() - began


def by_fit(arm, predictor, start):
    """Return the same of `fit`."""
    began = time.process_time()
    free = [Free(name=name, low=value / 10, high=value * 10) for name, value in start.items()]
    found = fit(arm, predictor.recording, free, loss="linear", threads=1, predictors=[predictor])
    told = [[getattr(one, name) for one in found.parameters] for name in ("value", "low", "high")]
    return *map(np.array, told), found.evaluations, time.process_time() - began


def compared(title, arm, predictor, residuals, truth, start):
    print(f"{title}: {len(predictor.recording)} samples, {len(start)} parameters")
    ways = {"fit": lambda: by_fit(arm, predictor, start)}
    for optimizer in ("mujoco", "scipy"):
        ways[f"mujoco.sysid ({optimizer})"] = lambda own=optimizer: by_sysid(residuals, truth, start, own)
    ours = None
    for way, call in ways.items():
        try:
            values, lows, highs, count, seconds = call()
        except (ValueError, np.linalg.LinAlgError) as error:
            print(f"  {way:24} failed: {error}")
            continue
        ours = ours or seconds
        print(f"  {way:24}{count:>6} predictions{seconds:>8.2f} s, {seconds / ours:.2f} of fit's")
        for name, value, low, high in zip(start, values, lows, highs, strict=True):
            wrong = "" if low <= truth[name] <= high else " !"
            print(f"    {name:30}{truth[name]:>9.4g}: {value:9.4g}  [{low:.4g}, {high:.4g}]{wrong}")


def settling(arm, recording, poses=5):
    """Return processor times of a pose [s] by stepping until rest and by equilibria, and how far apart tips are [m]."""
    model = arm_spec(arm).compile()
    data, solved, off = mujoco.MjData(model), AtRest(recording, threads=1)([arm], [recording.rig])[0], []
    controls, began = recording.rig.actuation.values(recording.commands[:poses]), time.process_time()
    for told, tip in zip(controls, solved[:, 0], strict=False):
        mujoco.mj_resetData(model, data)
        data.ctrl = told
        while data.time < 60 and (data.time < 0.2 or np.abs(data.qvel).max() > 1e-4):
            mujoco.mj_step(model, data)
        off.append(np.linalg.norm(data.sensor("tip_position").data - tip))
    stepped = (time.process_time() - began) / poses
    began = time.process_time()
    AtRest(recording, threads=1)([arm], [recording.rig])
    return stepped, (time.process_time() - began) / len(recording), max(off)


def main():
    arm, recording = moving()
    residuals = motion_residuals(arm, recording, STEP)
    compared("motion", arm, InMotion(recording, 1, STEP), residuals, *IN_MOTION)
    arm, recording = resting()
    compared("rest", arm, AtRest(recording, 1), rest_residuals(arm, recording), *AT_REST)
    stepped, solved, off = settling(arm, recording)
    print(
        f"  a pose: {1e3 * stepped:.0f} ms by stepping, {1e3 * solved:.2f} ms by equilibria; {1e3 * off:.2g} mm apart"
    )


if __name__ == "__main__":
    main()
