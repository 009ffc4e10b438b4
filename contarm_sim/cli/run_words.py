"""What `contarm run` prints of a run."""

from __future__ import annotations

from typing import Any

import click

from contarm_sim.model.arm import Arm


def show_run(summary: dict[str, Any], arm: Arm) -> None:
    """Print the error budget of a run, its verdict, its remarks, and what is known of sampled arms."""
    from contarm_sim.cli.terminal import table
    from contarm_sim.view.report.contact_words import in_numbers
    from contarm_sim.view.report.words import budget, remarks, verdict_lines

    rows = [[name, *(f"{number:.4f}" for number in numbers)] for name, numbers in budget(summary)]
    title = f"{summary['path']}, {summary['duration']:g} s, controller {summary['controller']}"
    if summary["extrapolated"]:
        title += f", extrapolated from {arm.links} and {arm.links // 2} links"
    if "contact_error" in summary:
        title += "; parts but contact: without objects"
    table(title, ["", "max [mm]", "rms [mm]", "max [% L0]", "rms [% L0]"], rows)
    if "sections" in summary:
        _show_sections(summary["sections"])
    for name, words in verdict_lines(summary):
        click.echo(f"{name}: {words}")
    if "contact" in summary:
        click.echo(f"contact: {in_numbers(summary)}")
    muscle, degrees, speed = summary["muscle"], summary["orientation_error_deg"], summary["real_time_factor"]
    forces = f"{muscle['min_force_n']:.1f} to {muscle['max_force_n']:.1f} N"
    shares = f"pushes {100 * muscle['push_fraction']:.3g} %, slack {100 * muscle['slack_fraction']:.3g} %"
    click.echo(f"orientation error {degrees:.3f} deg max; muscles {forces}, {shares}; {speed:.3g} x real time")
    if "direction_error_deg" in summary:
        click.echo(f"direction of the tip: off by {summary['direction_error_deg']:.3f} deg at most")
    for remark in remarks(summary):
        click.echo(remark)
    if "uncertainty" in summary:
        from contarm_sim.cli import uncertain
        from contarm_sim.view.report.uncertainty_words import error_rows

        found = summary["uncertainty"]
        errors = [(f"tip error, {name} [mm]", values) for name, values in error_rows(found)]
        uncertain.show(found, errors, "mean", "the tip error's mean over time")


def _show_sections(sections: list[dict[str, Any]]) -> None:
    """Print the parts of the error section by section, and what the muscles of each did."""
    from contarm_sim.cli.terminal import table

    parts = ("discretisation", "servo", "shape")
    rows = []
    for own in sections:
        both = [f"{1e3 * own[part]['max_m']:.3f} ({own[part]['max_percent']:.3f})" for part in parts]
        muscle = own["muscle"]
        forces = "none" if muscle is None else f"{muscle['min_force_n']:.1f} .. {muscle['max_force_n']:.1f}"
        rows.append([str(own["section"]), *both, forces])
    columns = ["section", *(f"{part} [mm] ([%])" for part in parts), "muscles [N]"]
    table("what the tip moves by the parts of each section alone, largest values", columns, rows)
