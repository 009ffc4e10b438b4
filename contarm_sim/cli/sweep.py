"""`contarm sweep`: many cases of an arm, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from contarm_sim.cli.options import Command, json_option

if TYPE_CHECKING:
    from contarm_sim.sweeps import Sweep
    from contarm_sim.sweeps.run import Runner


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC", required=False)
@click.option("--out", metavar="FOLDER", help="Where the table is kept. Default: runs/sweep-NAME of SPEC.")
@click.option(
    "--processes", type=click.IntRange(1, 4096), metavar="N", help="Worker processes; default one for each core."
)
@click.option("--workers", type=click.IntRange(1, 4096), metavar="N", help="Dask workers here, with a dashboard.")
@click.option("--scheduler", metavar="ADDRESS", help="A Dask scheduler, tcp://HOST:PORT, or the .json file it wrote.")
@click.option("--backend", metavar="NAME", help="What steps motions; default what SPEC says, or cpu.")
@click.option(
    "--names", is_flag=True, help="List what cases of SPEC may differ in, and which quantities there are; run nothing."
)
@json_option
def sweep(
    spec: str | None,
    out: str | None,
    processes: int | None,
    workers: int | None,
    scheduler: str | None,
    backend: str | None,
    names: bool,
    as_json: bool,
) -> int:
    """Run many cases of an arm, and keep parameters and results as a table (Parquet), one row a case.

    SPEC is a TOML file, or the name of a sweep that comes with the package: soft, validity. Ctrl-C, a full disk or a
    killed process lose a few seconds of work; the same command goes on from there. The same SPEC gives the same
    table, bit for bit. Exit code 1 if no case went well.

    This is soft.toml, which takes some 10 s: `contarm sweep soft` runs it; save it, change it, and run yours.

    \b
        run = "rest"      # poses at rest beside arcs; or equilibrium, motion
        arm = "paper"     # or another preset, or "my_arm.toml" beside this file
        design = "grid"   # or latin-hypercube, sobol, sobol-indices
        ask = [           # left out: all
          "tip_error_max_percent", "sag_max_percent", "tension_max",
          "weight_over_stiffness",
        ]
        [fixed]
        gravity = [0, 0, 9.81]  # hanging
        links = 12
        [vary]
        bending_stiffness = { from = 0.05, to = 2, count = 20, scale = "log" }
        payload = [0, "50 g", "100 g"]    # has no weight without gravity
        controller = ["servo", "paper"]
        # not in a grid:
        # mass = { distribution = "normal", mean = "300 g", std = "5 %" }

    \b
    contarm sweep soft
    contarm sweep soft --names             what could be varied and asked for
    contarm sweep my.toml --processes 1 --json
    contarm sweep my.toml --scheduler tcp://node1:8786        on a Dask cluster
    contarm sweep validity                 the validity chart of the README

    \b
    In Python: contarm_sim.sweeps.load("runs/sweep-soft").table, or
    .column("tip_error_max_percent")
    """
    from contarm_sim import sweeps
    from contarm_sim.cli.pace import pace
    from contarm_sim.cli.terminal import say
    from contarm_sim.errors import ContarmError, InputError
    from contarm_sim.stopping import exit_code
    from contarm_sim.sweeps.run import default_folder
    from contarm_sim.sweeps.statuses import OK

    if spec is None:
        raise InputError("SPEC", "missing", "a TOML file, or soft, validity (see contarm sweep --help)")
    asked = sweeps.read(spec, backend)
    if names:
        _show_names(asked, as_json)
        return 0
    runner = _runner(processes, workers, scheduler)
    folder, done = out if out is not None else str(default_folder(asked)), -1

    def on_done(count: int, total: int) -> None:
        nonlocal done
        if done < 0 < count:
            say(f"{count:,} of {total:,} cases are there already")
        done = count
        show(count, total)

    def kept() -> str:
        if done <= 0:
            return "no case is done"
        return f"{done:,} of {asked.cases:,} cases are done; the same command goes on from there: {folder}"

    try:
        with pace(f"sweep {asked.name}") as show:
            found = sweeps.sweep(asked, folder, processes, on_done, runner)
    except KeyboardInterrupt:
        say(f"contarm: interrupted; {kept()}")
        return exit_code()
    except OSError as error:
        if isinstance(error, ContarmError):
            raise
        say(f"contarm: cannot write: {error.strerror or error}; {kept()}")
        return 1
    except ContarmError as error:
        if isinstance(error, InputError) or done < 0:
            raise
        say(f"contarm: {error}; {kept()}")
        return 1
    summary = _summary(found)
    if as_json:
        from contarm_sim.view.report.output import to_json

        click.echo(to_json(summary))
    else:
        _show(found, summary)
    say(f"written: {folder}")
    return 0 if found.counts.get(OK) else 1


def _runner(processes: int | None, workers: int | None, scheduler: str | None) -> Runner | None:
    """Return what runs chunks; None for processes without Dask."""
    from contarm_sim.cli.terminal import say
    from contarm_sim.errors import InputError

    given = {"--processes": processes, "--workers": workers, "--scheduler": scheduler}
    names = [name for name, value in given.items() if value is not None]
    if len(names) > 1:
        raise InputError(names[0], f"given beside {' and '.join(names[1:])}", "one of them")
    if workers is None and scheduler is None:
        return None
    from contarm_sim.sweeps.cluster import on_scheduler, on_workers

    return on_scheduler(scheduler, say) if scheduler is not None else on_workers(workers or 1, say)


def _summary(found: Sweep) -> dict[str, Any]:
    """Return the sweep in numbers: of each quantity the least, the median and the largest."""
    from contarm_sim.cli.terminal import command_line
    from contarm_sim.sweeps.quantities import QUANTITIES
    from contarm_sim.versions import versions

    quantities: dict[str, Any] = {}
    for name in found.spec.ask:
        count, *middle = found.middle(name)
        of = dict(zip(_COLUMNS, middle or [None] * 3, strict=True))
        quantities[name] = {"unit": QUANTITIES[found.spec.run][name].unit, "cases": count} | of
    return {
        "sweep": found.spec.name,
        "folder": str(found.folder),
        "cases": found.spec.cases,
        "status": found.counts,
        "ok_but_not": found.short,
        "quantities": quantities,
        "key": found.spec.key,
        "versions": versions(),
        "command": command_line(),
    }


def _show(found: Sweep, summary: dict[str, Any]) -> None:
    from contarm_sim.cli.terminal import table
    from contarm_sim.sweeps.statuses import OK
    from contarm_sim.sweeps.table import LACKING

    spec = found.spec
    told = summary["quantities"]
    rows = [_row(name, of) for name, of in told.items() if f"{name}_percent" not in told]
    click.echo(
        f"{spec.cases:,} case{'s' * (spec.cases != 1)} of {spec.run!r}, {spec.design} over {', '.join(spec.vary)}"
    )
    table("", ["quantity", "unit", "least", "median", "largest"], rows)
    click.echo(", ".join(f"{count:,} {status}" for status, count in found.counts.items()))
    for name, count in found.short.items():
        click.echo(f"{count:,} of the {found.counts[OK]:,} ok {LACKING[name]}")


_COLUMNS = ("min", "median", "max")


_NOTHING = 1e-9
"""Shares of length [%] and distances [mm] below are rounding, and printed as 0."""


def _row(name: str, of: dict[str, Any]) -> list[str]:
    """Return a row of the table, in units that people read."""
    from contarm_sim.view.report.sweeps.columns import READ

    factor, unit = READ.get(of["unit"], (1.0, of["unit"]))
    if name.endswith("_percent"):
        unit = "% of length"
    least = _NOTHING if unit in ("mm", "% of length") else 0.0
    numbers = [None if of[key] is None else factor * float(of[key]) for key in _COLUMNS]
    return [name, unit, *("" if x is None else "0" if abs(x) < least else f"{x:.4g}" for x in numbers)]


def _show_names(spec: Any, as_json: bool) -> None:
    from contarm_sim.sweeps.quantities import QUANTITIES

    if as_json:
        from contarm_sim.view.report.output import to_json

        told = {one.name: {"unit": one.unit, "values": one.meant} for one in spec.known.values() if not one.idle}
        asked = {one.name: {"unit": one.unit, "meaning": one.meaning} for one in QUANTITIES[spec.run].values()}
        click.echo(to_json({"run": spec.run, "parameters": told, "quantities": asked}))
        return
    click.echo(f"Cases may differ in (run = {spec.run!r}):")
    for one in spec.known.values():
        if one.idle:
            continue
        click.echo(f"  {one.name:32} {one.unit:8} {one.meant}".rstrip())
    click.echo("Quantities:")
    for quantity in QUANTITIES[spec.run].values():
        click.echo(f"  {quantity.name:32} {quantity.unit:8} {quantity.meaning}")
