"""How much of one core the live arm takes: simulated over processor time, and the page's share, by controller."""

import time

import numpy as np

from contarm_sim import Arm
from contarm_sim.control.registry import NAMES
from contarm_sim.engine.plant import engine_room
from contarm_sim.kinematics import arc
from contarm_sim.view.live.keeping import Keeper
from contarm_sim.view.live.page import page
from contarm_sim.view.live.session import PERIOD, Session

SECONDS, PICTURES, PLOTS = 10.0, 30.0, 8.0


def seconds_of(function, count):
    """Return the processor time of one call [s], all threads; nobody is connected, so nothing is sent."""
    start = time.process_time()
    for _ in range(count):
        function()
    return (time.process_time() - start) / count


def main():
    for controller in NAMES:
        session = Session(Arm(), controller)
        session.aim(arc.from_polar(1.2, 0.5))
        with engine_room(), page(session, None, Keeper(print)) as shown:
            scene, panel = shown.scene, shown.panel
            ticks = seconds_of(
                lambda panel=panel, session=session: (session.tick(), panel.note()), round(SECONDS / PERIOD)
            )
            picture = seconds_of(scene.show, 200)
            plots = seconds_of(lambda panel=panel: panel.show(""), 50)
        parts = np.array([ticks / PERIOD, picture * PICTURES, plots * PLOTS])
        print(
            f"{controller:11} {100 * parts.sum():5.1f} % of a core: simulation and control {100 * parts[0]:.1f}, "
            f"pictures {100 * parts[1]:.1f}, plots {100 * parts[2]:.1f}; {1 / parts.sum():.1f} x real time"
        )


if __name__ == "__main__":
    main()
