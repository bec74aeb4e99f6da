"""
Standing up and sitting down: all joints at once, feet where they are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.body_motion import minimum_jerk

Array = NDArray[np.float64]

_GROUND_CLEARANCE = 0.01
"""Distance between the lowest part of a sitting body and the ground [m]."""

_HEIGHTS = 60
"""Number of heights that are tried between standing and the ground."""


def crouching_joint_angles(robot: Robot) -> Array:
    """
    Find the posture with the body as low as it goes, feet as in the initial posture.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    ndarray, shape (4, 3)
        Joint angles [rad]: within their limits, and body and knees clear of the ground.
    """
    highest = robot.standing_height
    lowest = robot.body_size[2] / 2.0 - robot.body_center[2] + _GROUND_CLEARANCE
    angles = robot.initial_joint_angles
    for height in np.linspace(highest, min(lowest, highest), _HEIGHTS)[1:]:
        feet = robot.neutral_feet + np.array([0.0, 0.0, highest - height])
        try:
            lower = robot.joint_angles(feet)
        except GaitError:
            break
        if _lowest_joint(robot, lower) + height < _GROUND_CLEARANCE:
            break
        angles = lower
    return angles


def _lowest_joint(robot: Robot, joint_angles: Array) -> float:
    """Height of the lowest part of hips and knees above base_link [m]."""
    heights = []
    for leg, angles in zip(robot.legs, joint_angles):
        pitch_axis, knee, _ = leg.chain(angles)
        heights.append(min(pitch_axis[2], leg.hip[2]) - robot.links['hip'].radius)
        heights.append(knee[2] - robot.links['calf'].radius)
    return float(min(heights))


def posture_trajectory(
    robot: Robot,
    joint_positions: Array,
    posture: Array,
    stamp: float,
    duration: float,
    sample_period: float,
) -> JointTrajectory:
    """
    Move all joints to a posture with minimum jerk.

    Parameters
    ----------
    robot : Robot
        The robot.
    joint_positions : ndarray, shape (12,)
        Where the joints are [rad].
    posture : ndarray, shape (4, 3)
        Where they are to go [rad].
    stamp : float
        When they begin to move [s].
    duration : float
        How long they take [s]; longer if a joint is not fast enough.
    sample_period : float
        Longest time between points [s].

    Returns
    -------
    JointTrajectory
        At rest at both ends.
    """
    # Minimum jerk is at most 15/8 times as fast as the mean.
    change = posture.reshape(-1) - joint_positions
    fastest = np.abs(change) / np.broadcast_to(robot.velocity, (4, 3)).reshape(-1)
    duration = max(duration, 1.875 * float(fastest.max()))
    steps = int(np.ceil(duration / sample_period))
    times = np.linspace(0.0, duration, steps + 1, dtype=np.float64)
    fraction, rate = minimum_jerk(0.0, duration, times)
    return JointTrajectory(
        joint_names=robot.joint_names,
        stamp=stamp,
        times=times,
        positions=joint_positions + fraction[:, None] * change,
        velocities=rate[:, None] * change,
    )
