"""Poses of arms that rub: closed forms, energy, what is remembered, and that each arm is as it is alone."""

from dataclasses import replace

import numpy as np
import pytest

from contarm_sim import Arm, InputError, Load, Muscles, Routing, Section, Tendon, Wrench, equilibria, presets, studies
from contarm_sim.identify.excite import excite
from contarm_sim.identify.freedom import freedom
from contarm_sim.identify.prediction.base import AtRest
from contarm_sim.identify.prediction.remembering import WithMemory, remembers
from contarm_sim.identify.recordings.recording import Recording
from contarm_sim.identify.recordings.rig import Actuation, Marker, Rig
from contarm_sim.identify.recordings.synthetic import recorded
from contarm_sim.mechanics import routing
from contarm_sim.model.named import with_parameters
from contarm_sim.statics import walking
from contarm_sim.statics.memory import settle
from contarm_sim.statics.rubbing import PRESLIDING, without_friction
from contarm_sim.statics.walking import Walk

SMALL = replace(presets.tendon(), sections=[replace(one, links=4) for one in presets.tendon().sections])
BACKBONE = {"friction_moment": 0.02, "friction_stiffness": 0.1}
KINDS = {
    "backbone": (BACKBONE, {}), "entry": ({}, {"friction": 0.8}), "along": ({}, {"friction_coefficient": 0.1}),
    "all": (BACKBONE, {"friction": 0.8, "friction_coefficient": 0.1}),
}  # fmt: skip


def _rubbing(kind, arm=SMALL):
    section, law = KINDS[kind]
    return replace(arm, sections=[replace(one, **section) for one in arm.sections],
                   laws=[replace(one, **law) for one in arm.laws])  # fmt: skip


def _circle(count, turns=1.0, size=0.6, arm=SMALL):
    """Return set-points that bend every section around, the sections not in step."""
    t = np.linspace(0, 2 * np.pi * turns, count)
    waves = [size * (1 - np.cos((k + 1) * t)) if k % 2 else size * np.sin((k // 2 + 1) * t) for k in range(6)]
    values = routing.arc_deltas(np.stack(waves, axis=-1), arm)
    return values, [Load(muscles=Muscles(kind="setpoints", values=tuple(row))) for row in values]


@pytest.mark.parametrize("path", ["parallel", "spans"])
def test_without_friction_poses_are_equilibria(path):
    arm = replace(SMALL, routings=[replace(one, path=path) for one in SMALL.routings], payload=0.05)
    _, loads = _circle(5, 0.4, 0.3, arm)
    wrenches = [replace(load, wrenches=(Wrench(xi=0.7, force=(0.1 * k, 0.0, 0.0)),)) for k, load in enumerate(loads)]
    found, alone = settle(arm, wrenches), equilibria(arm, wrenches)
    assert found.qpos[0] == pytest.approx(alone.qpos, abs=1e-8)
    assert found.frames[0] == pytest.approx(alone.frames, abs=1e-8)
    assert found.start_tensions[0] == pytest.approx(alone.muscle_tensions, abs=1e-5)
    assert (found.start_tensions == found.end_tensions).all()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("drive", ["setpoints", "tensions"])
def test_stiffness_is_the_slope_of_the_forces(kind, drive):
    arm, rng, row = _rubbing(kind), np.random.default_rng(3), np.array([0])
    walk = Walk([arm], [without_friction(arm)], drive)
    q = rng.normal(0, 0.05, walk.poses.qpos.shape[1])
    told = np.full((1, 9), 8.0 if drive == "tensions" else -0.001)
    walk.begin(q[None], told, [Load()])
    walk.rubbing.grip[:] = rng.uniform(-0.5, 0.5, (1, 9))

    def forces(angles):
        walk.poses.qpos[0] = angles
        walk.poses.derive(row)
        return walk.rubbing.forces(walk._stiffness)[0].copy()

    q = q + rng.normal(0, 2e-4, len(q))
    h, _ = 1e-7, forces(q)
    K = walk.rubbing.matrix(walk._stiffness)[0].copy()
    slopes = [(forces(q - h * one) - forces(q + h * one)) / (2 * h) for one in np.eye(len(q))]
    assert pytest.approx(np.array(slopes).T, abs=1e-5) == K
    assert np.diagonal(K).min() > 0.1


def test_the_backbone_sticks_and_slides_as_in_closed_form():
    """Under a moment M along all of it, each joint bends by what its two springs and the slider let it."""
    arm = Arm(links=4, bending_stiffness=0.1, friction_moment=0.03, friction_stiffness=0.2)
    h, moments = arm.sections[0].link_pitch, [0.0, 0.02, 0.08, 0.2, 0.1, 0.05, -0.2]
    found = settle(arm, [Load(actuation_moment=(0.0, moment)) for moment in moments])
    bend, held, expected = 0.0, 0.0, []
    for before, moment in zip([0.0, *moments], moments, strict=False):
        change = (moment - before) * h / 0.3  # while it sticks
        held_then = held + 0.2 / h * change
        if abs(held_then) > 0.03:
            held_then = np.copysign(0.03, held_then)
            change = (moment - held_then) * h / 0.1 - bend
        bend, held = bend + change, held_then
        expected.append(bend)
    joints = found.qpos[0].reshape(len(moments), 4, 2)
    of_y = np.abs(joints).max(axis=(0, 1)).argmax()
    angles = found.qpos[0][:, np.abs(found.qpos[0, 3]) > 1e-6]
    assert angles.shape == (len(moments), 4)
    assert of_y in (0, 1)
    assert angles == pytest.approx(np.repeat(np.array(expected)[:, None], 4, axis=1), abs=1e-9)


@pytest.mark.parametrize("kind", [None, *KINDS])
def test_a_closed_way_takes_work_where_something_rubs_and_none_elsewhere(kind):
    """What winches do around a loop of commands that is closed, in the turn after the first."""
    arm = SMALL if kind is None else _rubbing(kind)
    values, loads = _circle(81, 2, 0.4)
    found = settle(arm, loads)
    assert not found.failed
    tension, wound = found.start_tensions[0], -np.diff(values, axis=0)
    work = (0.5 * (tension[1:] + tension[:-1]) * wound).sum(axis=-1)
    scale, lost = np.abs(work[40:]).sum(), work[40:].sum()
    assert found.tip[0, 80] == pytest.approx(found.tip[0, 40], abs=1e-6)  # the loop is closed
    if kind is None:
        assert abs(lost) < 0.02 * scale  # of the trapezoidal rule
        assert found.tip[0, 40] == pytest.approx(found.tip[0, 0], abs=1e-8)
    else:
        assert lost > 0.1 * scale


def test_friction_remembers_and_does_not_creep():
    """Held, the arm stays to the last digit that rest allows; the same command has two poses, up and down."""
    arm = _rubbing("all")
    _, loads = _circle(9, 0.25)
    found = settle(arm, [*loads, *[loads[-1]] * 20, *loads[::-1]])
    assert np.ptp(found.tip[0, 8:29], axis=0).max() < 1e-9
    assert np.linalg.norm(found.tip[0, 4] - found.tip[0, -5]) > 2e-3


def test_dry_friction_lowers_the_tension_by_what_it_holds():
    arm = _rubbing("entry")
    _, loads = _circle(9, 0.25)
    found = settle(arm, loads)
    lost, grip = found.start_tensions - found.end_tensions, found.grip
    pulling = found.end_tensions > 0
    assert lost[pulling] == pytest.approx(0.8 * grip[pulling], abs=1e-12)
    assert {-1.0, 1.0} <= set(grip.ravel().tolist())
    slip = -np.diff(found.muscle_lengths[0], axis=0)
    far = np.abs(slip) > 2 * PRESLIDING
    assert (grip[0, 1:][far] == np.sign(slip[far])).all()


def test_each_arm_is_as_it_is_alone_and_goes_on_as_if_it_had_not_stopped():
    """Arms of one model and of others, one that cannot go on, and a stop half way."""
    turned = replace(SMALL, routings=[replace(one, offset=one.offset + 0.1) for one in SMALL.routings])
    arms = [
        _rubbing("all"),
        _rubbing("along", turned),
        SMALL,
        with_parameters(_rubbing("backbone"), {"bending_stiffness": 0.03}),
    ]
    values, loads = _circle(8, 0.4)
    own = [loads] * 4
    own[1] = [Load(muscles=Muscles(kind="setpoints", values=tuple(1.2 * row))) for row in values]
    found = settle(arms, own)
    assert not found.failed
    first = settle(arms, [each[:5] for each in own])
    second = settle(arms, [each[5:] for each in own], states=first.states, stations=[0, 12])
    for place, (arm, each) in enumerate(zip(arms, own, strict=True)):
        alone = settle(arm, each)
        for name in ("qpos", "frames", "start_tensions", "end_tensions", "grip"):
            assert (getattr(found, name)[place] == getattr(alone, name)[0]).all(), name
    assert np.concatenate([first.qpos, second.qpos], axis=1) == pytest.approx(found.qpos, abs=1e-9)
    assert second.frames == pytest.approx(found.frames[:, 5:, [0, 12]], abs=1e-9)


def test_a_step_too_long_is_halved_and_one_without_rest_said(monkeypatch):
    arm = _rubbing("all")
    _, loads = _circle(3, 0.25)
    whole = settle([arm, SMALL], loads)
    monkeypatch.setattr(walking, "ITERATIONS", 6)
    halved = settle([arm, SMALL], loads)
    assert not halved.failed
    assert np.linalg.norm(halved.tip[0, -1] - whole.tip[0, -1]) < 5e-3  # its way has more corners
    assert halved.tip[1] == pytest.approx(whole.tip[1], abs=1e-8)
    crushed = [*loads, Load(muscles=loads[0].muscles, wrenches=(Wrench(xi=1, force=(0.0, 900.0, -900.0)),))]
    found = settle([arm, SMALL], [crushed, [*loads, loads[-1]]])
    assert found.stopped == {0: 3}
    assert "help" in str(found.failed[0])
    assert np.isnan(found.tip[0, 3]).all()
    assert np.isfinite(found.tip[0, :3]).all()
    assert np.isfinite(found.tip[1]).all()


def test_a_payload_may_come_and_go():
    heavy = replace(SMALL, payload=0.1)
    _, loads = _circle(3, 0.25)
    found = settle([[SMALL, heavy, SMALL]], loads)
    assert found.qpos[0] == pytest.approx(equilibria([SMALL, heavy, SMALL], loads).qpos, abs=1e-8)


@pytest.mark.parametrize(
    ("arms", "loads", "said"),
    [
        (SMALL, [], "loads is none"),
        ([SMALL, SMALL], [[Load()]], "loads is for 1 arms"),
        (SMALL, [Load(), Load(muscles=Muscles(kind="tensions", values=(1.0,) * 9))], "driven alike"),
        ([[SMALL, presets.two()]], [Load(), Load()], "payload and gravity alone"),
    ],
)
def test_bad_arguments_are_said(arms, loads, said):
    with pytest.raises(InputError, match=said):
        settle(arms, loads)


def _recorded(arm, rig, commands, noise=0.0):
    rng, empty = np.random.default_rng(0), np.zeros((len(commands), len(rig.markers), 3))
    blank = Recording("static", np.arange(len(commands)), empty, commands, rig, np.full(len(commands), "one"))
    seen = WithMemory(blank)([arm], [rig])[0]
    return replace(blank, positions=seen + noise * rng.normal(size=seen.shape))


def test_a_fit_finds_what_rubs():
    """Friction of all three kinds is found from tips with noise, and explains what no memoryless arm does."""
    from scipy.optimize import least_squares

    sections = (Section(length=0.2, links=4, mass=0.05, bending_stiffness=0.05, **BACKBONE),)
    true = Arm(
        sections=sections,
        routings=(Routing(),),
        laws=(Tendon(stiffness=1000, friction=1.5, friction_coefficient=0.12),),
    )
    rig = Rig(markers=(Marker(),), actuation=Actuation(channels=(0, 1, 2)))
    t = np.linspace(0, 3 * np.pi, 36)
    waves = np.stack([np.sin(t), np.sin(0.7 * t), np.zeros_like(t)], axis=-1)
    commands = -routing.arc_deltas(0.5 * waves[:, :2], true) + 0.002 * (1 + np.cos(0.3 * t))[:, None]
    recording = _recorded(true, rig, commands, 2e-5)
    names = ["friction_moment", "muscle.friction", "muscle.friction_coefficient"]
    begin = replace(
        true, laws=(Tendon(stiffness=1000, friction=1.1, friction_coefficient=0.09),), friction_moment=0.027
    )
    free, predicts = freedom(begin, rig, names), WithMemory(recording)

    def errors(vectors):
        each = [free.applied(free.of_vector(vector)) for vector in vectors]
        made = predicts([arm for arm, _ in each], [one for _, one in each]) - recording.positions
        return 1e3 * made.reshape(len(vectors), -1)

    def slopes(vector):
        made = errors(np.vstack([vector, vector + 1e-4 * np.eye(3)]))
        return (made[1:] - made[0]).T / 1e-4

    found = least_squares(lambda x: errors(x[None])[0], free.vector(free.values()), slopes, max_nfev=8)
    assert free.of_vector(found.x) == pytest.approx([0.02, 1.5, 0.12], rel=0.1)
    memoryless = AtRest(recording)([true], [rig]) - recording.positions
    assert np.sqrt((found.fun**2).mean()) < 0.05 * 1e3 * np.sqrt((memoryless**2).mean())


def test_arms_that_see_the_same_are_posed_once_and_predicted_each():
    arm, rig = _rubbing("all"), Rig(markers=(Marker(xi=0.6), Marker()), actuation=Actuation(channels=tuple(range(9))))
    values, _ = _circle(6, 0.3)
    recording = _recorded(arm, rig, -values)
    moved = replace(rig, markers=(Marker(xi=0.7), Marker(offset=(0.0, 0.01, 0.0))), position=(0.1, 0.0, 0.0))
    slack = replace(rig, actuation=replace(rig.actuation, slack=(0.001,) * 9))
    arms, rigs = [arm, arm, with_parameters(arm, {"bending_stiffness": 0.06}), arm], [rig, moved, rig, slack]
    together = WithMemory(recording)(arms, rigs)
    for place, (one, own) in enumerate(zip(arms, rigs, strict=True)):
        assert (WithMemory(recording)([one], [own])[0] == together[place]).all()
    assert len(np.unique(together[:, -1, 1, 0])) == 4


def test_memory_is_used_where_something_rubs():
    assert not remembers(SMALL)
    assert all(remembers(_rubbing(kind)) for kind in KINDS)
    assert remembers(_rubbing("along"), ["muscle.friction_coefficient"])
    with pytest.raises(InputError, match=r"friction_coefficient = 0\.05"):
        remembers(SMALL, ["muscle.friction_coefficient"])


def test_motions_refuse_friction_along_tendons_and_single_poses_leave_it_out():
    arm = _rubbing("along")
    with pytest.raises(InputError, match=r"muscle\.friction_coefficient is 0\.1; allowed: omitted"):
        arm.refuse_memory("simulated motions are")
    for study in (studies.validate, studies.trust, studies.compare_controllers):
        with pytest.raises(InputError, match=r"friction_coefficient is 0\.1; allowed: omitted"):
            study(arm)
    assert arm.without_memory == SMALL
    _, loads = _circle(2, 0.2)
    assert (equilibria(arm, loads).qpos == equilibria(SMALL, loads).qpos).all()
    with pytest.raises(InputError, match=r"friction_coefficient = 0\.05"):
        freedom(SMALL, Rig(actuation=Actuation(channels=tuple(range(9)))), ["muscle.friction_coefficient"])


def test_an_arm_that_cannot_be_driven_so_has_no_pose_and_leaves_the_others_alone():
    arm = Arm(links=4, friction_moment=0.02, friction_stiffness=0.1)
    weak = with_parameters(arm, {"muscle.max_pressure": 2e5})
    loads = [Load(muscles=Muscles(kind="pressures", values=(p, 0, 0))) for p in (2e5, 3e5)]
    found = settle([arm, weak], loads)
    assert "pressures" in str(found.failed[1])
    assert (found.qpos[0] == settle(arm, loads).qpos[0]).all()
    rig = Rig(markers=(Marker(),), actuation=Actuation(drive="pressures", channels=(0, 1, 2)))
    recording = _recorded(arm, rig, np.array([load.muscles.values for load in loads]))
    with pytest.raises(InputError, match="pressures"):
        WithMemory(recording)([weak], [rig])
    predictor = WithMemory(recording)
    assert np.isnan(predictor([arm, weak], [rig, rig])[1]).all()
    assert np.isnan(predictor([weak], [rig])).all()
    assert np.abs(predictor([arm], [rig])[0] - recording.positions).max() < 1e-9


def test_what_is_made_and_proposed_of_an_arm_that_rubs_remembers():
    arm, rig = _rubbing("all"), Rig(markers=(Marker(),), actuation=Actuation(channels=tuple(range(9))))
    commands = -_circle(7, 0.3)[0]
    commands = np.concatenate([commands, commands[-2::-1]])
    made = recorded(arm, rig, commands, seed=1, noise=0)
    assert np.linalg.norm(made.positions[0] - made.positions[-1]) > 3e-4
    assert (made.positions == WithMemory(made)([arm], [rig])[0]).all()
    names = np.repeat(["a", "b"], [6, 7])
    given = {"candidates": commands, "blocks": names, "count": 1}
    found, same = (excite(arm, rig, ["friction_moment"], **given, **more) for more in ({}, {"predictor": WithMemory}))
    assert np.isfinite(found.sd_after).all()
    assert (found.sd_after == same.sd_after).all()
    with pytest.raises(InputError, match="kind is a motion"):
        excite(arm, rig, ["mass"], recording=replace(made, kind="motion"))
