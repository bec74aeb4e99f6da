"""
What a robot is doing, or why it is not moving, in one word.
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
    ARRIVED = 'arrived'
    STOPPED = 'stopped'
    BLOCKED = 'blocked'
    FALLEN = 'fallen'
    LAME = 'lame'
    NOT_EXECUTED = 'not executed'
    EMERGENCY_STOP = 'emergency stop'

    @property
    def is_terminal(self) -> bool:
        """Whether the robot goes no farther unless somebody wishes for something new."""
        return self in _TERMINAL

    @property
    def is_disabled(self) -> bool:
        """Whether no new plan moves the robot either: somebody must help it first."""
        return self in _DISABLED


_DISABLED = frozenset({Activity.FALLEN, Activity.LAME, Activity.EMERGENCY_STOP})

_TERMINAL = _DISABLED | {
    Activity.ARRIVED,
    Activity.STOPPED,
    Activity.BLOCKED,
    Activity.NOT_EXECUTED,
}
