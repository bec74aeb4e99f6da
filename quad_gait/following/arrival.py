"""
When a robot at its goal has arrived, and when it is given up that it gets nearer.
"""

from __future__ import annotations

import math

from quad_common.errors import GoalNotReached
from quad_common.planar_pose import Pose2D
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.reference_path import work_left

_HERE = Pose2D(0.0, 0.0, 0.0)

_SETTLING_CYCLES = 3
"""Cycles at the goal that bring the robot no nearer, after which it may stay where it is."""

_NEARER = 2e-3
"""Distance by which a cycle must bring it nearer to count [m]."""


class Arrival:
    """
    Counts the cycles at the goal that bring the robot no nearer.

    Parameters
    ----------
    options : FollowerOptions
        Tolerances.
    """

    def __init__(self, options: FollowerOptions) -> None:
        self._options = options
        self._cycles = 0
        self._least = math.inf
        self.remark = ''
        """How far off it ended, if not within the usual tolerances; empty if it did."""

    def is_near(self, error: Pose2D) -> bool:
        """Return whether a robot is where it was to go, by the goal in its frame."""
        options = self._options
        in_place = math.hypot(error.x, error.y) <= options.position_tolerance
        return in_place and abs(error.yaw) <= options.heading_tolerance

    def is_settled(self, error: Pose2D) -> bool:
        """
        Return whether a robot that is not there stays where it is; count the cycle if not.

        Parameters
        ----------
        error : Pose2D
            Goal in the robot's frame.

        Raises
        ------
        GoalNotReached
            If it is too far off after many cycles that brought it no nearer.
        """
        options, distance = self._options, math.hypot(error.x, error.y)
        size = work_left((), _HERE, error)
        if size < self._least - _NEARER:
            # A gait with short steps may need many of them for half a turn.
            self._least, self._cycles = size, 0
        if options.settling_distance:
            is_near = distance <= options.settling_distance
            is_near = is_near and abs(error.yaw) <= options.settling_angle
            if is_near and self._cycles >= _SETTLING_CYCLES:
                angle = math.degrees(abs(error.yaw))
                self.remark = f'{distance:.3f} m and {angle:.1f} degrees off: no footholds nearer'
                return True
        self._cycles += 1
        if self._cycles > options.final_cycles:
            raise GoalNotReached(distance, abs(error.yaw), options.final_cycles)
        return False
