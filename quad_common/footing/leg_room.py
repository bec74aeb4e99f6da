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
        low, high = np.array(lowest), np.array(highest)
        is_none = low > high
        low[is_none], high[is_none] = math.inf, -math.inf
        return cls(neutral, scale * _SIDE, low, high)


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
    """
    Return the ends of the run of reached heights that is nearest to the middle one.

    Where the initial height is too low for a leg that reaches out, the body may be lower.
    """
    count = is_reached.shape[-1]
    index = np.arange(count)
    away = np.where(is_reached, np.abs(index - count // 2), count)
    nearest = away.argmin(axis=-1)[..., None]
    gaps_below = np.maximum.accumulate(np.where(is_reached, -1, index), axis=-1)
    gaps_above = np.where(is_reached, count, index)
    gaps_above = np.flip(np.minimum.accumulate(np.flip(gaps_above, -1), axis=-1), -1)
    first = np.take_along_axis(gaps_below, nearest, -1) + 1
    last = np.take_along_axis(gaps_above, nearest, -1) - 1
    is_known = is_reached.any(axis=-1)
    low, high = (
        np.take_along_axis(heights, np.clip(k, 0, count - 1), -1)[..., 0] for k in (first, last)
    )
    return np.where(is_known, low, math.inf), np.where(is_known, high, -math.inf)


def _corners(image: Array) -> list[Array]:
    return [image[:-1, :-1], image[1:, :-1], image[:-1, 1:], image[1:, 1:]]
