"""
Keeps simulated time at a multiple of real time, or within reach of the gait, and measures it.
"""

from __future__ import annotations

import math

_LATE = 0.25
"""Lag behind real time beyond which the lost time is let go [s]."""


class Pacing:
    """
    Simulated time beside the wall clock's.

    Parameters
    ----------
    factor : float
        Simulated over real time; 0 for as fast as possible.
    wall : float
        The wall clock's time now, at which simulated time is 0 [s].
    """

    def __init__(self, factor: float, wall: float) -> None:
        self._factor = factor
        self._paced_from = (wall, 0.0)
        self._measured_from = (wall, 0.0)

    def ahead(self, simulated: float, wall: float) -> float:
        """
        Return how far the simulation is ahead of its pace; lost time is not caught up.

        Parameters
        ----------
        simulated, wall : float
            Simulated time, and the wall clock's [s].

        Returns
        -------
        float
            Real time to wait before it goes on, negative if it is late [s].
        """
        if self._factor == 0.0:
            return 0.0
        since, start = self._paced_from
        ahead = (simulated - start) / self._factor - (wall - since)
        if ahead < -_LATE:
            self.restart(simulated, wall)
        return ahead

    def restart(self, simulated: float, wall: float) -> None:
        """Keep the pace from these times on [s]."""
        self._paced_from = (wall, simulated)

    def measured_factor(self, simulated: float, wall: float) -> float:
        """Return simulated over real time since the last call; times as in :meth:`ahead`."""
        since, start = self._measured_from
        self._measured_from = (wall, simulated)
        return (simulated - start) / max(wall - since, 1e-6)


_AHEAD = 0.2
"""Simulated time by which the gait may be left behind: less than its lead before a cycle [s]."""

_OFTEN = 0.05
"""Time between two answers of a gait that decides at every measurement, at most [s]."""

_MEASUREMENTS_AHEAD = 1.5
"""Number of measurements by which such a gait may be left behind, before the next one."""

_PATIENCE = 1.0
"""Time on the wall clock without an answer for which a gait is waited for [s]."""

_GONE = 5.0
"""The same after which it is taken to be gone [s]: until then simulated time goes on no faster than
the wall clock's, as a gait that gets no processor meanwhile would lose whole cycles."""

_LONGEST_LOOK = 0.2
"""Time between two looks of which more does not count: all of the machine stood still then [s]."""


class Answers:
    """
    How far the gait has answered a simulation that goes as fast as possible.

    Such a simulation would leave a gait behind that computes, or is not given the processor. A gait
    that keeps the robot's balance answers every measurement, and is to answer it before the next.
    """

    def __init__(self) -> None:
        self._up_to = self._looked_at = -math.inf
        self._waited = _GONE
        self._alone_from: tuple[float, float] | None = None
        self._between, self._gaps = math.inf, 0
        self._ahead = _AHEAD

    def take(self, stamp: float, simulated: float, wall: float) -> None:
        """
        Take an answer; one that is not newer, or of the future, is none.

        Parameters
        ----------
        stamp : float
            Simulated time of the measurement that is answered [s].
        simulated, wall : float
            Simulated time, and the wall clock's [s].
        """
        if self._up_to < stamp <= simulated:
            since = stamp - self._up_to
            # One that skips measurements once, as it is late, is not left behind farther for it.
            self._gaps = 0 if since <= _OFTEN else self._gaps + 1
            if self._gaps == 0:
                self._between = min(self._between, since)
            elif self._gaps > 1:
                self._between = math.inf
            self._ahead = min(_MEASUREMENTS_AHEAD * self._between, _AHEAD)
            self._up_to, self._looked_at, self._waited = stamp, wall, 0.0
            self._alone_from = None

    def wait(self, simulated: float, wall: float) -> float:
        """
        Return how long to wait for the gait; times as of :meth:`Pacing.ahead`.

        Parameters
        ----------
        simulated, wall : float
            Simulated time, and the wall clock's [s].

        Returns
        -------
        float
            Real time to wait at most, until an answer comes; 0 to go on [s].
        """
        self._waited += min(wall - self._looked_at, _LONGEST_LOOK)
        self._looked_at = wall
        if simulated - self._up_to <= self._ahead or self._waited >= _GONE:
            return 0.0
        if self._waited < _PATIENCE:
            return _PATIENCE - self._waited
        if self._alone_from is None:
            self._alone_from = simulated, self._waited
        began, waited = self._alone_from
        return max(0.0, simulated - began - (self._waited - waited))
