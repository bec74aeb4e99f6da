"""
Poses and motions in the plane: SE(2).

Conventions: x forward, y left, yaw counter-clockwise, metres and radians
(REP-103). ``a @ b`` composes: if ``a`` is the pose of B in A and ``b`` the pose of
C in B, ``a @ b`` is the pose of C in A.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_MOST_PAIRS = 100_000
"""Number of pairs of a point and a segment whose distances are worked out at one time."""


def wrap_angle(angle: float) -> float:
    """
    Map an angle to the half-open interval [-pi, pi).

    Parameters
    ----------
    angle : float
        Any angle [rad].

    Returns
    -------
    float
        The same direction, in [-pi, pi) [rad].
    """
    wrapped = (angle + math.pi) % (2.0 * math.pi) - math.pi
    # Just below -pi the remainder rounds to a whole turn.
    return wrapped if wrapped < math.pi else -math.pi


@dataclass(frozen=True)
class Pose2D:
    """Position and heading in the plane."""

    x: float
    """Coordinate x [m]."""
    y: float
    """Coordinate y [m]."""
    yaw: float
    """Heading, counter-clockwise from the x axis [rad]."""

    def __matmul__(self, other: Pose2D) -> Pose2D:
        """Compose two poses, left to right."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return Pose2D(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.yaw + other.yaw),
        )

    def inverse(self) -> Pose2D:
        """Return the pose that undoes this one."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return Pose2D(-c * self.x - s * self.y, s * self.x - c * self.y, -self.yaw)

    def distance_to(self, other: Pose2D) -> float:
        """Return the distance between the two positions [m]."""
        return math.hypot(other.x - self.x, other.y - self.y)

    def heading_to(self, other: Pose2D) -> float:
        """Return the direction from this position to the other one [rad]."""
        return math.atan2(other.y - self.y, other.x - self.x)

    def transform(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """
        Bring points of the body frame into the frame of this pose.

        Parameters
        ----------
        points : ndarray, shape (..., 2) or (..., 3)
            In the body frame [m]; a third coordinate is left as it is.

        Returns
        -------
        ndarray
            The points in the frame in which this pose is given [m].
        """
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        result = np.array(points, dtype=float)
        result[..., 0] = self.x + c * points[..., 0] - s * points[..., 1]
        result[..., 1] = self.y + s * points[..., 0] + c * points[..., 1]
        return result

    def is_finite(self) -> bool:
        """Return whether all three numbers are finite."""
        return math.isfinite(self.x) and math.isfinite(self.y) and math.isfinite(self.yaw)


@dataclass(frozen=True)
class Twist2D:
    """Velocity of a body in the plane, along its own axes."""

    forward: float = 0.0
    """Velocity along the x axis of the body [m/s]."""
    left: float = 0.0
    """Velocity along the y axis of the body [m/s]."""
    turn: float = 0.0
    """Angular velocity, counter-clockwise [rad/s]."""

    def __bool__(self) -> bool:
        """Return whether there is any movement."""
        return bool(self.forward or self.left or self.turn)

    def scaled(self, factor: float) -> Twist2D:
        """Return the same movement at another speed."""
        return Twist2D(factor * self.forward, factor * self.left, factor * self.turn)

    def plus(self, other: Twist2D) -> Twist2D:
        """Return the sum of both velocities."""
        return Twist2D(self.forward + other.forward, self.left + other.left, self.turn + other.turn)

    def minus(self, other: Twist2D) -> Twist2D:
        """Return by how much this velocity differs from another one."""
        return Twist2D(self.forward - other.forward, self.left - other.left, self.turn - other.turn)

    def is_finite(self) -> bool:
        """Return whether all three numbers are finite."""
        return all(math.isfinite(value) for value in (self.forward, self.left, self.turn))


STILL = Twist2D()
"""No movement."""


def distance_aside(poses: Sequence[Pose2D], course: float) -> float:
    """
    Say how far a robot went to one side of its course.

    Parameters
    ----------
    poses : sequence of Pose2D
        Poses of the robot on its way. Its heading in any of them does not count: a body turns to
        and fro within its cycles.
    course : float
        Direction in which it was to go [rad].

    Returns
    -------
    float
        [m]
    """
    x, y = poses[-1].x - poses[0].x, poses[-1].y - poses[0].y
    return abs(y * math.cos(course) - x * math.sin(course))


def distance_to_polyline(point: tuple[float, float], corners: NDArray[np.float64]) -> float:
    """
    Distance from a point to a line of straight segments.

    Parameters
    ----------
    point : tuple of float
        x and y [m].
    corners : ndarray, shape (n, 2), n >= 1
        The corners in order [m].

    Returns
    -------
    float
        Distance [m].
    """
    return float(distances_to_polyline(np.array([point], dtype=float), corners)[0])


def distances_to_polyline(
    points: NDArray[np.float64], corners: NDArray[np.float64]
) -> NDArray[np.float64]:
    """
    Distances from points to a line of straight segments.

    Parameters
    ----------
    points : ndarray, shape (m, 2)
        The points [m].
    corners : ndarray, shape (n, 2), n >= 1
        The corners in order [m].

    Returns
    -------
    ndarray, shape (m,)
        Distances [m].
    """
    # A single corner is a segment without length.
    a, b = (corners[:-1], corners[1:]) if len(corners) > 1 else (corners, corners)
    ab = b - a
    squared = np.maximum(np.einsum('ij,ij->i', ab, ab), 1e-18)
    distances = np.empty(len(points))
    # In parts: long lines and many points would need gigabytes at once.
    count = max(1, _MOST_PAIRS // len(a))
    for first in range(0, len(points), count):
        p = points[first : first + count, None]
        t = np.clip(np.einsum('mij,ij->mi', p - a, ab) / squared, 0.0, 1.0)
        apart = np.linalg.norm(a + t[..., None] * ab - p, axis=2)
        distances[first : first + count] = np.min(apart, axis=1)
    return distances
