"""
How a task has ended that somebody gave a robot, in the terms of ROS's actions and Nav2's codes.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass


class TaskOutcome(enum.Enum):
    """Kind of end, as an action has it."""

    SUCCEEDED = 'succeeded'
    CANCELED = 'canceled'
    ABORTED = 'aborted'


class FollowCode(enum.IntEnum):
    """Error codes of Nav2's FollowPath action (Jazzy); those of planners come with their errors."""

    NONE = 0
    UNKNOWN = 100
    INVALID_CONTROLLER = 101
    NO_POSE = 102
    INVALID_PATH = 103
    PATIENCE_EXCEEDED = 104
    NO_PROGRESS = 105
    NO_CONTROL = 106


@dataclass(frozen=True)
class TaskResult:
    """End of a task."""

    outcome: TaskOutcome
    """Kind of end."""
    code: int = FollowCode.NONE
    """Error code of Nav2; 0 for none."""
    message: str = ''
    """Reason, as a sentence; empty if it succeeded."""
