"""
The behaviours of a sound robot together: one acts, and hands over to the next when it is done.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import Behaviour, Command, Done, Shared, Walk
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import Wish
from quad_gait.state.robot_state import RobotState


def _always(_: SupervisorOptions) -> bool:
    return True


@dataclass(frozen=True)
class Row:
    """One behaviour in the table of transitions."""

    behaviour: type[Behaviour]
    """What acts."""
    takes: Activity
    """Activity by which others hand over to it."""
    says: frozenset[Activity]
    """Everything that the robot may be said to do while it acts."""
    hands_over_to: frozenset[Activity]
    """Activities that it may hand over to."""
    suits: Callable[[SupervisorOptions], bool] = _always
    """Whether a robot with these options has it."""


class Routine:
    """
    Lets one behaviour act at a time; the first of the table begins.

    Parameters
    ----------
    rows : sequence of Row
        The table of transitions.
    shared : Shared
        What the behaviours have in common.
    """

    def __init__(self, rows: Sequence[Row], shared: Shared) -> None:
        rows = [row for row in rows if row.suits(shared.options)]
        self._behaviours = {row.takes: row.behaviour(shared) for row in rows}
        self._first = self._current = self._behaviours[rows[0].takes]
        self._joints, self._guidance = shared.joints, shared.guidance

    @property
    def walk(self) -> Walk:
        """The behaviour that walks, or would."""
        if isinstance(self._current, Walk):
            return self._current
        walk = self._behaviours[Activity.WALKING]
        assert isinstance(walk, Walk)
        return walk

    def take(self, wish: Wish) -> None:
        """Let all behaviours that walk take notice of a wish: any of them may be the next."""
        for behaviour in self._behaviours.values():
            if isinstance(behaviour, Walk):
                behaviour.take(wish)

    def update(self, state: RobotState) -> Command:
        """Let the behaviour that acts decide, and those that it hands over to."""
        outcome = self._current.update(state)
        while isinstance(outcome, Done):
            assert outcome.next is not None
            self._current = self._behaviours[outcome.next]
            outcome = self._current.begin(state, outcome)
        return outcome

    def come_to_rest(self, state: RobotState) -> bool:
        """Begin nothing more; return whether what was given out still moves the robot."""
        return self._current.come_to_rest(state)

    def forget(self) -> None:
        """Know nothing of what was planned, and begin with the first behaviour again."""
        self._joints.busy_until = float('-inf')
        for behaviour in self._behaviours.values():
            behaviour.forget()
        # Something else moved the robot: nothing is expected of what was begun.
        self._guidance.begun = None
        self._guidance.steering.expire()
        self._current = self._first
