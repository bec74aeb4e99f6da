"""
What the gait knows of the robot at one instant: what was measured, and what follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import angles_from_quaternion, matrix_from_angles
from quad_gait.cycle.stability import stability_margin, support_polygon
from quad_gait.state.measurement import Measurement
from quad_gait.state.rest_check import RestCheck
from quad_gait.state.stance import Stance

Array = NDArray[np.float64]

_LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True)
class RobotState(Measurement):
    """
    A measurement, with what a behaviour asks of it.

    What takes time is computed when it is first needed, and once. ``was_moved`` also says that
    the clock was set back: nothing that was planned before holds then.
    """

    robot: Robot = field(kw_only=True, repr=False, compare=False)
    """The robot."""
    rest: RestCheck = field(kw_only=True, repr=False, compare=False)
    """Positions of the joints of late; asked while this is the newest state."""

    @classmethod
    def of(cls, measurement: Measurement, robot: Robot, rest: RestCheck) -> RobotState:
        """Return the state that a measurement tells of."""
        # A frozen dataclass sets its fields one by one: that takes as long as a whole decision.
        state = cls.__new__(cls)
        state.__dict__.update(measurement.__dict__, robot=robot, rest=rest)
        return state

    def placed(self, pose: Pose2D, odometry: Pose2D) -> RobotState:
        """Return this state at another pose on the map, and by odometry."""
        return replace(self, pose=pose, odometry=odometry)

    @property
    def has_joints(self) -> bool:
        """Whether the joints have been measured at all."""
        return self.joint_positions is not None

    @property
    def balance_problem(self) -> str:
        """Reason why imu and joints do not tell how the body moves now; empty if they do."""
        if self.imu is None:
            return 'no imu tells its attitude and motion'
        if self.joint_velocities is None:
            return 'no joint velocities'
        return self.late

    @cached_property
    def joints(self) -> Array:
        """Joint positions by leg, shape (4, 3) [rad]; for a state that has joints."""
        assert self.joint_positions is not None
        return self.joint_positions.reshape(4, 3)

    @property
    def measured_at(self) -> float:
        """Time at which the joints were measured [s]."""
        return self.time if self.joint_time is None else self.joint_time

    @property
    def is_at_rest(self) -> bool:
        """Whether the joints are at rest."""
        return self.rest.is_at_rest(self.joint_velocities)

    @property
    def what_moves(self) -> str:
        """The joint that moves most, with its numbers, as a phrase."""
        return self.rest.what_moves(self.joint_velocities)

    @cached_property
    def level_feet(self) -> tuple[Array, Array]:
        """Feet (4, 2) and center of mass (2,) in base_link's axes, made level [m]."""
        feet = self.robot.foot_positions(self.joints)
        center = self.robot.center_of_mass(self.joints)
        if self.orientation is not None:
            roll, pitch, _ = angles_from_quaternion(self.orientation)
            rotation = matrix_from_angles(np.array([roll, pitch, 0.0]))
            feet, center = feet @ rotation.T, center @ rotation.T
        return feet[:, :2], center[:2]

    def stance(self, since: Measurement | None = None) -> Stance:
        """
        Return how the robot stands: its body, its feet, and what they bear.

        Parameters
        ----------
        since : Measurement, optional
            The pose is corrected as it was then; without one it is odometry's own.
        """
        return Stance.measured(
            self.robot,
            self.time,
            self.motion_pose if since is None else self.pose_corrected_as(since),
            _LEVEL if self.orientation is None else self.orientation,
            self.joints,
            self.joint_efforts,
        )

    def stability_margin(self, in_contact: NDArray[np.bool_]) -> float:
        """Return the static stability margin over the feet that stand, (4,) [m]; or NaN."""
        if not self.has_joints:
            return float('nan')
        feet, center = self.level_feet
        return float(stability_margin(center, feet, in_contact))

    def support_polygon(self, in_contact: NDArray[np.bool_]) -> Array:
        """Return the support polygon in the plan's frame, counter-clockwise, (n, 2) [m]."""
        if not self.has_joints:
            return np.empty((0, 2))
        return self.pose.transform(support_polygon(self.level_feet[0], in_contact))
