"""
A walk without topics whose sensors are noisy.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.closed_loop import ClosedLoop, Place
from quad_sim.engines.simulator import Observation


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of normal noise."""

    position: float = 0.0
    """Noise of the position, along each axis [m]."""
    heading: float = 0.0
    """Noise of the heading [rad]."""
    joints: float = 0.0
    """Noise of each joint's angle [rad]."""


class NoisyLoop(ClosedLoop):
    """
    A robot under a controller in a simulator, with noise on what the controller is told.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What moves it.
    noise : SensorNoise
        How much.
    rng : numpy.random.Generator
        What the noise is drawn with.
    **others
        As :class:`~quad_lab.closed_loop.closed_loop.ClosedLoop` takes them.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Supervisor,
        noise: SensorNoise,
        rng: np.random.Generator,
        **others: Any,
    ) -> None:
        super().__init__(robot, controller, **others)
        self._noise = noise
        self._rng = rng
        self.locate = self.noisy_place

    def noisy_place(self, seen: Observation) -> Place:
        """Return where the robot takes itself to be."""
        true, noise = seen.pose, self._noise
        if not (noise.position or noise.heading):
            return true, true
        x, y, yaw = self._rng.standard_normal(3).tolist()
        told = Pose2D(
            true.x + noise.position * x, true.y + noise.position * y, true.yaw + noise.heading * yaw
        )
        return told, told

    def _readings(self, seen: Observation) -> JointReadings:
        readings = super()._readings(seen)
        if not self._noise.joints:
            return readings
        noise = self._noise.joints * self._rng.standard_normal(seen.joint_positions.shape)
        return JointReadings(
            seen.joint_positions + noise, seen.joint_velocities, seen.joint_efforts, seen.time
        )
