"""What the page shows beside the scene: controls, readings, live plots. Every control sets one value and nothing else.

Callbacks run in the server's threads, so they only queue what is to be done; the loop in `server` does it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.control.registry import NAMES
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arrays import Array
from contarm_sim.mechanics.muscles import each
from contarm_sim.mechanics.shape import bends_of
from contarm_sim.model.arm import Arm
from contarm_sim.view.live.aims import OneSection, SeveralSections
from contarm_sim.view.live.inputs import slider, value
from contarm_sim.view.live.plots import Plots
from contarm_sim.view.live.session import Session

if TYPE_CHECKING:
    import viser

Post = Callable[..., None]

_DOWN = {"hanging": (0.0, 0.0, 1.0), "upright": (0.0, 0.0, -1.0), "sideways": (-1.0, 0.0, 0.0)}
_GIVEN = "as given"


class Panel:
    """The controls of a page.

    Attributes:
        paused: whether time stands still.
        speed: simulated over wall-clock time asked for.
    """

    def __init__(self, server: viser.ViserServer, session: Session, post: Post, on_turn: Callable[[], None]) -> None:
        self._session, self._post, self._turn = session, post, on_turn
        self.paused, self.speed = False, 1.0
        self._build(server.gui, session.arm)

    def _build(self, gui: Any, arm: Arm) -> None:
        self.aims = OneSection(gui, self._session) if len(arm.sections) == 1 else SeveralSections(gui, self._session)
        with gui.add_folder("Control"):
            self._controller = gui.add_dropdown("controller", NAMES, initial_value=self._session.controller)
            least = max(group.law.min_tension for group in arm.groups)
            self._least = slider(
                gui, "least tension [N]", (0.5, max(60.0, 2 * least)), 0.5, least,
                hint="Co-contraction: the tension of the slackest muscle."
            )  # fmt: skip
        with gui.add_folder("Load"):
            strength = float(np.linalg.norm(arm.gravity))
            gravities = [_GIVEN, *_DOWN] if strength else list(_DOWN)
            self._mount = gui.add_dropdown(
                "the arm is", gravities, initial_value=gravities[0] if strength else "upright"
            )
            self._gravity = slider(gui, "gravity [m/s²]", (0.0, max(9.81, strength)), 0.01, strength)
            self._payload = slider(gui, "payload [g]", (0, max(200.0, 2e3 * arm.payload)), 5, 1e3 * arm.payload)
        with gui.add_folder("Time"):
            self._pause = gui.add_button("Pause")
            self._reset = gui.add_button("Reset", hint="Start again at time 0 with the straight arm at rest.")
            self._speed = slider(gui, "speed", (0.1, 4.0), 0.1, 1.0, hint="Simulated time over real time.")
        gui.main_panel.dock_right()
        readings = gui.add_panel()
        with readings.add_tab("Readings"):
            self._status = gui.add_markdown("")
            self._plots = Plots(gui, arm)
        readings.dock_left()
        readings.set_width(300)
        self._given = np.array(arm.gravity) / strength if strength else np.zeros(3)
        self._connect()

    def _connect(self) -> None:
        self.aims.connect(self._on)
        self._on(self._controller, lambda: self._session.change(controller=self._controller.value))
        self._on(self._least, self._contract)
        for control in (self._payload, self._gravity):
            self._on(control, self._load)
        self._on(self._mount, self._load)
        self._on(self._speed, lambda: setattr(self, "speed", value(self._speed)))
        self._pause.on_click(lambda _: self._post(self._toggle))
        self._reset.on_click(lambda _: self._post(self._start_again))

    def _on(self, control: Any, action: Callable[[], None]) -> None:
        """Queue an action for whatever a person does with a control; what `follow` sets is not echoed."""
        control.on_update(lambda event: self._post(action) if event.client is not None else None)

    def _contract(self) -> None:
        """Give the muscles of all sections the least tension that the slider says."""
        arm = self._session.arm
        laws = tuple(law.with_min_tension(value(self._least)) for law in arm.laws)
        self._session.change(arm=replace(arm, laws=laws))

    def _load(self) -> None:
        """Give the session's arm the gravity and the payload that the controls say."""
        down = self._given if self._mount.value == _GIVEN else np.array(_DOWN[self._mount.value])
        arm = self._session.arm
        # A hair of gravity keeps the picture's way down while it is turned off.
        x, y, z = (float(part) for part in max(value(self._gravity), 1e-9) * down)
        changed = replace(arm, gravity=(x, y, z), payload=1e-3 * value(self._payload))
        turned = not np.allclose(_direction(changed), _direction(arm))
        self._session.change(arm=changed)
        if turned:
            self._turn()

    def _toggle(self) -> None:
        self.paused = not self.paused
        self._pause.label = "Resume" if self.paused else "Pause"

    def _start_again(self) -> None:
        self._session.reset()
        self._plots.clear()
        self._turn()
        self.follow()

    def aim(self, bend: Array) -> None:
        """Go to a bend [rad], shape (2 S,), and let the sliders say so."""
        self._session.aim(bend)
        self.follow()

    def follow(self) -> None:
        """Let the sliders say what the session's goal is."""
        self.aims.follow()

    def note(self) -> None:
        """Take a point for the plots, if it is time for one."""
        self._plots.note(self._session.reading)

    def show(self, busy: float, behind: bool) -> None:
        """Bring readings and plots up to date.

        Args:
            busy: share of one processor core that the simulation takes.
            behind: whether it cannot keep up with real time.
        """
        reading, arm = self._session.reading, self._session.arm
        pace = "**slower than the set speed**" if behind else f"{100 * busy:.0f} % of a core"
        highest = each(arm, lambda group: group.law.pressure_limits[1])
        beyond = highest[reading.pressures > 1.001 * highest]
        over = f"  \n**needs more than {1e-3 * beyond.min():.0f} kPa**" if beyond.size else ""
        text = (
            f"**Tip error {1e3 * reading.error:.2f} mm** ({100 * reading.error / arm.length:.2f} % of length)  \n"
            f"{_bend_lines(reading.bend, arm)}  \n"
            f"t = {reading.time:.1f} s, {'paused' if self.paused else pace}{over}"
        )
        self._status.content = text + (
            f"\n\n**Goal not followed:** {self._session.problem}" if self._session.problem else ""
        )
        self._plots.show()


def _direction(arm: Arm) -> Array:
    gravity = np.array(arm.gravity)
    return gravity / max(float(np.linalg.norm(gravity)), 1e-300)


def _bend_lines(bend: Array, arm: Arm) -> str:
    """Return a bend [rad], shape (2 S,), in words, a line a section."""
    lines = []
    for number, own in enumerate(bends_of(bend, arm)):
        angle, plane = (np.degrees(x) for x in arc.to_polar(own))
        of_section = "" if len(arm.sections) == 1 else f" {number + 1}"
        lines.append(f"bend{of_section} {angle:.1f}° towards {plane:.0f}°")
    return "  \n".join(lines)
