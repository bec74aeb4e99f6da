"""
Bodies of robots that stay where they are, as obstacles of the map.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from quad_common.planar_pose import Pose2D
from quad_planner.traffic.right_of_way import Distances, is_body_ahead
from quad_planner.traffic.robot_on_map import RobotOnMap

_MOVED = 0.05
"""Distance by which a robot has to move for its body to be moved on the map: one that stands does
not do so by the noise of where it believes to be [m]."""

_GROWN = 0.1
"""Room that has to be gained before a body that was drawn smaller is drawn larger again [m]."""

Disc = tuple[float, float, float]
"""x, y and radius [m]."""


class StandingBodies:
    """
    Discs that paths lead around, one for each robot that stays.

    A disc changes as seldom as possible: whenever it does, the map is prepared again.
    """

    def __init__(self) -> None:
        self._discs: dict[str, Disc] = {}

    def __contains__(self, name: str) -> bool:
        """Return whether paths lead around a robot."""
        return name in self._discs

    def holds(self, robot: RobotOnMap) -> bool:
        """Return whether paths lead around a robot where it is."""
        disc = self._discs.get(robot.name)
        return disc is not None and _is_there(disc, robot)

    def ahead(self, own: RobotOnMap, robots: Iterable[RobotOnMap], room: Distances) -> set[str]:
        """Return the names of robots, staying or not, that are on a robot's path."""
        return {r.name for r in robots if is_body_ahead(own, r, room, r.name in self)}

    @property
    def discs(self) -> tuple[Disc, ...]:
        """The bodies, in the order of the robots' names."""
        return tuple(disc for _, disc in sorted(self._discs.items()))

    def place(
        self, pose: Pose2D, robots: Iterable[RobotOnMap], clearance: float, resolution: float
    ) -> bool:
        """
        Take the robots that stay now; all others are none any more.

        Parameters
        ----------
        pose : Pose2D
            Where the robot itself is. Its place stays free, however near it stands: there the
            body is drawn smaller.
        robots : iterable of RobotOnMap
            The robots that stay.
        clearance : float
            Distance that paths keep from obstacles [m].
        resolution : float
            Edge length of a cell of the map [m].

        Returns
        -------
        bool
            Whether anything is in the way now that was not before.
        """
        before, self._discs = self._discs, {}
        for robot in robots:
            disc = _disc(before.get(robot.name), robot, pose, clearance + resolution)
            if disc[2] > 0.0:
                self._discs[robot.name] = disc
        return not all(_is_within(disc, before.get(name)) for name, disc in self._discs.items())

    def clear(self) -> None:
        """Know of no robot that stays."""
        self._discs = {}


def _is_within(disc: Disc, other: Disc | None) -> bool:
    """Return whether a disc is another one, or a smaller one there."""
    return other is not None and disc[:2] == other[:2] and disc[2] <= other[2]


def _is_there(disc: Disc, robot: RobotOnMap) -> bool:
    """Return whether a robot is where it was drawn."""
    return math.hypot(disc[0] - robot.pose.x, disc[1] - robot.pose.y) <= _MOVED


def _disc(known: Disc | None, robot: RobotOnMap, pose: Pose2D, needed: float) -> Disc:
    x, y = robot.pose.x, robot.pose.y
    if known is not None and _is_there(known, robot):
        x, y = known[:2]
    else:
        known = None
    room = math.hypot(pose.x - x, pose.y - y) - needed
    radius = min(robot.radius, room)
    # It is as large as there is room for, but not larger with every step.
    is_smaller = known is not None and known[2] < robot.radius
    if is_smaller and known is not None and known[2] <= room < known[2] + _GROWN:
        radius = known[2]
    return x, y, radius
