"""
What becomes of trajectories that are sent to a joint controller as goals of an action.
"""

from __future__ import annotations

import math
from enum import IntEnum
from itertools import islice

from quad_common.errors.quoting import clipped

_ANSWERED_WITHIN = 1.0
"""Time after which a goal that is neither accepted nor rejected is missed [s]."""

_MOST_UNANSWERED = 50
"""Number of goals without an answer that are kept."""

_SAID_FOR = 5.0
"""Least time for which a trouble is said [s]: the next trajectory may follow at once."""


class TrajectoryCode(IntEnum):
    """Codes of ``FollowJointTrajectory``."""

    SUCCESSFUL = 0
    INVALID_GOAL = -1
    INVALID_JOINTS = -2
    OLD_HEADER_TIMESTAMP = -3
    PATH_TOLERANCE_VIOLATED = -4
    GOAL_TOLERANCE_VIOLATED = -5


class GoalWatch:
    """
    Notes which goals are answered, and how the newest one ends.

    A goal that a newer one has replaced ends however it may: each trajectory but the last does.

    Parameters
    ----------
    name : str
        Name of the action, for sentences.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._newest = 0
        self._unanswered: dict[int, float] = {}
        self._trouble = ''
        self._trouble_at = -math.inf
        self._is_over = True

    def sent(self, now: float) -> int:
        """Note that a goal was sent at a time [s]; return its number."""
        self._newest += 1
        if len(self._unanswered) == _MOST_UNANSWERED:
            # The first one says since when there is no answer.
            del self._unanswered[next(islice(self._unanswered, 1, None))]
        self._unanswered[self._newest] = now
        return self._newest

    def missed(self, now: float) -> None:
        """Note that there was a trajectory, and nobody to send it to, at a time [s]."""
        self._say('was not there for a trajectory, which was lost', now)

    def accepted(self, number: int) -> None:
        """Note that a goal was accepted."""
        self._answered(number)
        self._is_over = True

    def rejected(self, number: int, now: float) -> None:
        """Note that a goal was rejected at a time [s]."""
        self._answered(number)
        self._say('rejected a trajectory: the joints go on with the one before', now)

    def given_up(self, number: int, code: int, sentence: str, now: float) -> None:
        """
        Note that a goal was given up by the controller.

        Parameters
        ----------
        number : int
            Number of the goal.
        code : int
            One of :class:`TrajectoryCode`.
        sentence : str
            What the controller says about it.
        now : float
            Time [s].
        """
        if number != self._newest:
            return
        known = {each.value: each.name for each in TrajectoryCode if each.value}
        name = known.get(code, f'code {code}')
        said = f' ({clipped(sentence)})' if sentence else ''
        self._say(f'gave up the trajectory: {name}{said}', now)

    def taken_over(self, number: int, now: float) -> None:
        """Note that a goal was canceled, which nobody here has done, at a time [s]."""
        if number == self._newest:
            self._say(
                'canceled the trajectory at the request of another client, which may command the '
                'same joints',
                now,
            )

    def problem(self, now: float, is_served: bool) -> str:
        """
        Say what is wrong with the action.

        Parameters
        ----------
        now : float
            Time [s].
        is_served : bool
            Whether there is a server of it.

        Returns
        -------
        str
            One sentence; empty if nothing is.
        """
        if not is_served:
            return f'{self._name} is not there: start the controller that serves it'
        oldest = min(self._unanswered.values(), default=now)
        if now - oldest > _ANSWERED_WITHIN:
            return f'{self._name} has not answered a trajectory for {now - oldest:.0f} s'
        if self._is_over and now - self._trouble_at > _SAID_FOR:
            return ''
        return f'{self._name} {self._trouble}'

    def _answered(self, number: int) -> None:
        # Whatever was sent before is answered, or its answer was lost.
        self._unanswered = {n: at for n, at in self._unanswered.items() if n > number}

    def _say(self, trouble: str, now: float) -> None:
        self._trouble, self._trouble_at, self._is_over = trouble, now, False
