"""
The course of the body over a cycle: along its arc, from speed to speed, with sway.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Twist2D
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import CycleEnds
from quad_gait.cycle.footholds import Footholds
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.schedule import Schedule, mid_swing_progress

Array = NDArray[np.float64]

_OTHERS = np.array([[k for k in range(4) if k != leg] for leg in range(4)])
"""The three other legs, of each."""


class BodyCourse(NamedTuple):
    """Pose and velocity of the body over a cycle, n samples, in the ground frame."""

    pose: Array
    """Pose x, y, yaw of base_link, sway included, shape (..., n, 3) [m, rad]."""
    velocity: Array
    """Rate of the pose, shape (..., n, 3) [m/s, rad/s]."""


def body_course(
    gait: Gait,
    legs: NDArray[np.intp],
    schedule: Schedule,
    motion: BodyMotion,
    ends: CycleEnds,
    footholds: Footholds,
) -> BodyCourse:
    """
    Move the body along its arc, at its speeds at both ends, swaying as it goes.

    Parameters
    ----------
    gait : Gait
        The gait.
    legs : ndarray of int, shape (..., 4)
        Legs in the order of their swings.
    schedule : Schedule
        The gait's curves, n samples.
    motion : BodyMotion
        Motion of the body in the cycle.
    ends : CycleEnds
        Speeds at the cycle's ends.
    footholds : Footholds
        Centers of the feet before and after their swings.

    Returns
    -------
    BodyCourse
        Pose and velocity of the body.
    """
    body = motion.pose_at(schedule.progress)
    heading = body[:, 2]
    cos, sin = np.cos(heading), np.sin(heading)
    velocity = schedule.progress_rate[:, None] * np.stack(
        [
            motion.forward * cos - motion.left * sin,
            motion.forward * sin + motion.left * cos,
            np.full_like(heading, motion.turn),
        ],
        axis=1,
    )
    # At its ends a cycle is as much faster than on average as its progress is there.
    pace = schedule.progress_rate[0] * gait.cycle_period if gait.is_steady else 1.0
    before = pace * _velocity(ends.entry, 0.0) - velocity[0]
    after = pace * _velocity(ends.exit, motion.turn) - velocity[-1]
    for curve, rate, change in (
        (schedule.entry, schedule.entry_rate, before),
        (schedule.exit, schedule.exit_rate, after),
    ):
        if np.any(change):
            body += curve[:, None] * change
            velocity += rate[:, None] * change
    if gait.sways:
        moves = _sway(gait, legs, motion, footholds)
        shape = (*moves.shape[:-2], *body.shape)
        body, velocity = (np.broadcast_to(a, shape).copy() for a in (body, velocity))
        body[..., :2] += schedule.sway @ moves
        velocity[..., :2] += schedule.sway_rate @ moves
    return BodyCourse(body, velocity)


def give_way_to_legs(
    course: BodyCourse, schedule: Schedule, motion: BodyMotion, ends: CycleEnds, reaction: Array
) -> BodyCourse:
    """
    Let the body advance and fall back within each support, so that moving legs do not tilt it.

    Over both supports of a cycle it does so by a wave, which is zero where supports begin, stand
    in their middle, and end. Its speed there goes with the body's own.

    Parameters
    ----------
    course : BodyCourse
        Pose and velocity of the body, as if legs had no mass.
    schedule : Schedule
        The gait's curves, n samples.
    motion : BodyMotion
        Motion of the body in the cycle.
    ends : CycleEnds
        Speeds at the cycle's ends.
    reaction : ndarray, shape (2,)
        Height of the wave, forward and to the left, as fractions of the body's motion.

    Returns
    -------
    BodyCourse
        Pose and velocity of the body.
    """
    period = float(schedule.times[-1])
    rate = 4.0 * np.pi / period
    own = np.array([motion.forward, motion.left])
    height = reaction * own
    wave = np.sin(rate * schedule.times)[:, None] * height
    wave_rate = rate * np.cos(rate * schedule.times)[:, None] * height
    before, after = (
        rate * reaction * (period * np.array([end.forward, end.left]) - own)
        for end in (ends.entry, ends.exit)
    )
    yaw = course.pose[:, 2]
    pose, velocity = course.pose.copy(), course.velocity.copy()
    pose[:, :2] += _turned(wave, yaw)
    turning = course.velocity[:, 2, None] * np.stack([-wave[:, 1], wave[:, 0]], axis=1)
    velocity[:, :2] += _turned(wave_rate + turning, yaw)
    for change, at, curve, curve_rate in (
        (before, 0, schedule.entry, schedule.entry_rate),
        (after, -1, schedule.exit, schedule.exit_rate),
    ):
        moved = _turned(change[None], yaw[at, None])
        pose[:, :2] += curve[:, None] * moved
        velocity[:, :2] += curve_rate[:, None] * moved
    return BodyCourse(pose, velocity)


def _turned(vectors: Array, yaw: Array) -> Array:
    """Turn vectors (n, 2) by angles (n,) [rad]."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = vectors[:, 0], vectors[:, 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def _velocity(twist: Twist2D, heading: float) -> Array:
    """Write a velocity in the ground frame, shape (3,)."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array(
        [
            twist.forward * cos - twist.left * sin,
            twist.forward * sin + twist.left * cos,
            twist.turn,
        ]
    )


def _sway(gait: Gait, legs: NDArray[np.intp], motion: BodyMotion, footholds: Footholds) -> Array:
    """
    List the body's sideways moves, ground frame, shape (..., 5, 2) [m].

    In each interval with all feet down the body moves towards the centroid of the next
    support triangle, weighted by mu (S4 eq. 4), and back to its arc at the end. The legs
    are those that swing, one after the other, shape (..., 4).
    """
    orders = legs.reshape(-1, len(LEGS))
    rows, shape = np.arange(len(orders)), (len(orders), len(LEGS), 2)
    # One row for each order of the legs.
    feet, target = (
        np.broadcast_to(places[..., :2], (*legs.shape, 2)).reshape(shape).copy()
        for places in footholds
    )
    course = np.zeros((len(orders), 6, 2))
    on_arc = motion.pose_at(mid_swing_progress(gait))
    cosines, sines = np.cos(on_arc[:, 2]), np.sin(on_arc[:, 2])
    forward, left = gait.sway_weight
    for k, (body, cos, sin) in enumerate(zip(on_arc, cosines, sines)):
        leg = orders[:, k]
        off = feet[rows[:, None], _OTHERS[leg]].mean(axis=-2) - body[:2]
        ahead = forward * (cos * off[:, 0] + sin * off[:, 1])
        aside = left * (cos * off[:, 1] - sin * off[:, 0])
        course[:, k + 1, 0] = cos * ahead - sin * aside
        course[:, k + 1, 1] = sin * ahead + cos * aside
        feet[rows, leg] = target[rows, leg]
    moves = course[:, 1:] - course[:, :-1]
    return moves.reshape(*legs.shape[:-1], *moves.shape[1:])
