"""
Whether a robot that gives way gets on along its way.
"""

from __future__ import annotations

import math

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle

_STRAYED = 0.2
"""Distance from the path from which on a robot that gives way plans again [m]."""

_STUCK = 4.0
"""Time without a movement after which it does so, too [s]."""

_STEP, _TURN = 0.02, 0.05
"""Least movement [m, rad]."""


class DetourProgress:
    """Watches a robot on the way to where it lets others pass."""

    def __init__(self) -> None:
        self._moved = (-math.inf, Pose2D(0.0, 0.0, 0.0))

    def begin(self, time: float, pose: Pose2D) -> None:
        """Begin at a time [s] where the robot is."""
        self._moved = time, pose

    def has_strayed(self, time: float, pose: Pose2D, plan: Plan) -> bool:
        """Return whether the robot is not on its way: beside it, or without a movement [s]."""
        since, last = self._moved
        turned = abs(wrap_angle(pose.yaw - last.yaw))
        if pose.distance_to(last) > _STEP or turned > _TURN:
            self._moved = time, pose
        is_stuck = time - since > _STUCK
        return is_stuck or distance_to_polyline((pose.x, pose.y), plan.corners) > _STRAYED
