"""
Where the robot is going and where it has been: walked track, distance from the path, goals.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D, distance_to_polyline

Array = NDArray[np.float64]

_STEP = 0.02
"""Between two points of a track [m]."""

_MOST_POINTS = 3000

_LEAP = 1.0
"""The robot does not walk so far between two looks: it was put somewhere else [m]."""

_NO_DRAG = 0.05
"""A drag shorter than this gives no heading [m]."""


class Track:
    """The way that a robot has walked, thinned out where it is long."""

    def __init__(self) -> None:
        self._points: list[tuple[float, float]] = []
        self._step = _STEP

    def add(self, x: float, y: float) -> bool:
        """Note where the robot is; return whether the track has changed."""
        if self._points:
            moved = math.dist(self._points[-1], (x, y))
            if moved < self._step:
                return False
            if moved > _LEAP:
                self._points, self._step = [], _STEP
        self._points.append((x, y))
        if len(self._points) > _MOST_POINTS:
            self._points = self._points[::2]
            self._step *= 2.0
        return True

    def points(self) -> Array:
        """Return its points, shape (n, 2) [m]."""
        return np.array(self._points).reshape(-1, 2)


def distance_from_plan(pose: Pose2D | None, corners: Array) -> float:
    """Return how far a robot is from its plan [m]; NaN where either is missing."""
    if pose is None or len(corners) < 2:
        return math.nan
    return distance_to_polyline((pose.x, pose.y), corners)


def goal_of_drag(
    start: tuple[float, float], end: tuple[float, float], robot: Pose2D | None
) -> Pose2D:
    """
    Make a goal of a click or a drag over the floor.

    Parameters
    ----------
    start, end : tuple of float
        Where the button was pressed and where it was let go: x, y [m].
    robot : Pose2D or None
        Where the robot is.

    Returns
    -------
    Pose2D
        Where the button was pressed, with the heading towards where it was let go; of a click, with
        the heading in which the robot comes in a straight line.
    """
    x, y = start
    if math.dist(start, end) >= _NO_DRAG:
        return Pose2D(x, y, math.atan2(end[1] - y, end[0] - x))
    if robot is None or math.dist(start, (robot.x, robot.y)) < _NO_DRAG:
        return Pose2D(x, y, 0.0 if robot is None else robot.yaw)
    return Pose2D(x, y, math.atan2(y - robot.y, x - robot.x))
