"""
The criterion of a foothold, by which gaits put feet down and planners choose paths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.fit_places import find_fit
from quad_common.footing.shin import shin_points
from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FootholdCriterion:
    """Conditions under which a foot may stand at a place; lengths are TITAN-VIII's."""

    reach: float = 0.08
    """Distance from its place at which a foot may be put for a better hold, at most [m]."""
    radius: float = 0.035
    """Radius around a foot in which the ground is even [m]."""
    largest_step: float = 0.025
    """Difference of the heights around a foot on even ground, at most [m]."""
    shin_clearance: float = 0.01
    """Distance of foot and shin from what is higher than they are [m]."""


def standing_shin(robot: Robot, leg: int, yaw: float) -> Array:
    """
    Place points of foot and shin while the foot stands and the body goes on by half a stride.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        Index of the leg.
    yaw : float
        Heading of the body [rad].

    Returns
    -------
    ndarray, shape (n, 3)
        As :func:`~quad_common.footing.shin.shin_points` [m].
    """
    stride = 0.5 * robot.largest_stride * np.array([math.cos(yaw), math.sin(yaw)])
    return shin_points(robot, leg, stride, yaw)


class FootholdImages:
    """
    Tells where feet may stand: on even ground, off edges, foot and shin free.

    Parameters
    ----------
    robot : Robot
        The robot.
    criterion : FootholdCriterion
        Conditions of a foothold.
    heights : HeightMap
        Of the ground.
    """

    def __init__(self, robot: Robot, criterion: FootholdCriterion, heights: HeightMap) -> None:
        self._robot = robot
        self._criterion = criterion
        self._heights = heights

    @property
    def largest_step(self) -> float:
        """Difference of the heights around a foot of this robot, at most [m]."""
        return self._robot.relative_size * self._criterion.largest_step

    @property
    def room(self) -> float:
        """Distance from a point of foot or shin within which nothing is higher [m]."""
        robot, scale = self._robot, self._robot.relative_size
        clearance = scale * self._criterion.shin_clearance
        return robot.foot_radius + clearance + self._heights.resolution / 2.0

    def shin(self, leg: int, yaw: float) -> Array:
        """Return points of foot and shin while the foot stands: :func:`standing_shin`."""
        return standing_shin(self._robot, leg, yaw)

    def is_fit(self, leg: int, points: Array, yaw: float) -> NDArray[np.bool_]:
        """
        Tell where a foot may stand.

        Parameters
        ----------
        leg : int
            Index of the leg.
        points : ndarray, shape (n, 2)
            Places on the ground [m].
        yaw : float
            Heading of the body [rad].

        Returns
        -------
        ndarray of bool, shape (n,)
            False where nothing is known, and off the map.
        """
        return self.is_fit_beside(self.shin(leg, yaw), points)

    def is_fit_beside(self, shin: Array, points: Array) -> NDArray[np.bool_]:
        """Tell where a foot may stand, as `is_fit`, given the points of its shin (m, 3) [m]."""
        fit = np.empty(len(points), dtype=np.uint8)
        cells = (points - self._heights.origin) / self._heights.resolution
        shin_cells = shin / (self._heights.resolution, self._heights.resolution, 1.0)
        find_fit(cells, self.images, shin_cells, self.largest_step, fit)
        return fit.astype(bool)

    @cached_property
    def images(self) -> Array:
        """
        Images of the ground, shape (4, rows, columns).

        Heights, how rough it is around them, and the highest and lowest ground near a shin [m].
        """
        heights, robot = self._heights, self._robot
        radius = max(robot.relative_size * self._criterion.radius, robot.foot_radius)
        return np.stack(
            [
                heights.heights,
                heights.steps(radius),
                *heights.extremes(self.room),
            ]
        )
