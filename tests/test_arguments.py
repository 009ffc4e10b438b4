"""Arguments of functions that cannot be, and poses that no arm can take, are refused in one line."""

import numpy as np
import pytest

from contarm_sim import studies
from contarm_sim.errors import InputError, NoEquilibriumError
from contarm_sim.model.arm import Arm
from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.model.mckibben import McKibben
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.paths.reference import Reference
from contarm_sim.statics.equilibrium import equilibrium
from contarm_sim.statics.extrapolation import extrapolated

ARM = Arm(links=8)
BEND = [1.0, 0.0]
GUESS = ["x"] * 16

REFUSED = {
    "levels is 0; .* at least 2": lambda: studies.stiffness(ARM, BEND, levels=0),
    "levels is -1": lambda: studies.stiffness(ARM, BEND, levels=-1),
    "levels is 2.5": lambda: studies.stiffness(ARM, BEND, levels=2.5),
    "bend is of shape .* one bend": lambda: studies.stiffness(ARM, [BEND, BEND]),
    "planes is 0": lambda: studies.possibility(ARM, planes=0),
    "planes is -1": lambda: studies.possibility(ARM, planes=-1),
    "points is 0": lambda: studies.muscle_law(ARM, points=0),
    "pressures is 100000.0; allowed: a sequence": lambda: studies.muscle_law(ARM, pressures=1e5),
    "pressure is -1.0": lambda: studies.muscle_law(ARM, pressures=np.array([1e5, -1.0])),
    "grid is 0": lambda: studies.validate(ARM, grid=0),
    "grid is -1": lambda: studies.validate(ARM, grid=-1),
    "duration is 0.02": lambda: studies.compare_controllers(ARM, duration=0.02),
    "duration is long": lambda: studies.compare_controllers(ARM, duration="long"),
    "bend is of shape .2, 2.; allowed: one bend": lambda: studies.hold(ARM, [BEND, BEND]),
    "share is half": lambda: studies.hold(ARM, BEND, share="half"),
    "run is an int; allowed: a Trajectory": lambda: studies.judge_run(3),
    "case is an int; allowed: a LoadCase": lambda: studies.cases_at_rest([3]),
    "xi is 0.5; allowed: numbers": lambda: studies.cases_at_rest([], xi=0.5),
    "load is an int; allowed: a Load": lambda: equilibrium(ARM, 0),
    "load is a list; allowed: a Load": lambda: equilibrium(ARM, []),
    "load is a Wrench; allowed: a Load": lambda: equilibrium(ARM, Wrench(xi=1.0)),
    "guess is .* numbers": lambda: equilibrium(ARM, guess=GUESS),
    "guess is .* finite": lambda: equilibrium(ARM, guess=[np.nan] * 16),
    "guess is of shape": lambda: equilibrium(ARM, guess=[0.0] * 15),
    "muscle is .*a MuscleLaw, such as McKibben": lambda: Arm(muscle=McKibben),
}


@pytest.mark.parametrize("message", REFUSED)
@pytest.mark.filterwarnings("error")
def test_what_cannot_be_is_refused_in_one_line(message):
    with pytest.raises(InputError, match=message) as refused:
        REFUSED[message]()
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "study",
    [
        equilibrium, extrapolated, studies.possibility, studies.release, studies.validate, studies.compare_controllers,
        studies.muscle_law, lambda arm: studies.hold(arm, BEND), lambda arm: studies.stiffness(arm, BEND),
        lambda arm: studies.cases_at_rest([studies.LoadCase(arm, Load())]),
    ],
)  # fmt: skip
def test_what_is_no_arm_is_refused(study):
    with pytest.raises(InputError, match="arm is an int; allowed: an Arm"):
        study(3)


@pytest.mark.parametrize("poses", [0, -1])
def test_a_run_is_judged_at_one_pose_or_more(poses):
    run = poses_at_rest(ARM, Reference.from_bends([BEND], ARM))
    with pytest.raises(InputError, match=f"poses is {poses}; allowed: a whole number, at least 1"):
        studies.judge_run(run, poses=poses)


def test_pressures_may_be_an_array():
    pressures = np.array([1e5, 2e5])
    np.testing.assert_array_equal(studies.muscle_law(ARM, pressures).pressure_pa, pressures)


def test_a_folded_arm_is_no_equilibrium():
    with pytest.raises(NoEquilibriumError, match=r"joint 1 would bend by 2650 deg, the most is 90 deg") as error:
        equilibrium(ARM, Load(actuation_moment=(100.0, 0.0)))
    assert error.value.value == pytest.approx(np.radians(2650), rel=1e-3)
    assert error.value.pose.shape == (16,)
    half_turn = equilibrium(Arm(links=2), Load(muscles=Muscles(kind="bend", values=(3.1, 0.0))))
    assert half_turn.stable


def test_a_muscle_keeps_a_length():
    thick = Arm(links=24, length=0.37, muscle_radius=0.1)
    with pytest.raises(NoEquilibriumError, match="a muscle would have a length of -"):
        equilibrium(thick, Load(actuation_moment=(0.0, 1.2)))
    assert equilibrium(thick, Load(actuation_moment=(0.0, 0.5))).muscle_lengths.min() > 0


def test_an_equilibrium_is_equal_to_itself_alone():
    one, two = equilibrium(ARM), equilibrium(ARM)
    assert one != two
    assert [one, two].index(two) == 1
    assert len({one, two, one}) == 2
