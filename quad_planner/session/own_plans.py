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
    OWN = 'own'
    """The plan is one of the session's, and nothing follows from it."""
    FOREIGN = 'foreign'
    """Somebody else has made the plan."""


class OwnPlans:
    """The stamps of plans to the goal in force, and of all plans."""

    def __init__(self) -> None:
        self._to_goal: deque[int] = deque(maxlen=_REMEMBERED_PLANS)
        self._all: deque[int] = deque(maxlen=_REMEMBERED_PLANS)

    def add(self, stamp: int, is_to_goal: bool = True) -> None:
        """Take note of a plan, to the goal in force or elsewhere."""
        if is_to_goal:
            self._to_goal.append(stamp)
        self._all.append(stamp)

    def begin_goal(self) -> None:
        """Take the plans so far for none to the goal in force."""
        self._to_goal.clear()

    def judge(self, stamp: int, has_ended: bool) -> Followed:
        """Say what it means that the plan of a stamp [ns] is followed, or has ended."""
        if has_ended and stamp in self._to_goal:
            return Followed.GOAL_ENDED
        return Followed.OWN if stamp in self._all else Followed.FOREIGN
