"""An arm on a base that rides on a cart: what is known of contact there, and whose time step it takes."""

import numpy as np
import pytest

from contarm_sim import Arm, Load, Muscles, equilibrium, simulate, studies
from contarm_sim.cli.leaning import leaning
from contarm_sim.engine.plant import Plant
from contarm_sim.model.host import Host
from contarm_sim.motion.time_step import Stepping
from contarm_sim.paths.reference import Reference
from contarm_sim.results.document import document
from contarm_sim.view.live.session import Session
from contarm_sim.view.report.words import remarks

CELL = """<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <body name="cart" pos="0 0 0.8">
      <joint type="slide" axis="0 1 0" damping="1"/>
      <geom type="box" size=".05 .05 .01" pos="0 0 0.05" mass="20" conaffinity="0"/>
      <site name="mount" euler="180 0 0"/>
    </body>
    <body name="ball" pos="0.12 0 0.5" gravcomp="1"><freejoint/><geom size=".03" mass="5" friction="1.3"/></body>
  </worldbody>
</mujoco>"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    file = tmp_path_factory.mktemp("riding") / "cell.xml"
    file.write_text(CELL)
    return Arm(links=8, host=Host(file=str(file), site="mount"))


def _judged(arm, most):
    time = np.arange(0, 0.8, 0.01)
    bend = np.stack([most * np.sin(np.pi * np.minimum(time, 0.6)), 0 * time], axis=1)
    run = simulate(arm, Reference.from_bends(bend, arm, time=time), stepping=Stepping(0.002), check_step=False)
    return run, studies.judge_run(run, poses=4)


def test_contact_on_a_base_that_moves_is_not_called_motion(arm):
    run, judged = _judged(arm, 1.2)
    assert run.base is not None
    assert len(run.contacts)
    assert (judged.motion, judged.errors.contact_error, judged.constant_curvature.motion_percent) == (None, None, None)
    assert any("contact and of motion unavailable" in remark for remark in remarks(document(judged)))
    assert not [check for check in judged.judged.checks if check.name == "motion share"]


def test_where_nothing_is_touched_contact_is_exactly_zero_on_a_base_that_moves_too(arm):
    run, judged = _judged(arm, -0.6)
    assert not run.contacts
    assert judged.errors.contact_error.max_m == 0
    assert judged.motion is not None
    assert "the base may move" in next(each.reason for each in judged.judged.checks if "ideal rod" in each.name)


def test_steps_are_at_most_the_hosts(arm):
    assert Plant(arm, in_world=True).model.opt.timestep == 0.002
    assert Session(arm).plant.model.opt.timestep == 0.002


def test_parameters_are_not_written_into_models_with_more_than_the_arm(arm):
    with pytest.raises(ValueError, match="alone"):
        Plant(arm, in_world=True).become(arm)


def test_a_body_that_can_move_is_leant_on_as_if_it_were_held_and_that_is_said(arm):
    found = equilibrium(arm, Load(muscles=Muscles(kind="bend", values=(1.2, 0.0))))
    assert {touch.object for touch in found.contacts} == {"ball"}
    assert {touch.friction for touch in found.contacts} == {1.3}  # MuJoCo takes the larger of ball and link
    said = "\n".join(leaning(found, arm))
    assert "their friction coefficient of 1.3 the tip" in said
    assert "ball, which can move, is held" in said
