"""
Leg odometry: where the body is, from joint angles, feet on the ground and the imu.

A foot that was on the ground a moment ago, and is now, has stayed where it was, but for
the rolling of its ball: so the body has moved. Nothing else is assumed of the gait, and
the same law holds standing, swaying, in a crawl, in a trot and with a single foot down.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import InvalidMessage
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.rotations import matrix_from_unit_quaternion
from quad_gait.state.foot_steps import FootStep, displacement, turn_of_feet

Array = NDArray[np.float64]

CONTACT_HEIGHT = 0.01
"""A foot no higher above the lowest than this fraction of the hips' height is on the ground."""

LARGEST_ANGLE = 20.0
"""Angle of a joint, however its turns are counted [rad]."""

LONGEST_STEP = 0.5
"""Time between updates after which nothing is known of what happened meanwhile [s]."""

LONGEST_HOLD = 0.1
"""Time for which the last velocity is trusted while no foot measures it [s]."""

SLIP = 0.02
"""Standard deviation of the distance after the first metre [m]; it grows with the root."""

TURNING_SLIP = 0.02
"""
Standard deviation of the heading by the feet, after the first radian and after the first metre
[rad].
"""

GYRO_DRIFT = 0.001
"""Standard deviation of the heading by the imu, after the first second [rad]."""

_LEVEL = np.eye(3)
"""Tilt of a body whose orientation is not known."""


class _Sample(NamedTuple):
    """
    What is known at one instant. The level frame has the body's heading, and z up.

    Feet are plain numbers: so few are added up faster than arrays are made of them.
    """

    time: float
    joint_angles: Array
    """Shape (4, 3) [rad]."""
    tilt: Array
    """Rotation from the body's axes to the level frame, shape (3, 3)."""
    feet: Sequence[Sequence[float]]
    """x, y and z of each relative to base_link, in the level frame [m]."""
    in_contact: Sequence[bool]
    """Whether each foot is on the ground."""
    heading: float | None
    """Heading by the imu's orientation [rad]."""
    yaw_rate: float | None
    """[rad/s]"""


class LegOdometry:
    """
    Dead reckoning of base_link in the plane.

    Between two updates with the feet's centers p_k and p'_k relative to the body, in
    axes that are level and have the body's heading, turned by dyaw, a standing foot
    gives the body's displacement in the axes of the middle of the step::

        u_k = R(-dyaw/2) p_k - R(dyaw/2) p'_k + r (w_k x z)

    Here r is the radius of the foot's ball and w_k the small rotation of the calf, to
    which it is fixed, in the world: the center of a ball that rolls on the ground moves
    by r (w x z). The body moves by the mean over the feet that stood at both instants,
    which is the least-squares solution.

    The heading comes from increments of the imu's orientation; without one from its yaw
    rate (trapezoids); without that from the rigid motion in the plane that fits two or
    more standing feet best. Without orientation the body is taken to be level.

    Where a filter of legs and accelerometer knows the velocity better, as feet slip and bounce in
    a trot, the body moves by that.

    While no foot stood at both instants the last velocity is held for at most 0.1 s in
    a row, and taken as zero after that. So is the last yaw rate while neither the imu
    nor two feet tell the heading.

    Parameters
    ----------
    robot : Robot
        The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._contact_height = CONTACT_HEIGHT * robot.hip_height
        self.reset(Pose2D(0.0, 0.0, 0.0))

    @property
    def pose(self) -> Pose2D:
        """Pose of base_link, in the frame of the pose given to :meth:`reset`."""
        return self._pose

    @property
    def twist(self) -> tuple[float, float, float]:
        """vx, vy [m/s] and wz [rad/s] in the body's axes, mean since the update before."""
        return self._twist

    @property
    def height(self) -> float:
        """Height of base_link above the ground [m]; while no foot stands, the last one."""
        return self._height

    @property
    def covariance(self) -> Array:
        """
        Of x, y [m] and yaw [rad] in the frame of the pose, shape (3, 3).

        A random walk, zero at a reset: :data:`SLIP` per root metre along x and y each,
        and in the heading :data:`GYRO_DRIFT` per root second by the imu, or
        :data:`TURNING_SLIP` per root radian and root metre by the feet. An error of the
        heading carries over to the distance walked after it.
        """
        xx, xy, yy, xt, yt, tt = self._covariance
        return np.array([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])

    def reset(self, pose: Pose2D) -> None:
        """
        Put the body at a pose, at rest; the next update begins from there.

        Parameters
        ----------
        pose : Pose2D
            Of base_link.

        Raises
        ------
        InvalidMessage
            If it is not finite.
        """
        if not pose.is_finite():
            raise InvalidMessage('pose', f'it is {pose}')
        self._pose = pose
        self._twist = (0.0, 0.0, 0.0)
        self._height = self._robot.standing_height
        # Of x with x, x with y, y with y, and of x, y and yaw with yaw.
        self._covariance = (0.0,) * 6
        self._last: _Sample | None = None
        self._time_without_feet = 0.0
        self._time_without_heading = 0.0

    def update(
        self,
        time: float,
        joint_positions: ArrayLike,
        in_contact: ArrayLike | None = None,
        orientation: ArrayLike | None = None,
        yaw_rate: float | None = None,
        velocity: tuple[float, float] | None = None,
    ) -> Pose2D:
        """
        Take in what the robot measures at one instant.

        If the time does not rise, or jumps by more than 0.5 s, the pose stays as it is
        and increments start again from this instant.

        Parameters
        ----------
        time : float
            Of the measurement [s].
        joint_positions : array_like, shape (12,)
            In the order of ``Robot.joint_names`` [rad].
        in_contact : array_like of bool, shape (4,), optional
            Which feet bear load. If not given: those that are, seen along gravity, no
            higher above the lowest than 1 % of the hips' height.
        orientation : array_like, shape (4,), optional
            Of the body in any frame with z up, by the imu: quaternion xyzw.
        yaw_rate : float, optional
            Of the body about the vertical, by the imu [rad/s].
        velocity : tuple of float, optional
            Of the body since the update before, along its heading and to the left, if it is known
            otherwise than by these feet [m/s].

        Returns
        -------
        Pose2D
            :attr:`pose`.

        Raises
        ------
        InvalidMessage
            If a number is not finite, a shape is wrong, a joint is beyond
            :data:`LARGEST_ANGLE` or the quaternion is no rotation; the update then counts
            for nothing.
        """
        now = self._sample(time, joint_positions, in_contact, orientation, yaw_rate)
        before, self._last = self._last, now
        heights = [foot[2] for foot, stands in zip(now.feet, now.in_contact) if stands]
        if heights:
            self._height = self._robot.foot_radius - sum(heights) / len(heights)
        if before is None or not 0.0 < now.time - before.time <= LONGEST_STEP:
            if before is None or now.time != before.time:
                self._twist = (0.0, 0.0, 0.0)
            self._time_without_feet = self._time_without_heading = 0.0
        else:
            self._move_on(before, now, velocity)
        return self._pose

    def _move_on(self, before: _Sample, now: _Sample, known: tuple[float, float] | None) -> None:
        """Move the body by what the feet that stand, and the heading, tell of the time between."""
        dt = now.time - before.time
        rolled = self._rolled(before, now)
        steps = [
            FootStep(*first[:2], *last[:2], *roll)
            for first, last, roll, stood, stands in zip(
                before.feet, now.feet, rolled, before.in_contact, now.in_contact
            )
            if stood and stands
        ]
        turn = self._turn(before, now, steps, dt)
        if known is not None:
            self._time_without_feet = 0.0
            x, y = known[0] * dt, known[1] * dt
            velocity = known
        elif steps:
            self._time_without_feet = 0.0
            x, y = displacement(steps, turn)
            velocity = (x / dt, y / dt)
        else:
            held = _time_held(self._time_without_feet, dt)
            self._time_without_feet += dt
            x, y = self._twist[0] * held, self._twist[1] * held
            is_held = self._time_without_feet <= LONGEST_HOLD
            velocity = self._twist[:2] if is_held else (0.0, 0.0)
        self._advance(x, y, turn)
        self._grow_covariance(x, y, turn, dt, by_imu=_has_heading(before, now))
        self._twist = (*velocity, turn / dt)

    def _sample(
        self,
        time: float,
        joint_positions: ArrayLike,
        in_contact: ArrayLike | None,
        orientation: ArrayLike | None,
        yaw_rate: float | None,
    ) -> _Sample:
        if not math.isfinite(time):
            raise InvalidMessage('odometry input', f'its time is {time}')
        if yaw_rate is not None and not math.isfinite(yaw_rate):
            raise InvalidMessage('imu', f'its yaw rate is {yaw_rate}')
        angles = _finite('joint state', joint_positions, (len(self._robot.joint_names),))
        largest = max(map(abs, angles.tolist()))
        if largest > LARGEST_ANGLE:
            raise InvalidMessage(
                'joint state', f'a joint is at {largest:.4g} rad; {LARGEST_ANGLE:g} are the most'
            )
        joint_angles = angles.reshape(len(LEGS), -1)
        tilt, heading = _LEVEL, None
        if orientation is not None:
            tilt, heading = _tilt_and_heading(_finite('imu', orientation, (4,)))
        feet = (self._robot.foot_positions(joint_angles) @ tilt.T).tolist()
        if in_contact is None:
            lowest = min(z for _, _, z in feet)
            contact = [z - lowest <= self._contact_height for _, _, z in feet]
        else:
            given = np.array(in_contact, dtype=bool)
            if given.shape != (len(LEGS),):
                raise InvalidMessage('contact', f'it has shape {given.shape}, not {(len(LEGS),)}')
            contact = given.tolist()
        return _Sample(time, joint_angles, tilt, feet, contact, heading, yaw_rate)

    def _rolled(self, before: _Sample, now: _Sample) -> list[list[float]]:
        """Displacement x, y of each foot's center by rolling, in level axes halfway [m]."""
        middle = (before.joint_angles + now.joint_angles) / 2.0
        change = now.joint_angles - before.joint_angles
        calf = self._robot.calf_angular_velocities(middle, change)
        tilting = (now.tilt @ before.tilt.T).tolist()
        # The part about z is the heading's: it rolls nothing.
        body_x, body_y = tilting[2][1] - tilting[1][2], tilting[0][2] - tilting[2][0]
        half_radius = self._robot.foot_radius / 2.0
        return [
            [half_radius * (body_y + y), -half_radius * (body_x + x)]
            for x, y, _ in (calf @ (before.tilt + now.tilt).T).tolist()
        ]

    def _turn(self, before: _Sample, now: _Sample, steps: Sequence[FootStep], dt: float) -> float:
        """Change of heading since the last update [rad]."""
        gap, self._time_without_heading = self._time_without_heading, 0.0
        if before.heading is not None and now.heading is not None:
            return wrap_angle(now.heading - before.heading)
        if now.yaw_rate is not None:
            first = now.yaw_rate if before.yaw_rate is None else before.yaw_rate
            return dt * (first + now.yaw_rate) / 2.0
        if len(steps) >= 2:
            return turn_of_feet(steps)
        self._time_without_heading = gap + dt
        return self._twist[2] * _time_held(gap, dt)

    def _advance(self, x: float, y: float, turn: float) -> None:
        """Move by a displacement (x, y) in the axes halfway [m], and turn [rad]."""
        last = self._pose
        c, s = math.cos(last.yaw + turn / 2.0), math.sin(last.yaw + turn / 2.0)
        self._pose = Pose2D(
            last.x + c * x - s * y, last.y + s * x + c * y, wrap_angle(last.yaw + turn)
        )

    def _grow_covariance(self, x: float, y: float, turn: float, dt: float, by_imu: bool) -> None:
        """Add a step's errors; that of the heading before it, times a and b, moves x and y."""
        distance = math.hypot(x, y)
        heading = self._pose.yaw - turn / 2.0
        c, s = math.cos(heading), math.sin(heading)
        a, b = -x * s - y * c, x * c - y * s
        along = SLIP**2 * distance
        about = GYRO_DRIFT**2 * dt if by_imu else TURNING_SLIP**2 * (abs(turn) + distance)
        xx, xy, yy, xt, yt, tt = self._covariance
        self._covariance = (
            xx + 2.0 * a * xt + a * a * tt + along,
            xy + a * yt + b * xt + a * b * tt,
            yy + 2.0 * b * yt + b * b * tt + along,
            xt + a * tt,
            yt + b * tt,
            tt + about,
        )


def _finite(what: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.array(values, dtype=float)
    if array.shape != shape:
        raise InvalidMessage(what, f'it has numbers of shape {array.shape}, not {shape}')
    if not all(map(math.isfinite, array.tolist())):
        raise InvalidMessage(what, f'its numbers are not finite: {array.tolist()}')
    return array


def _has_heading(before: _Sample, now: _Sample) -> bool:
    by_orientation = before.heading is not None and now.heading is not None
    return by_orientation or now.yaw_rate is not None


def _tilt_and_heading(quaternion: Array) -> tuple[Array, float]:
    """Split a rotation into roll and pitch, as a matrix (3, 3), and yaw [rad]."""
    length = math.hypot(*quaternion.tolist())
    if not 0.5 < length < 2.0:
        raise InvalidMessage('imu', f'its quaternion has length {length:.3f}; it must be 1')
    x, y, z, w = (quaternion / length).tolist()
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    # Turned back by its yaw, which is the first of the three rotations.
    c, s = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    turned_back = (c * x + s * y, c * y - s * x, c * z - s * w, c * w + s * z)
    return matrix_from_unit_quaternion(turned_back), yaw


def _time_held(gap: float, dt: float) -> float:
    """How much of a step falls into the time for which a velocity is held [s]."""
    return min(dt, max(0.0, LONGEST_HOLD - gap))
