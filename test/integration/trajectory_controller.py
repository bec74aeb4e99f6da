"""
ros2_control's joint_trajectory_controller, as far as its topic goes: what it refuses and commands.

Written after the rules of ROS 2 Jazzy's controller, with the settings of an exported robot; see
``docs/hardware.md``.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from trajectory_msgs.msg import JointTrajectory

from quad_common.ros.pose_conversions import seconds_from_time

SMALLEST = float(np.finfo(np.float32).eps)
"""Speed at the last point that counts as none [rad/s]."""


class TrajectoryController:
    """
    Commands joints by the last trajectory that it was given.

    Parameters
    ----------
    joints : list of str
        Names of the joints.
    positions : ndarray, shape (n,)
        Where they are when the controller is activated [rad].
    """

    def __init__(self, joints, positions):
        self.joints = list(joints)
        self.time = 0.0
        self.position = np.array(positions, dtype=float)
        self.velocity = np.zeros_like(self.position)
        self._path = None

    def refusal(self, message: JointTrajectory, now: float) -> str:
        """Return why a message is refused; nothing if it is taken."""
        count = len(self.joints)
        if sorted(message.joint_names) != sorted(self.joints):
            return "its joints are not the controller's"
        if not message.points:
            return 'it is empty'
        if max(map(abs, message.points[-1].velocities), default=0.0) > SMALLEST:
            return 'its last point is not at rest'
        times = [_seconds(point.time_from_start) for point in message.points]
        start = seconds_from_time(message.header.stamp)
        if start != 0.0 and start + times[-1] < now:
            return 'it has ended'
        if any(later <= earlier for earlier, later in pairwise(times)):
            return 'its times do not rise'
        for point in message.points:
            if len(point.positions) != count:
                return 'a point has not as many positions as joints'
            if len(point.velocities) not in (0, count):
                return 'a point has not as many velocities as joints'
            if point.accelerations or point.effort:
                return 'it has accelerations or efforts'
        return ''

    def take(self, message: JointTrajectory) -> None:
        """Replace the trajectory; the way to its first point begins at the last command."""
        order = [message.joint_names.index(name) for name in self.joints]
        start = seconds_from_time(message.header.stamp) or self.time
        times = np.array([start + _seconds(point.time_from_start) for point in message.points])
        positions = np.array([point.positions for point in message.points])[:, order]
        velocities = np.array([point.velocities for point in message.points])[:, order]
        if times[0] > self.time:
            times = np.concatenate([[self.time], times])
            positions = np.vstack([self.position, positions])
            velocities = np.vstack([self.velocity, velocities])
        self._path = CubicHermiteSpline(times, positions, velocities), times[-1]

    def update(self, now: float) -> None:
        """Command the joints for an instant."""
        if self._path is not None:
            curve, end = self._path
            self.position = curve(min(now, end))
            self.velocity = curve(now, 1) if now < end else np.zeros_like(self.position)
        self.time = now


def _seconds(duration) -> float:
    return duration.sec + 1e-9 * duration.nanosec
