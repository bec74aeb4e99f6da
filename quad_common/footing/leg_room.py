"""
Where the feet of a robot may be below its body, as a table for searches.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

_EXTENT, _SIDE = 0.30, 0.02
"""Extent of the table to each side of a foot's initial place, and side of its cells [m, of
TITAN-VIII]."""

_LOWEST, _HIGHEST, _RISE = -0.16, 0.16, 0.008
"""Heights that are tried, from the foot's initial one [m, of TITAN-VIII]."""


@dataclass(frozen=True, eq=False)
class LegRoom:
    """
    Heights that each leg reaches, over a grid around its foot's initial place.

    A cell has what its four corners have in common, so that a place within it is reached if it is
    no lower and no higher: what a leg reaches has no dents so small.
    """

    neutral: Array
    """Feet in the initial posture, body frame, shape (4, 3) [m]."""
    side: float
    """Side of a cell [m]."""
    lowest: Array
    """Lowest reachable height of the foot in the body frame, shape (4, n, n), over x and y from
    the initial place; infinite where there is none [m]."""
    highest: Array
    """Highest such height; minus infinity where there is none [m]."""

    @classmethod
    def of(cls, robot: Robot) -> LegRoom:
        """Make the table of a robot, by its kinematics, joints' limits and own parts."""
        scale, neutral = robot.relative_size, robot.neutral_feet
        count = round(_EXTENT / _SIDE)
        corners = scale * _SIDE * np.arange(-count, count + 1)
        heights = scale * np.arange(_LOWEST, _HIGHEST, _RISE)
        x, y, z = np.meshgrid(corners, corners, heights, indexing='ij')
        grid = np.stack([x, y, z], axis=-1)
        lowest, highest = [], []
        for leg in range(len(robot.legs)):
            feet = neutral[leg] + grid
            is_reached = _reached(robot, leg, feet)
            low, high = _interval(is_reached, feet[..., 2])
            lowest.append(np.maximum.reduce(_corners(low)))
            highest.append(np.minimum.reduce(_corners(high)))
        return cls(neutral, scale * _SIDE, np.array(lowest), np.array(highest))


def _reached(robot: Robot, leg: int, feet: Array) -> NDArray[np.bool_]:
    """Tell which feet (..., 3) in the body frame [m] a leg reaches, its thigh off the body."""
    kinematics = robot.legs[leg]
    is_reached = kinematics.reaches(feet)
    angles = kinematics.inverse(feet[is_reached])
    is_within = np.all((angles >= robot.lower[leg]) & (angles <= robot.upper[leg]), axis=-1)
    is_within[is_within] = robot.own_parts.leg_keeps_clear(leg, angles[is_within])
    is_reached[is_reached] = is_within
    return is_reached


def _interval(is_reached: NDArray[np.bool_], heights: Array) -> tuple[Array, Array]:
    """Return the ends of the run of reached heights around the middle; none if that is not."""
    count = is_reached.shape[-1]
    middle = count // 2
    below = np.flip(np.minimum.accumulate(np.flip(is_reached[..., :middle], -1), axis=-1), -1)
    above = np.minimum.accumulate(is_reached[..., middle:], axis=-1)
    low = np.where(below, heights[..., :middle], math.inf).min(axis=-1, initial=math.inf)
    high = np.where(above, heights[..., middle:], -math.inf).max(axis=-1, initial=-math.inf)
    is_known = np.isfinite(high)
    low = np.where(is_known, np.minimum(low, heights[..., middle]), math.inf)
    return low, high


def _corners(image: Array) -> list[Array]:
    return [image[:-1, :-1], image[1:, :-1], image[:-1, 1:], image[1:, 1:]]
