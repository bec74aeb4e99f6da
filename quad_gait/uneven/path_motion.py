"""
From paths of body and feet to the motion of the joints.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_angles
from quad_common.trajectory.trajectory_gate import VELOCITY_TOLERANCE, velocities_between
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.cycle.part_check import check_nearing_parts
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.stance import Stance
from quad_gait.uneven.joint_motion import JointMotion
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]

_MOST_SAG = 0.05
"""Angle by which load pulls a joint out of its range, at most [rad]."""

_OVERSHOOT = 4.0 / 27.0
"""Distance by which a joint overshoots that ends at rest where it began, by a cubic, over its first
velocity times the duration."""


@dataclass(frozen=True)
class PlannedPaths:
    """Paths of body and feet, n samples; the body goes straight from where it is."""

    times: Array
    """Times from 0 on, evenly spaced, shape (n,) [s]."""
    end: BodyPose
    """Pose of the body at the end."""
    progress: Array
    """Fraction of the body's motion that is done, shape (n,)."""
    feet: Array
    """Centers of the feet, shape (n, 4, 3) [m]."""
    sure: int | None = None
    """Sample from which on samples are left out where a leg does not reach; None: none are."""
    given: int | None = None
    """Sample up to which all are given out at once; None: the last one."""


def motion_along(
    robot: Robot,
    options: UnevenOptions,
    now: Stance,
    commanded: Array | None,
    paths: PlannedPaths,
) -> JointMotion:
    """
    Turn paths of body and feet into joint motion, from where the joints are commanded.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    now : Stance
        The robot as it stands.
    commanded : ndarray, shape (4, 3), or None
        Where the joints are commanded to be [rad]; None: where they are.
    paths : PlannedPaths
        The paths.

    Returns
    -------
    JointMotion
        The motion.

    Raises
    ------
    GaitError
        If a leg does not reach, a joint is too slow or parts come too near to one another.
    """
    times, arms = paths.times, _arms(now, paths)
    sagged = _sagged(robot, now.joint_positions)
    sure = len(times) if paths.sure is None else paths.sure
    joints = _reached_joints(robot, arms, sure, sagged)
    times = times[: len(joints)]
    commanded = now.joint_positions - sagged if commanded is None else commanded
    blend = minimum_jerk(0.0, min(options.shift_time, float(times[-1])), times)[0]
    joints = joints + (1.0 - blend)[:, None, None] * (commanded - joints[0])
    # What drives are off is made up for within their ranges: a leg may be near the end of one.
    joints = np.clip(joints, robot.lower, robot.upper)
    joints = joints[: _stoppable(robot, joints, sure, options.reaction_time / times[1])]
    times = times[: len(joints)]
    last = len(times) - 1
    given = last if paths.given is None else min(paths.given, last)
    motion = _motion(robot, times, joints, now.time + options.reaction_time, given)
    check_nearing_parts(robot, times, joints)
    return motion


def motion_back(robot: Robot, options: UnevenOptions, now: Stance, way: list[Array]) -> JointMotion:
    """
    Take the joints back the way they came: what they have reached they reach again.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    now : Stance
        The robot as it stands.
    way : list of ndarray, each of shape (4, 3)
        Where the joints were commanded to be, evenly spaced in time, up to now; two at least
        [rad].

    Returns
    -------
    JointMotion
        The motion.

    Raises
    ------
    GaitError
        If a joint is too slow.
    """
    # Minimum jerk is 1.875 times as fast as it is on average.
    duration = 2.0 * options.sample_period * (len(way) - 1)
    times: Array = np.linspace(0.0, duration, 2 * len(way) - 1, dtype=np.float64)
    places = (len(way) - 1) * (1.0 - minimum_jerk(0.0, duration, times)[0])
    before = np.minimum(places.astype(int), len(way) - 2)
    part = (places - before)[:, None, None]
    passed = np.array(way)
    joints = (1.0 - part) * passed[before] + part * passed[before + 1]
    return _motion(robot, times, joints, now.time + options.reaction_time, len(times) - 1)


def _motion(robot: Robot, times: Array, joints: Array, start: float, given: int) -> JointMotion:
    """Make a motion of samples (n, 4, 3) that ends at rest; a joint may be too slow for it."""
    velocities = np.gradient(joints, times, axis=0)
    velocities[0] = velocities[-1] = 0.0
    _check_speeds(robot, times, joints, velocities)
    fastest = np.broadcast_to(robot.velocity, (4, 3)).reshape(-1)
    return JointMotion(robot.joint_names, times, joints, velocities, fastest, start, given)


def may_reach(robot: Robot, now: Stance, paths: PlannedPaths) -> bool:
    """Tell whether all legs reach at the samples of some paths, which may be a few of a motion."""
    try:
        _joint_angles(robot, _arms(now, paths), _sagged(robot, now.joint_positions))
    except GaitError:
        return False
    return True


def _arms(now: Stance, paths: PlannedPaths) -> Array:
    """Return where the feet are in the body frame, shape (n, 4, 3) [m]."""
    start, end, progress = now.body, paths.end, paths.progress
    position = start.position + progress[:, None] * (end.position - start.position)
    turns = np.array([end.roll - start.roll, end.pitch - start.pitch, turned_by(start, end)])
    angles = np.array([start.roll, start.pitch, start.yaw]) + progress[:, None] * turns
    offsets = paths.feet - position[:, None]
    arms: Array = np.einsum('nji,nkj->nki', matrix_from_angles(angles), offsets)
    return arms


def _check_speeds(robot: Robot, times: Array, joints: Array, velocities: Array) -> None:
    """Raise if a joint is too slow for its samples, or for what the drives make between them."""
    robot.check_joint_speeds(velocities)
    count = len(times)
    between = velocities_between(times, joints.reshape(count, -1), velocities.reshape(count, -1))
    # The last interval is given out with the time that the joints need to come to rest.
    kept = between[:-1].reshape(-1, *joints.shape[1:])
    if len(kept):
        robot.check_joint_speeds(kept / (1.0 + VELOCITY_TOLERANCE))


def _sagged(robot: Robot, joint_positions: Array) -> Array:
    """Return how far load pulls joints out of their ranges, shape (4, 3) [rad]; mostly zeros."""
    outside = joint_positions - np.clip(joint_positions, robot.lower, robot.upper)
    sagged: Array = np.clip(outside, -_MOST_SAG, _MOST_SAG)
    return sagged


def _joint_angles(robot: Robot, feet: Array, sagged: Array) -> Array:
    """
    Find the joints for feet in the body frame, which begin where feet are measured.

    A stretched leg that bears load is beyond the end of a joint's range by a little, and so is
    what is planned from there. It is commanded to the end of the range, as it was before.
    """
    if not sagged.any():
        return robot.joint_angles(feet)
    angles = robot.stacked_legs.inverse(feet)
    outside = angles - np.clip(angles, robot.lower, robot.upper)
    angles = angles - np.clip(outside, np.minimum(sagged, 0.0), np.maximum(sagged, 0.0))
    robot.check_joint_limits(angles)
    return angles


def _reached_joints(robot: Robot, feet: Array, sure: int, sagged: Array) -> Array:
    """Find the joints for feet in the body frame (n, 4, 3); beyond what is sure while reached."""
    needed = min(sure, len(feet))
    # Mostly all are reached: at once that is several times as fast, and the same bit for bit.
    with suppress(GaitError):
        return _joint_angles(robot, feet, sagged)
    joints = _joint_angles(robot, feet[:needed], sagged)
    # Beyond what is sure the foot goes only as deep as the leg reaches: that is found by halving.
    missed = len(feet)
    while missed - needed > 1:
        middle = (needed + missed) // 2
        try:
            joints = _joint_angles(robot, feet[:middle], sagged)
            needed = middle
        except GaitError:
            missed = middle
    return joints


def _stoppable(robot: Robot, joints: Array, sure: int, samples: float) -> int:
    """
    Count the samples beyond what is sure up to which joints stay in their ranges wherever they end.

    What replaces a motion begins at its end, at rest, so many samples later: a joint that is still
    fast overshoots on its way there, and one that stretches a leg to the end is fastest there.
    """
    first = max(sure, 1)
    steps = joints[first:] - joints[first - 1 : -1]
    farthest = joints[first:] + _OVERSHOOT * samples * steps
    goes_out = (farthest < robot.lower) | (farthest > robot.upper)
    out = np.flatnonzero(goes_out.any(axis=(1, 2)))
    return first + int(out[0]) if len(out) else len(joints)


def turned_by(start: BodyPose, end: BodyPose) -> float:
    """Return the change of heading from one pose to another, in [-pi, pi) [rad]."""
    return float((end.yaw - start.yaw + np.pi) % (2.0 * np.pi) - np.pi)
