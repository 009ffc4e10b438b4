"""The option --uncertain of `run` and `equilibrium`, and what is printed of sampled arms."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from contarm_sim.stopping import break_off, unbroken

if TYPE_CHECKING:
    from contarm_sim.sweeps.uncertain import Uncertain
    from contarm_sim.sweeps.uncertain_motion import UncertainMotion
    from contarm_sim.sweeps.uncertain_pose import UncertainPose

HELP = (
    "Sample arms with parameters as distributed as this file says, all commanded as the nominal arm: percentiles, "
    "a band, and which parameter causes it."
)

uncertain_option = click.option("--uncertain", "uncertain_file", metavar="FILE.toml", help=HELP)


def read(file: str | None, arm: Any) -> Uncertain | None:
    """Return the uncertain parameters of an arm that a file describes, or None without a file.

    Raises:
        InputError: what is wrong with it.
    """
    if file is None:
        return None
    from contarm_sim.sweeps.uncertain import read_uncertain

    return read_uncertain(Path(file), arm)


def sampled(what: Callable[[Callable[[int, int], None]], Any]) -> Any:
    """Return what a function finds of sampled arms, given what to call after each; Ctrl-C ends it between two."""
    from contarm_sim.cli.terminal import progress

    with progress("sampled arms") as show, unbroken():

        def on_done(done: int, count: int) -> None:
            show(done, count)
            break_off()

        return what(on_done)


def motion_of(recorded: Any, uncertain: Uncertain, stepping: Any) -> UncertainMotion:
    """Return a recorded motion of sampled arms."""
    from contarm_sim.sweeps.uncertain_motion import uncertain_motion

    def on_tick(count: int) -> None:
        break_off()

    return sampled(
        lambda on_done: uncertain_motion(recorded, uncertain, stepping=stepping, on_done=on_done, on_tick=on_tick)
    )


def pose_of(arm: Any, load: Any, uncertain: Uncertain, method: Any) -> UncertainPose:
    """Return a static pose of sampled arms."""
    from contarm_sim.sweeps.uncertain_pose import uncertain_pose

    return sampled(lambda on_done: uncertain_pose(arm, load, uncertain, method, on_done=on_done))


def show(found: dict[str, Any], rows: Any, quantity: str, words: str) -> None:
    """Print what is known of sampled arms.

    Args:
        found: the document.
        rows: of what was found, as `error_rows` or `pose_rows` return them.
        quantity, words: whose causes are told.
    """
    from contarm_sim.cli.terminal import table
    from contarm_sim.view.report import uncertainty_words as said

    columns = ["nominal", "5 %", "median", "95 %"]
    table(said.cases_words(found), ["", *columns], [[name, *values] for name, values in rows])
    own = said.parameter_rows(found, quantity)
    shares = ["alone [%]", "with others [%]"]
    told = "reason" not in found["causes"][quantity]
    end = None if told else -2
    table("uncertain parameters", ["", *columns, *(shares if told else [])], [[name, *v[:end]] for name, v in own])
    click.echo(said.causes_words(found, quantity, words))
