"""
What time it is, in the time of the measurements, also while they are silent.
"""

from __future__ import annotations

_WINDOW = 0.5
"""Time on the wall clock over which the pace of the measurements is found, at least [s]."""

_MARGIN = 1.5
"""Factor by which time may go on faster than the measurements did."""


class MeasuredTime:
    """
    Goes on from the newest measurement by a clock, but no faster than the measurements went.

    The clock may be a simulation's, which pauses, or leaps where two simulations publish theirs; it
    need not have the time of the measurements.
    """

    def __init__(self) -> None:
        self._newest: float | None = None
        self._clock = self._wall = 0.0
        self._began: tuple[float, float] | None = None
        self._pace = 1.0

    def note(self, newest: float | None, clock: float, wall: float) -> None:
        """
        Note what was measured last.

        Parameters
        ----------
        newest : float or None
            Time of the newest measurement [s]; None without one.
        clock, wall : float
            The clock's time now, and the wall clock's [s].
        """
        if newest is None or newest == self._newest:
            return
        self._newest, self._clock, self._wall = newest, clock, wall
        if self._began is None or newest < self._began[0]:
            self._began = newest, wall
        elif wall - self._began[1] >= _WINDOW:
            self._pace = (newest - self._began[0]) / (wall - self._began[1])
            self._began = newest, wall

    def now(self, clock: float, wall: float) -> float | None:
        """Return what time it is [s], given both clocks' as to :meth:`note`; None if unknown."""
        if self._newest is None:
            return None
        most = _MARGIN * self._pace * (wall - self._wall)
        return self._newest + min(max(clock - self._clock, 0.0), most)
