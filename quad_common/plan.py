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

from quad_common.planar_pose import Pose2D, wrap_angle

LONGEST_PLAN = 1000
"""Poses of a plan that is walked, unless a parameter says otherwise."""

_STRAIGHT = 1e-6
"""Two segments whose headings differ by less are one [rad]."""


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
