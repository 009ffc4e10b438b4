"""Names in a user's own MJCF: given where there are none, refused where the arm has them; and included files."""

import os
import re

import pytest

from contarm_sim import Arm, arm_spec
from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.model.host import Host
from contarm_sim.model.objects import Object

WEDGE = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"


def test_a_host_is_read_anew_where_a_file_that_it_includes_has_changed(tmp_path):
    file = tmp_path / "cell.xml"
    file.write_text('<mujoco><include file="parts/all.xml"/></mujoco>')
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "all.xml").write_text('<mujoco><include file="part.xml"/></mujoco>')
    part, host, found = tmp_path / "parts" / "part.xml", None, []
    for name in ("post", "wall"):
        body = f'<body name="{name}" pos="0 0 3"><geom size=".1"/></body>'
        part.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
        os.utime(part, (len(found), len(found)))
        host = host or Host(file=str(file))
        found.append(host.partners)
        assert arm_spec(Arm(links=2, host=host)).compile()
    assert found == [("post",), ("wall",)]


TAKEN = {
    "a mesh": ('<asset><mesh name="it" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>', "mesh of that name"),
    "a joint": ('<worldbody><body><joint name="it"/><geom size=".1"/></body></worldbody>', "joint of that name"),
    "a sensor": ('<sensor><clock name="base_position"/></sensor>', "sensor base_position"),
    "a joint's sensor": (
        '<worldbody><body><joint name="j"/><geom size=".1"/></body></worldbody><sensor><clock name="world_j_angle"/>'
        "</sensor>", "sensor world_j_angle",
    ),
    "an exclude": (
        '<worldbody><body name="a"/><body name="b"/></worldbody>'
        '<contact><exclude name="base_mount" body1="a" body2="b"/></contact>', "exclude base_mount",
    ),
    "itself": ('<worldbody><body name="itself"><geom size=".1"/></body></worldbody>', "'itself'"),
    "no contact": ('<option><flag contact="disable"/></option>', "flag contact"),
}  # fmt: skip


@pytest.mark.parametrize("what", TAKEN)
def test_a_name_that_is_taken_is_refused_whatever_has_it(what, tmp_path):
    (tmp_path / "it.obj").write_text(WEDGE)
    (tmp_path / "cell.xml").write_text(f"<mujoco>{TAKEN[what][0]}</mujoco>")
    mesh = Object(name="it", shape="mesh", file=str(tmp_path / "it.obj"), mass=0.1, position=(1, 0, 0))
    with pytest.raises(InputError, match=re.escape(TAKEN[what][1])) as caught:
        arm_spec(Arm(links=3, host=Host(file=str(tmp_path / "cell.xml")), objects=(mesh,)))
    assert "\n" not in str(caught.value)


def test_bodies_and_joints_without_names_get_unused_ones(tmp_path):
    sphere = '<geom size=".1"/>'
    parts = f'<body pos="1 0 1"><joint/>{sphere}</body>'
    parts += f'<body name="body_1" pos="2 0 1"><joint name="joint_0"/>{sphere}</body>'
    (tmp_path / "cell.xml").write_text(f"<mujoco><worldbody>{parts}</worldbody></mujoco>")
    host = Host(file=str(tmp_path / "cell.xml"))
    assert len(set(host.partners)) == 2
    plant = Plant(Arm(links=3, host=host), in_world=True)
    assert len(plant.index.host) == 2
