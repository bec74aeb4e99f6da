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
    shins = []
    for fraction in _STANCE:
        foot = robot.neutral_feet[leg] + fraction * stride_in_body
        try:
            shins.append(robot.legs[leg].chain(robot.legs[leg].inverse(foot))[1] - foot)
        except GaitError:
            continue
    shin = np.array(shins).reshape(-1, 1, 3)
    points = _ON_SHIN[:, None] * shin
    # The foot rolls under its shin.
    points[..., :2] += robot.foot_radius * (_lean(shin) - _lean(shin[:1]))
    points[..., 2] += robot.foot_radius
    turned: Array = points.reshape(-1, 3) @ turn.T
    return turned


def _lean(shin: Array) -> Array:
    """By which angles a shin, shape (..., 3), leans to x and y, shape (..., 2) [rad]."""
    return np.arctan2(shin[..., :2], shin[..., 2:])
