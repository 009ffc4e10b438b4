"""What becomes of a case, in a word or two: the same words in tables of sweeps and of sampled arms."""

from __future__ import annotations

import numpy as np

from contarm_sim.errors import (
    ContarmError,
    DivergenceError,
    EquilibriumError,
    InputError,
    MissingError,
    NotConvergedError,
    PressureError,
    UnreachableError,
    UnstableError,
    one_line,
)

OK = "ok"
"""Status of a case that went well."""

UNSTABLE = "unstable"
"""Status of a pose at rest that an arm would not stay in."""

FAILED = "failed"
"""Status of a case whose numbers came to an end: divided by zero, say."""

_STATUS: tuple[tuple[type[Exception], str], ...] = (
    (NotConvergedError, "not converged"),
    (UnstableError, UNSTABLE),
    (EquilibriumError, "no equilibrium"),
    (PressureError, "too much pressure"),
    (UnreachableError, "out of reach"),
    (DivergenceError, "diverged"),
    (InputError, "bad input"),
    (ArithmeticError, FAILED),
    (np.linalg.LinAlgError, FAILED),
)
"""What is said of errors, the first that fits."""


def of_case(problem: BaseException) -> bool:
    """Tell an error that says what becomes of a case from one that a case has no part in: full memory, a fault here."""
    return isinstance(problem, (ContarmError, *(kind for kind, _ in _STATUS))) and not isinstance(problem, MissingError)


def status_of(problem: Exception | None, stable: bool = True) -> tuple[str, str]:
    """Return status and error text of a case, which is none where it went well.

    Args:
        problem: why it has no result, see `of_case`.
        stable: of a pose at rest: whether the arm would stay there.
    """
    if problem is None:
        return (OK, "") if stable else (UNSTABLE, "the arm would not stay in this pose")
    status = next((status for kind, status in _STATUS if isinstance(problem, kind)), FAILED)
    text = str(problem) if status != FAILED else f"{type(problem).__name__}: {problem}"
    return status, one_line(text, 400)
