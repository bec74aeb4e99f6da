"""
What is left of a plan.
"""

from __future__ import annotations

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D


def remaining_plan(plan: Plan, pose: Pose2D) -> Plan:
    """
    Return what is left of a plan for a robot on it, or near it.

    Parameters
    ----------
    plan : Plan
        The plan.
    pose : Pose2D
        The robot, in the frame of the plan.

    Returns
    -------
    Plan
        From the point of the plan that is nearest to the robot, the last one if there are
        several, to the goal.
    """
    corners = plan.corners
    if len(corners) < 2:
        return plan
    a, along = corners[:-1], np.diff(corners, axis=0)
    squared = np.maximum(np.einsum('ij,ij->i', along, along), 1e-18)
    here = np.array([pose.x, pose.y])
    t = np.clip(np.einsum('ij,ij->i', here - a, along) / squared, 0.0, 1.0)
    nearest = a + t[:, None] * along
    distances = np.linalg.norm(nearest - here, axis=1)
    index = len(distances) - 1 - int(np.argmin(distances[::-1]))
    x, y = nearest[index].tolist()
    return Plan((Pose2D(x, y, plan.poses[index].yaw), *plan.poses[index + 1 :]))
