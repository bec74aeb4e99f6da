"""
Where a robot should be by now in the step that it takes, and how fast it is to be for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from quad_common.planar_pose import Pose2D, Twist2D, wrap_angle
from quad_gait.balance.foot_laws import Pace
from quad_gait.cycle.body_motion import BodyMotion

_TURN_TIME = 0.5
"""Time in which the largest correction of a turn turns by a radian [s]."""


class Guide(NamedTuple):
    """How a robot is guided along its course."""

    gain: float
    """Gain with which it is drawn to it [1/s]."""
    largest: float
    """Velocity of that, at most [m/s]."""
    lead: float
    """Time by which the velocity that is wanted is ahead [s]: a body has it so long after."""
    turns_back: bool
    """Whether it is turned to the course, too."""


@dataclass(frozen=True)
class Course:
    """
    One step, followed in time and then held.

    Forward, left and turn each follow the cubic of their whole and of their speeds at both ends.
    """

    start: float
    """Time at which it begins [s]."""
    period: float
    """Duration [s]."""
    pose: Pose2D
    """Pose of the body then, by odometry."""
    entry: Twist2D
    """Velocity of the body then."""
    motion: BodyMotion
    """Motion of the body in it."""
    exit: Twist2D
    """Velocity of the body at its end."""

    def fraction(self, time: float) -> float:
        """Return how much of its time is over at a time [s], from 0 to 1."""
        return min(max((time - self.start) / self.period, 0.0), 1.0)

    def at(self, time: float) -> tuple[Pose2D, Twist2D]:
        """Return where the body should be at a time [s], by odometry, and how fast."""
        s, T = self.fraction(time), self.period
        done, speeds = [], []
        for whole, first, last in (
            (self.motion.forward, self.entry.forward, self.exit.forward),
            (self.motion.left, self.entry.left, self.exit.left),
            (self.motion.turn, self.entry.turn, self.exit.turn),
        ):
            u, v = first * T, last * T
            b, c = 3.0 * whole - 2.0 * u - v, u + v - 2.0 * whole
            done.append(s * (u + s * (b + s * c)))
            speeds.append((u + s * (2.0 * b + 3.0 * s * c)) / T if time < self.start + T else last)
        return self.pose @ BodyMotion(*done).end, Twist2D(*speeds)

    def through(self, time: float, pose: Pose2D) -> Course:
        """Return the same course shifted to where the robot is at a time [s], not turned."""
        planned, start = self.at(time)[0], self.pose
        x, y = start.x + pose.x - planned.x, start.y + pose.y - planned.y
        return replace(self, pose=Pose2D(x, y, start.yaw))

    def pace(self, time: float, pose: Pose2D, guide: Guide) -> Pace:
        """
        Return how fast the robot is to be.

        Parameters
        ----------
        time : float
            [s]
        pose : Pose2D
            Where it is by odometry.
        guide : Guide
            How it is guided.

        Returns
        -------
        Pace
        """
        apart = pose.inverse() @ self.at(time)[0]
        twist = self.at(time + guide.lead)[1]
        x, y = guide.gain * apart.x, guide.gain * apart.y
        size = math.hypot(x, y)
        if size > guide.largest:
            x, y = x * guide.largest / size, y * guide.largest / size
        turn = guide.gain * wrap_angle(apart.yaw) if guide.turns_back else 0.0
        turn = min(max(turn, -1.0 / _TURN_TIME), 1.0 / _TURN_TIME)
        return Pace(twist.forward + x, twist.left + y, twist.turn + turn)
