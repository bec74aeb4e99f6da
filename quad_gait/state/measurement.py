"""
What the gait is told about the robot at one instant.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D

Array = NDArray[np.float64]


class ImuMotion(NamedTuple):
    """How the body moves by its imu, in its own axes."""

    angular_velocity: Array
    """Angular velocity, shape (3,) [rad/s]."""
    specific_force: Array | None
    """What the accelerometer measures, +g upward at rest, shape (3,) [m/s^2]; None without one."""


@dataclass(frozen=True)
class Measurement:
    """What is known of the robot at one instant."""

    time: float
    """Time of the measurement [s]."""
    pose: Pose2D
    """Pose of base_link in the plan's frame; leaps when a localiser corrects odometry."""
    tilt: float
    """Angle between the body's z axis and the vertical [rad]."""
    joint_positions: Array | None
    """Positions of the joints, shape (12,) [rad]; None before the first were received."""
    joint_velocities: Array | None
    """Velocities of the joints, shape (12,) [rad/s]; None where they are not measured."""
    orientation: Array | None = None
    """Attitude of the body, quaternion xyzw, shape (4,); None: level."""
    joint_efforts: Array | None = None
    """Torques of the motors, shape (12,) [N m]; None where they do not tell."""
    joint_time: float | None = None
    """Time at which the joints were measured [s]; None: ``time``."""
    problem: str = ''
    """What is missing for a walk, as a sentence; empty if nothing is."""
    was_moved: bool = False
    """Whether something else has moved the robot since the last one, as a reset does."""
    odometry: Pose2D | None = None
    """Pose of base_link in odometry's own frame, without leaps; None: that is the plan's frame."""
    imu: ImuMotion | None = None
    """Motion by the imu; None where it does not tell attitude and motion, or has fallen silent."""
    late: str = ''
    """That readings come too late to keep the balance by, as a sentence; empty if they do not."""

    @property
    def motion_pose(self) -> Pose2D:
        """Pose of base_link that tells how the robot has moved, and nothing else."""
        return self.pose if self.odometry is None else self.odometry

    def pose_corrected_as(self, before: Measurement) -> Pose2D:
        """Return the pose in the plan's frame by the correction of an earlier measurement."""
        if self.odometry is None or before.odometry is None:
            return self.pose
        return before.pose @ before.odometry.inverse() @ self.odometry
