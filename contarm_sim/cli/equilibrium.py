"""`contarm equilibrium`: the static pose under any load."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, json_option, muscles_from_words, muscles_option
from contarm_sim.errors import ConvergenceError, InputError
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@click.option(
    "--wrench", type=float, nargs=7, multiple=True, metavar="XI FX FY FZ MX MY MZ",
    help="Dead force [N] and couple [N m] at a backbone station, 0 base to 1 tip; repeatable.",
)  # fmt: skip
@click.option(
    "--follower-moment", type=float, nargs=3, default=(0.0, 0.0, 0.0), metavar="MX MY MZ",
    help="Couple at the tip that turns with it [N m].",
)  # fmt: skip
@click.option(
    "--actuation-moment", type=float, nargs=2, default=(0.0, 0.0), metavar="MX MY",
    help="Uniform bending moment, fixed in the material frame, as ideal muscles make it [N m].",
)  # fmt: skip
@muscles_option("off | deltas L1 L2 L3 [m] | tensions T1 T2 T3 [N] | pressures P1 P2 P3 [Pa] | bend ANGLE PLANE [rad].")
@click.option(
    "--file", metavar="LOADS.json", help="A list of cases (gravity, payload, wrenches, ...) instead of flags."
)
@click.option("--xi", type=float, multiple=True, metavar="X ...", help="Also interpolate the pose at these stations.")
@click.option(
    "--method", type=click.Choice(["auto", "newton", "pseudo-transient"]), default="auto", show_default=True,
    help="auto: Newton, then load continuation.",
)  # fmt: skip
@click.option("--extrapolate", is_flag=True, help="Improve poses by Richardson's extrapolation from half the links.")
@json_option
@arm_options
def equilibrium(arm: Arm, wrench: Any, follower_moment: Any, actuation_moment: Any, muscles: str, file: str | None,
                xi: tuple[float, ...], method: str, extrapolate: bool, as_json: bool) -> int:  # fmt: skip
    """Find the static pose of the arm under its weight, payload and loads; vectors in the base frame.

    Exit code 1 if a case has no stable equilibrium that the load leads to.

    \b
    contarm equilibrium --gravity -9.81 0 0
    contarm equilibrium --wrench 1 0.2 0 0 0 0 0 --wrench 0.5 0 0.1 0 0 0 0 --json
    contarm equilibrium --muscles bend 1.5 0 --gravity 0 0 9.81 --payload 0.1
    contarm equilibrium --muscles pressures 500000 200000 200000
    contarm equilibrium --file loads.json --json

    A case in a file: {"gravity": [0, 0, 9.81], "payload": 0.1, "wrenches": [{"xi": 1, "force": [0.2, 0, 0]}],
    "follower_moment": [0, 0, 0], "actuation_moment": [0, 0.05], "muscles": {"kind": "off"}}.
    """
    from contarm_sim.model.load import Load, Wrench
    from contarm_sim.view.report.output import to_json

    if extrapolate and method != "auto":
        raise InputError("method", f"{method} beside --extrapolate", "--extrapolate with the method auto")
    if any(not 0 <= x <= 1 for x in xi):
        raise InputError("xi", list(xi), "0 (base) to 1 (tip)")
    if file is not None:
        if wrench or any(follower_moment) or any(actuation_moment) or muscles != "off":
            raise InputError("input", "both --file and loads as flags", "either --file, or flags")
        cases = _read(file, arm)
    else:
        wrenches = tuple(Wrench(xi=w[0], force=w[1:4], moment=w[4:]) for w in wrench)
        load = Load(
            wrenches=wrenches,
            follower_moment=follower_moment,
            actuation_moment=actuation_moment,
            muscles=muscles_from_words(muscles),
        )
        cases = [(arm, load)]
    results = [
        _solve(case, method, extrapolate, xi, None if file is None else f"{file}, case {number}")
        for number, case in enumerate(cases, 1)
    ]
    if as_json:
        click.echo(to_json(results if file is not None else results[0]))
    else:
        _show(results)
    return 1 if any("error" in result or not result["stable"] for result in results) else 0


def _read(file: str, arm: Arm) -> list[tuple[Arm, Any]]:
    import json

    from contarm_sim.model.load import load_from_dict

    allowed = "a JSON list of load cases"
    try:
        cases = json.loads(Path(file).read_bytes().decode())
    except OSError as error:
        raise InputError("file", f"unreadable ({error.strerror})", allowed, file) from error
    except UnicodeDecodeError as error:
        raise InputError("file", "not text", allowed, file) from error
    except (ValueError, RecursionError) as error:
        raise InputError("file", f"not JSON ({error})", allowed, file) from error
    if not isinstance(cases, list) or not cases:
        raise InputError("file", "no list, or an empty one", allowed, file)
    found = []
    for number, case in enumerate(cases, 1):
        load, changes = load_from_dict(case, f"{file}, case {number}")
        try:
            found.append((replace(arm, **changes), load))
        except InputError as error:
            raise error.located(f"{file}, case {number}") from None
    return found


def _solve(
    case: tuple[Arm, Any], method: str, extrapolate: bool, xi: tuple[float, ...], where: str | None
) -> dict[str, Any]:
    import numpy as np

    from contarm_sim.statics.equilibrium import equilibrium
    from contarm_sim.statics.extrapolation import extrapolated, interpolate

    arm, load = case
    try:
        found: Any = extrapolated(arm, load)[0] if extrapolate else equilibrium(arm, load, method)
    except ConvergenceError as error:
        return {"error": str(error), "stable": False}
    except InputError as error:
        raise error.located(where) from None
    result = {
        "tip": found.tip.tolist(),
        "transform": found.frames[-1].tolist(),
        "backbone": {"centres": found.frames[:, :3, 3].tolist(), "frames": found.frames.tolist()},
        "muscle_lengths": found.muscle_lengths.tolist(),
        "muscle_tensions": found.muscle_tensions.tolist(),
        "muscle_pressures": [p if np.isfinite(p) else None for p in found.pressures_needed(arm).tolist()],
        "tip_compliance": found.tip_compliance.tolist(),
        "residual": found.residual,
        "stable": found.stable,
        "smallest_eigenvalue": found.smallest_eigenvalue,
        "growth": found.growth if np.isfinite(found.growth) else None,
        "held": found.held,
        "beyond": _beyond(arm, found),
        "iterations": found.iterations,
        "seconds": found.seconds,
    }
    if extrapolate:
        result["trusted"] = found.trusted
        result["error_estimate"] = found.error if np.isfinite(found.error) else None
    if xi:
        result["xi"], result["poses"] = list(xi), interpolate(found.frames, arm.length, np.array(xi)).tolist()
    return result


def _beyond(arm: Arm, found: Any) -> str:
    """Say what real muscles have not got, of force or pressure; empty if they have."""
    most, force = arm.muscle.max_pressure, arm.muscle.blocked_force
    pressure, tension = float(found.pressures_needed(arm).max()), float(found.muscle_tensions.max())
    if tension > force:
        return f"a muscle pulls with {tension:.4g} N, more than its blocked force, {force:.0f} N"
    if pressure > most * (1 + 1e-9):
        needs = f"{pressure / 1e3:.0f} kPa" if math.isfinite(pressure) else "more than any pressure"
        return f"a muscle needs {needs}, more than the {most / 1e3:.0f} kPa there are"
    return ""


def _show(results: list[dict[str, Any]]) -> None:
    for number, result in enumerate(results, 1):
        head = f"case {number}: " if len(results) > 1 else ""
        if "error" in result:
            click.echo(f"{head}no equilibrium: {result['error']}")
            continue
        tip = "  ".join(f"{1e3 * x + 0.0:.4f}" for x in result["tip"])
        tensions = "  ".join(f"{x + 0.0:.2f}" for x in result["muscle_tensions"])
        stable = "stable" if result["stable"] else "UNSTABLE"
        if (result["growth"] or 0.0) > 0:
            stable += f" (flutters, disturbances grow by {result['growth']:.2g} /s)"
        pressures = "  ".join("too much" if p is None else f"{p / 1e3:.0f}" for p in result["muscle_pressures"])
        muscles = (
            f"muscles {tensions} N, which takes {pressures} kPa"
            if any(result["muscle_tensions"])
            else "no muscle pulls"
        )
        click.echo(f"{head}tip {tip} mm; {muscles}")
        if "trusted" in result:
            off = result["error_estimate"]
            may = "an unknown amount" if off is None else f"perhaps {1e3 * off:.2g} mm"
            kind = "extrapolated" if result["trusted"] else "NOT EXTRAPOLATED: too few links for the order to show"
            click.echo(f"{kind}; the tip is off by {may}")
        if result["beyond"]:
            click.echo(f"real muscles cannot: {result['beyond']}")
        if result["held"] is False:
            click.echo("NOT HELD: a length servo is at a limit: it pulls with the blocked force, or cannot push")
        softest, residual = f"{result['smallest_eigenvalue']:.3g} N m/rad", f"{result['residual']:.1g} N m"
        took = f"{result['iterations']} iterations, {1e3 * result['seconds']:.1f} ms"
        click.echo(f"{stable}, softest mode {softest}; residual {residual} after {took}")
        for x, pose in zip(result.get("xi", ()), result.get("poses", ()), strict=True):
            click.echo(f"xi = {x:g}: " + "  ".join(f"{1e3 * row[3] + 0.0:.4f}" for row in pose[:3]) + " mm")
