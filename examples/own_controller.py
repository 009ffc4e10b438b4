"""A controller of one's own: the tensions that hold each bend at rest, sent without any feedback."""

from contarm_sim import Arm, Controller, Plan, Reference, compare, paths, simulate
from contarm_sim.mechanics.routing import lengths_from_bend
from contarm_sim.mechanics.statics import holding_tensions


class OpenLoop(Controller):
    """Tensions in closed form; nothing is measured."""

    name = "open-loop"
    actuation = "tensions"

    def plan(self, arm: Arm, reference: Reference) -> Plan:
        """Return the muscle lengths [m] and the tensions [N] of all samples, shape (T, 3) each."""
        tensions = holding_tensions(reference.bend, arm)
        return Plan(lengths_from_bend(reference.bend, arm), tensions, tensions[0])


arm = Arm()
reference = Reference.from_path(paths.named("circle", arm.length, duration=10, max_bend=1.0), arm)
for controller in (OpenLoop(), "servo"):
    trajectory = simulate(arm, reference, controller)
    print(f"{trajectory.controller:10} largest tip error {1e3 * compare(trajectory).tip_error.max():6.2f} mm")
