"""
Whether a planned motion keeps the robot's parts and feet apart, and its knees off the ground.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import PartsTooNear
from quad_common.robot.own_parts import Approach
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.robot.robot_shape import Chain
from quad_gait.cycle.cycle import Cycle

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


def crossing_feet(robot: Robot, cycle: Cycle) -> str:
    """
    Say which feet get in each other's way.

    Parameters
    ----------
    robot : Robot
        The robot.
    cycle : Cycle
        Any cycle.

    Returns
    -------
    str
        A sentence; empty if each foot keeps its place: left of the right ones, front
        before hind, and apart by more than the feet's own size.
    """
    body = cycle.body
    x = cycle.feet[..., 0] - body[:, None, 0]
    y = cycle.feet[..., 1] - body[:, None, 1]
    cos, sin = np.cos(body[:, 2])[:, None], np.sin(body[:, 2])[:, None]
    ahead, left = cos * x + sin * y, cos * y - sin * x
    lf, rf, lh, rh = range(len(LEGS))
    # Legs beside each other may pass fore and aft, if they stay apart sideways.
    for front, hind in ((lf, lh), (rf, rh)):
        gap = np.hypot(ahead[:, front] - ahead[:, hind], left[:, front] - left[:, hind])
        passed = ahead[:, front] < ahead[:, hind]
        if np.any(gap < 2.0 * robot.foot_radius) or np.any(passed):
            k = int(np.argmin(np.where(passed, -1.0, gap)))
            return (
                f'foot {LEGS[hind]} comes within {1e3 * gap[k]:.0f} mm of foot {LEGS[front]} or '
                f'passes it {cycle.times[k]:.2f} s into the cycle; they need '
                f'{2e3 * robot.foot_radius:.0f} mm'
            )
    for left_foot, right_foot in ((lf, rf), (lh, rh)):
        gap = left[:, left_foot] - left[:, right_foot]
        if np.any(gap < 2.0 * robot.foot_radius):
            k = int(np.argmin(gap))
            return (
                f'feet {LEGS[left_foot]} and {LEGS[right_foot]} cross: {1e3 * gap[k]:.0f} mm apart '
                f'sideways {cycle.times[k]:.2f} s into the cycle; they need '
                f'{2e3 * robot.foot_radius:.0f} mm'
            )
    return ''


def _error(found: Approach, times: Array) -> PartsTooNear:
    pair = found.pair
    time, duration = float(times[found.sample]), float(times[-1])
    return PartsTooNear(pair.first, pair.second, found.clearance, found.least, time, duration)
