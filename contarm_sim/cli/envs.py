"""`contarm envs`: the tasks for people who train and control, and what a learner has to beat."""

from __future__ import annotations

from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option
from contarm_sim.errors import MissingError
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--seeds", type=click.IntRange(1, 10_000), default=100, show_default=True, help="Episodes a score is taken over."
)
@click.option(
    "--actions",
    type=click.Choice(["bend", "lengths", "tensions", "pressures"]),
    help="Action mode; default each task's own.",
)
@click.option("--no-scores", is_flag=True, help="List the tasks only.")
@json_option
@arm_options
def envs(arm: Arm, seeds: int, actions: Any, no_scores: bool, as_json: bool) -> None:
    """List the tasks, their spaces, and the scores of the closed-form baseline and of chance.

    Reward is the mean of an episode's actions, at most 1; the error is taken at an episode's end, of `track` the root
    mean square after its first second, of `grasp` the height that lacks; solved is an error within 1 % of length (of
    `hold` with the stiffness asked for, of `grasp` with the object up for a second). With gravity or payload `track`
    solves statics at every step, which takes minutes. `hold` is for arms of one section, `grasp` for several that hang
    in a world with one free object; where no arm is given, `grasp` has that of its demonstration.

    \b
    contarm envs --no-scores
    contarm envs --seeds 20 --gravity 0 0 9.81
    contarm envs --actions pressures
    """
    try:
        from contarm_sim.envs.definition import TASKS, define
        from contarm_sim.envs.registration import NAMES
        from contarm_sim.envs.scores import POLICIES, score
    except ModuleNotFoundError as error:
        if not (error.name or "").startswith("gymnasium"):
            raise
        raise MissingError("gymnasium", "gym") from None
    from contarm_sim.cli.terminal import progress, table
    from contarm_sim.view.report.output import to_json

    found = []
    own = {name: kind.usual() if arm == Arm() else arm for name, kind in TASKS.items()}
    needs = {name: needed for name, kind in TASKS.items() if (needed := kind.needs(own[name])) is not None}
    for name in [name for name in TASKS if name not in needs]:
        definition = define(name, own[name], actions if actions in TASKS[name].modes else None)
        row: dict[str, Any] = {
            "task": name,
            "gymnasium": NAMES[name],
            "dm_control": name,
            "mode": definition.actions.mode,
            "scores": {},
        }
        row |= {"actions": list(definition.task.modes), "action_size": definition.actions.size}
        row |= {"observation": definition.sizes, "observation_size": definition.size, "steps": definition.ticks}
        for policy, make in POLICIES.items() if not no_scores else ():
            with progress(f"{name}, {policy}") as show:
                row["scores"][policy] = score(definition, make(definition), seeds, show).summary
        found.append(row)
    if as_json:
        left_out = {"left_out": {name: f"needs {needed}" for name, needed in needs.items()}} if needs else {}
        click.echo(to_json({"seeds": None if no_scores else seeds, "tasks": found} | left_out))
        return
    table(
        "tasks", ["task", "Gymnasium", "actions", "observation", "steps", "action modes"], [_task(row) for row in found]
    )
    for name, needed in needs.items():
        click.echo(f"{name} needs {needed}")
    if not no_scores:
        columns = ["task", "policy", "reward", "solved", "error, mean [mm]", "error, largest [mm]"]
        rows = [_score(row, policy, seeds) for row in found for policy in row["scores"]]
        driven = f", by {actions} where a task takes them" if actions is not None else ""
        table(f"scores over {seeds} seeds{driven}", columns, rows)


def _task(row: dict[str, Any]) -> list[str]:
    sizes = (str(row["action_size"]), str(row["observation_size"]), str(row["steps"]))
    return [row["task"], row["gymnasium"], *sizes, ", ".join(row["actions"])]


def _score(row: dict[str, Any], policy: str, seeds: int) -> list[str]:
    got = row["scores"][policy]
    errors = (f"{1e3 * got[name]:.2f}" for name in ("error_mean_m", "error_largest_m"))
    return [row["task"], policy, f"{got['reward_mean']:.3f}", f"{got['solved']} of {seeds}", *errors]
