"""
How stably the robot is planned to stand, at any time of its cycles.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.cycle.stability import stability_margin, support_polygon
from quad_gait.following.motion_sequence import MotionSequence

Array = NDArray[np.float64]


class PlannedSupport:
    """
    Support polygon and stability margin of the cycles that were given out.

    Parameters
    ----------
    robot : Robot
        The robot; between cycles it stands in its initial posture.
    cycles : MotionSequence
        The cycles.
    """

    def __init__(self, robot: Robot, cycles: MotionSequence) -> None:
        self._robot = robot
        self._cycles = cycles

    def margin_at(self, time: float) -> float:
        """Return the predicted stability margin at a time [m]."""
        scheduled = self._cycles.at(time)
        if scheduled is None:
            return self._standing_margin
        cycle = scheduled.cycle
        return float(cycle.margin[cycle.sample(time - scheduled.start)])

    def polygon_at(self, time: float, pose: Pose2D) -> Array:
        """
        Return the support polygon at a time, in the plan's frame.

        Parameters
        ----------
        time : float
            [s].
        pose : Pose2D
            Where the robot is; used while it stands.

        Returns
        -------
        ndarray, shape (n, 2)
            Counter-clockwise [m].
        """
        scheduled = self._cycles.at(time)
        if scheduled is None:
            feet = self._robot.neutral_feet[:, :2]
            return pose.transform(support_polygon(feet, np.ones(4, dtype=bool)))
        cycle = scheduled.cycle
        sample = cycle.sample(time - scheduled.start)
        polygon = support_polygon(cycle.feet[sample, :, :2], cycle.in_contact[sample])
        return scheduled.pose.transform(polygon)

    @cached_property
    def _standing_margin(self) -> float:
        center = self._robot.center_of_mass(self._robot.initial_joint_angles)[:2]
        feet = self._robot.neutral_feet[:, :2]
        return float(stability_margin(center, feet, np.ones(4, dtype=bool)))
