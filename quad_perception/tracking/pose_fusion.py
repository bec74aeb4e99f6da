"""
The robot's pose on the map, from a camera's rare pictures and the legs' steady odometry.

Leg odometry measures every step, but drifts; a camera shows where the robot was when it took
the picture, late and with noise. What is estimated is the transform from the odometry's
frame to the map's, map -> odom of REP-105: it changes only by the drift. A Kalman filter
with one state, this transform, seen from the robot:

- between pictures its covariance grows with the distance walked and the angle turned,
- a picture corrects it by the difference between the camera's pose and where odometry had
  the robot at the picture's own time, however late the picture comes.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError, QuadError
from quad_common.planar_pose import Pose2D, wrap_angle

Array = NDArray[np.float64]

_GATE = 16.27
"""Largest squared Mahalanobis distance: one in a thousand is farther (chi-square, 3)."""

_TOLERANCE = 2.0
"""Factor of the covariance within which pictures agree that a robot was carried: noise may be more
than is told."""

_LARGEST_SLIP, _SIGMAS = 0.3, 4.0
"""Part of the distance by odometry, and deviations of a picture, by which a robot that was carried
may have moved otherwise: what moves more differently is another robot."""

_LARGEST_GAP = 0.5
"""Longest time between two odometries between which is interpolated [s]."""


@dataclass(eq=False, repr=False)
class PictureTooOld(QuadError):
    """A camera's pose is from before all that is remembered of the odometry, or after it."""

    stamp: float
    """Time of the picture [s]."""
    known: tuple[float, float] | None
    """Times from and to which odometry is known [s]; None if none is."""

    def sentence(self) -> str:
        """Say from when to when odometry is known."""
        odometry = 'no odometry is known'
        if self.known is not None:
            odometry = f'odometry is known from {self.known[0]:.2f} s to {self.known[1]:.2f} s'
        return f'the camera saw the robot at {self.stamp:.2f} s; {odometry}'


@dataclass(eq=False, repr=False)
class PoseRefused(QuadError):
    """A camera's pose is too far from where the robot must be."""

    distance: float
    """Distance between both [m]."""
    angle: float
    """Angle between both [rad]."""

    def sentence(self) -> str:
        """Say how far the pose is off."""
        return (
            f'the camera saw the robot {self.distance:.2f} m and '
            f'{math.degrees(self.angle):.0f} degrees from where it must be; it was not believed'
        )


@dataclass(frozen=True)
class FusionOptions:
    """
    How much odometry and camera are believed.

    Raises
    ------
    ParameterError
        If a number is not positive and finite.
    """

    slip: float = 0.03
    """Drift of the odometry: standard deviation for a metre walked [m]."""
    turning_slip: float = 0.03
    """Deviation of the heading for a radian turned, and for a metre walked [rad]."""
    memory: float = 5.0
    """Pictures may be so late [s]."""
    patience: int = 5
    """Number of poses in a row not believed that agree with one another, after which the next one
    is: the robot was moved."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ('slip', 'turning_slip', 'memory', 'patience'):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'positive and finite')


@dataclass
class _Rival:
    """Another place where pictures in a row have had the robot."""

    correction: Pose2D
    """The odometry's frame in the map's by them."""
    covariance: Array
    """Covariance of the pose by it, shape (3, 3)."""
    first: Pose2D
    """That by the first of them alone."""
    since: Pose2D
    """Pose by odometry at the first of them."""
    count: int = 1
    """Number of pictures that agree."""

    def is_left_by(self, pose: Pose2D, then: Pose2D, covariance: Array) -> bool:
        """Return whether a pose has not moved with odometry since the first of them."""
        noise = _SIGMAS * math.sqrt(float(covariance[0, 0] + covariance[1, 1]))
        moved = self.since.distance_to(then)
        return pose.distance_to(self.first @ then) > _LARGEST_SLIP * moved + noise


class PoseFusion:
    """
    A filter for one robot.

    Poses that do not fit are not believed. Where a number of them in a row agree with one another
    as odometry has the robot move meanwhile, it was carried, and is there from then on; poses that
    contradict one another, as of a mirrored picture or of another robot that walks, never are.

    Parameters
    ----------
    options : FusionOptions
        Weights of odometry and camera.
    """

    def __init__(self, options: FusionOptions | None = None) -> None:
        self._options = options or FusionOptions()
        self._odometry: deque[tuple[float, Pose2D]] = deque()
        self._correction: Pose2D | None = None
        self._covariance: Array = np.zeros((3, 3))
        self._rival: _Rival | None = None
        self._corrected_at = -math.inf

    @property
    def correction(self) -> Pose2D | None:
        """The odometry's frame in the map's, map -> odom; None before the first picture."""
        return self._correction

    @property
    def pose(self) -> Pose2D | None:
        """Pose of the robot on the map at the last odometry; None before picture and odometry."""
        if self._correction is None or not self._odometry:
            return None
        return self._correction @ self._odometry[-1][1]

    @property
    def covariance(self) -> Array:
        """Covariance of x, y [m] and yaw [rad] of the pose, in the map's axes, shape (3, 3)."""
        return self._covariance.copy()

    def age(self, time: float) -> float:
        """Return how long ago the last picture was taken that was believed [s]."""
        return time - self._corrected_at

    def add_odometry(self, time: float, pose: Pose2D) -> None:
        """
        Take an odometry.

        Parameters
        ----------
        time : float
            Of the pose [s]. A time before the last one starts over.
        pose : Pose2D
            Of the robot in the odometry's frame.
        """
        if self._odometry and time < self._odometry[-1][0]:
            self.reset()
        if self._odometry and self._correction is not None:
            step = self._odometry[-1][1], pose
            self._covariance = self._drifted(self._covariance, self._correction, *step)
            rival = self._rival
            if rival is not None:
                rival.covariance = self._drifted(rival.covariance, rival.correction, *step)
        self._odometry.append((time, pose))
        while self._odometry[0][0] < time - self._options.memory:
            self._odometry.popleft()

    def add_picture(self, time: float, pose: Pose2D, covariance: Array) -> None:
        """
        Take where a camera saw the robot.

        Parameters
        ----------
        time : float
            When the picture was taken [s].
        pose : Pose2D
            Of the robot on the map.
        covariance : ndarray, shape (3, 3)
            Of x, y [m] and yaw [rad], in the map's axes.

        Raises
        ------
        PictureTooOld
            If odometry at that time is not known.
        PoseRefused
            If it is too far from where the robot must be.
        """
        then = self._odometry_at(time)
        if self._correction is None:
            self._begin(time, pose, then, covariance)
            return
        expected = self._correction @ then
        off = _apart(pose, expected)
        if _is_beyond(off, self._covariance + covariance):
            if self._is_carried(pose, then, covariance):
                self._begin(time, pose, then, covariance)
                return
            raise PoseRefused(float(np.hypot(off[0], off[1])), abs(float(off[2])))
        self._correction, self._covariance = _corrected(
            expected, self._covariance, pose, covariance, then
        )
        self._rival = None
        self._corrected_at = time

    def reset(self) -> None:
        """Forget all."""
        self._odometry.clear()
        self._correction = None
        self._covariance = np.zeros((3, 3))
        self._rival = None
        self._corrected_at = -math.inf

    def _is_carried(self, pose: Pose2D, then: Pose2D, covariance: Array) -> bool:
        """Return whether a pose that does not fit goes on with enough others before it."""
        rival = self._rival
        expected = None if rival is None else rival.correction @ then
        if (
            rival is None
            or expected is None
            or _is_beyond(_apart(pose, expected), _TOLERANCE * (rival.covariance + covariance))
            or rival.is_left_by(pose, then, covariance)
        ):
            there = pose @ then.inverse()
            self._rival = _Rival(there, np.array(covariance, dtype=float), there, then)
            return False
        rival.count += 1
        # Odometry may err by more than it is taken to: the next one is compared with all of them.
        rival.correction, rival.covariance = _corrected(
            expected, rival.covariance, pose, covariance, then
        )
        return rival.count > self._options.patience

    def _begin(self, time: float, pose: Pose2D, then: Pose2D, covariance: Array) -> None:
        self._correction = pose @ then.inverse()
        self._covariance = np.array(covariance, dtype=float)
        self._rival = None
        self._corrected_at = time

    def _drifted(self, covariance: Array, correction: Pose2D, old: Pose2D, new: Pose2D) -> Array:
        """Return a covariance that has grown by a random walk, between two odometries."""
        before, after = correction @ old, correction @ new
        distance = before.distance_to(after)
        # An error of the heading leads sideways.
        lead = np.eye(3)
        lead[:2, 2] = before.y - after.y, after.x - before.x
        along = self._options.slip**2 * distance
        turned = abs(wrap_angle(after.yaw - before.yaw))
        around = self._options.turning_slip**2 * (distance + turned)
        drift = np.diag([along, along, around])
        grown: Array = lead @ covariance @ lead.T + drift
        return grown

    def _odometry_at(self, time: float) -> Pose2D:
        """Interpolate the odometry."""
        known = self._odometry
        if not known or not known[0][0] <= time <= known[-1][0] + _LARGEST_GAP:
            raise PictureTooOld(time, (known[0][0], known[-1][0]) if known else None)
        after = known[-1]
        for entry in reversed(known):
            if entry[0] <= time:
                before = entry
                break
            after = entry
        if after[0] <= before[0]:
            return before[1]
        fraction = min(1.0, (time - before[0]) / (after[0] - before[0]))
        a, b = before[1], after[1]
        return Pose2D(
            a.x + fraction * (b.x - a.x),
            a.y + fraction * (b.y - a.y),
            wrap_angle(a.yaw + fraction * wrap_angle(b.yaw - a.yaw)),
        )


def _apart(pose: Pose2D, expected: Pose2D) -> Array:
    """Return by how much a pose is off another one, x, y [m] and yaw [rad]."""
    return np.array([pose.x - expected.x, pose.y - expected.y, wrap_angle(pose.yaw - expected.yaw)])


def _is_beyond(off: Array, covariance: Array) -> bool:
    """Return whether a pose is farther off, (3,), than its covariance explains, (3, 3)."""
    return float(off @ np.linalg.solve(covariance, off)) > _GATE


def _corrected(
    expected: Pose2D, covariance: Array, pose: Pose2D, noise: Array, then: Pose2D
) -> tuple[Pose2D, Array]:
    """
    Correct a pose by a picture's, as a Kalman filter does.

    Parameters
    ----------
    expected : Pose2D
        Pose of the robot without the picture.
    covariance, noise : ndarray, shape (3, 3)
        Covariance of that pose, and of the picture's.
    pose : Pose2D
        Pose by the picture.
    then : Pose2D
        Pose by odometry at that time.

    Returns
    -------
    Pose2D
        The odometry's frame in the map's.
    ndarray, shape (3, 3)
        Covariance of the pose.
    """
    gain = np.linalg.solve((covariance + noise).T, covariance.T).T
    x, y, yaw = (gain @ _apart(pose, expected)).tolist()
    seen = Pose2D(expected.x + x, expected.y + y, wrap_angle(expected.yaw + yaw))
    # Joseph's form: it stays symmetric and positive.
    left = np.eye(3) - gain
    return seen @ then.inverse(), left @ covariance @ left.T + gain @ noise @ gain.T
