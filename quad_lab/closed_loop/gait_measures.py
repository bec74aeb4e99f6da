"""
What can be measured of a gait in physics: how far, how straight, how stable, at what cost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from quad_common.plan import Plan
from quad_common.planar_pose import (
    Pose2D,
    Twist2D,
    distance_aside,
    distance_to_polyline,
    distances_to_polyline,
)
from quad_common.robot.robot import Robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.reference_path import circle_pieces
from quad_gait.following.slip_compensation import NO_SLIP, SlipCompensation
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.loop_record import Record

Array = NDArray[np.float64]

_GRAVITY = 9.80665


@dataclass(frozen=True)
class SteadyWalk:
    """One gait of one robot, steered in one direction for a time."""

    asked: BodyMotion
    """Of one cycle."""
    done: BodyMotion
    """Mean of one cycle."""
    drift: float
    """Distance by which the robot leaves its course, per metre walked [m/m]; 0 for a turn. On a
    curve the course is that of each cycle by itself."""
    veer: float
    """Change of heading that was not asked for, per metre [rad/m]; 0 for a turn, and a curve."""
    slip: float
    """How far standing feet moved, all four together, per cycle [m]; rolling counts."""
    least_margin: float
    """Measured, static [m]."""
    tilt_rms: float
    """[rad]"""
    torque_rms: float
    """[N m]"""
    transport_cost: float
    """Mechanical energy over weight and distance; nan for a turn."""
    has_fallen: bool
    is_finite: bool
    joints_in_range: bool
    contacts: tuple[str, ...]
    """Of anything but feet with the ground."""


def steady_walk(
    robot: Robot,
    gait: Gait,
    direction: BodyMotion,
    duration: float,
    asked: BodyMotion | None = None,
    least_margin: float = 0.005,
) -> SteadyWalk:
    """
    Steer a robot in one direction.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    direction : BodyMotion
        Direction of the motion; its size does not matter.
    duration : float
        [s]
    asked : BodyMotion, optional
        Of one cycle; 60 % of the largest in that direction if not given.
    least_margin : float
        That cycles must keep [m].

    Returns
    -------
    SteadyWalk
        What was measured; ``done`` is nan if there was no time for four cycles.
    """
    return recorded_steady_walk(robot, gait, direction, duration, asked, least_margin)[0]


def recorded_steady_walk(
    robot: Robot,
    gait: Gait,
    direction: BodyMotion,
    duration: float,
    asked: BodyMotion | None = None,
    least_margin: float = 0.005,
) -> tuple[SteadyWalk, Record]:
    """Steer a robot as :func:`steady_walk` does, and return what was seen of it, too."""
    walk = ClosedLoop(robot, measuring_controller(robot, gait, least_margin=least_margin))
    try:
        return steered_walk(walk, direction, duration, asked), walk.record
    finally:
        walk.close()


def steered_walk(
    walk: ClosedLoop, direction: BodyMotion, duration: float, asked: BodyMotion | None = None
) -> SteadyWalk:
    """
    Steer a robot that is ready to walk; as :func:`steady_walk`, which makes it ready.

    Parameters
    ----------
    walk : ClosedLoop
        The robot; it is for the caller to close.
    direction, duration, asked
        As of :func:`steady_walk`.
    """
    controller = walk.controller
    walk.run(0.1)
    gear = controller.gait_pair.of_twist(direction.rate(1.0))
    period = gear.period
    if asked is None:
        asked = direction.scaled(0.6 * gear.largest_scale(direction))
    controller.set_twist(asked.rate(period))
    ends = [walk.record.poses[-1]]
    walk.run(0.5)
    while walk.time < duration and not walk.record.has_fallen:
        ends.append(walk.next_cycle_end())
    return _steady_walk(walk.robot, walk, asked, period, ends)


def _steady_walk(
    robot: Robot, walk: ClosedLoop, asked: BodyMotion, period: float, poses: list[Pose2D]
) -> SteadyWalk:
    """Measure a walk by the poses at its start and at the ends of its cycles."""
    record = walk.record
    start, ends = poses[0], poses[3:]
    steps = [BodyMotion.reaching(a.inverse() @ b) for a, b in pairwise(ends)]
    parts = np.array([(s.forward, s.left, s.turn) for s in steps]).reshape(-1, 3)
    mean = parts.mean(axis=0) if len(parts) else np.full(3, math.nan)
    stride = math.hypot(asked.forward, asked.left)
    walked = stride * max(len(steps), 1)
    drift = veer = 0.0
    cost = math.nan
    if stride and ends:
        if asked.turn:
            drift = abs(asked.forward * mean[1] - asked.left * mean[0]) / stride**2
        else:
            course = start.yaw + math.atan2(asked.left, asked.forward)
            turned = (ends[0].inverse() @ ends[-1]).yaw
            drift, veer = distance_aside(ends, course) / walked, abs(turned) / walked
        speed = stride / period
        cost = float(np.mean(record.power)) / (robot.mass * _GRAVITY * speed)
    joints = np.array(record.joints).reshape(-1, 4, 3)
    cycles = max(record.times[-1] / period, 1.0)
    return SteadyWalk(
        asked=asked,
        done=BodyMotion(*mean.tolist()),
        drift=drift,
        veer=veer,
        slip=float(np.sum(record.slips)) / cycles,
        least_margin=float(np.min(record.margins)),
        tilt_rms=record.tilt_rms,
        torque_rms=float(np.sqrt(np.mean(np.square(record.torques)))),
        transport_cost=cost,
        has_fallen=record.has_fallen,
        is_finite=bool(np.all(np.isfinite(joints)) and np.all(np.isfinite(record.positions))),
        joints_in_range=bool(
            np.all(joints >= robot.lower - 0.01) and np.all(joints <= robot.upper + 0.01)
        ),
        contacts=tuple(sorted(map(str, walk.simulation.contacts_seen))),
    )


@dataclass(frozen=True)
class Circle:
    """A circle to the left that is to be walked."""

    radius: float
    """Radius [m]."""
    angle: float
    """Angle of one cycle, twice the delta of its source [rad]."""
    laps: float = 2.0
    """Laps after the first few cycles."""


@dataclass(frozen=True)
class CircleWalk:
    """A circle, as S2's table IV has it."""

    radius: float
    """Of the circle that fits the body's path best [m]."""
    steps_per_lap: float
    """Gait cycles for a turn of 360 degrees."""
    has_fallen: bool
    positions: Array
    """The body's path over the laps, shape (n, 2) [m]."""


def circle_walk(
    robot: Robot,
    gait: Gait,
    circle: Circle,
    closed_loop: bool,
    compensation: SlipCompensation = NO_SLIP,
) -> CircleWalk:
    """
    Walk on a circle to the left.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    circle : Circle
        To be walked.
    closed_loop : bool
        Follow the circle; otherwise steer as if there were no slip, and do not look.
    compensation : SlipCompensation
        For the open loop.

    Returns
    -------
    CircleWalk
        What came of it.
    """
    period, radius, laps = gait.cycle_period, circle.radius, circle.laps
    speed = radius * circle.angle / period
    options = FollowerOptions(largest_speed=speed)
    controller = measuring_controller(
        robot, gait, hold_course=False, compensation=compensation, follower=options
    )
    walk = ClosedLoop(robot, controller)
    try:
        walk.run(0.1)
        start = walk.record.poses[-1]
        if closed_loop:
            pieces = circle_pieces(start, radius, 2.0 * math.pi * (laps + 1.0))
            controller.set_plan(Plan((start, pieces[-1].end)), pieces)
        else:
            controller.set_twist(Twist2D(speed, 0.0, circle.angle / period))
        walk.run(0.5)
        ends = [walk.next_cycle_end() for _ in range(5)]
        first = len(walk.record.times)
        heading = [ends[-1].yaw]
        while abs(heading[-1] - heading[0]) < 2.0 * math.pi * laps:
            if walk.record.has_fallen or len(heading) > 10.0 * laps / circle.angle:
                break
            yaw = walk.next_cycle_end().yaw
            heading.append(heading[-1] + math.remainder(yaw - heading[-1], 2.0 * math.pi))
        turned = abs(heading[-1] - heading[0])
        positions = walk.record.positions[first:]
        return CircleWalk(
            radius=fitted_radius(positions),
            steps_per_lap=(len(heading) - 1) * 2.0 * math.pi / turned if turned else math.nan,
            has_fallen=walk.record.has_fallen,
            positions=positions,
        )
    finally:
        walk.close()


def fitted_radius(points: Array) -> float:
    """Return the radius of the circle that fits points (n, 2) best, algebraically [m]."""
    return fitted_circle(points)[1]


def fitted_circle(points: Array) -> tuple[Array, float]:
    """Return center, shape (2,), and radius of the circle that fits points (n, 2) best [m]."""
    matrix = np.column_stack([2.0 * points, np.ones(len(points))])
    x, y, c = np.linalg.lstsq(matrix, np.sum(points**2, axis=1), rcond=None)[0]
    return np.array([x, y]), float(np.sqrt(c + x * x + y * y))


@dataclass(frozen=True)
class PlanWalk:
    """A plan that was walked to its end."""

    arrived: bool
    largest_distance: float
    """From the plan's line, at any time [m]."""
    largest_distance_at_ends: float
    """The same at the ends of cycles, where the body does not sway [m]."""
    cycles: int
    record: Record


def plan_walk(
    robot: Robot,
    gait: Gait,
    plan: Plan,
    turning: str,
    timeout: float,
    least_margin: float = 0.005,
) -> PlanWalk:
    """
    Follow a plan from its first pose.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    plan : Plan
        It must begin where the robot stands: at the origin.
    turning : str
        How it is followed.
    timeout : float
        Given up after so long [s].
    least_margin : float
        That cycles must keep [m].

    Returns
    -------
    PlanWalk
        How well.
    """
    follower = FollowerOptions(turning=turning)
    controller = measuring_controller(robot, gait, follower=follower, least_margin=least_margin)
    walk = ClosedLoop(robot, controller)
    at_ends = []
    try:
        walk.run(0.1)
        controller.set_plan(plan)
        walk.run(0.5)
        while walk.time < timeout and controller.cycle_at(walk.time) is not None:
            end = walk.next_cycle_end()
            at_ends.append(distance_to_polyline((end.x, end.y), plan.corners))
            walk.run(1.0, until=lambda: controller.cycle_at(walk.time) is not None)
            if controller.activity.is_terminal:
                break
        track = np.array([(pose.x, pose.y) for pose in walk.record.poses])
        return PlanWalk(
            arrived=controller.activity is Activity.ARRIVED,
            largest_distance=float(distances_to_polyline(track, plan.corners).max()),
            largest_distance_at_ends=max(at_ends, default=math.nan),
            cycles=len(at_ends),
            record=walk.record,
        )
    finally:
        walk.close()
