"""
Walking with a velocity that somebody wants, on the course that it has described so far.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.step import Departure, Step

_LARGEST_TURN_BACK = math.radians(12.0)
"""A robot turned farther from its course than this has lost it [rad]."""


@dataclass(frozen=True)
class Steered:
    """What steering leads to."""

    step: Step | None
    """Step to do next; None: to stay, or to come to rest."""
    limit: str = ''
    """Reason why the robot does not do all that was requested."""
    reason: str = ''
    """Why it is to stay."""


class Steering:
    """
    The velocity that is wanted, and the course.

    Parameters
    ----------
    timeout : float
        A velocity older than this is over [s].
    largest_correction : float
        A robot farther than this from its course goes on beside it [m]; 0: none is kept.
    steps_in_place : bool
        Whether no velocity is walked in place, and not a reason to stand.
    """

    def __init__(
        self, timeout: float, largest_correction: float, steps_in_place: bool = False
    ) -> None:
        self._steps_in_place = steps_in_place
        self._timeout = timeout
        self._largest_correction = largest_correction
        self._since = -math.inf
        self._course: Pose2D | None = None
        self.twist: Twist2D | None = None
        """Velocity that is wanted; None if none is."""

    def wish(self, twist: Twist2D, time: float) -> None:
        """Take the velocity that is wanted from now [s] on."""
        if self.twist is None:
            self._course = None
        self.twist, self._since = twist, time

    def end(self) -> None:
        """Forget what was wanted."""
        self.twist = None

    def lose_course(self) -> None:
        """Go on from wherever the robot will be."""
        self._course = None

    def take_course(self, place: Pose2D) -> None:
        """Go on from a place, by odometry, and with its heading."""
        if self._course is not None:
            self._course = place

    def expire(self) -> None:
        """Let what is wanted time out at once, unless it is wished for again."""
        self._course = None
        self._since = -math.inf

    def next_step(self, time: float, start: Departure, gait_pair: GaitPair) -> Steered:
        """
        Turn the velocity into a step.

        Parameters
        ----------
        time : float
            Now [s].
        start : Departure
            Where the next cycle begins, and how. A course is kept by odometry: a correction
            must not steer the robot.
        gait_pair : GaitPair
            The gaits.

        Returns
        -------
        Steered
            The step, or why there is none.
        """
        assert self.twist is not None
        wanted, pose, entry = self.twist, start.odometry, start.entry
        if time > self._since + self._timeout:
            self.twist = None
            return Steered(None, reason='the steering has timed out')
        gear = gait_pair.of_twist(wanted)
        twist, limit = gear.limited(wanted)
        if not wanted and self._steps_in_place:
            self._course = None
            return Steered(Step(is_turn=False, motion=BodyMotion()))
        if not wanted or not twist:
            self._course = None
            return Steered(None, limit, limit or 'steered to stand')
        if limit:
            limit = (
                f'steered at {_described(wanted)}, walking at {_described(twist)}, '
                f'the most that the {gear.gait.name} gait does: {limit}'
            )
        if entry and gear is not start.gear:
            self._course = None
            return Steered(None, limit)
        period = gear.period
        motion = BodyMotion.during(twist, period)
        if gear.is_steady:
            part = gear.acceleration_fraction
            motion = BodyMotion.during(entry.scaled(1.0 - part).plus(twist.scaled(part)), period)
        target = self._on_course(pose) @ motion.end
        self._course = target
        step = Step(
            is_turn=gear is gait_pair.turning and gear is not gait_pair.walking,
            motion=BodyMotion.reaching(pose.inverse() @ target),
            exit=twist if gear.is_steady else STILL,
        )
        return Steered(step, limit)

    def _on_course(self, pose: Pose2D) -> Pose2D:
        """
        Return where the steering would have brought the robot; or where it is, if lost.

        A robot too far from its course goes on beside it.
        """
        course = self._course
        if course is None or not self._largest_correction:
            return pose
        apart = pose.inverse() @ course
        if abs(apart.yaw) >= _LARGEST_TURN_BACK:
            return pose
        is_near = math.hypot(apart.x, apart.y) <= self._largest_correction
        return course if is_near else Pose2D(pose.x, pose.y, course.yaw)


def _described(twist: Twist2D) -> str:
    return f'({twist.forward:.3f}, {twist.left:.3f}) m/s and {math.degrees(twist.turn):.1f} deg/s'
