"""
Whether a planned motion keeps the robot's own parts apart, and its knees off the ground.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import PartsTooNear
from quad_common.robot.own_parts import Approach
from quad_common.robot.robot import Robot
from quad_common.robot.robot_shape import Chain

Array = NDArray[np.float64]

_ALIKE = 1e-4
"""Parts that come nearer by less than this count as staying where they are [m]."""


def check_own_parts(
    robot: Robot, times: Array, body_lift: Array, joint_angles: Array, chain: Chain
) -> None:
    """
    Raise if parts come too near to one another, or to level ground.

    Parameters
    ----------
    robot : Robot
        The robot.
    times : ndarray, shape (n,)
        From the start of the motion [s].
    body_lift : ndarray, shape (n,)
        Height of the body above its standing height [m].
    joint_angles : ndarray, shape (n, 4, 3)
        [rad]
    chain : tuple of ndarray
        Where these angles place pitch axes, knees and feet, each of shape (n, 4, 3) [m].

    Raises
    ------
    PartsTooNear
        Naming the parts, and when they are nearest.
    """
    parts = robot.own_parts
    found = parts.too_near(joint_angles, chain)
    if found is None:
        found = parts.too_low(chain, -(robot.standing_height + body_lift))
    if found is not None:
        raise _error(found, times)


def check_nearing_parts(robot: Robot, times: Array, joint_angles: Array) -> None:
    """
    Raise if parts come too near to one another, and nearer than they are at the start.

    A robot whose parts are too near already must be able to move them apart.

    Parameters
    ----------
    robot : Robot
        The robot.
    times : ndarray, shape (n,)
        From the start of the motion [s].
    joint_angles : ndarray, shape (n, 4, 3)
        [rad]

    Raises
    ------
    PartsTooNear
        Naming the parts, and when they are nearest.
    """
    parts = robot.own_parts
    found = parts.too_near(joint_angles)
    if found is None:
        return
    first = parts.shape.clearances(joint_angles[0])[parts.shape.pairs.index(found.pair)]
    if found.clearance < float(first) - _ALIKE:
        raise _error(found, times)


def _error(found: Approach, times: Array) -> PartsTooNear:
    pair = found.pair
    time, duration = float(times[found.sample]), float(times[-1])
    return PartsTooNear(pair.first, pair.second, found.clearance, found.least, time, duration)
