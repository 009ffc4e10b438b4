"""Pictures of an arm while it is trained: as arrays, or in a window."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol

from contarm_sim.envs.state import joint_count
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.view.rendering import BROADEST
from contarm_sim.view.rendering.cameras import check_camera
from contarm_sim.view.rendering.window import has_display

RENDER_MODES = ("rgb_array", "human")


def modes_here() -> list[str]:
    """Return the render modes that work here: a window needs a display."""
    return [mode for mode in RENDER_MODES if mode != "human" or has_display()]


@dataclass(frozen=True)
class Sight:
    """What pictures of mode rgb_array show.

    Attributes:
        width, height: size [pixels].
        camera: front, side, top, orbit (one turn an episode) or tip (follows it).

    Raises:
        InputError: a size that is no positive whole number, or larger than anything draws, or an unknown camera.
    """

    width: int = 640
    height: int = 480
    camera: str = "front"

    def __post_init__(self) -> None:
        from contarm_sim.view.rendering.formats import check_size

        check_size(self.width, self.height)
        for name in ("width", "height"):
            if getattr(self, name) > BROADEST:
                raise InputError(name, getattr(self, name), f"at most {BROADEST} pixels")
        check_camera(self.camera)


class Picture(Protocol):
    """Something that shows an arm."""

    def draw(self, positions: Array, target: Array | None, share: float, arm: Arm) -> Any:
        """Show an arm and a target.

        Args:
            positions: joint angles [rad], then the poses of free objects in the base frame, shape (nq,).
            target: a point of the base frame [m], shape (3,), or None.
            share: of the episode that has passed.
            arm: that of the episode, whose objects are shown.
        """

    def close(self) -> None:
        """Give back what it holds."""


def picture(mode: str, arm: Arm, sight: Sight) -> Picture:
    """Return what draws in a render mode.

    Raises:
        RenderingError: nothing draws here, or not so large.
    """
    return Window(arm) if mode == "human" else Pixels(arm, sight)


class Pixels:
    """Draws arrays, shape (height, width, 3)."""

    def __init__(self, arm: Arm, sight: Sight) -> None:
        from contarm_sim.view.rendering.draw import ArmRenderer

        self._renderer = ArmRenderer(arm, sight.width, sight.height, sight.camera)

    def draw(self, positions: Array, target: Array | None, share: float, arm: Arm) -> Any:
        """Return the picture."""
        joints = joint_count(arm)
        if arm.world.objects:
            self._renderer.among(arm)
        return self._renderer.pose(positions[:joints], target, share, positions[joints:].reshape(-1, 7)).copy()

    def close(self) -> None:
        """Give the GL memory back."""
        self._renderer.__exit__()


class Window:
    """Draws in MuJoCo's viewer.

    Raises:
        RenderingError: there is no display.
    """

    def __init__(self, arm: Arm) -> None:
        import mujoco

        from contarm_sim.mjcf import scene_spec
        from contarm_sim.view.rendering.window import window

        self._arm, self._model = arm, scene_spec(arm).compile()
        self._data = mujoco.MjData(self._model)
        self._ball = 0.02 * arm.length
        self._open = ExitStack()
        self._viewer = self._open.enter_context(window(self._model, self._data))

    def draw(self, positions: Array, target: Array | None, share: float, arm: Arm) -> None:
        """Show the pose and the target."""
        import mujoco

        from contarm_sim.mjcf.object_looks import restage, to_scene
        from contarm_sim.view.rendering.draw import ASKED
        from contarm_sim.view.rendering.overlays import add_ball

        with self._viewer.lock():
            joints = joint_count(arm)
            self._data.qpos[:joints] = positions[:joints]
            if arm.world.objects:
                restage(self._model, self._arm, arm)
                self._data.qpos[joints:] = to_scene(self._arm, positions[joints:].reshape(-1, 7))
            mujoco.mj_forward(self._model, self._data)
            self._viewer.user_scn.ngeom = 0
            if target is not None:
                base = self._data.body("base")
                place = base.xpos + base.xmat.reshape(3, 3) @ target
                add_ball(self._viewer.user_scn, place, self._ball, ASKED)
        self._viewer.sync()

    def close(self) -> None:
        """Close the window, and wait until it is gone: Python must not end under it."""
        self._open.close()
