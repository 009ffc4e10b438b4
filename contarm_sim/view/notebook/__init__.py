"""Results in notebooks: tables and small pictures of them, figures, films and reports that show themselves.

Each function loads what it needs when it is called: a table loads neither matplotlib nor MuJoCo.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from contarm_sim.view.notebook.films import Film
    from contarm_sim.view.notebook.reports import Report
    from contarm_sim.view.style import Sheet


def html(result: Any) -> str:
    """Return what a notebook shows of a result."""
    from contarm_sim.view.notebook.cards import html as made

    return made(result)


def plot(samples: Any, *given: Any) -> Sheet:
    """Return a figure of a trajectory."""
    from contarm_sim.view.notebook.figures import plot as made

    return made(samples, *given)


def film(samples: Any, path: Any, **given: Any) -> Film:
    """Film a trajectory."""
    from contarm_sim.view.notebook.films import film as made

    return made(samples, path, **given)


def fit_figure(fit: Any, *given: Any) -> Sheet:
    """Return a figure of a fit."""
    from contarm_sim.view.notebook.fits import figure as made

    return made(fit, *given)


def fit_report(fit: Any, folder: Any) -> Report:
    """Report a fit."""
    from contarm_sim.view.notebook.fits import report as made

    return made(fit, folder)


def replay_figure(replay: Any, *given: Any) -> Sheet:
    """Return a figure of a replay."""
    from contarm_sim.view.notebook.replays import figure as made

    return made(replay, *given)


def replay_film(replay: Any, path: Any, **given: Any) -> Film:
    """Film a replay."""
    from contarm_sim.view.notebook.replays import film as made

    return made(replay, path, **given)


def replay_report(replay: Any, folder: Any, **given: Any) -> Report:
    """Report a replay."""
    from contarm_sim.view.notebook.replays import report as made

    return made(replay, folder, **given)


def report(samples: Any, folder: Any, **given: Any) -> Report:
    """Report a trajectory."""
    from contarm_sim.view.notebook.reports import report as made

    return made(samples, folder, **given)
