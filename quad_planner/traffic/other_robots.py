"""
What is known of other robots: by what they say, and by what they do not do.
"""

from __future__ import annotations

import math

from quad_common.errors import RobotLeftOut
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_planner.traffic.robot_on_map import RobotOnMap
from quad_planner.traffic.speeds import Speeds

MOST_ROBOTS = 64
"""Number of other robots that are reckoned with."""

_FARTHEST = 50.0
"""Length of the beginning of a robot's path that is reckoned with [m]: nobody waits for what comes
after it."""

_MOST_CORNERS = 2000
"""Number of corners of all robots' paths that are reckoned with. Together with the length it bounds
the time that a look takes, whatever robots say."""

_SETTLED = 5.0
"""Time after which a robot that wants to go nowhere is an obstacle that paths lead around [s]."""

_SILENT = 10.0
"""Time without a word after which a robot is taken to stay where it was last [s]."""

_FORGOTTEN = 600.0
"""Time without a word after which it is taken to have been carried away [s]."""

_STILL = 40.0
"""Time without a movement after which a robot is taken to stay, wherever it wants to go [s]."""

_GAP = 1.0
"""Time between two looks after which it is the one that looks who has paused [s]."""

_STEP, _TURN = 0.05, 0.1
"""Least movement [m, rad]."""


class OtherRobots:
    """
    The other robots, with those that do not get out of the way as robots that stay.

    Parameters
    ----------
    name : str
        Name of the robot that looks at them, whose own word is left out.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._words: dict[str, tuple[float, RobotOnMap]] = {}
        self._moved: dict[str, tuple[float, Pose2D]] = {}
        self._staying: dict[str, float] = {}
        self._inert: set[str] = set()
        self._looked = self._resumed = -math.inf
        self.speeds = Speeds()
        """Speeds of all robots, the one that looks too."""

    @property
    def robots(self) -> dict[str, RobotOnMap]:
        """
        Robots by their names; those that are silent, or do not move, as robots that stay.

        Each with as many corners of its path as are left for one of so many.
        """
        corners = _MOST_CORNERS // max(1, len(self._words))
        return {
            name: robot.staying()
            if name in self._inert
            else robot
            if len(robot.path) <= corners
            else robot.beginning(corners)
            for name, (_, robot) in self._words.items()
        }

    def take(self, time: float, robot: RobotOnMap) -> None:
        """
        Take what a robot says of itself at a time [s].

        Raises
        ------
        RobotLeftOut
            If as many as can be are known already, and none of them is silent.
        """
        name = robot.name
        if name == self._name:
            return
        if name not in self._words and len(self._words) >= MOST_ROBOTS:
            oldest = min(self._words, key=lambda known: self._words[known][0])
            if time - self._words[oldest][0] <= _SILENT:
                raise RobotLeftOut(name, MOST_ROBOTS)
            self.forget(oldest)
        self._words[name] = time, robot.beginning(_MOST_CORNERS, _FARTHEST)
        self.speeds.take(name, time, robot.pose)
        _, last = self._moved.setdefault(name, (time, robot.pose))
        turned = abs(wrap_angle(robot.pose.yaw - last.yaw))
        if robot.pose.distance_to(last) > _STEP or turned > _TURN:
            self._moved[name] = time, robot.pose
            self._inert.discard(name)
        if robot.is_staying:
            self._staying.setdefault(name, time)
        elif name not in self._inert:
            self._staying.pop(name, None)

    def forget(self, name: str) -> None:
        """Forget a robot that has left."""
        for known in (self._words, self._moved, self._staying):
            known.pop(name, None)
        self._inert.discard(name)
        self.speeds.forget(name)

    def bring_over(self, before: Pose2D | None) -> None:
        """
        Go on with robots on a map in another frame.

        Parameters
        ----------
        before : Pose2D or None
            Pose of the frame of the map before in it; without it all robots are forgotten.
        """
        if before is None:
            # The robot that looks at them has not walked from one frame into the other either.
            for name in [*self._words, self._name]:
                self.forget(name)
            return
        self._words = {n: (at, word.seen_from(before)) for n, (at, word) in self._words.items()}
        self._moved = {n: (at, before @ pose) for n, (at, pose) in self._moved.items()}
        self.speeds.bring_over(before)

    def look(self, time: float) -> None:
        """See at a time [s] who is silent, and who does not move."""
        # Time goes back when a simulator is started again.
        gone = [n for n, (at, _) in self._words.items() if not 0.0 <= time - at <= _FORGOTTEN]
        for name in gone:
            self.forget(name)
        if not 0.0 <= time - self._looked <= _GAP:
            # Nobody was listened to: they have as long as ever to speak again.
            self._resumed = time
        self._looked = time
        for name, (at, _) in self._words.items():
            since = self._moved[name][0]
            has_spoken = at >= self._resumed
            is_still = has_spoken and time - since > _STILL
            if is_still or time - max(at, self._resumed) > _SILENT:
                self._inert.add(name)
                self._staying.setdefault(name, since)
            elif has_spoken:
                self._inert.discard(name)

    def has_settled(self, name: str, time: float) -> bool:
        """Return whether a robot is an obstacle, by now [s]."""
        if self._words[name][1].has_fallen:
            return True
        return time - self._staying.get(name, math.inf) > _SETTLED
