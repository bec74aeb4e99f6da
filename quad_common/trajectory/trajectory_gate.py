"""
The last gate before the joints: no trajectory passes that leaves the robot's limits.

Between two points p0, p1 with velocities v0, v1, a time h apart, a joint follows a cubic. It
stays between its Bezier points p0, p0 + v0 h/3, p1 - v1 h/3 and p1, and its velocity between
v0, 3 (p1 - p0)/h - v0 - v1 and v1. That is enough for nearly all trajectories, and costs
little; where it is not, the cubic's own extrema are found.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import CommandJumps, CommandOutsideLimits
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory

Array = NDArray[np.float64]

POSITION_TOLERANCE = 1e-6
"""Rounding error of positions that passes [rad]."""

_VELOCITY_ROUNDING = 1e-6
"""Rounding error of velocities that passes [rad/s]."""

OVERSHOOT = 0.005
"""Angle by which a joint may leave its range between two points [rad]; at the points it may not."""

CONTROL_PERIOD = 0.02
"""Time in which a command may get where another trajectory, which already runs, is [s]."""

_TIME_ROUNDING = 1e-9
"""Rounding error of times: a trajectory that starts this much later starts now [s]."""

VELOCITY_TOLERANCE = 0.05
"""Fraction of a joint's largest velocity by which it may be exceeded between two points; at the
points themselves it may not."""

_ROWS = 256
"""Number of points up to which limits are kept once per point: compared with rows that are all
the same instead, numpy goes from row to row, which takes nearly twice as long."""


@dataclass(frozen=True)
class JointLimits:
    """What a robot's joints are able to do."""

    joint_names: tuple[str, ...]
    """Names of the n joints, in the order of all arrays."""
    lower: Array
    """Least positions, shape (n,) [rad]."""
    upper: Array
    """Largest positions, shape (n,) [rad]."""
    velocity: Array
    """Largest velocities, shape (n,) [rad/s]."""

    @classmethod
    def of(cls, robot: Robot) -> JointLimits:
        """Take a robot's limits."""
        shape = robot.lower.shape
        return cls(
            robot.joint_names,
            robot.lower.reshape(-1),
            robot.upper.reshape(-1),
            np.broadcast_to(robot.velocity, shape).reshape(-1).copy(),
        )

    @cached_property
    def _at_points(self) -> _Bounds:
        """What passes at points."""
        return _Bounds.of(
            self.lower - POSITION_TOLERANCE,
            self.upper + POSITION_TOLERANCE,
            self.velocity + _VELOCITY_ROUNDING,
        )

    @cached_property
    def _between(self) -> _Bounds:
        """What passes between two points."""
        return _Bounds.of(
            self.lower - POSITION_TOLERANCE - OVERSHOOT,
            self.upper + POSITION_TOLERANCE + OVERSHOOT,
            (1.0 + VELOCITY_TOLERANCE) * self.velocity,
        )

    def clip(self, positions: Array) -> Array:
        """Return the positions within range that are nearest, shape (n,) [rad]."""
        clipped: Array = np.clip(positions, self.lower, self.upper)
        return clipped

    def clip_velocity(self, velocities: Array) -> Array:
        """Return the velocities within the limits that are nearest, shape (n,) [rad/s]."""
        clipped: Array = np.clip(velocities, -self.velocity, self.velocity)
        return clipped

    def keeps_range(self, times: Array, positions: Array, velocities: Array) -> bool:
        """
        Return whether cubics between some points stay within the joints' range.

        Parameters
        ----------
        times : ndarray, shape (m,)
            Of the points, rising [s].
        positions, velocities : ndarray, shape (m, n)
            At the points [rad], [rad/s]; the points themselves are not judged.

        Returns
        -------
        bool
            Whether no joint leaves its range by more than :data:`OVERSHOOT`.
        """
        h = self._durations(times)
        farthest = _farthest(self._between.rows(len(h)), h, positions, velocities)
        return farthest is None or bool(self._between.rows(len(farthest)).hold(farthest).all())

    def check(self, times: Array, positions: Array, velocities: Array) -> None:
        """
        Raise if cubics through some points leave the limits.

        Parameters
        ----------
        times : ndarray, shape (m,)
            Of the points, rising [s].
        positions, velocities : ndarray, shape (m, n)
            At the points [rad], [rad/s].

        Raises
        ------
        CommandOutsideLimits
            Naming joint, quantity and value of one that is farthest outside.
        """
        at_points = self._at_points.rows(len(times))
        self._compare('position', 'rad', positions, at_points.lower, at_points.upper)
        # NaN compares as outside.
        if not (np.abs(velocities) <= at_points.velocity).all():
            fastest = at_points.velocity
            self._compare('velocity', 'rad/s', velocities, -fastest, fastest)
        if len(times) < 2:
            return
        h = self._durations(times)
        between = self._between.rows(len(h))
        farthest = _farthest(between, h, positions, velocities)
        if farthest is not None:
            overshot = self._between.rows(len(farthest))
            self._compare('position', 'rad', farthest, overshot.lower, overshot.upper)
        v0, v1 = velocities[:-1], velocities[1:]
        middle = 3.0 * _steps(positions) / h - v0 - v1
        fastest = between.velocity
        if (np.abs(middle) > fastest).any():
            extremes = _velocity_extrema(v0, v1, middle)
            self._compare('velocity', 'rad/s', extremes, -fastest, fastest)

    def _durations(self, times: Array) -> Array:
        """Return how long each interval lasts, for each joint, shape (m - 1, n) [s]."""
        return _steps(times).repeat(len(self.lower)).reshape(-1, len(self.lower))

    def _compare(self, what: str, unit: str, values: Array, low: Array, high: Array) -> None:
        # NaN compares as outside.
        inside = (values >= low) & (values <= high)
        if inside.all():
            return
        beyond = np.where(inside, -np.inf, np.maximum(low - values, values - high))
        beyond[np.isnan(beyond)] = 0.0
        row, joint = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
        # All rows of the limits are the same.
        raise CommandOutsideLimits(
            self.joint_names[joint],
            what,
            float(values[row, joint]),
            (float(low[0, joint]), float(high[0, joint])),
            unit,
        )


class _Bounds(NamedTuple):
    """Limits of n joints, once for each of m points, or in one row for all points."""

    lower: Array
    """Least positions, shape (m, n) or (1, n) [rad]."""
    upper: Array
    """Largest positions, of that shape [rad]."""
    velocity: Array
    """Largest velocities, of that shape [rad/s]."""

    @classmethod
    def of(cls, *limits: Array) -> _Bounds:
        """Repeat limits of shape (n,) for many points."""
        return cls(*(np.tile(limit, (_ROWS, 1)) for limit in limits))

    def rows(self, count: int) -> _Bounds:
        """Return those of so many points."""
        rows = slice(count if count <= _ROWS else 1)
        return _Bounds(self.lower[rows], self.upper[rows], self.velocity[rows])

    def hold(self, positions: Array) -> NDArray[np.bool_]:
        """Return which positions are within, shape (m, n)."""
        inside: NDArray[np.bool_] = (positions >= self.lower) & (positions <= self.upper)
        return inside


def check_command(
    limits: JointLimits,
    trajectory: JointTrajectory,
    now: float,
    position: Array,
    velocity: Array,
) -> None:
    """
    Raise unless joints that are commanded elsewhere now are able to follow a trajectory.

    Parameters
    ----------
    limits : JointLimits
        Of the joints.
    trajectory : JointTrajectory
        For all joints, in the limits' order.
    now : float
        When it arrives [s].
    position, velocity : ndarray, shape (n,)
        What the joints are commanded then, by what came before [rad], [rad/s].

    Raises
    ------
    CommandOutsideLimits
        If a position or velocity is outside the limits at any instant, or the first point
        cannot be reached in its time from what is commanded now.
    CommandJumps
        If it runs already, and is elsewhere than what is commanded now.
    """
    limits.check(trajectory.times, trajectory.positions, trajectory.velocities)
    start = (trajectory.stamp if trajectory.stamp > 0.0 else now) + float(trajectory.times[0])
    if start > now + _TIME_ROUNDING:
        limits.check(
            np.array([now, start]),
            np.stack([limits.clip(position), trajectory.positions[0]]),
            np.stack([limits.clip_velocity(velocity), trajectory.velocities[0]]),
        )
        return
    step = trajectory.positions_at(np.array([now]))[0] - position
    too_far = np.abs(step) > limits.velocity * CONTROL_PERIOD
    if too_far.any():
        joint = int(np.argmax(np.abs(step) / limits.velocity))
        raise CommandJumps(limits.joint_names[joint], float(step[joint]), CONTROL_PERIOD)


def joining_time(limits: JointLimits, position: Array, velocity: Array, target: Array) -> float:
    """
    Return how long joints need to come to rest at a target without exceeding their velocity.

    Parameters
    ----------
    limits : JointLimits
        Of the joints.
    position, velocity : ndarray, shape (n,)
        What the joints are commanded now [rad], [rad/s].
    target : ndarray, shape (n,)
        Where they are to rest [rad].

    Returns
    -------
    float
        For a cubic from here to there [s]: its middle velocity 3 (target - position)/T - velocity
        stays within the limit.
    """
    room = np.maximum(limits.velocity - np.abs(velocity), 0.1 * limits.velocity)
    return float(np.max(3.0 * np.abs(target - position) / room))


def velocities_between(times: Array, positions: Array, velocities: Array) -> Array:
    """
    Return the velocities farthest from zero within the intervals of cubics through some points.

    Parameters
    ----------
    times : ndarray, shape (m,)
        Of the points, rising [s].
    positions, velocities : ndarray, shape (m, n)
        At the points [rad], [rad/s].

    Returns
    -------
    ndarray, shape (m - 1, n)
        Velocities at the cubics' vertices, or at an end where the vertex is outside [rad/s].
    """
    v0, v1 = velocities[:-1], velocities[1:]
    mean = _steps(positions) / _steps(times)[:, None]
    return _velocity_extrema(v0, v1, 3.0 * mean - v0 - v1)


def _farthest(between: _Bounds, h: Array, positions: Array, velocities: Array) -> Array | None:
    """Return the extreme positions of cubics; None if all are within range for sure."""
    p0, p1, v0, v1 = positions[:-1], positions[1:], velocities[:-1], velocities[1:]
    third = h / 3.0
    if between.hold(p0 + v0 * third).all() and between.hold(p1 - v1 * third).all():
        return None
    return _position_extrema(h, p0, v0, v1, 3.0 * (p1 - p0) / h - v0 - v1)


def _steps(rows: Array) -> Array:
    """Return the differences from each row to the next: `numpy.diff` takes four times as long."""
    return rows[1:] - rows[:-1]


def _velocity_extrema(v0: Array, v1: Array, middle: Array) -> Array:
    """Return the velocity at its vertex in each interval, or at an end if that is outside."""
    # v(s) = v0 (1-s)^2 + 2 middle s (1-s) + v1 s^2, with its vertex where v'(s) = 0.
    bend = v0 - 2.0 * middle + v1
    s = np.clip((v0 - middle) / np.where(bend == 0.0, 1.0, bend), 0.0, 1.0)
    extreme: Array = v0 * (1.0 - s) ** 2 + 2.0 * middle * s * (1.0 - s) + v1 * s * s
    return extreme


def _position_extrema(h: Array, p0: Array, v0: Array, v1: Array, middle: Array) -> Array:
    """Return the positions where the velocity is zero in each interval, shape (2 (m - 1), n)."""
    # v(s) = a s^2 + 2 b s + v0, and its integral p0 + h (a s^3/3 + b s^2 + v0 s).
    a, b = v0 - 2.0 * middle + v1, middle - v0
    root = np.sqrt(np.maximum(b * b - a * v0, 0.0))
    # The form without cancellation, and without a division by a: q / a and v0 / q.
    q = -(b + np.copysign(root, b))
    extremes = []
    for above, below in ((q, a), (v0, q)):
        s = np.clip(above / np.where(below == 0.0, 1.0, below), 0.0, 1.0)
        extremes.append(p0 + h * s * (v0 + s * (b + s * (a / 3.0))))
    return np.concatenate(extremes)
