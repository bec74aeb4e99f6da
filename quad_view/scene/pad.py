"""
The speed pad: it steers while a button is held, and says once that it was let go.

Every press and every repetition of it counts for a moment only. So a page that is closed, or a
browser that hangs, ends the steering as a hand that lets go does.
"""

from __future__ import annotations

from quad_common.planar_pose import Twist2D

HELD = 0.35
"""Time for which a press counts: a page repeats it ten times a second [s]."""

KEY_HELD = 0.7
"""Time for which a key counts: keyboards repeat after half a second at first [s]."""

_PERIOD = 0.1
"""Between two commands [s]."""

STILL = Twist2D(0.0, 0.0, 0.0)


class Pad:
    """Speed commands of one robot."""

    def __init__(self) -> None:
        self._twist = STILL
        self._until = 0.0
        self._next = 0.0
        self._is_steering = False

    def hold(self, twist: Twist2D, now: float, duration: float = HELD) -> None:
        """Steer with a velocity for a duration [s] from now [s] on."""
        self._twist, self._until = twist, now + duration
        self._is_steering = True

    def let_go(self) -> None:
        """Stop at the next command."""
        self._until = 0.0

    def command(self, now: float) -> Twist2D | None:
        """Return the velocity to command at a time [s]; None if there is nothing to say."""
        if not self._is_steering:
            return None
        if now >= self._until:
            self._is_steering = False
            return STILL
        if now < self._next:
            return None
        self._next = now + _PERIOD
        return self._twist
