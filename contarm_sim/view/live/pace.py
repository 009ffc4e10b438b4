"""How often the page is drawn: as often as leaves the simulation time to keep in step with the clock."""

from __future__ import annotations

MOST, LEAST = 30.0, 3.0
"""Pictures a second, at most and at least."""

_WINDOW = 1.0
"""Time over which one judges [s]."""

_LATE, _EARLY = 0.06, 0.025
"""Backlog [s] that is too much, and one that leaves room for more pictures."""

_DOWN, _UP = 0.6, 1.3
_PATIENCE, _MOST_PATIENCE = 4, 60
"""Good windows before more pictures are tried: at first, and after many tries that failed."""

_PLOTS = 4
"""Pictures for every time that curves are drawn."""


class Pace:
    """Lowers the rate of pictures when time runs away, and raises it again, carefully, when there is room.

    A browser without a graphics card draws with the same processor cores that simulate. So fewer pictures give both
    what they need; curves come less often in proportion, and with fewer points.

    Attributes:
        rate: pictures a second.
        real: simulated time over the time that there was for it, in the last window; 1 is in step with the clock.
    """

    def __init__(self, now: float) -> None:
        self.rate, self.real = MOST, 1.0
        self._start, self._lost, self._backlog = now, 0.0, 0.0
        self._good, self._patience = 0, _PATIENCE
        self._raised = False

    @property
    def picture(self) -> float:
        """Time between pictures [s]."""
        return 1 / self.rate

    @property
    def curves(self) -> float:
        """Time between drawings of the curves [s]."""
        return _PLOTS / self.rate

    @property
    def thinning(self) -> int:
        """Of how many points of the curves one is drawn."""
        return 1 if self.rate > MOST / 2 else 2 if self.rate > MOST / 4 else 4

    @property
    def lowered(self) -> bool:
        """Whether there are fewer pictures than there should be."""
        return self.rate < 0.99 * MOST

    def note(self, now: float, backlog: float, lost: float) -> None:
        """Take in a turn of the loop.

        Args:
            now: the clock [s].
            backlog: time that is yet to be simulated when the turn begins [s of the clock].
            lost: time that was given up [s of the clock].
        """
        self._backlog, self._lost = max(self._backlog, backlog), self._lost + lost
        spent = now - self._start
        if spent < _WINDOW:
            return
        self.real = max(0.0, 1.0 - self._lost / spent)
        if self._lost > 0 or self._backlog > _LATE:
            if self._raised:  # it was a mistake to try: wait longer next time
                self._patience = min(2 * self._patience, _MOST_PATIENCE)
            self.rate, self._good = max(LEAST, _DOWN * self.rate), 0
            self._raised = False
        elif self._backlog < _EARLY:
            self._good += 1
            if self._good >= self._patience and self.lowered:
                self.rate, self._good, self._raised = min(MOST, _UP * self.rate), 0, True
        self._start, self._lost, self._backlog = now, 0.0, 0.0

    def words(self) -> str:
        """Return what the page says of it; "" if all is well."""
        if self.real < 0.98:
            return f"**{self.real:.2f} of the set speed**: this machine is too slow"
        return f"real time, at {self.rate:.0f} pictures/s" if self.lowered else ""
