"""
A simulator without physics: joints follow commands exactly, stance feet do not slip.

The body goes where the feet that stay on the ground carry it: its heading and position
are the rigid motion that keeps them in place best, as their balls roll, its height that
of the lowest foot.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.simulator import Observation

Array = NDArray[np.float64]

_GRAVITY = np.array([0.0, 0.0, 9.80665])

_CONTACT_HEIGHT = 1e-3
"""A foot this near to the height of the lowest one is on the ground [m]."""

_MOST_WAITING = 64
"""Number of steps after which the body is moved although nobody looks."""


class KinematicSimulator:
    """
    One robot on a flat, empty floor, moved by its commands alone.

    Parameters
    ----------
    robot : Robot
        The robot.
    time_step : float
        Fixed step [s].
    """

    def __init__(self, robot: Robot, time_step: float = 0.005) -> None:
        self.time_step = time_step
        self.failures: tuple[str, ...] = ('stuck',)
        self._robot = robot
        self._steps = 0
        self.reset(Pose2D(0.0, 0.0, 0.0))

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]."""
        return self._steps * self.time_step

    def reset(self, pose: Pose2D) -> None:
        """Stand the robot at a pose, in its initial posture, at rest, with all joints sound."""
        self._pose = pose
        self._previous = pose
        self._joints: Array = self._robot.initial_joint_angles.reshape(-1).copy()
        self._joint_velocities: Array = np.zeros_like(self._joints)
        self._feet = self._robot.neutral_feet
        self._placed: Array = self._joints
        self._waiting: list[Array] = []
        self._stuck: set[int] = set()

    def fail_joint(self, joint: int, kind: str) -> None:
        """Let a joint stick where it is, whatever the kind: a free one needs physics."""
        self._stuck.add(joint)

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """Advance by one time step; shape (12,) each [rad], [rad/s]."""
        joint_positions = np.array(joint_positions, dtype=float)
        joint_velocities = np.array(joint_velocities, dtype=float)
        if self._stuck:
            stuck = list(self._stuck)
            joint_positions[stuck], joint_velocities[stuck] = self._joints[stuck], 0.0
        self._steps += 1
        self._joints, self._joint_velocities = joint_positions, joint_velocities
        self._waiting.append(joint_positions)
        if len(self._waiting) >= _MOST_WAITING:
            self._move()

    def _move(self) -> None:
        """Move the body as the joints have moved since: arrays of several steps take less time."""
        if not self._waiting:
            return
        joints = np.array([self._placed, *self._waiting])
        self._placed = self._waiting[-1]
        self._waiting = []
        self._previous = self._pose
        # Where no joint moves nothing does.
        moved = (joints[1:] != joints[:-1]).any(axis=1)
        if not moved.any():
            return
        after = joints[1:][moved].reshape(-1, 4, 3)
        before = joints[:-1][moved].reshape(-1, 4, 3)
        spin = self._robot.calf_angular_velocities((before + after) / 2.0, after - before)
        feet = self._robot.foot_positions(after)
        # Feet at rest, but for their rolling: old pose @ old feet = new pose @ new feet.
        rolled = self._robot.foot_radius * spin[..., 1::-1] * (1.0, -1.0)
        rolled += np.concatenate((self._feet[None], feet[:-1]))[..., :2]
        stood = _on_ground(self._feet.tolist())
        for new, old in zip(feet.tolist(), rolled.tolist(), strict=True):
            stand = _on_ground(new)
            pairs = [(a, b) for a, b, *stands in zip(new, old, stood, stand) if all(stands)]
            self._previous = self._pose
            if len(pairs) >= 2:
                self._pose = self._pose @ _rigid_motion(pairs)
            stood = stand
        if not moved[-1]:
            self._previous = self._pose
        self._feet = feet[-1]

    def observe(self) -> Observation:
        """Return the robot's state; the body stays level and touches nothing."""
        self._move()
        moved = self._previous.inverse() @ self._pose
        height = self._robot.foot_radius - float(self._feet[:, 2].min())
        half = self._pose.yaw / 2.0
        return Observation(
            time=self.time,
            position=np.array([self._pose.x, self._pose.y, height]),
            orientation=np.array([0.0, 0.0, np.sin(half), np.cos(half)]),
            linear_velocity_base_in_base=np.array([moved.x, moved.y, 0.0]) / self.time_step,
            angular_velocity_base_in_base=np.array([0.0, 0.0, moved.yaw]) / self.time_step,
            specific_force_in_base=_GRAVITY.copy(),
            joint_positions=self._joints,
            joint_velocities=self._joint_velocities,
            joint_efforts=np.zeros_like(self._joints),
            contacts=(),
            has_fallen=False,
        )

    def close(self) -> None:
        """Nothing to release."""


def _on_ground(feet: list[list[float]]) -> list[bool]:
    """Return which feet, each x, y and z [m], are on the ground."""
    highest = min(z for _, _, z in feet) + _CONTACT_HEIGHT
    return [z < highest for _, _, z in feet]


def _rigid_motion(pairs: list[tuple[list[float], list[float]]]) -> Pose2D:
    """
    Find the planar pose that brings points onto others with least squares.

    In plain numbers: for so few, arrays take ten times as long.
    """
    count = len(pairs)
    x0, y0 = (sum(source[k] for source, _ in pairs) / count for k in (0, 1))
    u0, v0 = (sum(target[k] for _, target in pairs) / count for k in (0, 1))
    offsets = [(a[0] - x0, a[1] - y0, b[0] - u0, b[1] - v0) for a, b in pairs]
    cross = sum(x * v - y * u for x, y, u, v in offsets)
    along = [part for x, y, u, v in offsets for part in (x * u, y * v)]
    yaw = float(np.arctan2(cross, np.sum(along)))
    c, s = math.cos(yaw), math.sin(yaw)
    return Pose2D(u0 - (c * x0 - s * y0), v0 - (s * x0 + c * y0), yaw)
