"""
Which plans a session has published, by their stamps.
"""

from __future__ import annotations

import enum
from collections import deque

_REMEMBERED_PLANS = 64
"""Number of own plans that are recognised when they are followed."""


class Followed(enum.Enum):
    """What it means that a plan is followed, or has ended."""

    GOAL_ENDED = 'goal ended'
    """A plan to the goal in force has ended."""
    STOPPED = 'stopped'
    """The robot was stopped on its way to the goal in force, or while it waited for a path."""
    OWN = 'own'
    """The plan is one of the session's, and nothing follows from it."""
    FOREIGN = 'foreign'
    """Somebody else has made the plan."""


class OwnPlans:
    """The stamps of plans to the goal in force, and of all plans."""

    def __init__(self) -> None:
        self._to_goal: deque[int] = deque(maxlen=_REMEMBERED_PLANS)
        self._for_goal: deque[int] = deque(maxlen=_REMEMBERED_PLANS)
        self._all: deque[int] = deque(maxlen=_REMEMBERED_PLANS)

    def add(self, stamp: int, is_to_goal: bool = True) -> None:
        """Take note of a plan, to the goal in force or elsewhere."""
        if is_to_goal:
            self._to_goal.append(stamp)
        self._for_goal.append(stamp)
        self._all.append(stamp)

    def take_back(self, stamp: int) -> None:
        """Take note that all plans so far were taken back: that they end is no news."""
        self._to_goal.clear()
        self._for_goal.append(stamp)
        self._all.append(stamp)

    def begin_goal(self) -> None:
        """Take the plans so far for none on the way to the goal in force."""
        self._to_goal.clear()
        self._for_goal.clear()

    def judge(self, stamp: int, has_ended: bool, was_stopped: bool = False) -> Followed:
        """
        Say what it means that the plan of a stamp [ns] is followed, or has ended.

        Parameters
        ----------
        stamp : int
            Of the plan, or of what took the last plan back [ns].
        has_ended : bool
            Whether it is followed no longer.
        was_stopped : bool
            Whether that is because the robot was stopped; it need not have followed any.

        Returns
        -------
        Followed
        """
        if was_stopped and stamp in self._for_goal:
            return Followed.STOPPED
        if has_ended and stamp in self._to_goal:
            return Followed.GOAL_ENDED
        return Followed.OWN if stamp in self._all else Followed.FOREIGN
