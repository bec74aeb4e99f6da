"""
What time it is, in the time of the measurements, also while they are silent.
"""

from __future__ import annotations

import math

_WINDOW = 0.5
"""Time on the wall clock over which the pace of the measurements is found, at least [s]."""

_RECENT = 0.1
"""Time on the wall clock for which joint states tell what time it is [s]."""

_MARGIN = 1.5
"""Factor by which time may go on faster than the measurements did."""


class MeasuredTime:
    """
    Goes on from the last odometry by the joints' stamps, or by a clock, but no faster than before.

    A single stamp may be of the future. The clock may be a simulation's, which pauses, or leaps
    where two simulations publish theirs; it need not have the time of the measurements.
    """

    def __init__(self) -> None:
        self._newest: float | None = None
        self._clock = self._wall = 0.0
        self._began: tuple[float, float] | None = None
        self._pace = 1.0
        self._joints, self._joints_wall = 0.0, -math.inf

    def note_odometry(self, time: float, clock: float, wall: float) -> None:
        """
        Note that odometry has come.

        Parameters
        ----------
        time : float
            Time at which it was measured [s].
        clock, wall : float
            The clock's time now, and the wall clock's [s].
        """
        self._newest, self._clock, self._wall = time, clock, wall
        if self._began is None or time < self._began[0]:
            self._began = time, wall
        elif wall - self._began[1] >= _WINDOW:
            self._pace = (time - self._began[0]) / (wall - self._began[1])
            self._began = time, wall

    def note_joints(self, time: float, wall: float) -> None:
        """Note that joint states have come, by whose stamps it is as late [s]."""
        if time != self._joints:
            self._joints, self._joints_wall = time, wall

    def now(self, clock: float, wall: float) -> float | None:
        """Return what time it is [s], given both clocks'; None before there was any odometry."""
        if self._newest is None:
            return None
        by_clock, by_joints = clock - self._clock, self._joints - self._newest
        later = by_clock
        if wall - self._joints_wall < _RECENT and by_joints > 0.0:
            # A clock that stands still or was set back, unlike theirs, is none of the joints'.
            later = min(by_joints, by_clock) if by_clock > 0.0 else by_joints
        most = _MARGIN * self._pace * (wall - self._wall)
        return self._newest + min(max(later, 0.0), most)
