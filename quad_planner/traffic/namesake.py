"""
Whether another planner speaks for a robot of the same name.

Robots know one another by their names, and leave their own word out. Two of one name would never
see each other. A planner hears its own words again as it said them: others of its name are not its
own.
"""

from __future__ import annotations

import math
from collections import deque

from quad_common.planar_pose import Pose2D

_REMEMBERED = 100
"""Number of own words that are remembered: 20 s of them."""

_FEW = 5
"""Number of foreign words that may be left of a planner that has just been replaced."""

_SILENT = 10.0
"""Time after the last foreign word for which there still is such a planner [s]."""


class Namesake:
    """
    Tells own words from those of another planner whose robot has the same name.

    Parameters
    ----------
    name : str
        Name of the robot.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._said: deque[tuple[float, float]] = deque(maxlen=_REMEMBERED)
        self._count = 0
        self._heard_at = -math.inf

    def say(self, pose: Pose2D) -> None:
        """Remember where the robot is, as it is said now."""
        self._said.append((pose.x, pose.y))

    def hear(self, time: float, pose: Pose2D) -> None:
        """Take where a robot of this name is, as it was heard at a time [s]."""
        if (pose.x, pose.y) in self._said:
            return
        self._count = self._count + 1 if 0.0 <= time - self._heard_at <= _SILENT else 1
        self._heard_at = time

    def problem(self, time: float) -> str:
        """Return that there is such a planner, at a time [s], as a sentence; empty if not."""
        if self._count <= _FEW or not 0.0 <= time - self._heard_at <= _SILENT:
            return ''
        return (
            f"another planner speaks for a robot named '{self._name}', and they do not see one "
            'another: give each a namespace of its own'
        )
