"""What the page shows beside the scene: controls, readings, live plots. Every control sets one value and nothing else.

Callbacks run in the server's threads, so they only queue what is to be done; the loop in `server` does it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from contarm_sim.control.registry import NAMES
from contarm_sim.kinematics import arc
from contarm_sim.kinematics.arc import LARGEST_BEND
from contarm_sim.kinematics.arrays import Array
from contarm_sim.model.arm import Arm
from contarm_sim.model.colours import muscle_hex
from contarm_sim.view.live.session import Session

if TYPE_CHECKING:
    import viser

Post = Callable[..., None]

_DOWN = {"hanging": (0.0, 0.0, 1.0), "upright": (0.0, 0.0, -1.0), "sideways": (-1.0, 0.0, 0.0)}
_GIVEN = "as given"
_SHOWN, _EVERY = 10.0, 0.05
"""Time that the plots show, and between their points [s]."""


class Panel:
    """The controls of a page.

    Attributes:
        paused: whether time stands still.
        speed: simulated over wall-clock time asked for.
    """

    def __init__(self, server: viser.ViserServer, session: Session, post: Post, on_turn: Callable[[], None]) -> None:
        self._session, self._post, self._turn = session, post, on_turn
        self.paused, self.speed = False, 1.0
        self._points: deque[tuple[float, ...]] = deque(maxlen=round(_SHOWN / _EVERY))
        self._build(server.gui, session.arm)

    def _build(self, gui: Any, arm: Arm) -> None:
        with gui.add_folder("Target"):
            largest = round(float(np.degrees(LARGEST_BEND)))
            self._angle = _slider(
                gui, "bend angle [deg]", (0, largest), 0.5, 0.0, hint="You can also drag the ball on the dome."
            )
            self._plane = _slider(gui, "plane angle [deg]", (-180, 180), 1.0, 0.0, hint="0 is towards muscle 1 (red).")
        with gui.add_folder("Control"):
            self._controller = gui.add_dropdown("controller", NAMES, initial_value=self._session.controller)
            least = arm.muscle.min_tension
            self._least = _slider(
                gui, "least tension [N]", (0.5, max(60.0, 2 * least)), 0.5, least,
                hint="Co-contraction: the tension of the slackest muscle."
            )  # fmt: skip
        with gui.add_folder("Load"):
            strength = float(np.linalg.norm(arm.gravity))
            gravities = [_GIVEN, *_DOWN] if strength else list(_DOWN)
            self._mount = gui.add_dropdown(
                "the arm is", gravities, initial_value=gravities[0] if strength else "upright"
            )
            self._gravity = _slider(gui, "gravity [m/s²]", (0.0, max(9.81, strength)), 0.01, strength)
            self._payload = _slider(gui, "payload [g]", (0, max(200.0, 2e3 * arm.payload)), 5, 1e3 * arm.payload)
        with gui.add_folder("Time"):
            self._pause = gui.add_button("Pause")
            self._reset = gui.add_button("Reset", hint="Start again at time 0 with the straight arm at rest.")
            self._speed = _slider(gui, "speed", (0.1, 4.0), 0.1, 1.0, hint="Simulated time over real time.")
        gui.main_panel.dock_right()
        readings = gui.add_panel()
        with readings.add_tab("Readings"):
            self._status = gui.add_markdown("")
            self._plots = _Plots(gui)
        readings.dock_left()
        readings.set_width(300)
        self._given = np.array(arm.gravity) / strength if strength else np.zeros(3)
        self._connect()

    def _connect(self) -> None:
        for slider in (self._angle, self._plane):
            self._on(slider, self._aim)
        self._on(self._controller, lambda: self._session.change(controller=self._controller.value))
        for control in (self._least, self._payload, self._gravity):
            self._on(control, self._load)
        self._on(self._mount, self._load)
        self._on(self._speed, lambda: setattr(self, "speed", _value(self._speed)))
        self._pause.on_click(lambda _: self._post(self._toggle))
        self._reset.on_click(lambda _: self._post(self._start_again))

    def _on(self, control: Any, action: Callable[[], None]) -> None:
        """Queue an action for whatever a person does with a control; what `follow` sets is not echoed."""
        control.on_update(lambda event: self._post(action) if event.client is not None else None)

    def _aim(self) -> None:
        angle, plane = np.radians([_value(self._angle), _value(self._plane)])
        self._session.aim(arc.from_polar(angle, plane))

    def _load(self) -> None:
        """Give the session the arm that the controls describe."""
        down = self._given if self._mount.value == _GIVEN else np.array(_DOWN[self._mount.value])
        arm = self._session.arm
        # A hair of gravity keeps the picture's way down while it is turned off.
        x, y, z = (float(part) for part in max(_value(self._gravity), 1e-9) * down)
        muscle = arm.muscle.with_min_tension(_value(self._least))
        changed = replace(arm, gravity=(x, y, z), payload=1e-3 * _value(self._payload), muscle=muscle)
        turned = not np.allclose(_direction(changed), _direction(arm))
        self._session.change(arm=changed)
        if turned:
            self._turn()

    def _toggle(self) -> None:
        self.paused = not self.paused
        self._pause.label = "Resume" if self.paused else "Pause"

    def _start_again(self) -> None:
        self._session.reset()
        self._points.clear()
        self._turn()
        self.follow()

    def aim(self, bend: Array) -> None:
        """Go to a bend [rad], shape (2,), and let the sliders say so."""
        self._session.aim(bend)
        self.follow()

    def follow(self) -> None:
        """Let the sliders say what the session's goal is."""
        angle, plane = (float(x) for x in arc.to_polar(self._session.goal))
        self._angle.value = round(2 * np.degrees(angle)) / 2
        if angle > 1e-9:
            self._plane.value = float(round(np.degrees(plane)))

    def note(self) -> None:
        """Take a point for the plots, if it is time for one."""
        reading, arm = self._session.reading, self._session.arm
        if self._points and 0 <= reading.time - self._points[-1][0] < _EVERY:
            return
        pressures = np.where(np.isfinite(reading.pressures), 1e-3 * reading.pressures, np.nan)
        error = 1e3 * reading.error
        self._points.append((reading.time, error, 0.1 * error / arm.length, *reading.tensions, *pressures))

    def show(self, busy: float, behind: bool) -> None:
        """Bring readings and plots up to date.

        Args:
            busy: share of one processor core that the simulation takes.
            behind: whether it cannot keep up with real time.
        """
        reading, arm = self._session.reading, self._session.arm
        angle, plane = (np.degrees(x) for x in arc.to_polar(reading.bend))
        pace = "**slower than the set speed**" if behind else f"{100 * busy:.0f} % of a core"
        highest = arm.muscle.pressure_limits[1]
        over = f"  \n**needs more than {1e-3 * highest:.0f} kPa**" if reading.pressures.max() > 1.001 * highest else ""
        text = (
            f"**Tip error {1e3 * reading.error:.2f} mm** ({100 * reading.error / arm.length:.2f} % of length)  \n"
            f"bend {angle:.1f}° towards {plane:.0f}°  \n"
            f"t = {reading.time:.1f} s, {'paused' if self.paused else pace}{over}"
        )
        self._status.content = text + (
            f"\n\n**Goal not followed:** {self._session.problem}" if self._session.problem else ""
        )
        if self._points:
            self._plots.show(np.array(self._points).T)


class _Plots:
    """Error, tensions and pressures of the last seconds."""

    def __init__(self, gui: Any) -> None:
        from viser import uplot

        muscles = [muscle_hex(i) for i in range(3)]
        empty = np.zeros(1)
        self._plots = []
        for title, names, colours, least in (
            ("tip error [mm]", ("error",), ("#7526cc",), 1.0),
            ("tension [N]: 1 red, 2 blue, 3 amber", ("1", "2", "3"), muscles, 10.0),
            ("pressure needed [kPa]", ("1", "2", "3"), muscles, 100.0),
        ):
            series = [uplot.Series(label="t [s]")]
            series += [
                uplot.Series(label=name, stroke=colour, width=2) for name, colour in zip(names, colours, strict=True)
            ]
            self._plots.append(
                gui.add_uplot(
                    (empty,) * len(series), tuple(series), title=title, height=140, padding=(10, 24, 0, 0),
                    scales={"x": uplot.Scale(time=False, auto=True), "y": {"range": _from_zero(least)}},
                    legend=uplot.Legend(show=False),
                )
            )  # fmt: skip

    def show(self, points: Array) -> None:
        """Draw points, shape (9, T): time, error [mm], error [%], tensions [N], pressures [kPa]."""
        time = points[0]
        for plot, rows in zip(self._plots, (points[1:2], points[3:6], points[6:9]), strict=True):
            plot.data = (time, *rows)


def _from_zero(least: float) -> Any:
    """Return the range of an axis that shows 0, and `least`, and more if there is more."""
    return {"min": {"pad": 0.1, "soft": 0.0, "mode": 1}, "max": {"pad": 0.1, "soft": least, "mode": 1}}


def _value(slider: Any) -> float:
    """Return what a slider says, within its limits: boxes pass on whatever is typed, key by key."""
    value = slider.value
    number = float(value) if isinstance(value, int | float) and np.isfinite(value) else slider.min
    return float(np.clip(number, slider.min, slider.max))


def _slider(
    gui: Any, label: str, limits: tuple[float, float], step: float, value: float, hint: str | None = None
) -> Any:
    return gui.add_slider(label, min=limits[0], max=limits[1], step=step, initial_value=value, hint=hint)


def _direction(arm: Arm) -> Array:
    gravity = np.array(arm.gravity)
    return gravity / max(float(np.linalg.norm(gravity)), 1e-300)
