"""The controls of where the arm is to bend: angles of each section, and which of many poses reach a point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics import shape
from contarm_sim.view.live.inputs import slider, value
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.words import DRAG

On = Callable[[Any, Callable[[], None]], None]
"""Queues an action for whatever a person does with a control."""


class Aims(Protocol):
    """Controls that aim a session's arm."""

    def connect(self, on: On) -> None:
        """Let what a person does aim the arm."""

    def follow(self) -> None:
        """Let the controls say what the session's goal is."""


class OneSection:
    """A bend angle and a plane."""

    def __init__(self, gui: Any, session: Session) -> None:
        self._session = session
        with gui.add_folder("Target"):
            gui.add_markdown(DRAG)
            self._bend = _Bend(gui, LARGEST_BEND)

    def connect(self, on: On) -> None:
        """Let what a person does aim the arm."""
        for control in self._bend.controls:
            on(control, lambda: self._session.aim(self._bend.value))

    def follow(self) -> None:
        """Let the controls say what the session's goal is."""
        self._bend.show(self._session.goal)


class SeveralSections:
    """A bend angle and a plane for each section; the tip can be pulled, and what that leaves free is chosen.

    Two sections leave one number free: a slider goes along all the poses that reach the tip.
    """

    def __init__(self, gui: Any, session: Session) -> None:
        from contarm_sim.view.live.redundancy import TAKEN, Redundancy  # one section does without

        self._session, arm = session, session.arm
        self.redundancy = Redundancy(arm)
        with gui.add_folder("Target"):
            gui.add_markdown(DRAG)
            self._taken = gui.add_dropdown(
                "pose taken", TAKEN, initial_value=TAKEN[0],
                hint="Of all poses that reach the ring: the one nearest to the pose before, or that with the "
                "least sum of squares of bends.",
            )  # fmt: skip
            self._along: Any = None
            self._kept: Any = None
            if len(arm.sections) == 2:
                self._along = slider(
                    gui, "same tip, other pose [%]", (0, 100), 0.5, 0.0,
                    hint="Goes along all poses that reach the ring.",
                )  # fmt: skip
            else:
                self._kept = gui.add_dropdown("tip's direction", ("free", "kept"), initial_value="free")
        self._bends = []
        for number, limit in enumerate(self.redundancy.backbone.limits):
            with gui.add_folder(f"Section {number + 1}"):
                self._bends.append(_Bend(gui, min(limit, LARGEST_BEND)))

    def connect(self, on: On) -> None:
        """Let what a person does aim the arm."""
        for bend in self._bends:
            for control in bend.controls:
                on(control, self._bent)
        on(self._taken, self._take)
        if self._along is not None:
            on(self._along, self._go_along)
        if self._kept is not None:
            on(self._kept, self._keep)

    def pull(self, point: Array) -> None:
        """Pull the tip to a point of the base frame [m], shape (3,)."""
        self._session.aim(self.redundancy.pull(self._session.goal, point))
        self._show_bends()

    def let_go(self, point: Array) -> None:
        """End a pull at a point [m]: where the way there was blocked, another may be free."""
        goal, redundancy = self._session.goal, self.redundancy
        if np.linalg.norm(redundancy.tip(goal) - point) > 1e-4 * self._session.arm.length:
            found = redundancy.nearest(goal, point)
            if np.linalg.norm(redundancy.tip(found) - point) < 0.5 * np.linalg.norm(redundancy.tip(goal) - point):
                self._session.aim(found)
        self.follow()

    def follow(self) -> None:
        """Let the controls say what the session's goal is."""
        self._show_bends()
        if self._along is not None:
            self.redundancy.forget()
            self._along.value = round(200 * self.redundancy.share(self._session.goal)) / 2

    def _show_bends(self) -> None:
        for bend, own in zip(self._bends, shape.bends_of(self._session.goal, self._session.arm), strict=True):
            bend.show(own)

    def _bent(self) -> None:
        self._session.aim(np.concatenate([bend.value for bend in self._bends]))
        self._hold_direction()
        self.redundancy.forget()
        if self._along is not None:
            self._along.value = round(200 * self.redundancy.share(self._session.goal)) / 2

    def _take(self) -> None:
        self.redundancy.taken = self._taken.value
        self.pull(self.redundancy.tip(self._session.goal))

    def _keep(self) -> None:
        self.redundancy.direction = None
        self._hold_direction()

    def _hold_direction(self) -> None:
        if self._kept is not None and self._kept.value == "kept":
            self.redundancy.direction = shape.rotation(self._session.goal, self._session.arm)[:, 2]

    def _go_along(self) -> None:
        self._session.aim(self.redundancy.along(self._session.goal, 0.01 * value(self._along)))
        self._show_bends()


class _Bend:
    """Sliders of the angle and the plane of one section's bend."""

    def __init__(self, gui: Any, largest: float) -> None:
        most = round(float(np.degrees(largest)))
        self._angle = slider(gui, "bend angle [deg]", (0, most), 0.5, 0.0)
        self._plane = slider(gui, "plane angle [deg]", (-180, 180), 1.0, 0.0, hint="0 is towards +X of the base.")
        self.controls = (self._angle, self._plane)

    @property
    def value(self) -> Array:
        """The bend that the sliders say [rad], shape (2,)."""
        angle, plane = np.radians([value(self._angle), value(self._plane)])
        return arc.from_polar(angle, plane)

    def show(self, bend: Array) -> None:
        """Let the sliders say a bend [rad], shape (2,)."""
        angle, plane = (float(x) for x in arc.to_polar(bend))
        self._angle.value = round(2 * np.degrees(angle)) / 2
        if angle > 1e-9:
            self._plane.value = float(round(np.degrees(plane)))
