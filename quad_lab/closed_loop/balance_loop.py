"""
The closed loop of a robot that keeps its balance: sensors of its own, which are noisy and late.
"""

from __future__ import annotations

import contextlib
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.state.measurement import ImuMotion
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.state.state_estimator import EstimatorOptions, StateEstimator
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.closed_loop import ClosedLoop, Place
from quad_sim.engines.simulator import Observation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of what the robot's sensors say."""

    angle: float = 0.0
    """Error of a joint's position [rad]."""
    speed: float = 0.0
    """Error of a joint's velocity [rad/s]."""
    attitude: float = 0.0
    """Error of roll, pitch and yaw [rad]."""
    rate: float = 0.0
    """Error of the gyroscope [rad/s]."""
    force: float = 0.0
    """Error of the accelerometer [m/s^2]."""


NO_NOISE = SensorNoise()
"""Sensors that are exact."""

NOISY = SensorNoise(angle=0.002, speed=0.05, attitude=0.005, rate=0.03, force=0.2)
"""Sensors as small robots have them: encoders of 12 bits, an imu of a few dollars."""


class BalanceLoop(ClosedLoop):
    """
    A robot that is told of its imu, goes by its own legs, and whose trajectories arrive late.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What moves it.
    delay : float
        Time that a trajectory travels [s].
    noise : SensorNoise
        Errors of its sensors.
    seed : int
        Seed of the errors.
    **others
        As :class:`~quad_lab.closed_loop.closed_loop.ClosedLoop` takes them.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Supervisor,
        delay: float = 0.0,
        noise: SensorNoise = NO_NOISE,
        seed: int = 0,
        **others: Any,
    ) -> None:
        super().__init__(robot, controller, **others)
        options = EstimatorOptions(has_leg_odometry=True, starts_at_origin=True)
        self._estimator = StateEstimator(robot, options, controller.support_at)
        self.locate = self._place_by_legs
        self._delay = delay
        self._noise = noise
        self._rng = np.random.default_rng(seed)
        self._in_transit: deque[tuple[float, JointTrajectory]] = deque()
        self.has_imu = True
        """Whether the imu tells."""
        self.is_deaf = False
        """Whether trajectories are lost."""

    @property
    def pose_by_legs(self) -> Pose2D:
        """Pose of the robot by its own legs and imu, where it began at the origin."""
        return self._estimator.leg_odometry.pose

    def _place_by_legs(self, seen: Observation) -> Place:
        return self.pose_by_legs, self.pose_by_legs

    def _step(self) -> None:
        super()._step()
        while self._in_transit and self._in_transit[0][0] <= self.time + 1e-9:
            self._simulation.accept(self._in_transit.popleft()[1])

    def _send(self, trajectory: JointTrajectory) -> None:
        if self.is_deaf:
            return
        if self._delay <= 0.0:
            super()._send(trajectory)
        else:
            self._in_transit.append((self.time + self._delay, trajectory))

    def decide(self, seen: Observation) -> None:
        """Tell the controller of an observation and of the imu, and send what it decides."""
        if self.has_imu:
            self._take_imu(seen)
        super().decide(seen)

    def _take_imu(self, seen: Observation) -> None:
        """Tell what the imu measures."""
        noise, rng = self._noise, self._rng
        rates = seen.angular_velocity_base_in_base + noise.rate * rng.normal(size=3)
        force = seen.specific_force_in_base + noise.force * rng.normal(size=3)
        # A small turn about each axis is half of it in the quaternion.
        attitude = seen.orientation + 0.5 * noise.attitude * rng.normal(size=4)
        attitude /= np.linalg.norm(attitude)
        # A body that turns over is not believed for a moment.
        with contextlib.suppress(InvalidMessage):
            self._estimator.take_imu(seen.time, attitude, float(rates[2]), ImuMotion(rates, force))

    def _readings(self, seen: Observation) -> JointReadings:
        noise, rng = self._noise, self._rng
        return JointReadings(
            seen.joint_positions + noise.angle * rng.normal(size=12),
            seen.joint_velocities + noise.speed * rng.normal(size=12),
            seen.joint_efforts,
            seen.time,
        )
