"""How fast a live run goes: simulated seconds per second of the clock."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable

LAG = 0.1  # seconds behind the clock from which a run that cannot keep up is let off
OVER = 1.0  # seconds over which the ratio to real time is measured


class Pace:
    """Where a run should be by now, and how fast it has been of late.

    speed: simulated seconds per second; infinite: as fast as it goes.
    """

    def __init__(self, speed: float = 1.0, clock: Callable[[], float] = time.perf_counter):
        self._clock = clock
        self.speed = speed
        self._anchor = 0.0, clock()
        self._passed: deque[tuple[float, float]] = deque()

    def start(self, t: float) -> None:
        """The run goes on from t [s] now."""
        self._anchor = t, self._clock()
        self._passed.clear()

    def due(self) -> float:
        """Where the run should be by now [s]."""
        t, since = self._anchor
        return t + self.speed * (self._clock() - since) if math.isfinite(self.speed) else math.inf

    def reached(self, t: float) -> None:
        """The run has come to t [s]."""
        now = self._clock()
        if math.isfinite(self.speed) and self.due() - t > LAG * self.speed:
            self._anchor = t, now
        self._passed.append((now, t))
        while now - self._passed[0][0] > OVER and len(self._passed) > 2:
            self._passed.popleft()

    @property
    def ratio(self) -> float | None:
        """Simulated seconds per second of late; None where it is not known yet."""
        if len(self._passed) < 2:
            return None
        (before, first), (now, last) = self._passed[0], self._passed[-1]
        return (last - first) / (now - before) if now > before else None
