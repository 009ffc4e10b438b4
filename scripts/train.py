"""Train a small policy on one of the tasks with stable-baselines3 (PPO), and score it beside the baseline and chance.

    pip install '.[train]'
    python scripts/train.py --task reach

The folder (learned-reach) has policy.zip, the learning curve as curve.csv and curve.png, and film.mp4, the learned
policy beside the baseline. Ctrl-C keeps what was learned; --resume learned-reach goes on from there.

It is a start, not a result: a two-layer network on flat observations, 64 arms side by side.
`PPO.load("learned-reach/policy.zip")` brings the policy back.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from contarm_sim import stopping
from contarm_sim.errors import ContarmError, InputError, MissingError
from contarm_sim.files import write_whole

ARMS, EPISODE = 64, 40
"""Arms side by side, and actions of each between two updates of the policy."""

EVALUATIONS = 20
"""Scores along the learning curve."""

FILMED = 4
"""Episodes in the film."""

LEARNING_RATE = 1e-3
"""At first; it falls evenly to a hundredth, and with it the spread of actions: precision comes last."""

SETTINGS = {"gamma": 0.9, "gae_lambda": 0.9, "n_epochs": 10}  # an action shows within a few control periods
NETWORK = {"net_arch": [128, 128], "log_std_init": -2.0}


def main() -> int:
    """Train, save, score, film; return the exit code."""
    given = _arguments()
    try:
        with stopping.listening():
            try:
                return _train(given)
            except KeyboardInterrupt:
                return stopping.exit_code()
    except (ContarmError, OSError) as error:
        print(f"train.py: {error}", file=sys.stderr)
        return 2


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", choices=("reach", "track", "hold"), help="what to learn (default reach)")
    parser.add_argument("--arm", help="a preset (paper, two, three, tendon) or a TOML file (default paper)")
    parser.add_argument(
        "--actions", choices=("bend", "lengths", "tensions", "pressures"), help="default the task's own"
    )
    parser.add_argument("--steps", type=int, help="actions to learn from, of all arms together (default 200000)")
    parser.add_argument("--seeds", type=int, help="episodes that scores are taken over (default 50)")
    parser.add_argument("--out", type=Path, help="the folder to make (default learned-TASK)")
    parser.add_argument("--resume", type=Path, metavar="FOLDER", help="go on in this folder; --steps may be larger")
    parser.add_argument("--no-film", action="store_true", help="write no film")
    return parser.parse_args()


def _train(given: argparse.Namespace) -> int:
    try:
        import torch
        from evaluations import Evaluations
        from stable_baselines3 import PPO

        from contarm_sim.envs.sb3 import ArmVecEnv
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] not in ("torch", "stable_baselines3", "gymnasium"):
            raise
        raise MissingError("stable-baselines3", "train") from None
    from contarm_sim.envs.definition import define
    from contarm_sim.envs.scores import POLICIES, score

    torch.set_num_threads(1)  # a network this small is slower on more
    folder, told = _resumed(given) if given.resume else _begun(given)
    definition = define(told["task"], folder / "arm.toml", told["actions"])
    envs = ArmVecEnv(ARMS, task=told["task"], arm=definition.arm, actions=told["actions"])
    if (folder / "policy.zip").exists():
        model = PPO.load(folder / "policy.zip", envs, device="cpu")
        print(f"going on after {model.num_timesteps:,} steps", flush=True)
    else:
        each = min(EPISODE, max(1, told["steps"] // ARMS))
        model = PPO(
            "MlpPolicy", envs, n_steps=each, batch_size=min(512, each * ARMS), seed=0, device="cpu",
            learning_rate=_falling, policy_kwargs=NETWORK, **SETTINGS,
        )  # fmt: skip

    def learned(observation: Any) -> Any:
        return np.asarray(model.predict(observation, deterministic=True)[0], float)

    evaluations = Evaluations(folder, told, lambda: score(definition, learned, told["seeds"]).summary, EVALUATIONS)
    with stopping.unbroken():  # the learning ends by itself on a signal, its policy saved
        model.learn(max(0, told["steps"] - model.num_timesteps), callback=evaluations, reset_num_timesteps=False)
        if stopping.came() is not None:
            again = f"python scripts/train.py --resume {folder}"
            print(f"stopped after {model.num_timesteps:,} steps, which are kept; go on with: {again}", file=sys.stderr)
    _tell(evaluations.points[-1], told)
    print(f"{folder}: policy.zip, curve.csv, curve.png after {evaluations.points[-1].seconds:.0f} s of learning")
    if not given.no_film:
        from policy_film import write_film

        print("filming ...", flush=True)
        policies = {"learned": learned, "baseline": POLICIES["baseline"](definition)}
        write_film(folder / "film.mp4", definition, policies, FILMED)
        print(f"{folder}/film.mp4: {FILMED} episodes, learned beside baseline")
    return 0


def _falling(left: float) -> float:
    """Return the learning rate when a share of the steps is left."""
    return LEARNING_RATE * max(left, 0.01)


def _begun(given: argparse.Namespace) -> tuple[Path, dict[str, Any]]:
    """Make the folder of a new run; return it and its settings."""
    from learning import NAMES

    from contarm_sim.envs.definition import define
    from contarm_sim.envs.scores import POLICIES, score
    from contarm_sim.model.arm_file import arm_to_toml

    told = {"task": given.task or "reach", "actions": given.actions}
    told |= {name: _count(name, getattr(given, name), usual) for name, usual in (("steps", 200_000), ("seeds", 50))}
    folder = given.out or Path(f"learned-{told['task']}")
    if folder.exists():
        raise InputError("out", str(folder), "a folder that is not there yet; --resume goes on in one that is")
    definition = define(told["task"], given.arm, told["actions"])
    print("scoring the baseline and chance ...", flush=True)
    told["scores"] = {name: score(definition, POLICIES[name](definition), told["seeds"]).summary for name in NAMES}
    told["length"] = definition.arm.length
    folder.mkdir(parents=True)
    write_whole(folder / "arm.toml", arm_to_toml(definition.arm))
    write_whole(folder / "settings.json", json.dumps(told, indent=2) + "\n")
    return folder, told


def _resumed(given: argparse.Namespace) -> tuple[Path, dict[str, Any]]:
    """Return the folder of an earlier run and its settings."""
    other = [name for name in ("task", "arm", "actions", "seeds", "out") if getattr(given, name) is not None]
    if other:
        raise InputError(
            "resume", f"given with --{other[0]}", "--steps and --no-film beside it; the folder has the rest"
        )
    folder = given.resume
    try:
        told = json.loads((folder / "settings.json").read_text())
    except (OSError, ValueError):
        raise InputError("resume", str(folder), "a folder that this script made") from None
    if given.steps is not None:
        told["steps"] = _count("steps", given.steps, 0)
        write_whole(folder / "settings.json", json.dumps(told, indent=2) + "\n")
    return folder, told


def _count(name: str, value: int | None, usual: int) -> int:
    if value is not None and value < 1:
        raise InputError(name, value, "a whole number, at least 1")
    return usual if value is None else value


def _tell(learned: Any, told: dict[str, Any]) -> None:
    """Print the scores, one line a policy."""
    for name, found in ({"learned": asdict(learned)} | told["scores"]).items():
        solved = f"solved {found['solved']} of {told['seeds']}"
        print(f"{name:9} reward {found['reward_mean']:.3f}, {solved}, mean error {1e3 * found['error_mean_m']:.2f} mm")


if __name__ == "__main__":
    sys.exit(main())
