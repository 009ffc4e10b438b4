"""The arm as a `composer.Entity`, and an arena that looks like the project's own pictures."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from contarm_sim.envs import dm_gl
from contarm_sim.envs.actions import Actions, Mode
from contarm_sim.envs.definition import plain_spec
from contarm_sim.envs.dm_touch import TouchSensors
from contarm_sim.envs.state import State, end_sensors, read
from contarm_sim.mjcf import TIMESTEP, exact_xml, names
from contarm_sim.mjcf.muscles import straight_controls
from contarm_sim.mjcf.objects import add_objects, place_objects
from contarm_sim.mjcf.scene import add_scene, base_quaternion, base_rotation, lighten
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering.draw import ASKED

dm_gl.load()
from dm_control import composer, mjcf  # noqa: E402
from dm_control.composer import define  # noqa: E402
from dm_control.composer.observation import observable  # noqa: E402
from dm_control.rl.control import PhysicsError  # noqa: E402, F401

_OPTIONS = ("gravity", "timestep")


class ContinuumArm(composer.Robot):
    """The arm, to be attached to any arena or robot; a gripper or camera attaches to its tip.

    Its base frame is the frame it is attached with. Gravity and time step are the arena's: 5 ms, or what `arm_spec` has
    for arms that need less. The integrator, `implicitfast`, it brings along, unless the arena has another. The objects
    of its world are the arena's to bring, as `ArmArena` does; an arm that has some brings along how contact is solved.

    Args:
        arm: its parameters; default the paper's arm.
        actions: what `apply_action` takes, in [-1, 1]: bend, lengths, tensions or pressures, or `Actions` of the arm.
        name: of the model.
        timestep: the arena's, which counts for arms that touch something [s].

    Attributes:
        touch: sensors of what it touches and of free objects, of the arena that it is in, or None.

    Raises:
        InputError: an unknown action mode, or an action of another shape or not finite.
    """

    def _build(
        self, arm: Arm | None = None, actions: Mode | Actions = "bend", name: str = "contarm",
        timestep: float = TIMESTEP,
    ) -> None:  # fmt: skip
        self._actions = actions if isinstance(actions, Actions) else Actions(arm or Arm(), actions)
        self._timestep = timestep
        self.touch: TouchSensors | None = None
        self._mjcf = self._model(self._actions.arm)
        self._mjcf.model = name

    def _model(self, arm: Arm) -> Any:
        spec = plain_spec(arm, self._actions.actuation, self._timestep)
        lighten(spec)
        model = mjcf.from_xml_string(exact_xml(spec))
        for part in (model.keyframe, model.statistic, model.size):
            part.remove()
        for option in _OPTIONS:
            delattr(model.option, option)
        del model.compiler.autolimits
        objects = {each.name for each in arm.world.objects}
        for sensor in list(model.sensor.all_children()):
            if any(getattr(getattr(sensor, name, None), "name", None) in objects for name in ("body2", "objname")):
                sensor.remove()
        for each in arm.world.objects:
            model.find("body", each.name).remove()
            if each.file is not None:
                model.find("mesh", each.name).remove()
        return model

    def _build_observables(self) -> ArmObservables:
        return ArmObservables(self)

    @property
    def mjcf_model(self) -> Any:
        """The arm as a PyMJCF tree."""
        return self._mjcf

    @property
    def actuators(self) -> list[Any]:
        """One a muscle, or two where pressures drive the arm."""
        return self._mjcf.find_all("actuator")

    @property
    def joints(self) -> list[Any]:
        """All hinges, base first."""
        return self._mjcf.find_all("joint")

    @property
    def tendons(self) -> list[Any]:
        """The muscles, section by section."""
        return [self._mjcf.find("tendon", muscle) for muscle in names.muscles(self._actions.arm)]

    @property
    def tip(self) -> Any:
        """The half link that ends in the tip plate; its centre of mass is a quarter of a pitch below the tip."""
        return self._mjcf.find("body", names.TIP)

    @property
    def payload(self) -> Any:
        """The body of the payload, there without one too: `xfrc_applied` on it acts at the tip."""
        return self._mjcf.find("body", names.PAYLOAD)

    @property
    def attachment_site(self) -> Any:
        """The tip plate's centre."""
        return self._mjcf.find("site", names.TIP)

    def vary(self, arm: Arm) -> None:
        """Give the model the numbers of another arm; a compilation must follow. Actions keep their meaning."""
        made = self._model(arm)
        for section in ("default", "worldbody", "tendon", "actuator"):  # options are the arena's
            _copy_numbers(getattr(made, section), getattr(self._mjcf, section))

    def straighten(self, physics: Any) -> None:
        """Put the arm straight and at rest, its muscles at their least tension."""
        each = straight_controls(self._actions.arm, self._actions.actuation)
        control = each * (len(self.actuators) // len(each))
        physics.bind(self.joints).qpos = 0.0
        physics.bind(self.joints).qvel = 0.0
        self._command(physics, control)
        if self._actions.mode == "pressures":
            physics.bind(self.actuators).act = control

    def apply_action(self, physics: Any, action: Any, random_state: Any) -> None:
        """Apply an action in [-1, 1]."""
        self._command(physics, self._actions.controls(self._actions.check(action))[0])

    def _command(self, physics: Any, control: Any) -> None:
        """Set controls in place: a write through the binding makes the next read forward the whole model."""
        physics.data.ctrl[physics.bind(self.actuators).element_id] = control

    def state(self, physics: Any) -> State:
        """Return what is seen of the arm, with an axis of one arm, see `state`."""
        if physics.data.time == 0:  # a reset leaves actuation off
            derive = mujoco.mj_fwdActuation if self.touch is None else mujoco.mj_forward
            derive(physics.model.ptr, physics.data.ptr)
        tendons, actuators = physics.bind(self.tendons), physics.bind(self.actuators)
        seen = (names.TIP_POSITION, names.TIP_ORIENTATION, *end_sensors(self._actions.arm))
        pose = [self._mjcf.find("sensor", name) for name in seen]
        state = read(
            {
                "ten_length": np.array(tendons.length)[None],
                "ten_velocity": np.array(tendons.velocity)[None],
                "actuator_force": np.array(actuators.force)[None],
                "act": np.array(actuators.act if self._actions.mode == "pressures" else [])[None],
                "qpos": np.array(physics.bind(self.joints).qpos)[None],
                "sensordata": np.concatenate([physics.bind(one).sensordata for one in pose])[None],
            },
            self._actions.arm,
        )
        if self.touch is None:
            return state
        base = physics.bind(self._mjcf.find("site", names.BASE))
        return state | self.touch.read(physics, np.array(base.xmat).reshape(3, 3), self._actions.arm)


class ArmObservables(composer.Observables):
    """What is seen of the arm, SI units, see `state`; disabled until asked for, as composer's are."""

    def _of(self, name: str) -> Any:
        return observable.Generic(lambda physics: self._entity.state(physics).get(name, np.empty((1, 0)))[0])

    @define.observable
    def muscle_lengths(self) -> Any:
        """Lengths of the n muscles [m], shape (n,)."""
        return self._of("muscle_lengths")

    @define.observable
    def muscle_velocities(self) -> Any:
        """How fast they lengthen [m/s], shape (n,)."""
        return self._of("muscle_velocities")

    @define.observable
    def actuator_tensions(self) -> Any:
        """What the actuators pull with [N], shape (n,)."""
        return self._of("actuator_tensions")

    @define.observable
    def pressures(self) -> Any:
        """Pressures behind the valves [Pa], shape (n,); empty unless they drive the arm."""
        return self._of("pressures")

    @define.observable
    def joint_angles(self) -> Any:
        """The shape: angles of all hinges [rad], shape (dofs,)."""
        return self._of("joint_angles")

    @define.observable
    def tip_position(self) -> Any:
        """Tip in the base frame [m], shape (3,)."""
        return self._of("tip_position")

    @define.observable
    def tip_orientation(self) -> Any:
        """Quaternion w x y z of the tip in the base frame, shape (4,)."""
        return self._of("tip_orientation")

    @define.observable
    def section_ends(self) -> Any:
        """Ends of all S sections but the last in the base frame [m], shape (3 S - 3,)."""
        return self._of("section_ends")

    @define.observable
    def object_positions(self) -> Any:
        """Free objects in the base frame [m], shape (3 F,); these and what follows of an arena that has some."""
        return self._of("object_positions")

    @define.observable
    def object_orientations(self) -> Any:
        """Quaternions w x y z of free objects in the base frame, shape (4 F,)."""
        return self._of("object_orientations")

    @define.observable
    def object_velocities(self) -> Any:
        """Velocities of free objects in the base frame [m/s], shape (3 F,)."""
        return self._of("object_velocities")

    @define.observable
    def object_rates(self) -> Any:
        """Rates of free objects in the base frame [rad/s], shape (3 F,)."""
        return self._of("object_rates")

    @define.observable
    def touching(self) -> Any:
        """How many links of each section touch each partner, shape (P S,)."""
        return self._of("touching")

    @define.observable
    def touch_forces(self) -> Any:
        """What each section feels of each partner [N], shape (3 P S,)."""
        return self._of("touch_forces")


class ArmArena(composer.Arena):
    """Floor, mount, light and cameras around one arm, to be looked at: nothing touches them; and the arm's objects."""

    def _build(self, arm: Arm) -> None:
        self._arm, self._turn, self._rotation = arm, base_quaternion(arm), base_rotation(arm)
        self._mjcf_root = self._model(arm)

    def _model(self, arm: Arm) -> Any:
        spec = mujoco.MjSpec()
        spec.modelname, spec.compiler.degree = "arena", False
        self._place = add_scene(spec, arm)
        spec.geom("floor").contype = spec.geom("floor").conaffinity = 0  # the other front ends have none
        add_objects(spec, arm)
        place_objects(spec, arm, self._place, self._turn)
        return mjcf.from_xml_string(exact_xml(spec))

    def place(self, arm: ContinuumArm) -> None:
        """Attach an arm to the mount, and let it feel the objects."""
        frame = self.attach(arm)
        frame.pos, frame.quat = self._place, self._turn
        if self._arm.world.touchable:
            arm.touch = TouchSensors.added(self._mjcf_root, arm.mjcf_model, self._arm)

    def vary(self, arm: Arm) -> None:
        """Give the objects the numbers of another arm's; a compilation must follow."""
        if not arm.world.objects:
            return
        made = self._model(arm)
        for each in arm.world.objects:
            _copy_numbers(made.find("body", each.name), self._mjcf_root.find("body", each.name))

    def add_ball(self, arm: Arm, visible: bool) -> Any:
        """Add a ball for a target; its place [m] may be written to the model at any time."""
        colour = ASKED if visible else [0.0] * 4
        size, place = [0.02 * arm.length] * 3, [arm.length] * 3  # at the origin the compiler would fix it there
        return self._mjcf_root.worldbody.add("site", name="target", type="sphere", size=size, pos=place, rgba=colour)

    def vector_to_world(self, vector: Any) -> Any:
        """Turn a vector of the base frame, shape (3,), into the world."""
        return self._rotation @ np.asarray(vector, dtype=float)

    def point_to_world(self, point: Any) -> Any:
        """Turn a point of the base frame [m], shape (3,), into one of the world."""
        return self._place + self.vector_to_world(point)


def _copy_numbers(source: Any, target: Any) -> None:
    """Copy all numbers from one PyMJCF tree to another of the same structure."""
    numbers = (int, float, np.ndarray)
    given = {name: value for name, value in source.get_attributes().items() if isinstance(value, numbers)}
    for name, value in target.get_attributes().items():
        if isinstance(value, numbers) and name not in given:
            delattr(target, name)
    if given:
        target.set_attributes(**given)
    for one, other in zip(source.all_children(), target.all_children(), strict=True):
        _copy_numbers(one, other)
