"""The arm as a part of another model: two arms on a turning column."""

import mujoco

from contarm_sim import Arm, spec

host = mujoco.MjSpec()
host.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # the arm's length servos need it
host.option.timestep = 0.005
column = host.worldbody.add_body(pos=[0, 0, 1])
column.add_joint(name="turn", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 0, 1], damping=[0.5, 0, 0])
column.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.03, 0.1, 0])
for prefix, y in (("left/", 0.1), ("right/", -0.1)):
    host.attach(spec(Arm(links=12)), site=column.add_site(pos=[0, y, 0.1]), prefix=prefix)

model = host.compile()
data = mujoco.MjData(model)
data.actuator("left/muscle_1").ctrl = -0.01  # shorten by 10 mm: this arm bends towards +X
mujoco.mj_step(model, data, nstep=400)
mujoco.mj_kinematics(model, data)
for name in ("left/tip", "right/tip"):
    print(name, data.site(name).xpos.round(3), "m")
