"""
Keeps simulated time at a multiple of real time, and measures how fast it goes.
"""

from __future__ import annotations

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
