"""`contarm equilibrium`: the static pose under any load."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

from contarm_sim import studies
from contarm_sim.cli.leaning import leaning
from contarm_sim.cli.options import Command, arm_options, json_option, muscles_from_words, muscles_option
from contarm_sim.cli.uncertain import sampled_arms, uncertain_option
from contarm_sim.errors import InputError
from contarm_sim.model.arm import Arm

if TYPE_CHECKING:
    from contarm_sim.statics.continuation import Method


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
@muscles_option(
    "off | deltas L1 L2 ... [m] | setpoints L1 L2 ... [m] | tensions T1 T2 ... [N] | pressures P1 P2 ... [Pa] | "
    "bend ANGLE PLANE ... [rad]."
)
@click.option(
    "--file", metavar="LOADS.json", help="A list of cases (gravity, payload, wrenches, ...) instead of flags."
)
@click.option("--xi", type=float, multiple=True, metavar="X ...", help="Also interpolate the pose at these stations.")
@click.option(
    "--method", type=click.Choice(["auto", "newton", "pseudo-transient"]), default="auto", show_default=True,
    help="auto: Newton, then load continuation.",
)  # fmt: skip
@click.option("--extrapolate", is_flag=True, help="Improve poses by Richardson's extrapolation from half the links.")
@uncertain_option
@click.option(
    "--out", metavar="FOLDER",
    help="With --uncertain: where to leave the cases as a table, summary.json and figures; must not exist yet.",
)  # fmt: skip
@json_option
@arm_options
def equilibrium(arm: Arm, wrench: Any, follower_moment: Any, actuation_moment: Any, muscles: str, file: str | None,
                xi: tuple[float, ...], method: Method, extrapolate: bool, uncertain_file: str | None, out: str | None,
                as_json: bool) -> int:  # fmt: skip
    """Find the static pose of the arm under its weight, payload and loads; vectors in the base frame.

    Exit code 1 if a case has no stable equilibrium that the load leads to.

    \b
    contarm equilibrium --gravity -9.81 0 0
    contarm equilibrium --wrench 1 0.2 0 0 0 0 0 --wrench 0.5 0 0.1 0 0 0 0 --json
    contarm equilibrium --muscles "bend 1.5 0" --gravity 0 0 9.81 --payload 0.1
    contarm equilibrium --muscles "pressures 500000 200000 200000"
    contarm equilibrium --arm two.toml --muscles "bend 1.5 0 1 1.57"
    contarm equilibrium --file loads.json --json
    contarm equilibrium --muscles "bend 1.5 0" --gravity 0 0 9.81 --uncertain FILE.toml --out runs/tips

    A case in a file: {"gravity": [0, 0, 9.81], "payload": 0.1, "wrenches": [{"xi": 1, "force": [0.2, 0, 0]}],
    "follower_moment": [0, 0, 0], "actuation_moment": [0, 0.05], "muscles": {"kind": "off"}}.

    Among objects ([[object]] in the arm's TOML) it is a pose that may lean on them, with the contact forces: rigid and
    without friction, and it says how far friction could hold the tip from there. Free objects are held where they are.

    --uncertain takes the same file as `contarm run`, and gives percentiles of the tip's place, of its distance from the
    nominal tip and of the tensions. Servos get the set-points that would hold the bend of the nominal arm, the one you
    believe in.
    """
    from contarm_sim.model.load import Load, Wrench
    from contarm_sim.results.document import document
    from contarm_sim.view.report.output import to_json

    if file is not None:
        if wrench or any(follower_moment) or any(actuation_moment) or muscles != "off":
            raise InputError("input", "both --file and loads as flags", "either --file, or flags")
        cases = studies.read_cases(file, arm)
    else:
        wrenches = tuple(Wrench(xi=w[0], force=w[1:4], moment=w[4:]) for w in wrench)
        load = Load(
            wrenches=wrenches,
            follower_moment=follower_moment,
            actuation_moment=actuation_moment,
            muscles=muscles_from_words(muscles),
        )
        cases = (studies.LoadCase(arm, load),)
    if uncertain_file is not None:
        given = {
            "--file": (file, "sampled arms are of one load, given as flags"),
            "--extrapolate": (extrapolate, "sampled arms are not extrapolated"),
            "--xi": (xi, "of sampled arms the tip alone is given"),
        }
        for name, (value, why) in given.items():
            if value:
                raise InputError("uncertain", f"beside {name}", f"one of the two: {why}")
        return sampled_arms(arm, cases[0].load, uncertain_file, method, out, as_json)
    if out is not None:
        raise InputError("out", out, "with --uncertain only")
    found = studies.cases_at_rest(cases, method, extrapolate, xi)
    if as_json:
        click.echo(to_json(document(found if file is not None else found[0])))
    else:
        _show(found, [case.arm for case in cases])
    return 0 if all(case.stable for case in found) else 1


def _show(found: tuple[studies.CaseAtRest | studies.CaseWithoutRest, ...], arms: list[Arm]) -> None:

    for number, (case, arm) in enumerate(zip(found, arms, strict=True), 1):
        head = f"case {number}: " if len(found) > 1 else ""
        if isinstance(case, studies.CaseWithoutRest):
            click.echo(f"{head}no equilibrium: {case.error}")
            continue
        click.echo(f"{head}tip {_millimetres(case.tip)} mm; {_muscles(case, arm)}")
        if case.trust is not None:
            off = case.trust.error_estimate
            may = f"perhaps {1e3 * off:.2g} mm" if math.isfinite(off) else "an unknown amount"
            kind = "extrapolated" if case.trust.trusted else "NOT EXTRAPOLATED: too few links for the order to show"
            click.echo(f"{kind}; the tip is off by {may}")
        if case.beyond:
            click.echo(f"real muscles cannot: {case.beyond}")
        if case.held is False:
            click.echo("NOT HELD: a length servo is at a limit: it pulls with the blocked force, or cannot push")
        for line in leaning(case, arm):
            click.echo(line)
        click.echo(_stability(case))
        if case.places is not None:
            for xi, pose in zip(case.places.xi, case.places.poses, strict=True):
                click.echo(f"xi = {xi:g}: {_millimetres(pose[:3, 3])} mm")


def _millimetres(point: Iterable[float]) -> str:
    return "  ".join(f"{1e3 * x + 0.0:.4f}" for x in point)


def _muscles(case: studies.CaseAtRest, arm: Arm) -> str:
    """Return tensions and the pressures that they take, sections apart by a bar."""
    from contarm_sim.studies.needs import by_pressure

    if not case.muscle_tensions.any():
        return "no muscle pulls"
    tensions = _by_section([f"{x + 0.0:.2f}" for x in case.muscle_tensions], arm)
    if not by_pressure(arm):
        return f"muscles {tensions} N"
    pressures = [f"{p / 1e3:.0f}" if math.isfinite(p) else "too much" for p in case.muscle_pressures]
    return f"muscles {tensions} N, which takes {_by_section(pressures, arm)} kPa"


def _by_section(words: list[str], arm: Arm) -> str:
    """Return words, one for each muscle, with bars between the muscles of one section and of the next."""
    from contarm_sim.mechanics import muscles

    return "  |  ".join("  ".join(words[own]) for own in muscles.slices(arm))


def _stability(case: studies.CaseAtRest) -> str:
    stable = "stable" if case.stable else "UNSTABLE"
    if math.isfinite(case.growth) and case.growth > 0:
        stable += f" (flutters, disturbances grow by {case.growth:.2g} /s)"
    softest, residual = f"{case.smallest_eigenvalue:.3g} N m/rad", f"{case.residual:.1g} N m"
    took = f"{case.iterations} iterations, {1e3 * case.seconds:.1f} ms"
    return f"{stable}, softest mode {softest}; residual {residual} after {took}"
