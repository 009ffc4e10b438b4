"""What the page shows beside the scene: controls, readings, live plots. Every control sets one value and nothing else.

Callbacks run in the server's threads, so they only queue what is to be done; the loop in `server` does it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from contarm_sim.control.registry import NAMES
from contarm_sim.errors import InputError
from contarm_sim.kinematics.arrays import Array
from contarm_sim.view.live.aims import Aims, OneSection, SeveralSections
from contarm_sim.view.live.inputs import slider, value
from contarm_sim.view.live.keeping import Keeper
from contarm_sim.view.live.loads import Loads, turned
from contarm_sim.view.live.plots import Plots
from contarm_sim.view.live.presets import name_of, offered
from contarm_sim.view.live.session import Session
from contarm_sim.view.live.words import legend, readings

if TYPE_CHECKING:
    import viser

Post = Callable[..., None]

_RED = (178, 32, 32)
"""Of the button that records: white words on it are read."""


class Panel:
    """The controls of a page.

    Args:
        post: queues what is to be done.
        on_turn: is called when the arm is mounted in another way.
        on_arm: is called when the session has another arm; the panel is another by then.
        keeper: of recordings.

    Attributes:
        paused: whether time stands still.
        speed: simulated over wall-clock time asked for.
    """

    def __init__(
        self, server: viser.ViserServer, session: Session, post: Post, on_turn: Callable[[], None],
        on_arm: Callable[[], None], keeper: Keeper,
    ) -> None:  # fmt: skip
        self._gui, self._session, self._post = server.gui, session, post
        self._turn, self._on_arm, self._keeper = on_turn, on_arm, keeper
        self._arms = offered(session.arm)
        self._build(name_of(session.arm, self._arms))

    def _build(self, name: str) -> None:
        """Put controls for the session's arm in place of what there was."""
        gui, arm = self._gui, self._session.arm
        gui.reset()
        self.paused, self.speed = False, 1.0
        self._status = gui.add_markdown("")
        self.aims: Aims = (OneSection if len(arm.sections) == 1 else SeveralSections)(gui, self._session)
        with gui.add_folder("Time"):
            self._record = gui.add_button(
                "Record", color=_RED,
                hint="Leaves a folder as `contarm run` does: numbers, figures, report.html. While it records, arm, "
                "control and load stay as they are.",
            )  # fmt: skip
            self._pause = gui.add_button("Pause")
            self._reset = gui.add_button("Reset", hint="Start again at time 0 with the straight arm at rest.")
            self._speed = slider(gui, "speed", (0.1, 4.0), 0.1, 1.0, hint="Simulated time over real time.")
        with gui.add_folder("Arm"):
            self._arm = gui.add_dropdown("arm", tuple(self._arms), initial_value=name)
        with gui.add_folder("Control"):
            self._controller = gui.add_dropdown("controller", NAMES, initial_value=self._session.controller)
            least = max(group.law.min_tension for group in arm.groups)
            self._least = slider(
                gui, "least tension [N]", (0.5, max(60.0, 2 * least)), 0.5, least,
                hint="Co-contraction: the tension of the slackest muscle."
            )  # fmt: skip
        self._loads = Loads(gui, arm)
        gui.main_panel.dock_right()
        curves = gui.add_panel()
        with curves.add_tab("Curves"):
            gui.add_html(legend(arm))
            self._plots = Plots(gui, arm)
        curves.dock_left()
        curves.set_width(300)
        self._connect()

    def _connect(self) -> None:
        self.aims.connect(self._on)
        self._on(self._arm, self._take_arm)
        self._on(self._controller, lambda: self._session.change(controller=self._controller.value))
        self._on(self._least, self._contract)
        self._loads.connect(self._on, self._load)
        self._on(self._speed, lambda: setattr(self, "speed", value(self._speed)))
        for button, action in ((self._pause, self._toggle), (self._reset, self._start_again)):
            self._on_click(button, action)
        self._on_click(self._record, self._start_or_stop)

    def _on(self, control: Any, action: Callable[[], None]) -> None:
        """Queue an action for whatever a person does with a control; what `follow` sets is not echoed."""
        act = self._while_here(action)
        control.on_update(lambda event: self._post(act) if event.client is not None else None)

    def _on_click(self, button: Any, action: Callable[[], None]) -> None:
        act = self._while_here(action)
        button.on_click(lambda _: self._post(act))

    def _while_here(self, action: Callable[[], None]) -> Callable[[], None]:
        """Return an action that does nothing once its controls have made place for those of another arm."""
        aims = self.aims
        return lambda: action() if aims is self.aims else None

    def _take_arm(self) -> None:
        """Change to the arm of a name."""
        name = self._arm.value
        self._keep()
        try:
            self._session.restart(self._arms[name])
        finally:
            self._build(name)
            self._on_arm()

    def _contract(self) -> None:
        """Give the muscles of all sections the least tension that the slider says."""
        arm = self._session.arm
        laws = tuple(law.with_min_tension(value(self._least)) for law in arm.laws)
        self._session.change(arm=replace(arm, laws=laws))

    def _load(self) -> None:
        """Give the session's arm the gravity and the payload that the controls say."""
        before = self._session.arm
        self._session.change(arm=self._loads.put_on(before))
        if turned(before, self._session.arm):
            self._turn()

    def _toggle(self) -> None:
        self.paused = not self.paused
        self._pause.label = "Resume" if self.paused else "Pause"

    def _start_again(self) -> None:
        self._keep()
        self._session.reset()
        self._plots.clear()
        self._turn()
        self.follow()

    def _start_or_stop(self) -> None:
        if self._session.recording is None:
            self._session.record()
            self._lock(True)
        else:
            self._keep()

    def _keep(self) -> None:
        """End a recording, if there is one, and keep it."""
        recording, self._session.recording = self._session.recording, None
        if recording is None:
            return
        self._lock(False)
        run = recording.trajectory()
        if run is None:
            raise InputError("recording", "less than two samples", "a longer one; it was not kept")
        self._keeper.keep(run)

    def _lock(self, recording: bool) -> None:
        """Let nobody change what a recording has one of."""
        self._record.label = "Stop recording" if recording else "Record"
        for control in (self._arm, self._controller, self._least, self._reset, *self._loads.controls):
            control.disabled = recording

    def aim(self, bend: Array) -> None:
        """Go to a bend [rad], shape (2 S,), and let the sliders say so."""
        self._session.aim(bend)
        self.follow()

    def follow(self) -> None:
        """Let the sliders say what the session's goal is."""
        self.aims.follow()

    def note(self) -> None:
        """Take a point for the plots, if it is time for one; end a recording that cannot go on."""
        self._plots.note(self._session.reading)
        if self._session.recording is not None and self._session.recording.ended:
            self._keep()

    def show(self, pace: str, thinning: int = 1, arrows: float = 0.0) -> None:
        """Bring readings and plots up to date.

        Args:
            pace: whether it keeps up with real time, in words.
            thinning: of how many points of the plots one is drawn.
            arrows: how long those of contact forces are [m/N].
        """
        usual = "real time" if self.speed == 1 else f"{self.speed:g} x real time"
        pace = "paused" if self.paused else pace or usual
        self._status.content = readings(self._session, pace, self._keeper, arrows)
        self._plots.show(thinning)
