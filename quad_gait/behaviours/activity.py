"""
What a robot is doing, or why it is not moving, in one word and in a sentence.
"""

from __future__ import annotations

import enum


class Activity(enum.Enum):
    """What the robot is doing, or why it is not moving."""

    WAITING = 'waiting'
    STANDING = 'standing'
    STANDING_UP = 'standing up'
    SITTING_DOWN = 'sitting down'
    SITTING = 'sitting'
    WALKING = 'walking'
    TURNING = 'turning'
    BALANCING = 'balancing'
    ARRIVED = 'arrived'
    STOPPED = 'stopped'
    BLOCKED = 'blocked'
    FALLEN = 'fallen'
    LAME = 'lame'
    NOT_EXECUTED = 'not executed'
    EMERGENCY_STOP = 'emergency stop'

    @property
    def is_moving(self) -> bool:
        """Whether the robot moves on its own legs."""
        return self in _MOVING

    @property
    def is_terminal(self) -> bool:
        """Whether the robot goes no farther unless somebody wishes for something new."""
        return self in _TERMINAL

    @property
    def is_disabled(self) -> bool:
        """Whether no new plan moves the robot either: somebody must help it first."""
        return self in _DISABLED

    @property
    def is_verdict(self) -> bool:
        """Whether it stays until something new is wished for, though the robot just stands."""
        return self in _VERDICTS


_MOVING = frozenset(
    {
        Activity.STANDING_UP,
        Activity.SITTING_DOWN,
        Activity.WALKING,
        Activity.TURNING,
        Activity.BALANCING,
    }
)

_VERDICTS = frozenset({Activity.ARRIVED, Activity.BLOCKED, Activity.STOPPED})

_DISABLED = frozenset({Activity.FALLEN, Activity.LAME, Activity.EMERGENCY_STOP})

_TERMINAL = _DISABLED | _VERDICTS | {Activity.NOT_EXECUTED}


class Report:
    """What the robot says of itself; behaviours write it."""

    def __init__(self) -> None:
        self.activity = Activity.WAITING
        """Activity of the robot."""
        self.reason = 'no plan yet'
        """The same as a sentence."""
        self.limit = ''
        """What keeps the robot from doing all that was requested; empty if nothing does."""

    def say(self, activity: Activity, reason: str) -> None:
        """Say what the robot does, and why."""
        self.activity = activity
        self.reason = reason
