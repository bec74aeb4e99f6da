"""
What the robot says of itself, checked: joints, imu and odometry become one measurement.

Every reading is compared with what the robot is able to do: a joint is not outside its range
and turns no faster than its drive, the body does not leap. What is impossible is refused in a
sentence and left out. What falls silent, or is refused for long, is missing: then the robot
comes to rest, and the measurement says why.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import tilt_from_quaternion
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.state.measurement import ImuMotion, Measurement
from quad_gait.state.readings.possible_steps import TURN_SPEED, attitude_step, joint_step, pose_step
from quad_gait.state.readings.reading_age import PromptAges, ReadingAge, SensorAges
from quad_gait.state.readings.series_check import SeriesCheck, Taken
from quad_gait.state.readings.stuck_check import StuckCheck

Array = NDArray[np.float64]

RANGE_MARGIN = 0.25
"""Angle by which a measured joint may be beyond its range, for errors of its encoder [rad]."""

_FIRST_IMU = 1.0
"""Time from the first odometry on in which an imu is to come, where only that tells the attitude
[s]."""

_OVERLOAD = 100.0
"""Number of times its limits that a joint's measured velocity and effort may be, for noise."""


@dataclass(frozen=True)
class InputOptions:
    """How old a reading may be."""

    joint_timeout: float = 0.2
    """Age of joint states at which they are missing [s]."""
    imu_timeout: float = 0.2
    """Age of the imu's readings at which the odometry's attitude takes their place [s]."""
    odometry_has_attitude: bool = True
    """Whether odometry tells roll and pitch; odometry by legs does not."""
    needs_attitude: bool = False
    """Whether the robot is not to walk without an imu that it had, where only that tells them."""


class JointReadings(NamedTuple):
    """What was read of the robot's joints, each of shape (12,) in the robot's order."""

    positions: Array
    """Positions [rad]."""
    velocities: Array | None
    """Velocities [rad/s]; None if they are not given."""
    efforts: Array | None
    """Efforts [N m]; None if they are not given."""
    time: float | None = None
    """Time at which they were measured [s]; None if the message has no stamp."""


class SensorInputs:
    """
    Checks readings as they come, and puts them together.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : InputOptions, optional
        How old a reading may be.
    """

    def __init__(self, robot: Robot, options: InputOptions | None = None) -> None:
        self._options = InputOptions() if options is None else options
        self._limits = limits = JointLimits.of(robot)
        self._range = limits.lower - RANGE_MARGIN, limits.upper + RANGE_MARGIN
        self._most_velocity = _OVERLOAD * limits.velocity
        efforts = np.broadcast_to(robot.effort, robot.lower.shape).reshape(-1)
        self._most_effort = _OVERLOAD * efforts
        self._joint_check = SeriesCheck[Array]('joint state', partial(joint_step, self._limits))
        self._imu_check = SeriesCheck[Array]('imu', attitude_step)
        self._pose_check = SeriesCheck[tuple[Pose2D, Array]]('odometry', pose_step)
        self._joints: JointReadings | None = None
        timeouts = self._options.joint_timeout, self._options.imu_timeout
        self._imu: tuple[Array | None, float | None] = (None, None)
        self._imu_motion: ImuMotion | None = None
        # Where odometry has no attitude nothing else would tell that the body falls.
        patience = math.inf if self._options.odometry_has_attitude else _FIRST_IMU
        prompt = PromptAges.of(robot)
        self._ages = SensorAges(
            ReadingAge('joint states', 'joint states', timeouts[0], prompt.sensors),
            ReadingAge('imu', "the imu's readings", timeouts[1], prompt.sensors, patience),
            prompt,
        )
        self._joints_age, self._imu_age = self._ages.joints, self._ages.imu
        self._stuck = StuckCheck()
        self._is_oriented, self._oriented_at, self._first = False, math.inf, math.inf
        # Why the last joint states were refused; empty if they were not.
        self._joint_refusal = ''
        self.imu_problem = ''
        """That the imu does not tell of now, as a sentence; empty while it does."""
        self._was_moved = False

    def imu_at(self, time: float) -> tuple[Array | None, float | None]:
        """
        Return what the imu says, unless that is old.

        Parameters
        ----------
        time : float
            Now [s].

        Returns
        -------
        tuple of ndarray (4,) or None, and float or None
            Orientation, quaternion xyzw, and yaw rate [rad/s].
        """
        tells = self._imu_age.is_recent(time) and not self._stuck.problem
        return self._imu if tells else (None, None)

    def take_joints(self, readings: JointReadings) -> bool:
        """
        Take joint states.

        Returns
        -------
        bool
            Whether they say something new.

        Raises
        ------
        InvalidMessage
            If a joint cannot be where they say; they are left out then.
        """
        try:
            _check_stamp('joint state', readings.time, self._joints_age)
            self._check_ranges(readings)
            taken = Taken.FITS
            if readings.time is not None:
                taken = self._joint_check.take(readings.time, readings.positions)
        except InvalidMessage as error:
            self._joint_refusal = str(error)
            raise
        if taken is Taken.REPEATED:
            return False
        self._was_moved = self._was_moved or taken is Taken.NEW_SERIES
        self._joint_refusal = ''
        self._joints = readings
        self._joints_age.take(readings.time)
        return True

    def take_imu(
        self,
        time: float | None,
        orientation: Array | None,
        yaw_rate: float | None,
        motion: ImuMotion | None = None,
    ) -> None:
        """
        Take what an imu says.

        Parameters
        ----------
        time : float or None
            When it was measured [s]; None if that is not known.
        orientation : ndarray, shape (4,), or None
            Unit quaternion xyzw; None if it is not measured.
        yaw_rate : float or None
            About the body's z axis [rad/s]; None if it is not measured.
        motion : ImuMotion, optional
            How the body moves, for whoever keeps its balance.

        Raises
        ------
        InvalidMessage
            If the body cannot have turned like that; it is left out then.
        """
        _check_stamp('imu', time, self._imu_age)
        if orientation is not None and time is not None:
            self._imu_check.take(time, orientation)
        if yaw_rate is not None and abs(yaw_rate) > TURN_SPEED:
            raise InvalidMessage(
                'imu', f'its yaw rate is {yaw_rate:.4g} rad/s; {TURN_SPEED:g} are the most'
            )
        self._imu = (orientation, yaw_rate)
        self._imu_motion = motion
        self._stuck.take(orientation)
        self._imu_age.take(time)
        self._is_oriented = self._is_oriented or orientation is not None

    def take_odometry(
        self, time: float, pose: Pose2D, orientation: Array, now: float | None = None
    ) -> Measurement | None:
        """
        Take where the body is, and put everything together.

        Parameters
        ----------
        time : float
            When it was measured [s].
        pose : Pose2D
            Position and heading of base_link.
        orientation : ndarray, shape (4,)
            Unit quaternion xyzw.
        now : float, optional
            Now, by a clock that may differ from the one by which it is stamped [s].

        Returns
        -------
        Measurement or None
            None if it is the same reading as the one before.

        Raises
        ------
        InvalidMessage
            If the body cannot have moved like that; it is left out then.
        """
        taken = self._pose_check.take(time, (pose, orientation))
        if taken is Taken.REPEATED:
            return None
        was_moved = self._was_moved or taken is Taken.NEW_SERIES
        self._was_moved = False
        positions = None if self._joints is None else self._joints.positions
        is_stuck = self._stuck.advance(time, positions, orientation)
        is_imu_recent = self._ages.advance(time, now) and not is_stuck
        self.imu_problem = self._problem_of_imu(self._missing_orientation(time))
        joints, imu = self._joints, self._imu[0] if is_imu_recent else None
        return Measurement(
            time=time,
            pose=pose,
            tilt=max(
                tilt_from_quaternion(orientation), 0.0 if imu is None else tilt_from_quaternion(imu)
            ),
            joint_positions=positions,
            joint_velocities=None if joints is None else joints.velocities,
            orientation=orientation if imu is None else imu,
            joint_efforts=None if joints is None else joints.efforts,
            joint_time=None if joints is None else joints.time,
            problem=self._problem(),
            was_moved=was_moved,
            imu=None if imu is None else self._imu_motion,
            late=self._ages.late,
        )

    def _missing_orientation(self, time: float) -> str:
        """Say that an imu tells turns alone where only it could tell the attitude; else nothing."""
        self._first = min(self._first, time)
        if self._is_oriented:
            self._oriented_at, self._is_oriented = time, False
        if self._options.odometry_has_attitude:
            return ''
        if math.isinf(self._oriented_at):
            return 'no orientation by the imu yet' if time - self._first > _FIRST_IMU else ''
        silence = time - self._oriented_at
        is_missing = silence > self._options.imu_timeout
        return f'no orientation by the imu for {silence:.1f} s' if is_missing else ''

    def _problem_of_imu(self, missing_orientation: str) -> str:
        """Say that an imu does not tell of now, and what follows from it; empty if it does."""
        options = self._options
        problem = self._imu_age.problem or self._stuck.problem or missing_orientation
        if not problem:
            return ''
        if options.odometry_has_attitude:
            return f"{problem}: odometry's attitude takes its place"
        if options.needs_attitude:
            return f'{problem}, and odometry by legs does not tell roll and pitch'
        return f'{problem}: the body is taken to be level, and a fall is not noticed'

    def _problem(self) -> str:
        """Say what is missing for a walk; empty if nothing is."""
        problem = self._problem_of_joints()
        options = self._options
        if not problem and options.needs_attitude and not options.odometry_has_attitude:
            return self.imu_problem
        return problem

    def _problem_of_joints(self) -> str:
        """Say that nothing is known of the joints now; empty if it is."""
        if self._joints is None:
            return self._joint_refusal or 'no joint states yet'
        problem = self._joints_age.problem
        # What is refused comes, and still nothing is known of the joints.
        return problem and (self._joint_refusal or problem)

    def _check_ranges(self, readings: JointReadings) -> None:
        limits, positions = self._limits, readings.positions
        least, largest = self._range
        if not ((least <= positions) & (positions <= largest)).all():
            outside = np.maximum(limits.lower - positions, positions - limits.upper)
            joint = int(np.argmax(np.nan_to_num(outside, nan=np.inf)))
            raise InvalidMessage(
                'joint state',
                f'{limits.joint_names[joint]} is at {positions[joint]:.4g} rad; its '
                f'range is {limits.lower[joint]:.3g} to {limits.upper[joint]:.3g} rad, and '
                f'{RANGE_MARGIN:g} rad more for errors: does its encoder count turns?',
            )
        for what, values, most in (
            ('velocity', readings.velocities, self._most_velocity),
            ('effort', readings.efforts, self._most_effort),
        ):
            if values is not None and not (np.abs(values) <= most).all():
                joint = int(np.argmax(np.nan_to_num(np.abs(values) / most, nan=np.inf)))
                raise InvalidMessage(
                    'joint state',
                    f'the {what} of {limits.joint_names[joint]} is {values[joint]:.4g}; '
                    f'its limit is {most[joint] / _OVERLOAD:.3g}',
                )


def _check_stamp(what: str, time: float | None, age: ReadingAge) -> None:
    """Refuse a reading without a stamp among others that have one: it could be of any time."""
    if time is None and age.is_stamped:
        raise InvalidMessage(what, 'it has no stamp, and those before it have one')
