"""
How long the body takes from one posture to another over feet that stand.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.robot.leg_moments import GRAVITY
from quad_common.robot.robot import Robot
from quad_gait.state.body_placement import BodyPose
from quad_gait.uneven.path_motion import turned_by
from quad_gait.uneven.uneven_options import UnevenOptions

_SWAY = 0.13
"""Distance of the zero moment point from the center of mass while the body goes elsewhere, as a
fraction of the distance between left and right feet: what is gone faster rocks a tall robot."""

_PEAK = 10.0 / math.sqrt(3.0)
"""Largest acceleration of a motion with minimum jerk, times its duration squared, over its
distance."""


class BodyPace:
    """
    Says how long shifts of the body take.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    """

    def __init__(self, robot: Robot, options: UnevenOptions) -> None:
        self._radius = robot.footprint_radius
        self._least = options.shift_time
        self._speed = robot.relative_size * options.shift_speed
        center = robot.center_of_mass(robot.initial_joint_angles)
        height = float(center[2]) + robot.standing_height
        width = float((robot.neutral_feet[::2, 1] - robot.neutral_feet[1::2, 1]).min())
        # The square of the least time of a motion, over its distance [s^2/m].
        self._sway = _PEAK * height / (GRAVITY * _SWAY * width)

    def duration(self, start: BodyPose, end: BodyPose) -> float:
        """
        Return how long the body takes, so that it goes at its speed and does not rock.

        Parameters
        ----------
        start, end : BodyPose
            Where the body is, and is to be.

        Returns
        -------
        float
            [s]
        """
        moved = end.position - start.position
        distance = float(np.linalg.norm(moved))
        turned = np.abs(
            [end.roll - start.roll, end.pitch - start.pitch, turned_by(start, end)]
        ).max()
        distance = max(distance, self._radius * float(turned))
        least = max(self._least, math.sqrt(self._sway * math.hypot(*moved[:2])))
        return max(least, distance / self._speed)
