"""`contarm doctor`: what this machine has, and what a headless user needs where something is missing."""

from __future__ import annotations

from typing import Any

import click

from contarm_sim.cli.options import Command, json_option
from contarm_sim.processors import processors


@click.command(cls=Command)
@json_option
def doctor(as_json: bool) -> int:
    """Report versions, cores, GL backends tried (and why each failed), the video encoder, and what steps on a GPU.

    Exit code 1 if pictures or video cannot be made here; numbers can all the same.
    """
    from contarm_sim.versions import versions
    from contarm_sim.view.report.output import to_json

    found: dict[str, Any] = {"versions": versions(), "cores": processors(), "gl": _gl(), "encoder": _encoder()}
    found["warp"] = _warp()
    found["verdict"] = "pass" if found["gl"]["backend"] and found["encoder"]["works"] else "fail"
    if as_json:
        click.echo(to_json(found))
    else:
        for package, version in found["versions"].items():
            click.echo(f"{package:12} {version}")
        click.echo(f"{'cores':12} {found['cores']}")
        for name, reason in found["gl"]["attempts"]:
            click.echo(f"{'gl ' + name:12} {'works' if reason is None else 'fails: ' + reason}")
        if found["gl"]["backend"] is None:
            click.echo(f"{'pictures':12} {found['gl']['error']}")
        click.echo(f"{'encoder':12} {found['encoder']['version'] or found['encoder']['error']}")
        click.echo(f"{'gpu':12} {found['warp']['device'] or found['warp']['error']}")
    return 0 if found["verdict"] == "pass" else 1


def _gl() -> dict[str, Any]:
    from contarm_sim.errors import RenderingError
    from contarm_sim.view.rendering.gl import choose_backend

    try:
        backend = choose_backend()
    except RenderingError as error:
        return {
            "backend": None,
            "attempts": [list(attempt) for attempt in getattr(error, "attempts", ())],
            "error": str(error),
        }
    return {"backend": backend.name, "attempts": [list(attempt) for attempt in backend.attempts], "error": None}


def _encoder() -> dict[str, Any]:
    import subprocess

    from contarm_sim.errors import RenderingError
    from contarm_sim.view.rendering.video import encoder

    try:
        program = encoder()
        done = subprocess.run([program, "-version"], capture_output=True, text=True, timeout=20, check=True)
    except (RenderingError, OSError, subprocess.SubprocessError) as error:
        return {"works": False, "version": None, "program": None, "error": str(error)}
    return {"works": True, "version": done.stdout.splitlines()[0], "program": program, "error": None}


def _warp() -> dict[str, Any]:
    """Ask in a process of its own: Warp writes to stderr that there is no driver, and its libraries are large."""
    import subprocess
    import sys

    code = """
from contarm_sim.engine.warp_library import described
from contarm_sim.errors import ContarmError
try:
    print(described())
except ContarmError as error:
    raise SystemExit(str(error))
"""
    try:
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    except (OSError, subprocess.SubprocessError) as error:
        return {"works": False, "device": None, "error": str(error)}
    said = (done.stdout if done.returncode == 0 else done.stderr).strip().splitlines() or ["Warp cannot be started"]
    return {
        "works": done.returncode == 0,
        "device": said[-1] if done.returncode == 0 else None,
        "error": None if done.returncode == 0 else said[-1],
    }
