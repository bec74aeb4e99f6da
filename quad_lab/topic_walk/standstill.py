"""
Notices that simulated time stands still: whoever waits for it would wait for ever.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from quad_common.errors import QuadError

STALL_TIMEOUT = 60.0
"""For simulated time to advance at all [s]."""


@dataclass(eq=False, repr=False)
class TimeStandsStill(QuadError):
    """Simulated time does not go on."""

    duration: float
    """Time on the wall clock for which it has not [s]."""

    def sentence(self) -> str:
        """Say for how long."""
        return (
            f'simulated time stands still since {self.duration:.0f} s: sim_node is paused, or hangs'
        )


class Standstill:
    """
    How long a time has not gone on.

    Parameters
    ----------
    time : float
        The time now [s].
    clock : callable
        Returns the wall clock's time [s].
    """

    def __init__(self, time: float, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._seen, self._advanced = time, clock()

    def duration(self, time: float) -> float:
        """Take the time as it is now [s]; return how long it has not gone on, by the clock [s]."""
        now = self._clock()
        if time > self._seen:
            self._seen, self._advanced = time, now
        return now - self._advanced
