"""Waiting for what another process does: long enough for a machine that is busy with other work."""

import time

PATIENCE = 300
"""Wall-clock time [s] after which something counts as never going to happen."""


def wait_for(condition, seconds=PATIENCE):
    """Wait until something is true and return it."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
    return found
