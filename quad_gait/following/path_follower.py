"""
Follows a plan of turning points, one gait cycle at a time, in one of three manners.

``in_place``: straight between turning points, a turn on the spot at each (S0 sec. 4).
``crab``: the body keeps its heading and walks in any direction (S1 sec. IV).
``arc``: corners are rounded by circles (S2).

Every cycle aims at a pose on the path from where the robot really is, so that drift in
heading and sideways is corrected within the gait's reach.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.errors import CannotFollow, LeftPath, ParameterError
from quad_common.plan import Plan
from quad_common.planar_pose import STILL, Pose2D, Twist2D, wrap_angle
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.arrival import Arrival
from quad_gait.following.follower_options import TURNINGS, FollowerOptions
from quad_gait.following.reference_path import (
    Piece,
    pose_ahead,
    rounded_pieces,
    straight_pieces,
    work_left,
)
from quad_gait.following.step import Gear, Step, advance

_CATCH_UP = 0.2
"""Fraction of a stride by which a robot that keeps its speed makes up for lost distance."""

_TURNING_RADIUS = 0.02
"""A circle smaller than this is a turn on the spot [m]."""

_LEAST_CORRECTION = 1e-4
"""A path this short is no path [m]."""


class PathFollower:
    """
    Decides on one cycle after the other.

    Parameters
    ----------
    walking : Gear
        The gait for walking along the path.
    turning : Gear
        The gait for turning on the spot.
    options : FollowerOptions
        Tolerances.

    Raises
    ------
    ParameterError
        If ``turning`` is none of `TURNINGS`.
    """

    def __init__(self, walking: Gear, turning: Gear, options: FollowerOptions) -> None:
        if options.turning not in TURNINGS:
            raise ParameterError('turning', options.turning, f'one of {", ".join(TURNINGS)}')
        self._walking = walking
        self._turning = turning
        self._options = options
        self.plan: Plan | None = None
        """The plan that is being followed."""
        self.remark = ''
        """How far off the last plan ended, if not within the usual tolerances; else empty."""
        self._pieces: list[Piece] = []
        self._piece = 0
        self._arrival = Arrival(options)
        self._crab_yaw = 0.0
        self._expected = 0.0

    def follow(self, plan: Plan | None, pose: Pose2D, pieces: list[Piece] | None = None) -> None:
        """
        Take a new plan, or none.

        Parameters
        ----------
        plan : Plan or None
            The plan.
        pose : Pose2D
            Where the robot is: it joins the plan at the nearest piece.
        pieces : list of Piece, optional
            The path to the plan's last pose; made of the turning points if not given.
        """
        options = self._options
        if plan is None:
            pieces = []
        elif pieces is not None:
            pass
        elif options.turning == 'arc':
            pieces = rounded_pieces(
                plan, options.corner_deviation, options.corner_radius, options.turn_threshold
            )
        else:
            pieces = straight_pieces(plan, options.turn_threshold)
        self.plan = plan
        self._pieces = pieces
        self._expected = 0.0
        self._arrival = Arrival(options)
        self._crab_yaw = pose.yaw
        self._piece = self._nearest_piece(pose)

    def distance_left(self, pose: Pose2D) -> float:
        """Return how far it is along the path to the goal [m]; 0 without a plan."""
        if self.plan is None:
            return 0.0
        ahead = self._pieces[self._piece :]
        if not ahead:
            return pose.distance_to(self.plan.poses[-1])
        return pose.distance_to(ahead[0].end) + sum(piece.length for piece in ahead[1:])

    def work_left(self, pose: Pose2D) -> float | None:
        """Return the distance to the goal, and the turns, as metres; None without a plan."""
        if self.plan is None:
            return None
        return work_left(self._pieces[self._piece :], pose, self.plan.poses[-1])

    def pose_ahead(self, pose: Pose2D, distance: float) -> Pose2D | None:
        """Return the pose so far ahead [m] along the path, or the goal; None without a plan."""
        if self.plan is None:
            return None
        pieces, most = self._pieces[self._piece :], 2.0 * self._options.turn_threshold
        return pose_ahead(pieces, pose, distance, most) if pieces else self.plan.poses[-1]

    def next_step(self, pose: Pose2D, entry: Twist2D = STILL) -> Step | None:
        """
        Decide on the next cycle.

        Parameters
        ----------
        pose : Pose2D
            Where the robot will be at the start of the cycle, in the plan's frame.
        entry : Twist2D
            Its velocity then.

        Returns
        -------
        Step or None
            None when the goal is reached, which ends the plan, or there is none.

        Raises
        ------
        LeftPath
            If the robot is too far from the plan.
        CannotFollow
            If the gait can do nothing of what the path asks for.
        GoalNotReached
            If the robot cannot correct its pose at the goal.
        """
        plan, options = self.plan, self._options
        if plan is None:
            return None
        self._look_where_it_is(pose)
        while self._piece < len(self._pieces):
            piece = self._pieces[self._piece]
            done = piece.project(pose)
            if piece.length - done <= (options.position_tolerance if piece.ends_in_stop else 1e-3):
                self._piece += 1
                continue
            # The point to turn on is on the path beside the robot, but not before it.
            beside = piece.at(min(max(done, 0.0), piece.length))
            heading = self._heading(beside)
            is_off = abs(wrap_angle(heading - pose.yaw)) > options.turn_threshold
            if _is_turning(entry) or (is_off and not entry):
                return self._turn(pose, Pose2D(beside.x, beside.y, heading), entry)
            if is_off:
                return self._come_to_rest(entry)
            return self._walk(pose, entry, done)
        step = self._final(pose, plan.poses[-1], entry)
        if step is None:
            self.remark = self._arrival.remark
            self.follow(None, pose)
        return step

    def _look_where_it_is(self, pose: Pose2D) -> None:
        """Go on on another piece if something carried the robot away."""
        if self._distance_to_piece(self._piece, pose) <= self._options.path_tolerance / 2.0:
            return
        self._piece = self._nearest_piece(pose)
        distance = self._distance_to_piece(self._piece, pose)
        if distance > self._options.path_tolerance:
            raise LeftPath(distance, self._options.path_tolerance)

    def _heading(self, on_path: Pose2D) -> float:
        """Return the heading that the body is to have there [rad]."""
        return self._crab_yaw if self._options.turning == 'crab' else on_path.yaw

    def _walk(self, pose: Pose2D, entry: Twist2D, done: float) -> Step:
        """Aim at the path ahead, one of the equal strides that are left before the next stop."""
        piece = self._pieces[self._piece]
        remaining = -done
        for following in self._pieces[self._piece :]:
            remaining += following.length
            if following.ends_in_stop:
                break
        stride = self._stride(done)
        period = self._walking.period
        speed = math.hypot(entry.forward, entry.left) * period
        if entry:
            # Distance that was lost is made up for, within reason.
            behind = self._expected - (self._before(self._piece) + done)
            catch_up = max(-_CATCH_UP * stride, min(_CATCH_UP * stride, behind))
            done, remaining = done + catch_up, remaining - catch_up
        length, exit_speed = advance(remaining, speed, stride, self._walking)
        if exit_speed:
            # What comes then may be slower: a bend, after a straight line.
            exit_speed = min(exit_speed, self._pace(done + length))
            fraction = self._walking.acceleration_fraction
            length = (1.0 - fraction) * speed + fraction * exit_speed
        self._expected = self._before(self._piece) + done + length
        ahead, along = self._ahead(done + length)
        target = ahead.at(along)
        # An error across the path is taken back gently: what is left, in the next cycles.
        limit = self._options.largest_correction
        across = (piece.at(piece.project(pose)).inverse() @ pose).y
        left_over = across - max(-limit, min(limit, across))
        target_then = target @ Pose2D(0.0, left_over, 0.0)
        heading = self._heading(target)
        course = wrap_angle(target.yaw - heading)
        aim = pose.inverse() @ Pose2D(target_then.x, target_then.y, heading)
        speed = exit_speed / period
        turn = 0.0 if self._options.turning == 'crab' else speed * ahead.curvature
        return Step(
            is_turn=False,
            motion=BodyMotion.reaching(aim),
            exit=Twist2D(speed * math.cos(course), speed * math.sin(course), turn),
        )

    def _before(self, index: int) -> float:
        """Return how long the path is up to a piece [m]."""
        return sum(piece.length for piece in self._pieces[:index])

    def _stride(self, done: float) -> float:
        """Return how far one cycle goes along the path, of which each piece takes its part [m]."""
        fraction, stride = 1.0, 0.0
        for piece in self._pieces[self._piece :]:
            left = piece.length - done
            largest = self._largest_stride(piece, done)
            if left < 0.0 and not piece.ends_in_stop:
                done -= piece.length
                continue
            if fraction * largest <= left or piece.ends_in_stop:
                return stride + fraction * largest
            stride, fraction, done = stride + left, fraction - left / largest, 0.0
        return stride

    def _pace(self, distance: float) -> float:
        """Return how fast a robot may be at a distance from this piece's start, per cycle [m]."""
        return min(self._stride(distance), self._largest_stride(*self._ahead(distance)))

    def _largest_stride(self, piece: Piece, done: float) -> float:
        """Return how far one cycle goes along a piece, were it long enough [m]."""
        if self._options.turning == 'crab':
            course = piece.at(min(max(done, 0.0), piece.length)).yaw - self._crab_yaw
            direction = BodyMotion(math.cos(course), math.sin(course))
        else:
            direction = BodyMotion(forward=1.0, turn=piece.curvature)
        largest = self._walking.largest_scale(direction)
        if not largest > 0.0:
            raise CannotFollow('walk along its path', self._walking.reason(direction))
        return min(largest, self._options.largest_speed * self._walking.period)

    def _ahead(self, distance: float) -> tuple[Piece, float]:
        """Find the place at a distance from this piece's start: a piece, and how far along."""
        for piece in self._pieces[self._piece :]:
            if distance <= piece.length or piece.ends_in_stop:
                break
            distance -= piece.length
        return piece, min(distance, piece.length)

    def _turn(self, pose: Pose2D, target: Pose2D, entry: Twist2D) -> Step:
        """Turn by one of the equal parts that are left, drifting towards the point."""
        angle = wrap_angle(target.yaw - pose.yaw)
        period = self._turning.period
        direction = BodyMotion(turn=math.copysign(1.0, angle))
        largest = self._turning.largest_scale(direction)
        if not largest > 0.0:
            raise CannotFollow('turn on the spot', self._turning.reason(direction))
        part, exit_speed = advance(abs(angle), abs(entry.turn) * period, largest, self._turning)
        ahead = pose.inverse() @ target
        limit = self._options.largest_correction
        aim = Pose2D(
            max(-limit, min(limit, ahead.x)),
            max(-limit, min(limit, ahead.y)),
            math.copysign(part, angle),
        )
        return Step(
            is_turn=True,
            motion=BodyMotion.reaching(aim),
            exit=Twist2D(turn=math.copysign(exit_speed / period, angle)),
        )

    def _final(self, pose: Pose2D, goal: Pose2D, entry: Twist2D) -> Step | None:
        """Turn to the goal's heading, then correct what is left of the error."""
        options = self._options
        error = pose.inverse() @ goal
        if self._arrival.is_near(error) and not entry:
            return None
        if self._arrival.is_settled(error):
            return None
        if _is_turning(entry) or (abs(error.yaw) > options.turn_threshold and not entry):
            return self._turn(pose, goal, entry)
        if entry:
            return self._come_to_rest(entry)
        stride = math.hypot(error.x, error.y)
        fraction = 1.0
        if stride > _LEAST_CORRECTION:
            fraction = self._walking.possible_part(BodyMotion(error.x, error.y))
        aim = Pose2D(fraction * error.x, fraction * error.y, error.yaw)
        return Step(is_turn=False, motion=BodyMotion.reaching(aim))

    def _come_to_rest(self, entry: Twist2D) -> Step:
        """Slow down within one cycle."""
        time = (1.0 - self._walking.acceleration_fraction) * self._walking.period
        return Step(is_turn=False, motion=BodyMotion.during(entry, time))

    def _distance_to_piece(self, index: int, pose: Pose2D) -> float:
        """Measure how far a pose is from a piece, or, past the last one, from the goal [m]."""
        if index < len(self._pieces):
            return self._pieces[index].distance_to(pose)
        assert self.plan is not None
        return pose.distance_to(self.plan.poses[-1])

    def _nearest_piece(self, pose: Pose2D) -> int:
        """Find the piece that passes nearest to a pose; the earliest of equals."""
        if not self._pieces:
            return 0
        distances = [round(piece.distance_to(pose), 3) for piece in self._pieces]
        return int(np.argmin(distances))


def _is_turning(twist: Twist2D) -> bool:
    """Whether a body turns on the spot."""
    return abs(twist.turn) * _TURNING_RADIUS > math.hypot(twist.forward, twist.left)
