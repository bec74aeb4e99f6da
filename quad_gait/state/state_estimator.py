"""
From what the robot's sensors say to the state that the gait acts on.

Joints, imu and odometry come one by one and are checked; each new odometry makes a state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.state.leg_odometry import LegOdometry
from quad_gait.state.measurement import ImuMotion, Measurement
from quad_gait.state.rest_check import RestCheck
from quad_gait.state.robot_state import RobotState
from quad_gait.state.sensor_inputs import InputOptions, JointReadings, SensorInputs
from quad_gait.state.support import BY_FEET, Supports

Array = NDArray[np.float64]

_CLOCK_SET_BACK = 1.0
"""Time by which a measurement must be older than the last one for that [s]."""

_EFFORTLESS = 50
"""Number of joint states in a row without efforts after which there are none."""


@dataclass(frozen=True)
class EstimatorOptions:
    """How a state is made."""

    inputs: InputOptions = field(default_factory=InputOptions)
    """Ages that readings may have."""
    rest_speed: float = 0.1
    """Speed below which joints are at rest [rad/s]."""
    has_leg_odometry: bool = False
    """Whether the pose by legs is estimated too."""
    starts_at_origin: bool = False
    """Whether that begins at its own frame's origin, and not where odometry has the robot."""


class StateEstimator:
    """
    Puts the readings of sensors together.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : EstimatorOptions, optional
        How a state is made.
    supports : callable, optional
        What bears the robot at a time, for leg odometry; without it level feet do.
    """

    def __init__(
        self,
        robot: Robot,
        options: EstimatorOptions | None = None,
        supports: Supports | None = None,
    ) -> None:
        options = EstimatorOptions() if options is None else options
        self._robot = robot
        self._options = options
        self._supports = supports
        self._inputs = SensorInputs(robot, options.inputs)
        self._rest = RestCheck(robot, options.rest_speed)
        self._last_time = -math.inf
        self._joints_time = math.inf
        self._joints: JointReadings | None = None
        self._without_efforts = 0
        self._is_placed = options.starts_at_origin
        self.leg_odometry = LegOdometry(robot)
        """The pose by legs; stays where it began unless the options ask for it."""

    @property
    def imu_problem(self) -> str:
        """That the imu has fallen silent, as a sentence; empty while it has not."""
        return self._inputs.imu_problem

    @property
    def lacks_efforts(self) -> bool:
        """Whether the last joint states, a good number of them, have no efforts, or only 0."""
        return self._without_efforts >= _EFFORTLESS

    @property
    def newest(self) -> tuple[float | None, Array | None]:
        """
        Time and joints by what was taken last, also where odometry is silent and joints are not.

        Time is odometry's [s]; by the joints' stamps it goes on. Joint positions are of shape (12,)
        [rad]. None for what is not known.
        """
        readings, time = self._joints, self._last_time
        stamp = None if readings is None else readings.time
        if math.isinf(time):
            time = stamp or 0.0
        elif stamp is not None:
            time += max(stamp - self._joints_time, 0.0)
        return (None, None) if readings is None else (time, readings.positions)

    def take_joints(self, readings: JointReadings) -> bool:
        """
        Take joint states.

        Returns
        -------
        bool
            Whether leg odometry has gone on by them.

        Raises
        ------
        InvalidMessage
            If a joint cannot be where they say; they are left out then.
        """
        is_new = self._inputs.take_joints(readings)
        self._joints = readings
        has_efforts = readings.efforts is not None and bool(readings.efforts.any())
        self._without_efforts = 0 if has_efforts else self._without_efforts + 1
        if not (is_new and self._is_placed and self._options.has_leg_odometry):
            return False
        time = readings.time or 0.0
        support = BY_FEET if self._supports is None else self._supports(time)
        imu = self._inputs.imu_at(time)
        self.leg_odometry.update(
            time, readings.positions, support.in_contact, *imu, support.velocity
        )
        return True

    def take_imu(
        self,
        time: float | None,
        orientation: Array | None,
        yaw_rate: float | None,
        motion: ImuMotion | None = None,
    ) -> None:
        """Take what an imu says; see :meth:`SensorInputs.take_imu`."""
        self._inputs.take_imu(time, orientation, yaw_rate, motion)

    def take_odometry(
        self, time: float, pose: Pose2D, orientation: Array, now: float | None = None
    ) -> RobotState | None:
        """
        Take where the body is, and put everything together.

        Parameters
        ----------
        time : float
            When it was measured [s].
        pose : Pose2D
            Position and heading of base_link in odometry's frame.
        orientation : ndarray, shape (4,)
            Unit quaternion xyzw.
        now : float, optional
            Now, by a clock that may differ from the one by which it is stamped [s].

        Returns
        -------
        RobotState or None
            None if it is the same reading as the one before.

        Raises
        ------
        InvalidMessage
            If the body cannot have moved like that; it is left out then.
        """
        measurement = self._inputs.take_odometry(time, pose, orientation, now)
        if measurement is None:
            return None
        if not self._is_placed:
            # From here on the legs tell; where the robot was put they cannot know.
            self.leg_odometry.reset(pose)
            self._is_placed = True
        return self.judge(measurement)

    def judge(self, measurement: Measurement) -> RobotState:
        """Return the state that follows from a measurement, and from those before it."""
        state = RobotState.of(measurement, self._robot, self._rest)
        if measurement.was_moved:
            self._rest.forget()
        elif measurement.time < self._last_time - _CLOCK_SET_BACK:
            self._rest.forget()
            state = replace(state, was_moved=True)
        self._last_time = measurement.time
        self._joints_time = state.measured_at
        if measurement.joint_positions is not None:
            self._rest.take(state.measured_at, measurement.joint_positions)
        return state
