"""Waiting for what another process does: long enough for a machine that is busy with other work."""

import os
import time
from pathlib import Path

PATIENCE = 300
"""Wall-clock time [s] after which something counts as never going to happen."""


def wait_for(condition, seconds=PATIENCE):
    """Wait until something is true and return it."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
    return found


def processor_time(pid):
    """Return how long a process has computed [s], which tells how far it is on a machine that is busy, too."""
    after_name = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return sum(int(ticks) for ticks in after_name[11:13]) / os.sysconf("SC_CLK_TCK")
