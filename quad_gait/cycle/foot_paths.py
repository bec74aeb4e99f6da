"""
The paths of the feet over a cycle, with the rolling of their balls, seen from the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_course import BodyCourse
from quad_gait.cycle.footholds import Footholds
from quad_gait.cycle.schedule import Schedule

Array = NDArray[np.float64]

_ROLLING_SAMPLES = 50
"""Samples of a cycle at which the rolling of the feet is computed."""

_ROLLING_PASSES = 2
"""Rolling changes how the calves turn, and that changes the rolling, a tenth as much."""


@dataclass(frozen=True)
class Rolling:
    """How the balls of the standing feet roll over the ground."""

    displacement: Array
    """Displacement of their centers since the start, shape (..., n, 4, 2) [m]."""
    velocity: Array
    """Velocity of their centers, shape (..., n, 4, 2) [m/s]."""


class FootPaths(NamedTuple):
    """Centers of the feet over a cycle, n samples."""

    in_body: Array
    """Centers in the body frame, shape (..., n, 4, 3) [m]."""
    velocities_in_body: Array
    """Velocities relative to the body, in its axes, shape (..., n, 4, 3) [m/s]."""
    in_ground: Array
    """Centers in the ground frame, shape (..., n, 4, 3) [m]."""


def rolled_paths(
    robot: Robot, schedule: Schedule, footholds: Footholds, course: BodyCourse
) -> FootPaths:
    """
    Move each foot from its start to its target, rolling over the ground while it stands.

    Parameters
    ----------
    robot, schedule, footholds, course
        As for :func:`rolling_of`.

    Returns
    -------
    FootPaths
        The feet in the body frame and in the ground frame.
    """
    rolling = rolling_of(robot, schedule, footholds, course)
    return foot_paths(schedule, robot.standing_height, footholds, course, rolling)


def rolling_of(
    robot: Robot, schedule: Schedule, footholds: Footholds, course: BodyCourse
) -> Rolling | None:
    """
    Find how far the feet roll, from how their calves turn.

    The center of a ball of radius r that rolls with the angular velocity omega moves
    with r (omega_y, -omega_x). Without it robots with legs that are short for their feet
    go up to a tenth too far.

    Parameters
    ----------
    robot : Robot
        The robot.
    schedule : Schedule
        The gait's curves, n samples.
    footholds : Footholds
        Centers of the feet before and after their swings.
    course : BodyCourse
        Pose and velocity of the body.

    Returns
    -------
    Rolling or None
        None if the feet are points.
    """
    radius = robot.foot_radius
    if radius <= 0.0:
        return None
    stride = max(1, (len(schedule.times) - 1) // _ROLLING_SAMPLES)
    coarse = schedule.thinned(stride)
    part = BodyCourse(course.pose[..., ::stride, :], course.velocity[..., ::stride, :])
    speed = None
    for _ in range(_ROLLING_PASSES):
        rolling = None if speed is None else _rolled(coarse, speed)
        arms, arm_velocities, _ = foot_paths(
            coarse, robot.standing_height, footholds, part, rolling
        )
        joints = robot.stacked_legs.inverse(arms)
        joint_velocities = robot.joint_velocities(joints, arm_velocities)
        spin = robot.calf_angular_velocities(joints, joint_velocities)
        yaw = part.pose[..., 2]
        cos, sin = np.cos(yaw)[..., None], np.sin(yaw)[..., None]
        x, y = spin[..., 0], spin[..., 1]
        speed = radius * np.stack([sin * x + cos * y, sin * y - cos * x], axis=-1)
    assert speed is not None
    return _rolled(schedule, _interpolated(schedule.times, coarse.times, speed))


def foot_paths(
    schedule: Schedule,
    standing_height: float,
    footholds: Footholds,
    course: BodyCourse,
    rolling: Rolling | None,
) -> FootPaths:
    """
    Move each foot from its start to its target while it swings.

    Parameters
    ----------
    schedule : Schedule
        The gait's curves, n samples.
    standing_height : float
        Height of base_link above the ground [m].
    footholds : Footholds
        Centers of the feet before and after their swings.
    course : BodyCourse
        Pose and velocity of the body.
    rolling : Rolling or None
        How the standing feet roll; None for feet that are points.

    Returns
    -------
    FootPaths
        The feet in the body frame and in the ground frame.
    """
    start, target = footholds
    step = target - start
    if rolling is not None:
        step[..., :2] -= rolling.displacement[..., -1, :, :]
    feet = np.empty((*step.shape[:-2], len(schedule.times), len(LEGS), 3))
    velocities = np.empty_like(feet)
    for axis in range(3):
        # Each axis by itself: arrays of numbers that lie side by side are several times as quick.
        place, way = start[..., None, :, axis], step[..., None, :, axis]
        speed = schedule.step_rate * way
        if axis == 2:
            place = place + schedule.step * way + schedule.lift
            speed += schedule.lift_rate
        elif rolling is None:
            place = place + schedule.step * way
        else:
            place = place + rolling.displacement[..., axis] + schedule.step * way
            speed += rolling.velocity[..., axis]
        feet[..., axis], velocities[..., axis] = place, speed
    in_body, velocities_in_body = _in_body(schedule, standing_height, feet, velocities, course)
    return FootPaths(in_body, velocities_in_body, feet)


def _rolled(schedule: Schedule, speed: Array) -> Rolling:
    """Add up the rolling of the feet on the ground."""
    velocity = np.where(schedule.in_contact[..., None], speed, 0.0)
    displacement = np.zeros_like(velocity)
    step = schedule.times[1]
    both = velocity[..., 1:, :, :] + velocity[..., :-1, :, :]
    np.cumsum(both * (step / 2.0), axis=-3, out=displacement[..., 1:, :, :])
    return Rolling(displacement, velocity)


def _interpolated(times: Array, known_times: Array, values: Array) -> Array:
    """Interpolate samples (..., n, 4, 2) linearly, between evenly spaced times."""
    place = times / known_times[1]
    index = np.minimum(place.astype(int), len(known_times) - 2)
    fraction = (place - index)[:, None, None]
    before, after = values[..., index, :, :], values[..., index + 1, :, :]
    result: Array = before * (1.0 - fraction) + after * fraction
    return result


def _in_body(
    schedule: Schedule,
    standing_height: float,
    feet: Array,
    foot_velocities: Array,
    course: BodyCourse,
) -> tuple[Array, Array]:
    """Bring feet (..., n, 4, 3) and their velocities from the ground frame into the body's."""
    body, body_velocity = course
    cos, sin = np.cos(body[..., 2, None]), np.sin(body[..., 2, None])
    yaw_rate = body_velocity[..., 2, None]
    x, y = feet[..., 0] - body[..., 0, None], feet[..., 1] - body[..., 1, None]
    arms = np.empty_like(feet)
    arms[..., 0] = cos * x + sin * y
    arms[..., 1] = cos * y - sin * x
    arms[..., 2] = feet[..., 2] - (standing_height + schedule.body_lift[:, None])
    x = foot_velocities[..., 0] - body_velocity[..., 0, None]
    y = foot_velocities[..., 1] - body_velocity[..., 1, None]
    velocities = np.empty_like(feet)
    # The body's own turning carries the feet the other way round.
    velocities[..., 0] = cos * x + sin * y + yaw_rate * arms[..., 1]
    velocities[..., 1] = cos * y - sin * x - yaw_rate * arms[..., 0]
    velocities[..., 2] = foot_velocities[..., 2] - schedule.body_lift_rate[:, None]
    return arms, velocities
