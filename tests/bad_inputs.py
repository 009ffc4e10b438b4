"""What is wrong with thousands of inputs, and what has to come of each: one short line."""

import numpy as np

from contarm_sim.errors import InputError
from contarm_sim.model.flat import MUSCLE_PARAMETERS, PARAMETERS

HUGE = 10**400
LONG = "9" * 20_000
WRONG = [
    "1", "", "x\ny", LONG, b"1", True, False, float("nan"), float("inf"), -float("inf"), HUGE, -HUGE, 1e10, -1e10, 1j,
    [], [1], {}, {"a": 1}, (1, 2), set(), object(), len, np.zeros(2), np.zeros((2, 2)), np.array("x"), np.array([None]),
    [[1, 2], [3]], range(3000),
]  # fmt: skip
"""Values that are no number of any parameter."""

TINY = [5e-324, 1e-308, 1e-100, 1e-12, -5e-324, -1e-12, -1]
"""Numbers that a parameter which is not negative cannot have."""


def refused(cases, made_by_chance=False):
    """Call every case and return those that end in anything else than an InputError of one short line."""
    failed, count = [], 0
    for label, call in cases:
        count += 1
        try:
            call()
        except InputError as error:
            text = str(error)
            if len(text) >= 400 or not text.isprintable():
                failed.append(f"{label}: {len(text)} characters: {text[:200]!r}")
        except Exception as error:
            failed.append(f"{label}: {type(error).__name__}: {str(error)[:200]}")
        else:
            if not made_by_chance:
                failed.append(f"{label}: accepted")
    print(f"{count} cases")
    return count, failed


def short(value):
    return repr(value)[:40] if not isinstance(value, int) or value.bit_length() < 100 else "huge"


def parameters():
    """Yield (table, name, declaration) of every parameter of a TOML file."""
    for table, declared in (("", PARAMETERS), ("muscle", MUSCLE_PARAMETERS)):
        for name, item in declared.items():
            yield table, name, item


def damaged_at_random(content, call, count):
    """Yield cases of a content with bytes changed, taken out, doubled, or its end cut off."""
    random = np.random.default_rng(1)
    for i in range(count):
        damaged, at = bytearray(content), int(random.integers(len(content)))
        if i % 4 == 0:
            damaged[at] ^= 1 << int(random.integers(8))
        elif i % 4 == 1:
            del damaged[at : at + int(random.integers(1, 30))]
        elif i % 4 == 2:
            damaged[at:at] = damaged[at : at + int(random.integers(1, 30))]
        else:
            damaged = damaged[:at]
        yield f"damaged {i}", lambda c=bytes(damaged): call(c)
