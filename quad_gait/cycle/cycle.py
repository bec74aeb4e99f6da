"""
A planned gait cycle: body, feet, joints and stability margin at its samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CycleEnds:
    """What joins a cycle to the ones before and after it; from rest to rest if not given."""

    start_feet: Array | None = None
    """Feet in the body frame at the start, shape (4, 3) [m]; None: the initial posture."""
    entry: Twist2D = STILL
    """Velocity of the body at the start, on average over a cycle at that pace."""
    exit: Twist2D = STILL
    """Velocity of the body at the end, on average over a cycle at that pace."""


AT_REST = CycleEnds()
"""Ends of a cycle that begins in the initial posture and ends there, without speed."""


@dataclass(frozen=True)
class Cycle:
    """One planned cycle, sampled; n samples, ground frame as in ``body_motion``."""

    gait: Gait
    """Gait of the cycle."""
    motion: BodyMotion
    """Motion of the body in the cycle."""
    entry: Twist2D
    """Velocity of the body at the start, on average over a cycle at that pace."""
    exit: Twist2D
    """Velocity of the body at the end, on average over a cycle at that pace."""
    times: Array
    """Times from the start of the cycle, shape (n,) [s]."""
    body: Array
    """Pose x, y, yaw of base_link in the ground frame, sway included, shape (n, 3) [m, rad]."""
    feet: Array
    """Centers of the feet in the ground frame, shape (n, 4, 3) [m]."""
    in_contact: NDArray[np.bool_]
    """Whether a foot is on the ground, shape (n, 4)."""
    joint_positions: Array
    """Joint angles, shape (n, 4, 3) [rad]."""
    joint_velocities: Array
    """Joint speeds, shape (n, 4, 3) [rad/s]."""
    end_feet: Array
    """Centers of the feet in the body frame at the end, shape (4, 3) [m]."""
    center_of_mass: Array
    """Center of mass projected to the ground, in the ground frame, shape (n, 2) [m]."""
    margin: Array
    """Static stability margin, shape (n,) [m]."""
    limit: str = ''
    """Reason why no more of the wanted motion is in it; empty if nothing forbade more."""

    @property
    def least_margin(self) -> float:
        """Least stability margin of the cycle [m]."""
        return float(np.min(self.margin))

    @property
    def period(self) -> float:
        """Duration of the cycle [s]."""
        return self.gait.cycle_period

    def sample(self, time: float) -> int:
        """Return the index of the sample nearest to a time from the cycle's start [s]."""
        return min(max(round(time / float(self.times[1])), 0), len(self.times) - 1)

    def pose_at(self, time: float) -> Pose2D:
        """Return where the body is planned to be, sway included, in the ground frame."""
        x, y, yaw = (float(np.interp(time, self.times, self.body[:, k])) for k in range(3))
        return Pose2D(x, y, yaw)

    @property
    def is_at_rest_first(self) -> bool:
        """Whether no joint moves before the gait's ``motion_start``."""
        return not self.entry

    def trajectory(self, robot: Robot, stamp: float) -> JointTrajectory:
        """
        Write the cycle's motion as a joint trajectory.

        Parameters
        ----------
        robot : Robot
            Whose joints.
        stamp : float
            When the cycle starts [s].

        Returns
        -------
        JointTrajectory
            From the first movement to the end of the cycle; before it the joints rest.
        """
        start = self.gait.motion_start if self.is_at_rest_first else 0.0
        first = int(np.searchsorted(self.times, start + 1e-9, side='right')) - 1
        joints = len(robot.joint_names)
        return JointTrajectory(
            joint_names=robot.joint_names,
            stamp=stamp,
            times=self.times[first:],
            positions=self.joint_positions[first:].reshape(-1, joints),
            velocities=self.joint_velocities[first:].reshape(-1, joints),
        )
