"""
The body's velocity and tilt, by joints and imu, predicted to when a decision takes effect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_moments import weight_torques
from quad_common.robot.robot import Robot
from quad_common.rotations import angles_from_quaternion, matrix_from_angles
from quad_gait.balance.balance_options import EstimateOptions
from quad_gait.balance.foot_laws import GRAVITY, pendulum_time
from quad_gait.ground.ground_slope import LEVEL, Slope, SlopeEstimator

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BodyReading:
    """What joints and imu say at one instant."""

    time: float
    """Time of the measurement [s]."""
    joints: Array
    """Joint positions, shape (4, 3) [rad]."""
    speeds: Array
    """Joint velocities, shape (4, 3) [rad/s]."""
    efforts: Array | None
    """Torques of the motors, shape (4, 3) [N m]; None where they do not tell."""
    orientation: Array
    """Attitude by the imu, quaternion xyzw, shape (4,)."""
    rates: Array
    """Angular velocity by the imu in the body's axes, shape (3,) [rad/s]."""
    specific_force: Array | None
    """What the accelerometer says, in the body's axes, shape (3,) [m/s^2]; None without one."""
    in_stance: NDArray[np.bool_]
    """Which feet are to stand, shape (4,)."""
    tells_slope: bool = True
    """Whether they tell of the ground: feet that slip and bounce do not."""


@dataclass(frozen=True)
class BodyEstimate:
    """How the body moves, in its level axes: x as its heading, z up."""

    velocity: tuple[float, float]
    """Velocity of base_link along x and y [m/s]."""
    turn: float
    """Turn about the vertical [rad/s]."""
    roll: float
    """Roll [rad]."""
    pitch: float
    """Pitch [rad]."""
    roll_rate: float
    """Angular velocity about the level x axis [rad/s]."""
    pitch_rate: float
    """Angular velocity about the level y axis [rad/s]."""
    slope: Slope = LEVEL
    """The ground under its feet."""
    roughness: float = 0.0
    """Height by which its feet were off that plane lately [m]."""
    contacts: tuple[bool, ...] | None = None
    """Which feet bear load, whatever they are to do; None if the motors do not tell."""
    roughest: float = 0.0
    """Height by which its feet were off the plane of the ground in a longer while [m]."""

    def tilt_in(self, time: float) -> tuple[float, float]:
        """Return roll and pitch so much later [s], turning on as it does [rad]."""
        return self.roll + time * self.roll_rate, self.pitch + time * self.pitch_rate

    @property
    def tilt(self) -> float:
        """Angle by which it is off the attitude that it is to have over the ground [rad]."""
        return math.hypot(self.roll - self.slope.roll, self.pitch - self.slope.pitch)


class BodyEstimator:
    """
    Follows the velocity of a body by its feet and its accelerometer.

    Between two measurements the velocity changes by the accelerometer's, trapezoidally; then it is
    drawn toward what the feet say that bear load. Feet that slip or bounce disagree with what the
    body can have gained meanwhile, and count less. Impacts that are sampled leave the accelerometer
    a bias, which is learned::

        v = v + dt (R f - g - b),   e = v_feet - v,
        v = v + k e / (1 + (|e| / s)^2),   b = b - dt k_b e

    Parameters
    ----------
    robot : Robot
        The robot.
    options : EstimateOptions
        Gains.
    """

    def __init__(self, robot: Robot, options: EstimateOptions) -> None:
        self._robot = robot
        self._options = options
        self._least_load = options.least_load * robot.mass * GRAVITY
        self._touching = options.touching_load * robot.mass * GRAVITY
        height = robot.center_height
        unit = math.sqrt(GRAVITY * height)
        self._slip, self._fastest = options.slip_fraction * unit, options.fastest * unit
        self._slope = SlopeEstimator(
            options.slope_memory * pendulum_time(height), options.slope_fraction
        )
        self._own_weight = weight_torques(robot, robot.initial_joint_angles, np.eye(3)[2])
        self._time = -math.inf
        self._velocity: Array = np.zeros(2)
        self._acceleration: Array = np.zeros(2)
        self._bias: Array = np.zeros(2)
        self.loads: Array | None = None
        """Vertical forces on the feet at the last measurement, shape (4,) [N]; None if unknown."""
        self.feet: Array = np.zeros((4, 3))
        """Centers of the feet beside the level body at the last measurement, shape (4, 3) [m]."""
        self.bears: NDArray[np.bool_] = np.ones(4, dtype=bool)
        """Which feet stood and bore load at the last measurement, shape (4,)."""

    def velocity_at(self, time: float) -> tuple[float, float] | None:
        """
        Return the velocity by the last measurement.

        Parameters
        ----------
        time : float
            Time at which it is asked for [s].

        Returns
        -------
        tuple of float or None
            Along the heading and to the left [m/s]; None if the measurement is too old, or the
            velocity is one that no trot has: an accelerometer that errs has led it away.
        """
        x, y = self._velocity.tolist()
        is_recent = 0.0 <= time - self._time <= self._options.longest_gap
        return (x, y) if is_recent and math.hypot(x, y) <= self._fastest else None

    def update(self, reading: BodyReading) -> BodyEstimate:
        """Take a measurement."""
        roll, pitch, _ = angles_from_quaternion(reading.orientation)
        rotation = matrix_from_angles(np.array([roll, pitch, 0.0]))
        rates = rotation @ reading.rates
        dt = reading.time - self._time
        self._time = reading.time
        jacobians = self._robot.foot_jacobians(reading.joints)
        weights = self._weights(reading, rotation[2], jacobians)
        self.bears = weights > 0.0
        if not 0.0 < dt <= self._options.longest_gap:
            self._velocity[:] = self._acceleration[:] = 0.0
            self._slope.forget()
            dt = 0.0
        turn = float(rates[2]) * dt
        vx, vy = self._velocity.tolist()
        # The axes turn with the body.
        self._velocity = np.array([vx + turn * vy, vy - turn * vx])
        if reading.specific_force is not None:
            acceleration = (rotation @ reading.specific_force)[:2]
            mean = (self._acceleration + acceleration) / 2.0
            self._velocity += dt * (mean - self._bias)
            self._acceleration = acceleration
        feet = self._robot.foot_positions(reading.joints)
        self.feet = feet @ rotation.T
        known = self._slope.slope
        is_upright = math.hypot(roll - known.roll, pitch - known.pitch) < self._options.upright
        standing = self.feet[self.bears & reading.tells_slope]
        self._slope.update(dt, turn, standing, is_upright)
        slope = self._slope.slope
        if weights.any():
            by_legs = leg_velocity(
                self._robot, reading, rotation, weights, slope, (feet, jacobians)
            )
            error = by_legs - self._velocity
            trust = self._options.leg_gain / (1.0 + float(error @ error) / self._slip**2)
            self._velocity = self._velocity + trust * error
            bias = self._bias - dt * self._options.bias_gain * error
            self._bias = np.clip(bias, -self._options.largest_bias, self._options.largest_bias)
        return BodyEstimate(
            (float(self._velocity[0]), float(self._velocity[1])),
            float(rates[2]), roll, pitch, float(rates[0]), float(rates[1]), slope,
            self._slope.roughness, self._contacts(), self._slope.roughest,
        )  # fmt: skip

    def _weights(self, reading: BodyReading, up: Array, jacobians: Array) -> Array:
        """Return how much each foot counts, shape (4,): 0 for one in the air."""
        self.loads = None
        if reading.efforts is None or not reading.efforts.any():
            return reading.in_stance.astype(np.float64)
        loads = self._foot_loads(reading, up, jacobians)
        self.loads = loads
        weights: Array = np.where(reading.in_stance & (loads > self._least_load), 1.0, 0.0)
        return weights

    def _contacts(self) -> tuple[bool, ...] | None:
        """Return which feet bear load; None if unknown."""
        return None if self.loads is None else tuple((self.loads > self._touching).tolist())

    def _foot_loads(self, reading: BodyReading, up: Array, jacobians: Array) -> Array:
        """
        Return the vertical forces on the feet by the motors' torques, shape (4,) [N].

        As :func:`~quad_gait.state.foot_forces.foot_forces` finds them, but with the torques of the
        legs' own weight as the robot stands: that is enough to tell which feet bear.
        """
        assert reading.efforts is not None
        transposed = np.swapaxes(jacobians, -1, -2)
        try:
            forces = np.linalg.solve(transposed, (self._own_weight - reading.efforts)[..., None])
        except np.linalg.LinAlgError:
            # A stretched leg tells nothing.
            return np.zeros(len(reading.efforts))
        loads: Array = forces[..., 0] @ up
        return loads


def leg_velocity(
    robot: Robot,
    reading: BodyReading,
    rotation: Array,
    weights: Array,
    slope: Slope = LEVEL,
    legs: tuple[Array, Array] | None = None,
) -> Array:
    """
    Find the body's velocity by the feet that stand.

    With a foot's center p and its velocity J q' in the body, which turns with w, and the calf
    turning with w_c in the world, a ball of the radius r that rolls on ground with the normal n has
    its center move by r w_c x n; so the body moves by::

        v = r w_c x n - w x p - J q'

    Parameters
    ----------
    robot : Robot
        The robot.
    reading : BodyReading
        Joints and imu.
    rotation : ndarray, shape (3, 3)
        From the body's axes to its level axes.
    weights : ndarray, shape (4,)
        How much each foot counts; not all 0.
    slope : Slope
        The ground.
    legs : tuple of ndarray, optional
        Places of the feet in the body, (4, 3) [m], and their Jacobians, (4, 3, 3), if known.

    Returns
    -------
    ndarray, shape (2,)
        In level axes, the mean of the feet's [m/s].
    """
    joints, speeds, rates = reading.joints, reading.speeds, reading.rates
    feet, jacobians = legs or (robot.foot_positions(joints), robot.foot_jacobians(joints))
    moving = (jacobians @ speeds[..., None])[..., 0]
    calves = robot.calf_angular_velocities(joints, speeds) + rates
    normal = np.array(slope.normal) @ rotation
    velocities = robot.foot_radius * _cross(calves, normal) + _cross(feet, rates) - moving
    level: Array = rotation @ (weights @ velocities / weights.sum())
    return level[:2]


def _cross(a: Array, b: Array) -> Array:
    """Return a x b for rows a, shape (n, 3), faster than numpy.cross."""
    x, y, z = b.tolist()
    product: Array = a @ np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return product
