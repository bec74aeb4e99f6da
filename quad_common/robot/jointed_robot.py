"""
Which postures and speeds a robot's joints allow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import JointLimitExceeded, JointNotFound
from quad_common.robot.robot_build import JOINTS_PER_LEG, LEGS, RobotBuild

Array = NDArray[np.float64]


@dataclass(frozen=True)
class JointedRobot(RobotBuild):
    """The numbers of a robot, and what its joints allow."""

    def check_joint_limits(self, joint_angles: Array) -> None:
        """
        Raise if a joint angle is outside its range.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Raises
        ------
        JointLimitExceeded
            Naming the joint that is farthest outside.
        """
        outside = np.maximum(self.lower - joint_angles, joint_angles - self.upper)
        if not np.any(outside > 1e-9):
            return
        worst = int(np.argmax(outside))
        joint = worst % len(self.joint_names)
        raise JointLimitExceeded(
            self.joint_names[joint],
            float(joint_angles.reshape(-1)[worst]),
            float(self.lower.flat[joint]),
            float(self.upper.flat[joint]),
        )

    def check_joint_speeds(self, joint_velocities: Array) -> None:
        """
        Raise if a joint is faster than it can be.

        Parameters
        ----------
        joint_velocities : ndarray, shape (..., 4, 3)
            [rad/s].

        Raises
        ------
        JointLimitExceeded
            Naming the joint that is fastest beside its limit.
        """
        excess = np.abs(joint_velocities) / self.velocity
        if not np.max(excess) > 1.0:
            return
        worst = int(np.argmax(excess))
        joint = worst % len(self.joint_names)
        limit = float(np.broadcast_to(self.velocity, (len(LEGS), JOINTS_PER_LEG)).flat[joint])
        speed = float(joint_velocities.reshape(-1)[worst])
        raise JointLimitExceeded(self.joint_names[joint], speed, -limit, limit, 'rad/s')

    def within_joint_limits(self, joint_angles: Array) -> NDArray[np.bool_]:
        """
        Say which postures are within all joints' ranges.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray of bool, shape (...)
            As :meth:`check_joint_limits` judges them.
        """
        outside = np.maximum(self.lower - joint_angles, joint_angles - self.upper)
        return np.asarray((outside <= 1e-9).all(axis=(-2, -1)))

    def joint_index(self, name: str) -> int:
        """Return the place of a joint in :attr:`joint_names`; raise JointNotFound."""
        try:
            return self.joint_names.index(name)
        except ValueError:
            raise JointNotFound(name, self.joint_names) from None
