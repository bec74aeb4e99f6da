"""
Where a robot should be by now in the step that it takes, and how fast it is to be for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from quad_common.planar_pose import STILL, Pose2D, Twist2D, wrap_angle
from quad_gait.balance.foot_laws import Pace
from quad_gait.cycle.body_motion import BodyMotion

_TURN_TIME = 0.5
"""Time in which the largest correction of a turn turns by a radian [s]."""

_FARTHEST_TURNED = math.radians(12.0)
"""Angle off its course from which on a robot's next step begins nearer to where it is [rad]."""


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


class Start(NamedTuple):
    """Where a step begins, and how."""

    pose: Pose2D
    """Pose of the body then, by odometry."""
    entry: Twist2D = STILL
    """Velocity of the body then."""
    before: Course | None = None
    """Course that leads there; None for a robot that waits for it."""


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
    before: Course | None = None
    """Course that leads to it, while it has not begun; None for a robot that waits for it."""

    @classmethod
    def from_start(
        cls, start: Start, times: tuple[float, float], motion: BodyMotion, exit: Twist2D
    ) -> Course:
        """Return the course of a step that begins at a time and takes another [s]."""
        before = None if start.before is None else replace(start.before, before=None)
        return cls(*times, start.pose, start.entry, motion, exit, before)

    @property
    def end(self) -> float:
        """Time at which it ends [s]."""
        return self.start + self.period

    def start_after(self, time: float, pose: Pose2D, farthest: float) -> Start:
        """
        Return where the next step begins, at a time at which this one is over, or nearly.

        A body has its velocity later than it is asked for, so it is behind while it goes and is not
        when it stops. So it goes on from where it should be; from nearer to where it is if it is
        farther off. After a stop it begins where that leads from where it is.

        Parameters
        ----------
        time : float
            Now [s].
        pose : Pose2D
            Where the robot is by odometry.
        farthest : float
            How far off it may be [m].
        """
        planned, entry = self.at(time)
        if not self.exit:
            return Start(pose @ (planned.inverse() @ self.at(self.end)[0]), STILL, self)
        apart = pose.inverse() @ planned
        part = min(1.0, farthest / max(math.hypot(apart.x, apart.y), 1e-9))
        turn = min(max(apart.yaw, -_FARTHEST_TURNED), _FARTHEST_TURNED)
        return Start(pose @ Pose2D(part * apart.x, part * apart.y, turn), entry)

    def fraction(self, time: float) -> float:
        """Return how much of its time is over at a time [s], from 0 to 1."""
        return min(max((time - self.start) / self.period, 0.0), 1.0)

    def at(self, time: float) -> tuple[Pose2D, Twist2D]:
        """Return where the body should be at a time [s], by odometry, and how fast."""
        if time < self.start and self.before is not None:
            there, twist = self.before.at(time)
            before_end = self.before.at(self.before.end)[0].inverse() @ there
            return self.pose @ before_end, twist
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
