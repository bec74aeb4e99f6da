"""
Follows a plan of turning points, one gait cycle at a time.

Between turning points the robot walks straight; at each it turns on the spot (S0
sec. 4). Every cycle aims at a pose on the plan from where the robot really is, so that
drift in heading and sideways is corrected within the gait's reach.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from quad_common.errors import GaitError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_gait.body_motion import BodyMotion


@dataclass(frozen=True)
class FollowerOptions:
    """What a cycle may do, and when the robot has arrived."""

    largest_stride: float
    """Of a straight cycle [m]."""
    largest_turn: float
    """Of a turning cycle [rad]."""
    position_tolerance: float = 0.02
    """The robot is at a turning point or the goal when it is this near [m]."""
    heading_tolerance: float = math.radians(2.0)
    """The robot has the goal's heading when it is this near [rad]."""
    turn_threshold: float = math.radians(12.0)
    """Larger heading errors are turned away on the spot [rad]."""
    largest_correction: float = 0.05
    """Sideways in a straight cycle, and in any direction while turning [m]."""
    path_tolerance: float = 0.5
    """Farther from the plan the robot does not follow it [m]."""
    final_cycles: int = 12
    """At the goal the robot turns and corrects its pose at most so often."""


@dataclass(frozen=True)
class Step:
    """What the next cycle is to do."""

    is_turn: bool
    """Whether it is a turn on the spot."""
    motion: BodyMotion


class LeftPath(GaitError):
    """The robot is too far from its plan to follow it."""

    def __init__(self, distance: float, tolerance: float) -> None:
        super().__init__(
            f'the robot is {distance:.2f} m from its path; it follows within {tolerance:.2f} m: '
            f'waiting for a new plan'
        )


class GoalNotReached(GaitError):
    """The robot is at the goal, but its cycles do not bring it within the tolerances."""

    def __init__(self, distance: float, angle: float, cycles: int) -> None:
        super().__init__(
            f'after {cycles} cycles at the goal the robot is still {distance:.3f} m and '
            f'{math.degrees(angle):.1f} degrees off'
        )


class PathFollower:
    """
    Decides on one cycle after the other.

    Parameters
    ----------
    options : FollowerOptions
        Limits and tolerances.
    """

    def __init__(self, options: FollowerOptions) -> None:
        self._options = options
        self._plan: Plan | None = None
        self._segment = 0
        self._final_cycles = 0

    @property
    def plan(self) -> Plan | None:
        """The plan that is being followed."""
        return self._plan

    def follow(self, plan: Plan | None, pose: Pose2D) -> None:
        """
        Take a new plan, or none.

        Parameters
        ----------
        plan : Plan or None
            The plan.
        pose : Pose2D
            Where the robot is: it joins the plan at the nearest segment.
        """
        self._plan = plan
        self._final_cycles = 0
        self._segment = 0 if plan is None else _nearest_segment(plan, pose)

    def distance_left(self, pose: Pose2D) -> float:
        """Return how far it is along the plan to the goal [m]; 0 without a plan."""
        if self._plan is None:
            return 0.0
        ahead = self._plan.poses[self._segment + 1 :] or self._plan.poses[-1:]
        stops = (pose, *ahead)
        return sum(a.distance_to(b) for a, b in pairwise(stops))

    def next_step(self, pose: Pose2D) -> Step | None:
        """
        Decide on the next cycle.

        Parameters
        ----------
        pose : Pose2D
            Where the robot is, in the plan's frame.

        Returns
        -------
        Step or None
            None when the goal is reached, or there is no plan.

        Raises
        ------
        LeftPath
            If the robot is too far from the plan.
        GoalNotReached
            If the robot cannot correct its pose at the goal.
        """
        plan, options = self._plan, self._options
        if plan is None:
            return None
        if _distance_to_segment(plan, self._segment, pose) > options.path_tolerance / 2.0:
            # Something carried the robot away: it may be on another part of its plan.
            self._segment = _nearest_segment(plan, pose)
            distance = _distance_to_segment(plan, self._segment, pose)
            if distance > options.path_tolerance:
                raise LeftPath(distance, options.path_tolerance)
        last = len(plan.poses) - 1
        while self._segment < last:
            corner, target = plan.poses[self._segment], plan.poses[self._segment + 1]
            heading = corner.heading_to(target)
            remaining = _along(pose, target, heading)
            if remaining <= options.position_tolerance:
                self._segment += 1
                continue
            if abs(wrap_angle(heading - pose.yaw)) > options.turn_threshold:
                return self._turn(pose, Pose2D(corner.x, corner.y, heading))
            return self._straight(pose, target, heading, remaining)
        return self._final(pose, plan.poses[last])

    def _straight(self, pose: Pose2D, target: Pose2D, heading: float, remaining: float) -> Step:
        """Aim at the segment, one of the equal strides that are left ahead."""
        options = self._options
        stride = remaining / math.ceil(remaining / options.largest_stride)
        # Target seen along the segment: the robot is `remaining` behind it, `left` beside.
        left = -((target.x - pose.x) * math.sin(heading) - (target.y - pose.y) * math.cos(heading))
        sideways = _clamp(left, options.largest_correction)
        on_segment = Pose2D(stride, sideways, 0.0)
        seen_from_robot = Pose2D(0.0, 0.0, wrap_angle(heading - pose.yaw)) @ on_segment
        return Step(is_turn=False, motion=BodyMotion.reaching(seen_from_robot))

    def _turn(self, pose: Pose2D, target: Pose2D) -> Step:
        """Turn by one of the equal shares that are left, drifting towards the point."""
        options = self._options
        angle = wrap_angle(target.yaw - pose.yaw)
        turn = angle / math.ceil(abs(angle) / options.largest_turn - 1e-9)
        ahead = pose.inverse() @ target
        limit = options.largest_correction
        aim = Pose2D(_clamp(ahead.x, limit), _clamp(ahead.y, limit), turn)
        return Step(is_turn=True, motion=BodyMotion.reaching(aim))

    def _final(self, pose: Pose2D, goal: Pose2D) -> Step | None:
        """Turn to the goal's heading, then correct what is left of the error."""
        options = self._options
        error = pose.inverse() @ goal
        in_place = math.hypot(error.x, error.y) <= options.position_tolerance
        if in_place and abs(error.yaw) <= options.heading_tolerance:
            return None
        self._final_cycles += 1
        if self._final_cycles > options.final_cycles:
            distance = math.hypot(error.x, error.y)
            raise GoalNotReached(distance, abs(error.yaw), options.final_cycles)
        if abs(error.yaw) > options.turn_threshold:
            return self._turn(pose, goal)
        stride = math.hypot(error.x, error.y)
        share = min(1.0, options.largest_stride / stride) if stride > 0.0 else 1.0
        aim = Pose2D(share * error.x, share * error.y, error.yaw)
        return Step(is_turn=False, motion=BodyMotion.reaching(aim))


def _distance_to_segment(plan: Plan, segment: int, pose: Pose2D) -> float:
    """Measure how far a pose is from a segment, or, past the last one, from the goal [m]."""
    return distance_to_polyline((pose.x, pose.y), plan.corners[segment : segment + 2])


def _nearest_segment(plan: Plan, pose: Pose2D) -> int:
    """Find the segment that passes nearest to a pose; the earliest of equals."""
    segments = range(max(1, len(plan.poses) - 1))
    return int(np.argmin([round(_distance_to_segment(plan, k, pose), 3) for k in segments]))


def _along(pose: Pose2D, target: Pose2D, heading: float) -> float:
    return (target.x - pose.x) * math.cos(heading) + (target.y - pose.y) * math.sin(heading)


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
