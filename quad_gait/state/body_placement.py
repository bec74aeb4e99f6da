"""
Where the body goes over feet that stand anywhere: level, within reach, and balanced.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_angles

Array = NDArray[np.float64]

_LEVEL = np.zeros(2)

_AROUND = (0, 1, 3, 2)
"""Legs in their order around the body, clockwise as seen from above."""

_MOST_PROJECTIONS, _NEGLIGIBLE = 40, 1e-4
"""Number of corrections of a point that is too near to edges, and how far it may be off [m]."""


@dataclass(frozen=True)
class BodyPose:
    """Position and attitude of base_link in a frame with z up."""

    position: Array
    """Shape (3,) [m]."""
    roll: float
    """[rad]"""
    pitch: float
    """Positive with the nose down [rad]."""
    yaw: float
    """[rad]"""

    @cached_property
    def rotation(self) -> Array:
        """Rotation from the body's axes to the frame's, shape (3, 3)."""
        return matrix_from_angles(np.array([self.roll, self.pitch, self.yaw]))

    def transform(self, points: Array) -> Array:
        """Bring points (..., 3) from the body's frame into this one [m]."""
        moved: Array = self.position + points @ self.rotation.T
        return moved

    def lowered(self, depth: float) -> BodyPose:
        """Return the pose that is lower by so much [m]."""
        position = self.position - np.array([0.0, 0.0, depth])
        return BodyPose(position, self.roll, self.pitch, self.yaw)

    def leaning_to(self, place: Pose2D, fraction: float, farthest: float) -> BodyPose:
        """Return the pose that is nearer to a place, by a fraction of at most a distance [m]."""
        offset = np.array([place.x, place.y]) - self.position[:2]
        offset *= min(1.0, farthest / max(float(np.hypot(*offset)), 1e-9))
        position = self.position + np.array([*(fraction * offset), 0.0])
        return BodyPose(position, self.roll, self.pitch, self.yaw)


def heading_over(robot: Robot, feet: Array) -> float:
    """
    Find the heading in which the feet are nearest to their initial posture.

    Parameters
    ----------
    robot : Robot
        The robot.
    feet : ndarray, shape (4, 3)
        Their centers, in a frame with z up [m].

    Returns
    -------
    float
        Of the rotation that fits best, in the sense of least squares [rad].
    """
    arms = feet[:, :2] - feet[:, :2].mean(axis=0)
    rests = robot.neutral_feet[:, :2] - robot.neutral_feet[:, :2].mean(axis=0)
    across = float(np.sum(rests[:, 0] * arms[:, 1] - rests[:, 1] * arms[:, 0]))
    return float(np.arctan2(across, np.sum(rests * arms)))


def body_over(robot: Robot, feet: Array, yaw: float, slope: Array, fraction: float) -> BodyPose:
    """
    Place the body where the feet are nearest to their initial posture, on average.

    Parameters
    ----------
    robot : Robot
        The robot.
    feet : ndarray, shape (4, 3)
        Their centers, in a frame with z up [m].
    yaw : float
        Heading of the body [rad].
    slope : ndarray, shape (2,)
        Rise of the ground along the frame's x and y.
    fraction : float
        How much of the ground's tilt the body takes: 0 stays level, 1 goes along.

    Returns
    -------
    BodyPose
    """
    ahead = np.cos(yaw) * slope[0] + np.sin(yaw) * slope[1]
    aside = np.cos(yaw) * slope[1] - np.sin(yaw) * slope[0]
    roll, pitch = fraction * float(np.arctan(aside)), -fraction * float(np.arctan(ahead))
    rotation = matrix_from_angles(np.array([roll, pitch, yaw]))
    position = (feet - robot.neutral_feet @ rotation.T).mean(axis=0)
    return BodyPose(position, roll, pitch, wrap_angle(yaw))


def strain_over(robot: Robot, feet: Array) -> float:
    """
    Return how far a foot is from its initial posture at most, the body over the feet.

    Parameters
    ----------
    robot : Robot
        The robot.
    feet : ndarray, shape (4, 3)
        Their centers, in a frame with z up [m].

    Returns
    -------
    float
        Horizontal distance, the body level [m].
    """
    body = body_over(robot, feet, heading_over(robot, feet), _LEVEL, 0.0)
    off = (feet - body.transform(robot.neutral_feet))[:, :2]
    return float(np.hypot(*off.T).max())


def balanced(point: Array, triangle: Array, margin: float) -> Array:
    """
    Find the point nearest to another one that is well inside a triangle.

    Parameters
    ----------
    point : ndarray, shape (2,)
        Where the center of mass would be [m].
    triangle : ndarray, shape (3, 2)
        The feet that bear it [m].
    margin : float
        Wanted distance from the edges; where the triangle is too small for it, the point
        is the center of the inscribed circle [m].

    Returns
    -------
    ndarray, shape (2,)
        [m]
    """
    sides = _sides(triangle)
    center = sides @ triangle / sides.sum()
    radius = inner_radius(triangle)
    inner: Array = center + (triangle - center) * max(0.0, 1.0 - margin / max(radius, 1e-9))
    if _is_inside(point, inner):
        return point
    nearest = [_nearest_on(point, inner[k], inner[(k + 1) % 3]) for k in range(3)]
    best: Array = min(nearest, key=lambda other: float(np.hypot(*(other - point))))
    return best


def inner_radius(triangle: Array) -> float:
    """Return how far a point can be inside the edges of a triangle, shape (3, 2), at most [m]."""
    first, second = triangle[1] - triangle[0], triangle[2] - triangle[0]
    doubled = abs(first[0] * second[1] - first[1] * second[0])
    return float(doubled / _sides(triangle).sum())


def _sides(triangle: Array) -> Array:
    """Return the lengths of the sides, each across from its corner, shape (3,) [m]."""
    across = np.roll(triangle, -1, axis=0) - np.roll(triangle, 1, axis=0)
    lengths: Array = np.linalg.norm(across, axis=1)
    return lengths


def balanced_on_four(point: Array, feet: Array, margin: float) -> Array:
    """
    Find a point near another one that is well inside the feet of all four legs.

    Parameters
    ----------
    point : ndarray, shape (2,)
        Where the center of mass would be [m].
    feet : ndarray, shape (4, 2)
        In the order of the legs [m].
    margin : float
        Wanted distance from the edges [m]; less where the feet are too near to one another.

    Returns
    -------
    ndarray, shape (2,)
        The point itself where it is inside; the nearest one where one edge is too near.
    """
    for leg in range(len(feet)):
        others = np.delete(feet, leg, axis=0)
        if _is_inside(feet[leg], others):
            # It adds nothing to the ground between the others.
            return balanced(point, others, margin)
    corners = feet[list(_AROUND)]
    edges = np.roll(corners, -1, axis=0) - corners
    inwards = np.column_stack([edges[:, 1], -edges[:, 0]])
    inwards /= np.maximum(np.linalg.norm(inwards, axis=1, keepdims=True), 1e-9)
    for _ in range(_MOST_PROJECTIONS):
        lacking = margin - np.einsum('ij,ij->i', point - corners, inwards)
        worst = int(np.argmax(lacking))
        if lacking[worst] <= _NEGLIGIBLE:
            break
        point = point + lacking[worst] * inwards[worst]
    return point


def _is_inside(point: Array, triangle: Array) -> bool:
    edges = np.roll(triangle, -1, axis=0) - triangle
    arms = point - triangle
    turns = edges[:, 0] * arms[:, 1] - edges[:, 1] * arms[:, 0]
    return bool(np.all(turns > 0.0) or np.all(turns < 0.0))


def _nearest_on(point: Array, start: Array, end: Array) -> Array:
    edge = end - start
    fraction = float((point - start) @ edge) / max(float(edge @ edge), 1e-18)
    nearest: Array = start + min(max(fraction, 0.0), 1.0) * edge
    return nearest
