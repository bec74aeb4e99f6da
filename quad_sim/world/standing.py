"""
How a robot is put onto the ground: all feet as near to it as a rigid posture allows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.world.terrain import Terrain

Array = NDArray[np.float64]

_ROUNDS = 4
"""The feet move a little as the body is tilted, and the ground under them with it."""

_RINGS = 3
_SPOKES = 12


def standing_on(robot: Robot, terrain: Terrain, pose: Pose2D) -> tuple[Array, Array]:
    """
    Find where a robot in its initial posture stands.

    The body is parallel to the plane that fits the ground under the four feet best, and as low as
    it can be with no foot in the ground. What then is still in the air falls by little.

    Parameters
    ----------
    robot : Robot
        The robot.
    terrain : Terrain
        The ground.
    pose : Pose2D
        Pose of base_link.

    Returns
    -------
    position : ndarray, shape (3,)
        Position of base_link in the world [m].
    rotation : ndarray, shape (3, 3)
        From base_link to the world.
    """
    feet = robot.foot_positions(robot.initial_joint_angles)
    ball = _ball(robot.foot_radius)
    slope: Array = np.zeros(2)
    for _ in range(_ROUNDS):
        rotation = _parallel_to(slope, pose.yaw)
        reach = feet @ rotation.T
        under = reach[:, :2] + (pose.x, pose.y)
        plane = np.column_stack([reach[:, :2], np.ones(4)])
        fitted, *_ = np.linalg.lstsq(plane, terrain.height_at(under), rcond=None)
        slope = np.array(fitted[:2], dtype=float)
    # A ball rests on the ground where something below it first touches it.
    needed = terrain.height_at(under[:, None] + ball[:, :2]) + ball[:, 2]
    height = float(np.max(needed.max(axis=1) - reach[:, 2]))
    return np.array([pose.x, pose.y, height]), rotation


def initial_place(
    robot: Robot, terrain: Terrain | None, pose: Pose2D
) -> tuple[Array, Array | None]:
    """
    Return where an engine puts a robot in its initial posture: position, and rotation if tilted.

    Parameters
    ----------
    robot : Robot
        The robot.
    terrain : Terrain or None
        The ground; None where it is level.
    pose : Pose2D
        Pose of base_link.

    Returns
    -------
    position : ndarray, shape (3,)
        Position of base_link in the world [m].
    rotation : ndarray, shape (3, 3), or None
        From base_link to the world, as :func:`standing_on`; None on level ground, where the body
        has the pose's heading.
    """
    if terrain is None:
        return np.array([pose.x, pose.y, robot.standing_height]), None
    return standing_on(robot, terrain, pose)


def _ball(radius: float) -> Array:
    """Points of a ball's lower half, and how far they are below its center, shape (n, 3) [m]."""
    rings = radius * np.arange(_RINGS + 1) / _RINGS
    angles = np.arange(_SPOKES) * (2.0 * np.pi / _SPOKES)
    r, angle = (values.reshape(-1) for values in np.meshgrid(rings, angles))
    # On the outermost ring rounding may leave less than nothing.
    below = np.sqrt(np.maximum(radius**2 - r**2, 0.0))
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), below])


def _parallel_to(slope: Array, yaw: float) -> Array:
    """Rotation of a body with a heading on ground that rises by a slope along x and along y."""
    normal = np.array([-slope[0], -slope[1], 1.0])
    normal /= np.linalg.norm(normal)
    heading = np.array([np.cos(yaw), np.sin(yaw)])
    forward = np.array([*heading, float(heading @ slope)])
    forward /= np.linalg.norm(forward)
    return np.column_stack([forward, np.cross(normal, forward), normal])
