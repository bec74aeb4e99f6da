"""
What becomes of a goal that was given.
"""

from __future__ import annotations

import enum

from quad_common.errors import PlannerError


class GoalEnd(enum.Enum):
    """How a goal has ended."""

    ARRIVED = 'arrived'
    REFUSED = 'refused'
    """There is no plan to it."""
    ENDED = 'ended'
    """The robot does not go there any more, and is not there."""
    REPLACED = 'replaced'
    """A newer goal has taken its place."""
    WITHDRAWN = 'withdrawn'


class GivenGoal:
    """A goal under way, or how it has ended: whoever gave it keeps this and looks."""

    def __init__(self) -> None:
        self.end: GoalEnd | None = None
        """End of it; None as long as it is under way."""
        self.reason = ''
        """Reason of the end, as a clause."""
        self.error: PlannerError | None = None
        """Error that refused it."""

    def conclude(self, end: GoalEnd, reason: str, error: PlannerError | None = None) -> None:
        """Note its end, unless it has ended before."""
        if self.end is None:
            self.end, self.reason, self.error = end, reason, error
