"""Errors reach other processes as they are."""

import pickle

import pytest

from contarm_sim import errors

MADE = {
    errors.InputError: ("a", 1, "b", "there"),
    errors.UnreachableError: ((0.1, 0.0, 0.2), 0.1, (0.0, 0.0, 0.2), 1e-6, 0, "there", "mm?"),
    errors.BlockedError: ("none is clear", 1e-3, 5e-3, "post"),
    errors.PressureError: ("bend", "much", "less", 9e5),
    errors.DivergenceError: (0.1, 2, "joint", {"timestep": 0.001}),
    errors.Interrupted: ([1, 2],),
    errors.InterruptedMany: ([None, 2],),
    errors.MissingError: ("pyarrow", "sweep"),
    errors.GuardError: ("changed", "2.0"),
}
EVERY = [kind for kind in vars(errors).values()
         if isinstance(kind, type) and issubclass(kind, BaseException) and kind is not errors._Sent]  # fmt: skip


@pytest.mark.parametrize("kind", EVERY, ids=lambda kind: kind.__name__)
def test_errors_are_the_same_in_another_process(kind):
    error = kind(*MADE.get(kind, ("text",)))
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind
    assert (str(again), again.args, repr(vars(again))) == (str(error), error.args, repr(vars(error)))
    assert vars(error) or kind in (errors.ContarmError, errors.RenderingError, errors.EncodingError)
