"""
How hard each foot presses on the ground, from the torques of its joints.

A leg that moves slowly is in balance: its motors bear its own weight and what the ground
gives its foot. So the joints' torques tell which feet stand, and no sensor is needed in
the foot.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_moments import weight_torques
from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

_SINGULAR = 1e-6
"""A leg whose Jacobian has a smaller determinant tells nothing [m^3]; relative to its length."""


def foot_forces(robot: Robot, joint_angles: Array, joint_efforts: Array, up: Array) -> Array:
    """
    Find the forces of the ground on the feet.

    With the leg's weight torques g(q) and the foot's Jacobian J the motors' torques are
    tau = g(q) - J^T f, so f = J^-T (g(q) - tau). Accelerations are left out: it holds for
    legs that stand or move slowly.

    Parameters
    ----------
    robot : Robot
        The robot.
    joint_angles : ndarray, shape (4, 3)
        [rad].
    joint_efforts : ndarray, shape (4, 3)
        Torques of the motors about the joints' axes [N m].
    up : ndarray, shape (3,)
        The vertical, upward, in the body's axes.

    Returns
    -------
    ndarray, shape (4, 3)
        In the body's axes [N]; nan for a leg that is stretched or folded so far that its
        torques do not tell the force.
    """
    jacobians = robot.foot_jacobians(joint_angles)
    size = np.abs(np.linalg.det(jacobians))
    tells = size > _SINGULAR * float(robot.legs[0].reach()[1]) ** 3
    missing = weight_torques(robot, joint_angles, up) - joint_efforts
    forces = np.full((len(robot.legs), 3), np.nan)
    transposed = np.swapaxes(jacobians[tells], -1, -2)
    forces[tells] = np.linalg.solve(transposed, missing[tells][..., None])[..., 0]
    return forces
