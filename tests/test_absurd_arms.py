"""Arms of absurd sizes: refused where they are made or compiled, or the engine takes them without a warning."""

import warnings

import numpy as np

from contarm_sim.engine.plant import Plant
from contarm_sim.errors import InputError
from contarm_sim.mjcf import scene_spec
from contarm_sim.model.arm import Arm
from contarm_sim.model.ideal import Ideal
from contarm_sim.model.mckibben import McKibben
from contarm_sim.model.routing import Routing
from contarm_sim.model.section import LONGEST, SHORTEST, Section
from contarm_sim.model.tendon import Tendon
from contarm_sim.model.world import World


def _size(rng, low=1e-9, high=1e9):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _absurd(rng):
    sections = tuple(
        Section(
            length=_size(rng, SHORTEST, LONGEST), links=int(rng.integers(2, 12)), mass=_size(rng),
            bending_stiffness=_size(rng), damping_time=_size(rng),
            torsional_stiffness=_size(rng) if rng.random() < 0.3 else None,
        )
        for _ in range(rng.integers(1, 4))
    )  # fmt: skip
    most = _size(rng, 1e-5)
    laws = (
        McKibben(),
        Tendon(stiffness=_size(rng), pretension=1e-3 * most, max_tension=most),
        Ideal(max_tension=1e9, servo_stiffness=_size(rng)),
    )
    return Arm(
        sections=sections,
        routings=tuple(
            Routing(radius=min(_size(rng), 0.3 * section.length), path=str(rng.choice(["parallel", "spans"])))
            for section in sections
        ),
        laws=tuple(laws[rng.integers(3)] for _ in sections),
        world=World(gravity=tuple((rng.normal(size=3) * _size(rng, high=1e8)).tolist()), payload=_size(rng)),
    )


def test_absurd_arms_are_refused_or_compile_without_a_warning():
    rng, refused, made = np.random.default_rng(0), [], 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for _ in range(120):
            try:
                arm = _absurd(rng)
                Plant(arm)
                Plant(arm, actuation="tensions")
                scene_spec(arm).compile()
                made += 1
            except InputError as error:
                refused.append(str(error))
    assert len(refused) > 30
    assert "\n" not in "".join(refused)
    assert made > 30
