"""
Whether a robot stands on some of its feet, and how far it tips if it does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_angles
from quad_gait.cycle.stability import stability_margin
from quad_gait.state.stance import Stance

Array = NDArray[np.float64]


def tipping(
    robot: Robot, joints: Array, up: Array, carries: NDArray[np.bool_]
) -> tuple[float, float]:
    """
    Predict whether a robot stands on some of its feet, and how far it tips if not.

    A body whose center of mass is outside its feet turns about the nearest line between two
    of them, joints held, until the first hip meets the ground.

    Parameters
    ----------
    robot : Robot
        The robot.
    joints : ndarray, shape (4, 3)
        [rad]
    up : ndarray, shape (3,)
        The vertical, upward, in the body's axes.
    carries : ndarray of bool, shape (4,)
        Which feet bear.

    Returns
    -------
    margin : float
        Of the center of mass inside those feet; negative outside [m].
    angle : float
        By which the body tips [rad]; 0 if it stands.
    """
    level = level_axes(up)
    feet, center = robot.foot_positions(joints) @ level.T, level @ robot.center_of_mass(joints)
    margin = float(stability_margin(center[:2], feet[:, :2], carries))
    if margin >= 0.0 or np.count_nonzero(carries) < 2:
        return margin, 0.0 if margin >= 0.0 else float('nan')
    standing = np.flatnonzero(carries)
    lines = [(a, b) for k, a in enumerate(standing) for b in standing[k + 1 :]]
    distances = []
    for a, b in lines:
        edge = (feet[b] - feet[a])[:2]
        arm = (center - feet[a])[:2]
        distances.append(abs(edge[0] * arm[1] - edge[1] * arm[0]) / float(np.hypot(*edge)))
    a, b = lines[int(np.argmin(distances))]
    edge = (feet[b] - feet[a])[:2] / np.hypot(*(feet[b] - feet[a])[:2])
    out = np.array([-edge[1], edge[0]])
    out *= np.sign(out @ (center - feet[a])[:2])
    hips = np.array([leg.hip for leg in robot.legs]) @ level.T
    ground = float(feet[[a, b], 2].mean()) - robot.foot_radius
    radius = robot.links['hip'].radius
    heights = hips[:, 2] - radius - ground
    reaches = (hips[:, :2] - feet[a, :2]) @ out
    angles = [np.arctan2(h, r) for h, r in zip(heights, reaches) if r > 0.0]
    return margin, float(min(angles, default=np.pi / 2.0))


def tilt_of_body(now: Stance) -> float:
    """Return the angle between the body's z axis and the vertical [rad]."""
    return float(np.arccos(min(1.0, now.body.rotation[2, 2])))


def level_axes(up: Array) -> Array:
    """Return the rotation from the body's axes to level ones with the body's heading."""
    roll, pitch = np.arctan2(up[1], up[2]), -np.arcsin(np.clip(up[0], -1.0, 1.0))
    return matrix_from_angles(np.array([roll, pitch, 0.0]))
