"""Another muscle law: a subclass of `PneumaticLaw`, in place of the McKibben law."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from references import resting

from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc
from contarm_sim.mechanics.pressures import holding_pressures
from contarm_sim.mechanics.statics import holding_tensions
from contarm_sim.mjcf import arm_spec
from contarm_sim.model import laws
from contarm_sim.model.arm import Arm
from contarm_sim.model.arm_file import arm_from_dict, arm_to_dict, arm_to_toml, load_arm
from contarm_sim.model.load import Load, Muscles
from contarm_sim.model.parameters import number
from contarm_sim.model.pneumatic_law import PneumaticLaw
from contarm_sim.motion.rest import poses_at_rest
from contarm_sim.statics.equilibrium import equilibrium


@dataclass(frozen=True, kw_only=True)
class Linear(PneumaticLaw):
    """A muscle whose force falls evenly from the blocked force to nothing: F = P area (1 - eps/eps_max)."""

    area: float = number(2e-4, "m^2", "force by pressure at rest length", above=0)
    max_contraction: float = number(0.3, "-", "where the force vanishes", above=0, below=1)
    mount_contraction: float = number(0.1, "-", "in the straight arm", least=0, below=1)
    min_pressure: float = number(5e4, "Pa", "lowest", above=0)
    max_pressure: float = number(6e5, "Pa", "highest", above=0)
    min_tension: float = number(4.0, "N", "of the slackest", above=0)
    passive_stiffness: float | None = number(None, "N/m", "silicone", above=0)
    braid_friction: float | None = number(None, "N", "friction", above=0)
    valve_time: float = number(0.02, "s", "valve", above=0)
    servo_stiffness: float | None = number(None, "N/m", "servo", above=0)
    servo_time: float | None = number(None, "s", "servo", least=0)

    def __post_init__(self):
        self.check()

    @property
    def diameter(self):
        return 0.012

    @property
    def max_stretch(self):
        return 0.2

    @property
    def blocked_force(self):
        return self.max_pressure * self.area

    def force(self, pressure, length, rest_length):
        contraction = 1 - np.asarray(length, dtype=float) / rest_length
        return np.asarray(pressure) * self.area * np.maximum(1 - contraction / self.max_contraction, 0.0)

    def slope(self, pressure, length, rest_length):
        pulls = self.force(1.0, length, rest_length) > 0
        return np.where(pulls, np.asarray(pressure) * self.area / (self.max_contraction * rest_length), 0.0)


ARM = Arm(links=12, muscle=Linear(), gravity=(0.0, 1.0, 9.0))
BEND = arc.from_polar(np.array([0.4, 0.9]), np.array([0.3, 2.5]))


def test_its_least_tension_holds_the_slackest_muscle():
    assert holding_tensions(BEND, ARM).min() == pytest.approx(4.0)
    pressures = holding_pressures(BEND, ARM)
    assert pressures.min() >= 5e4 * (1 - 1e-12)


@pytest.mark.parametrize("wrong", [{"min_pressure": 7e5}, {"mount_contraction": 0.5}, {"min_tension": 200.0}])
def test_fields_that_do_not_fit_together_are_refused(wrong):
    with pytest.raises(InputError, match=f"muscle.{next(iter(wrong))}"):
        Linear(**wrong)


def test_servos_and_tensions_drive_it():
    found = poses_at_rest(ARM, resting(ARM, BEND))
    assert found.muscle_tensions.min() == pytest.approx(4.0, abs=1e-6)
    per_pascal = ARM.pneumatics.force(1.0, found.muscle_lengths, ARM.muscle_rest_length)
    np.testing.assert_allclose(found.pressure, found.muscle_tensions / per_pascal)
    tensions = tuple(found.muscle_tensions[1].tolist())
    pulled = equilibrium(ARM, Load(muscles=Muscles(kind="tensions", values=tensions)))
    np.testing.assert_allclose(pulled.tip, found.tip[1], atol=1e-8)


def test_pressures_take_actuators_of_its_own():
    with pytest.raises(InputError, match="'pressures' with the law Linear"):
        arm_spec(ARM, "pressures")


def test_files_choose_it_by_name(monkeypatch, tmp_path):
    monkeypatch.setitem(laws.LAWS, "linear", Linear)
    arm = arm_from_dict({"muscle": {"law": "linear", "area": 3e-4, "path": "spans"}})
    assert arm == Arm(muscle=Linear(area=3e-4), path="spans")
    assert arm_from_dict(arm_to_dict(arm)) == arm
    (tmp_path / "arm.toml").write_text(arm_to_toml(replace(arm, gravity=(0.0, 0.0, 9.81))))
    assert load_arm(tmp_path / "arm.toml") == replace(arm, gravity=(0.0, 0.0, 9.81))
    (tmp_path / "arm.toml").write_text('[muscle]\nlaw = "linear"\nmin_pressure = "60 kPa"\n')
    assert load_arm(tmp_path / "arm.toml") == Arm(muscle=Linear(min_pressure=6e4))
    with pytest.raises(InputError, match=r"muscle\.law is cubic; allowed: mckibben.*linear"):
        arm_from_dict({"muscle": {"law": "cubic"}})
    with pytest.raises(InputError, match=r"muscle\.wall"):
        arm_from_dict({"muscle": {"law": "linear", "wall": 1e-3}})
