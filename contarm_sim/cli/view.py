"""`contarm view`: the arm live, in a browser or in MuJoCo's own viewer."""

from __future__ import annotations

from typing import Any

import click

from contarm_sim.cli.options import Command, arm_options, controller_option, json_option
from contarm_sim.model.arm import Arm


@click.command(cls=Command)
@controller_option("To begin with.")
@click.option("--port", type=click.IntRange(1, 65535), help="Default: the first free one from 8080 on.")
@click.option("--open", "opened", is_flag=True, help="Open the page in the browser.")
@click.option("--native", is_flag=True, help="MuJoCo's own viewer instead of a page; needs a display.")
@json_option
@arm_options
def view(arm: Arm, controller: Any, port: int | None, opened: bool, native: bool, as_json: bool) -> None:
    """Steer the simulated arm by hand, beside its analytic ghost, until Ctrl-C.

    Serves a page on this machine alone (127.0.0.1): drag the ring over the dome of reachable tips, or use the sliders;
    change arm, controller, co-contraction, gravity and payload while it moves; record what it does, which leaves a
    folder in runs/ as `contarm run` does. From another machine, forward the port first: ssh -L 8080:127.0.0.1:8080
    HOST. The controller `tip` feeds the seen tip back here, without the plan that `contarm run` makes beforehand.

    With --native, the arrow keys bend the arm, Space pauses, Backspace starts again.

    \b
    contarm view
    contarm view --controller pressure --gravity 0 0 9.81 --port 9000
    contarm view --native
    """
    from contarm_sim.cli.terminal import command_line, say

    if native:
        from contarm_sim.view.live.native import show

        show(arm, controller)
        return
    from contarm_sim.view.live.server import serve
    from contarm_sim.view.report.output import to_json

    def ready(url: str) -> None:
        if as_json:
            click.echo(to_json({"url": url}))
        say(f"the arm is at {url}; Ctrl-C ends")
        if opened:
            click.launch(url)

    serve(arm, controller, port, ready, say, command_line())
    say("ended")
