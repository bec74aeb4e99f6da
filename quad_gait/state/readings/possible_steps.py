"""
How far joints and body may get from one reading to the next: what is farther, no robot does.

Each function says what is impossible about a step, as a clause; empty if it is possible.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.trajectory.trajectory_gate import JointLimits

Array = NDArray[np.float64]

TURN_SPEED = 20.0
"""Largest speed with which a body turns [rad/s]."""

_TURN_NOISE = 0.3
"""Angle by which two readings of the attitude may differ anyway [rad]."""

_OVERSPEED = 4.0
"""Number of times its largest speed that a joint may turn, as when the robot falls."""

_JOINT_NOISE = 0.08
"""Angle by which two readings of a joint may differ at any rate [rad]."""

_BODY_SPEED, _BODY_NOISE = 5.0, 0.15
"""Speed of the body [m/s], and distance by which two readings may differ at any rate [m]."""


def joint_step(limits: JointLimits, before: Array, after: Array, dt: float) -> str:
    """Say what is impossible about the joints' step, shape (12,) [rad], in a time [s]."""
    most = _OVERSPEED * limits.velocity * dt + _JOINT_NOISE
    step = np.abs(after - before)
    if (step <= most).all():
        return ''
    joint = int(np.argmax(step / most))
    return (
        f'{limits.joint_names[joint]} would have turned by {step[joint]:.3f} rad '
        f'in {dt:.3f} s; its largest speed is {limits.velocity[joint]:.3g} rad/s'
    )


def attitude_step(before: Array, after: Array, dt: float) -> str:
    """Say what is impossible about a turn from one unit quaternion xyzw to another."""
    turn = 2.0 * math.acos(min(1.0, abs(float(np.dot(before, after)))))
    if turn <= TURN_SPEED * dt + _TURN_NOISE:
        return ''
    return f'the body would have turned by {math.degrees(turn):.0f} degrees in {dt:.3f} s'


def pose_step(before: tuple[Pose2D, Array], after: tuple[Pose2D, Array], dt: float) -> str:
    """Say what is impossible about the step of a body, pose and unit quaternion."""
    distance = before[0].distance_to(after[0])
    if distance > _BODY_SPEED * dt + _BODY_NOISE:
        return f'the body would have moved by {distance:.3g} m in {dt:.3f} s'
    turn = abs(wrap_angle(after[0].yaw - before[0].yaw))
    if turn > TURN_SPEED * dt + _TURN_NOISE:
        return f'the body would have turned by {math.degrees(turn):.0f} degrees in {dt:.3f} s'
    return attitude_step(before[1], after[1], dt)
