"""
Whether feet keep out of each other's way.
"""

from __future__ import annotations

import numpy as np

from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.cycle import Cycle


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
