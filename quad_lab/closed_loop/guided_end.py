"""
When a walk that a planner guides is over.
"""

from __future__ import annotations

import math

from quad_gait.behaviours.activity import Activity


class GuidedEnd:
    """
    Ends a walk at once where no plan can help, and else when none has for a while.

    Parameters
    ----------
    patience : float
        Time for a robot that goes no farther to get another plan [s].
    """

    def __init__(self, patience: float = 2.0) -> None:
        self._patience = patience
        self._since = math.inf

    def is_over(self, time: float, activity: Activity | None) -> bool:
        """
        Return whether the robot has arrived, or will not.

        Parameters
        ----------
        time : float
            Simulated time [s].
        activity : Activity or None
            What the robot does; None while that is not known.
        """
        if activity is None or not activity.is_terminal:
            self._since = math.inf
            return False
        self._since = min(self._since, time)
        is_final = activity is Activity.ARRIVED or activity.is_disabled
        return is_final or time - self._since > self._patience
