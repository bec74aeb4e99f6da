"""
Time for which no new pose has been received, while time went on.
"""

from __future__ import annotations


class PoseAge:
    """
    Counts the wall clock, as messages do that may take a good part of a fast simulation's time.

    It stands still while the node's own clock does: a simulation that is paused is not silent.
    """

    def __init__(self) -> None:
        self._age = 0.0
        self._stamp: float | None = None
        self._last: tuple[float, float] | None = None

    @property
    def seconds(self) -> float:
        """Time since the last new pose, as of the last :meth:`tick` [s]."""
        return self._age

    def receive(self, stamp: float) -> None:
        """Take note of a pose; the same stamp again is the same pose, if it has one [s]."""
        if stamp != self._stamp or stamp == 0.0:
            self._age = 0.0
        self._stamp = stamp

    def tick(self, wall: float, clock: float) -> None:
        """Let time go on: the wall clock's, and that of the node [s]."""
        if self._last is not None and clock != self._last[1]:
            self._age += max(0.0, wall - self._last[0])
        self._last = wall, clock
