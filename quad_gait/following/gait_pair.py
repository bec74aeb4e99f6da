"""
A gait for walking and one for turning on the spot: which of them does a motion.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from quad_common.planar_pose import Twist2D
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.motion_limits import Bound, MotionLimits
from quad_gait.following.step import Step

_PURE_TURN = 0.02
"""Steering that moves the body by less than this per radian is a turn on the spot [m]."""


class GaitPair:
    """
    The two gaits that a robot uses, and what they can do.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        For walking; fitted to the robot.
    turning_gait : Gait
        For turning on the spot; may be the same.
    least_margin : float
        Stability margin that cycles of a static gait must keep [m].
    bound_of : callable, optional
        Returns what else forbids motions of a gait.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        turning_gait: Gait,
        least_margin: float,
        bound_of: Callable[[Gait], Bound | None] = lambda gait: None,
    ) -> None:
        self.walking = MotionLimits(robot, gait, least_margin, bound=bound_of(gait))
        """The gait for walking."""
        self.turning = (
            self.walking
            if turning_gait == gait
            else MotionLimits(robot, turning_gait, least_margin, bound=bound_of(turning_gait))
        )
        """The gait for turning on the spot; may be the same object."""

    def prepare(self) -> None:
        """Find the commonest limits beforehand: it takes a while, and cycles are awaited."""
        self.turning.largest_scale(BodyMotion(turn=-1.0))
        _ = self.largest_speeds

    @property
    def largest_speeds(self) -> Twist2D:
        """Largest velocity forward, to the left, and in turns on the spot, each by itself."""
        walking, turning = self.walking, self.turning
        return Twist2D(
            walking.largest_scale(BodyMotion(forward=1.0)) / walking.period,
            walking.largest_scale(BodyMotion(left=1.0)) / walking.period,
            turning.largest_scale(BodyMotion(turn=1.0)) / turning.period,
        )

    def of(self, step: Step) -> MotionLimits:
        """Return the gait that does a step."""
        return self.turning if step.is_turn else self.walking

    def of_twist(self, twist: Twist2D) -> MotionLimits:
        """Return the gait that a velocity is walked with."""
        translation = math.hypot(twist.forward, twist.left)
        is_turn = bool(twist.turn) and translation <= _PURE_TURN * abs(twist.turn)
        return self.turning if is_turn else self.walking

    def order_of(self, step: Step) -> Gait:
        """Choose the order of the legs by where the body goes, not by what is corrected."""
        gear = self.of(step)
        motion = BodyMotion.during(step.exit, gear.period) if step.exit else step.motion
        return gear.gait_for(motion)
