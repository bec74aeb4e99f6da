"""
A plan: the turning points of a walk, and the heading on each leg of it.

A legged robot walks straight and turns on the spot (S0 section 4), so a plan is its
turning points and nothing between them: pose k stands at turning point k and faces
along the segment that leaves it; the last pose has the goal's heading.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.planar_pose import Pose2D, distances_to_polyline, wrap_angle

LONGEST_PLAN = 1000
"""Poses of a plan that is walked, unless a parameter says otherwise."""

_STRAIGHT = 1e-6
"""Two segments whose headings differ by less are one [rad]."""


_MOST_LOOKS = 30
"""Looks at each point of a path on average, after which its parts are halved."""

_TOLERANCE = 0.02
"""Distance within which a path of many points may be replaced by straight segments [m]."""


def turning_points(
    points: NDArray[np.float64], tolerance: float = _TOLERANCE
) -> NDArray[np.float64]:
    """
    Leave out the points of a path that its straight segments pass by closely enough.

    The point farthest from a segment stays, if that is too far, and divides the segment (Ramer,
    1972; Douglas and Peucker, 1973).

    Parameters
    ----------
    points : ndarray, shape (n, 2), n >= 1
        The path, in the world [m].
    tolerance : float
        Largest distance of a point that is left out from the segment in its place [m].

    Returns
    -------
    ndarray, shape (m, 2), m <= n
        The first point, turning points, and the last.
    """
    is_kept = np.zeros(len(points), dtype=bool)
    is_kept[[0, -1]] = True
    segments = [(0, len(points) - 1)]
    looked_at = 0
    while segments:
        first, last = segments.pop()
        if last - first < 2:
            continue
        away = distances_to_polyline(points[first + 1 : last], points[[first, last]])
        looked_at += len(away)
        middle = int(np.argmax(away))
        if away[middle] > tolerance:
            # A zigzag sheds a point at a time: halves keep its time in bounds, and the distance.
            is_long = looked_at > _MOST_LOOKS * len(points)
            middle = (first + last) // 2 if is_long else middle + first + 1
            is_kept[middle] = True
            segments += [(first, middle), (middle, last)]
    kept: NDArray[np.float64] = points[is_kept]
    return kept


@dataclass(frozen=True)
class Plan:
    """
    The poses at which the robot turns, from the start's position to the goal pose.

    A plan of a single pose is a turn on the spot: the robot is already there.
    """

    poses: tuple[Pose2D, ...]
    """Poses in the world; pose k faces along segment k, the last has the goal's heading."""
    remark: str = field(default='', compare=False)
    """Remark on how it was found; empty if there is none."""

    @classmethod
    def through(cls, points: ArrayLike, goal_yaw: float) -> Plan:
        """
        Make the plan that walks through some points.

        Points at which the walk does not turn, and repeated points, are left out.

        Parameters
        ----------
        points : array_like, shape (n, 2), n >= 1
            Start, any points between, and goal, in the world [m].
        goal_yaw : float
            Heading at the goal [rad].

        Returns
        -------
        Plan
            The plan through the turning points among them.
        """
        corners: list[Pose2D] = []
        for x, y in np.asarray(points, dtype=float).tolist():
            here = Pose2D(x, y, goal_yaw)
            if corners and corners[-1].distance_to(here) < 1e-9:
                continue
            if corners:
                last = corners.pop()
                yaw = last.heading_to(here)
                if corners and abs(wrap_angle(yaw - corners[-1].yaw)) < _STRAIGHT:
                    # No turn at `last`: the segment before it goes on to here.
                    last = corners.pop()
                    yaw = last.heading_to(here)
                corners.append(Pose2D(last.x, last.y, yaw))
            corners.append(here)
        return cls(tuple(corners))

    @property
    def corners(self) -> NDArray[np.float64]:
        """Return the positions of the poses, shape (n, 2), in the world [m]."""
        return np.array([(pose.x, pose.y) for pose in self.poses])

    @property
    def length(self) -> float:
        """Return the length of the walk [m]."""
        return float(np.linalg.norm(np.diff(self.corners, axis=0), axis=1).sum())
