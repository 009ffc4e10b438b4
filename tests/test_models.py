"""Kept models: what is written into a copy is, bit for bit, what compiling gives."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from random_arms import random_arm

from contarm_sim.engine import models
from contarm_sim.engine.plant import Plant
from contarm_sim.envs.definition import unseen_spec
from contarm_sim.mjcf import TIMESTEP, arm_spec
from contarm_sim.model.arm import Arm


def _arrays(model):
    parts = {"": model, "opt.": model.opt, "stat.": model.stat}
    for prefix, part in parts.items():
        for name in dir(part):
            value = getattr(part, name) if not name.startswith("_") else None
            if isinstance(value, (np.ndarray, float, int)) and not callable(value):
                yield prefix + name, np.asarray(value)


@pytest.mark.parametrize(
    ("actuation", "spec"),
    [*((each, arm_spec) for each in ("lengths", "pressures", "tensions", "none")), ("pressures", unseen_spec)],
)
def test_a_written_model_is_the_compiled_one(actuation, spec):
    rng, compared = np.random.default_rng(0), 0
    for _ in range(6):
        arm = random_arm(rng, twist=0.5, spans=0.4)
        other = random_arm(rng, twist=0.0 if arm.torsional_stiffness is None else 1.0)
        if (other.torsional_stiffness is None) != (arm.torsional_stiffness is None):
            continue
        compared += 1
        written = (*models._WRITTEN, "mass", "gravity", "base_orientation")
        changes = {name: getattr(other, name) for name in written}
        arm_with = replace(arm, **changes, payload=other.payload if arm.payload and other.payload else arm.payload)
        models.built(arm, actuation, spec)  # compiled with the one's parameters
        written = models.built(arm_with, actuation, spec).model
        compiled = dict(_arrays(spec(arm_with, actuation, TIMESTEP).compile()))
        names = [name for name, _ in _arrays(written)]
        assert "jnt_stiffness" in names
        assert len(names) > 200
        for name, value in _arrays(written):
            np.testing.assert_array_equal(value, compiled[name], err_msg=name)
    assert compared > 2


def test_a_plant_may_change_its_model():
    one = Plant(Arm())
    one.model.body_mass[:] = 7.0
    one.model.opt.timestep = 1.0
    assert Plant(Arm()).model.body_mass.max() < 1
    assert Plant(Arm()).model.opt.timestep < 0.1


def test_only_the_latest_models_are_kept():
    for links in range(2, 2 + models.KEPT + 4):
        Plant(Arm(links=links), actuation="none")
    assert len(models._kept) == models.KEPT
    model = models.built(Arm(links=2 + models.KEPT), "none").model
    assert isinstance(model, mujoco.MjModel)
