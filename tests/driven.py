"""The simulated arm under the seeded cases of `random_drives`, and how far its tip ends from the ideal rod's."""

from dataclasses import replace

import numpy as np

from contarm_sim.model.load import Load, Muscles, Wrench
from contarm_sim.statics.equilibrium import equilibrium


def simulated(case, links, path="parallel"):
    """Return the equilibrium of a case's arm with so many links."""
    arm = replace(case.arm, links=links, path=path)
    wrench = Wrench(xi=1, force=tuple(case.force), moment=tuple(case.moment))
    return equilibrium(arm, Load(wrenches=(wrench,), muscles=Muscles(kind=case.kind, values=tuple(case.values))))


def tip_errors(cases, links):
    """Return distances of simulated tips from the rod's [% of length], shape (cases, links)."""
    return np.array([[tip_error(simulated(case, n).tip, case.rod.tip, case.arm) for n in links] for case in cases])


def span_errors(cases, links):
    """Return distances of tips with straight spans from the rod's with as many disks [% of length]."""
    return np.array(
        [[tip_error(simulated(case, n, "spans").tip, case.spans(n).tip, case.arm) for n in links] for case in cases]
    )


def tip_error(tip, expected, arm):
    """Return the distance of a tip from another [% of length]."""
    return 100 * float(np.linalg.norm(tip - expected)) / arm.length


def order(coarse, fine):
    """Return the median order of convergence from errors at N links and at 2 N."""
    return float(np.median(np.log2(coarse / fine)))
