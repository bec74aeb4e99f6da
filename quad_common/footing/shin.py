"""
Where the shin of a standing foot passes, so that nothing is in its way.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

_STANCE = (0.5, 0.0, -0.5, -1.0)
"""Position of a foot beside its place under the body, in strides, until it is lifted."""

_ON_SHIN = np.linspace(0.0, 0.7, 8)
"""Points between foot and knee, higher than which no step is."""

_UP_TO_KNEE = np.linspace(0.0, 1.0, 11)
"""Points on shins that may lie nearly level."""


def shin_points(robot: Robot, leg: int, stride: Array, yaw: float) -> Array:
    """
    Place points of foot and shin while the foot stands.

    The body goes on by one stride until the foot is lifted again; how it sways meanwhile
    does not count.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        Index of the leg.
    stride : ndarray, shape (2,)
        Motion of the body until the foot is lifted again [m].
    yaw : float
        Heading of the body [rad].

    Returns
    -------
    ndarray, shape (n, 3)
        Points, measured from the point of the ground below the foot [m].
    """
    c, s = math.cos(yaw), math.sin(yaw)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    stride_in_body = np.array([*stride, 0.0]) @ turn
    feet = robot.neutral_feet[leg] + np.multiply.outer(np.array(_STANCE), stride_in_body)
    shins = _shins(robot, leg, feet)
    shin = shins[~np.isnan(shins[:, 0])].reshape(-1, 1, 3)
    points = _ON_SHIN[:, None] * shin
    # The foot rolls under its shin.
    points[..., :2] += robot.foot_radius * (_lean(shin) - _lean(shin[:1]))
    points[..., 2] += robot.foot_radius
    turned: Array = points.reshape(-1, 3) @ turn.T
    return turned


def points_on_shins(robot: Robot, feet: Array) -> Array:
    """
    Place points of the shins of legs whose feet are somewhere below the body.

    Parameters
    ----------
    robot : Robot
        The robot.
    feet : ndarray, shape (n, 4, 3)
        Centers of the feet, body frame [m].

    Returns
    -------
    ndarray, shape (n, 4, m, 3)
        From the center of the foot to the knee, body frame [m]; NaN beyond a leg's reach.
    """
    shins = np.stack([_shins(robot, leg, feet[:, leg]) for leg in range(feet.shape[1])], axis=1)
    points: Array = feet[:, :, None] + _UP_TO_KNEE[:, None] * shins[:, :, None]
    return points


def _shins(robot: Robot, leg: int, feet: Array) -> Array:
    """Return the way from foot to knee, shape (n, 3) [m]; NaN beyond the leg's reach."""
    kinematics = robot.legs[leg]
    try:
        shins: Array = kinematics.chain(kinematics.inverse(feet))[1] - feet
    except GaitError:
        if len(feet) == 1:
            return np.full((1, 3), np.nan)
        halves = np.array_split(feet, 2)
        shins = np.concatenate([_shins(robot, leg, half) for half in halves])
    return shins


def _lean(shin: Array) -> Array:
    """By which angles a shin, shape (..., 3), leans to x and y, shape (..., 2) [rad]."""
    return np.arctan2(shin[..., :2], shin[..., 2:])
