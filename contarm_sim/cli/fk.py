"""`contarm fk`: pose of bends or of muscle lengths, on the command line."""

from __future__ import annotations

from typing import Any

import click

from contarm_sim.cli.options import LENGTH, PLAIN, Command, arm_options, bend_option, bends_from_words, json_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm

DELTA_TOLERANCE = 1e-6
"""Largest mean of muscle length changes that is taken for rounding [m]."""


@click.command(cls=Command)
@click.option(
    "--deltas", type=LENGTH, nargs=3, multiple=True, metavar="L1 L2 L3",
    help="Muscle length changes [m], shortening < 0; of evenly spaced muscles their sum is 0. Once for each section, "
    "if all have three muscles.",
)  # fmt: skip
@bend_option("Bend in polar form [rad]. Once for each section, from the base on.")
@click.option(
    "--xi", type=PLAIN, multiple=True, metavar="X ...", help="Normalised arc lengths, 0 base to 1 tip; default the tip."
)
@json_option
@arm_options
def fk(arm: Arm, deltas: Any, bend: Any, xi: tuple[float, ...], as_json: bool) -> None:
    """Forward kinematics: muscle length changes or a bend to the pose of the arc.

    \b
    contarm fk --bend 90deg 0
    contarm fk --deltas -0.02827 0.01414 0.01413 --xi 0 0.5 1 --json
    contarm fk --preset two --bend 60deg 0 --bend 45deg 180deg
    """
    import numpy as np

    from contarm_sim.cli.solutions import of_bends, of_sections, show
    from contarm_sim.cli.terminal import say_objects
    from contarm_sim.mechanics import shape

    say_objects(arm)
    if bool(deltas) == bool(bend):
        given = "both --deltas and --bend" if deltas else "neither --deltas nor --bend"
        raise InputError("input", given, "--bend BEND_ANGLE PLANE_ANGLE for each section, or --deltas L1 L2 L3")
    vector = _from_deltas(arm, deltas) if deltas else bends_from_words(bend, arm).reshape(-1)
    stations = np.array(xi) if xi else np.array(1.0)
    solution = {**of_bends(arm, vector[None])[0], "transform": shape.transform(vector, arm, stations).tolist()}
    solution["sections"] = of_sections(arm, vector)
    if xi:
        solution["xi"] = list(xi)
    if as_json:
        from contarm_sim.view.report.output import to_json

        click.echo(to_json(solution))
    else:
        transforms = np.reshape(solution["transform"], (-1, 4, 4))
        show(arm, solution, [(f"xi = {x:g}", T) for x, T in zip(xi or (1.0,), transforms, strict=True)])


def _from_deltas(arm: Arm, deltas: tuple[tuple[float, float, float], ...]) -> Any:
    """Return the coordinates [rad] that length changes of three muscles in each section ask for.

    Raises:
        InputError: another number of muscles, or changes that no arcs have.
    """
    import numpy as np

    from contarm_sim.kinematics import arc, muscles
    from contarm_sim.mechanics import routing

    counts = [line.count for line in arm.routings]
    if counts != [3] * len(deltas):
        said = f"{len(deltas)} time{'s' * (len(deltas) != 1)}"
        has = f"this arm's sections have {', '.join(map(str, counts))} muscles"
        allowed = f"once for each section, if all have three muscles ({has}); else give --bend"
        raise InputError("--deltas", f"given {said}", allowed)
    if len(counts) == 1 and muscles.evenly_spaced(arm.routing.angles):
        return muscles.bend_from_deltas(deltas[0], arm.muscle_radius, DELTA_TOLERANCE, arm.routing.angles)[0]
    bend, residual = routing.bend_from_arc_deltas(np.ravel(deltas), arm)
    if np.abs(residual).max() > DELTA_TOLERANCE:
        given = f"({', '.join(f'{x:.6g}' for x in np.ravel(deltas))}) m, off arcs by {np.abs(residual).max():.3g} m"
        raise InputError(
            "deltas", given, "length changes of arcs; of evenly spaced muscles they sum to 0 in each section"
        )
    arc.as_bend(bend.reshape(-1, 2))
    return bend
