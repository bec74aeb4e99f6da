"""
Whether a localiser, or two of them, say again and again that the robot is elsewhere.

A robot that was carried is where its localiser says, after one leap or a few. Where leaps do not
end, two publishers disagree or the localiser does not know: nothing in the map is true for long.
"""

from __future__ import annotations

from collections import deque

_WINDOW = 5.0
"""Time in which leaps are counted [s]."""

_FEW = 3
"""Number of leaps in that time that a robot may take that was carried."""


class LeapWatch:
    """Counts leaps of corrections, in the time of odometry."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=_FEW + 1)

    def take(self, time: float) -> None:
        """Take note of a leap at a time [s]."""
        self._times.append(time)

    def forget(self) -> None:
        """Begin anew: corrections are those of other frames, or the clock was set."""
        self._times.clear()

    def is_doubtful(self, time: float) -> bool:
        """Return whether leaps have not ended by a time [s]."""
        recent = [leap for leap in self._times if time - leap <= _WINDOW]
        return len(recent) > _FEW
