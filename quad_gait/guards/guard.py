"""
What a guard is: it acts in place of what the robot did, as long as something is wrong.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import Command, Done, Shared
from quad_gait.behaviours.routine import Routine
from quad_gait.behaviours.wishes import Wish
from quad_gait.state.robot_state import RobotState


class Guard(ABC):
    """
    A behaviour that is asked at every measurement, before those of a sound robot.

    Parameters
    ----------
    shared : Shared
        What it has in common with the others.
    routine : Routine
        What it interrupts.
    """

    def __init__(self, shared: Shared, routine: Routine) -> None:
        self._robot = shared.robot
        self._options = shared.options
        self._report = shared.report
        self._joints = shared.joints
        self._guidance = shared.guidance
        self._routine = routine

    @abstractmethod
    def update(self, state: RobotState) -> Command | Done:
        """Decide, at each measurement; pass if nothing is wrong."""

    @property
    def refusal(self) -> str:
        """Reason for which nothing new is to be begun, as a sentence; empty if it may."""
        return ''

    def take(self, wish: Wish) -> str:
        """
        Take notice of a wish.

        Returns
        -------
        str
            What will happen, if it is this guard that does it.

        Raises
        ------
        GaitError
            If the wish cannot be granted.
        """
        return ''


@dataclass(frozen=True)
class GuardRow:
    """One guard in the table of transitions; it comes before those in the rows below."""

    guard: type[Guard]
    """What acts."""
    acts_when: str
    """Condition under which it does, for people."""
    says: frozenset[Activity]
    """Everything that the robot may be said to do while it acts."""
