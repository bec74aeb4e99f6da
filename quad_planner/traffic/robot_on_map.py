"""
What robots tell one another: where each is, how large, and the path it wants to walk.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

import numpy as np

from quad_common.planar_pose import Pose2D
from quad_planner.grid.array_types import Points


@dataclass(frozen=True, eq=False)
class RobotOnMap:
    """A robot as others see it."""

    name: str
    """Name, which says who gives way: the one that comes later in the order of names."""
    pose: Pose2D
    """Pose of base_link in the map."""
    radius: float
    """Radius of the circle around base_link that holds its feet [m]."""
    path: Points
    """What is left of the path to its goal, shape (n, 2) [m]; empty for one that stays."""
    goes_first: bool = False
    """Whether it can give way to nobody, so that others give way to it."""
    has_fallen: bool = False
    """Whether it lies on the ground: it has no path then."""
    goal: Points | None = None
    """Where it wants to go, shape (2,) [m], if only the beginning of its path is known; otherwise
    its path ends there."""

    @property
    def position(self) -> Points:
        """Position in the map, shape (2,) [m]."""
        return np.array([self.pose.x, self.pose.y])

    @property
    def line(self) -> Points:
        """Position and path, shape (n, 2), n >= 1 [m]."""
        return np.vstack([self.position, np.reshape(self.path, (-1, 2))])

    @property
    def destination(self) -> Points:
        """Where it wants to go, shape (2,) [m]."""
        destination: Points = self.line[-1] if self.goal is None else self.goal
        return destination

    def seen_from(self, before: Pose2D) -> RobotOnMap:
        """Return it on a map in another frame, in which that of the map before has a pose."""
        path = before.transform(np.reshape(self.path, (-1, 2)))
        goal = None if self.goal is None else before.transform(self.goal)
        return replace(self, pose=before @ self.pose, path=path, goal=goal)

    def staying(self) -> RobotOnMap:
        """Return it as one that stays where it is."""
        return replace(self, path=np.empty((0, 2)), goes_first=False, goal=None)

    def beginning(self, most_corners: int, length: float = math.inf) -> RobotOnMap:
        """
        Return it with the beginning of its path.

        Parameters
        ----------
        most_corners : int
            Largest number of its corners.
        length : float
            Largest length [m].

        Returns
        -------
        RobotOnMap
            Itself, if its path is no longer.
        """
        path = np.reshape(self.path, (-1, 2))[:most_corners]
        lengths = np.linalg.norm(np.diff(np.vstack([self.position, path]), axis=0), axis=1)
        along = np.cumsum(lengths)
        beyond = np.flatnonzero(along > length)
        if not len(beyond) and len(path) == len(self.path):
            return self
        if len(beyond):
            last = int(beyond[0])
            before = path[last - 1] if last else self.position
            left = length - (along[last] - lengths[last])
            end = before + (path[last] - before) * left / lengths[last]
            path = np.vstack([path[:last], end])
        return replace(self, path=path, goal=self.destination)

    @property
    def is_staying(self) -> bool:
        """Whether it wants to go nowhere."""
        return len(self.path) == 0


def precedes(a: RobotOnMap, b: RobotOnMap) -> bool:
    """
    Return whether a robot has the right of way before another one.

    One that can give way to nobody has it before one that can; else the order of names decides,
    with numbers in them as numbers: robot2 before robot10.
    """
    return _rank(a) < _rank(b)


def _rank(robot: RobotOnMap) -> tuple[bool, list[tuple[int, str]], str]:
    parts = re.split(r'(\d+)', robot.name)
    numbered = [(int(p), '') if p.isdecimal() else (-1, p) for p in parts]
    # robot1 and robot01 are two robots, of which one goes first.
    return not robot.goes_first, numbered, robot.name
