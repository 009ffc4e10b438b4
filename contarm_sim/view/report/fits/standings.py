"""How far a fit can be relied on: the boxes at the top of its page."""

from __future__ import annotations

import math

import numpy as np

from contarm_sim.identify.fitted import FOUND, Fit
from contarm_sim.view.report.fits.left_over import FITTED, HELD_OUT, pooled, repeatability
from contarm_sim.view.report.fits.words import how_many, millimetres, sentence
from contarm_sim.view.report.headline import Standing
from contarm_sim.view.report.outliers import outliers, without
from contarm_sim.view.report.outliers import told as counted

AGREE = 1e-2
"""Costs of two starts that differ by less [share] are the same optimum."""

_CLOSE = 0.9
"""Parameters that are correlated by more are hardly told apart."""

_WORSE = 1.5
"""Held-out errors that are larger than this many times the fitted ones are remarked on."""


def standings(fit: Fit) -> list[Standing]:
    """Say how far the fit can be relied on: what is determined, whether the search ended, how well it predicts."""
    return [_determined(fit), *_correlated(fit), _search(fit), *_prediction(fit)]


def _determined(fit: Fit) -> Standing:
    lost = [one.name for one in fit.parameters if one.status not in FOUND]
    bound = [one.name for one in fit.parameters if one.status == "at bound"]
    if len(lost) == len(fit.parameters):
        return Standing("bad", "The recording determines no parameter.", "The arm is as it was.")
    if lost:
        text = (f"{_ticked(_short(lost))}: what you would have to measure to find more is "
                "listed below.")  # fmt: skip
        unseen = f"; {len(fit.undetermined)} of {len(fit.parameters)} directions not seen" if fit.undetermined else ""
        title = f"{sentence(how_many(len(lost), 'parameter'))[:-1]} not determined{unseen}."
        return Standing("note", title, text)
    if bound:
        return Standing("note", f"{how_many(len(bound), 'parameter')} at a bound.",
                        f"{_ticked(bound)}: the data would rather have it beyond.")  # fmt: skip
    if any(one.status == "stopped early" for one in fit.parameters):
        return Standing("bad", "The search was stopped.", "Values are where it was; nothing is known of how far off.")
    weak = [one.name for one in fit.parameters if one.status == "weakly determined"]
    if weak:
        return Standing("note", f"{how_many(len(weak), 'parameter')} weakly determined.",
                        f"{_ticked(weak)}: see how wide the intervals are.")  # fmt: skip
    return Standing("good", "All free parameters are determined.", "Each is told apart from the others by the data.")


def _short(names: list[str]) -> list[str]:
    """Return names, with runs of numbered ones as one: slack_1 to slack_6."""
    runs: list[list[str]] = []
    for name in names:
        stem, _, number = name.rpartition("_")
        before = f"{stem}_{int(number) - 1}" if number.isdigit() else ""
        if runs and runs[-1][-1] == before:
            runs[-1].append(name)
        else:
            runs.append([name])
    return [f"{run[0]} to {run[-1].rpartition('.')[2]}" if len(run) > 2 else name
            for run in runs for name in (run[:1] if len(run) > 2 else run)]  # fmt: skip


def _correlated(fit: Fit) -> list[Standing]:
    """Name parameters that are determined, but whose errors nearly go together."""
    size = np.nan_to_num(np.abs(fit.correlation)) * (1 - np.eye(len(fit.parameters)))
    alike = np.flatnonzero((size > _CLOSE).any(axis=1))
    names = [fit.parameters[k].name for k in alike if fit.parameters[k].status in FOUND]
    if len(names) < 2:
        return []
    least = float(size[alike].max(axis=1).min())
    title = f"{sentence(how_many(len(names), 'parameter'))[:-1]} are hardly told apart."
    return [Standing("note", title, f"{_ticked(names)}: each is correlated with another by {least:.3g} or more, "
                                    "so one may be wrong as far as another is.")]  # fmt: skip


def _search(fit: Fit) -> Standing:
    how = f"{fit.method}, {fit.evaluations:,} evaluations in {fit.seconds:.3g} s."
    if not fit.converged:
        return Standing("bad", "The search did not converge.", f"{sentence(fit.message)} {how}")
    costs = np.array([cost for cost in fit.cost if math.isfinite(cost)])
    if len(fit.cost) < 2:
        return Standing("note", "The search converged, from one start.", f"More starts tell whether it is alone. {how}")
    same = int((costs <= costs.min() * (1 + AGREE)).sum())
    state = "good" if same > 1 else "note"
    title = f"The search converged; {same} of {len(fit.cost)} starts end at the best."
    return Standing(state, title, how if same > 1 else f"One start alone ends there: there may be better ones. {how}")


def _prediction(fit: Fit) -> list[Standing]:
    own, held = (without(pooled(fit, part)) for part in (FITTED, HELD_OUT))
    repeated = [f"The same command repeats to {millimetres(found[0])} mm rms."
                for found in map(repeatability, fit.left) if found]  # fmt: skip
    more = f" {repeated[0]}" if repeated else ""
    if not math.isfinite(held):
        return [Standing("note", "Nothing was held out.", f"`--hold-out` keeps blocks from the fit.{more}")]
    ratio = held / own if own else 1.0
    far = sum(int(outliers(pooled(fit, part)).sum()) for part in (FITTED, HELD_OUT))
    without_them = f", without {counted(far)}" if far else ""
    text = f"Held out {millimetres(held)} mm, fitted {millimetres(own)} mm rms{without_them}.{more}"
    if ratio > _WORSE:
        return [Standing("note", f"Held-out errors are {ratio:.2g} times the fitted ones.", text)]
    return [Standing("good", "What was held out is predicted as well as what was fitted.", text)]


def _ticked(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)
